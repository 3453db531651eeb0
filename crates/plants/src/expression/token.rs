//! From text to tokens.

use super::parse::{ExpressionError, Problem};

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Name(String),
    /// One of `+ - * / ^ ( ) ,`.
    Symbol(char),
    End,
}

/// A token and the bytes of the text it came from.
#[derive(Clone, Debug)]
pub(super) struct Spanned {
    pub token: Token,
    pub start: usize,
    pub end: usize,
}

pub(super) fn tokens(text: &str) -> Result<Vec<Spanned>, ExpressionError> {
    let bytes = text.as_bytes();
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        let token = match bytes[at] {
            b if b.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            b'0'..=b'9' | b'.' => {
                at = number_end(bytes, at);
                let value = text[start..at].parse().map_err(|_| ExpressionError {
                    problem: Problem::Number { found: text[start..at].to_owned() },
                    start,
                    end: at,
                })?;
                Token::Number(value)
            }
            b if b.is_ascii_alphabetic() || b == b'_' => {
                while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_') {
                    at += 1;
                }
                Token::Name(text[start..at].to_owned())
            }
            b @ (b'+' | b'-' | b'*' | b'/' | b'^' | b'(' | b')' | b',') => {
                at += 1;
                Token::Symbol(b as char)
            }
            _ => {
                let found = text[start..].chars().next().unwrap_or(' ');
                let end = start + found.len_utf8();
                return Err(ExpressionError { problem: Problem::Character { found }, start, end });
            }
        };
        out.push(Spanned { token, start, end: at });
    }
    out.push(Spanned { token: Token::End, start: text.len(), end: text.len() });
    Ok(out)
}

/// End of the number that begins at `at`: digits, a point, and an exponent with its sign.
fn number_end(bytes: &[u8], mut at: usize) -> usize {
    let digits = |mut at: usize| {
        while at < bytes.len() && (bytes[at].is_ascii_digit() || bytes[at] == b'.') {
            at += 1;
        }
        at
    };
    at = digits(at);
    if at < bytes.len() && (bytes[at] | 32) == b'e' {
        let mut next = at + 1;
        if next < bytes.len() && (bytes[next] == b'+' || bytes[next] == b'-') {
            next += 1;
        }
        if next < bytes.len() && bytes[next].is_ascii_digit() {
            return digits(next);
        }
    }
    at
}

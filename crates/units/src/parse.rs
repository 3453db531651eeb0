//! The grammar of units.

use crate::{Product, UnitError};

/// Parentheses may be nested this deep.
const DEEPEST: usize = 16;

/// Reads a text from left to right.
pub(crate) struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Reads the whole text.
    pub fn read(text: &'a str) -> Result<Product, UnitError> {
        let mut parser = Self { text, rest: text, depth: 0 };
        let product = parser.product()?;
        if parser.rest.is_empty() {
            Ok(product)
        } else {
            Err(parser.syntax("a unit, '*', '/' or '^'"))
        }
    }

    /// Powers joined by a space, `*`, a middle dot or `/`, up to the end or a `)`.
    fn product(&mut self) -> Result<Product, UnitError> {
        let mut product = self.power()?;
        let mut divided = false;
        loop {
            let spaced = self.skip_spaces();
            let dotted = self.take_one_of("*\u{b7}\u{22c5}.");
            let divides = !dotted && self.take_one_of("/");
            if !dotted && !divides {
                if self.rest.is_empty() || self.rest.starts_with(')') {
                    return Ok(product);
                }
                if divided {
                    return Err(UnitError::Ambiguous { text: self.text.into() });
                }
                if !spaced {
                    return Err(self.syntax("a space, '*', '/' or '^'"));
                }
            }
            divided |= divides;
            self.skip_spaces();
            product = product.times(&self.power()?, if divides { -1.0 } else { 1.0 });
        }
    }

    /// A factor with an exponent.
    fn power(&mut self) -> Result<Product, UnitError> {
        let (factor, is_number) = self.factor()?;
        let exponent = if self.take_one_of("^") {
            self.skip_spaces();
            self.exponent()?
        } else if self.take_one_of("\u{b2}") {
            2.0
        } else if self.take_one_of("\u{b3}") {
            3.0
        } else if !is_number && self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
            // s2, s-1
            self.exponent()?
        } else {
            1.0
        };
        Ok(Product::ONE.times(&factor, exponent))
    }

    /// A name, a number or a product in parentheses; and whether it is a number.
    fn factor(&mut self) -> Result<(Product, bool), UnitError> {
        if self.rest.starts_with('(') {
            return Ok((self.group()?, false));
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit()) {
            let before = self.rest;
            let factor = self.number()?;
            if factor == 0.0 {
                self.rest = before;
                return Err(self.syntax("a positive number"));
            }
            let read = &before[..before.len() - self.rest.len()];
            return Ok((if factor == 1.0 { Product::ONE } else { Product::symbol(read) }, true));
        }
        let is_letter = |c: char| c.is_alphabetic() || "%\u{b0}".contains(c);
        let end = self.rest.find(|c| !is_letter(c)).unwrap_or(self.rest.len());
        let name = &self.rest[..end];
        if name.is_empty() {
            return Err(self.syntax("a unit"));
        }
        self.rest = &self.rest[end..];
        Ok((Product::symbol(name), false))
    }

    fn group(&mut self) -> Result<Product, UnitError> {
        if self.depth == DEEPEST {
            return Err(self.syntax("fewer nested parentheses"));
        }
        self.depth += 1;
        self.rest = &self.rest[1..];
        self.skip_spaces();
        let inside = self.product()?;
        self.depth -= 1;
        if self.take_one_of(")") { Ok(inside) } else { Err(self.syntax("')'")) }
    }

    /// A number without a sign; an `e` belongs to it only if digits follow.
    fn number(&mut self) -> Result<f64, UnitError> {
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut end = digits(self.rest);
        if self.rest[end..].starts_with('.') {
            end += 1 + digits(&self.rest[end + 1..]);
        }
        if let Some(after) = self.rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(after.starts_with(['+', '-']));
            let power = digits(&after[sign..]);
            if power > 0 {
                end += 1 + sign + power;
            }
        }
        match self.rest[..end].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.rest = &self.rest[end..];
                Ok(number)
            }
            _ => Err(self.syntax("a number")),
        }
    }

    /// An exponent: 2, -1, 2.5, (1/2).
    fn exponent(&mut self) -> Result<f64, UnitError> {
        if self.take_one_of("(") {
            let above = self.signed()?;
            let below = if self.take_one_of("/") { self.number()? } else { 1.0 };
            return if self.take_one_of(")") { Ok(above / below) } else { Err(self.syntax("')'")) };
        }
        self.signed()
    }

    fn signed(&mut self) -> Result<f64, UnitError> {
        let sign = if self.take_one_of("-") { -1.0 } else { 1.0 };
        Ok(sign * self.number()?)
    }

    /// Whether there were any.
    fn skip_spaces(&mut self) -> bool {
        let before = self.rest.len();
        self.rest = self.rest.trim_start();
        self.rest.len() < before
    }

    fn take_one_of(&mut self, characters: &str) -> bool {
        match self.rest.chars().next().filter(|&c| characters.contains(c)) {
            Some(c) => {
                self.rest = &self.rest[c.len_utf8()..];
                true
            }
            None => false,
        }
    }

    fn syntax(&self, expected: &'static str) -> UnitError {
        let found = match self.rest.chars().next() {
            Some(c) => format!("'{c}'"),
            None => "the end".into(),
        };
        let read = &self.text[..self.text.len() - self.rest.len()];
        let position = read.chars().count() + 1;
        UnitError::Syntax { text: self.text.into(), position, expected, found }
    }
}

//! From tokens to nodes, by precedence climbing.

use super::graph::{Binary, Graph, NodeId, Unary};
use super::token::{Spanned, Token, tokens};
use thiserror::Error;

/// What is wrong with an expression, and where in its text (byte offsets).
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{problem}")]
pub struct ExpressionError {
    /// What is wrong.
    pub problem: Problem,
    /// First byte of the offending text.
    pub start: usize,
    /// Byte after the offending text.
    pub end: usize,
}

/// What can be wrong with an expression.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Problem {
    /// A character that no expression contains.
    #[error(
        "unexpected character '{found}': expressions hold names, numbers, + - * / ^ ( ) and commas"
    )]
    Character {
        /// The character.
        found: char,
    },
    /// Digits that are no number.
    #[error("'{found}' is not a number")]
    Number {
        /// The digits.
        found: String,
    },
    /// Another token was needed.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What may stand here.
        expected: String,
        /// What stands here.
        found: String,
    },
    /// A name that nothing declares.
    #[error("unknown name '{name}'{}", meant(suggestion.as_deref()))]
    UnknownName {
        /// The name.
        name: String,
        /// The nearest name that is declared.
        suggestion: Option<String>,
    },
    /// The force on something that nothing moves from outside.
    #[error(
        "'force on {channel}' is known of an imposed coordinate alone; {}",
        imposed_ones(imposed)
    )]
    UnknownForce {
        /// What it is said to act on.
        channel: String,
        /// The imposed coordinates.
        imposed: Vec<String>,
    },
    /// A function that does not exist.
    #[error("unknown function '{name}': there are {FUNCTIONS}")]
    UnknownFunction {
        /// The name.
        name: String,
    },
    /// A wrong number of arguments.
    #[error("{name} takes {expected} argument(s), found {found}")]
    Arguments {
        /// The function.
        name: String,
        /// How many it takes.
        expected: usize,
        /// How many are given.
        found: usize,
    },
    /// Parentheses or signs nested beyond reason.
    #[error("the expression is nested more than {limit} levels deep")]
    TooDeep {
        /// The limit.
        limit: usize,
    },
}

/// What to do about a name that nothing declares.
fn meant(suggestion: Option<&str>) -> String {
    match suggestion {
        Some(near) => format!(", did you mean '{near}'?"),
        None => ": declare it, or write what the model has".to_owned(),
    }
}

const FUNCTIONS: &str =
    "sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs sign min max";
const MAX_DEPTH: usize = 200;

/// What stands before the name of an imposed coordinate in the name of the force that moves it.
pub(crate) const FORCE_ON: &str = "force on ";

fn imposed_ones(names: &[String]) -> String {
    match names {
        [] => "here there is none".to_owned(),
        names => format!("there are {}", names.join(", ")),
    }
}

/// Parse `text` into `graph`. `lookup` gives the node of a declared name; `names` lists
/// them for suggestions.
///
/// # Errors
/// [`ExpressionError`] with the place in `text` and what was expected there.
pub fn parse(
    text: &str,
    graph: &mut Graph,
    names: &[String],
    lookup: &dyn Fn(&mut Graph, &str) -> Option<NodeId>,
) -> Result<NodeId, ExpressionError> {
    let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0, graph, names, lookup };
    let node = parser.sum()?;
    match parser.peek().token {
        Token::End => Ok(node),
        _ => Err(parser.expected("an operator or the end")),
    }
}

struct Parser<'a> {
    tokens: Vec<Spanned>,
    at: usize,
    depth: usize,
    graph: &'a mut Graph,
    names: &'a [String],
    lookup: &'a dyn Fn(&mut Graph, &str) -> Option<NodeId>,
}

impl Parser<'_> {
    fn peek(&self) -> &Spanned {
        &self.tokens[self.at]
    }

    fn take_symbol(&mut self, symbol: char) -> bool {
        let here = self.peek().token == Token::Symbol(symbol);
        self.at += usize::from(here);
        here
    }

    fn error(&self, problem: Problem, token: usize) -> ExpressionError {
        let Spanned { start, end, .. } = self.tokens[token];
        ExpressionError { problem, start, end }
    }

    fn expected(&self, expected: &str) -> ExpressionError {
        let found = match &self.peek().token {
            Token::Number(v) => format!("the number {v}"),
            Token::Name(n) => format!("'{n}'"),
            Token::Symbol(c) => format!("'{c}'"),
            Token::End => "the end of the expression".to_owned(),
        };
        self.error(Problem::Expected { expected: expected.to_owned(), found }, self.at)
    }

    /// `term (+|- term)*`
    fn sum(&mut self) -> Result<NodeId, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(Problem::TooDeep { limit: MAX_DEPTH }, self.at));
        }
        let mut left = self.product()?;
        loop {
            let op = match self.peek().token {
                Token::Symbol('+') => Binary::Add,
                Token::Symbol('-') => Binary::Subtract,
                _ => break,
            };
            self.at += 1;
            let right = self.product()?;
            left = self.graph.binary(op, left, right);
        }
        self.depth -= 1;
        Ok(left)
    }

    /// `factor (*|/ factor)*`
    fn product(&mut self) -> Result<NodeId, ExpressionError> {
        let mut left = self.signed()?;
        loop {
            let op = match self.peek().token {
                Token::Symbol('*') => Binary::Multiply,
                Token::Symbol('/') => Binary::Divide,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.signed()?;
            left = self.graph.binary(op, left, right);
        }
    }

    /// A factor with its signs; a sign binds less than `^`: `-x^2` is `-(x^2)`.
    fn signed(&mut self) -> Result<NodeId, ExpressionError> {
        let mut negative = false;
        loop {
            if self.take_symbol('-') {
                negative = !negative;
            } else if !self.take_symbol('+') {
                break;
            }
        }
        let node = self.power()?;
        Ok(if negative { self.graph.unary(Unary::Negate, node) } else { node })
    }

    /// `atom (^ signed)?`, right-associative.
    fn power(&mut self) -> Result<NodeId, ExpressionError> {
        let base = self.atom()?;
        if !self.take_symbol('^') {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(Problem::TooDeep { limit: MAX_DEPTH }, self.at));
        }
        let exponent = self.signed()?;
        self.depth -= 1;
        Ok(self.graph.binary(Binary::Power, base, exponent))
    }

    fn atom(&mut self) -> Result<NodeId, ExpressionError> {
        let here = self.at;
        match self.peek().token.clone() {
            Token::Number(value) => {
                self.at += 1;
                Ok(self.graph.constant(value))
            }
            Token::Name(name) => {
                self.at += 1;
                if self.take_symbol('(') {
                    return self.call(&name, here);
                }
                if name == "pi" {
                    return Ok(self.graph.constant(std::f64::consts::PI));
                }
                if let Some(channel) = self.force_on(&name) {
                    return self.force(&channel);
                }
                (self.lookup)(self.graph, &name).ok_or_else(|| {
                    let suggestion = nearest(&name, self.names);
                    self.error(Problem::UnknownName { name, suggestion }, here)
                })
            }
            Token::Symbol('(') => {
                self.at += 1;
                let inner = self.sum()?;
                if self.take_symbol(')') { Ok(inner) } else { Err(self.expected("')'")) }
            }
            _ => Err(self.expected("a number, a name or '('")),
        }
    }

    /// The channel of `force on CHANNEL`, after its first word; two names never follow one another
    /// otherwise.
    fn force_on(&self, first: &str) -> Option<String> {
        let word = |k: usize| match &self.tokens.get(self.at + k)?.token {
            Token::Name(name) => Some(name.as_str()),
            _ => None,
        };
        let is = first == "force" && word(0) == Some("on");
        word(1).filter(|_| is).map(str::to_owned)
    }

    fn force(&mut self, channel: &str) -> Result<NodeId, ExpressionError> {
        let at = self.at + 1;
        self.at += 2;
        (self.lookup)(self.graph, &format!("{FORCE_ON}{channel}")).ok_or_else(|| {
            let forces = self.names.iter().filter_map(|name| name.strip_prefix(FORCE_ON));
            let (channel, imposed) = (channel.to_owned(), forces.map(str::to_owned).collect());
            self.error(Problem::UnknownForce { channel, imposed }, at)
        })
    }

    fn call(&mut self, name: &str, at: usize) -> Result<NodeId, ExpressionError> {
        let mut arguments = Vec::new();
        if !self.take_symbol(')') {
            loop {
                arguments.push(self.sum()?);
                if self.take_symbol(')') {
                    break;
                }
                if !self.take_symbol(',') {
                    return Err(self.expected("',' or ')'"));
                }
            }
        }
        let found = arguments.len();
        let wrong = |expected| Problem::Arguments { name: name.to_owned(), expected, found };
        if let Some(op) = Unary::of_name(name) {
            let [a] = arguments[..] else { return Err(self.error(wrong(1), at)) };
            return Ok(self.graph.unary(op, a));
        }
        if let Some(op) = Binary::of_name(name) {
            let [a, b] = arguments[..] else { return Err(self.error(wrong(2), at)) };
            return Ok(self.graph.binary(op, a, b));
        }
        Err(self.error(Problem::UnknownFunction { name: name.to_owned() }, at))
    }
}

/// Names that an expression uses, functions apart; none of a text that is no expression.
pub(crate) fn names_in(text: &str) -> Vec<String> {
    let tokens = tokens(text).unwrap_or_default();
    let is_call = |k: usize| tokens.get(k + 1).is_some_and(|t| t.token == Token::Symbol('('));
    let name = |(k, t): (usize, &Spanned)| match &t.token {
        Token::Name(name) if !is_call(k) => Some(name.clone()),
        _ => None,
    };
    tokens.iter().enumerate().filter_map(name).collect()
}

/// Whether expressions know a function of this name.
pub(crate) fn is_function(name: &str) -> bool {
    Unary::of_name(name).is_some() || Binary::of_name(name).is_some()
}

/// The declared name nearest to `name`, if one is near at all: few letters differ, or one is
/// part of the other.
#[must_use]
pub fn nearest(name: &str, names: &[String]) -> Option<String> {
    let limit = name.len().div_ceil(3);
    let candidates = names.iter().map(|n| (distance(name, n), n));
    let near = candidates.filter(|&(d, _)| d <= limit).min_by_key(|&(d, _)| d);
    let part = || names.iter().find(|n| name.len() > 3 && n.contains(name));
    near.map(|(_, n)| n).or_else(part).cloned()
}

/// What is said of a name that is none of those that are declared: the nearest, if one is near.
#[must_use]
pub(crate) fn hint(name: &str, names: &[String]) -> String {
    nearest(name, names).map_or_else(String::new, |near| format!(", did you mean '{near}'?"))
}

/// Levenshtein distance, letter case apart.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

//! A JSON text in which every name and every number knows its place.
//!
//! The one idea: what is read from it is a table of numbers by name. Lists, texts and truth values are passed over as such, so
//! that a reader can say what it found in the place of a number.

use std::ops::Range as Span;
use std::sync::Arc;

use super::{InputError, Problem, Source, limits};

/// A value with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// What it is.
    pub is: Is,
    /// Where it is.
    pub span: Span<usize>,
}

/// What a value is.
#[derive(Debug, Clone, PartialEq)]
pub enum Is {
    /// A table: each name with its place, in the order of the file.
    Table(Vec<(String, Span<usize>, Value)>),
    /// A number; finite.
    Number(f64),
    /// Something else, in words with its article.
    Other(&'static str),
}

/// Reads a JSON text.
///
/// # Errors
/// The first place that is no JSON.
pub fn read(source: &Arc<Source>) -> Result<Value, InputError> {
    let mut reader = Reader { text: source.text(), at: 0, depth: 0 };
    let value = reader.value().and_then(|value| match reader.peek() {
        None => Ok(value),
        Some(_) => Err(reader.wrong("expected the end of the text")),
    });
    value.map_err(|problem| InputError { source: source.clone(), problems: vec![problem] })
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
        self.text[self.at..].chars().next()
    }

    fn wrong(&self, expected: &str) -> Problem {
        let end = self.at + self.text[self.at..].chars().next().map_or(0, char::len_utf8);
        Problem::at(self.at..end, "not valid JSON", expected)
    }

    fn eat(&mut self, wanted: char) -> Result<(), Problem> {
        if self.peek() == Some(wanted) {
            self.at += wanted.len_utf8();
            return Ok(());
        }
        Err(self.wrong(&format!("expected `{wanted}`")))
    }

    fn value(&mut self) -> Result<Value, Problem> {
        let first = self.peek();
        let start = self.at;
        self.depth += 1;
        if self.depth > limits::DEPTH {
            return Err(self.wrong("tables and lists are nested too deep"));
        }
        let is = match first {
            Some('{') => self.table()?,
            Some('[') => self.list()?,
            Some('"') => {
                self.string()?;
                Is::Other("a text")
            }
            Some('-' | '0'..='9') => self.number()?,
            _ => self.word()?,
        };
        self.depth -= 1;
        Ok(Value { is, span: start..self.at })
    }

    fn table(&mut self) -> Result<Is, Problem> {
        self.eat('{')?;
        let mut entries: Vec<(String, Span<usize>, Value)> = Vec::new();
        if self.peek() == Some('}') {
            self.at += 1;
            return Ok(Is::Table(entries));
        }
        loop {
            self.peek();
            let start = self.at;
            let name = self.string()?;
            let span = start..self.at;
            self.eat(':')?;
            entries.push((name, span, self.value()?));
            match self.peek() {
                Some(',') => self.at += 1,
                Some('}') => {
                    self.at += 1;
                    return Ok(Is::Table(entries));
                }
                _ => return Err(self.wrong("expected `,` or `}`")),
            }
        }
    }

    fn list(&mut self) -> Result<Is, Problem> {
        self.eat('[')?;
        if self.peek() == Some(']') {
            self.at += 1;
            return Ok(Is::Other("a list"));
        }
        loop {
            self.value()?;
            match self.peek() {
                Some(',') => self.at += 1,
                Some(']') => {
                    self.at += 1;
                    return Ok(Is::Other("a list"));
                }
                _ => return Err(self.wrong("expected `,` or `]`")),
            }
        }
    }

    fn string(&mut self) -> Result<String, Problem> {
        self.eat('"')?;
        let mut read = String::new();
        let mut rest = self.text[self.at..].chars();
        while let Some(c) = rest.next() {
            self.at = self.text.len() - rest.as_str().len();
            match c {
                '"' => return Ok(read),
                '\\' => {
                    let escaped = rest.next();
                    match escaped {
                        Some(c @ ('"' | '\\' | '/')) => read.push(c),
                        Some('n') => read.push('\n'),
                        Some('t') => read.push('\t'),
                        Some('r') => read.push('\r'),
                        Some('b' | 'f') => {}
                        Some('u') => {
                            let digits: String = rest.by_ref().take(4).collect();
                            let code = u32::from_str_radix(&digits, 16);
                            read.push(code.ok().and_then(char::from_u32).unwrap_or(char::REPLACEMENT_CHARACTER));
                        }
                        _ => return Err(self.wrong("expected an escape of JSON")),
                    }
                    self.at = self.text.len() - rest.as_str().len();
                }
                c if c.is_control() => return Err(self.wrong("a text ends with `\"` on its line")),
                c => read.push(c),
            }
        }
        Err(self.wrong("a text has no end"))
    }

    fn number(&mut self) -> Result<Is, Problem> {
        let start = self.at;
        let rest = &self.text[start..];
        let length = rest.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(rest.len());
        match rest[..length].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.at = start + length;
                Ok(Is::Number(number))
            }
            _ => Err(Problem::at(start..start + length, "not valid JSON", "expected a finite number")),
        }
    }

    fn word(&mut self) -> Result<Is, Problem> {
        for (word, is) in [("true", "a truth value"), ("false", "a truth value"), ("null", "null")] {
            if self.text[self.at..].starts_with(word) {
                self.at += word.len();
                return Ok(Is::Other(is));
            }
        }
        let rest = &self.text[self.at..];
        if let Some(word) = ["NaN", "Infinity", "nan", "inf"].iter().find(|word| rest.starts_with(**word)) {
            let problem = Problem::at(self.at..self.at + word.len(), "not valid JSON", "no finite number");
            return Err(problem.help("leave out what is not known"));
        }
        Err(self.wrong("expected a value"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Value, InputError> {
        read(&Arc::new(Source::new("a.json", text)))
    }

    #[test]
    fn numbers_know_their_place() {
        let text = " {\"a\\u0062\": {\"effort\" : -1.5e1, \"list\": [1, {}, []]}, \"c\": null} ";
        let Is::Table(entries) = of(text).unwrap().is else { panic!() };
        assert_eq!((entries[0].0.as_str(), entries.len()), ("ab", 2));
        let Is::Table(inner) = &entries[0].2.is else { panic!() };
        assert_eq!(inner[0].2.is, Is::Number(-15.0));
        assert_eq!((&text[inner[0].1.clone()], &text[inner[0].2.span.clone()]), ("\"effort\"", "-1.5e1"));
        assert_eq!((&inner[1].2.is, &entries[1].2.is), (&Is::Other("a list"), &Is::Other("null")));
    }

    #[test]
    fn what_is_no_json_is_refused_at_its_place() {
        for (text, at) in [
            ("{\"a\": NaN}", 6),
            ("{\"a\": 1,}", 8),
            ("{\"a\" 1}", 5),
            ("{\"a\": 1e999}", 6),
            ("{} x", 3),
            ("", 0),
            ("{\"a\": \"b", 8),
        ] {
            let error = of(text).unwrap_err();
            assert_eq!(error.problems[0].span.as_ref().unwrap().start, at, "{text}");
        }
        assert!(of(&"[".repeat(100_000)).is_err());
    }
}

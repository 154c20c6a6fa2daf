//! The brackets of well-known text: `KEYWORD["text", 1.5, WORD, KEYWORD[…]]`.

use crate::number::number;

/// Bytes of a text at most; a record of a LAS file has no more.
const MAX_BYTES: usize = 1 << 16;

/// Brackets within each other at most; real texts have about eight.
const MAX_DEPTH: usize = 32;

/// A keyword with what its brackets hold.
#[derive(Debug, Default)]
pub(super) struct Node {
    /// Keyword in capitals.
    pub keyword: String,
    pub values: Vec<Value>,
}

/// A part of what brackets hold.
#[derive(Debug)]
pub(super) enum Value {
    Node(Node),
    /// Text in quotes.
    Text(String),
    Number(f64),
    Word(String),
}

impl Node {
    /// Returns the nodes in it.
    pub fn nodes(&self) -> impl Iterator<Item = &Self> {
        self.values.iter().filter_map(|value| match value {
            Value::Node(node) => Some(node),
            _ => None,
        })
    }

    /// Returns the first node in it with one of these keywords.
    pub fn node(&self, keywords: &[&str]) -> Option<&Self> {
        self.nodes().find(|node| node.is(keywords))
    }

    pub fn is(&self, keywords: &[&str]) -> bool {
        keywords.contains(&self.keyword.as_str())
    }

    /// Returns the first text in it.
    pub fn text(&self) -> Option<&str> {
        self.values.iter().find_map(|value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Returns the first number in it.
    pub fn number(&self) -> Option<f64> {
        self.values.iter().find_map(|value| match value {
            Value::Number(number) => Some(*number),
            _ => None,
        })
    }

    /// Returns the first word in it.
    pub fn word(&self) -> Option<&str> {
        self.values.iter().find_map(|value| match value {
            Value::Word(word) => Some(word.as_str()),
            _ => None,
        })
    }
}

/// Returns the outermost node of a text; `None` if its brackets or quotes don't close, or if they are too many.
pub(super) fn parse(text: &str) -> Option<Node> {
    if text.len() > MAX_BYTES {
        return None;
    }
    match (Parser { rest: text }).value(0)? {
        Value::Node(node) => Some(node),
        _ => None,
    }
}

struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    /// Takes a letter that comes next, behind white space.
    fn take(&mut self, letters: &[char]) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(letters) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn value(&mut self, depth: usize) -> Option<Value> {
        if self.take(&['"']) {
            return self.quoted().map(Value::Text);
        }
        let ends = |letter: char| letter.is_whitespace() || "[](),\"".contains(letter);
        let end = self.rest.find(ends).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return None;
        }
        if self.take(&['[', '(']) {
            return self.node(word.to_ascii_uppercase(), depth + 1).map(Value::Node);
        }
        Some(number(word).map_or_else(|| Value::Word(word.to_owned()), Value::Number))
    }

    /// The rest of a text in quotes; two quotes stand for one.
    fn quoted(&mut self) -> Option<String> {
        let mut text = String::new();
        loop {
            let (part, rest) = self.rest.split_once('"')?;
            text.push_str(part);
            self.rest = rest;
            match rest.strip_prefix('"') {
                Some(rest) => self.rest = rest,
                None => return Some(text),
            }
            text.push('"');
        }
    }

    /// The rest of a node whose bracket is open.
    fn node(&mut self, keyword: String, depth: usize) -> Option<Node> {
        if depth > MAX_DEPTH {
            return None;
        }
        let mut values = Vec::new();
        while !self.take(&[']', ')']) {
            values.push(self.value(depth)?);
            if !self.take(&[',']) && !self.rest.starts_with([']', ')']) {
                return None;
            }
        }
        Some(Node { keyword, values })
    }
}

//! The elements of an XML text with their lines and attribute texts, for messages and strict checks. It builds no tree and resolves nothing.

use std::path::Path;

use crate::load::LoadError;
use crate::load::checked_text::limits::{ATTRIBUTES, ELEMENTS, LINKS, TEXT, XML_DEPTH};
use crate::load::checked_text::printable::hidden_in;

/// One element: its name, place and attributes as written.
#[derive(Debug, Clone)]
pub struct Element {
    pub name: String,
    /// Line of its opening tag, from 1.
    pub line: usize,
    /// 0 for the root element.
    pub depth: usize,
    /// Index of the enclosing element.
    pub parent: Option<usize>,
    attributes: Vec<(String, String)>,
}

impl Element {
    /// Text of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
    }
}

/// All elements in the order of their opening tags; what is not well-formed is refused with its line.
pub fn elements(file: &Path, text: &str) -> Result<Vec<Element>, LoadError> {
    let mut scan = Scan { file, text, at: 0, line: 1, open: Vec::new(), elements: Vec::new(), links: 0 };
    while scan.text[scan.at..].contains('<') {
        scan.next_tag()?;
    }
    if let Some(&last) = scan.open.last() {
        let element = &scan.elements[last];
        return Err(LoadError::line(
            file,
            element.line,
            format!("<{}> is not closed; the file may be cut off", element.name),
        ));
    }
    Ok(scan.elements)
}

struct Scan<'a> {
    file: &'a Path,
    text: &'a str,
    at: usize,
    line: usize,
    open: Vec<usize>,
    elements: Vec<Element>,
    /// Links and joints so far.
    links: usize,
}

impl<'a> Scan<'a> {
    fn refuse(&self, message: impl Into<String>) -> LoadError {
        LoadError::line(self.file, self.line, message)
    }

    /// Moves past the first `end` and returns the text before it.
    fn take_until(&mut self, end: &str, what: &str) -> Result<&'a str, LoadError> {
        let rest = &self.text[self.at..];
        let Some(length) = rest.find(end) else {
            return Err(self.refuse(format!("{what} is not closed by '{end}'; the file may be cut off")));
        };
        let taken = &rest[..length];
        self.line += taken.matches('\n').count();
        self.at += length + end.len();
        Ok(taken)
    }

    fn next_tag(&mut self) -> Result<(), LoadError> {
        self.take_until("<", "text")?;
        let rest = &self.text[self.at..];
        if rest.starts_with("!--") {
            self.take_until("-->", "a comment").map(drop)
        } else if rest.starts_with("![CDATA[") {
            self.take_until("]]>", "CDATA").map(drop)
        } else if rest.starts_with('!') {
            Err(self.refuse("holds a document type or entities (<!…>); a robot description has none, remove it"))
        } else if rest.starts_with('?') {
            self.take_until("?>", "an XML declaration").map(drop)
        } else if rest.starts_with('/') {
            self.close()
        } else {
            self.open_tag()
        }
    }

    fn close(&mut self) -> Result<(), LoadError> {
        self.at += 1;
        let name = self.take_until(">", "a tag")?.trim();
        let open = self.open.pop().map(|index| self.elements[index].name.clone());
        match open {
            Some(open) if open == name => Ok(()),
            Some(open) => Err(self.refuse(format!("</{name}> closes <{open}>; tags close in the order they opened"))),
            None => Err(self.refuse(format!("</{name}> closes nothing"))),
        }
    }

    fn open_tag(&mut self) -> Result<(), LoadError> {
        if self.open.len() >= XML_DEPTH.most {
            let most = XML_DEPTH.most;
            return Err(self.refuse(format!("is nested deeper than {most} levels; no robot description needs that")));
        }
        if let Some(message) = ELEMENTS.exceeded(self.elements.len() + 1) {
            return Err(self.refuse(message));
        }
        if self.open.is_empty() && !self.elements.is_empty() {
            return Err(self.refuse("a second root element; a robot description has one, <robot>"));
        }
        let line = self.line;
        let name = self.word();
        if name.is_empty() {
            return Err(self.refuse("'<' opens no tag; write &lt; for the character"));
        }
        let mut element = Element {
            name: name.to_string(),
            line,
            depth: self.open.len(),
            parent: self.open.last().copied(),
            attributes: Vec::new(),
        };
        loop {
            self.skip_space();
            let rest = &self.text[self.at..];
            if rest.starts_with("/>") {
                self.at += 2;
                break;
            }
            if rest.starts_with('>') {
                self.at += 1;
                self.open.push(self.elements.len());
                break;
            }
            if let Some(message) = ATTRIBUTES.exceeded(element.attributes.len() + 1) {
                return Err(self.refuse(message));
            }
            let (key, value) = self.attribute(&element.name)?;
            if element.attribute(&key).is_some() {
                return Err(self.refuse(format!("attribute {key} of <{}> stands twice", element.name)));
            }
            element.attributes.push((key, value));
        }
        if element.depth == 1 && matches!(element.name.as_str(), "link" | "joint") {
            self.links += 1;
            // as many joints as links
            if let Some(message) = LINKS.exceeded(self.links.div_ceil(2)) {
                return Err(self.refuse(message));
            }
        }
        self.elements.push(element);
        Ok(())
    }

    fn attribute(&mut self, element: &str) -> Result<(String, String), LoadError> {
        let key = self.word().to_string();
        self.skip_space();
        let malformed = |scan: &Self| {
            scan.refuse(format!("<{element}> is malformed or cut off; an attribute is written name=\"value\""))
        };
        if key.is_empty() || !self.text[self.at..].starts_with('=') {
            return Err(malformed(self));
        }
        self.at += 1;
        self.skip_space();
        let quote = match self.text[self.at..].chars().next() {
            Some(quote @ ('"' | '\'')) => quote,
            _ => return Err(malformed(self)),
        };
        self.at += 1;
        let value = self.take_until(&quote.to_string(), &format!("attribute {key} of <{element}>"))?;
        let value = plain(value);
        if value.contains("&#") {
            return Err(self.refuse(format!(
                "attribute {key} of <{element}> holds a character reference (&#…); write the character itself"
            )));
        }
        if let Some(hidden) = hidden_in(&key).or_else(|| hidden_in(&value)) {
            return Err(
                self.refuse(format!("attribute {key} of <{element}> holds the hidden character {hidden}; remove it"))
            );
        }
        match TEXT.exceeded(value.chars().count()) {
            Some(message) => Err(self.refuse(format!("attribute {key} of <{element}>: {message}"))),
            None => Ok((key, value)),
        }
    }

    fn word(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| c.is_whitespace() || matches!(c, '=' | '>' | '/' | '<' | '"' | '\''));
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    fn skip_space(&mut self) {
        let rest = &self.text[self.at..];
        let space = rest.len() - rest.trim_start().len();
        self.line += rest[..space].matches('\n').count();
        self.at += space;
    }
}

/// Attribute text with the five named entities of XML in plain form; its line ends and tabs are blanks, as XML has them.
fn plain(text: &str) -> String {
    let text = text.replace(['\n', '\r', '\t'], " ");
    if !text.contains('&') {
        return text;
    }
    let named = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    named.iter().fold(text, |text, (entity, character)| text.replace(entity, character))
}

//! A line with some of its words replaced; every other byte stays. It decides nothing.

use std::ops::Range;

/// Changes to one line.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    /// Bytes of the line and what stands there instead, in the order of the line.
    replaced: Vec<(Range<usize>, String)>,
    /// Words put in front of the first word of the block.
    before: String,
    /// Words put behind the last one.
    after: String,
}

impl Changes {
    /// Forgets all changes.
    pub fn clear(&mut self) {
        self.replaced.clear();
        self.before.clear();
        self.after.clear();
    }

    /// Puts a text in the place of a word; an empty one removes it.
    pub fn replace(&mut self, bytes: Range<usize>, text: String) {
        self.replaced.push((bytes, text));
    }

    /// Adds a word in front.
    pub fn put_before(&mut self, word: &str) {
        self.before.push_str(word);
        self.before.push(' ');
    }

    /// Adds a word behind.
    pub fn put_after(&mut self, word: &str) {
        self.after.push(' ');
        self.after.push_str(word);
    }

    /// Writes the line: `first` is where words may be put in front, `last` where behind.
    pub fn write(&mut self, line: &[u8], first: usize, last: usize, out: &mut Vec<u8>) {
        self.replaced.sort_by_key(|(bytes, _)| bytes.start);
        let mut at = 0;
        let copy = |to: usize, at: &mut usize, out: &mut Vec<u8>| {
            out.extend_from_slice(&line[*at..to]);
            *at = to;
        };
        copy(first, &mut at, out);
        if !self.before.is_empty() {
            // between a line number and the next word
            if first > 0 && !matches!(line[first - 1], b' ' | b'\t') {
                out.push(b' ');
            }
            out.extend_from_slice(self.before.as_bytes());
            while at < last && matches!(line[at], b' ' | b'\t') {
                at += 1;
            }
        }
        for (bytes, text) in &self.replaced {
            copy(bytes.start.max(at), &mut at, out);
            out.extend_from_slice(text.as_bytes());
            at = bytes.end;
        }
        copy(last.max(at), &mut at, out);
        out.extend_from_slice(self.after.as_bytes());
        copy(line.len(), &mut at, out);
    }
}

/// A number with at most so many decimals and at least one: some controls read `10` as 0.010.
pub fn number(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        while text.ends_with('0') && !text.ends_with(".0") {
            text.pop();
        }
    }
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if is_zero && text.starts_with('-') { text[1..].to_string() } else { text }
}

/// A feed with six digits.
pub fn feed_number(value: f64) -> String {
    let whole = value.abs().log10().floor().clamp(-9.0, 9.0) as i32 + 1;
    number(value, (6 - whole).clamp(1, 12) as usize)
}

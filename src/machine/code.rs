//! Structural codes such as `[wCAYbXZt]`: the order of axes from workpiece over bed to tool. Says nothing of dimensions.

use std::fmt;

/// Order of the axes between workpiece (`w`) and tool (`t`) with the place of the bed (`b`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StructuralCode {
    /// Axis names from the workpiece to the bed.
    pub workpiece_side: Vec<String>,
    /// Axis names from the bed to the tool.
    pub tool_side: Vec<String>,
}

/// Why a structural code was refused; prints the code with a caret under the offending character.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}\n    {code}\n    {caret:>width$}", caret = "^", width = column + 1)]
pub struct CodeError {
    /// The code as written.
    pub code: String,
    /// Character position of the offence, from 0.
    pub column: usize,
    /// What is wrong and what is allowed.
    pub reason: String,
}

/// Axes that a code of letters may have: X Y Z U V W slide, A B C turn.
const AXIS_LETTERS: &str = "XYZABCUVW";
/// Longest axis name, characters.
const MAX_NAME: usize = 64;

/// Why a word cannot name an axis; `None` when it can.
///
/// Names stand in headers (`J1_deg`), error names (`EC0J1`) and codes, so they start with a letter and hold no spaces,
/// commas or brackets.
pub fn refuse_axis_name(name: &str) -> Option<String> {
    let mut characters = name.chars();
    let starts_well = characters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_');
    let goes_on_well = characters.all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | '/'));
    if !starts_well || !goes_on_well || name.len() > MAX_NAME {
        return Some(format!(
            "'{name}' cannot name an axis; a name starts with a letter and holds letters, digits, _ - . / (at most {MAX_NAME})"
        ));
    }
    ["b", "w", "t"]
        .contains(&name)
        .then(|| format!("'{name}' cannot name an axis; b, w and t are bed, workpiece and tool"))
}

impl StructuralCode {
    /// Whether the axis at a place of the code lies between the bed and the workpiece.
    pub fn carries_workpiece(&self, axis: usize) -> bool {
        axis < self.workpiece_side.len()
    }

    /// Reads `[wCAYbXZt]` (brackets may be left out) or the form for longer names, `[w, b, J1, J2, t]`.
    pub fn parse(text: &str) -> Result<StructuralCode, CodeError> {
        let refuse = |column: usize, reason: String| CodeError { code: printable(text), column, reason };
        let (body, first) = unbracketed(text).map_err(|(column, reason)| refuse(column, reason))?;
        let is_list = body.contains(',');
        let words: Vec<(usize, &str)> = if is_list { words_of_list(body) } else { letters(body) };
        let names: Vec<&str> = words.iter().map(|(_, word)| *word).collect();
        let unknown = |name: &&str| !(AXIS_LETTERS.contains(*name) || matches!(*name, "w" | "b" | "t"));
        let outcome = match names.iter().position(unknown).filter(|_| !is_list) {
            Some(index) => Err((
                index,
                format!(
                    "'{}' is no axis; allowed are X Y Z A B C U V W and one b for the bed",
                    printable(names[index])
                ),
            )),
            None => StructuralCode::from_words(&names),
        };
        outcome.map_err(|(index, reason)| {
            let column = words.get(index).map_or(body.chars().count(), |(column, _)| *column);
            refuse(first + column, reason)
        })
    }

    /// Builds a code from its words, `w` and `t` included; a refusal names the index of the offending word.
    pub fn from_words(words: &[&str]) -> Result<StructuralCode, (usize, String)> {
        const EXAMPLES: &str = "as in [wCAYbXZt] or [w, b, J1, J2, t]";
        let last = words.len().saturating_sub(1);
        if words.first() != Some(&"w") {
            return Err((0, format!("a structural code starts with 'w', the workpiece, {EXAMPLES}")));
        }
        if last == 0 || words[last] != "t" {
            return Err((last, format!("a structural code ends with 't', the tool, {EXAMPLES}")));
        }
        let mut sides: [Vec<String>; 2] = [Vec::new(), Vec::new()];
        let mut bed_seen = false;
        for (index, &word) in words.iter().enumerate().take(last).skip(1) {
            match word {
                "b" if bed_seen => return Err((index, "the bed 'b' stands twice; it stands once".into())),
                "b" => bed_seen = true,
                "w" | "t" => return Err((index, format!("'{word}' stands inside the code; it is an end"))),
                _ => {
                    if let Some(reason) = refuse_axis_name(word) {
                        return Err((index, reason));
                    }
                    if sides.iter().flatten().any(|other| other == word) {
                        return Err((index, format!("axis '{word}' stands twice; each axis stands once")));
                    }
                    sides[usize::from(bed_seen)].push(word.to_string());
                }
            }
        }
        if !bed_seen {
            let reason = format!("the bed 'b' is missing; write it between workpiece and tool axes, {EXAMPLES}");
            return Err((last, reason));
        }
        let [workpiece_side, tool_side] = sides;
        if workpiece_side.is_empty() && tool_side.is_empty() {
            return Err((last, format!("no axis stands between workpiece and tool; write at least one, {EXAMPLES}")));
        }
        Ok(StructuralCode { workpiece_side, tool_side })
    }

    /// All axis names, workpiece side first.
    pub fn axis_names(&self) -> impl Iterator<Item = &String> {
        self.workpiece_side.iter().chain(&self.tool_side)
    }
}

impl fmt::Display for StructuralCode {
    /// `[wCAYbXZt]` where every axis is one of the letters, `[w, b, J1, J2, t]` otherwise.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters = self.axis_names().all(|name| name.len() == 1 && AXIS_LETTERS.contains(name.as_str()));
        let separator = if letters { "" } else { ", " };
        let words: Vec<&str> = std::iter::once("w")
            .chain(self.workpiece_side.iter().map(String::as_str))
            .chain(std::iter::once("b"))
            .chain(self.tool_side.iter().map(String::as_str))
            .chain(std::iter::once("t"))
            .collect();
        write!(out, "[{}]", words.join(separator))
    }
}

/// The code without its brackets and the column at which it begins.
fn unbracketed(text: &str) -> Result<(&str, usize), (usize, String)> {
    match (text.strip_prefix('['), text.strip_suffix(']')) {
        (Some(rest), Some(_)) if !rest.is_empty() => Ok((&rest[..rest.len() - 1], 1)),
        (Some(_), _) => Err((text.chars().count(), "the code opens with '[' but does not close with ']'".into())),
        (None, Some(_)) => Err((0, "the code closes with ']' but does not open with '['".into())),
        (None, None) => Ok((text, 0)),
    }
}

/// Letters with their columns.
fn letters(body: &str) -> Vec<(usize, &str)> {
    let places = body.char_indices().map(|(at, letter)| &body[at..at + letter.len_utf8()]);
    places.enumerate().collect()
}

/// Words between commas with the columns at which they begin.
fn words_of_list(body: &str) -> Vec<(usize, &str)> {
    let mut column = 0;
    let words = body.split(',').map(|part| {
        let blanks = part.chars().take_while(|c| c.is_whitespace()).count();
        let word = (column + blanks, part.trim());
        column += part.chars().count() + 1;
        word
    });
    words.collect()
}

/// Text in one line of visible characters, so that the caret stands right.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '·' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, message: &str) {
        assert_eq!(StructuralCode::parse(text).unwrap_err().to_string(), message);
    }

    #[test]
    fn the_caret_stands_under_the_offence() {
        check("[wCAYbXZ", "the code opens with '[' but does not close with ']'\n    [wCAYbXZ\n            ^");
        check(
            "[wCAYbXQt]",
            "'Q' is no axis; allowed are X Y Z A B C U V W and one b for the bed\n    [wCAYbXQt]\n           ^",
        );
        check("[wCAYbXAt]", "axis 'A' stands twice; each axis stands once\n    [wCAYbXAt]\n           ^");
        check(
            "[w, b, J1, J 2, t]",
            "'J 2' cannot name an axis; a name starts with a letter and holds letters, digits, _ - . / (at most 64)\n    [w, b, J1, J 2, t]\n               ^",
        );
        let missing =
            "the bed 'b' is missing; write it between workpiece and tool axes, as in [wCAYbXZt] or [w, b, J1, J2, t]";
        check("[wCAYXZt]", &format!("{missing}\n    [wCAYXZt]\n           ^"));
    }

    #[test]
    fn printed_codes_read_back() {
        for text in ["[wCAbYXZt]", "[wbXYZCAt]", "[w, b, J1, J2, t]", "[w, P, b, t]"] {
            assert_eq!(StructuralCode::parse(text).unwrap().to_string(), text);
        }
        assert_eq!(StructuralCode::parse("wCAbYXZt").unwrap().to_string(), "[wCAbYXZt]");
    }
}

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
    /// Reads a code of letters, `[wCAYbXZt]`; the brackets may be left out.
    pub fn parse(text: &str) -> Result<StructuralCode, CodeError> {
        let refuse = |column: usize, reason: String| CodeError { code: text.to_string(), column, reason };
        let characters: Vec<char> = text.chars().collect();
        let mut body: &[char] = &characters;
        let mut first = 0;
        if body.first() == Some(&'[') {
            if body.last() != Some(&']') {
                let at = body.len();
                return Err(refuse(at, "the code opens with '[' but does not close with ']'".into()));
            }
            body = &body[1..body.len() - 1];
            first = 1;
        }
        if body.first() != Some(&'w') {
            return Err(refuse(first, "a structural code starts with 'w', the workpiece, as in [wCAYbXZt]".into()));
        }
        let last = first + body.len() - 1;
        if body.len() < 2 || body[body.len() - 1] != 't' {
            return Err(refuse(last, "a structural code ends with 't', the tool, as in [wCAYbXZt]".into()));
        }
        let mut names: [Vec<String>; 2] = [Vec::new(), Vec::new()];
        let mut bed_seen = false;
        for (offset, &letter) in body[1..body.len() - 1].iter().enumerate() {
            let column = first + 1 + offset;
            match letter {
                'b' if bed_seen => return Err(refuse(column, "the bed 'b' stands twice; it stands once".into())),
                'b' => bed_seen = true,
                letter if AXIS_LETTERS.contains(letter) => {
                    let name = letter.to_string();
                    if names.iter().flatten().any(|other| *other == name) {
                        return Err(refuse(column, format!("axis '{letter}' stands twice; each axis stands once")));
                    }
                    names[usize::from(bed_seen)].push(name);
                }
                other => {
                    return Err(refuse(
                        column,
                        format!("'{other}' is no axis; allowed are X Y Z A B C U V W and one b for the bed"),
                    ));
                }
            }
        }
        if !bed_seen {
            return Err(refuse(
                last,
                "the bed 'b' is missing; write it between workpiece and tool axes, as in [wCAYbXZt]".into(),
            ));
        }
        let [workpiece_side, tool_side] = names;
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

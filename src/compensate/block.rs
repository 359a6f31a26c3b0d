//! One line of a program split into words, each with its bytes. It knows no meaning of words.

use std::ops::Range;

/// Longest line that is read, bytes: controls take some hundred.
pub const LONGEST_LINE: usize = 16_384;

/// A letter and its number.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// Capital letter.
    pub letter: u8,
    pub value: f64,
    /// Bytes of letter and number in the line.
    pub bytes: Range<usize>,
}

impl Word {
    /// The number as a code in tenths: 434 for G43.4.
    pub fn code(&self) -> Option<u16> {
        let tenths = self.value * 10.0;
        let is_code = (0.0..10_000.0).contains(&tenths) && (tenths - tenths.round()).abs() < 1e-6;
        is_code.then_some(tenths.round() as u16)
    }
}

/// A line without its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Block {
    pub words: Vec<Word>,
    /// First byte after a leading N word and blanks.
    pub after_number: usize,
    /// The line may be left out by a switch of the control (leading `/`).
    pub is_optional: bool,
}

/// Splits a line; the words of an earlier line are overwritten. An error says what was found.
pub fn split(line: &[u8], block: &mut Block) -> Result<(), String> {
    block.words.clear();
    block.after_number = 0;
    block.is_optional = false;
    if line.len() > LONGEST_LINE {
        return Err(format!("has {} bytes; at most {LONGEST_LINE} are allowed on a line", line.len()));
    }
    let mut at = 0;
    while at < line.len() {
        match line[at] {
            b' ' | b'\t' | b'\r' => at += 1,
            b'%' if block.words.is_empty() => return Ok(()),
            b';' => return Ok(()),
            b'(' => at = after_comment(line, at)?,
            b'/' if block.words.is_empty() && !block.is_optional => {
                block.is_optional = true;
                at += 1;
            }
            letter if letter.is_ascii_alphabetic() => {
                let word = word(line, at)?;
                at = word.bytes.end;
                let is_number = word.letter == b'N' && block.words.is_empty();
                block.words.push(word);
                if is_number {
                    block.after_number = at;
                }
            }
            b'#' | b'[' | b']' | b'=' | b'<' | b'$' | b'@' | b'"' => {
                return Err("has a variable, expression or macro, whose value is not known here; let the CAM system or the control write it out".into());
            }
            other => return Err(format!("has the character {}, which stands in no word", shown(other))),
        }
    }
    Ok(())
}

/// First byte after a comment in brackets.
fn after_comment(line: &[u8], from: usize) -> Result<usize, String> {
    match line[from..].iter().position(|&byte| byte == b')') {
        Some(length) => Ok(from + length + 1),
        None => Err("has a comment without its closing bracket; close it".into()),
    }
}

/// Letter and number from a place on.
fn word(line: &[u8], from: usize) -> Result<Word, String> {
    let letter = line[from].to_ascii_uppercase();
    let mut at = from + 1;
    while at < line.len() && matches!(line[at], b' ' | b'\t') {
        at += 1;
    }
    let begin = at;
    let is_part =
        |at: usize, byte: u8| byte.is_ascii_digit() || byte == b'.' || (at == begin && matches!(byte, b'+' | b'-'));
    while at < line.len() && is_part(at, line[at]) {
        at += 1;
    }
    if at < line.len() && matches!(line[at], b'#' | b'[' | b'=') || at == begin {
        let rest = line.get(begin).copied();
        // a letter right behind is a macro's word, unless it has a number of its own: another word
        let next_is_word = line.get(begin + 1).is_some_and(|byte| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-'));
        let is_name = begin == from + 1 && !next_is_word && rest.is_some_and(|byte| byte.is_ascii_alphabetic());
        let is_macro = is_name || rest.is_some_and(|byte| matches!(byte, b'#' | b'[' | b'=' | b'<'));
        return Err(match is_macro {
            true => "has a variable, expression or macro, whose value is not known here; let the CAM system or the control write it out".into(),
            false => format!("has {} without a number; write both or neither", letter as char),
        });
    }
    let text = std::str::from_utf8(&line[begin..at]).unwrap_or_default();
    let value = text.parse::<f64>().ok().filter(|value| value.abs() < 1e9);
    match value {
        Some(value) => Ok(Word { letter, value, bytes: from..at }),
        None => Err(format!("has {}{text}, which is no number", letter as char)),
    }
}

fn shown(byte: u8) -> String {
    match byte.is_ascii_graphic() {
        true => format!("'{}'", byte as char),
        false => format!("with the code {byte}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_with_their_bytes() {
        let mut block = Block::default();
        let line = b"N10 g1X-1.5 (a Y2) Z +3. F500 ; X9";
        split(line, &mut block).unwrap();
        let found: Vec<(u8, f64, &[u8])> =
            block.words.iter().map(|word| (word.letter, word.value, &line[word.bytes.clone()])).collect();
        let expected: Vec<(u8, f64, &[u8])> = vec![
            (b'N', 10.0, b"N10"),
            (b'G', 1.0, b"g1"),
            (b'X', -1.5, b"X-1.5"),
            (b'Z', 3.0, b"Z +3."),
            (b'F', 500.0, b"F500"),
        ];
        assert_eq!(found, expected);
        for wrong in [&b"X#1"[..], b"G1 X[1+2]", b"#1=3", b"o100 sub", b"X1.2.3", b"(open", b"X", b"\x00", b"IF X"] {
            assert!(split(wrong, &mut block).is_err(), "{}", String::from_utf8_lossy(wrong));
        }
    }
}

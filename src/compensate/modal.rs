//! Modes of a program: what a control keeps from block to block. Unknown until said.

use super::block::{Block, Word};
use super::codes::{Meaning, Motion, g_code, refused_m_code};
use crate::units::MM_PER_INCH;

/// Axis letters in the order of all arrays here.
pub const LETTERS: [u8; 9] = *b"XYZABCUVW";

/// Whether axis words stand in a block.
pub fn has_place(block: &Block) -> bool {
    block.words.iter().any(|word| LETTERS.contains(&word.letter))
}

/// Meaning of F.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedMode {
    InverseTime,
    PerMinute,
    PerRevolution,
}

impl FeedMode {
    /// The word that switches it on.
    pub fn word(self) -> &'static str {
        match self {
            FeedMode::InverseTime => "G93",
            FeedMode::PerMinute => "G94",
            FeedMode::PerRevolution => "G95",
        }
    }
}

/// State of the tool's length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolLength {
    /// Length in force, mm.
    On(f64),
    /// Not in force.
    Off,
}

/// Offsets G54 … G59.3, mm and deg by letter; `None`: not stated.
pub type OffsetTable = [Option<[f64; 9]>; 9];

/// Modes, `None` where nothing was said yet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Modal {
    pub motion: Option<Motion>,
    pub plane: Option<[usize; 2]>,
    /// mm per unit of length.
    pub unit_mm: Option<f64>,
    pub is_absolute: Option<bool>,
    /// Centres of arcs are absolute; relative unless said.
    pub absolute_centres: bool,
    pub feed_mode: Option<FeedMode>,
    /// F as last said, in its mode and unit.
    pub feed: Option<f64>,
    pub system: Option<usize>,
    pub tool: Option<ToolLength>,
    /// Tool centre point control is on.
    pub centre_point: bool,
    /// Number of the tool in the spindle, and of the one called.
    pub in_spindle: Option<u32>,
    pub called: Option<u32>,
}

/// Modes that a move needs beside units, G90 or G91 and the tool's length.
#[derive(Debug, Clone, Copy)]
pub struct Needs {
    pub plane: bool,
    pub feed_mode: bool,
    pub system: bool,
}

/// What a block asks for beside its modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Once {
    Nothing,
    MachineCoordinates,
    SetOffsets,
    Reference,
    Dwell,
    ToolLengthGiven,
}

/// Lengths of tools by number, mm.
pub type Tools = [(u32, f64)];

/// Refuses a block of which a control may read one half or the other, or nothing at all.
fn refuse_contradictions(block: &Block) -> Result<(), String> {
    let mut groups = [None; 9];
    for (k, word) in block.words.iter().enumerate() {
        let letter = word.letter as char;
        if letter == 'E' {
            return Err("has the letter E, which is not known here; numbers have no exponents".into());
        }
        if word.letter == b'M' {
            continue;
        }
        if word.letter != b'G' {
            if block.words[..k].iter().any(|other| other.letter == word.letter) {
                return Err(format!("has {letter} twice; keep one"));
            }
            continue;
        }
        let Some(group) = word.code().and_then(g_code).and_then(|meaning| meaning.group()) else { continue };
        if let Some(other) = groups[usize::from(group)].replace(word.value).filter(|other| *other != word.value) {
            return Err(format!("has G{other} and G{}, which exclude each other", word.value));
        }
    }
    let has = |letters: &[u8]| block.words.iter().any(|word| letters.contains(&word.letter));
    let is_dwell = |word: &Word| word.letter == b'G' && word.code().and_then(g_code) == Some(Meaning::Dwell);
    // some controls take the seconds as X, others as P
    if block.words.iter().any(is_dwell) && (has(b"YZABC") || has(b"X") && has(b"PF")) {
        return Err("has a dwell and axis words, which controls read in different ways; write two blocks".into());
    }
    Ok(())
}

impl Modal {
    /// Takes over the modes of a block; says what else it asks for.
    pub fn take(&mut self, block: &Block, tools: &Tools) -> Result<Once, String> {
        refuse_contradictions(block)?;
        let mut once = Once::Nothing;
        let number = |letter: u8| block.words.iter().find(|word| word.letter == letter).map(|word| word.value);
        for word in &block.words {
            match word.letter {
                b'G' => {
                    let meaning = word
                        .code()
                        .and_then(g_code)
                        .ok_or_else(|| format!("has G{}, which is not known here", word.value))?;
                    self.take_code(meaning, word, block, tools, &mut once)?;
                }
                b'M' => {
                    let code = word.code().ok_or_else(|| format!("has M{}, which is no code", word.value))?;
                    if let Some(why) = refused_m_code(code) {
                        return Err(format!("has M{}, which {why}", word.value));
                    }
                    if code == 60 {
                        self.in_spindle = number(b'T').map(|tool| tool as u32).or(self.called);
                    }
                }
                b'T' => self.called = Some(word.value as u32),
                _ => {}
            }
        }
        if let Some(feed) = number(b'F').filter(|_| once != Once::Dwell) {
            if feed <= 0.0 {
                return Err(format!("has F{feed}; a feed is above zero"));
            }
            self.feed = Some(feed);
        } else if self.feed_mode == Some(FeedMode::InverseTime) {
            // a time holds for its own block
            self.feed = None;
        }
        if once == Once::ToolLengthGiven {
            let z = number(b'Z').ok_or("has G43.1 without the tool's length as Z")?;
            if let Some(word) = block.words.iter().find(|word| word.letter != b'Z' && LETTERS.contains(&word.letter)) {
                let letter = word.letter as char;
                return Err(format!(
                    "has G43.1 with {letter}{}, an offset of the tool across its axis, which is not followed here; give Z alone",
                    word.value
                ));
            }
            self.tool = Some(ToolLength::On(z * self.unit()?));
        }
        Ok(once)
    }

    fn take_code(
        &mut self,
        meaning: Meaning,
        word: &Word,
        block: &Block,
        tools: &Tools,
        once: &mut Once,
    ) -> Result<(), String> {
        match meaning {
            Meaning::Motion(motion) => self.motion = Some(motion),
            Meaning::Plane(plane) => self.plane = Some(plane),
            Meaning::Inches => self.unit_mm = Some(MM_PER_INCH),
            Meaning::Millimetres => self.unit_mm = Some(1.0),
            Meaning::Absolute => self.is_absolute = Some(true),
            Meaning::Incremental => self.is_absolute = Some(false),
            Meaning::AbsoluteCentres => self.absolute_centres = true,
            Meaning::IncrementalCentres => self.absolute_centres = false,
            Meaning::InverseTime => self.change_feed_mode(FeedMode::InverseTime),
            Meaning::PerMinute => self.change_feed_mode(FeedMode::PerMinute),
            Meaning::PerRevolution => self.change_feed_mode(FeedMode::PerRevolution),
            Meaning::WorkOffset(system) => self.system = Some(system),
            Meaning::ToolLength | Meaning::ToolCentrePoint => {
                let length_number = block.words.iter().find(|word| word.letter == b'H').map(|word| word.value);
                let tool = length_number.map(|number| number as u32).or(self.in_spindle);
                let tool = tool.ok_or("has a tool length without H, and which tool is in the spindle was not said")?;
                let length = tools.iter().find(|(number, _)| *number == tool).map(|(_, length)| *length);
                let length = length.ok_or_else(|| {
                    format!("has the length of tool {tool}, which was not stated; say for example --tool {tool}=120.5")
                })?;
                self.tool = Some(ToolLength::On(length));
                self.centre_point = meaning == Meaning::ToolCentrePoint;
            }
            Meaning::ToolLengthGiven => *once = Once::ToolLengthGiven,
            Meaning::NoToolLength => {
                self.tool = Some(ToolLength::Off);
                self.centre_point = false;
            }
            Meaning::MachineCoordinates => *once = Once::MachineCoordinates,
            Meaning::SetOffsets => *once = Once::SetOffsets,
            Meaning::Reference => *once = Once::Reference,
            Meaning::Dwell => *once = Once::Dwell,
            Meaning::Other => {}
            Meaning::RefusedWithPlace(_) if !has_place(block) => {}
            Meaning::Refused(why) | Meaning::RefusedWithPlace(why) => {
                // until another motion is said, further places belong to it
                self.motion = Some(Motion::Cycle);
                return Err(format!("has G{}, which {why}", word.value));
            }
        }
        Ok(())
    }

    fn change_feed_mode(&mut self, mode: FeedMode) {
        if self.feed_mode != Some(mode) {
            self.feed = None;
        }
        self.feed_mode = Some(mode);
    }

    /// mm per unit of length.
    pub fn unit(&self) -> Result<f64, String> {
        self.unit_mm.ok_or_else(|| {
            "has lengths before G20 or G21 was said; add --initial \"G21\" if the control stands so".into()
        })
    }

    /// Modes that a move needs and that were not said, as words for a message.
    pub fn missing(&self, needs: Needs) -> Vec<&'static str> {
        let mut missing = Vec::new();
        let mut ask = |is_missing: bool, words: &'static str| {
            if is_missing {
                missing.push(words);
            }
        };
        ask(self.unit_mm.is_none(), "G20 or G21");
        ask(self.is_absolute.is_none(), "G90 or G91");
        ask(needs.system && self.system.is_none(), "G54 to G59.3");
        ask(self.tool.is_none(), "G43 or G49");
        ask(needs.plane && self.plane.is_none(), "G17, G18 or G19");
        ask(needs.feed_mode && self.feed_mode.is_none(), "G93, G94 or G95");
        missing
    }
}

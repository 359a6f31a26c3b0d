//! Places that words name: offsets, machine coordinates, the end of a block.

use super::block::Block;
use super::command::Coordinates;
use super::modal::{LETTERS, ToolLength};
use super::path::Place;
use super::settings::OFFSET_NAMES;
use super::state::Compensator;

impl Compensator<'_> {
    /// `G10 L2 P1 X… Y…`.
    pub(super) fn set_offsets(&mut self, block: &Block) -> Result<(), String> {
        let value = |letter: u8| block.words.iter().find(|word| word.letter == letter).map(|word| word.value);
        if value(b'L') != Some(2.0) {
            return Err(
                "has G10 without L2: what it sets is not followed here; state offsets and tools as options".into()
            );
        }
        if value(b'R').is_some_and(|angle| angle != 0.0) {
            return Err("turns the coordinates of a work offset; program the plain ones".into());
        }
        if self.modal.is_absolute != Some(true) {
            return Err(
                "sets a work offset where G90 is not in force, which controls read in different ways; say G90 before"
                    .into(),
            );
        }
        let number =
            value(b'P').filter(|p| (0.0..=9.0).contains(p) && p.fract() == 0.0).ok_or("has G10 L2 without P0 to P9")?;
        let system = match number as usize {
            0 => self.modal.system.ok_or("has G10 L2 P0 before G54 to G59.3 was said")?,
            number => number - 1,
        };
        let unit = self.modal.unit()?;
        let mut offsets = self.offsets[system].unwrap_or_default();
        for word in &block.words {
            if let Some(letter) = LETTERS.iter().position(|letter| *letter == word.letter) {
                offsets[letter] = word.value * if (3..6).contains(&letter) { 1.0 } else { unit };
            }
        }
        self.offsets[system] = Some(offsets);
        Ok(())
    }

    /// Axes that go to a place which only the control knows.
    pub(super) fn forget(&mut self, block: &Block) {
        let named = |letter: usize| block.words.iter().any(|word| word.letter == LETTERS[letter]);
        let all = (0..9).all(|letter| !named(letter));
        for letter in 0..9 {
            if all || named(letter) {
                self.lose_place(letter);
            }
        }
    }

    /// Where an axis stands is not known any more, nor which way it came.
    pub(super) fn lose_place(&mut self, letter: usize) {
        (self.here[letter], self.sent[letter]) = (None, None);
        if let Some(axis) = self.control.axis_of[letter] {
            self.corrector.memories.forget(axis);
        }
    }

    /// Tells the axes that lose motion where they were sent to.
    pub(super) fn follow_memories(&mut self) {
        if self.corrector.memories.is_empty() {
            return;
        }
        let is_known = |letter: usize| self.control.axis_of[letter].is_none() || self.sent[letter].is_some();
        let all_known = (0..9).all(is_known);
        let known: [bool; 9] = std::array::from_fn(|letter| {
            let is_own = self.control.coordinates == Coordinates::Axes || letter > 2;
            if is_own { is_known(letter) } else { all_known }
        });
        let sent: Place = std::array::from_fn(|k| self.sent[k].unwrap_or(0.0));
        let positions = self.control.positions(&sent, &[0.0; 9]);
        for (letter, _) in known.iter().enumerate().filter(|(_, known)| **known) {
            if let Some(axis) = self.control.axis_of[letter] {
                self.corrector.memories.went(axis, positions[axis]);
            }
        }
    }

    /// `G53`: stays as it is.
    pub(super) fn goes_to_machine_coordinates(&mut self, block: &Block) -> Result<(), String> {
        if self.modal.is_absolute == Some(false) {
            return Err("has G53 in G91, which controls read in different ways; say G90 before it".into());
        }
        let unit = self.modal.unit()?;
        for word in &block.words {
            let Some(letter) = self.letter(word.letter)? else { continue };
            let value = word.value * if (3..6).contains(&letter) { 1.0 } else { unit };
            // with tool centre point control machine coordinates of slides are no tip
            let known = (self.control.coordinates == Coordinates::Axes || letter > 2).then_some(value);
            (self.here[letter], self.sent[letter]) = (known, known);
        }
        self.follow_memories();
        self.summary.left += 1;
        Ok(())
    }

    /// Place of an axis letter in the arrays; refused for axes that the machine has not.
    pub(super) fn letter(&self, letter: u8) -> Result<Option<usize>, String> {
        let Some(place) = LETTERS.iter().position(|other| *other == letter) else { return Ok(None) };
        match self.control.axis_of[place] {
            Some(_) => Ok(Some(place)),
            None => Err(format!(
                "has {}, and the machine has no such axis (its axes are {}): is it a program of another machine?",
                letter as char,
                self.control.nominal.machine().axis_names().join(" ")
            )),
        }
    }

    /// What stands between a word and the coordinate with all offsets, mm or deg.
    pub(super) fn offset(&self, letter: usize) -> Result<f64, String> {
        if self.in_machine {
            return Ok(0.0);
        }
        let system = self.modal.system.unwrap_or(0);
        let offsets = self.offsets[system].ok_or_else(|| {
            let name = OFFSET_NAMES[system];
            format!("moves with {name}, whose offsets were not stated; say for example --offset {name}:X=0,Y=0,Z=0")
        })?;
        let tool = match (self.modal.tool, letter, self.control.coordinates) {
            (Some(ToolLength::On(length)), 2, Coordinates::Axes) => length,
            _ => 0.0,
        };
        Ok(offsets[letter] + tool)
    }

    /// Coordinates at the end of a block.
    pub(super) fn target(&self, block: &Block) -> Result<[Option<f64>; 9], String> {
        let unit = self.modal.unit()?;
        let mut target = self.here;
        for word in &block.words {
            let Some(letter) = self.letter(word.letter)? else { continue };
            let value = word.value * if (3..6).contains(&letter) { 1.0 } else { unit };
            target[letter] = match self.modal.is_absolute {
                Some(true) => Some(value + self.offset(letter)?),
                _ => Some(
                    self.here[letter].ok_or_else(|| {
                        format!(
                            "moves {} by a step, and where it stands is not known; go to an absolute place first",
                            LETTERS[letter] as char
                        )
                    })? + value,
                ),
            };
        }
        Ok(target)
    }
}

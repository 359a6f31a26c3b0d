//! A program block by block: what stays, what is corrected, what is refused.

use super::block::{Block, split};
use super::codes::{Motion, is_usual_m_code};
use super::command::{Control, Coordinates};
use super::correct::Corrector;
use super::memory::Memories;
use super::modal::{Modal, Once, ToolLength, has_place};
use super::rewrite::Changes;
use super::settings::{NotCorrected, Settings, Summary};
use super::state::{Compensator, Text, Told};
use crate::chain::Chain;
use crate::disturbances::Remembered;
use crate::inverse::Kinematics;
use crate::machine::Machine;

/// Blocks that stay are listed up to this many.
const MOST_LISTED: usize = 100;

impl<'a> Compensator<'a> {
    /// For a machine with its errors.
    pub fn new(machine: &'a Machine, chain: &'a Chain, settings: Settings) -> Result<Compensator<'a>, String> {
        let control = Control::new(machine, chain, settings.coordinates, settings.tool_length_mm)?;
        let actual = Kinematics::actual(machine, chain, *control.nominal.tool());
        let corrector = Corrector::new(actual, control.sliding, &control.turning);
        let mut compensator = Compensator {
            offsets: settings.offsets,
            control,
            corrector,
            modal: Modal::default(),
            here: [None; 9],
            sent: [None; 9],
            told: Told::default(),
            in_machine: false,
            kept: None,
            text: Text::Before,
            block: Block::default(),
            changes: Changes::default(),
            summary: Summary::default(),
            settings,
        };
        let initial = compensator.settings.initial.clone();
        split(initial.as_bytes(), &mut compensator.block)
            .and_then(|()| compensator.modal.take(&compensator.block, &compensator.settings.tools))
            .map_err(|why| format!("--initial '{initial}' {why}"))?;
        compensator.take_tool();
        compensator.told = Told {
            motion: compensator.modal.motion,
            feed_mode: compensator.modal.feed_mode,
            feed: compensator.modal.feed,
        };
        Ok(compensator)
    }

    /// With effects that depend on the way of an axis: each is run along the commands of the new program.
    pub fn with_remembered(mut self, remembered: Vec<Remembered>) -> Compensator<'a> {
        self.corrector.memories = Memories::new(remembered, self.settings.tolerance_mm);
        self.leave_out_spikes();
        self
    }

    /// In coordinates of the workpiece no reversal spike is taken out from here on.
    fn leave_out_spikes(&mut self) {
        if self.control.coordinates == Coordinates::Workpiece && self.corrector.memories.without_spikes() {
            self.summary.spikes_stay_from = Some(self.summary.lines.max(1));
        }
    }

    /// What was done so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// One line with its end; what stands for it is added to `out`.
    pub fn line(&mut self, line: &[u8], out: &mut Vec<u8>) -> Result<(), NotCorrected> {
        self.summary.lines += 1;
        let length = line.iter().rposition(|byte| !matches!(byte, b'\n' | b'\r')).map_or(0, |last| last + 1);
        let (text, end) = line.split_at(length);
        let is_bar = text.trim_ascii_start().starts_with(b"%");
        let has_begun = self.text != Text::Before;
        if self.text == Text::After || is_bar && has_begun {
            // what stands behind the closing % is no program
            self.text = Text::After;
            out.extend_from_slice(line);
            return Ok(());
        }
        let begin = out.len();
        let mut block = std::mem::take(&mut self.block);
        let outcome = split(text, &mut block).and_then(|()| self.block(text, end, &block, out));
        if is_bar || !block.words.is_empty() {
            self.text = Text::Program;
        }
        self.block = block;
        let Err(reason) = outcome else { return Ok(()) };
        let refusal = NotCorrected { line: self.summary.lines, reason };
        if !self.settings.mark {
            return Err(refusal);
        }
        out.truncate(begin);
        self.mark(refusal, line, out);
        Ok(())
    }

    /// Leaves a line as it is, with a comment before it; where the axes stand after it is not known.
    fn mark(&mut self, refusal: NotCorrected, line: &[u8], out: &mut Vec<u8>) {
        self.restore_feed(b"\n", out);
        // a comment in brackets holds none
        let plain = |c: char| if c.is_ascii_graphic() && !matches!(c, '(' | ')') || c == ' ' { c } else { '?' };
        let reason: String = refusal.reason.chars().map(plain).take(160).collect();
        out.extend_from_slice(format!("(NOT CORRECTED, line {} {reason})\n", refusal.line).as_bytes());
        out.extend_from_slice(line);
        (0..9).for_each(|letter| self.lose_place(letter));
        self.told = Told::default();
        self.summary.marked_count += 1;
        if self.summary.marked.len() < MOST_LISTED {
            self.summary.marked.push(refusal);
        }
    }

    fn block(&mut self, line: &[u8], end: &[u8], block: &Block, out: &mut Vec<u8>) -> Result<(), String> {
        if block.is_optional && !block.words.is_empty() {
            return Err(
                "may be left out by a switch of the control, so that the path is not known; write two programs".into(),
            );
        }
        if let Some(word) = block.words.iter().find(|word| word.letter == b'O') {
            let is_name = block.words.len() == 1;
            if !is_name {
                return Err(format!("has O{}, a subprogram; write it out", word.value));
            }
        }
        let was_tool = (self.modal.tool, self.modal.centre_point);
        let was_system = self.modal.system;
        let once = self.modal.take(block, &self.settings.tools)?;
        self.keep_modes(block);
        if (self.modal.tool, self.modal.centre_point) != was_tool {
            self.take_tool();
        }
        self.note_m_codes(block);
        let has_place = has_place(block);
        let has_centre = block.words.iter().any(|word| matches!(word.letter, b'I' | b'J' | b'K'));
        match once {
            Once::SetOffsets => self.set_offsets(block)?,
            Once::Reference => self.forget(block),
            // a rapid in machine coordinates is a way to a safe place, often at the end of the travel
            Once::MachineCoordinates if has_place && self.modal.motion == Some(Motion::Rapid) => {
                self.goes_to_machine_coordinates(block)?;
            }
            Once::MachineCoordinates if has_place => {
                self.in_machine = true;
                let outcome = self.moved(line, end, block, out);
                self.in_machine = false;
                outcome?;
                self.after_tool_change(block);
                return Ok(());
            }
            Once::Nothing if has_place || has_centre => {
                let is_new = (self.modal.tool, self.modal.centre_point) != was_tool || self.modal.system != was_system;
                if is_new && self.modal.is_absolute == Some(false) {
                    return Err("changes a tool length or offset and moves in G91, which controls read in different ways; move in a block of its own".into());
                }
                self.moved(line, end, block, out)?;
                self.after_tool_change(block);
                return Ok(());
            }
            _ => {}
        }
        self.pass(line, end, block, out);
        self.after_tool_change(block);
        Ok(())
    }

    /// M70 keeps the modes, M72 brings them back; without an M70 they are not known after it.
    fn keep_modes(&mut self, block: &Block) {
        for word in block.words.iter().filter(|word| word.letter == b'M') {
            match word.code() {
                Some(700) => self.kept = Some(self.modal.clone()),
                Some(720) => {
                    let kept = self.kept.clone().unwrap_or_default();
                    let (in_spindle, called) = (self.modal.in_spindle, self.modal.called);
                    self.modal = Modal { motion: self.modal.motion, in_spindle, called, ..kept };
                    (self.told.feed_mode, self.told.feed) = (self.modal.feed_mode, self.modal.feed);
                }
                _ => {}
            }
        }
    }

    /// A tool change may drive the slides to its place.
    fn after_tool_change(&mut self, block: &Block) {
        if block.words.iter().any(|word| word.letter == b'M' && word.code() == Some(60)) {
            (0..3).for_each(|letter| self.lose_place(letter));
        }
    }

    /// The tool in force for the kinematics.
    fn take_tool(&mut self) {
        let length = match self.modal.tool {
            Some(ToolLength::On(length)) => Some(length),
            _ => None,
        };
        let tool = self.control.tool(length);
        self.control.nominal = self.control.nominal.with_tool(tool);
        self.corrector.take_tool(tool);
        if self.settings.coordinates == Coordinates::Axes {
            let coordinates = if self.modal.centre_point { Coordinates::Workpiece } else { Coordinates::Axes };
            if coordinates != self.control.coordinates {
                self.control.coordinates = coordinates;
                // the slides' coordinates have become others
                for letter in 0..3 {
                    (self.here[letter], self.sent[letter]) = (None, None);
                }
                self.leave_out_spikes();
            }
        }
    }

    fn note_m_codes(&mut self, block: &Block) {
        for code in block.words.iter().filter(|word| word.letter == b'M').filter_map(|word| word.code()) {
            let is_known = is_usual_m_code(code) || self.summary.unusual_m.iter().any(|(other, _)| *other == code);
            if !is_known && self.summary.unusual_m.len() < MOST_LISTED {
                self.summary.unusual_m.push((code, self.summary.lines));
            }
        }
    }
}

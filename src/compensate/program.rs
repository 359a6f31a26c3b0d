//! A program block by block: what stays, what is corrected, what is refused.

use nalgebra::Vector3;

use super::block::{Block, split};
use super::codes::{Motion, acts_at_the_end, is_usual_m_code};
use super::command::{Control, Coordinates};
use super::correct::Corrector;
use super::modal::{FeedMode, LETTERS, Modal, Needs, OffsetTable, Once, ToolLength};
use super::path::{Arc, ArcWords, Path, Place};
use super::pieces::{Fineness, Piece, Pieces};
use super::rewrite::{Changes, feed_number, number};
use crate::bodies::Bodies;
use crate::chain::Chain;
use crate::inverse::Kinematics;
use crate::machine::Machine;

/// What is known beside the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub coordinates: Coordinates,
    /// The tip stays this near to the ideal path, mm.
    pub tolerance_mm: f64,
    /// The tool stays this near to the ideal direction, rad.
    pub tolerance_rad: f64,
    pub offsets: OffsetTable,
    /// Lengths of tools by number, mm.
    pub tools: Vec<(u32, f64)>,
    /// Length of the tool from the spindle's nose while no length is in force, mm; `None`: the machine's gauge length.
    pub tool_length_mm: Option<f64>,
    /// Words that hold when the program begins.
    pub initial: String,
    /// Blocks that cannot be corrected stay, with a comment; else they end the run.
    pub mark: bool,
    /// Decimals of lengths in mm and of angles in degrees.
    pub decimals: [usize; 2],
}

/// A block that is not corrected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} {reason}")]
pub struct NotCorrected {
    /// From 1.
    pub line: u64,
    /// What was found, what is allowed, what to do.
    pub reason: String,
}

/// Largest amount and the line where it was.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Largest {
    pub amount: f64,
    pub line: u64,
}

impl Largest {
    fn take(&mut self, amount: f64, line: u64) {
        if amount > self.amount {
            *self = Largest { amount, line };
        }
    }
}

/// What was done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    pub lines: u64,
    /// Moves that were corrected, and the straight blocks written for them.
    pub moves: u64,
    pub blocks: u64,
    /// Moves that stayed because not all axes had a position yet, or because they go to machine coordinates.
    pub left: u64,
    /// Largest change of a coordinate by letter, mm or deg.
    pub changed: [Largest; 9],
    /// Largest angle that the tool stays off, rad.
    pub off: Largest,
    /// Blocks that stay with a comment, the first of them.
    pub marked: Vec<NotCorrected>,
    pub marked_count: u64,
    /// M codes that are not the same on all controls, with the first line of each.
    pub unusual_m: Vec<(u16, u64)>,
}

/// Blocks that stay are listed up to this many.
const MOST_LISTED: usize = 100;
/// Feeds that differ by less are the same.
const SAME_FEED: f64 = 1e-4;

/// What the control that reads the new program holds.
#[derive(Debug, Clone, Default)]
struct Told {
    motion: Option<Motion>,
    feed_mode: Option<FeedMode>,
    feed: Option<f64>,
}

/// How long the pieces of a move take.
#[derive(Debug, Clone, Copy)]
enum Timing {
    Rapid,
    /// In the program's mode with its feed, for a move of this length, mm.
    Feed {
        mode: FeedMode,
        feed: f64,
        length_mm: f64,
    },
    /// The whole move in this time, min.
    Time(f64),
}

/// A block that moves.
#[derive(Clone, Copy)]
struct Moving<'m> {
    line: &'m [u8],
    block: &'m Block,
    path: &'m Path,
    timing: Timing,
}

/// Corrects a program.
pub struct Compensator<'a> {
    settings: Settings,
    control: Control<'a>,
    corrector: Corrector<'a>,
    modal: Modal,
    /// Ideal coordinates by letter, and those that the new program has commanded; both with all offsets in them.
    here: [Option<f64>; 9],
    sent: [Option<f64>; 9],
    told: Told,
    offsets: OffsetTable,
    /// The block in hand counts in machine coordinates (G53).
    in_machine: bool,
    /// Modes that M70 has kept.
    kept: Option<Modal>,
    block: Block,
    changes: Changes,
    summary: Summary,
}

impl<'a> Compensator<'a> {
    /// For a machine with its errors.
    pub fn new(
        machine: &'a Machine,
        chain: &'a Chain,
        bodies: &'a Bodies,
        settings: Settings,
    ) -> Result<Compensator<'a>, String> {
        let control = Control::new(machine, chain, bodies, settings.coordinates, settings.tool_length_mm)?;
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

    /// What was done so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// One line with its end; what stands for it is added to `out`.
    pub fn line(&mut self, line: &[u8], out: &mut Vec<u8>) -> Result<(), NotCorrected> {
        self.summary.lines += 1;
        let length = line.iter().rposition(|byte| !matches!(byte, b'\n' | b'\r')).map_or(0, |last| last + 1);
        let (text, end) = line.split_at(length);
        let begin = out.len();
        let mut block = std::mem::take(&mut self.block);
        let outcome = split(text, &mut block).and_then(|()| self.block(text, end, &block, out));
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
        (self.here, self.sent) = ([None; 9], [None; 9]);
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
        let has_place = block.words.iter().any(|word| LETTERS.contains(&word.letter));
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
                return outcome;
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
            for letter in 0..3 {
                (self.here[letter], self.sent[letter]) = (None, None);
            }
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

    /// `G10 L2 P1 X… Y…`.
    fn set_offsets(&mut self, block: &Block) -> Result<(), String> {
        let value = |letter: u8| block.words.iter().find(|word| word.letter == letter).map(|word| word.value);
        if value(b'L') != Some(2.0) {
            return Err(
                "has G10 without L2: what it sets is not followed here; state offsets and tools as options".into()
            );
        }
        if value(b'R').is_some_and(|angle| angle != 0.0) {
            return Err("turns the coordinates of a work offset; program the plain ones".into());
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
    fn forget(&mut self, block: &Block) {
        let named = |letter: usize| block.words.iter().any(|word| word.letter == LETTERS[letter]);
        let all = (0..9).all(|letter| !named(letter));
        for letter in 0..9 {
            if all || named(letter) {
                (self.here[letter], self.sent[letter]) = (None, None);
            }
        }
    }

    /// `G53`: stays as it is.
    fn goes_to_machine_coordinates(&mut self, block: &Block) -> Result<(), String> {
        let unit = self.modal.unit()?;
        for word in &block.words {
            let Some(letter) = self.letter(word.letter)? else { continue };
            let value = word.value * if (3..6).contains(&letter) { 1.0 } else { unit };
            // with tool centre point control machine coordinates of slides are no tip
            let known = (self.control.coordinates == Coordinates::Axes || letter > 2).then_some(value);
            (self.here[letter], self.sent[letter]) = (known, known);
        }
        self.summary.left += 1;
        Ok(())
    }

    /// Place of an axis letter in the arrays; refused for axes that the machine has not.
    fn letter(&self, letter: u8) -> Result<Option<usize>, String> {
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
    fn offset(&self, letter: usize) -> Result<f64, String> {
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

    /// A block that moves.
    fn moved(&mut self, line: &[u8], end: &[u8], block: &Block, out: &mut Vec<u8>) -> Result<(), String> {
        let motion = match self.modal.motion {
            Some(Motion::Cycle) => return Err("belongs to a canned cycle or another motion that is not followed; let the CAM system write its moves out".into()),
            None | Some(Motion::None) => return Err("has coordinates and no motion; say G0, G1, G2 or G3".into()),
            Some(motion) => motion,
        };
        let is_arc = matches!(motion, Motion::Clockwise | Motion::Counter);
        if self.in_machine
            && (is_arc || self.modal.is_absolute == Some(false) || self.control.coordinates == Coordinates::Workpiece)
        {
            return Err("has G53 with an arc, in G91 or with tool centre point control; go to machine coordinates by G90 and a straight move".into());
        }
        let needs = Needs { plane: is_arc, feed_mode: motion != Motion::Rapid, system: !self.in_machine };
        let missing = self.modal.missing(needs);
        if !missing.is_empty() {
            return Err(format!(
                "moves before these modes were said: {}; say them in the program, or with --initial \"G21 G90 …\" how the control stands when it begins",
                missing.join("; ")
            ));
        }
        let target = self.target(block)?;
        let count = self.control.axis_of.iter().filter(|axis| axis.is_some()).count();
        let is_known = |place: &[Option<f64>; 9]| place.iter().filter(|value| value.is_some()).count() == count;
        if !is_known(&self.here) || !is_known(&self.sent) {
            return self.first_moves(line, end, block, &target, out);
        }
        let whole = |place: &[Option<f64>; 9]| -> Place { std::array::from_fn(|k| place[k].unwrap_or(0.0)) };
        let from = whole(&self.here);
        let to = whole(&target);
        let arc = if is_arc { Some(self.arc(block, &from, &to, motion == Motion::Counter)?) } else { None };
        let path = Path { from, to, arc };
        let timing = self.timing(&path, motion)?;
        self.pieces(line, end, block, &path, timing, out)?;
        self.here = target;
        self.summary.moves += 1;
        Ok(())
    }

    /// Coordinates at the end of a block.
    fn target(&self, block: &Block) -> Result<[Option<f64>; 9], String> {
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

    /// Rapids before every axis has a position stay; other moves are refused there.
    fn first_moves(
        &mut self,
        line: &[u8],
        end: &[u8],
        block: &Block,
        target: &[Option<f64>; 9],
        out: &mut Vec<u8>,
    ) -> Result<(), String> {
        let unknown: Vec<String> = (0..9)
            .filter(|&k| {
                self.control.axis_of[k].is_some()
                    && (target[k].is_none() || self.here[k].is_none() && target[k].is_none())
            })
            .map(|k| (LETTERS[k] as char).to_string())
            .collect();
        if self.modal.motion != Some(Motion::Rapid) {
            return Err(format!(
                "is a feed move while it is not known where {} stands; go there with G0 before, every axis named once",
                if unknown.is_empty() { "an axis".into() } else { unknown.join(", ") }
            ));
        }
        self.here = *target;
        if unknown.is_empty() {
            // every axis has a place now: the end can be corrected
            let to: Place = std::array::from_fn(|k| target[k].unwrap_or(0.0));
            self.sent = std::array::from_fn(|k| self.sent[k].or(target[k]));
            let path = Path { from: to, to, arc: None };
            self.summary.moves += 1;
            return self.pieces(line, end, block, &path, Timing::Rapid, out);
        }
        for letter in 0..9 {
            if block.words.iter().any(|word| word.letter == LETTERS[letter]) {
                self.sent[letter] = target[letter];
            }
        }
        self.summary.left += 1;
        self.pass(line, end, block, out);
        Ok(())
    }

    fn arc(&self, block: &Block, from: &Place, to: &Place, counter: bool) -> Result<Arc, String> {
        let plane = self.modal.plane.unwrap_or([0, 1]);
        let unit = self.modal.unit()?;
        let value = |letter: u8| block.words.iter().find(|word| word.letter == letter).map(|word| word.value);
        let third = 3 - plane[0] - plane[1];
        if value([b'I', b'J', b'K'][third]).is_some_and(|value| value != 0.0) {
            return Err(format!("has {} outside the plane of its arc", ['I', 'J', 'K'][third]));
        }
        let centres = plane.map(|k| value([b'I', b'J', b'K'][k]));
        let words = match (value(b'R'), centres) {
            (Some(_), [Some(_), _] | [_, Some(_)]) => return Err("has an arc with R and a centre; keep one".into()),
            (Some(radius), _) => ArcWords::Radius(radius * unit),
            (None, [None, None]) => return Err("has an arc without R and without I, J, K".into()),
            (None, centres) => {
                let mut centre = [0.0; 2];
                for (k, &axis) in plane.iter().enumerate() {
                    let said = centres[k].unwrap_or(0.0) * unit;
                    centre[k] = match self.modal.absolute_centres {
                        true => said + self.offset(axis)?,
                        false => from[axis] + said,
                    };
                }
                ArcWords::Centre(centre)
            }
        };
        let turns = value(b'P').unwrap_or(1.0);
        if !(1.0..=1000.0).contains(&turns) || turns.fract() != 0.0 {
            return Err(format!("has P{turns} on an arc; whole turns from 1 to 1000 are allowed"));
        }
        Arc::new(from, to, plane, words, counter, turns)
    }

    /// How long a move takes, by the control's rule: F is along X, Y, Z where one of them moves, else along the rotary axes.
    fn timing(&self, path: &Path, motion: Motion) -> Result<Timing, String> {
        if motion == Motion::Rapid {
            return Ok(Timing::Rapid);
        }
        // said by now, as are the units
        let mode = self.modal.feed_mode.unwrap_or(FeedMode::PerMinute);
        let unit = self.modal.unit()?;
        let feed = self.modal.feed.ok_or("is a feed move before an F was said in its mode")?;
        let (length_mm, turn_deg) = (path.length_mm(), path.turn_deg());
        let moves_tip = length_mm > 0.0;
        let is_tip_feed = self.control.coordinates == Coordinates::Workpiece && moves_tip;
        match mode {
            FeedMode::InverseTime => Ok(Timing::Time(1.0 / feed)),
            _ if turn_deg == 0.0 || is_tip_feed => Ok(Timing::Feed { mode, feed, length_mm }),
            FeedMode::PerMinute => {
                Ok(Timing::Time(if moves_tip { length_mm / (feed * unit) } else { turn_deg / feed }))
            }
            FeedMode::PerRevolution => {
                Err("turns a rotary axis with a feed per revolution, whose time is not known here; say G94 or G93"
                    .into())
            }
        }
    }

    fn pieces(
        &mut self,
        line: &[u8],
        end: &[u8],
        block: &Block,
        path: &Path,
        timing: Timing,
        out: &mut Vec<u8>,
    ) -> Result<(), String> {
        let sent: Place = std::array::from_fn(|k| self.sent[k].unwrap_or(0.0));
        let [mm, deg] = self.settings.decimals;
        let fineness = Fineness {
            tolerance_mm: self.settings.tolerance_mm,
            tolerance_rad: self.settings.tolerance_rad,
            step_mm: 0.1f64.powi(mm as i32),
            step_deg: 0.1f64.powi(deg as i32),
        };
        // of a rapid only the end matters
        let ends = Path { from: path.to, to: path.to, arc: None };
        let cut = if matches!(timing, Timing::Rapid) { &ends } else { path };
        let mut pieces = match timing {
            Timing::Rapid => Pieces::rapid(cut, fineness),
            _ => Pieces::new(&mut self.control, &self.corrector, cut, &sent, fineness),
        };
        let late: Vec<&[u8]> = late_words(line, block);
        let mut is_first = true;
        while let Some(mut piece) = pieces.next(&mut self.control, &mut self.corrector)? {
            if let Err(why) = self.check_travel(&piece) {
                if !matches!(timing, Timing::Rapid) {
                    return Err(why);
                }
                // a rapid to the end of the travel, a park position, stays where it was
                piece.command = path.to;
                piece.positions = self.control.positions(&path.to, &piece.positions);
                self.check_travel(&piece)?;
                self.summary.left += 1;
            }
            let is_last = piece.share >= 1.0;
            let late = if is_first && is_last { &[] } else { late.as_slice() };
            match is_first {
                true => self.first_piece(&Moving { line, block, path, timing }, &piece, !late.is_empty(), out),
                false => self.next_piece(path, &piece, timing, out),
            }
            if is_last && !is_first {
                for word in late {
                    out.push(b' ');
                    out.extend_from_slice(word);
                }
            }
            out.extend_from_slice(if is_last || !end.is_empty() { end } else { b"\n" });
            self.summary.blocks += 1;
            self.summary.off.take(piece.off_rad, self.summary.lines);
            let ideal = path.at(piece.share);
            for (letter, largest) in self.summary.changed.iter_mut().enumerate() {
                largest.take((piece.command[letter] - ideal[letter]).abs(), self.summary.lines);
            }
            is_first = false;
        }
        Ok(())
    }

    /// Refuses positions outside the travel.
    fn check_travel(&self, piece: &Piece) -> Result<(), String> {
        for (axis, &q) in self.control.nominal.machine().axes.iter().zip(&piece.positions) {
            let Some((from, to)) = axis.range else { continue };
            if q < from - 1e-9 || q > to + 1e-9 {
                let shown = |q: f64| number(axis.kind.to_file_unit(q), 4);
                return Err(format!(
                    "takes {} to {} {}, outside its travel of {} to {}: is it a program of another machine, or are offsets and tool lengths others?",
                    axis.name,
                    shown(q),
                    axis.kind.position_unit(),
                    shown(from),
                    shown(to)
                ));
            }
        }
        Ok(())
    }

    /// Words for the axes that move; `said` are the letters that the block has.
    fn axis_words(&mut self, command: &Place, said: impl Fn(u8) -> bool) -> Vec<(u8, String)> {
        let unit = self.modal.unit_mm.unwrap_or(1.0);
        let mut words = Vec::new();
        for letter in 0..9 {
            if self.control.axis_of[letter].is_none() {
                continue;
            }
            let is_angle = (3..6).contains(&letter);
            let decimals = self.settings.decimals[usize::from(is_angle)];
            let before = self.sent[letter].unwrap_or(f64::INFINITY);
            let is_moved = (command[letter] - before).abs() >= 0.5 * 0.1f64.powi(decimals as i32);
            if !is_moved && !said(LETTERS[letter]) {
                continue;
            }
            let offset = self.offset(letter).unwrap_or(0.0);
            let value = match self.modal.is_absolute {
                Some(false) if before.is_finite() => command[letter] - before,
                _ => command[letter] - offset,
            };
            let (value, decimals) = match is_angle || unit == 1.0 {
                true => (value, decimals),
                // a hundredth of a micrometre in inches
                false => (value / unit, decimals + 2),
            };
            words.push((LETTERS[letter], number(value, decimals)));
            self.sent[letter] = Some(command[letter]);
        }
        words
    }

    /// The block itself with its words for the first piece.
    fn first_piece(&mut self, moving: &Moving, piece: &Piece, is_cut: bool, out: &mut Vec<u8>) {
        let Moving { line, block, path, timing } = *moving;
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        let before = self.sent;
        let has = |letter: u8| block.words.iter().any(|word| word.letter == letter);
        let words = self.axis_words(&piece.command, has);
        let motion = if matches!(timing, Timing::Rapid) { Motion::Rapid } else { Motion::Line };
        let feed = self.feed_words(path, piece, &before, timing);
        let (mut said_motion, mut said_feed) = (false, false);
        for word in &block.words {
            match word.letter {
                b'G' => match word.code() {
                    Some(0 | 10 | 20 | 30) => {
                        changes.replace(
                            word.bytes.clone(),
                            if said_motion { String::new() } else { motion_word(motion).into() },
                        );
                        said_motion = true;
                    }
                    Some(930 | 940 | 950) if feed.is_some() => changes.replace(word.bytes.clone(), String::new()),
                    _ => {}
                },
                b'F' if let Some((_, value)) = &feed => {
                    said_feed = true;
                    let is_same = self.modal.feed_mode == feed.map(|(mode, _)| mode) && word.value == *value;
                    if !is_same {
                        changes.replace(word.bytes.clone(), format!("F{}", feed_number(*value)));
                    }
                }
                b'I' | b'J' | b'K' | b'R' | b'P' if path.arc.is_some() => {
                    changes.replace(word.bytes.clone(), String::new())
                }
                b'M' if is_cut && word.code().is_some_and(acts_at_the_end) => {
                    changes.replace(word.bytes.clone(), String::new())
                }
                letter => {
                    if let Some((_, value)) = words.iter().find(|(other, _)| *other == letter) {
                        changes.replace(word.bytes.clone(), format!("{}{value}", letter as char));
                    }
                }
            }
        }
        self.tell_feed(block, feed, said_feed, &mut changes);
        if !said_motion && self.told.motion != Some(motion) {
            changes.put_before(motion_word(motion));
        }
        self.told.motion = Some(motion);
        for (letter, value) in words.iter().filter(|(letter, _)| !has(*letter)) {
            changes.put_after(&format!("{}{value}", *letter as char));
        }
        let last = block.words.last().map_or(0, |word| word.bytes.end);
        changes.write(line, block.after_number, last, out);
        self.changes = changes;
    }

    /// Mode and F of the first piece, where the control does not hold them.
    fn tell_feed(&mut self, block: &Block, feed: Option<(FeedMode, f64)>, said_feed: bool, changes: &mut Changes) {
        let Some((mode, value)) = feed else { return self.follow(block) };
        let is_mode = |word: &super::block::Word| word.letter == b'G' && matches!(word.code(), Some(930 | 940 | 950));
        if block.words.iter().any(is_mode) || self.told.feed_mode != Some(mode) {
            changes.put_before(mode.word());
        }
        let is_told =
            self.told.feed_mode == Some(mode) && self.told.feed == Some(value) && mode != FeedMode::InverseTime;
        if !said_feed && !is_told {
            changes.put_after(&format!("F{}", feed_number(value)));
        }
        (self.told.feed_mode, self.told.feed) = (Some(mode), Some(value));
    }

    /// A further block of the same move.
    fn next_piece(&mut self, path: &Path, piece: &Piece, timing: Timing, out: &mut Vec<u8>) {
        let before = self.sent;
        let words = self.axis_words(&piece.command, |_| false);
        let mut is_first = true;
        let mut put = |text: &str| {
            if !std::mem::take(&mut is_first) {
                out.push(b' ');
            }
            out.extend_from_slice(text.as_bytes());
        };
        if self.in_machine && !words.is_empty() {
            put("G53");
        }
        for (letter, value) in &words {
            put(&format!("{}{value}", *letter as char));
        }
        if let Some((mode, value)) = self.feed_words(path, piece, &before, timing).filter(|_| !words.is_empty()) {
            if mode == FeedMode::InverseTime || self.told.feed != Some(value) {
                put(&format!("F{}", feed_number(value)));
            }
            self.told.feed = Some(value);
        }
    }

    /// Mode and value of F for a piece; `None` for rapids.
    fn feed_words(
        &self,
        path: &Path,
        piece: &Piece,
        before: &[Option<f64>; 9],
        timing: Timing,
    ) -> Option<(FeedMode, f64)> {
        let share = piece.share - piece.from_share;
        match timing {
            Timing::Rapid => None,
            Timing::Time(minutes) => Some((FeedMode::InverseTime, 1.0 / (minutes * share))),
            Timing::Feed { mode, feed, length_mm } => {
                let step = Vector3::from_fn(|k, _| piece.command[k] - before[k].unwrap_or(path.from[k]));
                let ratio = step.norm() / (share * length_mm);
                let is_same = !ratio.is_finite() || (ratio - 1.0).abs() < SAME_FEED;
                Some((mode, if is_same { feed } else { feed * ratio }))
            }
        }
    }

    /// A block that stays.
    fn pass(&mut self, line: &[u8], end: &[u8], block: &Block, out: &mut Vec<u8>) {
        if block.words.iter().any(|word| word.letter != b'N' && word.letter != b'O') {
            self.restore_feed(if end.is_empty() { b"\n" } else { end }, out);
        }
        self.follow(block);
        out.extend_from_slice(line);
        out.extend_from_slice(end);
    }

    /// What the control holds after words that stay.
    fn follow(&mut self, block: &Block) {
        for word in &block.words {
            match (word.letter, word.code()) {
                (b'G', Some(0 | 10 | 20 | 30 | 800)) => self.told.motion = self.modal.motion,
                (b'G', Some(930 | 940 | 950)) => (self.told.feed_mode, self.told.feed) = (self.modal.feed_mode, None),
                _ => {}
            }
        }
        if block.words.iter().any(|word| word.letter == b'F') {
            self.told.feed = self.modal.feed;
        }
    }

    /// Puts the program's own feed mode back before a block that stays.
    fn restore_feed(&mut self, end: &[u8], out: &mut Vec<u8>) {
        let Some(mode) = self.modal.feed_mode.filter(|mode| self.told.feed_mode.is_some_and(|told| told != *mode))
        else {
            return;
        };
        let feed = self.modal.feed.filter(|_| mode != FeedMode::InverseTime);
        let feed_word = feed.map(|feed| format!(" F{}", feed_number(feed))).unwrap_or_default();
        out.extend_from_slice(format!("{}{feed_word}", mode.word()).as_bytes());
        out.extend_from_slice(end);
        (self.told.feed_mode, self.told.feed) = (Some(mode), feed);
    }
}

/// Names of the work offsets in the order of the table.
pub const OFFSET_NAMES: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

fn motion_word(motion: Motion) -> &'static str {
    if motion == Motion::Rapid { "G0" } else { "G1" }
}

/// Words that act at the end of the block, as written.
fn late_words<'l>(line: &'l [u8], block: &Block) -> Vec<&'l [u8]> {
    let is_late = |word: &&super::block::Word| word.letter == b'M' && word.code().is_some_and(acts_at_the_end);
    block.words.iter().filter(is_late).map(|word| &line[word.bytes.clone()]).collect()
}

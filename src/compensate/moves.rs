//! A block that moves: its path, its time, its pieces.

use super::block::Block;
use super::codes::Motion;
use super::command::Coordinates;
use super::modal::{FeedMode, LETTERS, Needs};
use super::path::{Arc, ArcSense, ArcWords, Path, Place};
use super::pieces::{Fineness, Piece, Pieces};
use super::rewrite::number;
use super::settings::UnknownFlank;
use super::state::{Compensator, Moving, Timing};
use super::written::late_words;

/// A feed move that starts this many tolerances beside its path is told.
const STARTS_OFF: f64 = 3.0;

impl Compensator<'_> {
    /// A block that moves.
    pub(super) fn moved(&mut self, line: &[u8], end: &[u8], block: &Block, out: &mut Vec<u8>) -> Result<(), String> {
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
        let sense = match motion {
            Motion::Counter => ArcSense::CounterClockwise,
            _ => ArcSense::Clockwise,
        };
        let arc = if is_arc { Some(self.arc(block, &from, &to, sense)?) } else { None };
        let path = Path { from, to, arc };
        let timing = self.timing(&path, motion)?;
        self.pieces(line, end, block, &path, timing, out)?;
        self.here = target;
        self.summary.moves += 1;
        if motion != Motion::Rapid {
            self.note_unknown_flanks();
        }
        Ok(())
    }

    /// Notes axes whose flank is not known in a feed move.
    fn note_unknown_flanks(&mut self) {
        let line = self.summary.lines;
        let known = &mut self.summary.unknown_flanks;
        for (axis, [off_mm, off_rad]) in self.corrector.memories.unknown_flanks() {
            match known.iter_mut().find(|other| other.axis == axis) {
                Some(other) => {
                    (other.off_mm, other.off_rad) = (other.off_mm.max(off_mm), other.off_rad.max(off_rad));
                }
                None => known.push(UnknownFlank { axis, line, off_mm, off_rad }),
            }
        }
    }

    /// Rapids before every axis has a position stay; other moves are refused there.
    pub(super) fn first_moves(
        &mut self,
        line: &[u8],
        end: &[u8],
        block: &Block,
        target: &[Option<f64>; 9],
        out: &mut Vec<u8>,
    ) -> Result<(), String> {
        let unknown: Vec<String> = (0..9)
            .filter(|&k| self.control.axis_of[k].is_some() && target[k].is_none())
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
        self.follow_memories();
        self.summary.left += 1;
        self.pass(line, end, block, out);
        Ok(())
    }

    pub(super) fn arc(&self, block: &Block, from: &Place, to: &Place, sense: ArcSense) -> Result<Arc, String> {
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
        Arc::new(from, to, plane, words, sense, turns)
    }

    /// How long a move takes, by the control's rule: F is along X, Y, Z where one of them moves, else along the rotary axes.
    pub(super) fn timing(&self, path: &Path, motion: Motion) -> Result<Timing, String> {
        if motion == Motion::Rapid {
            return Ok(Timing::Rapid);
        }
        // said by now, as are the units
        let mode = self.modal.feed_mode.unwrap_or(FeedMode::PerMinute);
        let unit = self.modal.unit()?;
        let feed = self.modal.feed.ok_or(match mode {
            FeedMode::InverseTime => "is a feed move without an F of its own, which each block in G93 needs",
            _ => "is a feed move before an F was said in its mode",
        })?;
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

    pub(super) fn pieces(
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
            keeps_arcs: self.settings.keeps_arcs,
        };
        // of a rapid only the end matters
        let ends = Path { from: path.to, to: path.to, arc: None };
        let cut = if matches!(timing, Timing::Rapid) { &ends } else { path };
        let mut pieces = match timing {
            Timing::Rapid => Pieces::rapid(cut, fineness),
            _ => Pieces::new(&mut self.control, &self.corrector, cut, &sent, fineness),
        };
        if !matches!(timing, Timing::Rapid) && pieces.starts_off_mm() > STARTS_OFF * self.settings.tolerance_mm {
            self.summary.starts_off.take(pieces.starts_off_mm(), self.summary.lines);
        }
        let late: Vec<&[u8]> = late_words(line, block);
        let mut is_first = true;
        while let Some(mut piece) = pieces.next(&mut self.control, &mut self.corrector)? {
            if let Err(why) = self.check_travel(&piece) {
                if !matches!(timing, Timing::Rapid) {
                    return Err(why);
                }
                // a rapid to the end of the travel, a park position, stays where it was
                (piece.command, piece.arc) = (path.to, None);
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
            self.follow_memories();
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
    pub(super) fn check_travel(&self, piece: &Piece) -> Result<(), String> {
        for (axis, &q) in self.control.nominal.machine().axes.iter().zip(&piece.positions) {
            let Some((from, to)) = axis.range else { continue };
            if q < from - 1e-9 || q > to + 1e-9 {
                let shown = |q: f64| number(axis.kind.to_file_unit(q), 4);
                // a correction leads over a limit by some thousandths: as many digits as tell the two apart
                let finely = |q: f64| number(axis.kind.to_file_unit(q), 7);
                return Err(format!(
                    "takes {} to {} {}, outside its travel of {} to {}: is it a program of another machine, or are offsets and tool lengths others?",
                    axis.name,
                    finely(q),
                    axis.kind.position_unit(),
                    shown(from),
                    shown(to)
                ));
            }
        }
        Ok(())
    }
}

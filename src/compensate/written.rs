//! Blocks as they are written: words that change, words that stay, and what the control then holds.

use super::block::{Block, Word};
use super::codes::{Motion, acts_at_the_end};
use super::modal::{FeedMode, LETTERS};
use super::path::{Path, Place};
use super::pieces::Piece;
use super::rewrite::{Changes, feed_number, number};
use super::state::{Compensator, Moving, Timing};

/// Feeds that differ by less are the same.
const SAME_FEED: f64 = 1e-4;
/// How many times faster than its move a block may be that takes lost motion up.
const MOST_FASTER: f64 = 2.0;

impl Compensator<'_> {
    /// Words for the axes that move; `said` are the letters that the block has.
    pub(super) fn axis_words(&mut self, command: &Place, said: impl Fn(u8) -> bool) -> Vec<(u8, String)> {
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
            let written = number(value, decimals);
            // increments add up on the control as they are written
            let rounded = written.parse::<f64>().map_or(value, |read| if is_angle { read } else { read * unit });
            self.sent[letter] = Some(match self.modal.is_absolute {
                Some(false) if before.is_finite() => before + rounded,
                _ => command[letter],
            });
            words.push((LETTERS[letter], written));
        }
        words
    }

    /// I, J, K of a piece that begins at a place; none where it is straight.
    fn centre_words(&self, piece: &Piece, before: &[Option<f64>; 9]) -> Vec<(u8, String)> {
        let Some(arc) = &piece.arc else { return Vec::new() };
        let unit = self.modal.unit_mm.unwrap_or(1.0);
        let decimals = self.settings.decimals[0] + if unit == 1.0 { 0 } else { 2 };
        let word = |k: usize| {
            let letter = arc.plane[k];
            let from = match self.modal.absolute_centres {
                true => self.offset(letter).unwrap_or(0.0),
                false => before[letter].unwrap_or(0.0),
            };
            (b"IJK"[letter], number((arc.centre[k] - from) / unit, decimals))
        };
        [0, 1].map(word).into()
    }

    /// The block itself with its words for the first piece.
    pub(super) fn first_piece(&mut self, moving: &Moving, piece: &Piece, is_cut: bool, out: &mut Vec<u8>) {
        let Moving { line, block, path, timing } = *moving;
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        let before = self.sent;
        let has = |letter: u8| block.words.iter().any(|word| word.letter == letter);
        let words = self.axis_words(&piece.command, has);
        let motion = motion_of(piece, timing);
        let centre = self.centre_words(piece, &before);
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
                    let own = centre.iter().find(|(other, _)| *other == word.letter);
                    let text = own.map_or_else(String::new, |(letter, value)| format!("{}{value}", *letter as char));
                    changes.replace(word.bytes.clone(), text);
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
        for (letter, value) in words.iter().chain(&centre).filter(|(letter, _)| !has(*letter)) {
            changes.put_after(&format!("{}{value}", *letter as char));
        }
        let last = block.words.last().map_or(0, |word| word.bytes.end);
        changes.write(line, block.after_number, last, out);
        self.changes = changes;
    }

    /// Mode and F of the first piece, where the control does not hold them.
    pub(super) fn tell_feed(
        &mut self,
        block: &Block,
        feed: Option<(FeedMode, f64)>,
        said_feed: bool,
        changes: &mut Changes,
    ) {
        let Some((mode, value)) = feed else { return self.follow(block) };
        if block.words.iter().any(is_feed_mode) || self.told.feed_mode != Some(mode) {
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
    pub(super) fn next_piece(&mut self, path: &Path, piece: &Piece, timing: Timing, out: &mut Vec<u8>) {
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
        let motion = motion_of(piece, timing);
        if !words.is_empty() && self.told.motion != Some(motion) {
            put(motion_word(motion));
            self.told.motion = Some(motion);
        }
        let centre = self.centre_words(piece, &before);
        for (letter, value) in words.iter().chain(&centre) {
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
    pub(super) fn feed_words(
        &self,
        path: &Path,
        piece: &Piece,
        before: &[Option<f64>; 9],
        timing: Timing,
    ) -> Option<(FeedMode, f64)> {
        let share = piece.share - piece.from_share;
        let from: Place = std::array::from_fn(|k| before[k].unwrap_or(path.from[k]));
        let way = Path { from, to: piece.command, arc: piece.arc };
        // lost motion is taken up at twice the speed of the move, not in no time
        let most = if self.corrector.memories.is_empty() { f64::INFINITY } else { MOST_FASTER };
        match timing {
            Timing::Rapid => None,
            Timing::Time(minutes) => {
                let faster = way.whole() / (share * path.whole()) / most;
                let longer = if faster.is_finite() { faster.max(1.0) } else { 1.0 };
                Some((FeedMode::InverseTime, 1.0 / (minutes * share * longer)))
            }
            Timing::Feed { mode, feed, length_mm } => {
                let ratio = (way.length_mm() / (share * length_mm)).min(most);
                let is_same = !ratio.is_finite() || (ratio - 1.0).abs() < SAME_FEED;
                Some((mode, if is_same { feed } else { feed * ratio }))
            }
        }
    }

    /// A block that stays.
    pub(super) fn pass(&mut self, line: &[u8], end: &[u8], block: &Block, out: &mut Vec<u8>) {
        let says_mode = block.words.iter().any(is_feed_mode);
        if !says_mode && block.words.iter().any(|word| word.letter != b'N' && word.letter != b'O') {
            self.restore_feed(if end.is_empty() { b"\n" } else { end }, out);
        }
        self.follow(block);
        out.extend_from_slice(line);
        out.extend_from_slice(end);
    }

    /// What the control holds after words that stay.
    pub(super) fn follow(&mut self, block: &Block) {
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
    pub(super) fn restore_feed(&mut self, end: &[u8], out: &mut Vec<u8>) {
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

fn is_feed_mode(word: &Word) -> bool {
    word.letter == b'G' && matches!(word.code(), Some(930 | 940 | 950))
}

fn motion_of(piece: &Piece, timing: Timing) -> Motion {
    match (timing, &piece.arc) {
        (Timing::Rapid, _) => Motion::Rapid,
        (_, None) => Motion::Line,
        (_, Some(arc)) if arc.sweep > 0.0 => Motion::Counter,
        _ => Motion::Clockwise,
    }
}

fn motion_word(motion: Motion) -> &'static str {
    match motion {
        Motion::Rapid => "G0",
        Motion::Clockwise => "G2",
        Motion::Counter => "G3",
        _ => "G1",
    }
}

/// Words that act at the end of the block, as written.
pub(super) fn late_words<'l>(line: &'l [u8], block: &Block) -> Vec<&'l [u8]> {
    let is_late = |word: &&Word| word.letter == b'M' && word.code().is_some_and(acts_at_the_end);
    block.words.iter().filter(is_late).map(|word| &line[word.bytes.clone()]).collect()
}

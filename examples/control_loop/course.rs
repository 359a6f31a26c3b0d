//! Where a corrected program asks the errorless machine to be: rows of its trace against the program as planned.

use std::path::Path;

use fiveaxis::machine::Machine;

use crate::plain_program::{LETTERS, Move, moves};

/// One degree of a rotary axis counts as this, mm: some 100 mm of lever.
const MM_PER_DEG: f64 = 1.75;
/// The control may already be on a neighbour of the move whose line it tells.
const NEIGHBOURS: usize = 4;
/// Pieces whose distances differ by less are as near, mm.
const AS_NEAR_MM: f64 = 1e-4;

/// How many times faster than its move a block is that takes lost motion up, and how closely a pace and a time are told by words.
const TAKES_UP: f64 = 2.0;
const SAME_PACE: f64 = 1e-2;
const SAME_TIME: f64 = 1e-5;

/// A program and the one that was made of it, whose N words say which moves belong together.
pub struct Course<'m> {
    machine: &'m Machine,
    planned: Vec<Move>,
    pieces: Vec<Piece>,
}

/// A move of the corrected program.
struct Piece {
    own: Move,
    /// Move of the planned program, and the shares of its time at both ends.
    of: usize,
    shares: [f64; 2],
}

/// A row of a trace and what it stands for.
pub struct Place {
    /// Positions of the program as planned, mm and rad.
    pub planned: Vec<f64>,
    /// Those of the corrected program.
    pub corrected: Vec<f64>,
}

impl<'m> Course<'m> {
    /// Reads both programs.
    pub fn new(machine: &'m Machine, planned: &Path, corrected: &Path) -> Course<'m> {
        let read = |file: &Path| read(&std::fs::read_to_string(file).expect("program"));
        let (planned, corrected) = (read(planned), read(corrected));
        let mut pieces = Vec::new();
        for blocks in corrected.chunk_by(|one, other| one.number == other.number) {
            let is_it = |other: &Move| other.number == blocks[0].number;
            let of = planned.iter().position(is_it).expect("a move of that number");
            let mut gone = 0.0;
            for (own, share) in blocks.iter().zip(shares(&planned[of], blocks)) {
                pieces.push(Piece { own: own.clone(), of, shares: [gone, gone + share] });
                gone += share;
            }
        }
        Course { machine, planned, pieces }
    }

    /// What positions of a trace stand for, by the line that the control told.
    pub fn place(&self, q: &[f64], line: usize) -> Place {
        let mut at = [0.0; 6];
        for (axis, q) in self.machine.axes.iter().zip(q) {
            at[letter(&axis.name)] = axis.kind.to_file_unit(*q);
        }
        let near = self.pieces.partition_point(|piece| piece.own.line < line);
        let (first, last) = (near.saturating_sub(NEIGHBOURS), (near + NEIGHBOURS).min(self.pieces.len() - 1));
        let near: Vec<_> = self.pieces[first..=last].iter().map(|piece| (piece, nearest(&piece.own, &at))).collect();
        let least = near.iter().map(|(_, (_, square))| *square).fold(f64::INFINITY, f64::min);
        // the way back of a mark lies on its way out: of pieces that are as near the line tells
        let as_near = near.into_iter().filter(|(_, (_, square))| square.sqrt() < least.sqrt() + AS_NEAR_MM);
        let (piece, (share, _)) = as_near.min_by_key(|(piece, _)| piece.own.line.abs_diff(line)).expect("pieces");
        let [begin, end] = piece.shares;
        Place {
            planned: positions(self.machine, &self.planned[piece.of].at(begin + share * (end - begin))),
            corrected: positions(self.machine, &piece.own.at(share)),
        }
    }
}

/// Which share of a planned move each of its blocks stands for: that of its time, but for blocks that take lost motion up or cross a
/// spike, which `compensate` writes twice as fast as the move and so longer than their share. These share what the others leave.
fn shares(planned: &Move, blocks: &[Move]) -> Vec<f64> {
    let whole: f64 = blocks.iter().map(|block| block.minutes).sum();
    if whole <= 0.0 {
        return vec![1.0; blocks.len()];
    }
    let pace = planned.way() / planned.minutes;
    let takes_up = |block: &&Move| (block.way() / block.minutes / (TAKES_UP * pace) - 1.0).abs() < SAME_PACE;
    if whole < planned.minutes * (1.0 + SAME_TIME) || !blocks.iter().any(|block| takes_up(&block)) {
        return blocks.iter().map(|block| block.minutes / whole).collect();
    }
    let taken_up: f64 = blocks.iter().filter(takes_up).map(|block| block.minutes).sum();
    let left = (1.0 - (whole - taken_up) / planned.minutes).max(0.0);
    let share = |block: &Move| match takes_up(&block) {
        true => left * block.minutes / taken_up,
        false => block.minutes / planned.minutes,
    };
    blocks.iter().map(share).collect()
}

/// Share of a move nearest to a place, and the squared distance.
fn nearest(own: &Move, at: &[f64; 6]) -> (f64, f64) {
    let weight = |k: usize| if k < 3 { 1.0 } else { MM_PER_DEG };
    let share = match own.arc {
        Some((plane, centre, sweep)) => {
            let angle = |place: &[f64; 6]| (place[plane[1]] - centre[1]).atan2(place[plane[0]] - centre[0]);
            let from_middle = angle(at) - angle(&own.from) - 0.5 * sweep;
            let turns = (from_middle / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            0.5 + (from_middle - turns) / sweep
        }
        None => {
            let way = |k: usize| weight(k) * (own.to[k] - own.from[k]);
            let square: f64 = (0..6).map(|k| way(k).powi(2)).sum();
            let along: f64 = (0..6).map(|k| way(k) * weight(k) * (at[k] - own.from[k])).sum();
            if square > 0.0 { along / square } else { 1.0 }
        }
    };
    let share = share.clamp(0.0, 1.0);
    let there = own.at(share);
    (share, (0..6).map(|k| (weight(k) * (at[k] - there[k])).powi(2)).sum())
}

/// Moves of a program whose work offset is zero.
pub fn read(text: &str) -> Vec<Move> {
    moves(text, [0.0; 6], [[0.0; 6]; 2], 0.0)
}

fn letter(name: &str) -> usize {
    LETTERS.find(name).expect("a letter")
}

/// Positions by axis index, mm and rad.
pub fn positions(machine: &Machine, place: &[f64; 6]) -> Vec<f64> {
    machine.axes.iter().map(|axis| axis.kind.from_file_unit(place[letter(&axis.name)])).collect()
}

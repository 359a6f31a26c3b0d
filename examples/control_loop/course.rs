//! Where a corrected program asks the errorless machine to be: rows of its trace against the program as planned.

use std::path::Path;

use fiveaxis::machine::{AxisKind, Machine};

use crate::plain_program::{LETTERS, Move, moves};

/// One radian of a rotary axis counts as this, mm.
const MM_PER_RAD: f64 = 100.0;
/// The control may already be on a neighbour of the move whose line it tells.
const NEIGHBOURS: usize = 4;

/// A program and the one that was made of it, whose N words say which moves belong together.
pub struct Course<'m> {
    machine: &'m Machine,
    planned: Vec<Move>,
    pieces: Vec<Piece>,
}

/// A straight move of the corrected program.
struct Piece {
    line: usize,
    from: Vec<f64>,
    to: Vec<f64>,
    /// Move of the planned program, and the shares of its time at both ends; `None`: the control drives there by itself.
    of: Option<(usize, f64, f64)>,
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
        let total = |number: u32| -> f64 {
            corrected.iter().filter(|piece| piece.number == number).map(|piece| piece.minutes).sum()
        };
        let mut pieces = Vec::new();
        let (mut number, mut gone, mut whole) = (u32::MAX, 0.0, 0.0);
        for piece in &corrected {
            assert!(piece.arc.is_none(), "line {}: an arc", piece.line);
            if piece.number != number {
                (number, gone, whole) = (piece.number, 0.0, total(piece.number));
            }
            let of = planned.iter().position(|other| other.number == number).expect("a move of that number");
            let shares = if whole > 0.0 { (gone / whole, (gone + piece.minutes) / whole) } else { (0.0, 1.0) };
            gone += piece.minutes;
            pieces.push(Piece {
                line: piece.line,
                from: positions(machine, &piece.from),
                to: positions(machine, &piece.to),
                of: Some((of, shares.0, shares.1)),
            });
        }
        Course { machine, planned, pieces }
    }

    /// What positions of a trace stand for, by the line that the control told.
    pub fn place(&self, q: &[f64], line: usize) -> Place {
        let near = self.pieces.partition_point(|piece| piece.line < line);
        let (first, last) = (near.saturating_sub(NEIGHBOURS), (near + NEIGHBOURS).min(self.pieces.len() - 1));
        let nearest = self.pieces[first..=last].iter().map(|piece| (piece, self.nearest(piece, q)));
        let (piece, (share, _)) = nearest.min_by(|a, b| a.1.1.total_cmp(&b.1.1)).expect("pieces");
        let corrected = (0..q.len()).map(|k| piece.from[k] + share * (piece.to[k] - piece.from[k])).collect();
        let planned = match piece.of {
            Some((number, begin, end)) => {
                positions(self.machine, &self.planned[number].at(begin + share * (end - begin)))
            }
            None => q.to_vec(),
        };
        Place { planned, corrected }
    }

    /// Share of a piece nearest to positions, and the squared distance.
    fn nearest(&self, piece: &Piece, q: &[f64]) -> (f64, f64) {
        let weight = |k: usize| if self.machine.axes[k].kind == AxisKind::Rotary { MM_PER_RAD } else { 1.0 };
        let way: Vec<f64> = (0..q.len()).map(|k| weight(k) * (piece.to[k] - piece.from[k])).collect();
        let gone: Vec<f64> = (0..q.len()).map(|k| weight(k) * (q[k] - piece.from[k])).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let square = product(&way, &way);
        let share = if square > 0.0 { (product(&way, &gone) / square).clamp(0.0, 1.0) } else { 1.0 };
        (share, gone.iter().zip(&way).map(|(gone, way)| (gone - share * way).powi(2)).sum())
    }
}

/// Moves of a program whose work offset is zero.
pub fn read(text: &str) -> Vec<Move> {
    moves(text, [0.0; 6], [[0.0; 6]; 2], 0.0)
}

/// Positions by axis index, mm and rad.
pub fn positions(machine: &Machine, place: &[f64; 6]) -> Vec<f64> {
    let of = |name: &str| place[LETTERS.find(name).expect("a letter")];
    machine.axes.iter().map(|axis| axis.kind.from_file_unit(of(&axis.name))).collect()
}

//! What the axes of a session did, as far as it says which shapes of an effect are worth trying. It names no effect.

use super::Context;
use crate::chain::{Branch, Geometry};
use crate::machine::AxisKind;
use std::f64::consts::TAU;

use crate::statistics::median;

/// Change of gravity's direction in a link from which it counts as turning there, in units of g.
const TURNED_G: f64 = 0.02;

/// Travel below which an axis has not moved, mm or rad.
const NO_TRAVEL: f64 = 1e-6;

/// Positions nearer than this are one, rad or mm: a hundredth of a degree.
const ONE_PLACE: f64 = 1.7e-4;

/// Coherence of positions with a grid of their median step, from 0 (none) to 1, from which they lie on it.
const ON_A_GRID: f64 = 0.5;

impl Context<'_> {
    /// Whether any test was recorded in time; static poses have none.
    pub fn has_sweeps(&self) -> bool {
        (0..self.tests()).any(|test| self.motion(test).time_s.is_some())
    }

    /// Whether an axis moves in any test.
    pub fn moves(&self, axis: usize) -> bool {
        (0..self.tests()).any(|test| self.motion(test).moving.contains(&axis))
    }

    /// Whether any slide moves in any test.
    pub fn slides_move(&self) -> bool {
        let axes = &self.machine().axes;
        (0..axes.len()).any(|axis| axes[axis].kind == AxisKind::Linear && self.moves(axis))
    }

    /// Smallest and largest position, mm or rad, that recordings reach with an axis in motion; `None` when it never moves.
    pub fn travelled(&self, axis: usize) -> Option<(f64, f64)> {
        let motions = (0..self.tests()).map(|test| self.motion(test)).filter(|motion| motion.moving.contains(&axis));
        let ends = motions
            .flat_map(|motion| motion.axis(axis))
            .fold(None, |ends: Option<(f64, f64)>, q| Some(ends.map_or((q, q), |(from, to)| (from.min(q), to.max(q)))));
        ends.filter(|(from, to)| to - from > NO_TRAVEL)
    }

    /// Smallest and largest position of an axis, standing or moving, mm or rad.
    pub fn visited(&self, axis: usize) -> (f64, f64) {
        (0..self.tests())
            .flat_map(|test| self.motion(test).axis(axis))
            .fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)))
    }

    /// Median distance of neighbouring positions of an axis in motion, mm or rad.
    pub(super) fn finest_step(&self, axis: usize) -> f64 {
        let motions = (0..self.tests()).map(|test| self.motion(test)).filter(|motion| motion.moving.contains(&axis));
        let steps = motions.flat_map(|motion| {
            let positions: Vec<f64> = motion.axis(axis).collect();
            positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect::<Vec<_>>()
        });
        median(steps).unwrap_or(1.0)
    }

    /// Whether the positions of an axis in motion lie on no grid: on one, a short period looks like a long one.
    pub(super) fn is_irregular(&self, axis: usize) -> bool {
        let motions = (0..self.tests()).map(|test| self.motion(test)).filter(|motion| motion.moving.contains(&axis));
        let mut places: Vec<f64> = motions.flat_map(|motion| motion.axis(axis).collect::<Vec<_>>()).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|one, other| (*one - *other).abs() < ONE_PLACE);
        let Some(step) = median(places.windows(2).map(|pair| pair[1] - pair[0])) else { return false };
        let sum = |part: fn(f64) -> f64| places.iter().map(|at| part(TAU * at / step)).sum::<f64>();
        sum(f64::cos).hypot(sum(f64::sin)) < ON_A_GRID * places.len() as f64
    }

    /// Number of different places at which an axis stands as tests begin, `apart` mm or rad from each other.
    pub(super) fn standing_places(&self, axis: usize, apart: f64) -> usize {
        let first = |test: usize| self.motion(test).axis(axis).next();
        let mut places: Vec<f64> = (0..self.tests()).filter_map(first).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|one, other| (*one - *other).abs() < apart);
        places.len()
    }

    /// Whether gravity changes its direction in the link that an axis carries, over the rows that `looked_at` picks by their number.
    pub(super) fn gravity_turns_in(&self, axis: usize, looked_at: impl Fn(usize) -> Vec<usize>) -> bool {
        let chain = self.chain();
        let geometry = Geometry::nominal(chain);
        let link = chain.carried_by(axis);
        let gravity = self.machine().gravity;
        let mut first = None;
        (0..self.tests()).any(|test| {
            let motion = self.motion(test);
            looked_at(motion.rows()).into_iter().any(|row| {
                let seen = geometry.pose(link, motion.row(row), None).rotation.transpose() * gravity;
                (seen - *first.get_or_insert(seen)).norm() > TURNED_G
            })
        })
    }

    /// Whether a slide is the one nearest to the spindle: there growth of the spindle shows.
    pub(super) fn is_last_before_spindle(&self, axis: usize) -> bool {
        let axes = &self.machine().axes;
        let branch = self.chain().branch(Branch::Tool);
        branch.iter().rev().find(|&&k| axes[k].kind == AxisKind::Linear) == Some(&axis)
    }

    /// Columns that every recording has, beside positions and readings, by their names.
    pub(super) fn common_channels(&self, is_wanted: fn(&str) -> bool) -> Vec<String> {
        let tests = &self.session().tests;
        let names = |index: usize| -> Vec<String> {
            let recording = tests.get(index).and_then(|test| test.recording.as_ref());
            let channels = recording.map(|recording| recording.channels.as_slice()).unwrap_or_default();
            channels.iter().map(|(name, _)| name.clone()).collect()
        };
        let in_all = |name: &String| (0..tests.len()).all(|test| names(test).contains(name));
        names(0).into_iter().filter(|name| is_wanted(name) && in_all(name)).collect()
    }
}

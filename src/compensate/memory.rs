//! Lost motion, play and reversal spikes along the commands of a program: the state that each has left, and what it makes of the
//! next command. It knows no programs.

use super::command::Positions;
use crate::disturbances::Remembered;
use crate::effects::{MemoryLaw, Past};
use crate::machine::{AxisKind, Machine};

/// Lever by which angular errors count, mm.
pub const LEVER_MM: f64 = 300.0;
/// Moves below this are none, mm or rad.
const STANDSTILL: f64 = 1e-7;
/// Of a tolerance: a reversal shorter than this waits until it is longer, so that rounding makes no axis turn back.
const WAITS: f64 = 0.12;
/// Of a tolerance: what is still to be taken up counts above this.
const COUNTS: f64 = 0.1;
/// Of the travel over which a law changes, one piece goes over this much at most.
const OF_TRAVEL: f64 = 0.7;
/// Least motion of a part per motion of its command by which a Newton step is divided.
const LEAST_SHARE: f64 = 0.1;

/// What an axis is asked to do next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Next {
    Stands,
    /// Turns back by so little that it waits.
    Waits,
    /// Goes in this sense of its mechanism, −1 or 1.
    Goes(f64),
}

#[derive(Debug, Clone)]
struct One {
    what: Remembered,
    past: Past,
    /// Where its axis was sent to, mm or rad; unknown before its first place and after a move that is not known.
    at: Option<f64>,
    next: Next,
}

/// How far a Newton search is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// With the errors of the past.
    Past,
    /// With those after a long way, which is a start.
    Settled,
    /// With those after the way itself.
    Way,
}

/// All effects with memory of a machine.
#[derive(Debug, Clone, Default)]
pub struct Memories {
    list: Vec<One>,
    /// Tolerance of the tip, mm.
    tolerance_mm: f64,
}

impl Memories {
    /// In the middle of their play: where a program finds them is not known.
    pub fn new(remembered: Vec<Remembered>, tolerance_mm: f64) -> Memories {
        let one = |what| One { what, past: Past::default(), at: None, next: Next::Stands };
        Memories { list: remembered.into_iter().map(one).collect(), tolerance_mm }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Leaves out reversal spikes; whether there were any. In coordinates of the workpiece rounded words let slides tremble, and each
    /// turn would bring a spike.
    pub fn without_spikes(&mut self) -> bool {
        let before = self.list.len();
        self.list.retain(|one| !matches!(one.what.law, MemoryLaw::Spike { .. }));
        self.list.len() < before
    }

    /// Axes that have not moved yet, so that the flank on which they stand is not known, by index, where that leaves more than the
    /// tolerance open; with what stands open to either side: the largest length, mm, and angle, rad.
    pub fn unknown_flanks(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let open = self.list.iter().filter(|one| {
            matches!(one.what.law, MemoryLaw::LostMotion { .. })
                && one.past.direction == 0.0
                && one.size_mm() > self.tolerance_mm
        });
        open.map(|one| (one.what.driving, [most(&one.what.sizes[..3]), most(&one.what.sizes[3..])]))
    }

    /// Axes whose ways drive them, by index.
    pub fn driving(&self) -> impl Iterator<Item = usize> + '_ {
        self.list.iter().map(|one| one.what.driving)
    }

    /// An axis moves in a way that is not known: it may stand on either flank then.
    pub fn forget(&mut self, axis: usize) {
        for one in self.list.iter_mut().filter(|one| one.what.driving == axis) {
            (one.past, one.at) = (Past::default(), None);
        }
    }

    /// An axis was sent to a place, mm or rad.
    pub fn went(&mut self, axis: usize, to: f64) {
        for one in self.list.iter_mut().filter(|one| one.what.driving == axis) {
            if let Some(at) = one.at {
                one.what.law.advance(&mut one.past, one.what.sign * (to - at));
            }
            one.at = Some(to);
        }
    }

    /// Asks what every axis has to do to come to positions; whether that changes any error.
    pub fn ask(&mut self, machine: &Machine, positions: &Positions) -> bool {
        let mut changes = false;
        for one in &mut self.list {
            let way = one.way(positions);
            let lever = if machine.axes[one.what.driving].kind == AxisKind::Rotary { LEVER_MM } else { 1.0 };
            let direction = way.signum();
            one.next = match way.abs() {
                none if none <= STANDSTILL => Next::Stands,
                little if one.past.direction * direction < 0.0 && little * lever < WAITS * self.tolerance_mm => {
                    Next::Waits
                }
                _ => Next::Goes(direction),
            };
            changes |= match one.next {
                Next::Stands => false,
                Next::Waits => true,
                Next::Goes(direction) => one.to_come_mm(direction) > 1e-3 * COUNTS * self.tolerance_mm,
            };
        }
        changes
    }

    /// Adds the component errors at positions, by axis.
    pub fn add(&self, search: Search, positions: &Positions, errors: &mut [[f64; 6]]) {
        for one in &self.list {
            let value = one.what.law.value(&one.then(search, positions));
            errors[one.what.axis].iter_mut().zip(&one.what.sizes).for_each(|(sum, size)| *sum += size * value);
        }
    }

    /// Adds those after the way to positions, whatever was asked.
    pub fn add_driven(&self, positions: &Positions, errors: &mut [[f64; 6]]) {
        for one in &self.list {
            let mut past = one.past;
            one.what.law.advance(&mut past, one.way(positions));
            let value = one.what.law.value(&past);
            errors[one.what.axis].iter_mut().zip(&one.what.sizes).for_each(|(sum, size)| *sum += size * value);
        }
    }

    /// Motion of an axis's part per motion of its command.
    pub fn share(&self, search: Search, axis: usize, positions: &Positions) -> f64 {
        let mut share = 1.0;
        for one in self.list.iter().filter(|one| one.what.driving == axis && one.what.own != 0.0) {
            if search == Search::Way && matches!(one.next, Next::Goes(_)) {
                share += one.what.own * one.what.law.slope(&one.then(search, positions));
            }
        }
        share.max(LEAST_SHARE)
    }

    /// Where the commands of axes can lie that owe something to their own ways, about a start.
    pub fn brackets(&self, start: &Positions) -> Brackets {
        let mut brackets = Brackets::default();
        for one in self.list.iter().filter(|one| one.what.own != 0.0) {
            let axis = one.what.driving;
            let [low, high] = brackets.ends[axis].unwrap_or([start[axis] - TRIED_BEYOND, start[axis] + TRIED_BEYOND]);
            let reach = TRIED_TO_EITHER_SIDE * one.what.own.abs();
            brackets.ends[axis] = Some([low - reach, high + reach]);
        }
        brackets
    }

    /// Puts axes that wait back to where they stand.
    pub fn keep_waiting(&self, positions: &mut Positions) {
        for one in self.list.iter().filter(|one| one.next == Next::Waits) {
            positions[one.what.driving] = one.at.unwrap_or(positions[one.what.driving]);
        }
    }

    /// Share of the way between two positions that one piece may go: over what is to be taken up it is short. 1 and more: all of it.
    pub fn reach(&self, from: &Positions, to: &Positions) -> f64 {
        let mut reach = f64::INFINITY;
        for one in &self.list {
            let way = one.what.sign * (to[one.what.driving] - from[one.what.driving]);
            let travel = one.what.law.next_travel(&one.past, way.signum());
            let counts = way.abs() > STANDSTILL && travel > 0.0;
            if counts && one.to_come_mm(way.signum()) > COUNTS * self.tolerance_mm {
                reach = reach.min(OF_TRAVEL * travel / way.abs());
            }
        }
        reach
    }
}

/// Ends between which a search for a command stays, by axis: what ways have left is one size to either side at most, and a step where a
/// part hardly moves with its command would else be far too long.
#[derive(Debug, Clone, Copy, Default)]
pub struct Brackets {
    ends: [Option<[f64; 2]>; 9],
}

/// Sizes of what is left, to either side, and a little, mm or rad.
const TRIED_TO_EITHER_SIDE: f64 = 2.2;
const TRIED_BEYOND: f64 = 1e-4;

impl Brackets {
    /// The next position of an axis after a step for a part that moves by a share of its command; halfway where the step leaves the bracket.
    pub fn next(&mut self, search: Search, axis: usize, at: f64, (step, share): (f64, f64)) -> f64 {
        let next = at + step / share;
        let Some([low, high]) = &mut self.ends[axis] else { return next };
        if search == Search::Way {
            *(if step > 0.0 { &mut *low } else { &mut *high }) = at;
        }
        if next >= *low && next <= *high { next } else { 0.5 * (*low + *high) }
    }
}

impl One {
    /// Way of the mechanism to positions, mm or rad.
    fn way(&self, positions: &Positions) -> f64 {
        self.at.map_or(0.0, |at| self.what.sign * (positions[self.what.driving] - at))
    }

    /// The past as a search sees it at positions.
    fn then(&self, search: Search, positions: &Positions) -> Past {
        let (law, mut past) = (&self.what.law, self.past);
        match (search, self.next) {
            (Search::Settled, Next::Goes(direction)) => law.settled(direction),
            (Search::Way, Next::Goes(direction)) => {
                // it has turned, however short the way
                let way = (direction * self.way(positions)).max(2.0 * STANDSTILL);
                law.advance(&mut past, direction * way);
                past
            }
            _ => past,
        }
    }

    /// How far the errors still change on a long way in a sense, at a lever, mm.
    fn to_come_mm(&self, direction: f64) -> f64 {
        self.size_mm() * self.what.law.to_come(&self.past, direction)
    }

    /// Size per unit of the law's value, angles at a lever, mm.
    fn size_mm(&self) -> f64 {
        most(&self.what.sizes[..3]).max(LEVER_MM * most(&self.what.sizes[3..]))
    }
}

fn most(sizes: &[f64]) -> f64 {
    sizes.iter().fold(0.0f64, |most, size| most.max(size.abs()))
}

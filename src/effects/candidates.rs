//! What a search tries of an effect: where, through which outlets, over which grid of shapes, against which odds. It judges
//! nothing; what each effect says of itself stands in its own file.

use super::Context;
use super::context::SAME_BAR_MM;
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};
use crate::readings::{Kind, Part};
use crate::session::Setups;
use std::f64::consts::TAU;

/// What effects go by to say which shapes of them to try in a session.
pub struct Observations<'a> {
    /// What the axes did.
    pub context: &'a Context<'a>,
    /// Which tests share balls and bars.
    pub setups: &'a Setups,
    /// Lines of the residuals' spectrum over time, Hz, the most prominent first, and what they may be aliases of.
    pub lines_hz: Vec<f64>,
    /// By axis, the loudest ripples of the residuals along its positions that wander with time.
    pub ripples: Vec<Vec<Ripple>>,
    /// By test, session times of the largest jumps of its residual, s.
    pub jumps_s: Vec<Vec<f64>>,
}

/// A ripple along an axis: phase per mm or rad, and frequency with which it beats, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ripple {
    pub per_unit: f64,
    pub hz: f64,
    /// Lowest frequency that is no mere drift of a ripple, Hz.
    pub least_hz: f64,
}

impl<'a> Observations<'a> {
    /// The machine.
    pub fn machine(&self) -> &Machine {
        self.context.machine()
    }

    /// Axes of a kind.
    pub fn axes(&self, kind: AxisKind) -> impl Iterator<Item = usize> + '_ {
        let axes = &self.machine().axes;
        (0..axes.len()).filter(move |&axis| axes[axis].kind == kind)
    }

    /// Axes of a kind that move in a test, with the smallest and largest position that they reach in motion, mm or rad.
    pub fn moving(&self, kind: AxisKind) -> impl Iterator<Item = (usize, (f64, f64))> + '_ {
        self.axes(kind).filter_map(|axis| Some((axis, self.context.travelled(axis)?)))
    }

    /// Rotary axes that turn round in sessions with displacement sensors.
    pub fn under_sensors(&self) -> impl Iterator<Item = usize> + '_ {
        let is_displacement = |part: &Part| part.kind == Kind::Displacement;
        let tests = &self.context.session().tests;
        let is_seen = tests.iter().any(|test| test.reading.part().is_some_and(is_displacement));
        let turning = self.moving(AxisKind::Rotary).filter(|(_, (from, to))| to - from > TAU);
        turning.filter(move |_| is_seen).map(|(axis, _)| axis)
    }

    /// Slides that were at different places, whether in a test or from test to test, with the ends of their way, mm.
    pub fn displaced_slides(&self) -> impl Iterator<Item = (usize, (f64, f64))> + '_ {
        let ways = self.axes(AxisKind::Linear).map(|axis| (axis, self.context.visited(axis)));
        ways.filter(|(_, (from, to))| to - from > LEAST_WAY_MM)
    }

    /// Tests in which an axis moves.
    pub fn tests_moving(&self, axis: usize) -> Vec<usize> {
        (0..self.context.tests()).filter(|&test| self.context.motion(test).moving.contains(&axis)).collect()
    }

    /// Lengths of the bars, mm, each once.
    pub fn bars_mm(&self) -> Vec<f64> {
        let tests = &self.context.session().tests;
        let bars = self.setups.bars.iter().filter_map(|bar| tests[bar.first_test].bar_length_mm);
        let mut lengths: Vec<f64> = bars.collect();
        lengths.sort_by(f64::total_cmp);
        lengths.dedup_by(|one, other| (*one - *other).abs() < SAME_BAR_MM);
        lengths
    }

    /// End of the last test, s since the session began.
    pub fn latest_s(&self) -> f64 {
        (0..self.context.tests()).map(|test| self.context.ends_at_s(test)).fold(0.0, f64::max)
    }
}

/// Way of a slide over a session below which it has stood, mm.
const LEAST_WAY_MM: f64 = 1.0;

/// Probability that a cause is there, at a place where it can be, at a size that matters: before any reading, for causes that
/// are common.
pub const PRESENT: f64 = 0.05;

/// Probability that what a cause explains comes from one that no candidate describes: of 130 causes told as proven and without
/// a rival on the seeds 626262, 919293, 454545 and 565656 of the blind trial, 3 were another.
const UNLISTED: f64 = 0.02;

/// Probability that what no form describes is no curve over one driver at one place either, where such a curve follows it best: 38 of 75
/// curves that the sessions of two outside examiners led to stood elsewhere.
pub const UNLISTED_BY_CURVES: f64 = 0.5;

/// Probability that the name which explains the readings best is the cause, whatever no candidate describes.
pub const DESCRIBED_BY_NAME: f64 = 1.0 - UNLISTED;

/// The same of a free curve.
pub const DESCRIBED_BY_CURVE: f64 = 1.0 - UNLISTED_BY_CURVES;

/// Candidates that differ only in shape: one kind of effect at one place through some outlets.
#[derive(Debug, Clone)]
pub struct CandidateFamily {
    pub kind: &'static str,
    pub place: Place,
    pub outlets: Vec<Outlet>,
    /// Shapes on the grid; without any there is nothing to try.
    pub grid: Vec<Effect>,
    /// Shape parameters that are refined.
    pub refined: Vec<Refined>,
    /// Amplitudes up to this are plausible, display units: the widest amplitude prior that is tried.
    pub plausible: f64,
    /// The largest size through its first outlet that it can have, display units: a larger one is something else.
    pub most: f64,
    /// It weighs against others and is not told itself: as much of it may be a gauge whose zero wanders.
    pub only_rival: bool,
    /// Tests that have amplitudes of their own, by number: the phase of a free-running source is not kept from test to test. Empty:
    /// all tests share them.
    pub by_test: Vec<usize>,
    /// Names of the effect's functions that take part; empty: all.
    pub functions: &'static [&'static str],
    /// Outlets through which a function acts, where not every one acts through all.
    pub pairs: Vec<(Outlet, &'static str)>,
    /// It changes from row to row: it is judged on all rows, the others on averaged ones.
    pub fast: bool,
    /// Its shape has parts that averaged rows do not show: found on averages, it is refined on all rows.
    pub turns_within_rows: bool,
    /// Log odds against it before the readings speak, beside causes that are common.
    pub rarity: f64,
    /// Rank among names for the same trace: the lowest is the customary one.
    pub rank: usize,
    /// Standard deviation of its size by the machine file's budget, display units; `None`: the budget says nothing of it, and it
    /// is there with the probability [`PRESENT`].
    pub budget: Option<f64>,
}

/// A shape parameter to refine.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    pub name: &'static str,
    /// Smallest and largest value, and first step, in units of the library.
    pub least: f64,
    pub most: f64,
    pub step: f64,
    /// Element of a list parameter; `None` for a number.
    pub element: Option<usize>,
}

impl Refined {
    /// A number.
    pub(super) fn number(name: &'static str, (least, most): (f64, f64), step: f64) -> Refined {
        Refined { name, least, most, step, element: None }
    }

    /// An element of a list.
    pub(super) fn element(name: &'static str, element: usize, (least, most): (f64, f64), step: f64) -> Refined {
        Refined { name, least, most, step, element: Some(element) }
    }
}

impl CandidateFamily {
    /// One shape without parameters.
    pub(super) fn new(kind: &'static str, place: Place, outlets: Vec<Outlet>, plausible: f64) -> CandidateFamily {
        CandidateFamily {
            kind,
            place,
            outlets,
            grid: vec![Effect::new(kind, place)],
            refined: Vec::new(),
            plausible,
            most: f64::INFINITY,
            only_rival: false,
            by_test: Vec::new(),
            functions: &[],
            pairs: Vec::new(),
            fast: false,
            turns_within_rows: false,
            rarity: 0.0,
            rank: 0,
            budget: None,
        }
    }

    pub(super) fn over(mut self, grid: Vec<Effect>) -> CandidateFamily {
        self.grid = grid;
        self
    }

    /// As a rival alone.
    pub(super) fn only_as_rival(mut self) -> CandidateFamily {
        self.only_rival = true;
        self
    }

    /// No larger than this through its first outlet.
    pub(super) fn at_most(mut self, most: f64) -> CandidateFamily {
        self.most = most;
        self
    }

    /// With amplitudes of their own in these tests.
    pub(super) fn by_test(mut self, tests: Vec<usize>) -> CandidateFamily {
        self.by_test = tests;
        self
    }

    pub(super) fn fast(mut self) -> CandidateFamily {
        self.fast = true;
        self
    }

    /// Found on averaged rows and refined on all: what turns round at reversals does so within some rows.
    pub(super) fn turning_within_rows(mut self) -> CandidateFamily {
        self.turns_within_rows = true;
        self
    }

    pub(super) fn refine(mut self, refined: Vec<Refined>) -> CandidateFamily {
        self.refined = refined;
        self
    }

    pub(super) fn rare(mut self, rarity: f64) -> CandidateFamily {
        self.rarity = rarity;
        self
    }

    pub(super) fn within(mut self, budget: f64) -> CandidateFamily {
        self.budget = Some(budget);
        self
    }

    pub(super) fn ranked(mut self, rank: usize) -> CandidateFamily {
        self.rank = rank;
        self
    }
}

/// Amplitudes up to this are plausible for an arm, µm or arcsec: arms of a metre sag by some hundreds of them, a torso that carries two
/// arms by thousands. How large the amplitudes of a block are is for its evidence to say.
pub(super) const PLAUSIBLE_OF_ARMS: f64 = 3000.0;

/// An effect that is not looked for.
pub(super) fn none(_seen: &Observations) -> Vec<CandidateFamily> {
    Vec::new()
}

/// An effect with one stated number.
pub(super) fn with_number(kind: &str, place: Place, name: &str, value: f64) -> Effect {
    Effect::new(kind, place).with(name, ParameterValue::Number(value))
}

/// An effect with one stated list.
pub(super) fn with_list(kind: &str, place: Place, name: &str, values: Vec<f64>) -> Effect {
    Effect::new(kind, place).with(name, ParameterValue::List(values))
}

/// An effect with one stated word.
pub(super) fn with_word(kind: &str, place: Place, name: &str, word: &str) -> Effect {
    Effect::new(kind, place).with(name, ParameterValue::Word(word.into()))
}

/// Rows of a session that are looked at to see what turns in an arm.
const LOOKED_AT: usize = 50;

/// Some rows of so many, evenly.
pub(super) fn some_rows(rows: usize) -> Vec<usize> {
    (0..rows).step_by((rows / LOOKED_AT).max(1)).collect()
}

/// Components across and along the nearest coordinate direction of an axis, and tilts about what is across.
pub(super) struct Directions {
    pub across: [Component; 2],
    pub along: Component,
    pub tilts: [Component; 2],
}

pub(super) fn directions(machine: &Machine, axis: usize) -> Directions {
    let k = machine.axes[axis].own_component().direction_index();
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    Directions {
        across: [Component::ALL[i], Component::ALL[j]],
        along: Component::ALL[k],
        tilts: [Component::ALL[i + 3], Component::ALL[j + 3]],
    }
}

/// Every component of a slide that is not its own motion, one by one: across it, its tilts, its roll.
pub(super) fn beside_own(machine: &Machine, axis: usize) -> [Component; 5] {
    let d = directions(machine, axis);
    [d.across[0], d.across[1], d.tilts[0], d.tilts[1], Component::ALL[d.along.index() + 3]]
}

/// Motion outlets of an axis for some components.
pub(super) fn motion(axis: usize, components: &[Component]) -> Vec<Outlet> {
    components.iter().map(|&component| Outlet::Motion { axis, component }).collect()
}

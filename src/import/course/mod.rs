//! The run of a planned pair of tests as a gauge would read it: lengths along it, and what errors may add. It knows no readings.

mod forms;
mod lost_motion;
mod table;

use std::f64::consts::TAU;
use std::sync::{Arc, LazyLock};

use self::forms::principal_forms;
use self::lost_motion::LostMotion;
pub(super) use self::lost_motion::Stretch;
use self::table::Table;
use super::error::ImportError;
use crate::chain::{Chain, Poses};
use crate::identify::{FreePrior, Problem, default_free, parse_free, unknowns};
use crate::machine::{AxisKind, Machine};
use crate::plan::beyond_path;
use crate::session::{Marks, Motion, Path, Session, Setups, Test};

/// Two tests of a session that one program runs: the same path there and back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// Indices of the tests in the order in which they run.
    pub tests: [usize; 2],
}

/// Pairs of neighbouring tests whose paths are each other's reverse, with the same balls, bar, feed and standing axes.
pub fn pairs(session: &Session) -> Vec<Pair> {
    let is_back = |one: &Test, other: &Test| match (&one.path, &other.path) {
        (Some(there), Some(back)) => {
            let [from, to] = there.ends();
            there.between(to, from) == *back
                && (&one.pivot, &one.spindle_ball, &one.positions)
                    == (&other.pivot, &other.spindle_ball, &other.positions)
                && (one.bar_length_mm, &one.bar_setup, one.feed_mm_per_min)
                    == (other.bar_length_mm, &other.bar_setup, other.feed_mm_per_min)
        }
        _ => false,
    };
    (1..session.tests.len())
        .filter(|&back| is_back(&session.tests[back - 1], &session.tests[back]))
        .map(|back| Pair { tests: [back - 1, back] })
        .collect()
}

/// Which feeds a search thinks possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feeds {
    /// As programmed, within a tenth: controls keep the feed of one axis and of arcs.
    Programmed,
    /// From an eighth to seven tenths more: an override, or blocks too short for the control's look-ahead (seen at 0.16 to 0.33).
    Any,
}

impl Feeds {
    /// Least and greatest speed over the programmed feed.
    pub(super) fn range(self) -> [f64; 2] {
        match self {
            Feeds::Programmed => [0.9, 1.1],
            Feeds::Any => [0.12, 1.7],
        }
    }

    /// Standard deviation of the speed's logarithm before the search.
    pub(super) fn sigma(self) -> f64 {
        match self {
            Feeds::Programmed => 0.02,
            Feeds::Any => 0.7,
        }
    }
}

/// Readings along one direction's run, run-in and run-out included, at even steps of the path.
#[derive(Debug, Clone)]
pub struct Course {
    /// Programmed time of the whole run, s.
    pub run_s: f64,
    /// Programmed times at which the arc begins and ends, s.
    pub arc_s: [f64; 2],
    /// Path at the first and the last node, deg or mm of the path.
    pub ends: [f64; 2],
    /// Unit of the path, as messages write it.
    pub unit: &'static str,
    /// Feeds that are thought possible.
    pub feeds: Feeds,
    /// Marks that the program makes, if any.
    pub marks: Option<Marks>,
    /// By node, mm: nominal length; what a lag of one second adds to it at the programmed feed beside a delay, which cuts corners
    /// and shrinks circles by `½τ²q̈`, as its square; forms that errors of balls, bar and axes may add at one standard deviation.
    read_mm: Table,
    /// Forms that lost motion may add: worked out once asked for, as most tests that a capture is held against are not its own.
    pub(super) lost_motion: Arc<LazyLock<LostMotion, Lazily>>,
    /// At even programmed times: node with its fraction, sine and cosine of the share of the run's time as an angle.
    at_time: Table,
    /// Positions of all axes, node by node, mm or rad.
    motion: Motion,
}

type Lazily = Box<dyn FnOnce() -> LostMotion + Send>;

/// Nodes of a run: a quarter of a degree of a whole turn, whose cubic has a nanometre on a radius of 200 mm.
const NODES: usize = 1440;
/// Location errors that a machine may have before it was ever measured: 0.1 mm and 0.02°.
const LOCATION: FreePrior = FreePrior { length_mm: 0.1, angle_rad: 3.5e-4 };
/// Components smaller than this are below what a gauge reads, mm.
const LEAST_MM: f64 = 2e-5;
/// Components kept at most: a sweep of one axis has seven, its harmonics up to the third.
const MOST_COMPONENTS: usize = 10;

impl Course {
    /// The run of the first test of a pair.
    pub fn of(session: &Session, pair: Pair, feeds: Feeds) -> Result<Course, ImportError> {
        let machine = &session.machine;
        let chain = Chain::of(machine);
        let mut test = session.tests[pair.tests[0]].clone();
        test.recording = None;
        let Some(path) = test.path.clone() else { return Err(ImportError::NoPath { test: test.name }) };
        let arc = Motion::of(session, &chain, &test)?;
        let [before, after] = beyond_path(machine, &test, &arc).unwrap_or([0.0, 0.0]);
        let [from, to] = path.ends();
        let way = (to - from).signum();
        let ends = [from - way * before, to + way * after];
        test.path = Some(path.between(ends[0], ends[1]).in_steps(NODES as f64));
        let alone = Session { tests: vec![test.clone()], ..session.clone() };
        let motion = Motion::of(&alone, &chain, &test)?;
        let time_s = motion.time_s.clone().unwrap_or_default();
        let run_s = time_s.last().copied().unwrap_or(0.0);
        if run_s <= 0.0 {
            return Err(ImportError::NoPath { test: test.name });
        }
        let read_mm = read_along(&alone, &chain, machine)?;
        let times = Table::of_columns(&[time_s.as_slice()]);
        let at = |value: f64| {
            let node = (value - ends[0]) / (ends[1] - ends[0]) * (time_s.len() - 1) as f64;
            times.between(node).value(0)
        };
        let marks = test.marks;
        let along = motion.clone();
        let lost_motion: Lazily = Box::new(move || LostMotion::of(&alone.machine, &test, &along));
        Ok(Course {
            run_s,
            arc_s: [at(from), at(to)],
            ends,
            unit: match path {
                Path::Sweep { axis, .. } if machine.axes[axis].kind == AxisKind::Linear => " mm",
                _ => "°",
            },
            feeds,
            marks,
            read_mm,
            lost_motion: Arc::new(LazyLock::new(lost_motion)),
            at_time: at_times(&time_s),
            motion,
        })
    }

    /// Node, with its fraction, at a programmed time, and sine and cosine of the share of the run's time as an angle.
    pub(super) fn node_and_angle(&self, gone_s: f64) -> [f64; 3] {
        let at = (gone_s / self.run_s).clamp(0.0, 1.0) * (self.at_time.rows() - 1) as f64;
        let found = self.at_time.between(at);
        [0, 1, 2].map(|column| found.value(column))
    }

    fn node(&self, gone_s: f64) -> f64 {
        self.node_and_angle(gone_s)[0]
    }

    /// Nominal length at a node, and what a lag of one second cuts off it, mm; the forms that errors may add are written into `forms`.
    pub(super) fn read_at(&self, node: f64, forms: &mut [f64]) -> [f64; 2] {
        let found = self.read_mm.between(node);
        found.write(2, forms);
        [found.value(0), found.value(1)]
    }

    /// Nominal length in the middle of the run, mm.
    pub(super) fn middle_mm(&self) -> f64 {
        self.read_mm.between(0.5 * (self.read_mm.rows() - 1) as f64).value(0)
    }

    /// Number of forms that errors of balls, bar and axes may add.
    pub(super) fn components(&self) -> usize {
        self.read_mm.columns() - 2
    }

    /// Path per programmed second in the middle of the run, deg/s or mm/s.
    pub fn rate(&self) -> f64 {
        (self.ends[1] - self.ends[0]).abs() / self.run_s
    }

    /// Axes that move.
    pub fn moving(&self) -> &[usize] {
        &self.motion.moving
    }

    /// Position of an axis at a programmed time, mm or rad: a cubic through four nodes.
    pub fn position(&self, axis: usize, gone_s: f64) -> f64 {
        let node = self.node(gone_s);
        let rows = self.motion.rows();
        let first = (node as usize).saturating_sub(1).min(rows.saturating_sub(4));
        let x = node - first as f64;
        let q = |k: usize| self.motion.row(first + k)[axis];
        q(0) * (x - 1.0) * (x - 2.0) * (x - 3.0) / -6.0
            + q(1) * x * (x - 2.0) * (x - 3.0) / 2.0
            + q(2) * x * (x - 1.0) * (x - 3.0) / -2.0
            + q(3) * x * (x - 1.0) * (x - 2.0) / 6.0
    }
}

/// See [`Course::at_time`], at as many even times as there are nodes.
fn at_times(time_s: &[f64]) -> Table {
    let (last, whole) = (time_s.len() - 1, time_s[time_s.len() - 1]);
    let mut before = 0;
    let nodes: Vec<f64> = (0..=last)
        .map(|k| {
            let at = whole * k as f64 / last as f64;
            while before + 1 < last && time_s[before + 1] < at {
                before += 1;
            }
            let step = (time_s[before + 1] - time_s[before]).max(1e-12);
            before as f64 + ((at - time_s[before]) / step).clamp(0.0, 1.0)
        })
        .collect();
    let angles = || (0..=last).map(|k| TAU * k as f64 / last as f64);
    Table::of_columns(&[nodes, angles().map(f64::sin).collect(), angles().map(f64::cos).collect()])
}

/// Lag at which the cut corners are computed, s: small beside a run, and its µm are far above rounding.
const CUT_LAG_S: f64 = 0.1;

/// See [`Course::read_mm`]; the forms that errors may add are the principal ones.
fn read_along(session: &Session, chain: &Chain, machine: &Machine) -> Result<Table, ImportError> {
    let setups = Setups::of(session);
    // slides out of square draw once-a-turn forms where they follow
    let free = parse_free("all", machine).unwrap_or_else(|_| default_free(machine));
    let list = unknowns(session, &setups, &free, LOCATION);
    let mut problem = Problem::new(session, chain, &setups, list)?;
    let rows = problem.tests[0].motion.rows();
    problem.tests[0].reading_mm = vec![0.0; rows];
    let values: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let prediction = problem.predict(0, &problem.geometry(&values), &values);
    let mut columns = prediction.jacobian;
    for (k, &index) in problem.tests[0].columns.iter().enumerate() {
        columns.column_mut(k).scale_mut(problem.unknowns[index].prior_sigma);
    }
    let length_mm: Vec<f64> = prediction.residual_mm.iter().map(|off| -off).collect();
    let motion = cut_by_lag(&problem.tests[0].motion);
    problem.tests[0].poses = Poses::from_rows(motion.axis_count, &motion.positions).with_sines(chain);
    problem.tests[0].motion = motion;
    let cut = problem.predict(0, &problem.geometry(&values), &values);
    let cut_mm = cut.residual_mm.iter().zip(&length_mm).map(|(off, length)| (-off - length) / CUT_LAG_S.powi(2));
    let cut_mm: Vec<f64> = cut_mm.collect();
    let columns: Vec<Vec<f64>> =
        [length_mm, cut_mm].into_iter().chain(principal_forms(&columns, (MOST_COMPONENTS, LEAST_MM))).collect();
    Ok(Table::of_columns(&columns))
}

/// A motion whose axes lag by [`CUT_LAG_S`], but for the delay.
fn cut_by_lag(motion: &Motion) -> Motion {
    let mut cut = motion.clone();
    let (Some(time_s), rows) = (&motion.time_s, motion.rows()) else { return cut };
    for row in 0..if rows > 2 { rows } else { 0 } {
        let middle = row.clamp(1, rows - 2);
        let [before, after] = [time_s[middle] - time_s[middle - 1], time_s[middle + 1] - time_s[middle]];
        for axis in 0..motion.axis_count {
            let [a, b, c] = [middle - 1, middle, middle + 1].map(|row| motion.row(row)[axis]);
            let acceleration = 2.0 * ((c - b) / after - (b - a) / before) / (before + after);
            cut.positions[row * motion.axis_count + axis] += 0.5 * CUT_LAG_S.powi(2) * acceleration;
        }
    }
    cut
}

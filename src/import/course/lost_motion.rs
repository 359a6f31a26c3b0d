//! What lost motion of the axes that move may add to the readings of a program, as forms each at one standard deviation. It knows no
//! readings and no timing.
//!
//! An axis that turns round is displaced and tilted to the other side: `L = Σ s·w·∂L/∂E`, E the component errors of the axis, s
//! their sizes of mean zero, w the flank, which follows the commands as `w' = 2v/d` from −1 to 1. The flank at first is unknown.
//! d is one of several travels: sums of such flanks are the Prandtl–Ishlinskii model of a lost motion that is taken up the slower the
//! farther the way, elastic wind-up among it. Of all columns the principal ones are kept: they have the same covariance.

use nalgebra::DMatrix;

use super::forms::principal_forms;
use super::table::Table;
use crate::chain::{Chain, Geometry, Sensitivity};
use crate::effects::{MemoryLaw, Past};
use crate::machine::{AxisKind, Component, LinearClass, Machine, Outlet};
use crate::session::{Motion, Test, marked};
use crate::statistics::mean;

/// Part of a program over which forms are told along the run, or stand still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stretch {
    /// Before the first mark.
    Before,
    /// A direction with the rests up to its marks.
    Run(usize),
    /// Between the marks of the two directions.
    Between,
    /// After the last mark.
    After,
}

/// Forms of lost motion.
#[derive(Debug, Clone)]
pub struct LostMotion {
    /// mm at one standard deviation, a column for each form: entries of the first direction, of the second, and the three rests.
    pub forms: Table,
    /// Nodes of the course.
    nodes: usize,
}

/// Standard deviations of half the lost motion of a slide that is new or of no stated class: along its way and across it, mm, and
/// as tilts, rad. Machines in use show some µm; 1 arcsec at a lever of 200 mm is 1 µm.
const SLIDE: [f64; 3] = [3e-3, 1.5e-3, 5e-6];
/// The same of a rotary axis: 4 arcsec about its own line, 2 µm as shifts, 3 arcsec as tilts.
const ROTARY: [f64; 3] = [2e-5, 2e-3, 1.5e-5];
/// Travels over which a flank turns round, mm or deg: free play of some µm, which is taken up over its own size and on a circle shows
/// later the larger it is, each twice the one before; drives that wind up, each four times.
const TRAVELS: [f64; 9] = [0.001, 0.002, 0.004, 0.008, 0.016, 0.03, 0.12, 0.5, 2.0];
/// Forms smaller than this are below what a gauge reads, mm.
const LEAST_MM: f64 = 2e-5;
/// Columns that are nowhere larger than this are rounding, mm.
const NOTHING_MM: f64 = 1e-9;
/// Forms kept at most.
const MOST_FORMS: usize = 24;
/// Nodes at either end of a run that are cut into parts: axes turn round there within a part of a node.
const EDGE: usize = 4;
const PARTS: usize = 16;

impl LostMotion {
    /// Of a test whose program goes along a motion.
    pub(super) fn of(machine: &Machine, test: &Test, motion: &Motion) -> LostMotion {
        let chain = Chain::of(machine);
        let nodes = motion.rows();
        let Ok(links) = test.links(&chain) else {
            return LostMotion { forms: Table::of_columns::<Vec<f64>>(&[]), nodes };
        };
        let rows: Vec<Vec<f64>> = entries(nodes).into_iter().map(|node| at_node(motion, node)).collect();
        let geometry = Geometry::nominal(&chain);
        let slopes: Vec<Vec<[f64; 6]>> = rows
            .iter()
            .map(|row| {
                let mut slope = Sensitivity::zeros(motion.axis_count);
                let (pivot, spindle) = ((links.0, &test.pivot.at), (links.1, &test.spindle_ball.at));
                geometry.sensitivity(pivot, spindle, row, None, &mut slope);
                slope.motion
            })
            .collect();
        let way = Way::of(machine, test, rows);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for axis in (0..motion.axis_count).filter(|&axis| way.moves(axis)) {
            for travel in TRAVELS.map(|travel| machine.axes[axis].kind.from_file_unit(travel)) {
                for flank in way.flanks(axis, travel) {
                    columns.extend((0..6).map(|component| {
                        let size = size(machine, axis, component) / (TRAVELS.len() as f64).sqrt();
                        way.along(&flank, |entry| size * slopes[entry][axis][component])
                    }));
                }
            }
        }
        LostMotion { forms: Table::of_columns(&centred_forms(columns)), nodes }
    }

    /// Entry of the forms, with its fraction, at a node of a stretch.
    pub fn entry(&self, stretch: Stretch, node: f64) -> f64 {
        let run = entries_of(self.nodes) as f64;
        match stretch {
            Stretch::Run(direction) => direction as f64 * run + entry_of(node, self.nodes),
            Stretch::Before => 2.0 * run,
            Stretch::Between => 2.0 * run + 1.0,
            Stretch::After => 2.0 * run + 2.0,
        }
    }
}

/// Number of entries along a run.
fn entries_of(nodes: usize) -> usize {
    entry_of((nodes - 1) as f64, nodes) as usize + 1
}

/// Entry at a node: each node at the ends counts for some.
fn entry_of(node: f64, nodes: usize) -> f64 {
    let (edge, last) = (EDGE as f64, (nodes - 1) as f64);
    let more = (PARTS - 1) as f64;
    node + more * (node.min(edge) + (node - (last - edge)).max(0.0))
}

/// Nodes of all entries along a run.
fn entries(nodes: usize) -> Vec<f64> {
    let part = |node: usize| (0..PARTS).map(move |k| node as f64 + k as f64 / PARTS as f64);
    let last = nodes - 1;
    let middle = (EDGE..last - EDGE).map(|node| node as f64);
    (0..EDGE).flat_map(part).chain(middle).chain((last - EDGE..last).flat_map(part)).chain([last as f64]).collect()
}

/// Positions of all axes at a node with its fraction, mm or rad.
fn at_node(motion: &Motion, node: f64) -> Vec<f64> {
    let before = (node as usize).min(motion.rows() - 2);
    let share = node - before as f64;
    motion.row(before).iter().zip(motion.row(before + 1)).map(|(one, next)| one + share * (next - one)).collect()
}

/// Standard deviation of a component of an axis's lost motion, mm or rad.
fn size(machine: &Machine, axis: usize, component: usize) -> f64 {
    let class = match machine.linear_axes.class {
        Some(LinearClass::Used) => 2.0,
        Some(LinearClass::Worn) => 4.0,
        _ => 1.0,
    };
    let is_own = Outlet::own(machine, axis) == Outlet::Motion { axis, component: Component::ALL[component] };
    match (machine.axes[axis].kind, is_own) {
        (AxisKind::Linear, true) => class * SLIDE[0],
        (AxisKind::Linear, false) => class * SLIDE[if component < 3 { 1 } else { 2 }],
        (AxisKind::Rotary, true) => ROTARY[0],
        (AxisKind::Rotary, false) => ROTARY[if component < 3 { 1 } else { 2 }],
    }
}

/// Where the axes go in a program.
struct Way {
    /// Positions along the run, by entry.
    rows: Vec<Vec<f64>>,
    /// Far ends of the marks at both ends of the run, where the program makes them.
    marks: [Option<Vec<f64>>; 2],
}

impl Way {
    fn of(machine: &Machine, test: &Test, rows: Vec<Vec<f64>>) -> Way {
        let ends = [rows.first(), rows.last()];
        let marks = ends.map(|end| marked(machine, test, end?, test.marks?.move_mm));
        Way { rows, marks }
    }

    fn moves(&self, axis: usize) -> bool {
        let first = self.rows.first().map_or(0.0, |row| row[axis]);
        self.rows.iter().chain(self.marks.iter().flatten()).any(|row| (row[axis] - first).abs() > STANDS)
    }

    /// Flanks of an axis along the program, −1 … 1: from the middle, and what a flank at first adds; the two directions, entry by
    /// entry, and the rests.
    fn flanks(&self, axis: usize, travel: f64) -> [Vec<f64>; 2] {
        let law = MemoryLaw::LostMotion { windup_share: 0.0, take_up: 0.0, gap: travel };
        let runs = self.rows.len();
        let mut values = [0.0, 1.0].map(|flank| {
            let (mut past, mut here) = (Past::on_flank(flank), self.rows[0][axis]);
            let mut flanks = vec![0.0; 2 * runs + 3];
            for (to, entry) in self.course() {
                law.advance(&mut past, to[axis] - here);
                here = to[axis];
                flanks[entry] = law.value(&past);
            }
            flanks
        });
        let [middle, first] = &mut values;
        first.iter_mut().zip(middle.iter()).for_each(|(first, middle)| *first -= middle);
        values
    }

    /// Positions in the order in which the program passes them, each with the entry whose flank it leaves, if no other does.
    fn course(&self) -> impl Iterator<Item = (&[f64], usize)> {
        let runs = self.rows.len();
        let [before, between, after] = [0, 1, 2].map(|rest| 2 * runs + rest);
        let (first, last) = (self.rows[0].as_slice(), self.rows[runs - 1].as_slice());
        // out and back
        let mark = move |side: usize, to, entry| {
            self.marks[side].iter().map(move |far| (far.as_slice(), entry)).chain([(to, entry)])
        };
        let run =
            |direction: usize| self.rows.iter().enumerate().map(move |(k, row)| (row.as_slice(), direction * runs + k));
        [(first, before)]
            .into_iter()
            .chain(mark(0, first, 0))
            .chain(run(0))
            .chain(mark(1, last, between))
            .chain(mark(1, last, 2 * runs - 1))
            .chain(run(1).rev())
            .chain(mark(0, first, after))
    }

    /// A flank times what it does to the reading there.
    fn along(&self, flank: &[f64], slope: impl Fn(usize) -> f64) -> Vec<f64> {
        let runs = self.rows.len();
        let entry = |k: usize| match k {
            k if k < runs => k,
            k if k < 2 * runs => k - runs,
            // between the directions the run stands at its far end
            k if k == 2 * runs + 1 => runs - 1,
            _ => 0,
        };
        flank.iter().enumerate().map(|(k, flank)| flank * slope(entry(k))).collect()
    }
}

/// Positions that differ by less are the same, mm or rad.
const STANDS: f64 = 1e-7;

/// Principal forms of columns, but for their means, which the zero of a gauge holds.
fn centred_forms(mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let Some(rows) = columns.first().map(Vec::len) else { return Vec::new() };
    for column in &mut columns {
        let mean = mean(column.iter().copied()).unwrap_or(f64::NAN);
        column.iter_mut().for_each(|value| *value -= mean);
    }
    // components that do not move this bar
    columns.retain(|column| column.iter().any(|value| value.abs() > NOTHING_MM));
    let columns = DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]);
    principal_forms(&columns, (MOST_FORMS, LEAST_MM))
}

//! Columns written with too few digits: lengths coarser than any gauge reads, positions so coarse that the lengths feel it.

use crate::chain::{Chain, Geometry};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::session::{Motion, Recording, Session, Test};
use crate::statistics::{ON_STEP, median, rms, step_of, third_differences};

/// Lengths of so large a step are not what a gauge read, mm: gauges read to 0.1 µm, and the noise of a good one is 0.2 µm.
const COARSE_LENGTH_MM: f64 = 0.01;

/// Positions of so large a step were rounded for people to read, mm or degrees: controls log to 0.001 and finer.
const COARSE_POSITION: f64 = 0.01;

/// Rounded positions that move the lengths by so much, µm rms, look like physics: as much as a gauge's noise.
const WORTH_UM: f64 = 0.2;

/// Share of the rows beside which steps are uneven, from which a column was rounded: one that was commanded in even steps lies
/// on a grid by right.
const UNEVEN: f64 = 0.05;

/// Rows of a test at which lengths are held against positions.
const ROWS_OF_A_TEST: usize = 24;

/// Lengths or positions that were rounded.
pub(super) fn rounded(session: &Session) -> Option<DataFault> {
    rounded_lengths(session).or_else(|| coarser_than_others(session)).or_else(|| rounded_positions(session))
}

fn rounded_lengths(session: &Session) -> Option<DataFault> {
    let of_bars = session.tests.iter().filter(|test| test.bar_length_mm.is_some());
    let recordings: Vec<&Recording> = of_bars.filter_map(|test| test.recording.as_ref()).collect();
    // a gauge that stuck has no digits to lose, nor has a machine without errors
    let changes = |recording: &&Recording| {
        let mut read = recording.length_mm.iter().filter(|length| length.is_finite());
        read.next().is_some_and(|first| read.any(|length| (length - first).abs() > ON_STEP))
    };
    if !recordings.iter().any(changes) {
        return None;
    }
    let read = || recordings.iter().flat_map(|recording| &recording.length_mm).copied().filter(|l| l.is_finite());
    let step_mm = step_of(read)?;
    let says = format!(
        "all lengths are multiples of {step_mm} mm, where a gauge reads to 0.0001 mm: they were rounded; export them with all their digits"
    );
    let mut fault = DataFault::seen(FaultKind::ValuesRounded, RECORDER, Vec::new(), says);
    fault.components = vec!["length".into()];
    (step_mm >= COARSE_LENGTH_MM).then_some(fault)
}

/// Steps of one recording, mm, and how many times as large as those of most others, from which that file lost its digits: a gauge that shows whole
/// µm does so in every file.
const COARSE_IN_ONE_MM: f64 = 0.002;
const COARSER: f64 = 10.0;

/// Different readings of a recording from which its steps are known.
const LEAST_READINGS: usize = 10;

/// How far from whole steps readings with fewer digits may lie, as a share of a step: files round once more.
const OFF_STEP: f64 = 0.1;

/// Recordings whose readings differ by far larger steps than those of most others, and by whole ones: readings that change fast lie far apart
/// with all their digits.
fn coarser_than_others(session: &Session) -> Option<DataFault> {
    let step_mm = |test: &Test| -> Option<f64> {
        let recording = test.recording.as_ref().filter(|_| test.bar_length_mm.is_some())?;
        let mut read: Vec<f64> = recording.length_mm.iter().copied().filter(|length| length.is_finite()).collect();
        read.sort_by(f64::total_cmp);
        let steps = read.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > ON_STEP);
        let least = steps.clone().fold(f64::INFINITY, f64::min);
        let is_whole = |step: f64| (step / least - (step / least).round()).abs() < OFF_STEP;
        // readings on no common step have finer digits than would be told
        let digits = if steps.clone().all(is_whole) { least } else { COARSE_IN_ONE_MM / COARSER };
        (steps.count() >= LEAST_READINGS).then_some(digits)
    };
    let steps: Vec<(&Test, f64)> = session.tests.iter().filter_map(|test| Some((test, step_mm(test)?))).collect();
    let usual_mm = median(steps.iter().map(|(_, step)| *step))?;
    let is_coarse = |step: f64| step >= COARSE_IN_ONE_MM && step > (COARSER - 0.5) * usual_mm;
    let coarse = || steps.iter().filter(|(_, step)| is_coarse(*step));
    let least_mm = coarse().map(|(_, step)| *step).reduce(f64::min)?;
    let tests: Vec<String> = coarse().map(|(test, _)| test.name.clone()).collect();
    let says = format!(
        "readings of {} go by steps of {:.0} µm and more, where other recordings have digits to {:.1} µm: they were rounded; export them with all their \
         digits",
        listed(&tests),
        1e3 * least_mm,
        1e3 * usual_mm
    );
    let fault = DataFault::seen(FaultKind::ValuesRounded, RECORDER, tests, says);
    Some(DataFault { components: vec!["length".into()], ..fault })
}

/// A column of positions that was rounded.
struct Coarse<'s> {
    test: &'s Test,
    axis: usize,
    /// In mm or degrees.
    step: f64,
    /// By how much that moves the lengths, µm rms.
    moves_um: f64,
}

fn rounded_positions(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let of_bars = session.tests.iter().filter(|test| test.bar_length_mm.is_some());
    let timed = of_bars.filter_map(|test| Some((test, test.recording.as_ref().filter(|r| r.time_s().is_some())?)));
    let columns = timed.flat_map(|(test, recording)| (0..recording.axes.len()).map(move |k| (test, recording, k)));
    let found: Vec<Coarse> = columns.filter_map(|column| coarse(session, &chain, column)).collect();
    let worst = found.iter().max_by(|a, b| a.moves_um.total_cmp(&b.moves_um))?;
    let mut tests: Vec<String> = found.iter().map(|one| one.test.name.clone()).collect();
    tests.dedup();
    let axis = &session.machine.axes[worst.axis];
    let says = format!(
        "positions were rounded: {} has steps of {} {} in {}, which moves the lengths by {:.1} µm rms; export positions with all their \
         digits",
        axis.name,
        worst.step,
        axis.kind.position_unit(),
        listed(&tests),
        worst.moves_um
    );
    let mut fault = DataFault::seen(FaultKind::ValuesRounded, RECORDER, tests, says);
    fault.components = vec![axis.name.clone()];
    Some(fault)
}

/// A column of a recording that was rounded so coarsely that its lengths feel it.
fn coarse<'s>(
    session: &Session,
    chain: &Chain,
    (test, recording, column): (&'s Test, &Recording, usize),
) -> Option<Coarse<'s>> {
    let axis = recording.axes[column];
    let kind = session.machine.axes[axis].kind;
    let step = rounded_step(session, recording, column)?;
    // rounding errs evenly over a step
    let off = kind.from_file_unit(step) / 12f64.sqrt();
    let moves_um = 1e3 * off * change_per(session, chain, test, axis)?;
    (moves_um > WORTH_UM).then_some(Coarse { test, axis, step, moves_um })
}

/// Step of a column that lies on a coarse grid and moves unevenly on it, mm or degrees.
pub(super) fn rounded_step(session: &Session, recording: &Recording, column: usize) -> Option<f64> {
    let kind = session.machine.axes[recording.axes[column]].kind;
    let values: Vec<f64> = recording.positions[column].iter().map(|value| kind.to_file_unit(*value)).collect();
    step_of(|| values.iter().copied()).filter(|step| *step >= COARSE_POSITION && is_uneven(&values, *step))
}

/// Whether a column on a grid moves unevenly: third differences of even and of smooth motion are nothing.
fn is_uneven(values: &[f64], step: f64) -> bool {
    let uneven = third_differences(values).filter(|third| third.abs() > 0.5 * step).count();
    uneven as f64 > UNEVEN * values.len() as f64
}

/// Change of the length per mm or rad of an axis along a test, rms.
fn change_per(session: &Session, chain: &Chain, test: &Test, axis: usize) -> Option<f64> {
    let geometry = Geometry::nominal(chain);
    let motion = Motion::of(session, chain, test).ok()?;
    let links = test.links(chain).ok()?;
    let length = |at: &[f64]| test.bar(&geometry, links, at).norm();
    let change = |row: usize| {
        let (mut above, mut below) = (motion.row(row).to_vec(), motion.row(row).to_vec());
        above[axis] += HALF_STEP;
        below[axis] -= HALF_STEP;
        (length(&above) - length(&below)) / (2.0 * HALF_STEP)
    };
    Some(rms((0..motion.rows()).step_by((motion.rows() / ROWS_OF_A_TEST).max(1)).map(change)))
}

/// Half a step of differences, mm or rad.
const HALF_STEP: f64 = 1e-4;

//! An instrument or a target that was moved while points and poses were read. Mistakes in their columns stand in `readings::columns`.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::ball_places::End;
use super::loaded::left_by_a_load;
use crate::chain::{Chain, Geometry};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, SESSION, listed};
use crate::identify::{Fit, Options, identify};
use crate::readings::Kind;
use crate::session::{Motion, Session, Setups, Test, UNKNOWN_MM, UNKNOWN_RAD};
use crate::statistics::{rms, robust_sigma};

/// Share of the residual's squares that is left at most when the instrument stands elsewhere from some row on: with the errors as
/// fitted, and with all fitted once more.
const MOST_LEFT: f64 = 0.7;
const MOST_LEFT_REFITTED: f64 = 0.5;
/// Rows on either side at least: twice the numbers of a place.
const LEAST_ROWS: usize = 12;

/// Residuals below this are rounding, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Tag of an instrument's second place.
const SECOND: &str = "second";

/// An instrument, or a target on its link, that was moved during a session.
pub(crate) fn moved(session: &Session, options: &Options, fit: &Fit) -> Option<DataFault> {
    let fitted = Fitted { session, options, fit, before_mm: all_mm(fit), by_load: OnceCell::new() };
    let ends =
        [(End::Pivot, Numbers::OfPoints), (End::Spindle, Numbers::OfPoints), (End::Spindle, Numbers::OfRotations)];
    let moved = ends.into_iter().filter_map(|(end, of)| fitted.moved_at(end, of));
    let once = moved.min_by(|one, other| one.after_um.total_cmp(&other.after_um));
    let before_um = once.as_ref().map_or(1e3 * fitted.before_mm, |once| once.after_um);
    fitted.anew_in_each().filter(|each| each.after_um.powi(2) < MOST_LEFT_REFITTED * before_um.powi(2)).or(once)
}

/// Rms of what a fit leaves of all readings, mm: rows after a move may have been left out as outliers.
fn all_mm(fit: &Fit) -> f64 {
    rms(fit.tests.iter().flat_map(|test| &test.residual_mm).copied().filter(|value| value.is_finite()))
}

/// A session with its fit, in which something may have moved.
struct Fitted<'s> {
    session: &'s Session,
    options: &'s Options,
    fit: &'s Fit,
    /// Rms of what the fit leaves of all readings, mm.
    before_mm: f64,
    /// Share of the squares that is left beside a load, worked out once.
    by_load: OnceCell<Option<f64>>,
}

/// A session in which what was moved has other places, fitted.
struct Split {
    session: Session,
    fit: Fit,
    /// Share of the squares that is left.
    left: f64,
}

impl Fitted<'_> {
    fn split(&self, session: Session) -> Option<Split> {
        let fit = identify(&session, self.options).ok()?;
        let left = (all_mm(&fit) / self.before_mm).powi(2);
        Some(Split { session, fit, left })
    }

    /// Whether one load leaves no more: it says so with fewer numbers.
    fn is_a_load(&self, left: f64) -> bool {
        let by_load = self.by_load.get_or_init(|| left_by_a_load(self.session, self.fit));
        by_load.is_some_and(|left_by_load| left_by_load <= left)
    }

    /// What stood at an end elsewhere, in words, with this share of the squares left.
    fn fault(&self, split: &Split, end: End, left: f64, tests: Vec<String>, says: String) -> DataFault {
        let (kind, place) = match end {
            End::Pivot => (FaultKind::InstrumentMoved, SESSION),
            End::Spindle => (FaultKind::MountedAnew, TARGET),
        };
        let before_um = 1e3 * self.before_mm;
        let fault =
            DataFault { before_um, after_um: before_um * left.sqrt(), ..DataFault::seen(kind, place, tests, says) };
        fault.or_effect(evenness(split, end), None)
    }

    /// An instrument that was zeroed or mounted anew for each of its tests.
    fn anew_in_each(&self) -> Option<DataFault> {
        let session = self.session;
        let each = visits(session, self.fit, (End::Pivot, Numbers::OfPoints)).into_iter().filter_map(|visits| {
            let by_test: Vec<&[Visit]> = visits.chunk_by(|one, next| one.test == next.test).collect();
            let squares: f64 = visits.iter().map(|visit| visit.left.norm_squared()).sum();
            let explained: f64 = by_test.iter().map(|visits| Sums::of(visits).explained()).sum();
            let tests: Vec<usize> = by_test.iter().map(|visits| visits[0].test).collect();
            let left = 1.0 - explained / squares;
            let is_each =
                tests.len() > 1 && by_test.iter().all(|visits| visits.len() >= LEAST_ROWS) && left < MOST_LEFT;
            is_each.then_some((left, tests))
        });
        let (left, tests) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut own = session.clone();
        for (count, &first) in tests.iter().enumerate().skip(1) {
            let of_test = &mut own.tests[first..first + numbers(session, first)];
            of_test.iter_mut().for_each(|test| End::Pivot.mount_anew(test, format!("{SECOND} {count}"), None));
        }
        let split = self.split(own)?;
        let left = left.min(split.left);
        if self.is_a_load(left) {
            return None;
        }
        let names: Vec<String> = tests.iter().map(|&test| session.tests[test].stated_name().to_string()).collect();
        let says = format!(
            "the instrument of {} stands elsewhere in each of these tests: it was zeroed or mounted anew between them; give each a setup of its \
             own, instrument: {{link: {}, setup: …}}",
            listed(&names),
            session.tests[tests[0]].pivot.link
        );
        Some(self.fault(&split, End::Pivot, left, names, says))
    }

    /// What stood at one end of the readings elsewhere from some row on: the residual is a shift and a turn of its frame before that row, and
    /// another after; of a target a shift on its link alone, or a turn there.
    fn moved_at(&self, end: End, of: Numbers) -> Option<DataFault> {
        let session = self.session;
        let moved = visits(session, self.fit, (end, of)).into_iter().filter_map(|visits| {
            let (at, left) = change(&visits)?;
            (left < MOST_LEFT && left < left_by_drift(&visits)).then_some((left, visits, at))
        });
        let (left, visits, at) = moved.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (first, row) = (visits[at].test, visits[at].row);
        let later: Vec<usize> = visits[at..].iter().map(|visit| visit.test).filter(|&test| test != first).collect();
        let begins_there = !visits[..at].iter().any(|visit| visit.test == first);
        let split = self.split(with_second_place(session, end, (first, row), &later))?;
        if split.left > MOST_LEFT_REFITTED || self.is_a_load(split.left) {
            return None;
        }
        let test = &session.tests[first];
        let of = test.stated_name().to_string();
        let what = if end == End::Pivot { "instrument" } else { "target" };
        let second = format!("{what}: {{link: {}, setup: second}}", end.of(test).link);
        let mut says = match begins_there {
            true => format!("the {what} of test '{of}' stands elsewhere than before: give that test {second}"),
            false => format!(
                "the {what} of test '{of}' stands elsewhere from row {} on: give these rows a test of their own with {second}",
                row + 1
            ),
        };
        if !later.is_empty() {
            says.push_str("; the tests after it have the same second setup");
        }
        Some(self.fault(&split, end, left.min(split.left), vec![of], says))
    }
}

/// What of a pose shows that something moved.
#[derive(Clone, Copy, PartialEq)]
enum Numbers {
    /// Its coordinates.
    OfPoints,
    /// Its rotation, for a target that was turned.
    OfRotations,
}

impl Numbers {
    /// How many numbers stand before them.
    fn after(self) -> usize {
        if self == Numbers::OfPoints { 0 } else { 3 }
    }
}

/// Numbers of the reading whose first is a test.
fn numbers(session: &Session, test: usize) -> usize {
    session.tests[test].reading.part().map_or(0, |part| part.kind.scalars().len())
}

/// Where a target is mounted.
const TARGET: &str = "target";

/// What is left on either side of a move may differ by so many times: poses are others there.
const EITHER_SIDE: f64 = 2.0;

/// How evenly a fit leaves its residual between the places of what was moved, one where they are alike: another mistake leaves far more in its
/// own tests.
fn evenness(split: &Split, end: End) -> f64 {
    let mut left: BTreeMap<Option<&str>, Vec<f64>> = BTreeMap::new();
    for (test, fitted) in split.session.tests.iter().zip(&split.fit.tests) {
        let finite = fitted.residual_mm.iter().copied().filter(|left| left.is_finite());
        left.entry(end.of(test).setup.as_deref()).or_default().extend(finite);
    }
    let sigma = || left.values().map(|left_mm| robust_sigma(left_mm.iter().copied()));
    (EITHER_SIDE * sigma().fold(f64::INFINITY, f64::min) / sigma().fold(0.0, f64::max)).min(1.0)
}

/// A pose that an instrument saw: first number of its test, row, time as a share of all, point and what is left of it, mm; for a target both
/// as its link has them, the point at its own origin, about which no turn shows.
struct Visit {
    test: usize,
    row: usize,
    at: f64,
    point: Vector3<f64>,
    left: Vector3<f64>,
}

/// What each instrument saw, or was seen of each target, in the order of the session, points from their middle; none of one that saw
/// too little.
fn visits(session: &Session, fit: &Fit, (end, of): (End, Numbers)) -> Vec<Vec<Visit>> {
    let setups = Setups::of(session);
    let chain = Chain::of(&session.machine);
    let firsts = (0..session.tests.len()).filter(|&test| session.tests[test].is_first_of_sighting());
    let mut order: Vec<usize> = firsts.filter(|&test| numbers(session, test) >= of.after() + 3).collect();
    order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
    let mut by_setup: Vec<(usize, Vec<Visit>)> = Vec::new();
    for test in order {
        let number = |k: usize, row: usize| session.tests[test + k].recording.as_ref().map(|r| r.length_mm[row]);
        let turns = match end {
            End::Pivot => None,
            End::Spindle => turns_of_link(session, &chain, test),
        };
        let seen = (0..session.tests[test].rows()).filter_map(|row| {
            let left = Vector3::from([0, 1, 2].map(|k| fit.tests[test + of.after() + k].residual_mm[row]));
            let point = Vector3::from([0, 1, 2].map(|k| number(k, row).unwrap_or(f64::NAN)));
            let (point, left) = match &turns {
                None => (point, left),
                Some(turns) => (Vector3::zeros(), turns.get(row)?.transpose() * left),
            };
            left.iter().all(|value| value.is_finite()).then_some(Visit { test, row, at: 0.0, point, left })
        });
        let setup = end.setup_of(&setups, test);
        match by_setup.iter_mut().find(|(of, _)| *of == setup) {
            Some((_, visits)) => visits.extend(seen),
            None => by_setup.push((setup, seen.collect())),
        }
    }
    let visits = by_setup.into_iter().map(|(_, visits)| visits);
    let is_much = |visits: &Vec<Visit>| {
        visits.len() >= 2 * LEAST_ROWS && rms(visits.iter().flat_map(|visit| visit.left.iter().copied())) > ROUNDING_MM
    };
    let from_middle = |mut visits: Vec<Visit>| {
        let count = visits.len() as f64;
        let middle = visits.iter().map(|visit| visit.point).sum::<Vector3<f64>>() / count;
        visits.iter_mut().enumerate().for_each(|(k, visit)| {
            visit.point -= middle;
            visit.at = k as f64 / count;
        });
        visits
    };
    visits.filter(is_much).map(from_middle).collect()
}

/// Rotation of the target's link as the instrument has it, row by row of a test.
fn turns_of_link(session: &Session, chain: &Chain, test: usize) -> Option<Vec<Matrix3<f64>>> {
    let test = &session.tests[test];
    let motion = Motion::of(session, chain, test).ok()?;
    let (pivot, target) = test.links(chain).ok()?;
    let axes = test.reading.part()?.instrument_axes;
    let geometry = Geometry::nominal(chain);
    let turn = |row: usize| {
        let [frame, carried] = [pivot, target].map(|link| geometry.pose(link, motion.row(row), None).rotation);
        (frame * axes).transpose() * carried
    };
    Some((0..motion.rows()).map(turn).collect())
}

/// The session with what stands at an end mounted anew from a row of a test on, and in later tests.
fn with_second_place(session: &Session, end: End, (first, row): (usize, usize), later: &[usize]) -> Session {
    let mut split = session.clone();
    let mount = |test: &mut Test| {
        // it is looked for as one that no file places
        let sought_mm = (end == End::Spindle).then_some(UNKNOWN_MM);
        end.mount_anew(test, SECOND.into(), sought_mm);
        if let Some(part) = test.reading.part_mut().filter(|part| end == End::Spindle && part.kind == Kind::Pose) {
            part.target_turn_rad = Some(UNKNOWN_RAD);
        }
    };
    for &test in later {
        split.tests[test..test + numbers(session, test)].iter_mut().for_each(mount);
    }
    for index in first..first + numbers(session, first) {
        let mut second = session.tests[index].clone();
        second.name.push_str(" from there");
        mount(&mut second);
        for (test, is_second) in [(&mut split.tests[index], false), (&mut second, true)] {
            let lengths = test.recording.iter_mut().flat_map(|recording| recording.length_mm.iter_mut().enumerate());
            lengths.filter(|(at, _)| (*at >= row) != is_second).for_each(|(_, value)| *value = f64::NAN);
        }
        split.tests.push(second);
    }
    split
}

/// The visit from which another place of the instrument explains most, and the share of squares that is left then.
fn change(visits: &[Visit]) -> Option<(usize, f64)> {
    let total = Sums::of(visits);
    let mut before = Sums::default();
    let mut best: Option<(usize, f64)> = None;
    for (count, visit) in visits.iter().enumerate() {
        if (LEAST_ROWS..=visits.len() - LEAST_ROWS).contains(&count) {
            let after = total.less(&before);
            let share = 1.0 - (before.explained() + after.explained()) / total.squares.max(f64::MIN_POSITIVE);
            if best.is_none_or(|(_, least)| share < least) {
                best = Some((count, share));
            }
        }
        before.add(&visit.point, &visit.left);
    }
    best
}

/// Shares of the session in which a place settles.
const SETTLES_IN: [f64; 4] = [0.1, 0.25, 0.5, 1.0];

/// Share of squares that is left by a frame that drifts, as much of it as it wants, evenly or settling: growth and creep look like that, and
/// a move does not.
fn left_by_drift(visits: &[Visit]) -> f64 {
    let squares: f64 = visits.iter().map(|visit| visit.left.norm_squared()).sum();
    let shapes = std::iter::once(None).chain(SETTLES_IN.map(Some));
    let left = shapes.map(|settles| {
        let (mut matrix, mut right) = (SMatrix::<f64, 12, 12>::zeros(), SVector::<f64, 12>::zeros());
        for visit in visits {
            let grown = settles.map_or(visit.at, |settles| 1.0 - (-visit.at / settles).exp());
            let still = frame_columns(&visit.point);
            let mut columns = SMatrix::<f64, 3, 12>::zeros();
            columns.fixed_view_mut::<3, 6>(0, 0).copy_from(&still);
            columns.fixed_view_mut::<3, 6>(0, 6).copy_from(&(still * grown));
            matrix += columns.transpose() * columns;
            right += columns.transpose() * visit.left;
        }
        let held = matrix + SMatrix::<f64, 12, 12>::identity() * HELD;
        1.0 - held.cholesky().map_or(0.0, |factor| factor.solve(&right).dot(&right)) / squares
    });
    left.fold(1.0, f64::min)
}

/// What holds directions that the points do not tell.
const HELD: f64 = 1e-9;

/// A shift and a small turn of a frame at a point.
fn frame_columns(point: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let mut columns = SMatrix::<f64, 3, 6>::zeros();
    columns.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    columns.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-point.cross_matrix() / LEVER));
    columns
}

/// Normal equations of a shift and a small turn: `left = t + w × point`.
#[derive(Clone, Copy, Default)]
struct Sums {
    matrix: Matrix6<f64>,
    right: Vector6<f64>,
    squares: f64,
}

/// Turns count at this lever, mm, so that shifts and turns are of like size.
const LEVER: f64 = 1e3;

impl Sums {
    fn of(visits: &[Visit]) -> Sums {
        let mut sums = Sums::default();
        visits.iter().for_each(|visit| sums.add(&visit.point, &visit.left));
        sums
    }

    fn add(&mut self, point: &Vector3<f64>, left: &Vector3<f64>) {
        let columns = frame_columns(point);
        self.matrix += columns.transpose() * columns;
        self.right += columns.transpose() * left;
        self.squares += left.norm_squared();
    }

    fn less(&self, other: &Sums) -> Sums {
        Sums {
            matrix: self.matrix - other.matrix,
            right: self.right - other.right,
            squares: self.squares - other.squares,
        }
    }

    /// Squares that shift and turn take.
    fn explained(&self) -> f64 {
        let held = self.matrix + Matrix6::identity() * HELD;
        held.cholesky().map_or(0.0, |factor| factor.solve(&self.right).dot(&self.right))
    }
}

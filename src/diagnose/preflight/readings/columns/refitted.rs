//! Coordinates exchanged, mirrored, turned, in another unit or beside other rows that a fit tells. Which they are by the nominal chain is for `points`.
//!
//! A target that hardly moves in the instrument's frame, as in an R-test, lies near the nominal chain whichever way its coordinates are
//! held. Its deviations tell then, by quick fits of few rows.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::points::{EXCHANGED, in_units, rows_off, sightings_if_several, with_coordinates};
use super::undone::{AS_READ, COORDINATES, Undone};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::every_nth_sighting;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::diagnose::preflight::mistakes::worst_tests;
use crate::diagnose::preflight::quick_fit::{Refit, refit, refit_up_to};
use crate::readings::quaternion;
use crate::session::{Recording, Session, Test, is_looked_for, located_anew};

/// What an instrument is called where a mistake stands.
const INSTRUMENT: &str = "instrument";

/// Rows of all instruments together by which coordinates are told.
const ROWS: usize = 60;

/// Fits that leave less are of readings without noise, µm: rounding.
const LEAST_MISFIT_UM: f64 = 1e-3;

/// What first steps of a fit leave with a mistake undone, over what is left as read, beyond which it is none.
const HOPELESS: f64 = 3.0;

/// What fits leave as read, and of every way in which coordinates may be held otherwise, at the size at which they were read, µm.
pub(super) fn refitted(session: &Session) -> Option<(f64, Vec<(f64, Undone)>)> {
    let all_rows = session;
    let session = few_readings(session);
    let as_read = refit(&session, None).filter(|refit| refit.misfit_um > LEAST_MISFIT_UM)?;
    let left_um = |one: &Undone| {
        let chain = Chain::of(&one.session.machine);
        let undone = located_anew(one.session.clone(), &chain)?;
        // in the geometric mean over all readings, as their likelihood counts it
        let scale = one.scale.0.powf(share_of(one, &session));
        let Refit { misfit_um, .. } = refit_up_to(&undone, None, HOPELESS * scale * as_read.misfit_um)?;
        Some(misfit_um / scale)
    };
    let worst = worst_tests(&as_read.residual_mm);
    // rows are moved before most are left out
    let moved = rows_off(all_rows).into_iter().map(|one| Undone { session: few_readings(&one.session), ..one });
    let ways: Vec<Undone> = ways(&session, &worst).into_iter().chain(moved).collect();
    let judged = ways.into_par_iter().filter_map(|one| Some((left_um(&one)?, one)));
    Some((as_read.misfit_um, judged.collect()))
}

/// Share of the readings that a mistake makes larger.
fn share_of(one: &Undone, session: &Session) -> f64 {
    let readings = |of: &dyn Fn(&Test) -> bool| -> usize {
        let of = session.tests.iter().filter(|test| of(test)).filter_map(|test| test.recording.as_ref());
        of.map(Recording::readings).sum()
    };
    readings(&|test| !test.reading.is_turn() && one.scale_of(test) != 1.0) as f64 / readings(&|_| true).max(1) as f64
}

/// Whether points fit as well with all coordinates turned: then every error has the other sign. Where the instrument is looked for they do
/// not, for no instrument is mirrored.
pub(super) fn fits_reversed(session: &Session) -> bool {
    if !are_placed(session) {
        return false;
    }
    let session = few_readings(session);
    let reversed = Axes::reversed().undone(&session, None, true).session;
    match [&session, &reversed].map(|session| refit(session, None)) {
        [Some(as_read), Some(reversed)] => {
            as_read.misfit_um > LEAST_MISFIT_UM && reversed.misfit_um < AS_WELL * as_read.misfit_um
        }
        _ => false,
    }
}

/// Misfits that differ by less say the same.
const AS_WELL: f64 = 1.05;

/// The session with some of the readings of its points and poses, evenly spread, and nothing else.
fn few_readings(session: &Session) -> Session {
    let rows: usize = sightings(session).map(Test::rows).sum();
    every_nth_sighting(session, rows.div_ceil(ROWS).max(1))
}

/// Whether the session states where its instruments stand.
fn are_placed(session: &Session) -> bool {
    !sightings(session).any(|test| is_looked_for(&test.pivot))
}

/// The first number of every test of points and poses.
fn sightings(session: &Session) -> impl Iterator<Item = &Test> {
    session.tests.iter().filter(|test| test.is_first_of_sighting())
}

/// Every way in which coordinates may be held otherwise: of all tests, and of each of those that fit worst.
fn ways(session: &Session, worst: &[usize]) -> Vec<Undone> {
    let is_placed = are_placed(session);
    // of mirrored axes, which are all alike where the instrument's are not known, one
    let axes = || Axes::all().filter(|axes| is_placed || axes.held == Held::Exchanged(0, 1));
    let mut list: Vec<Undone> = axes().map(|axes| axes.undone(session, None, is_placed)).collect();
    list.extend(in_units(session, None));
    for name in sightings_if_several(session) {
        if worst.iter().any(|&test| session.tests[test].stated_name() == name) {
            let reversed = is_placed.then(Axes::reversed);
            list.extend(axes().chain(reversed).map(|axes| axes.undone(session, Some(name), is_placed)));
            list.extend(in_units(session, Some(name)));
        }
    }
    list
}

/// The instrument's axes: which column holds each, and its sign.
#[derive(Clone, Copy, PartialEq)]
struct Axes {
    column: [usize; 3],
    sign: [f64; 3],
    held: Held,
}

/// How coordinates are held otherwise: in one way that a person gets wrong.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    /// Two columns are exchanged.
    Exchanged(usize, usize),
    /// One counts the other way.
    Mirrored(usize),
    /// The instrument is turned about one of its axes, deg.
    Turned(usize, f64),
    /// All count the other way.
    Reversed,
}

const NAMES: [&str; 3] = ["x", "y", "z"];

impl Axes {
    const AS_READ: Axes = Axes { column: [0, 1, 2], sign: [1.0; 3], held: Held::Reversed };

    /// Every other way than the columns say, but for the sense of all of them.
    fn all() -> impl Iterator<Item = Axes> {
        [0, 1, 2].into_iter().flat_map(|axis| {
            let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
            let [mut exchanged, mut mirrored, mut half, mut quarter] = [Axes::AS_READ; 4];
            exchanged.held = Held::Exchanged(one.min(other), one.max(other));
            exchanged.column.swap(one, other);
            mirrored.held = Held::Mirrored(axis);
            mirrored.sign[axis] = -1.0;
            half.held = Held::Turned(axis, 180.0);
            (half.sign[one], half.sign[other]) = (-1.0, -1.0);
            // a quarter turn of the instrument about an axis: what it reads along the next one stands in the column of the last
            quarter.held = Held::Turned(axis, 90.0);
            quarter.column.swap(one, other);
            quarter.sign[one] = -1.0;
            let mut back = Axes { held: Held::Turned(axis, -90.0), ..quarter };
            (back.sign[one], back.sign[other]) = (1.0, -1.0);
            [exchanged, mirrored, half, quarter, back]
        })
    }

    /// All coordinates with the other sign.
    fn reversed() -> Axes {
        Axes { sign: [-1.0; 3], ..Axes::AS_READ }
    }

    fn of(&self, read: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from([0, 1, 2].map(|k| self.sign[k] * read[self.column[k]]))
    }

    /// As a matrix that makes true coordinates of those read.
    fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self.of(&axis)))
    }

    /// With what the columns hold set right: of the test of that name, or of all.
    fn undone(&self, session: &Session, of: Option<&str>, is_placed: bool) -> Undone {
        let (kind, place, says) = match self.held {
            _ if !is_placed => (FaultKind::SwappedColumns, RECORDER, EXCHANGED.to_string()),
            Held::Exchanged(one, other) => {
                let says = format!(
                    "the columns {} and {} of the readings are exchanged: correct the header",
                    NAMES[one], NAMES[other]
                );
                (FaultKind::SwappedColumns, RECORDER, says)
            }
            Held::Mirrored(axis) => {
                let says = format!("{} of the readings counts the other way: turn the sign of the column", NAMES[axis]);
                (FaultKind::SwappedColumns, RECORDER, says)
            }
            Held::Reversed => (FaultKind::ReadingSign, RECORDER, "all coordinates have the other sign".to_string()),
            Held::Turned(axis, by_deg) => {
                let stated = sightings(session).find_map(|test| test.reading.part()).map(|part| part.instrument_axes);
                let [w, x, y, z] = quaternion(&(stated.unwrap_or_else(Matrix3::identity) * self.matrix()));
                let says = format!(
                    "the instrument is turned by {by_deg:.0}° about its {} against the session: state quaternion: [{w:.4}, {x:.4}, {y:.4}, {z:.4}]",
                    NAMES[axis]
                );
                (FaultKind::BallPlace, INSTRUMENT, says)
            }
        };
        let components = if place == RECORDER { vec![COORDINATES.into()] } else { Vec::new() };
        let undone = with_coordinates(session, of, |read| self.of(&read));
        let says = match of {
            Some(name) => format!("in {name} {says}"),
            None => says,
        };
        Undone { kind, place, components, says, session: undone, scale: AS_READ }
    }
}

//! Mistakes in columns and statements of points, poses and displacements, which no chain explains as they stand. Lengths have theirs in `mistakes`.
//!
//! With instruments and targets where they fit best, readings lie millimetres from the nominal chain. A wrong sense, unit, link or order of
//! columns puts them off by the size of the machine.
//!
//! | file | mistakes |
//! |---|---|
//! | `points` | of coordinates, positions and links, which coordinates tell |
//! | `refitted` | of coordinates that are near to the nominal chain however they are held |
//! | `rotations` | of the form of rotations |
//! | `gauges` | of the sense and unit of displacements |
//! | `undone` | what they have in common |

mod gauges;
mod points;
mod refitted;
mod rotations;
mod undone;

use rayon::prelude::*;

use crate::diagnose::cause::MOST_RIVALS;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, Rival};
use crate::identify::Fit;
use crate::readings::{Kind, LEVER_MM, Scalar};
use crate::session::{Session, Test};
use crate::statistics::{NOISE_FLOOR_MM, robust_sigma};

use gauges::{gauges_mm, mistakes_of_gauges};
use points::{mistakes_of_points, points_mm};
use refitted::{fits_reversed, refitted};
use rotations::{mistakes_of_rotations, turns_rad};
use undone::{COORDINATES, Undone};

/// Undoing a mistake brings the readings so many times nearer to the nominal chain: nominal dimensions are off by millimetres, a
/// wrong sense by the size of the machine.
const LEAST_RATIO: f64 = 5.0;
/// Readings this near to the nominal chain hold no mistake of this kind, mm and rad: arms are built to millimetres and tenths of a degree.
const NEAR_NOMINAL_MM: f64 = 15.0;
const NEAR_NOMINAL_RAD: f64 = 0.05;
/// The same for a gauge, mm: it is used within its travel of some tenths.
const GAUGE_NEAR_NOMINAL_MM: f64 = 0.1;

/// Mistakes that leave up to so many times as much are as likely: nothing but nominal dimensions was compared.
const AS_LIKELY_UP_TO: f64 = 1.5;

/// What readings are compared by, over all of them: coordinates or rotations (mm or rad), or one gauge's displacements (mm).
type Measure = fn(&Session, &dyn Fn(&Test) -> f64) -> Option<f64>;

/// A mistake in columns or statements that makes the readings fit the nominal chain once it is undone.
pub(crate) fn mistaken_columns(session: &Session) -> Option<DataFault> {
    best(session, points_mm, NEAR_NOMINAL_MM, 1e3, mistakes_of_points)
        .or_else(|| best(session, turns_rad, NEAR_NOMINAL_RAD, 1e3 * crate::readings::LEVER_MM, mistakes_of_rotations))
}

/// A gauge read with the other sign or in another unit. A fit turns the gauge round and leaves nothing of it: the stated direction tells.
pub(crate) fn mistaken_gauge(session: &Session) -> Option<DataFault> {
    best(session, gauges_mm, GAUGE_NEAR_NOMINAL_MM, 1e3, mistakes_of_gauges)
}

/// Width of a target, mm, below which no instrument reads its rotation: what its points scatter by over that width is what its rotation
/// scatters by.
const LEAST_WIDTH_MM: f64 = 5.0;

/// Poses whose coordinates repeat as if the target were far too small for the scatter of its rotations: they are in metres. Where all axes
/// meet the fit itself tells no scale.
pub(crate) fn coordinates_in_metres(session: &Session, fit: &Fit) -> Option<DataFault> {
    let is_pose = |test: &usize| session.tests[*test].reading.part().is_some_and(|part| part.kind == Kind::Pose);
    let left_mm = |is_wanted: fn(&Scalar) -> bool| {
        let of = (0..session.tests.len())
            .filter(is_pose)
            .filter(|&test| session.tests[test].reading.part().is_some_and(|part| is_wanted(&part.scalar)));
        let left = of.flat_map(|test| &fit.tests[test].residual_mm).copied().filter(|left| left.is_finite());
        robust_sigma(left)
    };
    let coordinates_mm = left_mm(|scalar| matches!(scalar, Scalar::Coordinate(_)));
    let rotations_mm = left_mm(|scalar| !matches!(scalar, Scalar::Coordinate(_)));
    let width_mm = LEVER_MM * coordinates_mm / rotations_mm;
    // rotations that do not fit say nothing of their scatter
    let fit_well = (f64::MIN_POSITIVE..LEVER_MM * NEAR_NOMINAL_RAD).contains(&rotations_mm);
    (fit_well && coordinates_mm > NOISE_FLOOR_MM && width_mm < LEAST_WIDTH_MM).then(|| {
        let says = format!(
            "coordinates repeat to {:.2} µm and rotations to {:.0} arcsec, as of a target {width_mm:.2} mm wide: are the coordinates in metres? \
             Convert the columns to mm",
            1e3 * coordinates_mm,
            1e3 * rotations_mm
        );
        let fault = DataFault::seen(FaultKind::Unit, RECORDER, Vec::new(), says);
        DataFault { components: vec![COORDINATES.into()], ..fault }
    })
}

/// The mistake that leaves least by a measure, with those that leave as little.
fn best(
    session: &Session,
    measure: Measure,
    near: f64,
    to_um: f64,
    mistakes: fn(&Session) -> Vec<Undone>,
) -> Option<DataFault> {
    let before = measure(session, &|_| 1.0).filter(|misfit| *misfit > near)?;
    let judged = mistakes(session).into_par_iter().filter_map(|one| {
        let left = measure(&one.session, &|test| one.scale_of(test))?;
        Some((to_um * left, one))
    });
    likeliest(to_um * before, judged.collect(), LEAST_RATIO)
}

/// Coordinates that fit so many times better once they are held otherwise: whatever a machine does beside its location errors, it does not
/// do as one that is mirrored.
const LEAST_RATIO_REFITTED: f64 = 2.0;

/// Coordinates that a fit tells to be exchanged, mirrored, turned or in another unit.
pub(crate) fn coordinates_held_otherwise(session: &Session) -> Option<DataFault> {
    let (before_um, judged) = refitted(session)?;
    likeliest(before_um, judged, LEAST_RATIO_REFITTED)
}

/// Residual of points below which no instrument reads and no machine comes back to a place, µm; that of readings without noise is below
/// [`ROUNDING_UM`].
const LEAST_RESIDUAL_UM: f64 = 0.05;
const ROUNDING_UM: f64 = 1e-3;

/// Points that fit better than any that were read: their unit is larger than mm.
pub(crate) fn coordinates_too_fine(session: &Session, fit: &Fit) -> Option<DataFault> {
    let is_of_points = session.tests.iter().all(Test::is_sighted);
    let left_um = 1e3 * fit.rms_mm;
    let is_too_fine = is_of_points && (ROUNDING_UM..LEAST_RESIDUAL_UM).contains(&left_um);
    is_too_fine.then(|| {
        let says = format!(
            "coordinates fit to {left_um:.3} µm rms, where no instrument reads and no machine comes back to a place so well: are they in metres or \
             inches? Convert the columns to mm"
        );
        let fault = DataFault::seen(FaultKind::Unit, RECORDER, Vec::new(), says);
        DataFault { components: vec![COORDINATES.into()], ..fault }
    })
}

/// A word where points do not tell their own sense.
pub(crate) fn sense_of_coordinates(session: &Session) -> Option<String> {
    let has_points = session.tests.iter().any(Test::is_sighted);
    (has_points && fits_reversed(session)).then(|| {
        "these readings do not tell their own sense: with all coordinates turned they fit as well, and every error has the other sign; move \
         the target by hand along x and look whether x rises"
            .to_string()
    })
}

/// The mistake that leaves least, µm, with those that leave as little, where it lowers what is left as read, µm, so many times.
fn likeliest(before_um: f64, mut judged: Vec<(f64, Undone)>, least_ratio: f64) -> Option<DataFault> {
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut alike = judged.into_iter();
    let (after_um, best) = alike.next().filter(|(after_um, _)| before_um > least_ratio * after_um)?;
    let rivals =
        alike.take_while(|(other, _)| *other < AS_LIKELY_UP_TO * after_um).take(MOST_RIVALS).map(|(_, other)| {
            let Undone { kind, place, components, says, .. } = other;
            Rival { kind, place: place.to_string(), components, says, probability: 0.0 }
        });
    let fault = DataFault {
        components: best.components,
        before_um,
        after_um,
        rivals: rivals.collect(),
        ..DataFault::seen(best.kind, best.place, Vec::new(), best.says)
    };
    Some(fault.shared_evenly())
}

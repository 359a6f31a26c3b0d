//! Recorded tests pass by pass: their angles, and deviations of readings and model from the nominal length. No pictures.

use super::bar_turn::{BarTurn, bar_turn, passes};
use super::centring::Centred;
use super::error::MethodError;
use super::swept::Course;
use crate::chain::Chain;
use crate::session::{Session, Test};
use crate::statistics::mean;
use crate::units::UM_PER_MM;

/// A recorded test of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct TestTrace {
    /// Its place in the session.
    pub test: usize,
    pub course: Course,
    /// Where the bar points; `None` where it keeps its direction.
    pub turn: Option<BarTurn>,
}

/// Deviations from the nominal length by row, µm; NaN where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceDeviations {
    pub nominal_mm: f64,
    /// Readings that a fit took.
    pub read_um: Vec<f64>,
    /// Readings that it left out.
    pub left_out_um: Vec<f64>,
    /// The model of the readings that it took.
    pub model_um: Vec<f64>,
}

/// A bar lies in the plane of its circle where its length is the radius, within what a calibrated length differs from a nominal one, mm.
const LEVEL_MM: f64 = 0.2;

impl TestTrace {
    fn of(session: &Session, chain: &Chain, test: usize) -> Result<TestTrace, MethodError> {
        let of = &session.tests[test];
        let course = Course::of(session, chain, of)?;
        let turns = course.motion.time_s.is_some() && of.recording.is_some();
        let turn = if turns { bar_turn(session, chain, of, &course.motion)? } else { None };
        Ok(TestTrace { test, course, turn })
    }

    /// Angle by row, rad: the bar's direction where it turns, else the position of the axis that turns.
    pub fn angle_rad(&self) -> Option<&[f64]> {
        let turn = self.turn.as_ref().map(|turn| turn.angle_rad.as_slice());
        turn.or(self.course.swept.as_ref().and_then(|swept| swept.angle_rad.as_deref()))
    }

    /// Signed turn over the test, rad.
    pub fn turned_rad(&self) -> Option<f64> {
        let angle = self.angle_rad()?;
        Some(angle.last()? - angle.first()?)
    }

    /// Deviations of the readings of its test in a fit, of which `kept` and `residual_mm` are given by row.
    pub fn deviations(&self, test: &Test, kept: &[bool], residual_mm: &[f64]) -> TraceDeviations {
        let lengths = test.recording.as_ref().map_or(&[][..], |recording| &recording.length_mm);
        let finite: Vec<f64> = lengths.iter().copied().filter(|length| length.is_finite()).collect();
        // a circle has the radius that was commanded, as its figures count; an absolute gauge has no nominal length: its mean stands for it
        let bar_mm = test.bar_length_mm;
        let is_level = |radius: &f64| bar_mm.is_none_or(|bar| (bar - radius).abs() < LEVEL_MM);
        let commanded_mm = self.course.swept.as_ref().and_then(|swept| swept.radius_mm).filter(is_level);
        let usual_mm = || mean(finite.iter().copied()).unwrap_or(0.0);
        let nominal_mm = commanded_mm.or(bar_mm).unwrap_or_else(usual_mm);
        let (mut read_um, mut left_out_um, mut model_um) = (Vec::new(), Vec::new(), Vec::new());
        for (row, length) in lengths.iter().enumerate() {
            let is_taken = kept.get(row).copied().unwrap_or(false);
            let deviation = (length - nominal_mm) * UM_PER_MM;
            read_um.push(if is_taken { deviation } else { f64::NAN });
            left_out_um.push(if is_taken { f64::NAN } else { deviation });
            model_um.push(if is_taken { deviation - residual_mm[row] * UM_PER_MM } else { f64::NAN });
        }
        TraceDeviations { nominal_mm, read_um, left_out_um, model_um }
    }
}

/// The recorded tests of a session, both directions of a pass together.
pub fn recorded_passes(session: &Session) -> Result<Vec<Vec<TestTrace>>, MethodError> {
    let chain = Chain::of(&session.machine);
    let all = (0..session.tests.len()).map(|test| TestTrace::of(session, &chain, test));
    let mut all: Vec<Option<TestTrace>> = all.map(|trace| trace.map(Some)).collect::<Result<_, _>>()?;
    let turns: Vec<Option<f64>> = all.iter().map(|trace| trace.as_ref()?.turned_rad()).collect();
    let recorded = |pass: Vec<usize>| -> Vec<TestTrace> {
        let recorded = pass.into_iter().filter(|&test| session.tests[test].recording.is_some());
        recorded.filter_map(|test| all[test].take()).collect()
    };
    Ok(passes(session, &turns).into_iter().map(recorded).filter(|pass| !pass.is_empty()).collect())
}

/// The offset of the centre that the directions of a pass have in common; `None` where the bar does not turn or too short an arc
/// holds no centre.
pub fn common_centre(pass: &[TestTrace], deviations: &[TraceDeviations]) -> Option<Centred> {
    pass.first()?.turn.as_ref()?;
    let points = pass.iter().zip(deviations).flat_map(|(one, deviations)| {
        let angles = one.angle_rad().unwrap_or_default();
        angles.iter().copied().zip(deviations.read_um.iter().copied())
    });
    Centred::of(points.collect::<Vec<_>>().into_iter())
}

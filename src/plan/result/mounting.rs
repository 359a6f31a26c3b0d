//! What the operator puts together for a test: bar and extensions, calibrator, spindle side. Where it stands is the test's.

use nalgebra::Vector3;

use crate::bodies::Kit;
use crate::collision::Instrument;
use crate::machine::{Machine, SpindleSide};
use crate::session::Test;

/// The instrument of a test in the parts of the kit.
#[derive(Debug, Clone, PartialEq)]
pub struct Mounting {
    /// The bar, then the extensions screwed to it, mm; together the bar's length.
    pub bar_parts_mm: Vec<f64>,
    /// The longest part of them, bar included, that the calibrator certifies, mm; `None` when it certifies none.
    pub calibrator_mm: Option<f64>,
    /// From the spindle's nose to the ball along the tool axis, mm: the gauge length to be set.
    pub nose_to_ball_mm: f64,
    /// `None`: a straight stem, the ball on the tool axis.
    pub arm: Option<Arm>,
}

/// The fixture that carries the ball aside of the tool axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    pub length_mm: f64,
    /// From the tool axis to the ball in R with all axes at zero, unit length.
    pub towards: Vector3<f64>,
    pub cup: CupLooks,
}

/// Where the cup of a fixture looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CupLooks {
    /// Away from the spindle, along the tool axis.
    DownTheTool,
    /// Away from the tool axis, along the arm.
    Outward,
}

/// Distances from the tool axis below this are none, mm.
const ON_AXIS_MM: f64 = 1e-6;

impl Mounting {
    /// The parts of a test's instrument.
    pub(crate) fn of(machine: &Machine, kit: &Kit, test: &Test, instrument: &Instrument) -> Option<Mounting> {
        let spindle = machine.spindle.as_ref()?;
        let length_mm = test.bar_length_mm?;
        let bar_parts_mm = kit.parts_mm(length_mm)?;
        let (nose_to_ball_mm, aside) = from_nose(spindle, &test.spindle_ball.at);
        let arm = (aside.norm() > ON_AXIS_MM).then(|| {
            let towards = aside.normalize();
            let looks = instrument.spindle_cup_looks();
            let outward = looks.dot(&towards) > looks.dot(&-spindle.direction);
            let cup = if outward { CupLooks::Outward } else { CupLooks::DownTheTool };
            Arm { length_mm: aside.norm(), towards, cup }
        });
        Some(Mounting { calibrator_mm: kit.calibrated_mm(&bar_parts_mm), bar_parts_mm, nose_to_ball_mm, arm })
    }
}

/// A ball seen from the spindle's nose: along the tool axis, mm, and across it.
fn from_nose(spindle: &SpindleSide, ball: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let along_mm = (spindle.nose - ball).dot(&spindle.direction);
    (along_mm, ball - (spindle.nose - spindle.direction * along_mm))
}

//! What the thesis's reduction gets wrong of second order, derived on paper: of each circle, and so of each error. No library code.
//!
//! The carried ball runs on a circle of radius ρ about k, where the axis pierces the turning plane of the standing ball, seen
//! from that ball. Sections 4.2 and 5.2 draw every reading at the commanded angle φ, u = (cos φ, sin φ), not at the bar's own,
//! which differs by k·u⊥/ρ. With t the axis's slope, h the distance from the standing to the carried ball along it, and e by
//! how much that ball stands farther than h:
//!
//! ```text
//! √(L² − h²) = ρ' + (1 − h e/ρ²) k·u − [(k·u)² − |k|²]/2ρ + ρ (t·u)²/2          as read
//! r(φ)       = ρ' + k·u              + [(k·u)² − |k|²]/2ρ                      the circle about k, drawn at φ
//! difference = −(k·u)²/ρ + ρ (t·u)²/2 − (h e/ρ²) k·u                          but for a constant
//! ```
//!
//! The fitted centre is off by what least squares of 1, cos φ, sin φ finds in the difference: nothing of the squares on a full
//! turn, some hundredths of a µm on the 90° of A. A ball carried at an angle ψ beside the commanded one turns k by −ψ. What the C
//! axis's line is at its own height 0, a standing ball sees EZ0A lower, and in directions turned by EC0A.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::examples::thesis_sessions::design::{
    A_SWEEP_DEG, Axis, C_SWEEP_DEG, Carrier, Design, FEED_MM_MIN, Mounting, RADIUS_MM, Test,
};

const RAD_PER_ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
/// Time between two readings on A and C, s.
const SAMPLE_S: [f64; 2] = [0.1, 0.25];

/// An axis as a line seen in the plane across it: place at the origin, mm, and slope.
#[derive(Clone, Copy)]
pub struct Line {
    place: Vector2<f64>,
    slope: Vector2<f64>,
}

/// The line that the tests of an axis see; YZ for A, XY for C, whose tests see A's errors too.
fn line(design: &Design, axis: Axis) -> Line {
    let [ey0a, ez0a, eb0a, ec0a, ex0c, ey0c, ea0c, eb0c] = design.errors;
    let (place_um, slope_arcsec) = match axis {
        Axis::A => ([ey0a, ez0a], [ec0a, -eb0a]),
        Axis::C => ([ex0c, ey0a + ey0c], [eb0a + eb0c, -ea0c]),
    };
    Line { place: Vector2::from(place_um) * 1e-3, slope: Vector2::from(slope_arcsec) * RAD_PER_ARCSEC }
}

/// Commanded angles of the carried ball in the turning plane, both directions, rad.
fn angles(mounting: &Mounting, test: &Test) -> Vec<f64> {
    let (from, to) = match test.axis {
        Axis::A => A_SWEEP_DEG,
        Axis::C => C_SWEEP_DEG,
    };
    let pivot = mounting.pivot_mm;
    let begin = match test.axis {
        Axis::A => pivot[2].atan2(pivot[1]),
        Axis::C => pivot[1].atan2(pivot[0]),
    };
    let step_deg = (FEED_MM_MIN / 60.0 / RADIUS_MM).to_degrees() * SAMPLE_S[test.axis as usize];
    let count = ((to - from) / step_deg) as usize;
    let ways = [(from, step_deg), (to, -step_deg)];
    ways.iter()
        .flat_map(|(start, step)| (0..=count).map(move |k| begin + (start + step * k as f64).to_radians()))
        .collect()
}

/// What the other axis's errors do to the carried ball: farther along the axis under test, mm, and beside its angle, rad.
fn carried(design: &Design, axis: Axis, carrier: Carrier) -> (f64, f64) {
    let [_, ez0a, _, ec0a, ex0c, _, ea0c, _] = design.errors;
    match (axis, carrier) {
        (Axis::A, Carrier::Table) => (ex0c * 1e-3, ea0c * RAD_PER_ARCSEC),
        (Axis::A, Carrier::TiltingTable) => (0.0, 0.0),
        (Axis::C, _) => (ez0a * 1e-3, ec0a * RAD_PER_ARCSEC),
    }
}

/// How far the C axis's line stands from where its own errors and A's, added, put it, mm.
fn product(design: &Design, axis: Axis) -> Vector2<f64> {
    let [_, ez0a, _, ec0a, ex0c, ey0c, ..] = design.errors;
    match axis {
        Axis::A => Vector2::zeros(),
        Axis::C => {
            let turned = Vector2::new(-ey0c, ex0c) * 1e-3 * (ec0a * RAD_PER_ARCSEC);
            turned - line(design, axis).slope * (ez0a * 1e-3)
        }
    }
}

/// How far the fitted centre of a test is off, mm, and where its standing ball is along the axis, mm.
fn centre_off(design: &Design, mounting: &Mounting, test: &Test) -> (Vector2<f64>, f64) {
    let along = if test.axis == Axis::A { 0 } else { 2 };
    let at_mm = test.spindle_mm[along];
    let reach_mm = mounting.pivot_mm[along] - at_mm;
    let Line { place, slope } = line(design, test.axis);
    let k = place + slope * at_mm;
    let (farther_mm, beside_rad) = carried(design, test.axis, mounting.carrier);
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for angle in angles(mounting, test) {
        let row = Vector3::new(1.0, angle.cos(), angle.sin());
        let u = Vector2::new(angle.cos(), angle.sin());
        let difference = -k.dot(&u).powi(2) / RADIUS_MM + RADIUS_MM * slope.dot(&u).powi(2) / 2.0;
        normal += row * row.transpose();
        right += row * difference;
    }
    let fitted = normal.cholesky().expect("an arc").solve(&right);
    let turned = Matrix2::new(0.0, beside_rad, -beside_rad, 0.0) * k;
    (Vector2::new(fitted[1], fitted[2]) - k * (reach_mm * farther_mm / RADIUS_MM.powi(2)) + turned, at_mm)
}

/// What the circles' offsets do to the line of an axis.
fn line_off(design: &Design, axis: Axis, besides: impl Fn(&Mounting, &Test) -> Vector2<f64>) -> Line {
    let tests = design.mountings.iter().flat_map(|mounting| mounting.tests.iter().map(move |test| (mounting, test)));
    let off: Vec<(Vector2<f64>, f64)> = tests
        .filter(|(_, test)| test.axis == axis)
        .map(|(mounting, test)| {
            let (off, at_mm) = centre_off(design, mounting, test);
            (off + besides(mounting, test), at_mm)
        })
        .collect();
    let [(first, from_mm), (second, to_mm)] = off[..] else { panic!("two circles of an axis") };
    let slope = (second - first) / (to_mm - from_mm);
    Line { place: first - slope * from_mm + product(design, axis), slope }
}

/// Off by second order: the eight errors, µm and arcsec in the order of the design's.
pub fn errors_off(design: &Design) -> [f64; 8] {
    stacked(line_off(design, Axis::A, |_, _| Vector2::zeros()), line_off(design, Axis::C, |_, _| Vector2::zeros()))
}

/// The same with eq. 4.1 taken literally: every arc turned by the angle at which the ball starts beside its ideal place.
pub fn errors_off_with_start_turned(design: &Design) -> [f64; 8] {
    let turned = |mounting: &Mounting, test: &Test| {
        let Line { place, slope } = line(design, test.axis);
        let along = if test.axis == Axis::A { 0 } else { 2 };
        let begin = angles(mounting, test)[0];
        let across = Vector2::new(-begin.sin(), begin.cos());
        // from P0, where the ball would start without errors, to P0'
        let start_rad = (place + slope * mounting.pivot_mm[along]).dot(&across) / RADIUS_MM
            + carried(design, test.axis, mounting.carrier).1;
        Matrix2::new(0.0, -start_rad, start_rad, 0.0) * (place + slope * test.spindle_mm[along])
    };
    stacked(line_off(design, Axis::A, turned), line_off(design, Axis::C, turned))
}

fn stacked(a: Line, c: Line) -> [f64; 8] {
    let um = |mm: f64| mm * 1e3;
    let arcsec = |rad: f64| rad / RAD_PER_ARCSEC;
    let (eb0a, ec0a) = (arcsec(-a.slope.y), arcsec(a.slope.x));
    [
        um(a.place.x),
        um(a.place.y),
        eb0a,
        ec0a,
        um(c.place.x),
        um(c.place.y - a.place.x),
        arcsec(-c.slope.y),
        arcsec(c.slope.x) - eb0a,
    ]
}

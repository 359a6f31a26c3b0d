//! The thesis's four steps and planar circle against closed forms, and its eq. 3.20, 3.21 as printed against the chain.

use crate::trunnion;
use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::load::load_session;
use fiveaxis::machine::ErrorName;
use fiveaxis::session::Session;
use fiveaxis::simulate::trace;
use fiveaxis::units::ARCSEC_PER_RAD;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use trunnion::Balls;

const RADIUS_MM: f64 = 100.0;
const BAR_MM: f64 = 150.0;

fn session() -> Session {
    load_session(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/chapter3/session.yaml")).unwrap()
}

/// Angle (rad) and change of length (mm) of a step with one error of the given size (mm or rad).
fn change(session: &Session, step: &str, error: &str, size: f64, composition: Composition) -> Vec<(f64, f64)> {
    let name = ErrorName::parse(error, &session.machine.axis_names()).unwrap();
    let mut errors = session.machine.location_errors();
    errors[session.machine.axis_index(&name.axis).unwrap()][name.component.index()] = size;
    let chain = Chain::of(&session.machine);
    let test = session.tests.iter().find(|test| test.name == step).unwrap();
    let with_error = trace(session, &Geometry::new(&chain, &errors, composition), test).unwrap();
    let nominal = trace(session, &Geometry::nominal(&chain), test).unwrap();
    let motion = &nominal.motion;
    let angle = |row: usize| match motion.moving[..] {
        [x, y] => motion.row(row)[y].atan2(motion.row(row)[x]),
        _ => motion.row(row)[motion.moving[0]],
    };
    (0..motion.rows()).map(|row| (angle(row), with_error.length_mm[row] - nominal.length_mm[row])).collect()
}

#[test]
fn each_error_shows_in_each_step_as_its_closed_form() {
    let session = session();
    let far_mm = (BAR_MM * BAR_MM - RADIUS_MM * RADIUS_MM).sqrt();
    let (radial, axial, k) = (RADIUS_MM / BAR_MM, far_mm / BAR_MM, RADIUS_MM * far_mm / BAR_MM);
    // per error and step: coefficients of 1, cos θ, sin θ in mm per mm or mm per rad
    let table: [(&str, [[f64; 3]; 4]); 8] = [
        ("EB0A", [[0.0; 3], [0.0, 0.0, k], [0.0; 3], [0.0, k, 0.0]]),
        ("EC0A", [[0.0; 3], [0.0, -k, 0.0], [0.0; 3], [0.0; 3]]),
        ("EY0A", [[0.0, 1.0, 0.0], [0.0, radial, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, radial]]),
        ("EZ0A", [[0.0, 0.0, 1.0], [0.0, 0.0, radial], [0.0; 3], [-axial, 0.0, 0.0]]),
        ("EA0C", [[0.0; 3], [0.0; 3], [0.0; 3], [0.0, 0.0, -k]]),
        ("EB0C", [[0.0; 3], [0.0; 3], [0.0; 3], [0.0, k, 0.0]]),
        ("EX0C", [[0.0; 3], [axial, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, radial, 0.0]]),
        ("EY0C", [[1.0, 0.0, 0.0], [radial, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, radial]]),
    ];
    for composition in [Composition::FirstOrder, Composition::Exact] {
        for (error, coefficients) in &table {
            let is_angle = ["EA", "EB", "EC"].iter().any(|angle| error.starts_with(angle));
            let size = if is_angle { 0.01f64.to_radians() } else { 10e-3 };
            // a ball displaced by d across the bar lengthens it by d²/2L; I + [ε]× also stretches the arm by ε²R/2
            let bound_mm = if is_angle {
                (size * RADIUS_MM).powi(2) / (2.0 * BAR_MM) + size * size * RADIUS_MM / 2.0 * radial
            } else {
                size * size / (2.0 * RADIUS_MM) * 1.001
            };
            let mut worst = 0.0f64;
            for (step, c) in ["A1", "A2", "C1", "C2"].iter().zip(coefficients) {
                for (theta, change) in change(&session, step, error, size, composition) {
                    let expected = size * (c[0] + c[1] * theta.cos() + c[2] * theta.sin());
                    worst = worst.max((change - expected).abs());
                }
            }
            println!("{error} {composition:?}: worst {:.3} nm, bound {:.3} nm", worst * 1e6, bound_mm * 1e6);
            assert!(worst < bound_mm, "{error} {composition:?}: {worst:e} mm");
        }
    }
}

/// What one error of the first-order product does to the pivot ball of a step at an angle of the turning axis, mm.
fn displacement(step: &str, error: &str, size: f64, theta: f64) -> Vector3<f64> {
    let name = ErrorName::parse(error, &["A", "C"]).unwrap();
    let mut along = Vector3::zeros();
    along[name.component.direction_index()] = size;
    let (pivot, a, c) = match step {
        "A1" | "A2" => (Vector3::y() * RADIUS_MM, theta, 0.0),
        _ => (Vector3::x() * RADIUS_MM, 0.0, theta),
    };
    let (by_a, by_c) =
        (Rotation3::from_axis_angle(&Vector3::x_axis(), a), Rotation3::from_axis_angle(&Vector3::z_axis(), c));
    // A's error stands outside A's turn; C's stands outside C's, and A turns it
    let of = |place: Vector3<f64>| if name.component.is_angle() { along.cross(&place) } else { along };
    if name.axis == "A" { of(by_a * (by_c * pivot)) } else { by_a * of(by_c * pivot) }
}

#[test]
fn to_second_order_the_closed_forms_hold_within_a_nanometre() {
    let session = session();
    let far_mm = (BAR_MM * BAR_MM - RADIUS_MM * RADIUS_MM).sqrt();
    let mut worst_mm = 0.0f64;
    for error in ["EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"] {
        // Table 3.1: 10 µm and 0.01°
        let is_angle = ErrorName::parse(error, &["A", "C"]).unwrap().component.is_angle();
        let size = if is_angle { 0.01f64.to_radians() } else { 10e-3 };
        for step in ["A1", "A2", "C1", "C2"] {
            for (theta, change) in change(&session, step, error, size, Composition::FirstOrder) {
                let (sin, cos) = theta.sin_cos();
                let bar = match step {
                    "A1" => Vector3::new(0.0, cos, sin) * RADIUS_MM,
                    "A2" => Vector3::new(far_mm, RADIUS_MM * cos, RADIUS_MM * sin),
                    "C1" => Vector3::new(cos, sin, 0.0) * RADIUS_MM,
                    _ => Vector3::new(RADIUS_MM * cos, RADIUS_MM * sin, -far_mm),
                };
                let moved = displacement(step, error, size, theta);
                let along = moved.dot(&bar) / bar.norm();
                let expected = along + (moved.norm_squared() - along * along) / (2.0 * bar.norm());
                worst_mm = worst_mm.max((change - expected).abs());
            }
        }
    }
    println!("worst {:.6} nm", worst_mm * 1e6);
    assert!(worst_mm < 1e-6, "{worst_mm:e} mm");
}

/// Length by eq. 3.20 or, with the spindle ball at −`d_mm`, 3.21, in the symbols printed; `e` holds ey0a ez0a thy0a thz0a
/// ex0c ey0c thx0c thy0c in mm and rad.
fn printed_length(e: [f64; 8], [a, c]: [f64; 2], [r, zca, h, d_mm]: [f64; 4]) -> f64 {
    let [ey0a, ez0a, thy0a, thz0a, ex0c, ey0c, thx0c, thy0c] = e;
    let ((sa, ca), (sc, cc)) = (a.sin_cos(), c.sin_cos());
    let (u, v, w) = (thz0a * ca - thy0a * sa, thy0a * ca + thz0a * sa, thx0c * cc + thy0c * sc);
    let (q, p) = (ey0c + zca * thx0c, ex0c - zca * thy0c);
    let x = u * q - p - h * (thy0c + thx0c * u + v) + zca * v + r * (sc - v * w + cc * u) - d_mm;
    let y = ey0a + ca * q + zca * sa + thz0a * p
        - h * (sa - thz0a * thy0c + thx0c * ca)
        - r * (sa * w - ca * cc + thz0a * sc);
    let z = ez0a + sa * q - zca * ca - thy0a * p - h * (thy0a * thy0c - ca + thx0c * sa)
        + r * (cc * sa + thy0a * sc + ca * w);
    (x * x + y * y + z * z).sqrt()
}

#[test]
fn equations_3_20_and_3_21_as_printed_are_the_first_order_chain() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(320);
    let mut worst = [0.0f64; 2];
    for _ in 0..500 {
        let mut drawn = |bound: f64| random.random_range(-bound..bound);
        // up to 1° and 1 mm: products of errors then show
        let degree = 1f64.to_radians();
        let e: [f64; 8] = std::array::from_fn(|k| drawn(if [0, 1, 4, 5].contains(&k) { 1.0 } else { degree }));
        let (a_deg, c_deg) = (drawn(110.0), drawn(180.0));
        let (zca, h) = (75.0 + drawn(20.0), 75.0 + drawn(20.0));
        let names = ["EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"];
        let sizes: Vec<(&str, f64)> = names
            .into_iter()
            .zip(e)
            .map(|(name, size)| {
                (
                    name,
                    size * if name.starts_with("EY") || name.starts_with("EX") || name.starts_with("EZ") {
                        1e3
                    } else {
                        ARCSEC_PER_RAD
                    },
                )
            })
            .collect();
        for (worst, d_mm) in worst.iter_mut().zip([0.0, 50.0 * 2f64.sqrt()]) {
            // foot at (0, R, −ZCA), ball H above it
            let balls = Balls { pivot: ("C", [0.0, RADIUS_MM, h - zca]), spindle: [-d_mm, 0.0, 0.0] };
            let by_chain = balls.length_mm(&sizes, Composition::FirstOrder, [a_deg, c_deg]);
            let printed = printed_length(e, [a_deg.to_radians(), c_deg.to_radians()], [RADIUS_MM, zca, h, d_mm]);
            *worst = worst.max((by_chain - printed).abs());
        }
    }
    println!("eq. 3.20: {:e} mm, eq. 3.21: {:e} mm", worst[0], worst[1]);
    // rounding: a few dozen operations on lengths of 150 mm
    assert!(worst.iter().all(|worst| *worst < 1e-12 * 150.0), "{worst:?}");
}

#[test]
fn squareness_makes_the_planar_circle_an_ellipse_on_the_diagonal() {
    let session = session();
    for sign in [1.0, -1.0] {
        let squareness_rad = sign * 0.01f64.to_radians();
        let trace = change(&session, "XY circle", "EC0Y", squareness_rad, Composition::Exact);
        let mut worst = 0.0f64;
        for &(theta, change) in &trace {
            worst = worst.max((change + squareness_rad * RADIUS_MM / 2.0 * (2.0 * theta).sin()).abs());
        }
        // remainder: (γR)²/2R
        assert!(worst < (squareness_rad * RADIUS_MM).powi(2) / RADIUS_MM, "{worst:e}");
        let longest = trace.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let diagonal = if sign > 0.0 { 135.0 } else { 45.0 };
        assert!((longest.0.to_degrees().rem_euclid(180.0) - diagonal).abs() < 1.5, "{}", longest.0.to_degrees());
    }
}

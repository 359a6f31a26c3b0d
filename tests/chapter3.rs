//! The thesis's four steps and planar circle against first-order closed forms; inserted errors are known exactly.

use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::load::load_session;
use fiveaxis::machine::ErrorName;
use fiveaxis::session::Session;
use fiveaxis::simulate::trace;

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

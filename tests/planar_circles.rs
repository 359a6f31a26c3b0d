//! Figures of planar circles against closed forms on simulated circles, and against the truth of practice sessions.

use crate::shared_data;
use std::path::Path as FilePath;

use fiveaxis::chain::{Chain, Composition};
use fiveaxis::load::{load_session, machine_from_yaml};
use fiveaxis::machine::{Component, ComponentError, ComponentForm, ErrorName, Machine};
use fiveaxis::methods::{CircleFigures, circles};
use fiveaxis::session::{Ball, CirclePlane, Clock, Motion, Path, Recording, Session, Spread, Test};
use fiveaxis::simulate::simulate;
use nalgebra::Vector3;

const RADIUS_MM: f64 = 100.0;
const ARCSEC_PER_RAD: f64 = 206_264.806_247_096_36;
/// Second-order remainder of the effects inserted here, all below d = 0.05 mm: d²/2R = 12.5 nm.
const SECOND_ORDER_UM: f64 = 0.05 * 0.05 / (2.0 * RADIUS_MM) * 1e3;

fn machine(code: &str) -> Machine {
    machine_from_yaml(FilePath::new("machine.yaml"), format!("name: test\ncode: '{code}'\naxes: {{}}\n")).unwrap()
}

/// A circle about a pivot on the bed side of the table, planned from and to the given angles (degrees).
fn test(machine: &Machine, plane: &str, from: f64, to: f64) -> Test {
    let axis = |letter: usize| machine.axis_index(&plane[letter..letter + 1]).unwrap();
    Test {
        name: format!("{plane} {from} to {to}"),
        recording_file: None,
        recording: None,
        path: Some(Path::Circle {
            plane: CirclePlane { first: axis(0), second: axis(1) },
            radius_mm: RADIUS_MM,
            from,
            to,
            step: 0.5,
        }),
        started_at_s: 0.0,
        bar_length_mm: None,
        bar_setup: None,
        zero: Default::default(),
        bar_error_mm: 0.0,
        pivot: Ball { link: "w".into(), at: Vector3::zeros(), setup: None, spread_mm: None, indexed_about: None },
        spindle_ball: Ball {
            link: "t".into(),
            at: Vector3::zeros(),
            setup: None,
            spread_mm: None,
            indexed_about: None,
        },
        positions: vec![Some(0.0); machine.axes.len()],
        feed_mm_per_min: Some(1000.0),
        overshoot: None,
        marks: None,
        approached: Vec::new(),
        reading: fiveaxis::readings::Reading::Length,
    }
}

fn session(machine: Machine, tests: Vec<Test>) -> Session {
    Session { name: "circles".into(), machine_file: String::new(), machine, spread: Spread::default(), tests }
}

/// Both directions of the planes over the given arc.
fn planes(machine: &Machine, arc: (f64, f64)) -> Vec<Test> {
    let both = |plane| [test(machine, plane, arc.0, arc.1), test(machine, plane, arc.1, arc.0)];
    ["XY", "YZ", "ZX"].into_iter().flat_map(both).collect()
}

/// Figures of the session when its tests are recorded with these lengths.
fn recorded(mut session: Session, lengths: Vec<Vec<f64>>) -> Vec<CircleFigures> {
    for (test, length_mm) in session.tests.iter_mut().zip(lengths) {
        test.recording = Some(Recording {
            clock: Clock::Absent,
            axes: Vec::new(),
            positions: Vec::new(),
            length_mm,
            channels: Vec::new(),
            leading_texts: std::sync::Arc::default(),
            leading_header: String::new(),
            column: Default::default(),
            scatter: None,
        });
    }
    circles(&session).unwrap()
}

/// Figures when the errors in `wrong` are on the machine but not known.
fn seen(nominal: &Machine, wrong: Machine, tests: Vec<Test>) -> Vec<CircleFigures> {
    let lengths = simulate(&session(wrong, tests.clone()), Composition::Exact).unwrap();
    recorded(session(nominal.clone(), tests), lengths.into_iter().map(|trace| trace.length_mm).collect())
}

/// `|R·u − B/2·sgn(velocity) + centre|` sampled by hand: lost motion (mm) of both axes and an offset of the path.
fn with_lost_motion(session: &Session, lost_mm: [f64; 2], centre_mm: [f64; 2]) -> Vec<Vec<f64>> {
    let chain = Chain::of(&session.machine);
    let of_test = |test: &Test| {
        let Some(Path::Circle { from, to, .. }) = &test.path else { panic!("no circle") };
        let rows = Motion::of(session, &chain, test).unwrap().rows();
        let sign = (to - from).signum();
        let length = |row: usize| {
            let angle = (from + (to - from) * row as f64 / (rows - 1) as f64).to_radians();
            let velocity = [-sign * angle.sin(), sign * angle.cos()];
            let nominal = [RADIUS_MM * angle.cos(), RADIUS_MM * angle.sin()];
            let at = [0, 1].map(|k| nominal[k] + centre_mm[k] - lost_mm[k] / 2.0 * velocity[k].signum());
            at[0].hypot(at[1])
        };
        (0..rows).map(length).collect()
    };
    session.tests.iter().map(of_test).collect()
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} and not {expected} ± {tolerance}");
}

#[test]
fn squareness_comes_back_with_its_sign_in_every_plane_whichever_side_carries_the_axes() {
    for code in ["[wCAbYXZt]", "[wCXbYZAt]", "[wZYXbCAt]"] {
        for (slot, plane) in [("EC0Y", "XY"), ("EA0Z", "YZ"), ("EB0Z", "ZX")] {
            let nominal = machine(code);
            let mut wrong = nominal.clone();
            let name = ErrorName::parse(slot, &wrong.axis_names()).unwrap();
            let angle_rad = 0.01f64.to_radians();
            let axis = wrong.axis_index(&name.axis).unwrap();
            wrong.axes[axis].location_errors[name.component.index()] = angle_rad;
            for arc in [(0.0, 360.0), (-20.0, 200.0)] {
                let figures = seen(&nominal, wrong.clone(), planes(&nominal, arc));
                let circle = figures.iter().find(|circle| circle.plane == plane).unwrap();
                let what = format!("{code} {slot} {arc:?}");
                assert_eq!(circle.squareness.location_error, slot, "{what}");
                // exact remainder: the deviation's second order turns up in cos 4φ and the radius, not in sin 2φ
                close(circle.squareness.location_error_arcsec, angle_rad * ARCSEC_PER_RAD, 0.02, &what);
                if arc.1 == 360.0 {
                    // δ = −γR/2·sin 2φ: a width of γR
                    let width_um = angle_rad * RADIUS_MM * 1e3;
                    for direction in [&circle.ccw, &circle.cw] {
                        close(direction.as_ref().unwrap().circular_deviation_um, width_um, SECOND_ORDER_UM, &what);
                    }
                    close(circle.bidirectional_circular_deviation_um.unwrap(), width_um, SECOND_ORDER_UM, &what);
                    close(circle.circular_hysteresis_um.unwrap(), 0.0, 1e-9, &what);
                }
            }
        }
    }
}

#[test]
fn a_scale_error_shows_as_mismatch_and_as_radius() {
    let nominal = machine("[wCAbYXZt]");
    let mut wrong = nominal.clone();
    let x = wrong.axis_index("X").unwrap();
    // 50 ppm: X runs 10 µm too far over the diameter
    wrong.axes[x].component_errors =
        vec![ComponentError { component: Component::EX, form: ComponentForm::Polynomial(vec![50e-6]) }];
    let figures = seen(&nominal, wrong, planes(&nominal, (0.0, 360.0)));
    for (circle, sign) in figures.iter().zip([1.0, 0.0, -1.0]) {
        close(circle.scale_mismatch_ppm, sign * 50.0, 0.1, &circle.plane);
        close(circle.scale_mismatch_um, sign * 10.0, 0.02, &circle.plane);
        close(circle.radius_deviation_um.unwrap(), sign.abs() * 2.5, SECOND_ORDER_UM, &circle.plane);
        close(circle.mean_bidirectional_radial_deviation_um.unwrap(), sign.abs() * 2.5, 0.1, &circle.plane);
        let ccw = circle.ccw.as_ref().unwrap();
        close(ccw.circular_deviation_um, sign.abs() * 5.0, 0.02, &circle.plane);
        // F is about the centre but keeps the radius: 0 to 5 µm
        close(ccw.radial_deviation_max_um.unwrap(), sign.abs() * 5.0, 0.02, &circle.plane);
        close(ccw.radial_deviation_min_um.unwrap(), 0.0, 0.02, &circle.plane);
    }
}

#[test]
fn lost_motion_of_each_axis_comes_back_beside_an_eccentric_pivot() {
    let nominal = machine("[wCAbYXZt]");
    for (arc, ends) in [((0.0, 360.0), [2, 2]), ((-45.0, 315.0), [2, 2]), ((-20.0, 200.0), [2, 1])] {
        let tests = vec![test(&nominal, "XY", arc.0, arc.1), test(&nominal, "XY", arc.1, arc.0)];
        let planned = session(nominal.clone(), tests);
        let lengths = with_lost_motion(&planned, [6e-3, -3e-3], [30e-3, -20e-3]);
        let figures = recorded(planned, lengths);
        let [circle] = &figures[..] else { panic!("{} circles", figures.len()) };
        let what = format!("{arc:?}");
        close(circle.centre_um[0], 30.0, 0.05, &what);
        close(circle.centre_um[1], -20.0, 0.05, &what);
        for (axis, (lost_um, ends)) in circle.axes.iter().zip([(6.0, ends[0]), (-3.0, ends[1])]) {
            close(axis.backlash_um.unwrap(), lost_um, 0.02, &what);
            close(axis.half_gap_um.unwrap(), lost_um / 2.0, 0.01, &what);
            // a full turn that starts at an end sees it on one side of each run only, yet on both over the two
            assert_eq!(axis.ends.len(), ends, "{what}: {axis:?}");
            for end in &axis.ends {
                close(end.step_um, lost_um, 0.05, &what);
                close(end.spike_um, 0.0, 0.05, &what);
            }
        }
        close(circle.squareness.angle_arcsec, 0.0, 0.1, &what);
        // both directions differ by 6·cos φ + 3·sin φ in the first quadrant: at most √45
        close(circle.circular_hysteresis_um.unwrap(), 45f64.sqrt(), 0.03, &what);
    }
}

#[test]
fn a_spike_after_a_reversal_is_a_spike_and_not_backlash() {
    let nominal = machine("[wCAbYXZt]");
    let tests = vec![test(&nominal, "XY", 45.0, 405.0), test(&nominal, "XY", 405.0, 45.0)];
    let planned = session(nominal.clone(), tests);
    let mut lengths = with_lost_motion(&planned, [0.0; 2], [0.0; 2]);
    for (lengths, upward) in lengths.iter_mut().zip([true, false]) {
        let rows = lengths.len();
        for (row, length) in lengths.iter_mut().enumerate() {
            let along = 45.0 + 360.0 * row as f64 / (rows - 1) as f64;
            let since = if upward { along - 360.0 } else { 405.0 - (along - 45.0) - 360.0 };
            // 8 µm for a degree after +X, then fading until 3 degrees
            let since = if upward { since } else { -since };
            if (0.0..3.0).contains(&since) {
                *length += 8e-3 * ((3.0 - since) / 2.0).min(1.0);
            }
        }
    }
    let figures = recorded(planned, lengths);
    let x = &figures[0].axes[0];
    println!("{x:?}");
    assert_eq!(x.ends[0].end, "+X");
    close(x.ends[0].spike_um, 8.0, 0.01, "spike");
    close(x.ends[0].step_um, 0.0, 0.01, "step");
    close(x.ends[1].spike_um, 0.0, 0.01, "other end");
}

#[test]
fn one_direction_alone_gives_no_figures_of_two() {
    let nominal = machine("[wCAbYXZt]");
    let planned = session(nominal.clone(), vec![test(&nominal, "ZX", 360.0, 0.0)]);
    let lengths = with_lost_motion(&planned, [4e-3, 0.0], [0.0; 2]);
    let figures = recorded(planned, lengths);
    let circle = &figures[0];
    assert!(circle.ccw.is_none() && circle.cw.is_some());
    assert!(circle.circular_hysteresis_um.is_none() && circle.bidirectional_circular_deviation_um.is_none());
    close(circle.axes[0].backlash_um.unwrap(), 4.0, 0.05, "backlash from one direction");
}

#[test]
fn a_short_arc_is_no_circle_test() {
    let nominal = machine("[wCAbYXZt]");
    let planned = session(nominal.clone(), vec![test(&nominal, "XY", 10.0, 30.0), test(&nominal, "XY", 0.0, 360.0)]);
    let lengths = with_lost_motion(&planned, [0.0; 2], [0.0; 2]);
    assert_eq!(recorded(planned, lengths).len(), 1);
}

#[test]
fn practice_circles_show_what_was_concealed() {
    let Some(folder) = shared_data::folder("recordings/practice") else { return };
    // truth: EC0Y = −12.84 arcsec; Z backlash of half width 1.025 µm, of which about half is taken up over 1.5 mm
    for circle in circles(&load_session(&folder.join("case-009/session.yaml")).unwrap()).unwrap() {
        match circle.plane.as_str() {
            "XY" => close(circle.squareness.location_error_arcsec, -12.84, 0.3, "EC0Y"),
            _ => {
                let z = circle.axes.iter().find(|axis| axis.axis == "Z").unwrap();
                // a step that is taken up slowly reads low: part of it lies in the readings left out after a reversal
                close(z.half_gap_um.unwrap(), 1.025, 0.3, &circle.plane);
            }
        }
        close(circle.axes.iter().find(|axis| axis.axis != "Z").unwrap().backlash_um.unwrap(), 0.0, 0.4, &circle.plane);
    }
    // truth: X spikes of 4.1 µm at 500 mm/min and 12.0 µm at 2000 mm/min
    for circle in circles(&load_session(&folder.join("case-004/session.yaml")).unwrap()).unwrap() {
        let expected_um = if circle.feed_mm_per_min == Some(500.0) { 4.12 } else { 11.97 };
        for end in circle.axes.iter().flat_map(|axis| &axis.ends) {
            let is_x = end.end.ends_with('X');
            // three times the noise of 0.38 µm: the largest of some thirty readings stands out by two of them
            close(
                if is_x { end.spike_um } else { end.spike_um.abs().min(0.8) },
                if is_x { expected_um } else { 0.4 },
                1.13,
                &end.end,
            );
        }
    }
}

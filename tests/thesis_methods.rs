//! The thesis's estimators on simulated sessions of its designs: what they return, and what each approximation costs.

use std::path::PathBuf;

use fiveaxis::chain::Composition;
use fiveaxis::load::load_session;
use fiveaxis::machine::ErrorName;
use fiveaxis::methods::{MethodError, ThesisEstimate, chapter4, chapter5, chapter6, turning_circle};
use fiveaxis::report;
use fiveaxis::session::Session;
use fiveaxis::simulate::simulate;

type Method = fn(&Session) -> Result<ThesisEstimate, MethodError>;
const METHODS: [(u8, Method); 3] = [(4, chapter4), (5, chapter5), (6, chapter6)];
const RADIUS_MM: f64 = 100.0;

fn session(chapter: u8) -> Session {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/thesis");
    load_session(&folder.join(format!("chapter{chapter}/session.yaml"))).unwrap()
}

fn truth(chapter: u8) -> serde_json::Value {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/thesis");
    let text = std::fs::read_to_string(folder.join(format!("chapter{chapter}/truth.json"))).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Inserted errors in µm and arcsec.
fn inserted(truth: &serde_json::Value, name: &ErrorName) -> f64 {
    truth["location_errors"][name.to_string()]["value"].as_f64().unwrap()
}

/// The session with noiseless lengths of its own motions and the true errors; `shift` moves the pivots (mm, on the link).
fn noiseless(chapter: u8, composition: Composition, shift: [f64; 3]) -> Session {
    let recorded = session(chapter);
    let truth = truth(chapter);
    let mut wrong = recorded.clone();
    for name in recorded.machine.slots().iter().filter(|name| ["A", "C"].contains(&name.axis.as_str())) {
        let axis = wrong.machine.axis_index(&name.axis).unwrap();
        let value = inserted(&truth, name) / name.component.measure().to_output(1.0);
        wrong.machine.axes[axis].location_errors[name.component.index()] = value;
    }
    for test in &mut wrong.tests {
        test.pivot.at += nalgebra::Vector3::from(shift);
    }
    let traces = simulate(&wrong, composition).unwrap();
    let mut simulated = recorded;
    for (test, trace) in simulated.tests.iter_mut().zip(traces) {
        test.recording.as_mut().unwrap().length_mm = trace.length_mm;
    }
    simulated
}

/// Largest difference to the inserted errors in µm (positions) and arcsec (orientations).
fn worst(chapter: u8, estimate: &ThesisEstimate, truth: &serde_json::Value) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for value in &estimate.values {
        let found = value.name.component.measure().to_output(value.value);
        let difference = found - inserted(truth, &value.name);
        println!("chapter {chapter} {}: found {found:.4}, difference {difference:+.6}", value.name);
        let kind = usize::from(value.name.component.is_angle());
        worst[kind] = worst[kind].max(difference.abs());
    }
    assert_eq!(estimate.values.len(), 8);
    worst
}

#[test]
fn estimators_return_the_inserted_errors_to_second_order() {
    for (chapter, method) in METHODS {
        for composition in [Composition::Exact, Composition::FirstOrder] {
            let estimate = method(&noiseless(chapter, composition, [0.0; 3])).unwrap();
            let [position_um, angle_arcsec] = worst(chapter, &estimate, &truth(chapter));
            println!("chapter {chapter} {composition:?}: {position_um:.6} µm, {angle_arcsec:.6} arcsec");
            // second order: an offset c of the centre across the bar moves the reading by c²/2R. The A centres are within
            // c = 0.04 mm; a centre from 90° of arc takes up to six times that (its normal equations' inverse), full
            // turns take none of it; the extended bar's tilt is the difference of two such centres over D = 111.8 mm
            let circle_um = 0.04 * 0.04 / (2.0 * RADIUS_MM) * 1e3;
            assert!(position_um < 6.0 * circle_um, "{position_um}");
            assert!(angle_arcsec < 12.0 * circle_um * 1e-3 / 111.8 * 206_264.8, "{angle_arcsec}");
        }
    }
}

#[test]
fn start_position_correction_costs_nothing_and_its_absence_a_tenth_more_than_the_pivot_is_off() {
    // pivots 40 µm further out: what an adjustment at the start position does
    for chapter in [4, 5] {
        let (_, method) = METHODS[usize::from(chapter) - 4];
        let plain = method(&noiseless(chapter, Composition::Exact, [0.0; 3])).unwrap();
        // outward along y for the A tests
        let moved = method(&noiseless(chapter, Composition::Exact, [0.0, 0.04, 0.0])).unwrap();
        for (a, b) in plain.values.iter().zip(&moved.values).take(4) {
            let difference = a.name.component.measure().to_output(b.value - a.value);
            println!("chapter {chapter} {}: pivot 40 µm further out changes it by {difference:+.5}", a.name);
            assert!(difference.abs() < 0.1, "{}", a.name);
        }
    }
    // without the correction the radius is held at its nominal value and the constant leaks into the centre: by
    // δ·sin(w)/w / (½ + sin(2w)/4w) along the middle of an arc of half width w
    let shifted = noiseless(4, Composition::Exact, [0.0, 0.04, 0.0]);
    let chain = fiveaxis::chain::Chain::of(&shifted.machine);
    let axis = shifted.machine.axis_index("A").unwrap();
    let circle = turning_circle(&shifted, &chain, 0, axis).unwrap();
    let before = noiseless(4, Composition::Exact, [0.0; 3]);
    let before = turning_circle(&before, &chain, 0, axis).unwrap();
    let leak = |circle: &fiveaxis::methods::TurningCircle| held_radius_centre(circle, RADIUS_MM);
    let leaked = (leak(&circle) - leak(&before)).norm();
    let w = 45f64.to_radians();
    let expected = 0.04 * (w.sin() / w) / (0.5 + (2.0 * w).sin() / (4.0 * w));
    println!("radius held: the centre moves by {:.2} µm for 40 µm; closed form {:.2} µm", leaked * 1e3, expected * 1e3);
    // the sum over the samples stands for the integral, the ends count half too much
    assert!((leaked - expected).abs() < 2.0 * expected / circle.rows.len() as f64);
    assert!((circle.centre_mm - before.centre_mm).norm() < 1e-4);
    assert!((circle.radius_mm - before.radius_mm - 0.04).abs() < 1e-4);
}

/// First-order centre with the radius held: least squares of `ρ − R = c·u`.
fn held_radius_centre(circle: &fiveaxis::methods::TurningCircle, radius_mm: f64) -> nalgebra::Vector2<f64> {
    let mut normal = nalgebra::Matrix2::zeros();
    let mut right = nalgebra::Vector2::zeros();
    for (&angle, &length) in circle.angle_rad.iter().zip(&circle.length_mm) {
        let u = nalgebra::Vector2::new(angle.cos(), angle.sin());
        normal += u * u.transpose();
        right += u * ((length * length - circle.reach_mm.powi(2)).sqrt() - radius_mm);
    }
    normal.try_inverse().unwrap() * right
}

#[test]
fn reconstructed_sessions_come_out_within_their_noise_and_spindle_ball() {
    for (chapter, method) in METHODS {
        let session = session(chapter);
        let estimate = method(&session).unwrap();
        println!("{}", report::thesis::thesis_text(&estimate, &session));
        let truth = truth(chapter);
        let ball = &truth["spindle_balls"][0]["error_um"];
        let mut worst = [0.0f64; 2];
        for value in &estimate.values {
            // places are relative to the spindle ball: its error is taken off the outer axis's, the inner one's y is a
            // difference of two such places
            let k = value.name.component.direction_index();
            let ball_um = match (value.name.component.is_angle(), value.name.axis.as_str(), k) {
                (true, ..) | (false, "C", 1) => 0.0,
                _ => ball[k].as_f64().unwrap(),
            };
            let found = value.name.component.measure().to_output(value.value);
            let difference = found - (inserted(&truth, &value.name) - ball_um);
            println!("  {:<6} found {found:8.2}  off {difference:+.2}", value.name.to_string());
            let kind = usize::from(value.name.component.is_angle());
            worst[kind] = worst[kind].max(difference.abs());
            // recovery under noise: four of the standard deviations that the repeats tell
            let deviation = value.name.component.measure().to_output(value.mean_deviation.unwrap());
            assert!(difference.abs() < 4.0 * deviation, "{}: {difference} with {deviation}", value.name);
        }
        println!("chapter {chapter}: worst {:.2} µm, {:.2} arcsec\n", worst[0], worst[1]);
        assert!(worst[0] < 1.0 && worst[1] < 1.0, "{worst:?}");
        for trace in &estimate.traces {
            let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt() * 1e3;
            assert!(rms(&trace.residual_mm) < 0.6, "{}: {}", trace.test, rms(&trace.residual_mm));
        }
        let json = report::thesis::thesis_json(&estimate, &session);
        assert_eq!(json["location_errors"].as_object().unwrap().len(), 8);
        assert_eq!(json["location_errors"]["EB0A"]["unit"], "arcsec");
    }
}

#[test]
fn a_recording_of_lengths_alone_is_spread_evenly_over_its_arc() {
    let full = noiseless(5, Composition::Exact, [0.0; 3]);
    let mut bare = full.clone();
    for test in &mut bare.tests {
        let recording = test.recording.as_mut().unwrap();
        let axis = recording.axes[0];
        let column = &recording.positions[0];
        let (from, to) = (column[0].to_degrees(), column[column.len() - 1].to_degrees());
        test.path = Some(fiveaxis::session::Path::Sweep {
            axis,
            from,
            to,
            step: 1.0,
            follow: fiveaxis::session::Follow::None,
            length_mm: None,
        });
        recording.clock = fiveaxis::session::Clock::Absent;
        recording.axes.clear();
        recording.positions.clear();
    }
    let (one, other) = (chapter5(&full).unwrap(), chapter5(&bare).unwrap());
    for (a, b) in one.values.iter().zip(&other.values) {
        // commanded positions are printed to 1e-5 degrees
        let difference = a.name.component.measure().to_output(a.value - b.value);
        assert!(difference.abs() < 0.01, "{}: {difference}", a.name);
    }
}

#[test]
fn a_session_of_another_design_is_told_which_test_is_missing() {
    let chapter_six = session(6);
    let message = chapter4(&chapter_six).unwrap_err().to_string();
    assert!(message.contains("chapter4 needs a test of A with extension"), "{message}");
    let message = chapter6(&session(5)).unwrap_err().to_string();
    assert!(message.contains("chapter6 needs tests of A without extension at two positions"), "{message}");
    // chapter 4's own design mounts the pivot twice
    let message = chapter5(&session(4)).unwrap_err().to_string();
    assert!(
        message.contains("chapter5 needs a test of C without extension") && message.contains("same pivot"),
        "{message}"
    );
    let mut none = session(4);
    none.tests.retain(|test| !test.name.starts_with("c-extended"));
    let message = chapter4(&none).unwrap_err().to_string();
    assert!(
        message.contains("a test of C with extension") && message.contains("C without extension at 0.0 mm (10 runs)")
    );
}

/// A B/C table whose axes do not meet, with planned sweeps after chapter 6.
const OTHER_TABLE: &str = "name: BC table
code: '[wCBbXYZt]'
axes:
  B: {origin: [0, 0, -50]}
  C: {origin: [0, 0, 20]}
";

#[test]
fn a_b_c_table_whose_axes_do_not_meet_comes_out_as_well() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.yaml"), OTHER_TABLE).unwrap();
    let mut text = String::from("machine: machine.yaml\ntests:\n");
    for (name, axis, pivot, still, arc) in [
        ("b-1", "B", "[100, -200, -50]", "{X: 0, Y: -200, Z: -50, C: 0}", (-40, 80)),
        ("b-2", "B", "[100, 200, -50]", "{X: 0, Y: 200, Z: -50, C: 0}", (-40, 80)),
        ("c-1", "C", "[100, 0, 0]", "{X: 0, Y: 0, Z: 0, B: 0}", (0, 360)),
        ("c-2", "C", "[100, 0, 150]", "{X: 0, Y: 0, Z: 150, B: 0}", (0, 360)),
    ] {
        text += &format!(
            "  - {{name: {name}, pivot: {{link: w, at: {pivot}}}, spindle_ball: {{link: t, at: [0, 0, 0]}}, \
             positions: {still}, sweep: {{axis: {axis}, from: {}, to: {}, step: 1}}}}\n",
            arc.0, arc.1
        );
    }
    std::fs::write(folder.path().join("session.yaml"), text).unwrap();
    let planned = load_session(&folder.path().join("session.yaml")).unwrap();
    let mut wrong = planned.clone();
    let inserted = [
        ("EX0B", 21.0),
        ("EZ0B", -13.0),
        ("EA0B", 8.0),
        ("EC0B", -5.0),
        ("EX0C", -7.0),
        ("EY0C", 17.0),
        ("EA0C", -9.0),
        ("EB0C", 6.0),
    ];
    for (name, size) in inserted {
        let name = ErrorName::parse(name, &wrong.machine.axis_names()).unwrap();
        let axis = wrong.machine.axis_index(&name.axis).unwrap();
        let value = size / name.component.measure().to_output(1.0);
        wrong.machine.axes[axis].location_errors[name.component.index()] = value;
    }
    let mut recorded = planned;
    for (test, trace) in recorded.tests.iter_mut().zip(simulate(&wrong, Composition::Exact).unwrap()) {
        test.recording = Some(fiveaxis::session::Recording {
            clock: fiveaxis::session::Clock::Absent,
            axes: Vec::new(),
            positions: Vec::new(),
            length_mm: trace.length_mm,
            channels: Vec::new(),
            leading_texts: std::sync::Arc::default(),
            leading_header: String::new(),
            column: Default::default(),
            scatter: None,
        });
    }
    let estimate = chapter6(&recorded).unwrap();
    for (name, size) in inserted {
        let value = estimate.values.iter().find(|value| value.name.to_string() == name).unwrap();
        let found = value.name.component.measure().to_output(value.value);
        println!("{name}: found {found:.4}, inserted {size}");
        assert!((found - size).abs() < 0.02, "{name}: {found}");
        assert!(value.run_deviation.is_none(), "a single run has no standard deviation");
    }
}

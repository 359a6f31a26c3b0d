//! Signs in words and numbers for a control against the forward kinematics.

use crate::recorded;
use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::control::{tables, without_travel};
use fiveaxis::identify::{AxisLine, Options, axis_lines, identify};
use fiveaxis::load::{load_session, machine_from_yaml};
use fiveaxis::machine::{Component, ComponentError, ComponentForm, Harmonic, Machine};
use fiveaxis::report::words::{control_in_words, sign_in_words};
use fiveaxis::session::Session;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

fn machine(yaml: &str) -> Machine {
    machine_from_yaml(Path::new("machine.yaml"), yaml.to_string()).unwrap()
}

/// A point of the line of an axis and its direction at the zero position, by turning two points about it.
fn line_by_turning(machine: &Machine, axis: usize) -> (Vector3<f64>, Vector3<f64>) {
    let chain = Chain::of(machine);
    let geometry = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
    let link = chain.carried_by(axis);
    let place = |at: &Vector3<f64>, angle: f64| {
        let mut positions = vec![0.0; chain.axis_count()];
        positions[axis] = angle;
        geometry.point(link, at, &positions, None)
    };
    // half a turn apart, two places of a point have the axis in their middle
    let half = std::f64::consts::PI;
    let middle = |at: Vector3<f64>| (place(&at, 0.0) + place(&at, half)) / 2.0;
    let along = chain.joint(axis).direction;
    let origin = chain.joint(axis).origin;
    let across = along.cross(&Vector3::new(0.3, 0.5, 0.8)) * 100.0;
    let (low, high) = (middle(origin + across), middle(origin + across + along * 500.0));
    (low, (high - low).normalize())
}

#[test]
fn words_of_signs_say_where_the_line_goes() {
    let base = "name: m\ncode: \"[wCAbYXZt]\"\naxes: {X: {}}\n";
    for (axis_name, component) in [
        ("C", Component::EX),
        ("C", Component::EY),
        ("C", Component::EA),
        ("C", Component::EB),
        ("A", Component::EY),
        ("A", Component::EZ),
        ("A", Component::EB),
        ("A", Component::EC),
    ] {
        let mut machine = machine(base);
        let axis = machine.axis_index(axis_name).unwrap();
        let nominal = line_by_turning(&machine, axis);
        machine.axes[axis].location_errors[component.index()] = 1e-3;
        let (point, direction) = line_by_turning(&machine, axis);
        let words = sign_in_words(&machine, axis, component);
        let moved = if component.is_angle() { direction - nominal.1 } else { point - nominal.0 };
        let k = moved.iamax();
        let signed = format!("{}{}", if moved[k] > 0.0 { '+' } else { '-' }, ['x', 'y', 'z'][k]);
        let phrase = match component.is_angle() {
            true => format!("end leans towards {signed}"),
            false => format!("lies on the {signed} side"),
        };
        assert!(words.contains(&phrase), "{words} against {signed} by {moved:?}");
        assert!((moved[k].abs() - 1e-3).abs() < 1e-8);
    }
    // a linear axis: the direction of motion
    let mut machine = machine(base);
    let z = machine.axis_index("Z").unwrap();
    machine.axes[z].location_errors[Component::EA.index()] = 1e-3;
    let chain = Chain::of(&machine);
    let geometry = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
    let mut positions = vec![0.0; chain.axis_count()];
    positions[z] = 100.0;
    let there = geometry.point(chain.carried_by(z), &Vector3::zeros(), &positions, None);
    assert!(there.y < -0.09);
    assert!(sign_in_words(&machine, z, Component::EA).contains("+z end leans towards -y"));
}

fn chapter5() -> Session {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5/session.yaml");
    load_session(&file).unwrap()
}

fn lines_of(session: &Session) -> (Vec<AxisLine>, Machine) {
    let fit = identify(session, &Options::default()).unwrap();
    (axis_lines(session, &fit), fiveaxis::identify::fitted_session(session, &fit).machine)
}

#[test]
fn numbers_for_the_control_are_where_the_fitted_lines_stand() {
    let mut session = chapter5();
    let x = session.machine.axis_index("X").unwrap();
    session.machine.machine_zero[x] = Some(-412.5);
    let (lines, fitted) = lines_of(&session);
    assert_eq!(lines.len(), 2);
    for line in &lines {
        let (point, direction) = line_by_turning(&fitted, line.axis);
        let along = fitted.axes[line.axis].direction;
        let off = point - along * along.dot(&point) - line.shift_mm;
        assert!(off.norm() < 1e-6, "{off:?}");
        assert!((direction - line.direction).norm() < 1e-7, "{direction:?} {:?}", line.direction);
        assert!(line.determined);
    }
    let c = lines.iter().find(|line| fitted.axes[line.axis].name == "C").unwrap();
    let a = lines.iter().find(|line| fitted.axes[line.axis].name == "A").unwrap();
    assert_eq!((c.carrier, a.carrier), (Some(a.axis), None));
    // the vector from A to C changes by C's own errors alone
    let own = &fitted.axes[c.axis].location_errors;
    // 1e-5: the carrier is turned by some 6e-5 rad, which the sum of 52 µm and that angle feels in nanometres
    assert!((c.from_carrier_mm.x - own[0]).abs() < 1e-5 && (c.from_carrier_mm.y - own[1]).abs() < 1e-5);
    // X carries the spindle: it stands over the line at the zero's reading plus the shift
    let reading = c.centre_at.iter().find(|reading| reading.axis == x).unwrap();
    assert!(reading.is_machine_coordinate && (reading.reading_mm - (-412.5 + c.shift_mm.x)).abs() < 1e-12);
    // known to what the spindle ball is known, 1 µm
    assert!((reading.sigma_mm - 1e-3).abs() < 2e-4, "{}", reading.sigma_mm);
    let words = control_in_words(&fitted, c);
    assert!(words.starts_with("C: add x ") && words.contains("to the vector from A to C"), "{words}");
    assert!(control_in_words(&fitted, a).starts_with("A: move the table centre in the control by y "));
}

#[test]
fn a_line_that_is_open_is_not_to_be_entered() {
    let mut session = chapter5();
    session.tests.retain(|test| test.name.starts_with("c-short"));
    let (lines, machine) = lines_of(&session);
    let a = lines.iter().find(|line| machine.axes[line.axis].name == "A").unwrap();
    assert!(!a.determined);
    assert!(control_in_words(&machine, a).ends_with("NOT determined by these recordings: do not enter it"));
}

#[test]
fn an_axis_without_a_stated_travel_has_its_tables_or_is_named() {
    let of = |errors: [ComponentError; 3]| {
        let mut machine = machine("name: m\ncode: \"[wCAbYXZt]\"\naxes: {}\n");
        let [x, y, c] = errors;
        for (name, error) in [("X", x), ("Y", y), ("C", c)] {
            let axis = machine.axis_index(name).unwrap();
            machine.axes[axis].component_errors.push(error);
        }
        machine
    };
    let table = ComponentForm::Table { position: vec![-100.0, 100.0], value: vec![0.0, 0.02] };
    let wave = ComponentForm::Fourier(vec![Harmonic { frequency: 1.0, cosine: 0.01, sine: 0.0 }]);
    let machine = of([
        ComponentError { component: Component::EX, form: table },
        ComponentError { component: Component::EY, form: ComponentForm::Polynomial(vec![1e-4]) },
        ComponentError { component: Component::EX, form: wave },
    ]);
    let tables = tables(&machine);
    let ends = |error: &str| {
        let rows = &tables.iter().find(|table| table.error == error).expect(error).rows;
        (rows[0].0, rows[rows.len() - 1].0)
    };
    assert_eq!(ends("EXX"), (-100.0, 100.0));
    assert!(ends("EXC").0 == 0.0 && (ends("EXC").1 - std::f64::consts::TAU).abs() < 1e-12);
    assert_eq!((tables.len(), without_travel(&machine)), (2, vec!["EYY".to_string()]));
}

#[test]
fn a_table_that_the_axis_carries_is_centred_from_the_other_side() {
    // X carries the table: to bring a line at +x under the spindle the table goes to −x, which an ISO axis reads as +x
    for (directions, reversed, sign) in
        [("carried", "false", -1.0), ("carried", "true", 1.0), ("iso841", "false", 1.0), ("iso841", "true", -1.0)]
    {
        let yaml = format!(
            "name: m\ncode: \"[wCXbYZAt]\"\ndirections: {directions}\naxes:\n  X: {{reversed: {reversed}}}\n  C: {{origin: [30, 0, 0], errors: {{EX0C: 50 um}}}}\n"
        );
        let mut session = chapter5();
        session.machine = machine(&yaml);
        for test in &mut session.tests {
            test.recording = None;
            test.recording_file = None;
            test.positions = vec![Some(0.0); 5];
            test.path = Some(fiveaxis::session::Path::Sweep {
                axis: session.machine.axis_index("C").unwrap(),
                from: 0.0,
                to: 360.0,
                step: 5.0,
                follow: fiveaxis::session::Follow::None,
                length_mm: None,
            });
            test.pivot.at = Vector3::new(130.0, 0.0, 0.0);
            test.spindle_ball.at = Vector3::new(30.0, 0.0, 0.0);
            test.spindle_ball.link = "A".into();
        }
        session.tests.truncate(2);
        let traces = fiveaxis::simulate::simulate(&session, Composition::Exact).unwrap();
        let mut bare = session.clone();
        bare.machine.axes.iter_mut().for_each(|axis| axis.location_errors = [0.0; 6]);
        let (lines, _) = lines_of(&recorded::recorded(&bare, &traces));
        let c = lines.iter().find(|line| session.machine.axes[line.axis].name == "C").unwrap();
        let x = session.machine.axis_index("X").unwrap();
        let reading = c.centre_at.iter().find(|reading| reading.axis == x).unwrap();
        assert!((reading.reading_mm - sign * 30.05).abs() < 1e-3, "{}", reading.reading_mm);
        let says = control_in_words(&session.machine, c);
        let against = "; X counts against x: a parameter that holds readings takes that part with the opposite sign";
        assert_eq!(says.contains(against), sign < 0.0, "{says}");
        // places in R hold whatever the sense
        assert!((c.shift_mm - Vector3::new(0.05, 0.0, 0.0)).norm() < 1e-3, "{:?}", c.shift_mm);
        // the spindle's own rotary axis is a head
        assert!(lines.iter().any(|line| line.is_head && line.centre_at.is_empty()));
    }
}

/// Joints of LinuxCNC's `xyzac-trt-kins` for a place on the workpiece, written from its notes: C turns about the rot-point,
/// A about rot-point plus offset; the pins are `x-rot-point`, `y-rot-point`, `z-rot-point`, `y-offset`, `z-offset`.
fn xyzac_joints(place: &Vector3<f64>, a: f64, c: f64, pins: [f64; 5]) -> Vector3<f64> {
    let [x_rot, y_rot, z_rot, y_offset, z_offset] = pins;
    let about = |axis: Vector3<f64>, angle: f64, at: Vector3<f64>, point: Vector3<f64>| {
        at + nalgebra::Rotation3::new(axis * angle) * (point - at)
    };
    let turned = about(Vector3::z(), c, Vector3::new(x_rot, y_rot, 0.0), *place);
    about(Vector3::x(), a, Vector3::new(0.0, y_rot + y_offset, z_rot + z_offset), turned)
}

#[test]
fn linuxcnc_pins_move_as_the_notes_on_controls_say() {
    let base = "name: m\ncode: \"[wCAbXYZt]\"\naxes:\n  C: {origin: [10, -20, 0]}\n  A: {origin: [0, -35, -60]}\n";
    let nominal = [10.0, -20.0, 0.0, -15.0, -60.0];
    let mut machine = machine(base);
    let joints = |machine: &Machine, place: &Vector3<f64>, a: f64, c: f64| {
        let chain = Chain::of(machine);
        let geometry = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
        let mut q = vec![0.0; 5];
        q[machine.axis_index("A").unwrap()] = a;
        q[machine.axis_index("C").unwrap()] = c;
        geometry.point(chain.link("C").unwrap(), place, &q, None)
    };
    let (ca, aa) = (machine.axis_index("C").unwrap(), machine.axis_index("A").unwrap());
    let place = Vector3::new(83.0, -41.0, 22.0);
    for (pins, errors) in [
        (nominal, [0.0; 4]),
        // own errors of C in x and y, of A in y and z
        ([10.5, -20.0 + 0.3 + 0.2, 0.7, -15.0 - 0.3, -60.0], [0.5, 0.3, 0.2, 0.7]),
    ] {
        machine.axes[ca].location_errors[0] = errors[0];
        machine.axes[ca].location_errors[1] = errors[1];
        machine.axes[aa].location_errors[1] = errors[2];
        machine.axes[aa].location_errors[2] = errors[3];
        // LinuxCNC counts places from where the workpiece stands with all axes at zero
        let at_zero = joints(&machine, &place, 0.0, 0.0);
        for (a, c) in [(0.4, -1.1), (-0.3, 2.5), (1.2, 0.2)] {
            let off = joints(&machine, &place, a, c) - xyzac_joints(&at_zero, a, c, pins);
            assert!(off.norm() < 1e-9, "{off:?}");
            let wrong = joints(&machine, &place, a, c)
                - xyzac_joints(&at_zero, a, c, [pins[0], pins[1], pins[2], pins[3] + 0.6, pins[4]]);
            assert!(wrong.norm() > 0.01);
        }
    }
}

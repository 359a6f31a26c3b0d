//! Machines and sessions as the YAML that `load` reads: reading back gives the same values. Writes no file.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};

use super::effect_yaml::effect_yaml;
use super::yaml_text::text;
use crate::machine::{Axis, AxisKind, CarriedBranch, ComponentError, ComponentForm, ErrorName, Harmonic, Machine};
use crate::readings::{Kind, Part, quaternion};
use crate::report::wording::number::{position, quantity, reading_back, scaled_quantity};
use crate::session::{Ball, Path, Session, Test, Zero};
use crate::units::Measure;

/// A machine file.
pub fn machine_yaml(machine: &Machine) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "name: {}", text(&machine.name));
    let code = machine.code.to_string();
    // a code of letters is one word, a chain of names a list
    if code.contains(',') {
        let names: Vec<String> = code.trim_matches(['[', ']']).split(", ").map(text).collect();
        let _ = writeln!(out, "chain: [{}]", names.join(", "));
    } else {
        let _ = writeln!(out, "code: \"{code}\"");
    }
    if let Some(directions) = machine.directions {
        let _ = writeln!(out, "directions: {directions}");
    }
    out.push_str("axes:\n");
    for axis in &machine.axes {
        axis_yaml(&mut out, axis);
    }
    if machine.gravity != -Vector3::z() {
        let _ = writeln!(out, "gravity: {}", vector(&machine.gravity));
    }
    let zeros: Vec<String> = machine
        .axes
        .iter()
        .zip(&machine.machine_zero)
        .filter_map(|(axis, zero)| zero.map(|zero| format!("{}: {zero}", text(&axis.name))))
        .collect();
    if !zeros.is_empty() {
        let _ = writeln!(out, "machine_zero: {{{}}}", zeros.join(", "));
    }
    if let Some(length) = machine.gauge_length_mm {
        let _ = writeln!(out, "gauge_length: {length}");
    }
    if let Some(spindle) = &machine.spindle {
        let (link, nose, direction) = (text(&spindle.link), vector(&spindle.nose), vector(&spindle.direction));
        let _ = writeln!(out, "spindle: {{link: {link}, nose: {nose}, direction: {direction}}}");
    }
    let budget = &machine.linear_axes;
    match budget.class {
        _ if !budget.is_stated => {}
        Some(class) => {
            let _ = writeln!(out, "linear_axes: {}", class.name());
        }
        None => {
            let _ = writeln!(
                out,
                "linear_axes: {{positioning: {}, straightness: {}, squareness: {}}}",
                quantity(Measure::Strain, budget.positioning),
                quantity(Measure::Strain, budget.straightness),
                quantity(Measure::Angle, budget.squareness_rad)
            );
        }
    }
    if !machine.link_names.is_empty() {
        out.push_str("links:\n");
        for (name, carrier) in &machine.link_names {
            let carrier = carrier.map_or("b", |axis| &machine.axes[axis].name);
            let _ = writeln!(out, "  - {{name: {}, carried_by: {}}}", text(name), text(carrier));
        }
    }
    if !machine.carried.is_empty() {
        out.push_str("carried:\n");
        machine.carried.iter().for_each(|branch| carried_yaml(&mut out, machine, branch));
    }
    if !machine.effects.is_empty() {
        out.push_str("effects:\n");
        machine.effects.iter().for_each(|effect| out.push_str(&effect_yaml(machine, effect)));
    }
    if !machine.caveats.is_empty() {
        out.push_str("caveats:\n");
        machine.caveats.iter().for_each(|caveat| {
            let _ = writeln!(out, "  - {}", text(caveat));
        });
    }
    out
}

fn carried_yaml(out: &mut String, machine: &Machine, branch: &CarriedBranch) {
    let on = branch.on.map_or("b", |axis| &machine.axes[axis].name);
    let _ = writeln!(out, "  - name: {}\n    on: {}\n    joints:", text(&branch.name), text(on));
    for joint in &branch.joints {
        let origin = joint.origin.map(|origin| format!(", origin: {}", vector(&origin))).unwrap_or_default();
        let reversed = if joint.reversed { ", reversed: true" } else { "" };
        let (name, direction) = (text(&joint.name), vector(&joint.direction));
        let _ = writeln!(out, "      - {{name: {name}, direction: {direction}{origin}{reversed}}}");
    }
}

fn axis_yaml(out: &mut String, axis: &Axis) {
    let _ = writeln!(out, "  {}:", text(&axis.name));
    let kind = match axis.kind {
        AxisKind::Linear => "linear",
        AxisKind::Rotary => "rotary",
    };
    let _ = writeln!(out, "    type: {kind}");
    let _ = writeln!(out, "    direction: {}", vector(&axis.direction));
    let _ = writeln!(out, "    origin: {}", vector(&axis.origin));
    if let Some((from, to)) = axis.range {
        let _ = writeln!(out, "    range: [{}, {}]", position(axis.kind, from), position(axis.kind, to));
    }
    if axis.reversed {
        out.push_str("    reversed: true\n");
    }
    let errors: Vec<String> = crate::machine::Component::ALL
        .into_iter()
        .filter(|component| axis.location_errors[component.index()] != 0.0)
        .map(|component| {
            let value = quantity(component.measure(), axis.location_errors[component.index()]);
            format!("{}: {value}", text(&ErrorName::location(component, &axis.name).to_string()))
        })
        .collect();
    if !errors.is_empty() {
        let _ = writeln!(out, "    errors: {{{}}}", errors.join(", "));
    }
    if !axis.component_errors.is_empty() {
        out.push_str("    component_errors:\n");
        for error in &axis.component_errors {
            let name = ErrorName::motion(error.component, &axis.name).to_string();
            let _ = writeln!(out, "      {}: {{{}}}", text(&name), form(axis.kind, error));
        }
    }
}

fn form(kind: AxisKind, error: &ComponentError) -> String {
    let measure = error.component.measure();
    match &error.form {
        ComponentForm::Polynomial(coefficients) => {
            let per_unit = kind.to_file_unit(1.0);
            let mut power = 1.0;
            let list: Vec<String> = coefficients
                .iter()
                .map(|&coefficient| {
                    power *= per_unit;
                    scaled_quantity(measure, coefficient, power)
                })
                .collect();
            format!("polynomial: [{}]", list.join(", "))
        }
        ComponentForm::Fourier(harmonics) => {
            let list: Vec<String> = harmonics.iter().map(|harmonic| harmonic_yaml(kind, measure, harmonic)).collect();
            format!("fourier: [{}]", list.join(", "))
        }
        ComponentForm::Table { position: at, value } => {
            let list: Vec<String> = at
                .iter()
                .zip(value)
                .map(|(&at, &value)| format!("[{}, {}]", position(kind, at), quantity(measure, value)))
                .collect();
            format!("table: [{}]", list.join(", "))
        }
    }
}

fn harmonic_yaml(kind: AxisKind, measure: Measure, harmonic: &Harmonic) -> String {
    let frequency = match kind {
        AxisKind::Rotary => format!("per_turn: {}", harmonic.frequency),
        AxisKind::Linear => {
            let tau = std::f64::consts::TAU;
            let guess = tau / harmonic.frequency;
            let period = reading_back(harmonic.frequency, guess, |period| tau / period).unwrap_or(guess);
            format!("period: {period}")
        }
    };
    let (cosine, sine) = (quantity(measure, harmonic.cosine), quantity(measure, harmonic.sine));
    format!("{{{frequency}, cos: {cosine}, sin: {sine}}}")
}

/// A session file; recordings and machine are named as the session names them.
pub fn session_yaml(session: &Session) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "name: {}", text(&session.name));
    let _ = writeln!(out, "machine: {}", text(&session.machine_file));
    let spread = |value| quantity(Measure::Length, value);
    let _ = writeln!(
        out,
        "spread: {{pivot: {}, spindle_ball: {}, bar_length: {}{}}}",
        spread(session.spread.pivot_mm),
        spread(session.spread.spindle_ball_mm),
        spread(session.spread.bar_length_mm),
        match session.spread.pivot_length_mm {
            0.0 => String::new(),
            length => format!(", pivot_length: {}", spread(length)),
        }
    );
    out.push_str("tests:\n");
    let gaps: Vec<&Test> = session.tests.iter().filter(|test| test.reading.is_gap()).collect();
    if !gaps.is_empty() {
        out.truncate(out.len() - "tests:\n".len());
        out.push_str("sockets:\n");
        gaps.into_iter().for_each(|test| sockets_yaml(&mut out, session, test));
        out.push_str("tests:\n");
    }
    // a reading of several numbers stands once
    for test in session.tests.iter().filter(|test| test.reading.part().is_none_or(Part::leads)) {
        test_yaml(&mut out, &session.machine, test);
    }
    out
}

/// A known distance of two sockets.
fn sockets_yaml(out: &mut String, session: &Session, test: &Test) {
    let named = |ball: &Ball| {
        let is_it = |other: &&Test| other.pivot == *ball && other.reading.part().is_some_and(Part::leads);
        session.tests.iter().find(is_it).and_then(|test| test.reading.part()).map_or("", |part| &part.of)
    };
    let (Some(recording), Some(noise)) = (&test.recording, test.reading.stated_noise_mm()) else { return };
    let _ = writeln!(
        out,
        "  - {{between: [{}, {}], distance: {}, spread: {}}}",
        text(named(&test.pivot)),
        text(named(&test.spindle_ball)),
        recording.length_mm[0],
        quantity(Measure::Length, noise)
    );
}

fn test_yaml(out: &mut String, machine: &Machine, test: &Test) {
    let part = test.reading.part();
    let _ = writeln!(out, "  - name: {}", text(test.stated_name()));
    let mut line = |key: &str, value: Option<String>| {
        if let Some(value) = value {
            let _ = writeln!(out, "    {key}: {value}");
        }
    };
    line("recording", test.recording_file.as_deref().map(text));
    line("started_at", Some(test.started_at_s.to_string()));
    line("bar_length", test.bar_length_mm.map(|length| length.to_string()));
    line("bar_setup", test.bar_setup.as_deref().map(text));
    line("zero", (test.zero != Zero::default()).then(|| test.zero.name().to_string()));
    line("bar_error", (test.bar_error_mm != 0.0).then(|| quantity(Measure::Length, test.bar_error_mm)));
    match part {
        None => {
            line("pivot", Some(ball(&test.pivot)));
            line("spindle_ball", Some(ball(&test.spindle_ball)));
        }
        Some(part) => {
            line("readings", Some(part.kind.name().to_string()));
            let sets = part.kind.column_sets().iter().find(|set| set.len() == part.columns.len());
            let renamed = sets.into_iter().flat_map(|set| set.iter().zip(part.columns.iter()));
            let renamed: Vec<String> = renamed
                .filter(|(usual, own)| *usual != own)
                .map(|(usual, own)| format!("{usual}: {}", text(own)))
                .collect();
            line("columns", (!renamed.is_empty()).then(|| format!("{{{}}}", renamed.join(", "))));
            let instrument = if part.kind == Kind::SamePoint { "socket" } else { "instrument" };
            line(instrument, Some(frame(&test.pivot, &part.instrument_axes, part.instrument_turn_rad)));
            line("target", Some(frame(&test.spindle_ball, &part.target_axes, part.target_turn_rad)));
        }
    }
    let standing: Vec<String> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, value)| value.map(|value| format!("{}: {}", text(&axis.name), position(axis.kind, value))))
        .collect();
    line("positions", (!standing.is_empty()).then(|| format!("{{{}}}", standing.join(", "))));
    let came = machine.axes.iter().zip(&test.approached);
    let came: Vec<String> =
        came.filter_map(|(axis, sense)| sense.map(|sense| format!("{}: {sense}", text(&axis.name)))).collect();
    line("approached", (!came.is_empty()).then(|| format!("{{{}}}", came.join(", "))));
    line("feed", test.feed_mm_per_min.map(|feed| feed.to_string()));
    line("overshoot", test.overshoot.map(|overshoot| overshoot.to_string()));
    line(
        "marks",
        test.marks.map(|marks| {
            let seen = marks.seen_mm.map_or(String::new(), |[before, after]| format!(", seen: [{before}, {after}]"));
            format!(
                "{{move: {}, feed: {}, hold: {}, rest: {}, gap: {}{seen}}}",
                marks.move_mm, marks.feed_mm_per_min, marks.hold_s, marks.rest_s, marks.gap_s
            )
        }),
    );
    match &test.path {
        None => {}
        Some(Path::Sweep { axis, from, to, step, follow, length_mm }) => {
            let length = length_mm.map_or(String::new(), |length_mm| format!(", length: {length_mm}"));
            let follow = follow.name();
            let axis = text(&machine.axes[*axis].name);
            line(
                "sweep",
                Some(format!("{{axis: {axis}, from: {from}, to: {to}, step: {step}, follow: {follow}{length}}}")),
            );
        }
        Some(Path::Circle { plane, radius_mm, from, to, step }) => {
            let plane = format!("{}{}", machine.axes[plane.first].name, machine.axes[plane.second].name);
            line(
                "circle",
                Some(format!("{{plane: {plane}, radius: {radius_mm}, from: {from}, to: {to}, step: {step}}}")),
            );
        }
    }
}

fn ball(ball: &Ball) -> String {
    let mut out = format!("{{link: {}, at: {}", text(&ball.link), vector(&ball.at));
    if let Some(setup) = &ball.setup {
        let _ = write!(out, ", setup: {}", text(setup));
    }
    if let Some(spread) = ball.spread_mm {
        let _ = write!(out, ", spread: {}", quantity(Measure::Length, spread));
    }
    if let Some(about) = ball.indexed_about {
        let _ = write!(out, ", indexed_about: {}", ["x", "y", "z"][about]);
    }
    out.push('}');
    out
}

/// An instrument, a socket or a target.
fn frame(at: &Ball, axes: &Matrix3<f64>, turn_rad: Option<f64>) -> String {
    let mut out = ball(at);
    out.pop();
    if *axes != Matrix3::identity() {
        let [w, x, y, z] = quaternion(axes);
        let _ = write!(out, ", quaternion: [{w}, {x}, {y}, {z}]");
    }
    if let Some(turn) = turn_rad {
        let _ = write!(out, ", turn_spread: {}", quantity(Measure::Angle, turn));
    }
    out.push('}');
    out
}

fn vector(value: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", value.x, value.y, value.z)
}

//! Turns played sessions into the text of their files; writes nothing to disk itself.

use std::fmt::Write;

use super::design::{Axis, Carrier, Design, ERROR_NAMES, FEED_MM_MIN, OVERSHOOT_DEG, designs};
use super::noise::{CORRELATED_UM, CORRELATION_S, WALK_UM_PER_ROOT_S, WARM_UP_UM, WHITE_UM};
use super::session::{BAR_LENGTH_MM, BAR_UM, PIVOT_UM, SPINDLE_BALL_UM, START_UM, Session, bar_length_mm, play};

/// Seed of the committed sessions: the year of the thesis.
pub const COMMITTED_SEED: u64 = 2014;

const LABEL: &str = "reconstructed by simulation, not measured";

const COMMON_ASSUMPTIONS: [&str; 7] = [
    "the inserted errors are the averages that the thesis publishes for this chapter, their signs read as printed by its Table 2.1 (the sign of a tilt is open by the text of chapters 4 and 5)",
    "EB0C is the C axis's own: EB0A was taken out of it, as chapter 6 prints and the numbers of chapters 4 and 5 speak for",
    "R = 100 mm, bars of 99.9881 and 149.9946 mm, D = √(150² − 100²) = 50√5 = 111.80 mm (eq. 3.13 prints 50√2), A from −20° to 70°; C turns from −180° to 180°, where it starts is not printed",
    "ten repeats (printed for chapter 4 alone), alternately ccw and cw, which is not printed; 500 mm/min at the pivot ball, overshoot 2° on A and 45° on C",
    "C stands at 0 in the A tests and A at 0 in the C tests, which is not printed",
    "linear axes are perfect and the machine has no other error than the eight location errors",
    "the origin is the nominal A∩C intersection, where the spindle ball stands with all axes at zero",
];

const MACHINE: &str = "# Nominal Hermle C600U, without errors; see machines/hermle-c600u.yaml for the sources.
name: Hermle C600U
code: \"[wCAbYXZt]\"
# the recordings hold the sense of the thesis's HTMs: positive is right-handed for the carried part
directions: carried
axes:
  X: {range: [-300, 300]}
  Y: {range: [-225, 225]}
  Z: {range: [-120, 330]}
  A: {origin: [0, 0, 0], range: [-30, 110]}
  C: {origin: [0, 0, 0], range: [-360, 360]}
";

/// A file's path below the output folder, and its text.
pub type TextFile = (String, String);

/// Every file of the three sessions.
pub fn all(seed: u64) -> Vec<TextFile> {
    let mut files = vec![("README.md".to_string(), readme(seed))];
    for design in designs() {
        files.extend(of_design(design, seed, 1.0));
    }
    files
}

/// The files of one design; `scatter` 0 leaves out every error of setting up and reading.
pub fn of_design(design: Design, seed: u64, scatter: f64) -> Vec<TextFile> {
    let session = play(design, seed, scatter);
    // a ball bar shows tenths of a micron
    let decimals = if scatter > 0.0 { 4 } else { 9 };
    let folder = format!("chapter{}", session.design.chapter);
    let mut files = vec![
        (format!("{folder}/machine.yaml"), MACHINE.to_string()),
        (format!("{folder}/session.yaml"), session_yaml(&session)),
        (format!("{folder}/truth.json"), truth_json(&session, seed)),
    ];
    for run in &session.runs {
        let axis = axis_name(run.test.axis);
        let mut csv = format!("time_s,{axis}_deg,length_mm\n");
        for [time_s, at_deg, length_mm] in &run.rows {
            let _ = writeln!(csv, "{time_s:.3},{at_deg:.5},{length_mm:.decimals$}");
        }
        files.push((format!("{folder}/{}.csv", run.name), csv));
    }
    files
}

fn carrier_name(carrier: Carrier) -> &'static str {
    match carrier {
        Carrier::TiltingTable => "A",
        Carrier::Table => "C",
    }
}

fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::A => "A",
        Axis::C => "C",
    }
}

fn point(values: [f64; 3]) -> String {
    let parts = values.map(|v| {
        let text = format!("{v:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_string() } else { text.to_string() }
    });
    format!("[{}]", parts.join(", "))
}

fn session_yaml(session: &Session) -> String {
    let design = &session.design;
    let mut text = format!(
        "# {}{}.\n# Test design of chapter {} of X. Jiang's thesis (Birmingham, 2014): {}.\n# Assumptions:\n",
        LABEL[..1].to_uppercase(),
        &LABEL[1..],
        design.chapter,
        design.title
    );
    for assumption in design.assumptions.iter().chain(&COMMON_ASSUMPTIONS) {
        let _ = writeln!(text, "# - {assumption}");
    }
    let _ = write!(
        text,
        "name: C600U, chapter {} ({LABEL})\nmachine: machine.yaml\nspread: {{pivot: {PIVOT_UM} um, spindle_ball: {SPINDLE_BALL_UM} um, bar_length: {BAR_UM} um}}\ntests:\n",
        design.chapter
    );
    for run in &session.runs {
        let [x, y, z] = run.test.spindle_mm;
        let still = match run.test.axis {
            Axis::A => "C",
            Axis::C => "A",
        };
        let places = point([x, y, z]);
        let mut places = places.trim_matches(['[', ']']).split(", ");
        let mut next = || places.next().unwrap_or("0").to_string();
        let _ = write!(
            text,
            "  - name: {name}\n    recording: {name}.csv\n    started_at: {:.1}\n    bar_length: {:.4}\n    pivot: {{link: {}, at: {}}}\n    spindle_ball: {{link: Z, at: [0, 0, 0]}}\n    positions: {{X: {}, Y: {}, Z: {}, {still}: 0}}\n    feed: {FEED_MM_MIN}\n    overshoot: {}\n",
            run.started_at_s,
            bar_length_mm(run.test.bar),
            carrier_name(design.mountings[run.mounting].carrier),
            point(design.mountings[run.mounting].pivot_mm),
            next(),
            next(),
            next(),
            OVERSHOOT_DEG[run.test.axis as usize],
            name = run.name,
        );
    }
    text
}

fn truth_json(session: &Session, seed: u64) -> String {
    let design = &session.design;
    let numbers = |values: [f64; 3]| {
        let parts = values.map(|v| format!("{v:.4}"));
        format!("[{}]", parts.join(", "))
    };
    let mut errors = String::new();
    for (k, (name, unit)) in ERROR_NAMES.iter().enumerate() {
        let comma = if k + 1 < ERROR_NAMES.len() { "," } else { "" };
        let _ = writeln!(errors, "    \"{name}\": {{\"value\": {:.2}, \"unit\": \"{unit}\"}}{comma}", design.errors[k]);
    }
    let pivots: Vec<String> = design
        .mountings
        .iter()
        .zip(&session.pivot_errors_um)
        .map(|(mounting, error_um)| {
            format!(
                "    {{\"link\": \"{}\", \"at\": {}, \"error_um\": {}}}",
                carrier_name(mounting.carrier),
                point(mounting.pivot_mm),
                numbers(*error_um)
            )
        })
        .collect();
    let bars: Vec<String> = BAR_LENGTH_MM
        .iter()
        .zip(&session.bar_errors_um)
        .map(|(length_mm, error_um)| {
            format!("    {{\"calibrated_mm\": {length_mm:.4}, \"reading_error_um\": {error_um:.4}}}")
        })
        .collect();
    format!(
        "{{\n  \"label\": \"{LABEL}\",\n  \"chapter\": {},\n  \"seed\": {seed},\n  \"location_errors\": {{\n{errors}  }},\n  \"pivots\": [\n{}\n  ],\n  \"spindle_balls\": [\n    {{\"link\": \"Z\", \"at\": [0, 0, 0], \"error_um\": {}}}\n  ],\n  \"bars\": [\n{}\n  ],\n  \"noise_rms_um\": {:.4}\n}}\n",
        design.chapter,
        pivots.join(",\n"),
        numbers(session.spindle_ball_error_um),
        bars.join(",\n"),
        session.noise_rms_um
    )
}

fn readme(seed: u64) -> String {
    let mut text = format!(
        "# Three sessions of a Hermle C600U\n\n**{}{}.** `cargo run --release --example thesis_sessions -- --out DIR --seed {seed}` writes them, with kinematics\nand noise of its own that share no code with the library. `truth.json` beside each session says what was inserted.\n\n",
        LABEL[..1].to_uppercase(),
        &LABEL[1..]
    );
    for design in designs() {
        let _ = writeln!(text, "- `chapter{}`: {}", design.chapter, design.title);
    }
    text.push_str("\nAssumed for all three:\n\n");
    for assumption in COMMON_ASSUMPTIONS {
        let _ = writeln!(text, "- {assumption}");
    }
    for design in designs() {
        let _ = writeln!(text, "\nAssumed for chapter {}:\n", design.chapter);
        for assumption in design.assumptions {
            let _ = writeln!(text, "- {assumption}");
        }
    }
    let _ = write!(
        text,
        "\nSetup errors (1 sigma): pivot {PIVOT_UM} µm a coordinate across the bar; along the bar the pivot is moved at the start position\nuntil the bar reads its nominal length, to {START_UM} µm; spindle ball {SPINDLE_BALL_UM} µm a coordinate; bar calibration {BAR_UM} µm.\nNoise: white {WHITE_UM} µm, first-order autoregressive {CORRELATED_UM} µm over {CORRELATION_S} s, random walk {WALK_UM_PER_ROOT_S} µm/√s, warm-up {WARM_UP_UM} µm over the\nsession, readings in steps of 0.1 µm.\n"
    );
    text
}

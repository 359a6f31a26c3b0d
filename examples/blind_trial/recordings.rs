//! What leaves the generator: session.yaml, machine.yaml and one CSV per test; nothing of the truth.

use super::kinematics::{AXES, Disturbance, Link, Location, Machine, V3, distance};
use super::plan::{Placed, Plan};
use super::visibility::setup;
use std::fmt::Write as _;
use std::path::Path;

/// One recording as it will be written.
#[derive(Clone)]
pub struct Recording {
    /// Axis and its commanded positions, in columns.
    pub columns: Vec<(usize, Vec<f64>)>,
    pub standing: Vec<(usize, f64)>,
    pub lengths_mm: Vec<Option<f64>>,
    pub temperature_degc: Option<Vec<f64>>,
}

impl Recording {
    /// Axis positions of a row as written.
    pub fn axes(&self, row: usize) -> [f64; AXES] {
        let mut q = [0.0; AXES];
        self.standing.iter().for_each(|s| q[s.0] = s.1);
        self.columns.iter().for_each(|c| q[c.0] = c.1[row]);
        q
    }
}

/// Exact readings of every row, mm.
pub fn lengths(plan: &Plan, location: &Location, rows: &[Vec<Disturbance>]) -> Vec<Vec<f64>> {
    plan.tests
        .iter()
        .zip(rows)
        .map(|(test, rows)| {
            let setup = setup(plan, test);
            let bar = plan.bars[test.bar].reading_error_mm;
            rows.iter()
                .enumerate()
                .map(|(row, d)| {
                    let q = plan.axes_at(test, row as f64 * test.step_s);
                    distance(&plan.machine, location, &setup, &q, d) + bar
                })
                .collect()
        })
        .collect()
}

/// Commanded positions, rounded as files hold them, with the lengths read.
pub fn recordings(plan: &Plan, lengths_mm: Vec<Vec<Option<f64>>>, mut warmth: impl FnMut() -> f64) -> Vec<Recording> {
    plan.tests
        .iter()
        .zip(lengths_mm)
        .map(|(test, lengths_mm)| {
            let at = |row: usize| plan.axes_at(test, row as f64 * test.step_s);
            let first = at(0);
            let temperature_degc = plan
                .temperature
                .as_ref()
                .map(|w| (0..test.rows).map(|k| w.at(test.started_at_s + k as f64 * test.step_s) + warmth()).collect());
            Recording {
                columns: test.moving.iter().map(|&j| (j, (0..test.rows).map(|k| at(k)[j]).collect())).collect(),
                standing: (0..AXES).filter(|j| !test.moving.contains(j)).map(|j| (j, first[j])).collect(),
                lengths_mm,
                temperature_degc,
            }
        })
        .collect()
}

/// Writes the folder of a session.
pub fn write(folder: &Path, name: &str, plan: &Plan, order: &[usize], recordings: &[Recording]) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("machine.yaml"), machine_yaml(&plan.machine))?;
    std::fs::write(folder.join("session.yaml"), session_yaml(name, plan, order, recordings))?;
    for (test, recording) in plan.tests.iter().zip(recordings) {
        let mut text = String::from("time_s");
        for (axis, _) in &recording.columns {
            let joint = &plan.machine.joints[*axis];
            let _ = write!(text, ",{}_{}", joint.name, if joint.rotary { "deg" } else { "mm" });
        }
        text.push_str(",length_mm");
        if recording.temperature_degc.is_some() {
            text.push_str(",temperature_degC");
        }
        text.push('\n');
        for (row, length) in recording.lengths_mm.iter().enumerate() {
            let _ = write!(text, "{:.4}", row as f64 * test.step_s);
            for (_, positions) in &recording.columns {
                let _ = write!(text, ",{:.5}", positions[row]);
            }
            match length {
                Some(x) => {
                    let _ = write!(text, ",{x:.4}");
                }
                None => text.push(','),
            }
            if let Some(t) = &recording.temperature_degc {
                let _ = write!(text, ",{:.2}", t[row]);
            }
            text.push('\n');
        }
        std::fs::write(folder.join(format!("{}.csv", test.name)), text)?;
    }
    Ok(())
}

/// A number without needless digits.
fn plain(x: f64) -> String {
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn point(p: V3) -> String {
    format!("[{}, {}, {}]", plain(p[0]), plain(p[1]), plain(p[2]))
}

pub fn machine_yaml(machine: &Machine) -> String {
    let mut text = format!(
        "name: {}\ncode: \"{}\"\ndirections: carried  # as the recordings were made\naxes:\n",
        machine.name, machine.code
    );
    for joint in &machine.joints {
        let mut fields = vec![];
        if joint.rotary {
            fields.push(format!("origin: {}", point(joint.origin)));
        }
        if joint.direction.iter().all(|x| x.abs() < 1.0 - 1e-9)
            || joint.direction.iter().filter(|x| x.abs() > 1e-9).count() > 1
        {
            let d = joint.direction;
            fields.push(format!("direction: [{:.15}, {:.15}, {:.15}]", d[0], d[1], d[2]));
        }
        if joint.reversed {
            fields.push("reversed: true".into());
        }
        fields.push(format!("range: [{}, {}]", plain(joint.range.0), plain(joint.range.1)));
        let _ = writeln!(text, "  {}: {{{}}}", joint.name, fields.join(", "));
    }
    text
}

fn session_yaml(name: &str, plan: &Plan, order: &[usize], recordings: &[Recording]) -> String {
    let mut text = format!(
        "name: {name}\nmachine: machine.yaml\nspread: {{pivot: 20 um, spindle_ball: 3 um, bar_length: 0.5 um}}\ntests:\n"
    );
    for &i in order {
        let (test, recording) = (&plan.tests[i], &recordings[i]);
        let standing: Vec<String> =
            recording.standing.iter().map(|&(j, q)| format!("{}: {}", plan.machine.joints[j].name, plain(q))).collect();
        let _ = writeln!(text, "  - name: {}\n    recording: {}.csv", test.name, test.name);
        let _ = writeln!(text, "    started_at: {:.1}", test.started_at_s);
        let _ = writeln!(text, "    bar_length: {}", plain(plan.bars[test.bar].calibrated_mm));
        let _ = writeln!(text, "    pivot: {}", seat(&plan.machine, &plan.pivots[test.pivot], 0.020));
        let _ = writeln!(text, "    spindle_ball: {}", seat(&plan.machine, &plan.balls[test.ball], 0.003));
        let _ = writeln!(text, "    positions: {{{}}}", standing.join(", "));
        let _ = writeln!(text, "    feed: {}", plain(test.feed));
    }
    text
}

fn seat(machine: &Machine, placed: &Placed, usual_mm: f64) -> String {
    let link = match placed.ball.link {
        Link::Bed => "b".to_string(),
        Link::Axis(j) => machine.joints[j].name.clone(),
    };
    let spread = if (placed.spread_mm - usual_mm).abs() < 1e-9 {
        String::new()
    } else {
        format!(", spread: {} um", plain(placed.spread_mm * 1e3))
    };
    format!("{{link: {link}, at: {}{spread}}}", point(placed.ball.at))
}

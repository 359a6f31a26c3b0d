//! How each control writes a program down. What is to be done is in `steps`.

use std::fmt::Write as _;

use super::{Step, machine_offsets, steps};
use crate::machine::Machine;
use crate::plan::PlannedTest;

/// A control's language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// ISO 6983 as most controls read it.
    Generic,
    LinuxCnc,
    /// Heidenhain conversational.
    Heidenhain,
    Sinumerik,
}

impl Dialect {
    /// All dialects with the endings of their files.
    pub const ALL: [(Dialect, &'static str); 4] =
        [(Dialect::Generic, "nc"), (Dialect::LinuxCnc, "ngc"), (Dialect::Heidenhain, "h"), (Dialect::Sinumerik, "mpf")];

    /// An axis of the machine whose name the control cannot write, if any.
    pub fn unknown_axis(self, machine: &Machine) -> Option<&str> {
        let known = |name: &str| match self {
            // a letter with a number is written X1=...
            Dialect::Sinumerik => {
                let mut letters = name.chars();
                letters.next().is_some_and(|first| first.is_ascii_uppercase())
                    && letters.all(|letter| letter.is_ascii_digit())
            }
            _ => name.len() == 1 && "XYZABCUVW".contains(name),
        };
        machine.axes.iter().map(|axis| axis.name.as_str()).find(|name| !known(name))
    }
}

/// The program of a planned test.
pub fn program(machine: &Machine, planned: &PlannedTest, dialect: Dialect) -> String {
    let in_machine_coordinates = machine_offsets(machine).is_some();
    let steps = steps(machine, planned);
    let name = planned.test.name.to_uppercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    match dialect {
        Dialect::Heidenhain => heidenhain(&name, &steps, in_machine_coordinates, machine.gauge_length_mm),
        _ => iso(&name, &steps, in_machine_coordinates, dialect),
    }
}

/// Text inside a comment: parentheses would end it.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii() && c != '(' && c != ')' && c != ';' { c } else { ' ' }).collect()
}

fn iso(name: &str, steps: &[Step], machine_coordinates: bool, dialect: Dialect) -> String {
    let comment = |text: &str| match dialect {
        Dialect::Sinumerik => format!("; {}\n", plain(text)),
        _ => format!("({})\n", plain(text)),
    };
    let mut out = String::new();
    if dialect == Dialect::Generic {
        out.push_str("%\n");
    }
    out.push_str(&comment(name));
    out.push_str(&comment(coordinates(machine_coordinates)));
    // no tool length, no radius, no tool centre point control: axes move as written
    out.push_str(match dialect {
        Dialect::Sinumerik => "G17 G40 G71 G90 G94\nTRAFOOF\nD0\n",
        _ => "G17 G21 G40 G49 G90 G94\n",
    });
    // the operator's hands are at the spindle next
    out.push_str("M5\nM9\n");
    if dialect == Dialect::LinuxCnc {
        out.push_str(&comment("identity kinematics: with xyzac-trt-kins switch by M429 before"));
    }
    // machine coordinates hold in one block only (G53); Sinumerik calls that SUPA
    let (before, after) = match (machine_coordinates, dialect) {
        (false, _) => ("", ""),
        (true, Dialect::Sinumerik) => ("", " SUPA"),
        (true, _) => ("G53 ", ""),
    };
    let word = |axis: &str, value: f64| {
        let equals = if dialect == Dialect::Sinumerik && axis.len() > 1 { "=" } else { "" };
        // no minus sign before a zero
        format!("{axis}{equals}{:.5}", (value * 1e5).round() / 1e5 + 0.0)
    };
    let coupled = steps.iter().any(|step| matches!(step, Step::Move { .. } | Step::Arc { .. }));
    // corners between blocks are not rounded by more than a micrometre, centres are relative; whatever ran before
    out.push_str(match dialect {
        Dialect::LinuxCnc => "G64 P0.001 G91.1\n",
        Dialect::Sinumerik => "G641 ADIS=0.001\n",
        _ if coupled => "G64\n",
        _ => "",
    });
    let mut by_time = false;
    for step in steps {
        // each block of coupled axes has its time (G93), every other feed is per minute (G94)
        let timed = matches!(step, Step::Move { .. });
        let has_feed = matches!(step, Step::Turn { .. } | Step::Arc { .. } | Step::Rapid { .. });
        if timed && !by_time || has_feed && by_time {
            out.push_str(if timed { "G93\n" } else { "G94\n" });
            by_time = timed;
        }
        match step {
            Step::Say(text) => out.push_str(&comment(text)),
            Step::Stop(text) => {
                out.push_str(&comment(text));
                out.push_str("M0\n");
            }
            Step::Rapid { axis, to } => {
                let _ = writeln!(out, "{before}G0 {}{after}", word(axis, *to));
            }
            Step::Turn { axis, to_deg, feed_deg_per_min } => {
                let _ = writeln!(out, "{before}G1 {} F{feed_deg_per_min:.3}{after}", word(axis, *to_deg));
            }
            Step::Move { to, minutes } => {
                let words: Vec<String> = to.iter().map(|(axis, value)| word(axis, *value)).collect();
                let _ = writeln!(out, "{before}G1 {} F{:.4}{after}", words.join(" "), 1.0 / minutes);
            }
            Step::Arc { axes, centre, end, counter_clockwise, feed_mm_per_min } => {
                let turn = if *counter_clockwise { 3 } else { 2 };
                let [one, other] = axes;
                let _ = writeln!(
                    out,
                    "G{} G91\nG{turn} {} {} {} {} F{feed_mm_per_min:.3}\nG17 G90",
                    plane(axes),
                    word(one, end[0]),
                    word(other, end[1]),
                    word(centre_letter(one), centre[0]),
                    word(centre_letter(other), centre[1]),
                );
            }
            Step::Dwell(seconds) => {
                let letter = match dialect {
                    Dialect::LinuxCnc => "P",
                    Dialect::Sinumerik => "F",
                    _ => "X",
                };
                let _ = writeln!(out, "G4 {letter}{seconds:.1}");
            }
        }
    }
    out.push_str(if dialect == Dialect::LinuxCnc { "M2\n" } else { "M30\n" });
    if dialect == Dialect::Generic {
        out.push_str("%\n");
    }
    out
}

/// G word of a plane.
fn plane(axes: &[String; 2]) -> u8 {
    match [axes[0].as_str(), axes[1].as_str()] {
        ["Y", "Z"] => 19,
        ["Z", "X"] => 18,
        _ => 17,
    }
}

/// Letter of a circle's centre along an axis.
fn centre_letter(axis: &str) -> &'static str {
    match axis {
        "X" => "I",
        "Y" => "J",
        _ => "K",
    }
}

/// Which coordinates a program's positions are in.
fn coordinates(of_machine: bool) -> &'static str {
    if of_machine {
        "positions in machine coordinates"
    } else {
        "positions in work coordinates with zero at the zero of the machine file"
    }
}

fn heidenhain(name: &str, steps: &[Step], machine_coordinates: bool, gauge_length_mm: Option<f64>) -> String {
    // M129: no tool centre point control; M127: rotary axes go the way that is written, not the shorter one
    // M5, M9: the operator's hands are at the spindle next
    let mut lines = vec![
        format!("BEGIN PGM {name} MM"),
        format!("; {}", coordinates(machine_coordinates)),
        match gauge_length_mm {
            Some(length) => format!("; gauge length of the machine file {length:.3} mm, tool length 0"),
            None => "; no gauge length in the machine file, tool length 0".into(),
        },
        "M129".into(),
        "M127".into(),
        "M5".into(),
        "M9".into(),
    ];
    // M91: this block in machine coordinates
    let after = if machine_coordinates { " M91" } else { "" };
    for step in steps {
        match step {
            Step::Say(text) => lines.push(format!("; {}", plain(text))),
            Step::Stop(text) => {
                lines.push(format!("; {}", plain(text)));
                lines.push("STOP M0".into());
            }
            Step::Rapid { axis, to } => lines.push(format!("L {axis}{to:+.5} R0 FMAX{after}")),
            Step::Turn { axis, to_deg, feed_deg_per_min } => {
                lines.push(format!("L {axis}{to_deg:+.5} R0 F{feed_deg_per_min:.0}{after}"));
            }
            // FT: the time of the block, s
            Step::Move { to, minutes } => {
                let words: Vec<String> = to.iter().map(|(axis, value)| format!("{axis}{value:+.5}")).collect();
                lines.push(format!("L {} R0 FT{:.3}{after}", words.join(" "), minutes * 60.0));
            }
            Step::Arc { axes: [one, other], centre, end, counter_clockwise, feed_mm_per_min } => {
                lines.push(format!("CC I{one}{:+.5} I{other}{:+.5}", centre[0], centre[1]));
                let turn = if *counter_clockwise { '+' } else { '-' };
                lines.push(format!("C I{one}{:+.5} I{other}{:+.5} DR{turn} R0 F{feed_mm_per_min:.0}", end[0], end[1]));
            }
            Step::Dwell(seconds) => {
                lines.push("CYCL DEF 9.0 DWELL TIME".into());
                lines.push(format!("CYCL DEF 9.1 DWELL {seconds:.1}"));
            }
        }
    }
    lines.push(format!("END PGM {name} MM"));
    lines.iter().enumerate().fold(String::new(), |mut out, (number, line)| {
        let _ = writeln!(out, "{number} {line}");
        out
    })
}

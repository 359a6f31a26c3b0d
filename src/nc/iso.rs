//! Programs of letters and numbers: generic ISO 6983, LinuxCNC and Sinumerik. What is to be done is in `steps`.

use std::fmt::Write as _;

use super::dialect::{feed, plain, rounded};
use super::{Dialect, Step};

/// Groups of Sinumerik's G words that a program changes: plane, exact stop and smoothing, inch and metric, absolute and
/// relative, kind of feed.
const SINUMERIK_GROUPS: [u8; 5] = [6, 10, 13, 14, 15];

/// A program that leaves the modes that it found where the control can tell them, else those named at its end.
pub(super) fn program(
    name: &str,
    head: &[String],
    steps: &[Step],
    in_machine_coordinates: bool,
    dialect: Dialect,
) -> String {
    let comment = |text: &str| match dialect {
        Dialect::Sinumerik => format!("; {}\n", plain(text)),
        _ => format!("({})\n", plain(text)),
    };
    let mut out = String::new();
    if dialect == Dialect::Generic {
        out.push_str("%\n");
    }
    if dialect == Dialect::Sinumerik {
        // definitions come before all else
        for group in SINUMERIK_GROUPS {
            let _ = writeln!(out, "DEF INT GROUP{group}");
        }
    }
    out.push_str(&comment(name));
    head.iter().for_each(|line| out.push_str(&comment(line)));
    // the operator's hands are at the spindle next; off before modes are saved, so that they come back off
    out.push_str("M5\nM9\n");
    out.push_str(&save(dialect));
    // no turned coordinates, no tool length, no radius, no tool centre point control: axes move as written
    out.push_str(straight(dialect));
    out.push_str(modes(dialect));
    if dialect == Dialect::LinuxCnc {
        out.push_str(&comment("identity kinematics: with xyzac-trt-kins switch by M429 before"));
    }
    let coupled = steps.iter().any(|step| matches!(step, Step::Move { .. } | Step::Arc { .. }));
    // corners between blocks are not rounded by more than a micrometre, centres are relative; whatever ran before
    out.push_str(match dialect {
        Dialect::LinuxCnc => "G64 P0.001 G91.1\n",
        Dialect::Sinumerik => "G641 ADIS=0.001\n",
        _ if coupled => "G64\n",
        _ => "",
    });
    blocks(&mut out, steps, in_machine_coordinates, dialect, &comment);
    out.push_str(&restore(dialect));
    out.push_str(if dialect == Dialect::LinuxCnc { "M2\n" } else { "M30\n" });
    if dialect == Dialect::Generic {
        out.push_str("%\n");
    }
    out
}

/// What switches turned and shifted coordinates off that an earlier program left; before the plane, which Fanuc's controls do
/// not take while coordinates are turned. Sinumerik: `TRANS` alone drops all that a program shifted, turned, mirrored or
/// scaled, the others what follows tool and workpiece. LinuxCNC turns the work offset itself (`G10 L2 R`): no word ends that.
fn straight(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::Generic => "G69\n",
        Dialect::Sinumerik => "TRANS\nTOROTOF\nPAROTOF\n",
        _ => "",
    }
}

/// Modes in which a program runs.
fn modes(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::Sinumerik => "G17 G40 G710 G90 G94\nTRAFOOF\nD0\n",
        _ => "G17 G21 G40 G49 G90 G94\n",
    }
}

fn save(dialect: Dialect) -> String {
    match dialect {
        Dialect::LinuxCnc => "M70\n".into(),
        Dialect::Sinumerik => SINUMERIK_GROUPS.iter().map(|group| format!("GROUP{group}=$P_GG[{group}]\n")).collect(),
        _ => String::new(),
    }
}

/// What was saved, or the modes in which most controls start.
fn restore(dialect: Dialect) -> String {
    match dialect {
        Dialect::LinuxCnc => "M72\n".into(),
        Dialect::Sinumerik => SINUMERIK_GROUPS.iter().map(|group| format!("G[{group}]=GROUP{group}\n")).collect(),
        _ => format!("(no word of ISO 6983 tells the modes found: left as here)\n{}", modes(dialect)),
    }
}

fn blocks(
    out: &mut String,
    steps: &[Step],
    in_machine_coordinates: bool,
    dialect: Dialect,
    comment: &dyn Fn(&str) -> String,
) {
    // machine coordinates hold in one block only (G53); Sinumerik calls that SUPA
    let (before, after) = match (in_machine_coordinates, dialect) {
        (false, _) => ("", ""),
        (true, Dialect::Sinumerik) => ("", " SUPA"),
        (true, _) => ("G53 ", ""),
    };
    let decimals = dialect.decimals();
    let word = |axis: &str, value: f64| {
        let equals = if dialect == Dialect::Sinumerik && axis.len() > 1 { "=" } else { "" };
        format!("{axis}{equals}{:.decimals$}", rounded(value, decimals))
    };
    let mut by_time = false;
    for step in steps {
        // each block of coupled axes has its time (G93), every other feed is per minute (G94)
        let timed = matches!(step, Step::Move { .. });
        let per_minute = matches!(step, Step::Turn { .. } | Step::Arc { .. } | Step::Rapid { .. });
        if timed && !by_time || per_minute && by_time {
            // some controls want a feed with the change
            out.push_str(if timed { "G93\n" } else { "G94 F500\n" });
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
                let _ = writeln!(out, "{before}G1 {} F{}{after}", word(axis, *to_deg), feed(*feed_deg_per_min));
            }
            Step::Move { to, minutes } => {
                let words: Vec<String> = to.iter().map(|(axis, value)| word(axis, *value)).collect();
                let _ = writeln!(out, "{before}G1 {} F{}{after}", words.join(" "), feed(1.0 / minutes));
            }
            Step::Arc { axes, centre, end, counter_clockwise, feed_mm_per_min } => {
                let turn = if *counter_clockwise { 3 } else { 2 };
                let [one, other] = axes;
                let _ = writeln!(
                    out,
                    "G{} G91\nG{turn} {} {} {} {} F{}\nG17 G90",
                    plane(axes),
                    word(one, end[0]),
                    word(other, end[1]),
                    word(centre_letter(one), centre[0]),
                    word(centre_letter(other), centre[1]),
                    feed(*feed_mm_per_min),
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

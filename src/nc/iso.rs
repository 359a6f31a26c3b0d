//! Programs of letters and numbers: generic ISO 6983, LinuxCNC and Sinumerik. What is to be done is in `step`.

use std::fmt::Write as _;

use super::coordinates::Coordinates;
use super::dialect::{Dialect, Title, capitals, feed, plain};
use super::step::Step;
use crate::units::rounded;

/// Groups of Sinumerik's G words that a program changes: plane, exact stop and smoothing, inch and metric, absolute and
/// relative, kind of feed.
const SINUMERIK_GROUPS: [u8; 5] = [6, 10, 13, 14, 15];

/// A program that leaves the modes that it found where the control can tell them, else those named at its end.
pub(super) fn program(
    title: &Title,
    head: &[String],
    steps: &[Step],
    coordinates: &Coordinates,
    dialect: Dialect,
) -> String {
    let comment = |text: &str| match dialect {
        Dialect::Sinumerik => format!("; {}\n", plain(text)),
        Dialect::Generic => format!("({})\n", capitals(text)),
        _ => format!("({})\n", plain(text)),
    };
    let mut out = String::new();
    if dialect == Dialect::Generic {
        let _ = writeln!(out, "%\nO{:04} ({})", title.number, capitals(&title.name.replace('_', "-")));
    }
    if dialect == Dialect::Sinumerik {
        // definitions come before all else
        for group in SINUMERIK_GROUPS {
            let _ = writeln!(out, "DEF INT GROUP{group}");
        }
    }
    if dialect != Dialect::Generic {
        out.push_str(&comment(&title.name));
    }
    head.iter().for_each(|line| out.push_str(&comment(line)));
    // the operator's hands are at the spindle next; off before modes are saved, so that they come back off
    out.push_str("M5\nM9\n");
    out.push_str(&save(dialect));
    // no turned coordinates, no tool length, no radius, no tool centre point control: axes move as written
    out.push_str(straight(dialect));
    out.push_str(modes(dialect));
    if dialect == Dialect::LinuxCnc {
        out.push_str(&comment("identity kinematics: with xyzac-trt-kins or xyzbc-trt-kins switch by M429 before"));
    }
    let coupled = steps.iter().any(|step| matches!(step, Step::Move { .. } | Step::Arc { .. }));
    // corners between blocks are not rounded by more than a micrometre, centres are relative; whatever ran before. Q0: LinuxCNC
    // must not put blocks together, which leaves the path of a corrected program
    out.push_str(match dialect {
        Dialect::LinuxCnc => "G64 P0.001 Q0 G91.1\n",
        Dialect::Sinumerik => "G641 ADIS=0.001\n",
        _ if coupled => "G64\n",
        _ => "",
    });
    blocks(&mut out, steps, coordinates, dialect, &comment);
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
        _ => format!("(NO WORD OF ISO 6983 TELLS THE MODES FOUND: LEFT AS HERE)\n{}", modes(dialect)),
    }
}

fn blocks(
    out: &mut String,
    steps: &[Step],
    coordinates: &Coordinates,
    dialect: Dialect,
    comment: &dyn Fn(&str) -> String,
) {
    // machine coordinates hold in one block only (G53); Sinumerik calls that SUPA
    let (before, after) = match (coordinates.is_machine(), dialect) {
        (false, _) => ("", ""),
        (true, Dialect::Sinumerik) => ("", " SUPA"),
        (true, _) => ("G53 ", ""),
    };
    let decimals = dialect.decimals();
    let word = |axis: &str, value: f64| {
        let equals = if dialect == Dialect::Sinumerik && axis.len() > 1 { "=" } else { "" };
        format!("{axis}{equals}{:.decimals$}", rounded(value, decimals))
    };
    let mut now = Modes { by_time: false, relative_in: None };
    for step in steps {
        now.change_for(step, out);
        match step {
            Step::Say(text) => out.push_str(&comment(text)),
            Step::Stop(text) => {
                // LinuxCNC shows the operator what begins so
                let shown = if dialect == Dialect::LinuxCnc { format!("MSG,{text}") } else { text.clone() };
                out.push_str(&comment(&shown));
                out.push_str("M0\n");
            }
            Step::Rapid { axis, to } => {
                let _ = writeln!(out, "{before}G0 {}{after}", word(axis, *to));
            }
            Step::Feed { axis, to, per_minute } => {
                let _ = writeln!(out, "{before}G1 {} F{}{after}", word(axis, *to), feed(*per_minute));
            }
            Step::Move { to, minutes } => {
                let words: Vec<String> = to.iter().map(|(axis, value)| word(axis, *value)).collect();
                let _ = writeln!(out, "{before}G1 {} F{}{after}", words.join(" "), feed(1.0 / minutes));
            }
            Step::Arc { axes: [one, other], centre, end, counter_clockwise, turns, turn, feed_mm_per_min } => {
                let g = if *counter_clockwise { 3 } else { 2 };
                let mut words = vec![word(one, end[0]), word(other, end[1])];
                words.extend(turn.iter().map(|(axis, deg)| word(axis, *deg)));
                words.extend([(one, centre[0]), (other, centre[1])].map(|(axis, to)| word(centre_letter(axis), to)));
                if *turns > 0 {
                    // LinuxCNC counts the last, unfinished turn too
                    words.push(format!("P{}", turns + 1));
                }
                let _ = writeln!(out, "G{g} {} F{}", words.join(" "), feed(*feed_mm_per_min));
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
    now.back(out);
}

/// Modes that steps change on the way: absolute positions in XY at a feed per minute else.
struct Modes {
    /// Each block has its time (G93).
    by_time: bool,
    /// Relative ends (G91) of arcs in this plane.
    relative_in: Option<u8>,
}

impl Modes {
    /// Words before a step that needs other modes; steps that do not move need none.
    fn change_for(&mut self, step: &Step, out: &mut String) {
        let wanted = match step {
            Step::Say(_) | Step::Stop(_) | Step::Dwell(_) => return,
            Step::Move { .. } => Modes { by_time: true, relative_in: None },
            Step::Arc { axes, .. } => Modes { by_time: false, relative_in: Some(plane(axes)) },
            Step::Feed { .. } | Step::Rapid { .. } => Modes { by_time: false, relative_in: None },
        };
        self.turn_to(wanted, out);
    }

    /// The modes in which a program began.
    fn back(&mut self, out: &mut String) {
        self.turn_to(Modes { by_time: false, relative_in: None }, out);
    }

    fn turn_to(&mut self, wanted: Modes, out: &mut String) {
        if wanted.by_time != self.by_time {
            out.push_str(if wanted.by_time { "G93\n" } else { "G94\n" });
        }
        if wanted.relative_in != self.relative_in {
            let _ = match wanted.relative_in {
                Some(plane) => writeln!(out, "G{plane} G91"),
                None => writeln!(out, "G17 G90"),
            };
        }
        *self = wanted;
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

//! Bodies that touch by design and bodies that can meet, as terminal text and JSON. They come found.

use std::fmt::Write as _;

use serde::Serialize;

use crate::collision::Meeting;
use crate::machine::Machine;

/// Pairs of a machine's bodies.
#[derive(Debug, Clone, Default)]
pub struct BodyPairs {
    /// Listed in the machine file: never compared.
    pub touching: Vec<(String, String)>,
    /// Overlapping with all axes at zero.
    pub at_zero: Vec<Meeting>,
    /// Meeting on the travel of the one joint between them.
    pub by_one_axis: Vec<Meeting>,
    /// Meeting where several joints bring them.
    pub by_several_axes: Vec<Meeting>,
}

/// `bodies` of `fiveaxis check --json`.
#[derive(Debug, Clone, Serialize)]
pub struct BodyPairsJson {
    pub touching: Vec<[String; 2]>,
    pub overlap_at_zero: Vec<MeetingJson>,
    pub can_touch_by_one_axis: Vec<MeetingJson>,
    pub can_touch_by_several_axes: Vec<MeetingJson>,
}

/// One pair that meets.
#[derive(Debug, Clone, Serialize)]
pub struct MeetingJson {
    pub pair: [String; 2],
    /// Axes between the two bodies and where they stand, mm or deg.
    pub at: Vec<(String, f64)>,
    pub depth_mm: f64,
}

/// The JSON of all pairs.
pub fn body_pairs_json(machine: &Machine, pairs: &BodyPairs) -> BodyPairsJson {
    BodyPairsJson {
        touching: touching_json(&pairs.touching),
        overlap_at_zero: meetings_json(machine, &pairs.at_zero),
        can_touch_by_one_axis: meetings_json(machine, &pairs.by_one_axis),
        can_touch_by_several_axes: meetings_json(machine, &pairs.by_several_axes),
    }
}

/// Listed pairs.
pub fn touching_json(touching: &[(String, String)]) -> Vec<[String; 2]> {
    touching.iter().map(|(one, other)| [one.clone(), other.clone()]).collect()
}

/// Pairs that meet.
pub fn meetings_json(machine: &Machine, meetings: &[Meeting]) -> Vec<MeetingJson> {
    let thousandths = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
    let one = |meeting: &Meeting| MeetingJson {
        pair: [meeting.pair.0.clone(), meeting.pair.1.clone()],
        at: places(machine, meeting, 1e3),
        depth_mm: thousandths(meeting.depth_mm),
    };
    meetings.iter().map(one).collect()
}

/// Axes and positions of a meeting in mm and degrees, `scale` being the parts of a unit shown.
fn places(machine: &Machine, meeting: &Meeting, scale: f64) -> Vec<(String, f64)> {
    let place = |&(axis, q): &(usize, f64)| {
        let axis = &machine.axes[axis];
        (axis.name.clone(), (axis.kind.to_file_unit(q) * scale).round() / scale + 0.0)
    };
    meeting.at.iter().map(place).collect()
}

/// `vice – cradle arm by 7.7 mm at C 37.5`.
fn words(machine: &Machine, meeting: &Meeting) -> String {
    let at: Vec<String> =
        places(machine, meeting, 10.0).into_iter().map(|(axis, position)| format!("{axis} {position}")).collect();
    format!("{} – {} by {:.1} mm at {}", meeting.pair.0, meeting.pair.1, meeting.depth_mm, at.join(" "))
}

/// What `check` says of bodies; empty for a machine without any.
pub fn body_pairs_text(machine: &Machine, pairs: &BodyPairs) -> String {
    let mut out = String::from("\nBodies\n");
    let touching: Vec<String> = pairs.touching.iter().map(|(one, other)| format!("{one} – {other}")).collect();
    let touching = if touching.is_empty() { "none".into() } else { touching.join(", ") };
    let _ = writeln!(out, "  listed as touching by design, never compared: {touching}");
    let groups = [
        (
            &pairs.at_zero,
            "OVERLAP with all axes at zero; plan and clearance are refused. Mend the bodies, or list a pair that a bearing or guideway joins under 'touching'",
        ),
        (
            &pairs.by_one_axis,
            "touch on the travel of the axis between them. Mend the bodies, or list a pair that a bearing or guideway joins under 'touching'; plan and clearance keep what is neither apart",
        ),
    ];
    for (meetings, what) in groups {
        if !meetings.is_empty() {
            let _ = writeln!(out, "  {what}:");
            meetings.iter().for_each(|meeting| {
                let _ = writeln!(out, "    {}", words(machine, meeting));
            });
        }
    }
    if !pairs.by_several_axes.is_empty() {
        let _ = writeln!(out, "  can be brought to touch by several axes; plan and clearance keep them apart:");
        for meeting in &pairs.by_several_axes {
            let _ = writeln!(out, "    {}", words(machine, meeting));
        }
    }
    out
}

/// What `plan` and `clearance` say of pairs that one axis brings to touch: a real obstacle, or a body in the wrong place.
pub fn can_touch_note(machine: &Machine, meetings: &[Meeting]) -> Option<String> {
    let told: Vec<String> = meetings.iter().map(|meeting| words(machine, meeting)).collect();
    (!told.is_empty()).then(|| {
        format!(
            "note: bodies that one axis brings to touch, which the tests keep apart: {}; where a bearing or guideway joins a pair, list it under 'touching' in the machine file",
            told.join(", ")
        )
    })
}

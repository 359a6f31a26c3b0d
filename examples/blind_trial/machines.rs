//! Machines to draw from: structural codes with dimensions of their own; no tests and no errors.

use super::draw::Draw;
use super::kinematics::{Joint, Machine, V3, unit};

/// A family of machines; slides stand nearer the bed than joints in all of them.
struct Family {
    code: &'static str,
    weight: f64,
    /// Direction of the tilting joint where it is not its letter's.
    nutating: Option<V3>,
}

const FAMILIES: &[Family] = &[
    Family { code: "[wCAbYXZt]", weight: 5.0, nutating: None },
    Family { code: "[wCXbYZAt]", weight: 3.0, nutating: None },
    Family { code: "[wXbYZCBt]", weight: 3.0, nutating: None },
    Family { code: "[wCBXbYZt]", weight: 1.0, nutating: None },
    Family { code: "[wYXbZCAt]", weight: 1.0, nutating: None },
    Family { code: "[wCBbXYZt]", weight: 1.0, nutating: Some([0.0, 1.0, -1.0]) },
    Family { code: "[wXbYZCBt]", weight: 0.7, nutating: Some([0.0, 1.0, 1.0]) },
];

/// Draws a machine: family, offsets between its joints, length of the head, sense of its counters.
pub fn draw(rng: &mut Draw) -> Machine {
    let weights: Vec<f64> = FAMILIES.iter().map(|f| f.weight).collect();
    let family = &FAMILIES[rng.weighted(&weights)];
    let head_mm = (rng.between(140.0, 260.0) / 10.0).round() * 10.0;
    let offset_mm = if rng.chance(0.6) { 0.0 } else { rng.between(-60.0, 60.0).round() };
    let reversed = rng.chance(0.1);
    let mut machine = build(family.code, family.nutating.map(unit), head_mm, offset_mm);
    if reversed {
        let c = machine.axis("C");
        machine.joints[c].reversed = true;
    }
    machine
}

/// The three machines of the published sessions, by code.
pub fn plain(code: &str) -> Machine {
    build(code, None, 200.0, 0.0)
}

/// Tool-side tilting joints turn about a line `head_mm` above the spindle ball, table-side ones `offset_mm` beside C.
fn build(code: &str, nutating: Option<V3>, head_mm: f64, offset_mm: f64) -> Machine {
    let letters: Vec<char> = code.chars().filter(|c| c.is_ascii_uppercase() || *c == 'b').collect();
    let bed = letters.iter().position(|&c| c == 'b').unwrap_or(0);
    let mut machine = Machine {
        name: format!("{} {head_mm:.0}", if nutating.is_some() { "Nutating" } else { "Five-axis" }),
        code: code.to_string(),
        joints: vec![],
        work: vec![],
        tool: vec![],
    };
    for (i, &letter) in letters.iter().enumerate().filter(|(i, _)| *i != bed) {
        let index = machine.joints.len();
        let tool_side = i > bed;
        machine.joints.push(joint(letter, tool_side, nutating, head_mm, offset_mm));
        if tool_side {
            machine.tool.push(index);
        } else {
            // the code runs from the workpiece to the bed; branches here run outward
            machine.work.insert(0, index);
        }
    }
    machine
}

fn joint(letter: char, tool_side: bool, nutating: Option<V3>, head_mm: f64, offset_mm: f64) -> Joint {
    let plain: V3 = match letter {
        'X' | 'A' => [1.0, 0.0, 0.0],
        'Y' | 'B' => [0.0, 1.0, 0.0],
        _ => [0.0, 0.0, 1.0],
    };
    let rotary = "ABC".contains(letter);
    let tilting = "AB".contains(letter);
    let origin = match (tilting, tool_side) {
        (true, true) => [0.0, 0.0, head_mm],
        (true, false) if nutating.is_none() => [0.0, 0.0, offset_mm],
        _ => [0.0; 3],
    };
    Joint {
        name: letter.to_string(),
        rotary,
        direction: if tilting { nutating.unwrap_or(plain) } else { plain },
        origin,
        range: match (rotary, tilting) {
            (true, true) => (-110.0, 110.0),
            (true, false) => (-360.0, 360.0),
            _ => (-600.0, 600.0),
        },
        reversed: false,
    }
}

/// Codes of all families.
pub fn codes() -> Vec<&'static str> {
    FAMILIES.iter().map(|f| f.code).collect()
}

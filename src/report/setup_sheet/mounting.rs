//! What is mounted for a test, in an operator's words: pivot, bar, calibrator, spindle side. It computes nothing.

use nalgebra::Vector3;

use super::sheet::Sheet;
use crate::nc::{Coordinates, placing_words};
use crate::plan::{CupLooks, Mounting, PlannedTest};
use crate::units::Measure;

/// What differs from the test before.
pub(super) fn changes(before: Option<&PlannedTest>, planned: &PlannedTest) -> String {
    let test = &planned.test;
    let same = |what: &dyn Fn(&PlannedTest) -> bool| before.is_some_and(what);
    let mut words = Vec::new();
    if !same(&|other| other.test.pivot == test.pivot) {
        words.push(format!("pivot on {}", planned.mount));
    }
    if !same(&|other| other.test.spindle_ball.at == test.spindle_ball.at && other.mounting.arm == planned.mounting.arm)
    {
        words.push(match &planned.mounting.arm {
            None => format!("spindle cup, ball {:.3} mm from the nose", planned.mounting.nose_to_ball_mm),
            Some(arm) => {
                format!("fixture {} mm, ball {:.3} mm from the nose", arm.length_mm, planned.mounting.nose_to_ball_mm)
            }
        });
    }
    let indexed = |test: &PlannedTest| test.test.spindle_ball.indexed_about.is_some();
    match (before.is_some_and(indexed), indexed(planned)) {
        (false, true) => words.push("spindle to 180°, cup left in".into()),
        (true, false) => words.push("spindle back to 0°".into()),
        _ => {}
    }
    if !same(&|other| other.test.bar_length_mm == test.bar_length_mm) {
        words.push(format!("bar {} mm", test.bar_length_mm.unwrap_or(0.0)));
    }
    match words.is_empty() {
        true => "nothing, all stays".into(),
        false => words.join(", "),
    }
}

/// Rows of the table.
pub(super) fn rows(sheet: &Sheet, planned: &PlannedTest) -> Vec<(&'static str, String)> {
    let test = &planned.test;
    let mounting = &planned.mounting;
    let mut rows = vec![
        ("pivot", pivot(sheet, planned)),
        ("place it", placing_words(sheet.machine, planned, &Coordinates::of(sheet.machine))),
        ("pivot ball", format!("{}, with all axes at zero", place(&test.pivot.at))),
        ("bar", bar(mounting)),
        ("zero the bar", calibrator(sheet, mounting)),
        ("spindle side", spindle_side(sheet, planned)),
        ("spindle ball", format!("{}, with all axes at zero", place(&test.spindle_ball.at))),
    ];
    if sheet.some_test_is_indexed() {
        rows.push(("spindle at", index(sheet, planned)));
    }
    rows
}

fn pivot(sheet: &Sheet, planned: &PlannedTest) -> String {
    let test = &planned.test;
    let mut words =
        format!("on {} (link {}), ball {:.3} mm above the surface", planned.mount, test.pivot.link, planned.height_mm);
    if let Some(mount) = sheet.bodies.mounts.iter().find(|mount| mount.name == planned.mount) {
        let foot = test.pivot.at - mount.normal * planned.height_mm - mount.middle;
        match in_surface(&foot) {
            Some(across) => words.push_str(&format!("; foot {across} from the middle of the surface")),
            None => words.push_str("; in the middle of the surface"),
        }
    }
    words
}

/// `x -100.000 y 30.000 mm`, zeros left out; `None` for none at all.
fn in_surface(foot: &Vector3<f64>) -> Option<String> {
    let parts: Vec<String> = ["x", "y", "z"]
        .iter()
        .zip(foot.iter())
        .filter(|(_, value)| value.abs() > 5e-4)
        .map(|(letter, value)| format!("{letter} {value:+.3}"))
        .collect();
    (!parts.is_empty()).then(|| format!("{} mm", parts.join(" ")))
}

fn place(at: &Vector3<f64>) -> String {
    let shown = |value: f64| format!("{:.3}", value + 0.0);
    format!("x {}  y {}  z {} mm", shown(at.x), shown(at.y), shown(at.z))
}

/// `250 mm: the 100 mm bar with extension 150 mm`.
fn bar(mounting: &Mounting) -> String {
    let length_mm: f64 = mounting.bar_parts_mm.iter().sum();
    match mounting.bar_parts_mm.split_first() {
        Some((bar, [])) => format!("{bar} mm, without extension"),
        Some((bar, [one])) => format!("{length_mm} mm = {bar} mm bar + {one} mm extension"),
        Some((bar, more)) => {
            let more: Vec<String> = more.iter().map(|part| format!("{part} mm")).collect();
            format!("{length_mm} mm = {bar} mm bar + extensions {}", more.join(" + "))
        }
        None => String::new(),
    }
}

fn calibrator(sheet: &Sheet, mounting: &Mounting) -> String {
    let length_mm: f64 = mounting.bar_parts_mm.iter().sum();
    let spread_um = Measure::Length.to_output(sheet.settings.uncertainty.spread.bar_length_mm);
    match mounting.calibrator_mm {
        Some(certified) if (certified - length_mm).abs() < 1e-6 => {
            format!("on the calibrator at {certified} mm; enter the length found as bar_length of the session")
        }
        Some(certified) => format!(
            "the calibrator has no {length_mm} mm: zero the {certified} mm part on it, then add the rest at its certified length; the plan counts on ± {spread_um} µm in all"
        ),
        None => format!(
            "the kit names no calibrator length for these parts: the length must be known otherwise, the plan counts on ± {spread_um} µm"
        ),
    }
}

fn spindle_side(sheet: &Sheet, planned: &PlannedTest) -> String {
    let mounting = &planned.mounting;
    let known = (planned.placing.gauge_length_mm * 1e3).floor() / 1e3;
    let stated = match sheet.machine.gauge_length_mm {
        Some(_) => "",
        None => " (the machine file states no gauge_length; its spindle ball stands there)",
    };
    let from_nose = format!(
        "{:.3} mm from spindle nose to ball centre, the gauge length{stated}, known within {known} mm",
        mounting.nose_to_ball_mm
    );
    match &mounting.arm {
        None => format!("cup on a straight stem, ball on the tool axis, {from_nose}"),
        Some(arm) => format!(
            "flat fixture, arm {} mm towards {} (all axes at zero), cup looks {}; {from_nose}, along the tool axis; orient and lock the \
             spindle first, the arm turns with it",
            arm.length_mm,
            direction(&arm.towards),
            match arm.cup {
                CupLooks::DownTheTool => "down the tool",
                CupLooks::Outward => "outward along the arm",
            }
        ),
    }
}

/// `+x`, or the vector where it is none of R's directions.
fn direction(towards: &Vector3<f64>) -> String {
    let along = ["x", "y", "z"].iter().zip(towards.iter()).find(|(_, part)| part.abs() > 1.0 - 1e-6);
    match along {
        Some((letter, part)) => format!("{}{letter}", if *part > 0.0 { '+' } else { '-' }),
        None => format!("({:.4}, {:.4}, {:.4})", towards.x, towards.y, towards.z),
    }
}

/// How the spindle stands, and which test is the same at the other stand.
fn index(sheet: &Sheet, planned: &PlannedTest) -> String {
    let twin = |other: &&PlannedTest| {
        let (a, b) = (&other.test, &planned.test);
        a.spindle_ball.indexed_about != b.spindle_ball.indexed_about
            && (&a.pivot, a.spindle_ball.at, a.bar_length_mm) == (&b.pivot, b.spindle_ball.at, b.bar_length_mm)
            && (&a.path, &a.positions) == (&b.path, &b.positions)
    };
    let twin = sheet.plan.tests.iter().find(twin).map(|other| other.test.name.as_str());
    match (planned.test.spindle_ball.indexed_about.is_some(), twin) {
        (true, Some(twin)) => {
            format!("180°: turned by 180° after {twin}, locked, cup and ball left in; all else as in {twin}")
        }
        (true, None) => "180°: turned by 180° from the other tests, locked, cup and ball left in".into(),
        (false, Some(twin)) => format!("0°, locked; the same again at 180° is {twin}"),
        (false, None) => "0°, locked".into(),
    }
}

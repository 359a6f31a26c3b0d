//! Kit files: bar, extensions, cups, stand and fixture, to a [`Kit`].

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::bodies::{Bar, Cup, Fixture, Kit, PivotStand};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{EXTENSIONS, KIT_LIST, YAML_BYTES};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::read_limited;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KitFile {
    name: String,
    bar: BarFile,
    pivot_cup: CupFile,
    spindle_cup: CupFile,
    pivot_stand: StandFile,
    #[serde(default)]
    spindle_reach: f64,
    fixture: Option<FixtureFile>,
    #[serde(default)]
    calibrator: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BarFile {
    length: f64,
    #[serde(default)]
    extensions: Vec<f64>,
    half_stroke: f64,
    radius: f64,
    neck_radius: f64,
    neck_length: f64,
    ball_radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CupFile {
    radius: f64,
    rim_below_ball: f64,
    height: f64,
    cone: f64,
    stem_radius: f64,
}

impl CupFile {
    fn sizes(&self) -> Vec<f64> {
        vec![self.radius, self.rim_below_ball, self.height, self.cone, self.stem_radius]
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StandFile {
    base_radius: f64,
    base_height: f64,
    height: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FixtureFile {
    arms: Vec<f64>,
    arm_radius: f64,
}

/// Kit of the common 100 mm bar; `kits/ballbar.yaml`.
const STANDARD_KIT: &str = include_str!("../../kits/ballbar.yaml");

/// The kit that ships with the program.
pub fn standard_kit() -> Result<Kit, LoadError> {
    kit_from_yaml(Path::new("kits/ballbar.yaml"), STANDARD_KIT.to_string())
}

/// Reads a kit file.
pub fn load_kit(file: &Path) -> Result<Kit, LoadError> {
    kit_from_yaml(file, read_limited(file, YAML_BYTES)?)
}

/// The kit that a text states, when its sizes can be made.
fn kit_from_yaml(file: &Path, text: String) -> Result<Kit, LoadError> {
    let document = Document::parse(file, text)?;
    let raw: KitFile = document.read()?;
    check_sizes(&document, &raw)?;
    let bar = Bar {
        length_mm: raw.bar.length,
        extensions_mm: raw.bar.extensions,
        half_stroke_mm: raw.bar.half_stroke,
        radius_mm: raw.bar.radius,
        neck_radius_mm: raw.bar.neck_radius,
        neck_length_mm: raw.bar.neck_length,
        ball_radius_mm: raw.bar.ball_radius,
    };
    Ok(Kit {
        name: raw.name,
        pivot_cup: cup(&document, "pivot_cup", &raw.pivot_cup, &bar)?,
        spindle_cup: cup(&document, "spindle_cup", &raw.spindle_cup, &bar)?,
        bar,
        pivot_stand: PivotStand {
            base_radius_mm: raw.pivot_stand.base_radius,
            base_height_mm: raw.pivot_stand.base_height,
            height_mm: raw.pivot_stand.height,
        },
        spindle_reach_mm: raw.spindle_reach,
        fixture: raw.fixture.map(|f| Fixture { arms_mm: f.arms, arm_radius_mm: f.arm_radius }),
        calibrator_mm: raw.calibrator,
    })
}

/// Refuses sizes that nothing can have, and lists that are too long.
fn check_sizes(document: &Document, raw: &KitFile) -> Result<(), LoadError> {
    let sizes = BTreeMap::from([
        (
            "bar",
            vec![
                raw.bar.length,
                raw.bar.half_stroke,
                raw.bar.radius,
                raw.bar.neck_radius,
                raw.bar.neck_length,
                raw.bar.ball_radius,
            ],
        ),
        ("pivot_cup", raw.pivot_cup.sizes()),
        ("spindle_cup", raw.spindle_cup.sizes()),
        ("pivot_stand", vec![raw.pivot_stand.base_radius, raw.pivot_stand.base_height, raw.pivot_stand.height[0]]),
        ("fixture", raw.fixture.iter().flat_map(|f| f.arms.iter().copied().chain([f.arm_radius])).collect()),
        ("calibrator", raw.calibrator.clone()),
    ]);
    for (key, values) in &sizes {
        if values.iter().chain(&raw.bar.extensions).any(|v| !(v.is_finite() && *v > 0.0 && *v < 1e5)) {
            return Err(
                document.refuse(&[Step::Key(key)], "every size is a finite number above zero, mm (cone: degrees)")
            );
        }
    }
    if let Some(message) = EXTENSIONS.exceeded(raw.bar.extensions.len()) {
        return Err(document.refuse(&[Step::Key("bar")], message));
    }
    for (key, list) in
        [("fixture", raw.fixture.as_ref().map_or(0, |f| f.arms.len())), ("calibrator", raw.calibrator.len())]
    {
        if let Some(message) = KIT_LIST.exceeded(list) {
            return Err(document.refuse(&[Step::Key(key)], message));
        }
    }
    if !(raw.spindle_reach.is_finite() && (0.0..1e5).contains(&raw.spindle_reach)) {
        return Err(document.refuse(&[Step::Key("spindle_reach")], "a finite length from 0 mm up, 0 for none"));
    }
    if !(0.0..1e5).contains(&raw.pivot_stand.height[1]) {
        return Err(document.refuse(&[Step::Key("pivot_stand")], "every height is below 100000 mm"));
    }
    if raw.pivot_stand.height[1] < raw.pivot_stand.height[0] {
        return Err(document.refuse(&[Step::Key("pivot_stand")], "height is lowest first: [45, 220]"));
    }
    Ok(())
}

/// A cup, when the bar meets its rim no sooner than the cone says.
fn cup(document: &Document, key: &str, raw: &CupFile, bar: &Bar) -> Result<Cup, LoadError> {
    let cup = Cup {
        radius_mm: raw.radius,
        rim_below_ball_mm: raw.rim_below_ball,
        height_mm: raw.height,
        cone_rad: raw.cone.to_radians(),
        stem_radius_mm: raw.stem_radius,
    };
    let most = cup.rim_angle_rad(bar);
    if cup.cone_rad > most {
        return Err(document.refuse(
            &[Step::Key(key)],
            format!(
                "cone: {} lets the bar touch the cup: it meets the rim at {:.1} degrees from the cup's axis (radius {}, rim_below_ball {}, the bar's neck_radius {})",
                raw.cone,
                most.to_degrees(),
                raw.radius,
                raw.rim_below_ball,
                bar.neck_radius_mm
            ),
        ));
    }
    Ok(cup)
}

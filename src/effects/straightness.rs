//! Errors of a slide across its motion that depend on its position: bow, wave and local wear. Scale and pitch errors are in `slide`.
//!
//! `degreeN`: `s (q / half_travel)^N`, zero at position 0. `bump`: `s (1 + cos 2π(q − c)/w) / 2` within w/2 of the
//! centre c, zero outside (`slope`: its incline, 1 at the steepest place); with a skew k the rising half is `w (1 + k) / 2` wide and the falling one `w (1 − k) / 2`.

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, Refined, beside_own, motion, none, with_list, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, list, no_check,
    plain_measure, word,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};
use crate::units::Measure;
use std::f64::consts::PI;

/// Skew of a bump.
pub(super) const SKEW: Parameter = Parameter::number(
    "skew",
    ParameterUnit::Plain,
    DefaultValue::Number(0.0),
    (-0.9, 0.9),
    "how much wider the rising half is than half the width",
);

/// Straightness, pitch, yaw and roll of a slide.
pub static STRAIGHTNESS: Kind = Kind {
    name: "straightness",
    driver: Driver::Position,
    formula: "E = s (1 + cos 2 pi (q - c)/w)/2 near c, or s (q/half_travel)^N",
    size_meaning: "height of the bump, or value at half_travel of a power",
    cause: "local guideway wear or a damaged rail (bump), sagging or bent guideway, foundation (bow)",
    remedy: "level and scrape or renew the guideway; compensate by tables if it repeats; keep work off the worn part",
    titles: &[("", "{place} does not run straight ({moving})")],
    measures: Some("at its highest"),
    notable: Notable { length: 1.5, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Circles },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Linear],
    // simulated guideways with skewed bumps that tip the carriage: heights off by 10 % in six of seven sessions
    form_error: 0.07,
    needs_runs: false,
    signature: Signature::Straightness,
    candidates: bumps_and_bows,
    candidates_of_poses: none,
    documented: Documented {
        place: "slide",
        components: "all but own",
        functions: "`bump = (1 + cos 2π(q−c)/w)/2` within w/2 of c, with `slope: yes` also `slope`, its incline; `degreeN = (q/half_travel)^N`",
        parameters: "`centre`, `width`, `skew`, `degrees`, `half_travel`, `slope` (no, yes)",
        unit: "um, arcsec",
    },
    parameters: &[
        Parameter::number(
            "centre",
            ParameterUnit::Position,
            DefaultValue::Absent,
            (-1e5, 1e5),
            "centre of the bump, mm",
        ),
        Parameter::number(
            "width",
            ParameterUnit::Position,
            DefaultValue::Number(60.0),
            (1e-3, 1e5),
            "width of the bump between its feet, mm",
        ),
        SKEW,
        Parameter::list("degrees", ParameterUnit::Plain, DefaultValue::Absent, (1.0, 9.0), "powers of position"),
        Parameter::number(
            "half_travel",
            ParameterUnit::Position,
            DefaultValue::Number(100.0),
            (1e-3, 1e5),
            "position at which a power has the stated size, mm",
        ),
        Parameter::word(
            "slope",
            &["no", "yes"],
            DefaultValue::Absent,
            "yes adds the function slope, the incline of the bump: tilts of a carriage that follows it",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Linear => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |effect| {
        let bump = effect.number("centre").map(|_| "bump".to_string());
        let slope = has_slope(effect).then(|| SLOPE.to_string());
        let powers = list(effect, "degrees").iter().map(|degree| format!("degree{degree}"));
        bump.into_iter().chain(slope).chain(powers).collect()
    },
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let number = |name| STRAIGHTNESS.number(context, effect, name);
    let (width, skew, half_travel) = (number("width"), number("skew"), number("half_travel"));
    let bump = effect
        .number("centre")
        .map(|centre| context.position_profile(axis, |q| raised_cosine(q - centre, width / 2.0, skew)));
    let slope = has_slope(effect).then(|| {
        let centre = number("centre");
        context.position_profile(axis, |q| incline(q - centre, width / 2.0, skew))
    });
    let powers = list(effect, "degrees")
        .iter()
        .map(|&degree| context.position_profile(axis, |q| power(q / half_travel, degree)));
    Ok(bump.into_iter().chain(slope).chain(powers).collect())
}

/// Name of the function that turns with the incline of the bump.
pub const SLOPE: &str = "slope";

fn has_slope(effect: &Effect) -> bool {
    word(effect, "slope") == Some("yes") && effect.number("centre").is_some()
}

/// Incline of the raised cosine in units of the largest one of a bump without skew.
fn incline(from_centre: f64, half_width: f64, skew: f64) -> f64 {
    let half = if from_centre < 0.0 { half_width * (1.0 + skew) } else { half_width * (1.0 - skew) };
    if from_centre.abs() < half { -(PI * from_centre / half).sin() * half_width / half } else { 0.0 }
}

/// `sgn` kept for odd degrees; degrees are whole numbers.
fn power(ratio: f64, degree: f64) -> f64 {
    ratio.powi(degree.round() as i32)
}

pub(super) fn raised_cosine(from_centre: f64, half_width: f64, skew: f64) -> f64 {
    let half = if from_centre < 0.0 { half_width * (1.0 + skew) } else { half_width * (1.0 - skew) };
    if from_centre.abs() < half { (1.0 + (PI * from_centre / half).cos()) / 2.0 } else { 0.0 }
}

/// Heights up to this are plausible, µm or arcsec: a worn way of a machine tool wanders by ten or twenty.
const PLAUSIBLE: f64 = 20.0;

/// Widths of bumps that are tried, as shares of the way.
const WIDTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.12];

fn bumps_and_bows(seen: &Observations) -> Vec<CandidateFamily> {
    seen.displaced_slides().flat_map(|(axis, ends)| of_slide(seen.machine(), axis, ends)).collect()
}

/// Bumps of these widths, a quarter of their width apart, from a first centre on as long as their centres are inside.
pub(super) fn bumps(
    kind: &str,
    place: Place,
    first: f64,
    widths: &[f64],
    is_inside: impl Fn(f64) -> bool,
) -> Vec<Effect> {
    let mut grid = Vec::new();
    for &width in widths {
        let mut centre = first;
        while is_inside(centre) {
            grid.push(with_number(kind, place, "centre", centre).with("width", ParameterValue::Number(width)));
            centre += width / 4.0;
        }
    }
    grid
}

/// Bumps and bows of a slide in each component beside its own motion, over the way on which it was.
fn of_slide(machine: &Machine, axis: usize, (from, to): (f64, f64)) -> Vec<CandidateFamily> {
    let (place, span) = (Place::Axis(axis), to - from);
    let grid = bumps(STRAIGHTNESS.name, place, from, &WIDTHS.map(|share| share * span), |centre| centre <= to + 1e-9);
    let with_slope: Vec<Effect> =
        grid.iter().map(|bump| bump.clone().with(SLOPE, ParameterValue::Word("yes".into()))).collect();
    let shape = vec![
        Refined::number("centre", (from - 0.3 * span, to + 0.3 * span), 0.03 * span),
        Refined::number("width", (0.05 * span, 2.0 * span), 0.05 * span),
        Refined::number("skew", (-0.8, 0.8), 0.2),
    ];
    let bow = with_list(STRAIGHTNESS.name, place, "degrees", vec![2.0, 3.0])
        .with("half_travel", ParameterValue::Number(span / 2.0));
    // a budget says how far a slide strays per length moved, and nothing of how it turns
    let budget = Measure::Length.to_output(machine.linear_axes.straightness * span / 2.0);
    let new = |outlets: Vec<Outlet>| {
        let is_shift = outlets.iter().any(|outlet| outlet.measure(machine) == Measure::Length);
        let family = CandidateFamily::new(STRAIGHTNESS.name, place, outlets, PLAUSIBLE);
        if is_shift { family.within(budget) } else { family }
    };
    let mut list = Vec::new();
    for component in beside_own(machine, axis) {
        if let Some(tilt) = tilt_of(axis, component, machine) {
            // a carriage that climbs a bump turns with its incline
            let outlets = motion(axis, &[component, tilt]);
            let pairs = outlets.iter().copied().zip(["bump", SLOPE]).collect();
            list.push(CandidateFamily { pairs, ..new(outlets).over(with_slope.clone()).refine(shape.clone()) });
        }
        list.push(new(motion(axis, &[component])).over(grid.clone()).refine(shape.clone()));
        list.push(new(motion(axis, &[component])).over(vec![bow.clone()]));
    }
    list
}

/// The tilt of a carriage that follows a straightness error: about what is square to its way and to the error.
fn tilt_of(axis: usize, component: Component, machine: &Machine) -> Option<Component> {
    let along = machine.axes[axis].own_component().index();
    let across = component.index();
    (across < 3).then(|| Component::ALL[3 + (3 - along - across)])
}

//! Which option of a plan keeps errors from being told, and which would bring them below the goal: found by planning without or with it.

use super::plan_result::Plan;
use super::planning::{plan, seen};
use crate::bodies::{Bodies, Kit};
use crate::machine::Machine;
use crate::plan::context::error::PlanError;
use crate::plan::context::settings::Settings;
use crate::plan::places::candidate::Coupled;
use crate::plan::places::following::FOLLOWED;
use crate::units::Measure;

/// A plan whose reasons name the option that leaves an error out, with advice on what would reach the goal.
///
/// It plans again for every option that narrows the choice, as long as something is undetermined, and with `--circles` where
/// the linear axes keep an error above its goal.
pub fn plan_with_advice(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Plan, PlanError> {
    let mut found = plan(machine, bodies, kit, settings)?;
    if settings.method.is_some() {
        return Ok(found);
    }
    for (option, relaxed) in narrowing(machine, settings) {
        if found.errors.iter().all(|error| error.determined) {
            break;
        }
        // what lengths of reachable setups do not show with the option taken away either is not left out by it
        let widens_reach = relaxed.avoid != settings.avoid || relaxed.coupled != settings.coupled;
        let is_seen = match widens_reach {
            true => seen(machine, bodies, kit, &relaxed).unwrap_or_default(),
            false => found.errors.iter().map(|error| error.visible).collect(),
        };
        if found.errors.iter().zip(is_seen).all(|(error, is_seen)| error.determined || !is_seen) {
            continue;
        }
        let Ok(free) = plan(machine, bodies, kit, &relaxed) else { continue };
        for (error, other) in found.errors.iter_mut().zip(&free.errors) {
            if !error.determined && other.determined && !error.reason.starts_with(LEFT_OUT) {
                let detail = std::mem::take(&mut error.reason);
                error.reason = format!("{LEFT_OUT}{option} {:.1} minutes bring it", free.minutes);
                // what holds of these tests alone is no law of the machine
                if !detail.contains("changes no ball-bar length") {
                    error.reason = format!("{}; {detail}", error.reason);
                }
            }
        }
    }
    if found.errors.iter().any(|error| error.by_linear_axes)
        && settings.goal.minutes.is_none()
        && !settings.coupled.circles
    {
        found.advice.extend(with_circles(machine, bodies, kit, settings, &found));
    }
    Ok(found)
}

/// How a reason begins that names an option.
const LEFT_OUT: &str = "left out by ";

/// Options that leave less to choose from than the ordinary plan has, with what to do instead, and the settings for that.
fn narrowing(machine: &Machine, settings: &Settings) -> Vec<(String, Settings)> {
    let ordinary = Settings::default();
    let mut list = Vec::new();
    if !settings.avoid.is_empty() {
        let regions = settings.avoid.iter().map(|&(axis, from, to)| {
            let entry = &machine.axes[axis];
            let tidy = |q: f64| (entry.kind.to_file_unit(q) * 1e3).round() / 1e3 + 0.0;
            format!("--avoid {}={}..{}", entry.name, tidy(from), tidy(to))
        });
        let option = format!("{}: without it", regions.collect::<Vec<_>>().join(" "));
        list.push((option, Settings { avoid: Vec::new(), ..settings.clone() }));
    }
    if settings.margin_mm > ordinary.margin_mm {
        let option = format!("--margin {}: with {} mm", settings.margin_mm, ordinary.margin_mm);
        list.push((option, Settings { margin_mm: ordinary.margin_mm, ..settings.clone() }));
    }
    if let Some(most) = settings.pivots {
        list.push((format!("--pivots {most}: without it"), Settings { pivots: None, ..settings.clone() }));
    }
    if settings.coupled.follow.len() < FOLLOWED.len() {
        let coupled = Coupled { follow: FOLLOWED.to_vec(), ..settings.coupled.clone() };
        list.push(("--follow: with all ways of following".into(), Settings { coupled, ..settings.clone() }));
    }
    list
}

/// What circles, and the spindle indexed as well, make of the errors that the linear axes keep above their goal.
fn with_circles(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings, found: &Plan) -> Vec<String> {
    let coupled = Coupled { circles: true, ..settings.coupled.clone() };
    let circles = Settings { coupled, ..settings.clone() };
    let indexed = Settings { index_spindle: true, ..circles.clone() };
    let mut tries = vec![("--circles", circles)];
    // an index turns the ball and not the pivot length
    if !settings.index_spindle && settings.uncertainty.spread.pivot_length_mm == 0.0 {
        tries.push(("--circles --index-spindle", indexed));
    }
    let mut advice = Vec::new();
    for (options, settings) in tries {
        let Ok(other) = plan(machine, bodies, kit, &settings) else { continue };
        let mut reaches_all = true;
        let mut figures = Vec::new();
        for error in found.errors.iter().filter(|error| error.by_linear_axes) {
            let Some(with) = other.errors.iter().find(|with| with.name == error.name && with.determined) else {
                continue;
            };
            let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
            let goal = if error.is_angle { settings.goal.orientation_rad } else { settings.goal.position_mm };
            reaches_all &= with.sigma_relative <= goal * 1.001;
            if with.sigma_relative < error.sigma_relative {
                let [from, to] = [error, with].map(|error| measure.to_output(error.sigma_relative));
                figures.push(format!("{} {from:.2} to {to:.2} {}", error.name, measure.output_unit()));
            }
        }
        if figures.is_empty() {
            continue;
        }
        let verdict = if reaches_all { "all of them within the goal" } else { "not all within the goal" };
        advice.push(format!("with {options} in {:.0} minutes: {}; {verdict}", other.minutes, figures.join(", ")));
        if reaches_all {
            break;
        }
    }
    if advice.is_empty() {
        advice.push(
            "planned with --circles and --index-spindle, what the linear axes keep above the goal stays there".into(),
        );
    }
    advice
}

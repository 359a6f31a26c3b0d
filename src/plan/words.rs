//! What a set of tests determines, how well, and in words what it does not and why. It chooses nothing.

use std::collections::{BTreeMap, HashMap};

use super::choose::{Desk, MAX_FAILURES};
use super::information::{Block, HELD, Knowledge, LOOSE, Nuisance};
use crate::machine::AxisKind;

/// Forecast for one location error.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorForecast {
    pub name: String,
    pub is_angle: bool,
    /// The data fix it, given the spindle balls: less than half of its variance stems from priors. The same as a fit's.
    pub determined: bool,
    /// Lengths of reachable setups would fix it if nothing stood in their way: what is not visible, no ball bar determines.
    pub visible: bool,
    /// Standard deviation with all priors, mm or rad.
    pub sigma: f64,
    /// The same with the spindle ball's place taken as given.
    pub sigma_relative: f64,
    /// Share of the priors in its variance, given the spindle balls: below a half it is determined.
    pub prior_share: f64,
    /// Why not, or relative to what.
    pub reason: String,
}

/// Share of the priors in the variance from which an error is not determined.
const HALF: f64 = 0.5;
/// Correlation from which two errors are named together.
const TOGETHER: f64 = 0.9;

/// What a fit of the recordings would say of an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fitted {
    /// Share of the priors in its variance.
    pub prior_share: f64,
    /// mm or rad.
    pub sigma: f64,
}

impl Fitted {
    /// The fit would call it determined.
    pub fn is_determined(&self) -> bool {
        self.prior_share < HALF
    }
}

/// For each wanted error: what a fit of the recordings would say of it.
pub(super) fn fitted(desk: &Desk, blocks: &[&Block]) -> Vec<Fitted> {
    let is_not_fitted =
        |nuisance: &Nuisance| matches!(nuisance, Nuisance::SpindleBall(_) | Nuisance::Stand(_) | Nuisance::Scale(_));
    let mut fitted = Knowledge::before(&desk.unknowns.with_exact_linear_axes());
    blocks.iter().for_each(|block| fitted.add(&block.with_prior_scaled(is_not_fitted, HELD)));
    let of = |k: usize| Fitted { prior_share: fitted.prior_share(k), sigma: fitted.covariance(k, k).sqrt() };
    (0..desk.unknowns.wanted).map(of).collect()
}

/// Forecast of all wanted errors for a set of tests.
pub(super) fn forecasts(desk: &Desk, blocks: &[&Block]) -> Vec<ErrorForecast> {
    let unknowns = &desk.unknowns;
    let after = |mut knowledge: Knowledge, change: &dyn Fn(&Block) -> Block| {
        blocks.iter().for_each(|block| knowledge.add(&change(block)));
        knowledge
    };
    let before = || Knowledge::before(unknowns);
    let is_pivot = |nuisance: &Nuisance| matches!(nuisance, Nuisance::Pivot(..));
    let is_spindle = |nuisance: &Nuisance| matches!(nuisance, Nuisance::SpindleBall(_));
    let plain = after(before(), &|block| block.clone());
    let loose_pivot = after(before(), &|block| block.with_prior_scaled(is_pivot, LOOSE));
    let given_spindle = after(before(), &|block| block.with_prior_scaled(is_spindle, HELD));
    let fitted = fitted(desk, blocks);
    (0..unknowns.wanted)
        .map(|k| {
            let (axis, component, name) = &unknowns.errors[k];
            let sigma = plain.covariance(k, k).sqrt();
            let sigma_relative = given_spindle.covariance(k, k).sqrt();
            let determined = fitted[k].is_determined();
            // without the pivots' spread nothing would be left of what was known before
            let by_pivot = plain.covariance(k, k) < HALF * unknowns.prior(k).powi(2);
            let reason = if determined {
                if sigma_relative < 0.7 * sigma && desk.is_indexed {
                    "relative to the spindle ball's place along the spindle: no index shows it; measure the gauge length"
                        .to_string()
                } else if sigma_relative < 0.7 * sigma {
                    "relative to the spindle ball, whose own placement is the floor of absolute positions".to_string()
                } else {
                    String::new()
                }
            } else {
                reason(desk, &loose_pivot, k, *axis, blocks, by_pivot)
            };
            ErrorForecast {
                name: name.to_string(),
                is_angle: *component >= 3,
                determined,
                visible: determined || desk.visible[k],
                sigma,
                sigma_relative,
                prior_share: fitted[k].prior_share,
                reason,
            }
        })
        .collect()
}

/// Setups of each axis that stand for all when it is asked what lengths can show.
const SAMPLE: usize = 16;

/// For each wanted error: reachable setups, clear or not, would fix it with pivots and bars unknown.
pub(super) fn visible(desk: &Desk) -> Vec<bool> {
    let mut knowledge = Knowledge::before_with_loose_setups(&desk.unknowns.with_exact_linear_axes());
    for axis in 0..desk.machine.axes.len() {
        let mine: Vec<_> = desk.all.list.iter().filter(|candidate| candidate.axis == axis).collect();
        let step = mine.len().div_ceil(SAMPLE).max(1);
        mine.iter().step_by(step).for_each(|candidate| knowledge.add(&desk.entry(candidate, None).block));
    }
    (0..desk.unknowns.wanted).map(|k| knowledge.prior_share(k) < HALF).collect()
}

fn reason(desk: &Desk, plain: &Knowledge, k: usize, axis: usize, blocks: &[&Block], by_pivot: bool) -> String {
    let unknowns = &desk.unknowns;
    let name = &desk.machine.axes[axis].name;
    if desk.machine.axes[axis].kind == AxisKind::Linear {
        return format!("no circle or other test that is reachable and clear tells how square {name} is");
    }
    if !desk.all.list.iter().any(|candidate| candidate.axis == axis)
        && let Some(why) = no_test(desk, axis)
    {
        return why;
    }
    let together: Vec<String> = (0..unknowns.wanted)
        .filter(|&other| other != k)
        .filter(|&other| {
            let r = plain.covariance(k, other) / (plain.covariance(k, k) * plain.covariance(other, other)).sqrt();
            r.abs() > TOGETHER
        })
        .map(|other| unknowns.errors[other].2.to_string())
        .collect();
    if !together.is_empty() && !blocks.is_empty() {
        let shared = if by_pivot { " and the pivot's place" } else { "" };
        return format!(
            "only together with {}{shared}: what moves both alike changes no ball-bar length",
            together.join(", ")
        );
    }
    if by_pivot {
        return "only through how well the pivot's place is known: what moves the whole branch changes no ball-bar length".into();
    }
    no_test(desk, axis).unwrap_or_else(|| format!("no chosen test of axis {name} sees it at a useful lever"))
}

/// By axis: how often a pair stood in the way.
type Pairs = BTreeMap<usize, HashMap<(String, String), usize>>;

/// Why no test of an axis exists, if none does.
fn no_test(desk: &Desk, axis: usize) -> Option<String> {
    let machine = desk.machine;
    let name = &machine.axes[axis].name;
    if desk.bodies.mounts.is_empty() || desk.all.places.is_empty() {
        return Some("the machine file names no mounting surface or no spindle: add 'mounts' and 'spindle'".into());
    }
    let reachable = desk.all.list.iter().filter(|candidate| candidate.axis == axis).count();
    if reachable > 0 {
        let nothing = HashMap::new();
        let of = |pairs: &Pairs| -> HashMap<(String, String), usize> { pairs.get(&axis).unwrap_or(&nothing).clone() };
        let (sweeps, ways) = (of(&desk.forbidden), of(&desk.blocked_ways));
        let refused: usize = sweeps.values().chain(ways.values()).sum();
        if refused == 0 || refused < reachable.min(MAX_FAILURES) / 2 {
            return None;
        }
        let most = |pairs: &HashMap<(String, String), usize>| -> Option<String> {
            let (pair, count) = pairs.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)))?;
            Some(format!("most often {} – {} ({count} setups)", pair.0, pair.1))
        };
        let margin = desk.settings.margin_mm;
        let sweeps = most(&sweeps)
            .map(|most| format!("no setup of axis {name} stays {margin} mm clear over a useful sweep: {most}"));
        let ways = most(&ways).map(|most| {
            format!("where the sweep of {name} is clear, no way from a park position to its start is: {most}")
        });
        return Some([sweeps, ways].into_iter().flatten().collect::<Vec<_>>().join("; "));
    }
    let misses = desk.all.misses.get(&axis)?;
    if let Some((limit, (at, beyond))) = misses.limits.iter().min_by(|a, b| a.1.1.total_cmp(&b.1.1)) {
        return Some(format!(
            "limits leave no setup of axis {name}: the nearest one needs {} = {at:.1} mm, {beyond:.1} mm beyond its range",
            machine.axes[*limit].name
        ));
    }
    if let Some(by) = misses.bar_short_mm {
        return Some(format!("no bar of the kit reaches for axis {name}: the longest is {by:.1} mm too short"));
    }
    if misses.tried == 0 {
        return Some(format!("no mounting surface lets a ball be carried by axis {name} at a lever"));
    }
    Some(format!("the linear axes cannot bring the balls onto the line of axis {name}"))
}

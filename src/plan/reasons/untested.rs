//! Which limit leaves an axis without a test, by how much, and what to do about it. It chooses nothing.

use std::collections::{BTreeMap, HashMap};

use crate::machine::AxisKind;
use crate::plan::context::evaluation::{Evaluation, MAX_FAILURES};
use crate::plan::places::free_range::{sweep_wanted, widest};
use crate::plan::places::run_in::{OFF_LIMIT, RUN_IN, shortest_deg};

/// By axis: how often a pair stood in the way.
type Pairs = BTreeMap<usize, HashMap<(String, String), usize>>;

/// Free sweeps narrower than this are named when something else shortens them further, deg.
const NARROW_DEG: f64 = 120.0;

/// Why no test of an axis exists, if none does.
pub(crate) fn untested(evaluation: &Evaluation, axis: usize) -> Option<String> {
    let machine = evaluation.context.machine;
    let name = &machine.axes[axis].name;
    if evaluation.context.bodies.mounts.is_empty() || evaluation.context.all.places.is_empty() {
        return Some("the machine file names no mounting surface or no spindle: add 'mounts' and 'spindle'".into());
    }
    if machine.axes[axis].kind == AxisKind::Rotary
        && sweep_wanted(machine, axis, &evaluation.context.settings.avoid).is_none()
    {
        return Some(too_narrow(evaluation, axis));
    }
    let reachable = evaluation.context.all.list.iter().filter(|candidate| candidate.axis == axis).count();
    if reachable > 0 {
        return in_the_way(evaluation, axis, reachable);
    }
    let misses = evaluation.context.all.misses.get(&axis)?;
    if let Some((region_of, count)) = misses.avoided.iter().max_by_key(|(_, count)| **count) {
        return Some(format!(
            "--avoid leaves no setup of axis {name}: {count} reachable ones have {} in a region kept out of use ({}); narrow it",
            machine.axes[*region_of].name,
            regions(evaluation, *region_of)
        ));
    }
    if let Some((limit, (at, beyond))) = misses.limits.iter().min_by(|a, b| a.1.1.total_cmp(&b.1.1)) {
        return Some(format!(
            "limits leave no setup of axis {name} from the places tried: the nearest one needs {} = {at:.1} mm, {beyond:.1} mm beyond its range",
            machine.axes[*limit].name
        ));
    }
    if let Some(by) = misses.all_too_short_mm() {
        return Some(format!(
            "no bar of the kit reaches for axis {name} from the places tried: the longest is {by:.1} mm too short"
        ));
    }
    if misses.tried == 0 {
        return Some(format!("no mounting surface lets a ball be carried by axis {name} at a lever"));
    }
    Some(format!("the linear axes cannot bring the balls onto the line of axis {name} from the places tried"))
}

/// The range, or what is left of it, is too narrow for any capture arc.
fn too_narrow(evaluation: &Evaluation, axis: usize) -> String {
    let machine = evaluation.context.machine;
    let name = &machine.axes[axis].name;
    let shortest = shortest_deg(machine, axis);
    let least = shortest + 2.0 * (RUN_IN + OFF_LIMIT);
    let needs = format!(
        "a test needs {least:.1}° ({shortest:.0}° of capture, {RUN_IN:.0}° of run-in at either end, {OFF_LIMIT}° off a limit)"
    );
    let degrees = |(low, high): (f64, f64)| format!("{}…{}°", tidy(low.to_degrees()), tidy(high.to_degrees()));
    let in_range = machine.axes[axis].range.map_or(f64::INFINITY, |(low, high)| (high - low).to_degrees());
    match (machine.axes[axis].range, widest(machine, axis, &evaluation.context.settings.avoid)) {
        (Some(range), _) if in_range < least => format!(
            "the range of axis {name}, {}, is {:.1}° too narrow for a sweep: {needs}; widen it in the machine file if the machine can",
            degrees(range),
            least - in_range
        ),
        (_, Some(left)) => format!(
            "--avoid {} leaves axis {name} at most {}, {:.1}° too narrow for a sweep: {needs}; narrow the region",
            regions(evaluation, axis),
            degrees(left),
            shortest + 2.0 * RUN_IN - (left.1 - left.0).to_degrees()
        ),
        (_, None) => {
            format!(
                "--avoid {} leaves nothing of the range of axis {name}; narrow the region",
                regions(evaluation, axis)
            )
        }
    }
}

/// What forbids the sweeps of reachable setups, or the ways to their starts.
fn in_the_way(evaluation: &Evaluation, axis: usize, reachable: usize) -> Option<String> {
    let name = &evaluation.context.machine.axes[axis].name;
    if evaluation
        .context
        .all
        .list
        .iter()
        .any(|candidate| candidate.axis == axis && evaluation.is_known_clear(candidate))
    {
        return None;
    }
    let (sweeps, ways) = (refused(&evaluation.forbidden, axis), refused(&evaluation.blocked_ways, axis));
    let count: usize = sweeps.values().chain(ways.values()).sum();
    if count == 0 || count < reachable.min(MAX_FAILURES) / 2 {
        return None;
    }
    let margin = evaluation.context.settings.margin_mm;
    let free_deg = match evaluation.context.machine.axes[axis].kind {
        AxisKind::Rotary => widest(evaluation.context.machine, axis, &evaluation.context.settings.avoid)
            .map(|(low, high)| (high - low).to_degrees()),
        AxisKind::Linear => None,
    };
    let of_what = match free_deg.filter(|deg| *deg < NARROW_DEG) {
        Some(deg) => format!(
            " of {:.0}° in the {deg:.0}° that range and --avoid leave",
            shortest_deg(evaluation.context.machine, axis)
        ),
        None => String::new(),
    };
    // a search gives up what proves hopeless: the rest was not looked at
    let of_how_many = if count < reachable {
        format!("none of {count} setups looked at, of {reachable} reachable ones,")
    } else {
        "no reachable setup tried".into()
    };
    let sweeps = most_often(&sweeps).map(|most| {
        format!("{of_how_many} of axis {name} stays {margin} mm clear over a useful sweep{of_what}: {most}")
    });
    let ways = most_often(&ways)
        .map(|most| format!("where the sweep of {name} is clear, no way from a park position to its start is: {most}"));
    Some([sweeps, ways].into_iter().flatten().collect::<Vec<_>>().join("; "))
}

/// How often which pair refused setups of an axis.
fn refused(pairs: &Pairs, axis: usize) -> HashMap<(String, String), usize> {
    pairs.get(&axis).cloned().unwrap_or_default()
}

/// The pair that refused most setups.
fn most_often(pairs: &HashMap<(String, String), usize>) -> Option<String> {
    let (pair, count) = pairs.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)))?;
    Some(format!("most often {} – {} ({count} setups)", pair.0, pair.1))
}

/// The pair that refused most sweeps of an axis, or most ways to them.
pub(crate) fn most_in_the_way(evaluation: &Evaluation, axis: usize) -> Option<String> {
    most_often(&refused(&evaluation.forbidden, axis)).or_else(|| most_often(&refused(&evaluation.blocked_ways, axis)))
}

/// Avoided regions of an axis as written: `A=-10..120`.
fn regions(evaluation: &Evaluation, axis: usize) -> String {
    let entry = &evaluation.context.machine.axes[axis];
    let of_axis = evaluation.context.settings.avoid.iter().filter(|(other, ..)| *other == axis);
    let words = of_axis.map(|&(_, from, to)| {
        format!("{}={}..{}", entry.name, tidy(entry.kind.to_file_unit(from)), tidy(entry.kind.to_file_unit(to)))
    });
    words.collect::<Vec<_>>().join(" ")
}

/// To a thousandth, without zeros at the end.
fn tidy(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}

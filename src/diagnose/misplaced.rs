//! Sessions with one statement about the set-up put right by what the lengths say: a ball's place or link, a standing axis, a bar, an axis line.

use nalgebra::Vector3;

use super::data_fault::{SESSION, listed};
use super::mistakes::{OFTEN, RARELY, SOMETIMES, Suspicion, is_repeat};
use super::places::{End, Sights, misfit_mm, sights, solutions, solved, written_otherwise};
use crate::chain::{Chain, Geometry};
use crate::identify::{self, FreePrior, Quantity};
use crate::machine::AxisKind;
use crate::session::{Ball, Motion, Session, Setups};

/// Effect names of wrong set-ups.
pub(super) const BALL_PLACE: &str = "ball-place";
const BALL_LINK: &str = "ball-link";
const STANDING_AXIS: &str = "standing-axis";
const BAR: &str = "bar-other";
pub(super) const AXIS_LINE: &str = "axis-line";

/// A place is told to be written otherwise where the lengths put the ball so near to that, mm.
const NEAR_MM: f64 = 1.0;

/// Share of a misfit by the nominal machine that putting a statement right must take off, to be worth a refit.
const WORTH: f64 = 0.5;

/// All statements that may be wrong, put right; `values` are those of a fit of the session as it is.
pub(super) fn misplaced(session: &Session, values: &[f64]) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let mut list = Vec::new();
    for (end, of) in [(End::Pivot, &setups.pivot_of), (End::Spindle, &setups.spindle_ball_of)] {
        let count = of.iter().copied().max().map_or(0, |most| most + 1);
        for setup in 0..count {
            let tests: Vec<usize> = (0..of.len()).filter(|&test| of[test] == setup).collect();
            list.extend(elsewhere(session, &chain, end, &tests));
            list.extend(on_other_links(session, &chain, end, &tests));
        }
        if count > 1 {
            list.extend(all_moved(session, &chain, end));
        }
    }
    list.extend(standing_elsewhere(session, &chain));
    list.extend(other_bars(session, &chain, &setups));
    list.extend(other_lines(session, &setups, values));
    list
}

fn suspicion(effect: &'static str, place: &str, tests: Vec<String>, says: String, undone: Session) -> Suspicion {
    let (place, components) = (place.to_string(), Vec::new());
    Suspicion { effect, place, components, tests, says, shift_ms: None, weight: SOMETIMES, undone }
}

fn names(session: &Session, tests: &[usize]) -> Vec<String> {
    tests.iter().map(|&test| session.tests[test].name.clone()).collect()
}

/// A place to a tenth of a millimetre, or finer where it differs from the stated one by less.
fn told(place: &Vector3<f64>, stated: &Vector3<f64>) -> String {
    let decimals = if (place - stated).norm() < 1.0 { 2 } else { 1 };
    let shown = |value: f64| {
        let text = format!("{value:.decimals$}");
        if text.trim_start_matches('-').chars().all(|c| "0.".contains(c)) { "0".to_string() } else { text }
    };
    format!("({}, {}, {})", shown(place.x), shown(place.y), shown(place.z))
}

fn ball_words(end: End, ball: &Ball) -> String {
    let name = if end == End::Pivot { "pivot" } else { "spindle ball" };
    format!("{name} on {} at ({}, {}, {})", ball.link, ball.at.x, ball.at.y, ball.at.z)
}

/// One ball where the lengths put it.
fn elsewhere(session: &Session, chain: &Chain, end: End, tests: &[usize]) -> Vec<Suspicion> {
    let Some(ball) = tests.first().map(|&test| end.of(&session.tests[test])) else { return Vec::new() };
    let all: Sights =
        tests.iter().flat_map(|&test| sights(session, chain, &session.tests[test], end, &ball.link)).collect();
    let stated = ball.at;
    let otherwise = written_otherwise(&stated);
    solutions(&all, &stated)
        .into_iter()
        .map(|(found, _)| {
            let mut undone = session.clone();
            tests.iter().for_each(|&test| end.of_mut(&mut undone.tests[test]).at = found);
            let near = otherwise.iter().skip(1).find(|(place, _)| (place - found).norm() < NEAR_MM);
            let place = near.map_or_else(|| told(&found, &stated), |(place, _)| told(place, &stated));
            let how = near.filter(|(_, words)| !words.is_empty()).map(|(_, words)| format!(": {words}"));
            let says = format!(
                "the {} stands at about {place} by the lengths, {:.1} mm from there{}; correct its 'at' in {}",
                ball_words(end, ball),
                (found - stated).norm(),
                how.unwrap_or_default(),
                listed(&names(session, tests))
            );
            let mut suspicion = suspicion(BALL_PLACE, end.place(), names(session, tests), says, undone);
            suspicion.weight = match near {
                Some((_, words)) if words.contains("exchanged") && words.contains("turned") => RARELY,
                Some(_) => OFTEN,
                // the nearer of two places that fit alike is the likelier one
                None => SOMETIMES * NEARBY_MM / (NEARBY_MM + (found - stated).norm()),
            };
            suspicion
        })
        .collect()
}

/// Distance over which a place of no special form becomes half as likely, mm.
const NEARBY_MM: f64 = 10.0;

/// One ball on another link, where that explains its lengths better.
fn on_other_links(session: &Session, chain: &Chain, end: End, tests: &[usize]) -> Vec<Suspicion> {
    let Some(ball) = tests.first().map(|&test| end.of(&session.tests[test])) else { return Vec::new() };
    let miss_on = |link: &str| {
        let seen: Sights =
            tests.iter().flat_map(|&test| sights(session, chain, &session.tests[test], end, link)).collect();
        misfit_mm(&seen, &ball.at)
    };
    let as_stated = miss_on(&ball.link);
    let own = chain.link(&ball.link);
    let others = chain.links().into_iter().filter(|(_, link)| Some(*link) != own).map(|(name, _)| name);
    others.filter(|link| miss_on(link) < WORTH * as_stated).map(|link| on_link(session, end, tests, link)).collect()
}

fn on_link(session: &Session, end: End, tests: &[usize], link: &str) -> Suspicion {
    let mut undone = session.clone();
    tests.iter().for_each(|&test| end.of_mut(&mut undone.tests[test]).link = link.to_string());
    let ball = end.of(&session.tests[tests[0]]);
    let says = format!(
        "the {} is carried by {link} by the lengths; correct its 'link' in {}",
        ball_words(end, ball),
        listed(&names(session, tests))
    );
    suspicion(BALL_LINK, end.place(), names(session, tests), says, undone)
}

/// All pivots that are stated on one link on another one of its branch: about a turning axis the lengths hardly tell.
pub(super) fn on_any_link(session: &Session) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let mut stated: Vec<&str> = session.tests.iter().map(|test| test.pivot.link.as_str()).collect();
    stated.sort_unstable();
    stated.dedup();
    let mut list = Vec::new();
    for own in stated {
        let tests: Vec<usize> =
            (0..session.tests.len()).filter(|&test| session.tests[test].pivot.link == own).collect();
        let Some(at) = chain.link(own) else { continue };
        let others = chain.links().into_iter().filter(|(_, link)| *link != at && link.branch == at.branch);
        list.extend(others.map(|(link, _)| on_link(session, End::Pivot, &tests, link)));
    }
    list
}

/// Shifts from which a common one is looked for, mm.
const COMMON_MM: [f64; 5] = [-100.0, -30.0, 0.0, 30.0, 100.0];

/// All balls of an end shifted alike: a height forgotten, a zero taken elsewhere, a gauge length.
fn all_moved(session: &Session, chain: &Chain, end: End) -> Vec<Suspicion> {
    let mut all: Sights = Vec::new();
    for test in &session.tests {
        let ball = end.of(test);
        // relative to the stated place, so that the shift is what is solved for
        let own = sights(session, chain, test, end, &ball.link).into_iter();
        all.extend(own.map(|(seen, length)| (seen - ball.at, length)));
    }
    let starts = (0..3)
        .flat_map(|axis| COMMON_MM.iter().map(move |&mm| Vector3::from_fn(|k, _| if k == axis { mm } else { 0.0 })));
    let best = starts.map(|start| solved(&all, start)).min_by(|a, b| a.1.total_cmp(&b.1));
    let worth = WORTH * misfit_mm(&all, &Vector3::zeros());
    let found = best.filter(|(_, misfit)| *misfit < worth);
    found
        .map(|(shift, _)| {
            let mut undone = session.clone();
            undone.tests.iter_mut().for_each(|test| end.of_mut(test).at += shift);
            let (which, why) = match end {
                End::Pivot => ("pivots stand", "the height above the table, or the zero from which they were counted"),
                End::Spindle => ("spindle balls stand", "the gauge length, or the zero of the linear axes"),
            };
            let says = format!(
                "all {which} by {} mm from where the session puts them: look at {why}, and correct every 'at'",
                told(&shift, &Vector3::zeros())
            );
            suspicion(BALL_PLACE, end.place(), Vec::new(), says, undone)
        })
        .into_iter()
        .collect()
}

/// Shifts of a standing axis that are tried first, mm or degrees.
const SHIFT_GRID: i32 = 40;
const GRID_MM: f64 = 5.0;
const GRID_DEG: f64 = 4.5;

/// Halvings of the grid's step, down to some µm.
const HALVINGS: usize = 22;

/// Rows of a test that tell where an axis stood.
const FEW: usize = 12;

/// Axes that stood elsewhere than stated, in the repeats of one test or wherever they stood alike.
fn standing_elsewhere(session: &Session, chain: &Chain) -> Vec<Suspicion> {
    let mut list = Vec::new();
    for axis in 0..session.machine.axes.len() {
        let standing = |test: usize| {
            let moves = session.tests[test].recording.as_ref().is_none_or(|recording| recording.axes.contains(&axis));
            session.tests[test].positions[axis].filter(|_| !moves)
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for first in 0..session.tests.len() {
            let Some(value) = standing(first) else { continue };
            let repeats = (0..session.tests.len()).filter(|&test| standing(test).is_some());
            let alike: Vec<usize> = repeats.clone().filter(|&test| standing(test) == Some(value)).collect();
            let repeats: Vec<usize> = repeats.filter(|&test| is_repeat(session, first, test)).collect();
            for group in [repeats, alike] {
                if group.first() == Some(&first) && !groups.contains(&group) {
                    groups.push(group);
                }
            }
        }
        list.extend(groups.iter().filter_map(|tests| stood_elsewhere(session, chain, axis, tests)));
    }
    list
}

fn stood_elsewhere(session: &Session, chain: &Chain, axis: usize, tests: &[usize]) -> Option<Suspicion> {
    let geometry = Geometry::nominal(chain);
    let kind = session.machine.axes[axis].kind;
    let mut rows: Vec<(usize, Vec<f64>, f64)> = Vec::new();
    for &index in tests {
        let test = &session.tests[index];
        let motion = Motion::of(session, chain, test).ok()?;
        let lengths = &test.recording.as_ref()?.length_mm;
        for row in (0..lengths.len()).step_by((lengths.len() / FEW).max(1)).filter(|&row| lengths[row].is_finite()) {
            rows.push((index, motion.row(row).to_vec(), lengths[row] - test.bar_error_mm));
        }
    }
    let links: Vec<_> = session.tests.iter().map(|test| test.links(chain).ok()).collect();
    let miss = |shift: f64| -> f64 {
        let one = |(index, at, length): &(usize, Vec<f64>, f64)| {
            let Some(links) = links[*index] else { return 0.0 };
            let mut at = at.clone();
            at[axis] += shift;
            let test = &session.tests[*index];
            let pivot = geometry.point(links.0, &test.pivot.at, &at, None);
            let spindle = geometry.point(links.1, &test.spindle_ball.at, &at, None);
            (length - (pivot - spindle).norm()).powi(2)
        };
        (rows.iter().map(one).sum::<f64>() / rows.len().max(1) as f64).sqrt()
    };
    let step = match kind {
        AxisKind::Linear => GRID_MM,
        AxisKind::Rotary => GRID_DEG.to_radians(),
    };
    let grid = (-SHIFT_GRID..=SHIFT_GRID).map(|k| f64::from(k) * step);
    let (mut best, mut least) = grid.map(|shift| (shift, miss(shift))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut width = step;
    for _ in 0..HALVINGS {
        width *= 0.5;
        for shift in [best - width, best + width] {
            let next = miss(shift);
            if next < least {
                (best, least) = (shift, next);
            }
        }
    }
    if least >= WORTH * miss(0.0) {
        return None;
    }
    let axis_name = &session.machine.axes[axis].name;
    let stated = session.tests[*tests.first()?].positions[axis]?;
    let mut undone = session.clone();
    tests.iter().for_each(|&test| undone.tests[test].positions[axis] = Some(stated + best));
    let says = format!(
        "{axis_name} stood at about {:.2} {} by the lengths and not at {}; correct 'positions' in {}",
        kind.to_file_unit(stated + best),
        kind.position_unit(),
        kind.to_file_unit(stated),
        listed(&names(session, tests))
    );
    let mut found = suspicion(STANDING_AXIS, SESSION, names(session, tests), says, undone);
    found.components = vec![axis_name.clone()];
    Some(found)
}

/// Bars whose readings are all too long or too short.
fn other_bars(session: &Session, chain: &Chain, setups: &Setups) -> Vec<Suspicion> {
    let mut list = Vec::new();
    for bar in 0..setups.bars.len() {
        let tests: Vec<usize> = (0..session.tests.len()).filter(|&test| setups.bar_of[test] == Some(bar)).collect();
        let mut off: Vec<f64> = Vec::new();
        for &index in &tests {
            let test = &session.tests[index];
            let seen = sights(session, chain, test, End::Pivot, &test.pivot.link).into_iter();
            off.extend(seen.map(|(seen, length)| length - (test.pivot.at - seen).norm()));
        }
        off.sort_by(f64::total_cmp);
        let Some(&middle) = off.get(off.len() / 2) else { continue };
        let mut undone = session.clone();
        tests.iter().for_each(|&test| undone.tests[test].bar_error_mm += middle);
        let says = format!(
            "readings of the {} are {:.3} mm too {}: another bar was used, or its calibrated length is another; correct 'bar_length' and the lengths made with it, or state 'bar_error'",
            setups.bars[bar].label,
            middle.abs(),
            if middle > 0.0 { "long" } else { "short" }
        );
        list.push(suspicion(BAR, "bar", names(session, &tests), says, undone));
    }
    list
}

/// A line so far from where the machine file puts it is tried there, mm.
const OTHER_LINE_MM: f64 = 1.0;

/// Rotary axes whose lines a fit puts elsewhere.
fn other_lines(session: &Session, setups: &Setups, values: &[f64]) -> Vec<Suspicion> {
    let machine = &session.machine;
    let free = identify::default_free(machine);
    let unknowns = identify::unknowns(session, setups, &free, FreePrior::of(machine));
    let shift_of = |axis: usize| {
        let mut shift = Vector3::zeros();
        for (unknown, value) in unknowns.iter().zip(values) {
            match unknown.quantity {
                Quantity::Location { axis: other, component } if other == axis && component.index() < 3 => {
                    shift[component.index()] = *value;
                }
                _ => {}
            }
        }
        shift
    };
    (0..machine.axes.len())
        .filter(|&axis| machine.axes[axis].kind == AxisKind::Rotary)
        .map(|axis| (axis, shift_of(axis)))
        .filter(|(_, shift)| shift.norm() > OTHER_LINE_MM)
        .map(|(axis, shift)| {
            let mut undone = session.clone();
            undone.machine.axes[axis].origin += shift;
            let name = &machine.axes[axis].name;
            let says = format!(
                "the line of {name} lies {} mm from where the machine file puts it: correct 'origin' of {name} to {}",
                told(&shift, &Vector3::zeros()),
                told(&(machine.axes[axis].origin + shift), &machine.axes[axis].origin)
            );
            let mut found = suspicion(AXIS_LINE, name, Vec::new(), says, undone);
            found.components = vec![name.clone()];
            found.weight = RARELY;
            found
        })
        .collect()
}

//! Sessions with one statement about balls and bars put right by what the lengths say: a place, a link, a length. Axes are for `standing` and `axis_lines`.

use nalgebra::Vector3;

use super::ball_places::{
    End, Sights, WORTH, misfit_mm, move_ball, placement, sights, solutions, solved, written_otherwise,
};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::listed;
use crate::diagnose::preflight::quick_fit::refit;
use crate::diagnose::preflight::suspicion::{Detail, OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::session::{Ball, Session, Setups, Zero};
use crate::statistics::median;

/// A place is told to be written otherwise where the lengths put the ball so near to that, mm, and as a share of its way there.
const NEAR_MM: f64 = 1.0;
const NEAR_SHARE: f64 = 0.1;

/// All statements about balls and bars that may be wrong, put right.
pub(crate) fn misplaced(session: &Session) -> Vec<Suspicion> {
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
    list.extend(other_bars(session, &chain, &setups));
    list
}

/// Names of tests.
pub(crate) fn names(session: &Session, tests: &[usize]) -> Vec<String> {
    tests.iter().map(|&test| session.tests[test].name.clone()).collect()
}

/// A place to a tenth of a millimetre, or finer where it differs from the stated one by less.
pub(crate) fn told(place: &Vector3<f64>, stated: &Vector3<f64>) -> String {
    let decimals = if (place - stated).norm() < 1.0 { 2 } else { 1 };
    let shown = |value: f64| {
        let text = format!("{value:.decimals$}");
        if text.trim_start_matches('-').chars().all(|c| "0.".contains(c)) { "0".to_string() } else { text }
    };
    format!("({}, {}, {})", shown(place.x), shown(place.y), shown(place.z))
}

/// A place as [`told`] rounds it.
pub(crate) fn told_sizes(place: &Vector3<f64>, stated: &Vector3<f64>) -> Detail {
    Detail::sizes(place.as_slice(), if (place - stated).norm() < 1.0 { 0.01 } else { 0.1 })
}

/// A ball as the session states it.
pub(crate) fn ball_words(end: End, ball: &Ball) -> String {
    let name = end.words();
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
            let near_mm = NEAR_MM.min(NEAR_SHARE * (found - stated).norm());
            let near = otherwise.iter().skip(1).find(|(place, _)| (place - found).norm() < near_mm);
            let place = near.map_or_else(|| told(&found, &stated), |(place, _)| told(place, &stated));
            let how = near.filter(|(_, words)| !words.is_empty()).map(|(_, words)| format!(": {words}"));
            let says = format!(
                "the {} stands at about {place} by the lengths, {:.1} mm from there{}; correct its 'at' in {}",
                ball_words(end, ball),
                (found - stated).norm(),
                how.unwrap_or_default(),
                listed(&names(session, tests))
            );
            let mut suspicion = Suspicion::new(FaultKind::BallPlace, end.place(), names(session, tests), says, undone);
            let shown = near.map_or(found, |(place, _)| *place);
            suspicion.detail = told_sizes(&shown, &stated).and_size((found - stated).norm(), 0.1);
            suspicion.is_found = near.is_none();
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

/// Balls a little beside their places, where a fit with a wide spread puts each of them: too little for the lengths alone to tell.
pub(crate) fn nearby(session: &Session) -> Vec<Suspicion> {
    let setups = Setups::of(session);
    let mut list = Vec::new();
    for (end, of) in [(End::Pivot, &setups.pivot_of), (End::Spindle, &setups.spindle_ball_of)] {
        for setup in 0..of.iter().copied().max().map_or(0, |most| most + 1) {
            let tests: Vec<usize> = (0..of.len()).filter(|&test| of[test] == setup).collect();
            list.extend(beside(session, end, setup, &tests));
        }
    }
    list
}

impl Suspicion {
    /// Whether another one puts the same ball nearly where this does.
    pub(crate) fn puts_a_ball_as(&self, other: &Suspicion) -> bool {
        let is_alike = (self.kind, &self.place, &self.tests) == (other.kind, &other.place, &other.tests);
        let places = |one: &Suspicion| -> Vec<Vector3<f64>> {
            let of = if one.place == End::Pivot.place() { End::Pivot } else { End::Spindle };
            one.undone.tests.iter().map(|test| of.of(test).at).collect()
        };
        self.kind == FaultKind::BallPlace
            && is_alike
            && places(self).iter().zip(places(other)).all(|(one, other)| (one - other).norm() < NEAR_MM)
    }
}

/// Spread with which a ball is looked for beside its place, mm.
const BESIDE_MM: f64 = 3.0;

fn beside(session: &Session, end: End, setup: usize, tests: &[usize]) -> Option<Suspicion> {
    let mut released = session.clone();
    tests.iter().for_each(|&test| end.of_mut(&mut released.tests[test]).spread_mm = Some(BESIDE_MM));
    let placement = placement(&refit(&released, None)?, end, setup);
    let mut undone = session.clone();
    tests.iter().for_each(|&test| move_ball(end.of_mut(&mut undone.tests[test]), &placement));
    let first = *tests.first()?;
    let (ball, found) = (end.of(&session.tests[first]), end.of(&undone.tests[first]));
    let says = format!(
        "the {} stands at about {} by the lengths, {:.2} mm from there; correct its 'at' in {}",
        ball_words(end, ball),
        told(&found.at, &ball.at),
        placement.norm(),
        listed(&names(session, tests))
    );
    Some(Suspicion {
        detail: told_sizes(&found.at, &ball.at).and_size(placement.norm(), 0.01),
        is_found: true,
        ..Suspicion::new(FaultKind::BallPlace, end.place(), names(session, tests), says, undone)
    })
}

/// Distance over which a place of no special form becomes half as likely, mm.
pub(crate) const NEARBY_MM: f64 = 10.0;

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
    let found = Suspicion::new(FaultKind::BallLink, end.place(), names(session, tests), says, undone);
    Suspicion { detail: Detail::Link(link.to_string()), ..found }
}

/// All pivots that are stated on one link on another one of its branch: about a turning axis the lengths hardly tell.
pub(crate) fn on_any_link(session: &Session) -> Vec<Suspicion> {
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
            let found = Suspicion::new(FaultKind::BallPlace, end.place(), Vec::new(), says, undone);
            Suspicion { detail: told_sizes(&shift, &Vector3::zeros()), ..found }
        })
        .into_iter()
        .collect()
}

/// Bars whose readings are all too long or too short.
fn other_bars(session: &Session, chain: &Chain, setups: &Setups) -> Vec<Suspicion> {
    let mut list = Vec::new();
    for bar in (0..setups.bars.len()).filter(|&bar| setups.bars[bar].zero == Zero::Calibrated) {
        let tests: Vec<usize> = (0..session.tests.len()).filter(|&test| setups.bar_of[test] == Some(bar)).collect();
        let mut off: Vec<f64> = Vec::new();
        for &index in &tests {
            let test = &session.tests[index];
            let seen = sights(session, chain, test, End::Pivot, &test.pivot.link).into_iter();
            off.extend(seen.map(|(seen, length)| length - (test.pivot.at - seen).norm()));
        }
        let Some(middle) = median(off.into_iter()) else { continue };
        let mut undone = session.clone();
        tests.iter().for_each(|&test| undone.tests[test].bar_error_mm += middle);
        let says = format!(
            "readings of the {} are {:.3} mm too {}: another bar was used, or its calibrated length is another; correct 'bar_length' and the lengths made with it, or state 'bar_error'",
            setups.bars[bar].label,
            middle.abs(),
            if middle > 0.0 { "long" } else { "short" }
        );
        list.push(Suspicion::new(FaultKind::BarOther, "bar", names(session, &tests), says, undone));
    }
    list
}

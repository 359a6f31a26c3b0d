//! Sessions with one mistake of the files undone: a sign, two names, a unit, an order, a clock. Which mistake was made is for others to judge.

use super::axis_columns::{columns_of_some, of_an_axis, senses_together, swapped};
use super::dwells::{other_rows, without_dwells};
use super::late_clock::shifted;
use super::places::axis_order::other_orders;
use super::places::exchanged;
use super::places::foreign::foreign;
use super::places::misplaced::on_any_link;
use super::places::standing::{a_little_elsewhere, columns_off, slides_off, stood_still};
use super::places::sweeps::other_arcs;
use super::quick_fit::Refit;
use super::readings::figures::Linearised;
use super::readings::order::out_of_order;
use super::readings::processed::own_zeros;
use super::readings::scaled::{scaled, scaled_by_any, zeroed};
use super::readings::steps::cut_off;
use super::readings::taken_off::taken_off;
use super::readings::unsigned::unsigned;
use super::suspicion::Suspicion;
use crate::session::{Session, Setups};
use crate::statistics::rms;

/// All mistakes that are tried on the thinned session; shifts in time are made on all rows, whose arcs are nearly straight.
pub(crate) fn suspicions(session: &Session, whole: &Session, as_it_is: &Refit) -> Vec<Suspicion> {
    let mut list = Vec::new();
    let worst = worst_tests(&as_it_is.residual_mm);
    let machine = &session.machine;
    let busy: Vec<usize> = (0..machine.axes.len())
        .filter(|&axis| {
            session.tests.iter().any(|test| test.recording.as_ref().is_some_and(|r| r.axes.contains(&axis)))
        })
        .collect();
    list.extend(busy.iter().flat_map(|&axis| of_an_axis((session, whole), axis)));
    list.extend(senses_together(session));
    for (index, &a) in busy.iter().enumerate() {
        for &b in &busy[index + 1..] {
            if machine.axes[a].kind == machine.axes[b].kind {
                list.push(swapped(session, a, b));
            }
        }
    }
    let every = [(0..session.tests.len()).collect::<Vec<usize>>()];
    // of tests alone only the worst ones are worth the refits
    let alone: Vec<Vec<usize>> = worst.iter().map(|&test| vec![test]).collect();
    let programs = worst_programs(session, &worst);
    let runs = there_and_back(session, &programs, &worst);
    for tests in &distinct([&every, &of_one_way(session, &every), &alone, &runs]) {
        list.extend(SHIFTS_S.iter().map(|seconds| shifted((session, whole), tests, *seconds)));
    }
    list.extend(alone.iter().flat_map(|test| columns_of_some(session, test)));
    list.extend(without_dwells(session, whole));
    list.extend(other_rows((session, whole), as_it_is, &worst));
    list.extend(on_any_link(session));
    list.extend(exchanged::with_worst(session, &worst));
    list.extend(exchanged::programs(session, &programs));
    list.extend(other_arcs(session));
    list.extend(other_orders(session));
    let alike = alike(session);
    let of_one_way = of_one_way(session, &alike);
    // of one recording alone a shift in time says as much
    list.extend(columns_off(session, &distinct([&programs, &of_one_way])));
    let of_bars = of_bars(session);
    list.extend(scaled(session, &distinct([&programs, &runs, &alone, &alike, &of_bars])));
    // a gauge taken down between the directions has another zero in one of them
    list.extend(zeroed(session, &distinct([&programs, &runs, &alone, &alike])));
    list.extend(distinct([&alone, &runs, &programs]).iter().flat_map(|tests| foreign(session, tests)));
    // where slides follow, the bar keeps its length whether anything moves or not: of one run among others that tells nothing
    let turns_alone = |test: &usize| session.tests[*test].recording.as_ref().is_some_and(|read| read.axes.len() == 1);
    let alone_in_run: Vec<Vec<usize>> = runs.iter().filter(|run| run.iter().all(turns_alone)).cloned().collect();
    list.extend(stood_still(session, &distinct([&alone, &alone_in_run, &programs])));
    list.extend(a_little_elsewhere(session, &worst, &runs));
    list.extend(own_zeros(session, whole));
    list.extend(cut_off(session, whole));
    if let Some(linearised) = Linearised::of(session, as_it_is) {
        list.extend(slides_off(session, &linearised, &distinct([&alone, &runs, &programs])));
        let groups = distinct([&alone, &runs, &programs, &alike, &of_one_way, &of_bars]);
        list.extend(scaled_by_any(session, &linearised, &groups));
        list.extend(out_of_order((session, whole), &linearised, &worst, &programs));
        list.extend(taken_off((session, whole), &linearised));
        list.extend(unsigned((session, whole), &linearised));
    }
    list.extend(of_one_conversion(session));
    list
}

/// Groups of tests, each once.
fn distinct<const N: usize>(of: [&[Vec<usize>]; N]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for group in of.into_iter().flatten() {
        if !groups.contains(group) {
            groups.push(group.clone());
        }
    }
    groups
}

/// Of groups of tests, those whose first axis goes one way, where there are several but not all.
fn of_one_way(session: &Session, groups: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let rises = |test: &usize| {
        let recording = session.tests[*test].recording.as_ref();
        let column = recording.and_then(|recording| recording.positions.first());
        column.is_some_and(|column| column.last() > column.first())
    };
    let ways = groups.iter().flat_map(|tests| {
        let (rising, falling): (Vec<usize>, Vec<usize>) = tests.iter().copied().partition(rises);
        [rising, falling]
    });
    ways.filter(|way| (2..session.tests.len()).contains(&way.len())).collect()
}

/// Recordings with the same columns come out of one conversion.
fn of_one_conversion(session: &Session) -> Vec<Suspicion> {
    alike(session).iter().flat_map(|tests| columns_of_some(session, tests)).collect()
}

/// Tests with the same columns, where there are several but not all.
fn alike(session: &Session) -> Vec<Vec<usize>> {
    let moving = |test: usize| session.tests[test].recording.as_ref().map(|recording| &recording.axes);
    let with = |first: usize| -> Vec<usize> {
        (0..session.tests.len()).filter(|&test| moving(test) == moving(first)).collect()
    };
    let is_part = |tests: &Vec<usize>| (2..session.tests.len()).contains(&tests.len());
    (0..session.tests.len())
        .map(|first| (first, with(first)))
        .filter(|(first, tests)| tests[0] == *first && is_part(tests))
        .map(|(_, tests)| tests)
        .collect()
}

/// Tests with the same bar, where there are several but not all.
fn of_bars(session: &Session) -> Vec<Vec<usize>> {
    let bar_of = Setups::of(session).bar_of;
    let bars = 0..bar_of.iter().flatten().max().map_or(0, |last| last + 1);
    let with = |bar: usize| (0..bar_of.len()).filter(|&test| bar_of[test] == Some(bar)).collect::<Vec<usize>>();
    bars.map(with).filter(|tests| (2..session.tests.len()).contains(&tests.len())).collect()
}

/// One run there and back of programs that were repeated, of the tests that fit worst: what a gauge records in one piece.
fn there_and_back(session: &Session, programs: &[Vec<usize>], worst: &[usize]) -> Vec<Vec<usize>> {
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for program in programs.iter().filter(|program| program.len() > 2) {
        let mut ways = of_one_way(session, std::slice::from_ref(program));
        let start = |test: &usize| session.tests[*test].started_at_s;
        ways.iter_mut().for_each(|way| way.sort_by(|one, other| start(one).total_cmp(&start(other))));
        let [rising, falling] = &ways[..] else { continue };
        let pairs = rising.iter().zip(falling).map(|(&one, &other)| vec![one.min(other), one.max(other)]);
        runs.extend(pairs.filter(|pair| pair.iter().any(|test| worst.contains(test))));
    }
    runs
}

/// The programs of the tests that fit worst: each with its other directions and repeats.
fn worst_programs(session: &Session, worst: &[usize]) -> Vec<Vec<usize>> {
    let mut programs: Vec<Vec<usize>> = Vec::new();
    for &test in worst {
        let repeats = exchanged::repeats(session, test);
        if !programs.contains(&repeats) {
            programs.push(repeats);
        }
    }
    programs
}

/// Shifts tried, s.
const SHIFTS_S: &[f64] =
    &[-3.0, -2.4, -1.9, -1.5, -1.2, -0.95, -0.75, -0.6, -0.45, 0.45, 0.6, 0.75, 0.95, 1.2, 1.5, 1.9, 2.4, 3.0];

/// Single tests tried for a shift.
const WORST_TESTS: usize = 3;

/// Tests with the largest residual in a common fit.
pub(crate) fn worst_tests(residual_mm: &[Vec<f64>]) -> Vec<usize> {
    let mut order: Vec<(usize, f64)> =
        residual_mm.iter().map(|residual| rms(residual.iter().copied())).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(WORST_TESTS).map(|(test, _)| test).collect()
}

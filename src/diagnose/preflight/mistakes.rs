//! Sessions with one mistake of the files undone: a sign, two names, a unit, an order, a clock. Which mistake was made is for others to judge.

use super::axis_columns::{columns_of_some, of_an_axis, senses_together, swapped};
use super::dwells::{other_rows, without_dwells};
use super::late_clock::{is_sampled_unevenly, rows_apart, shifted};
use super::places::axis_order::other_orders;
use super::places::exchanged;
use super::places::foreign::foreign;
use super::places::misplaced::on_any_link;
use super::places::remounted::mounted_anew;
use super::places::spreads::stated_too_small;
use super::places::standing::{a_little_elsewhere, columns_off, slides_off, stood_off, stood_still, touched_off_anew};
use super::places::sweeps::other_arcs;
use super::places::written_positions::positions_written_otherwise;
use super::quick_fit::{Refit, robust_rms_mm};
use super::readings::factors::scaled_in_some;
use super::readings::figures::Linearised;
use super::readings::order::out_of_order;
use super::readings::processed::own_zeros;
use super::readings::scaled::{per_100_mm, scaled, scaled_by_any, zeroed};
use super::readings::steps::cut_off;
use super::readings::taken_off::taken_off;
use super::readings::unsigned::unsigned;
use super::struck_together::{StruckTogether, all, distinct, of_two_programs};
use super::suspicion::Suspicion;
use crate::diagnose::model::decimate::Sampled;
use crate::statistics::rms;

/// All mistakes that are tried on the thinned session; shifts in time are made on all rows, whose arcs are nearly straight.
pub(crate) fn suspicions(sampled: Sampled<'_>, as_it_is: &Refit) -> Vec<Suspicion> {
    let session = sampled.few_rows;
    let mut list = Vec::new();
    let worst = worst_tests(&as_it_is.residual_mm);
    let machine = &session.machine;
    let busy: Vec<usize> = (0..machine.axes.len())
        .filter(|&axis| {
            session.tests.iter().any(|test| test.recording.as_ref().is_some_and(|r| r.axes.contains(&axis)))
        })
        .collect();
    list.extend(busy.iter().flat_map(|&axis| of_an_axis(sampled, axis)));
    list.extend(senses_together(session));
    for (index, &a) in busy.iter().enumerate() {
        for &b in &busy[index + 1..] {
            if machine.axes[a].kind == machine.axes[b].kind {
                list.push(swapped(session, a, b));
            }
        }
    }
    let groups = StruckTogether::of(session, &worst);
    let (pieces, StruckTogether { alone, runs, programs, conversions, bars, .. }) = (groups.pieces(), &groups);
    for tests in &distinct([&[all(session)], &groups.all_one_way, alone, runs]) {
        list.extend(SHIFTS_S.iter().map(|seconds| shifted(sampled, tests, *seconds)));
    }
    list.extend(alone.iter().chain(conversions).flat_map(|tests| columns_of_some(session, tests)));
    list.extend(without_dwells(sampled));
    list.extend(other_rows(sampled, as_it_is, &worst));
    list.extend(on_any_link(session));
    list.extend(exchanged::with_worst(session, &worst));
    list.extend(exchanged::programs(session, programs));
    list.extend(other_arcs(session));
    list.extend(other_orders(session));
    // of one recording alone a shift in time says as much
    list.extend(columns_off(session, &distinct([programs, &groups.conversions_one_way])));
    list.extend(scaled(session, &distinct([&pieces, conversions, bars])));
    // a gauge taken down between the directions has another zero in one of them
    list.extend(zeroed(session, &distinct([&pieces, conversions])));
    list.extend(
        pieces
            .iter()
            .chain(&of_two_programs(session, &worst_of(&as_it_is.residual_mm, PAIRED_TESTS)))
            .flat_map(|tests| foreign(session, tests)),
    );
    list.extend(stated_too_small(session));
    list.extend(stood_still(session, &groups));
    list.extend(a_little_elsewhere(session, &worst, runs));
    list.extend(mounted_anew(session, &groups.all_one_way));
    list.extend(positions_written_otherwise(session, programs));
    list.extend(own_zeros(sampled));
    list.extend(cut_off(sampled));
    if let Some(linearised) = Linearised::of(session, as_it_is) {
        list.extend(slides_off(session, &linearised, &pieces));
        list.extend(stood_off(session, &linearised));
        list.extend(touched_off_anew(session, &linearised));
        let of_any = distinct([&pieces, conversions, &groups.conversions_one_way, bars]);
        list.extend(per_100_mm(session));
        list.extend(scaled_by_any(session, &linearised, &of_any));
        let squares = linearised.squares(1e3 * robust_rms_mm(&as_it_is.residual_mm));
        list.extend(scaled_in_some(session, &linearised, squares));
        // of all tests sampled alike it is a shift in time
        let everywhere = if is_sampled_unevenly(session) { vec![all(session)] } else { Vec::new() };
        list.extend(rows_apart(sampled, &linearised, &distinct([&everywhere, &pieces])));
        list.extend(out_of_order(sampled, &linearised, &worst, programs));
        list.extend(taken_off(sampled, &linearised));
        list.extend(unsigned(sampled, &linearised));
    }
    list
}

/// Shifts tried, s.
const SHIFTS_S: &[f64] =
    &[-3.0, -2.4, -1.9, -1.5, -1.2, -0.95, -0.75, -0.6, -0.45, 0.45, 0.6, 0.75, 0.95, 1.2, 1.5, 1.9, 2.4, 3.0];

/// Single tests tried for a shift.
const WORST_TESTS: usize = 3;

/// Tests with the largest residual of which two together are tried: a common fit shares what one run has between both runs of its program.
const PAIRED_TESTS: usize = 6;

/// Tests with the largest residual in a common fit.
pub(crate) fn worst_tests(residual_mm: &[Vec<f64>]) -> Vec<usize> {
    worst_of(residual_mm, WORST_TESTS)
}

fn worst_of(residual_mm: &[Vec<f64>], count: usize) -> Vec<usize> {
    let mut order: Vec<(usize, f64)> =
        residual_mm.iter().map(|residual| rms(residual.iter().copied())).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(count).map(|(test, _)| test).collect()
}

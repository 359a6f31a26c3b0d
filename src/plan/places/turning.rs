//! Setups in which one axis turns alone, and what kept others from being reachable. Not yet checked for collisions.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::ball_places::Offer;
use super::candidate::{Avoid, Candidate, Candidates, Misses, WantedSweep};
use super::drive::Drive;
use super::pairing::{LEAST_LEVER_MM, Pairing, SAME_LENGTH_MM, pairings};
use super::solver::{Pull, Solved, Stance};
use crate::chain::{Geometry, LinkId};
use crate::machine::{Axis, AxisKind, Machine};

/// Setups in which one axis turns alone, and what kept others from being reachable.
pub(crate) fn turning(
    machine: &Machine,
    geometry: &Geometry,
    all: &Candidates,
    &WantedSweep { axis, from, to, lengths_mm, starts, avoid }: &WantedSweep,
    offer: Offer,
) -> (Vec<Candidate>, Misses) {
    let chain = geometry.chain();
    let longest_mm = lengths_mm.last().copied().unwrap_or(0.0);
    let pairings = pairings(all, chain, axis, offer);
    let (mut list, mut misses) = (Vec::new(), Misses::default());
    for start in starts {
        let stance = Stance::new(machine, geometry, axis, start);
        let at_sites: Vec<Vector3<f64>> = all.sites.iter().map(|site| stance.point((site.link, &site.at))).collect();
        let at_places: Vec<Vector3<f64>> =
            all.places.iter().map(|place| stance.point((place.link, &place.at))).collect();
        let mut pulls: HashMap<(LinkId, LinkId), Pull> = HashMap::new();
        for &Pairing { place, site, on_tool } in &pairings {
            let (pivot, spindle) =
                ((all.sites[site].link, &at_sites[site]), (all.places[place].link, &at_places[place]));
            let (carried, still) = if on_tool { (spindle, pivot) } else { (pivot, spindle) };
            let pull = pulls.entry((carried.0, still.0)).or_insert_with(|| stance.pull(chain, carried.0, still.0));
            let (rho, _) = stance.lever(carried.1);
            let chosen: &[f64] = if pull.changes_lever { lengths_mm } else { &[] };
            let levers = [rho].into_iter().filter(|&rho| rho >= LEAST_LEVER_MM).chain(chosen.iter().copied());
            for (lever_mm, &bar_mm) in levers.flat_map(|lever| lengths_mm.iter().map(move |bar| (lever, bar))) {
                misses.tried += 1;
                if bar_mm < lever_mm - SAME_LENGTH_MM {
                    misses.too_short += 1;
                    if bar_mm == longest_mm {
                        misses.note_short(lever_mm - bar_mm);
                    }
                    continue;
                }
                // the bar has its stroke: what a place is off by is read as a constant
                let is_level = bar_mm - lever_mm < SAME_LENGTH_MM;
                let spans: &[(f64, f64)] = if is_level { &[(lever_mm, 1.0)] } else { &[(bar_mm, 1.0), (bar_mm, -1.0)] };
                for &span in spans {
                    match stance.solve(pull, carried.1, still.1, lever_mm, span) {
                        Ok(solved) => {
                            if let Some(axis) = avoided(&solved.positions, axis, avoid) {
                                *misses.avoided.entry(axis).or_default() += 1;
                                continue;
                            }
                            let solved = Solved { positions: rounded(machine, solved.positions), ..solved };
                            list.push(Candidate { axis, site, place, bar_mm, solved, from, to, drive: Drive::Turn });
                        }
                        Err(unreachable) => misses.note(&unreachable),
                    }
                }
            }
        }
    }
    (list, misses)
}

/// Positions of linear axes as programs state them, to 10 nm, so that zero is zero.
fn rounded(machine: &Machine, positions: Vec<f64>) -> Vec<f64> {
    let round = |(q, axis): (f64, &Axis)| if axis.kind == AxisKind::Linear { (q * 1e5).round() / 1e5 + 0.0 } else { q };
    positions.into_iter().zip(&machine.axes).map(round).collect()
}

/// The axis, other than the swept one, that stands in an avoided region.
fn avoided(positions: &[f64], swept: usize, avoid: &Avoid) -> Option<usize> {
    let inside =
        |&&(axis, from, to): &&(usize, f64, f64)| axis != swept && positions[axis] > from && positions[axis] < to;
    avoid.iter().find(inside).map(|&(axis, ..)| axis)
}

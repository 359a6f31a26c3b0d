//! Setups that come into question for every rotary axis: places on mounts, bars, static positions. Reachable, not yet checked for collisions.

use super::ball_places::{Offer, pivot_sites, spindle_places};
use super::candidate::{Avoid, Candidate, Candidates, Coupled, WantedSweep};
use super::circle_setups::circles;
use super::following::following;
use super::free_range::sweep_wanted;
use super::pairing::stands_on_line;
use super::starts::static_positions;
use super::turning::turning;
use crate::bodies::{Bodies, Kit};
use crate::chain::{Branch, Chain, Geometry};
use crate::machine::{AxisKind, Machine};

/// Most setups kept for one axis. A pivot that turns with the axis must stand just right, one beside a head anywhere.
const MOST_SETUPS_OF_TABLES: usize = 15_000;
const MOST_SETUPS_OF_HEADS: usize = 4_000;
/// The same with linear axes following.
const MOST_FOLLOWING: usize = 1500;

/// All reachable setups of a machine.
pub fn candidates(machine: &Machine, bodies: &Bodies, kit: &Kit, avoid: &Avoid, coupled: &Coupled) -> Candidates {
    candidates_at(machine, bodies, kit, avoid, coupled, Offer::Spread)
}

/// The same from the places offered.
pub(crate) fn candidates_at(
    machine: &Machine,
    bodies: &Bodies,
    kit: &Kit,
    avoid: &Avoid,
    coupled: &Coupled,
    offer: Offer,
) -> Candidates {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let mut all = Candidates {
        sites: pivot_sites(machine, &chain, bodies, kit, offer),
        places: spindle_places(machine, &chain, kit, offer),
        ..Candidates::default()
    };
    let rotary: Vec<usize> = machine.axes_of(AxisKind::Rotary).collect();
    let lengths = kit.lengths_mm();
    for &axis in &rotary {
        let Some((from, to)) = sweep_wanted(machine, axis, avoid) else { continue };
        let starts = static_positions(machine, &chain, axis, avoid);
        let wanted = WantedSweep { axis, from, to, lengths_mm: &lengths, starts: &starts, avoid };
        // the first start has the other rotary axes at zero
        let of_turning = if offer == Offer::Common { starts.get(..1).unwrap_or_default() } else { &starts };
        let turned = WantedSweep { starts: of_turning, ..wanted };
        let (mine, misses) = turning(machine, &geometry, &all, &turned, offer);
        let most = match chain.carried_by(axis).branch {
            Branch::Workpiece => MOST_SETUPS_OF_TABLES,
            Branch::Tool => MOST_SETUPS_OF_HEADS,
        };
        // what is left out for one axis may be what serves all
        let is_kept = |site: usize| offer == Offer::Level && stands_on_line(&chain, axis, &all.sites[site]);
        let mine = if offer == Offer::Common { mine } else { thinned(mine, most, is_kept) };
        all.list.extend(mine);
        all.misses.insert(axis, misses);
        let more = following(machine, &geometry, &all, &wanted, &coupled.follow, Offer::Spread);
        all.list.extend(thinned(more, MOST_FOLLOWING, |_| false));
    }
    if coupled.circles {
        all.list.extend(circles(machine, &geometry, bodies, &all, &lengths, avoid));
    }
    all
}

/// Every n-th pivot place when there are more setups than needed, and those that are kept in any case: whole places, so that
/// their bars stay together.
fn thinned(mut list: Vec<Candidate>, most: usize, is_kept: impl Fn(usize) -> bool) -> Vec<Candidate> {
    let stride = list.len().div_ceil(most);
    if stride > 1 {
        let mut sites: Vec<usize> = list.iter().map(|candidate| candidate.site).collect();
        sites.sort_unstable();
        sites.dedup();
        let kept: Vec<usize> = sites.into_iter().step_by(stride).collect();
        list.retain(|candidate| kept.binary_search(&candidate.site).is_ok() || is_kept(candidate.site));
    }
    list
}

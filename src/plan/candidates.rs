//! Setups that come into question for every rotary axis: places on mounts, bars, static positions. Reachable, not yet checked for collisions.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;

use super::course::Drive;
use super::following::following;
use super::free_range::{free_parts, sweep_wanted};
use super::places::{Offer, pivot_sites, spindle_places};
use super::planar::circles;
use super::solver::{Pull, Solved, Stance, Unreachable};
use crate::bodies::{Bodies, Kit};
use crate::chain::{Branch, Chain, Geometry, LinkId};
use crate::machine::{Axis, AxisKind, Machine};
use crate::session::Follow;

/// A ball place that several candidates share.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotSite {
    /// Index of the mount.
    pub mount: usize,
    pub link: LinkId,
    pub at: Vector3<f64>,
    pub height_mm: f64,
}

/// Where the spindle ball is clamped.
#[derive(Debug, Clone, PartialEq)]
pub struct SpindlePlace {
    pub link: LinkId,
    pub at: Vector3<f64>,
    /// Distance from the tool axis, mm; above zero on a fixture.
    pub aside_mm: f64,
}

/// One reachable setup for the sweep of one axis, or for a circle of two.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The axis that turns; on a circle the linear axis that carries the cosine.
    pub axis: usize,
    /// Index of the pivot site.
    pub site: usize,
    /// Index of the spindle place.
    pub place: usize,
    pub bar_mm: f64,
    pub solved: Solved,
    /// Arc wanted, rad: of the axis, or on a circle.
    pub from: f64,
    pub to: f64,
    pub drive: Drive,
}

/// What is looked for beside sweeps of one axis alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coupled {
    /// Ways in which linear axes may follow a rotary axis.
    pub follow: Vec<Follow>,
    /// Planar circles of the linear axes.
    pub circles: bool,
}

/// Everything that comes into question.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    pub sites: Vec<PivotSite>,
    pub places: Vec<SpindlePlace>,
    pub list: Vec<Candidate>,
    /// By axis: what kept setups from being reachable, the nearest miss of each limit.
    pub misses: BTreeMap<usize, Misses>,
}

/// What stood in the way for one axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Misses {
    /// Combinations of places, bars and static positions tried.
    pub tried: usize,
    /// Smallest overrun of each linear axis: position and by how much, mm.
    pub limits: BTreeMap<usize, (f64, f64)>,
    /// Smallest amount by which the longest bar was too short, mm.
    pub bar_short_mm: Option<f64>,
    pub singular: usize,
    /// Setups within all limits with this axis in an avoided region.
    pub avoided: BTreeMap<usize, usize>,
}

impl Misses {
    /// The longest bar was too short by so much.
    fn note_short(&mut self, by_mm: f64) {
        self.bar_short_mm = Some(self.bar_short_mm.map_or(by_mm, |least| least.min(by_mm)));
    }

    fn note(&mut self, unreachable: &Unreachable) {
        match *unreachable {
            Unreachable::Limit { axis, at_mm, beyond_mm } => {
                let least = self.limits.entry(axis).or_insert((at_mm, beyond_mm));
                if beyond_mm < least.1 {
                    *least = (at_mm, beyond_mm);
                }
            }
            Unreachable::Singular => self.singular += 1,
            Unreachable::BarShort { .. } => {}
        }
    }
}

/// Axis regions kept out of use, mm or rad.
pub type Avoid = Vec<(usize, f64, f64)>;

/// Smallest lever that a carried ball may have, mm: below, nothing of the axis is seen.
pub(super) const LEAST_LEVER_MM: f64 = 30.0;
/// Balls nearer than this to a bar's length from the line count as h = 0, mm: places are stated to the nanometre.
const SAME_LENGTH_MM: f64 = 5e-6;

/// All reachable setups of a machine.
pub fn candidates(machine: &Machine, bodies: &Bodies, kit: &Kit, avoid: &Avoid, coupled: &Coupled) -> Candidates {
    candidates_at(machine, bodies, kit, avoid, coupled, Offer::Spread)
}

/// The same from the places offered.
pub(super) fn candidates_at(
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
        places: spindle_places(machine, &chain, bodies, kit, offer),
        ..Candidates::default()
    };
    let rotary: Vec<usize> = (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Rotary).collect();
    let lengths = kit.lengths_mm();
    for &axis in &rotary {
        let Some((from, to)) = sweep_wanted(machine, axis, avoid) else { continue };
        let mut starts = static_positions(machine, &chain, axis, avoid);
        if offer == Offer::Common {
            // the first one has the other rotary axes at zero
            starts.truncate(1);
        }
        let (mine, misses) = turning(machine, &geometry, &all, &lengths, (axis, from, to), &starts, avoid, offer);
        let most = match chain.carried_by(axis).branch {
            Branch::Workpiece => MOST_SETUPS_OF_TABLES,
            Branch::Tool => MOST_SETUPS_OF_HEADS,
        };
        // what is left out for one axis may be what serves all
        let is_kept = |site: usize| offer == Offer::Level && stands_on_line(&chain, axis, &all.sites[site]);
        let mine = if offer == Offer::Common { mine } else { thinned(mine, most, is_kept) };
        all.list.extend(mine);
        all.misses.insert(axis, misses);
        let starts = static_positions(machine, &chain, axis, avoid);
        let kinds = &coupled.follow;
        let more =
            following(machine, &geometry, &all, &lengths, (axis, from, to), &starts, avoid, kinds, Offer::Spread);
        all.list.extend(thinned(more, MOST_FOLLOWING, |_| false));
    }
    if coupled.circles {
        all.list.extend(circles(machine, &geometry, bodies, &all, &lengths, avoid));
    }
    all
}

/// Setups in which one axis turns alone, and what kept others from being reachable.
#[allow(clippy::too_many_arguments)]
pub(super) fn turning(
    machine: &Machine,
    geometry: &Geometry,
    all: &Candidates,
    lengths_mm: &[f64],
    (axis, from, to): (usize, f64, f64),
    starts: &[Vec<f64>],
    avoid: &Avoid,
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

/// A spindle ball and a pivot of which the swept axis carries one, by index.
pub(super) struct Pairing {
    pub place: usize,
    pub site: usize,
    /// The axis carries the spindle ball.
    pub on_tool: bool,
}

/// Balls that may be paired for the sweep of an axis.
pub(super) fn pairings(all: &Candidates, chain: &Chain, axis: usize, offer: Offer) -> Vec<Pairing> {
    let mut list = Vec::new();
    for (place_index, place) in all.places.iter().enumerate() {
        let on_tool = chain.carries(axis, place.link);
        if !on_tool && place.aside_mm > 0.0 && offer != Offer::Common {
            // a fixture brings nothing when the axis does not carry it
            continue;
        }
        for (site_index, site) in all.sites.iter().enumerate() {
            // a pivot that stands still may stand anywhere: every third place is enough
            let is_taken = match offer {
                Offer::Common | Offer::Near => true,
                Offer::Level if stands_on_line(chain, axis, site) => true,
                Offer::Level | Offer::Spread => !on_tool || site_index % 3 == place_index % 3,
            };
            if chain.carries(axis, site.link) != on_tool && is_taken {
                list.push(Pairing { place: place_index, site: site_index, on_tool });
            }
        }
    }
    list
}

/// A pivot on the line of an axis with all axes at zero: methods of the thesis set it there, and no slide has to move far.
fn stands_on_line(chain: &Chain, axis: usize, site: &PivotSite) -> bool {
    let joint = chain.joint(axis);
    (site.at - joint.origin).cross(&joint.direction).norm() < SAME_LENGTH_MM
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

/// Static positions of a rotary axis that the swept one carries: they change the lever, degrees.
const CARRIED_DEG: [f64; 8] = [0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 180.0];
/// Static positions of a rotary axis that carries the swept one: they turn the whole setup, degrees.
const CARRYING_DEG: [f64; 3] = [0.0, 90.0, -90.0];
/// Most setups kept for one axis. A pivot that turns with the axis must stand just right, one beside a head anywhere.
const MOST_SETUPS_OF_TABLES: usize = 15_000;
const MOST_SETUPS_OF_HEADS: usize = 4_000;
/// The same with linear axes following.
const MOST_FOLLOWING: usize = 1500;

/// Start positions: linear axes at the place in their range nearest zero, other rotary axes at some static places.
pub(super) fn static_positions(machine: &Machine, chain: &Chain, axis: usize, avoid: &Avoid) -> Vec<Vec<f64>> {
    let near_zero = |k: usize| machine.axes[k].range.map_or(0.0, |(low, high)| 0f64.clamp(low, high));
    let mut starts = vec![(0..machine.axes.len()).map(near_zero).collect::<Vec<f64>>()];
    let branch = chain.carried_by(axis).branch;
    for other in (0..machine.axes.len()).filter(|&k| k != axis && machine.axes[k].kind == AxisKind::Rotary) {
        if chain.carried_by(other).branch != branch {
            continue;
        }
        let fits = |q: &f64| free_parts(machine, other, avoid).iter().any(|(low, high)| q >= low && q <= high);
        let carried = chain.carried_by(other).depth > chain.carried_by(axis).depth;
        let degrees: &[f64] = if carried { &CARRIED_DEG } else { &CARRYING_DEG };
        let mut places: Vec<f64> = degrees.iter().map(|deg| deg.to_radians()).filter(fits).collect();
        if places.is_empty() {
            // off the usual places: the middle of what is left
            places = free_parts(machine, other, avoid).iter().map(|(low, high)| 0.5 * (low + high)).collect();
        }
        starts = starts
            .iter()
            .flat_map(|start| {
                places.iter().map(|&q| {
                    let mut start = start.clone();
                    start[other] = q;
                    start
                })
            })
            .collect();
    }
    starts
}

//! Setups that come into question for every rotary axis: places on mounts, bars, static positions. Reachable, not yet checked for collisions.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;

use super::course::Drive;
use super::following::following;
use super::free_range::{free_parts, sweep_wanted};
use super::planar::circles;
use super::solver::{Pull, Solved, Stance, Unreachable};
use crate::bodies::{Bodies, Kit, Mount, Outline};
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

/// Axis regions kept out of use, mm or rad.
pub type Avoid = Vec<(usize, f64, f64)>;

/// Smallest lever that a carried ball may have, mm: below, nothing of the axis is seen.
const LEAST_LEVER_MM: f64 = 30.0;
/// Balls nearer than this to a bar's length from the line count as h = 0, mm.
const SAME_LENGTH_MM: f64 = 1e-6;

/// All reachable setups of a machine.
pub fn candidates(machine: &Machine, bodies: &Bodies, kit: &Kit, avoid: &Avoid, coupled: &Coupled) -> Candidates {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let mut all =
        Candidates { places: spindle_places(machine, &chain, &geometry, bodies, kit), ..Candidates::default() };
    let rotary: Vec<usize> = (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Rotary).collect();
    for (index, mount) in bodies.mounts.iter().enumerate() {
        if let Some(link) = chain.link(&mount.link) {
            let points = sites(machine, &chain, kit, mount, &rotary, link);
            all.sites.extend(points.into_iter().map(|(at, height_mm)| PivotSite { mount: index, link, at, height_mm }));
        }
    }
    let lengths = kit.lengths_mm();
    for &axis in &rotary {
        let mut misses = Misses::default();
        let first = all.list.len();
        let Some((from, to)) = sweep_wanted(machine, axis, avoid) else { continue };
        for start in static_positions(machine, &chain, axis, avoid) {
            let stance = Stance::new(machine, &geometry, axis, &start);
            let at_sites: Vec<Vector3<f64>> =
                all.sites.iter().map(|site| stance.point((site.link, &site.at))).collect();
            let mut pulls: HashMap<(LinkId, LinkId), Pull> = HashMap::new();
            for (place_index, place) in all.places.iter().enumerate() {
                let on_tool = chain.carries(axis, place.link);
                if !on_tool && place.aside_mm > 0.0 {
                    // a fixture brings nothing when the axis does not carry it
                    continue;
                }
                let at_place = stance.point((place.link, &place.at));
                for (site_index, site) in all.sites.iter().enumerate() {
                    let carries_pivot = chain.carries(axis, site.link);
                    // a pivot that stands still may stand anywhere: every third place is enough
                    if carries_pivot == on_tool || (on_tool && site_index % 3 != place_index % 3) {
                        continue;
                    }
                    let (pivot, spindle) = ((site.link, &at_sites[site_index]), (place.link, &at_place));
                    let (carried, still) = if on_tool { (spindle, pivot) } else { (pivot, spindle) };
                    let pull =
                        pulls.entry((carried.0, still.0)).or_insert_with(|| stance.pull(&chain, carried.0, still.0));
                    let (rho, _) = stance.lever(carried.1);
                    let chosen: &[f64] = if pull.changes_lever { &lengths } else { &[] };
                    let levers = [rho].into_iter().filter(|&rho| rho >= LEAST_LEVER_MM).chain(chosen.iter().copied());
                    for (lever_mm, &bar_mm) in levers.flat_map(|lever| lengths.iter().map(move |bar| (lever, bar))) {
                        misses.tried += 1;
                        if bar_mm < lever_mm - SAME_LENGTH_MM {
                            let by = lever_mm - bar_mm;
                            if bar_mm == lengths[lengths.len() - 1] {
                                misses.bar_short_mm = Some(misses.bar_short_mm.map_or(by, |least: f64| least.min(by)));
                            }
                            continue;
                        }
                        let signs: &[f64] = if bar_mm - lever_mm < SAME_LENGTH_MM { &[1.0] } else { &[1.0, -1.0] };
                        for &sign in signs {
                            match stance.solve(pull, carried.1, still.1, lever_mm, (bar_mm, sign)) {
                                Ok(solved) => {
                                    if let Some(axis) = avoided(&solved.positions, axis, avoid) {
                                        *misses.avoided.entry(axis).or_default() += 1;
                                        continue;
                                    }
                                    let solved = Solved { positions: rounded(machine, solved.positions), ..solved };
                                    all.list.push(Candidate {
                                        axis,
                                        site: site_index,
                                        place: place_index,
                                        bar_mm,
                                        solved,
                                        from,
                                        to,
                                        drive: Drive::Turn,
                                    });
                                }
                                Err(Unreachable::Limit { axis, at_mm, beyond_mm }) => {
                                    let least = misses.limits.entry(axis).or_insert((at_mm, beyond_mm));
                                    if beyond_mm < least.1 {
                                        *least = (at_mm, beyond_mm);
                                    }
                                }
                                Err(Unreachable::Singular) => misses.singular += 1,
                                Err(Unreachable::BarShort { .. }) => {}
                            }
                        }
                    }
                }
            }
        }
        thin_out(&mut all.list, axis, first, chain.carried_by(axis).branch);
        all.misses.insert(axis, misses);
        let more = following(machine, &geometry, &all, &lengths, (axis, from, to), avoid, &coupled.follow);
        all.list.extend(more);
    }
    if coupled.circles {
        all.list.extend(circles(machine, &geometry, bodies, &all, &lengths, avoid));
    }
    all
}

/// Keeps every n-th pivot place of an axis when there are more setups than needed: whole places, so that their bars stay together.
fn thin_out(list: &mut Vec<Candidate>, axis: usize, first: usize, branch: Branch) {
    let most = match branch {
        Branch::Workpiece => MOST_SETUPS_OF_TABLES,
        Branch::Tool => MOST_SETUPS_OF_HEADS,
    };
    let stride = (list.len() - first).div_ceil(most);
    if stride > 1 {
        let mut sites: Vec<usize> = list[first..].iter().map(|candidate| candidate.site).collect();
        sites.sort_unstable();
        sites.dedup();
        let kept: Vec<usize> = sites.into_iter().step_by(stride).collect();
        list.retain(|candidate| candidate.axis != axis || kept.binary_search(&candidate.site).is_ok());
    }
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

/// Pivot ball places on a mount with their heights, mm.
fn sites(
    machine: &Machine,
    chain: &Chain,
    kit: &Kit,
    mount: &Mount,
    rotary: &[usize],
    link: LinkId,
) -> Vec<(Vector3<f64>, f64)> {
    let [lowest, highest] = kit.pivot_stand.height_mm;
    let edge = kit.pivot_stand.base_radius_mm;
    // level with an axis line that runs along the surface and carries it: h = 0 becomes possible for several axes at once
    let mut heights: Vec<f64> = rotary
        .iter()
        .filter(|&&axis| chain.carries(axis, link) && machine.axes[axis].direction.dot(&mount.normal).abs() < 0.1)
        .map(|&axis| (machine.axes[axis].origin - mount.middle).dot(&mount.normal))
        .filter(|height| *height >= lowest && *height <= highest)
        .collect();
    heights.extend([lowest.max(60.0).min(highest), (lowest + highest) * 0.5, highest]);
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    let mut points: Vec<(f64, f64)> = Vec::new();
    match mount.outline {
        Outline::Disc { .. } => {
            let mut radii: Vec<f64> = kit.lengths_mm();
            radii.push(0.6 * (mount.extent_mm() - edge));
            for radius in radii {
                for eighth in 0..8 {
                    let (s, c) = (f64::from(eighth) * std::f64::consts::FRAC_PI_4).sin_cos();
                    points.push((snap(radius * c), snap(radius * s)));
                }
            }
        }
        Outline::Rectangle { size_mm } => {
            let steps = |size: f64| [-0.4, -0.2, 0.0, 0.2, 0.4].map(|part| (part * size).clamp(-400.0, 400.0));
            for u in steps(size_mm[0]) {
                for v in steps(size_mm[1]) {
                    points.push((snap(u), snap(v)));
                }
            }
        }
    }
    // a bar's length from an axis that lies along the surface, at either end of what the surface allows (chapter 6)
    for &axis in rotary.iter().filter(|&&axis| chain.carries(axis, link)) {
        let Some(way) = (machine.axes[axis].direction - mount.normal * mount.normal.dot(&machine.axes[axis].direction))
            .try_normalize(0.7)
        else {
            continue;
        };
        let (a, b) = (way.dot(&mount.along), way.dot(&mount.normal.cross(&mount.along)));
        let from = machine.axes[axis].origin - mount.middle;
        let offset = from.dot(&mount.along) * -b + from.dot(&mount.normal.cross(&mount.along)) * a;
        for length in kit.lengths_mm() {
            for side in [-1.0, 1.0] {
                let across = offset + side * length;
                let room = (mount.extent_mm() - edge).powi(2) - across * across;
                for end in [-1.0, 0.0, 1.0] {
                    let t = end * (0.98 * room.max(0.0).sqrt()).min(300.0);
                    points.push((snap(a * t - b * across), snap(b * t + a * across)));
                }
            }
        }
    }
    // where an axis line meets the surface: a ball that stands still there needs no slide to bring it onto the line
    for &axis in rotary.iter().filter(|&&axis| machine.axes[axis].direction.dot(&mount.normal).abs() > 0.99) {
        let from = machine.axes[axis].origin - mount.middle;
        points.push((snap(from.dot(&mount.along)), snap(from.dot(&mount.normal.cross(&mount.along)))));
    }
    if let Some(pitch) = mount.slot_pitch_mm {
        for (_, v) in &mut points {
            *v = (*v / pitch).round() * pitch;
        }
    }
    points.retain(|&(u, v)| mount.holds(u, v, edge));
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup();
    points
        .iter()
        .flat_map(|&(u, v)| heights.iter().map(move |&height| (u, v, height)))
        .map(|(u, v, height)| {
            let at = mount.point(u, v) + mount.normal * height;
            (at.map(|x| (x * 1e6).round() / 1e6 + 0.0), height)
        })
        .collect()
}

/// Places in a surface to the micrometre.
fn snap(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}

/// Spindle ball on the tool axis and on fixtures, nearest first.
fn spindle_places(
    machine: &Machine,
    chain: &Chain,
    geometry: &Geometry,
    bodies: &Bodies,
    kit: &Kit,
) -> Vec<SpindlePlace> {
    let Some(spindle) = &bodies.spindle else { return Vec::new() };
    let Some(link) = chain.link(&spindle.link) else { return Vec::new() };
    let base = spindle.ball();
    let zero = vec![0.0; machine.axes.len()];
    let heads: Vec<usize> = (0..machine.axes.len())
        .filter(|&k| machine.axes[k].kind == AxisKind::Rotary && chain.carries(k, link))
        .collect();
    // how far the ball must reach out so that it stands a bar's length from a tilting axis
    let mut reaches = vec![0.0];
    for &axis in &heads {
        let stance = Stance::new(machine, geometry, axis, &zero);
        let (rho, _) = stance.lever(&stance.point((link, &base)));
        for length in kit.lengths_mm() {
            let more = length - rho;
            if more > 1.0 && more <= kit.spindle_reach_mm {
                reaches.push(snap(more));
            }
        }
    }
    reaches.push(kit.spindle_reach_mm);
    reaches.sort_by(f64::total_cmp);
    reaches.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    reaches.truncate(4);
    let mut places = Vec::new();
    let side = [Vector3::x(), Vector3::y(), Vector3::z()]
        .iter()
        .find_map(|axis| (axis - spindle.direction * spindle.direction.dot(axis)).try_normalize(0.5))
        .unwrap_or_else(Vector3::x);
    let across = spindle.direction.cross(&side);
    for &reach in &reaches {
        let on_axis = base - spindle.direction * reach;
        places.push(SpindlePlace { link, at: on_axis, aside_mm: 0.0 });
        let arms = kit.fixture.as_ref().map(|fixture| fixture.arms_mm.as_slice()).unwrap_or_default();
        for &arm in arms.iter().filter(|_| !heads.is_empty()) {
            for direction in [side, -side, across, -across] {
                places.push(SpindlePlace { link, at: on_axis + direction * arm, aside_mm: arm });
            }
        }
    }
    places
}

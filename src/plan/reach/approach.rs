//! Where the machine parks between tests and the checked way from there to the start of a run; the retreat is the same way back.
//!
//! Cups, balls and stand are mounted on the way, the bar is not: it is put on at the start of the run-in. Setups are
//! changed at the park position, so that every program starts and ends there and tests may run in any order.

use crate::chain::{Branch, Chain, Geometry};
use crate::collision::{Aside, Leg, NoWay, Scene, Scratch, certify, clear_way};
use crate::machine::{AxisKind, Machine};
use crate::plan::places::candidate::Avoid;
use crate::plan::places::free_range::free_parts;
use crate::session::APPROACHED_OVER;

/// The way to a test.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Positions of all axes where setups are changed, mm and rad.
    pub park: Vec<f64>,
    /// Axes in the order in which they go to park from wherever the machine stands: away from the table first.
    pub park_order: Vec<usize>,
    /// Moves aside and back to park, before the legs, of axes that the legs leave on an unknown flank of their lost motion.
    pub aside_and_back: Vec<Leg>,
    /// From park to the start of the run-in, one axis at a time.
    pub legs: Vec<Leg>,
}

impl Approach {
    /// The same way back: from the start of the run-in to park. Programs go back over the corners; tests compare.
    pub fn retreat(&self) -> Vec<Leg> {
        let mut here = self.park.clone();
        let mut back = Vec::new();
        for leg in &self.legs {
            back.push(Leg { axis: leg.axis, to: here[leg.axis] });
            here[leg.axis] = leg.to;
        }
        back.reverse();
        back
    }

    /// Positions at the corners of the way, park first.
    pub fn corners(&self) -> Vec<Vec<f64>> {
        let mut corners = vec![self.park.clone()];
        for leg in &self.legs {
            let mut here = corners[corners.len() - 1].clone();
            here[leg.axis] = leg.to;
            corners.push(here);
        }
        corners
    }

    /// Far ends of the moves aside.
    pub fn asides(&self) -> impl Iterator<Item = &Leg> {
        self.aside_and_back.iter().step_by(2)
    }

    /// The last leg of an axis, from and to, mm or rad.
    fn last_leg(&self, axis: usize) -> Option<(f64, f64)> {
        let last = self.legs.iter().rposition(|leg| leg.axis == axis)?;
        Some((self.corners()[last][axis], self.legs[last].to))
    }
}

/// Park positions that come into question and ways aside, best first.
#[derive(Debug, Clone)]
pub struct Parking {
    parks: Vec<Vec<f64>>,
    park_order: Vec<usize>,
    asides: Vec<Aside>,
    avoid: Avoid,
}

/// Travel aside of an axis without range, mm.
const FREE_TRAVEL_MM: f64 = 300.0;
/// Ends of ranges are kept off, mm: a control stops at its limit.
const OFF_LIMIT_MM: f64 = 1.0;
/// Axes that stay within this of one place stand, mm or rad.
pub(crate) const STANDS: f64 = 1e-6;

impl Parking {
    /// Park positions of a machine: spindle and table apart, other axes at zero or in the middle, all outside avoided regions
    /// and on either side of them.
    pub fn of(machine: &Machine, avoid: &Avoid) -> Parking {
        let chain = Chain::of(machine);
        let linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
        let ends = |k: usize| {
            let (low, high) = machine.axes[k].range.unwrap_or((-FREE_TRAVEL_MM, FREE_TRAVEL_MM));
            let off = OFF_LIMIT_MM.min(0.25 * (high - low));
            [low + off, high - off]
        };
        let zero: Vec<f64> = machine.axes.iter().map(|axis| axis.near_zero()).collect();
        let up = spindle_up(machine, &chain, &zero);
        // how much the spindle leaves the table when an axis moves by one
        let parting = |k: usize| {
            let tool = chain.branch(Branch::Tool).contains(&k);
            let joint = chain.joint(k);
            joint.sign * joint.direction.dot(&up) * if tool { 1.0 } else { -1.0 }
        };
        let away = linear.iter().copied().max_by(|&a, &b| parting(a).abs().total_cmp(&parting(b).abs()));
        let apart = |k: usize| if parting(k) < 0.0 { ends(k)[0] } else { ends(k)[1] };
        let mut base = zero.clone();
        if let Some(k) = away {
            base[k] = apart(k);
        }
        let others: Vec<usize> = linear.iter().copied().filter(|&k| Some(k) != away).collect();
        let with = |changes: &[(usize, f64)]| {
            let mut park = base.clone();
            changes.iter().for_each(|&(k, q)| park[k] = q);
            park
        };
        let middle = |k: usize| (k, 0.5 * (ends(k)[0] + ends(k)[1]));
        let mut parks = vec![base.clone(), with(&others.iter().map(|&k| middle(k)).collect::<Vec<_>>())];
        parks.extend(others.iter().flat_map(|&k| ends(k).map(|q| with(&[(k, q)]))));
        parks.push(zero);
        let mut asides: Vec<Aside> = vec![Vec::new()];
        asides.extend(away.map(|k| vec![(k, apart(k))]));
        asides.extend(linear.iter().flat_map(|&k| ends(k).map(|q| vec![(k, q)])));
        if let Some(first) = away {
            asides.extend(others.iter().flat_map(|&k| ends(k).map(|q| vec![(first, apart(first)), (k, q)])));
        }
        let rotary = (0..machine.axes.len()).filter(|k| !linear.contains(k));
        let park_order = away.into_iter().chain(rotary).chain(others.iter().copied()).collect();
        let parks = parks.iter().flat_map(|park| outside(machine, avoid, &all_axes(park)));
        let mut parks: Vec<Vec<f64>> = parks.map(|park| park.into_iter().map(|(_, q)| q).collect()).collect();
        drop_repeated(&mut parks);
        let mut asides: Vec<Aside> = asides.iter().flat_map(|aside| outside(machine, avoid, aside)).collect();
        drop_repeated(&mut asides);
        Parking { parks, park_order, asides, avoid: avoid.clone() }
    }

    /// No axis has to go through an avoided region on the way from a park position to a start.
    pub fn serves(&self, park: usize, start: &[f64]) -> bool {
        self.parks[park].iter().zip(start).enumerate().all(|(axis, (&q, &start))| is_free(&self.avoid, axis, q, start))
    }

    /// Number of park positions.
    pub fn count(&self) -> usize {
        self.parks.len()
    }

    /// The way from a park position to a start, in a scene without bar.
    pub fn approach(
        &self,
        park: usize,
        scene: &Scene,
        start: &[f64],
        margin_mm: f64,
        scratch: &mut Scratch,
    ) -> Result<Approach, NoWay> {
        let park = &self.parks[park];
        let is_free_way = |aside: &&Aside| aside.iter().all(|&(axis, q)| is_free(&self.avoid, axis, q, start[axis]));
        let asides: Vec<Aside> = self.asides.iter().filter(is_free_way).cloned().collect();
        let legs = clear_way(scene, park, start, &asides, margin_mm, scratch)?;
        Ok(Approach { park: park.clone(), park_order: self.park_order.clone(), aside_and_back: Vec::new(), legs })
    }

    /// The sense, −1 or 1 as commanded, in which the axes that stand in a run come to their places, by axis. An axis that comes
    /// from nearer than [`APPROACHED_OVER`] first goes aside from park and back where that is clear; `None` where nothing tells its sense.
    pub fn give_senses(
        &self,
        machine: &Machine,
        scene: &Scene,
        (approach, run): (&mut Approach, &[Vec<f64>]),
        margin_mm: f64,
        scratch: &mut Scratch,
    ) -> Vec<Option<f64>> {
        let mut sense_of = |axis: usize| {
            if run.iter().any(|row| (row[axis] - run[0][axis]).abs() > STANDS) {
                return None;
            }
            let kind = machine.axes[axis].kind;
            let last = approach.last_leg(axis).map(|(from, to)| to - from);
            if let Some(way) = last.filter(|way| kind.to_file_unit(way.abs()) >= APPROACHED_OVER) {
                return Some(way.signum());
            }
            // short, and not the only one: from where it comes it has not been aside
            if approach.legs.iter().filter(|leg| leg.axis == axis).count() > 1 {
                return None;
            }
            let park = approach.park[axis];
            let far = |sense: f64| park - sense * kind.from_file_unit(APPROACHED_OVER);
            let senses = last.map_or(vec![1.0, -1.0], |way| vec![way.signum()]);
            let sense = senses.into_iter().find(|&sense| {
                let off = kind.from_file_unit(OFF_LIMIT_MM);
                let is_inside = |(low, high): (f64, f64)| (low + off..=high - off).contains(&far(sense));
                let mut aside = approach.park.clone();
                aside[axis] = far(sense);
                machine.axes[axis].range.is_none_or(is_inside)
                    && is_free(&self.avoid, axis, park, far(sense))
                    && certify(scene, &[approach.park.clone(), aside], margin_mm, scratch).is_ok()
            })?;
            approach.aside_and_back.extend([far(sense), park].map(|to| Leg { axis, to }));
            Some(sense)
        };
        (0..machine.axes.len()).map(&mut sense_of).collect()
    }
}

/// Positions closer than this to an avoided region's end are outside, mm or rad: programs state tens of nanometres.
const AT_END: f64 = 1e-5;

/// An axis may go from one position to another without a part of the way in an avoided region.
fn is_free(avoid: &Avoid, axis: usize, one: f64, other: f64) -> bool {
    let (low, high) = (one.min(other), one.max(other));
    avoid.iter().all(|&(of, from, to)| of != axis || low >= to - AT_END || high <= from + AT_END)
}

fn all_axes(positions: &[f64]) -> Vec<(usize, f64)> {
    positions.iter().copied().enumerate().collect()
}

/// Axis positions moved out of avoided regions, into every free part of each axis's range, the nearest first.
fn outside(machine: &Machine, avoid: &Avoid, positions: &[(usize, f64)]) -> Vec<Vec<(usize, f64)>> {
    let mut all = vec![positions.to_vec()];
    for (place, &(axis, q)) in positions.iter().enumerate() {
        if avoid.iter().all(|(other, ..)| *other != axis) {
            continue;
        }
        let mut free: Vec<f64> =
            free_parts(machine, axis, avoid).iter().map(|&(low, high)| q.clamp(low, high)).collect();
        free.sort_by(|a, b| (a - q).abs().total_cmp(&(b - q).abs()));
        all = free
            .iter()
            .flat_map(|&q| {
                all.iter().cloned().map(move |mut positions| {
                    positions[place].1 = q;
                    positions
                })
            })
            .collect();
    }
    all
}

/// Keeps the first of equals, in order.
fn drop_repeated<T: PartialEq>(list: &mut Vec<T>) {
    let mut kept: Vec<T> = Vec::new();
    for item in list.drain(..) {
        if !kept.contains(&item) {
            kept.push(item);
        }
    }
    *list = kept;
}

/// Avoided regions that lie between the park positions of some tests and those of others, in words.
pub(crate) fn crossings(machine: &Machine, avoid: &Avoid, parked: &[(&str, &Approach)]) -> Vec<String> {
    let between = |&(axis, from, to): &(usize, f64, f64)| {
        let (below, above): (Vec<_>, Vec<_>) = parked.iter().partition(|(_, way)| way.park[axis] <= from + AT_END);
        let names = |tests: &[&(&str, &Approach)]| tests.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        (!below.is_empty() && !above.is_empty()).then(|| {
            let entry = &machine.axes[axis];
            let [from, to] = [from, to].map(|q| (entry.kind.to_file_unit(q) * 1e3).round() / 1e3 + 0.0);
            format!(
                "{name} goes through {from}..{to}, which --avoid keeps out of use, between the park position of {} and that of {}: with the bar off, nothing is read there",
                names(&below.iter().collect::<Vec<_>>()),
                names(&above.iter().collect::<Vec<_>>()),
                name = entry.name
            )
        })
    };
    avoid.iter().filter_map(between).collect()
}

/// Direction from the table into the spindle in the bed frame.
fn spindle_up(machine: &Machine, chain: &Chain, positions: &[f64]) -> nalgebra::Vector3<f64> {
    let Some(spindle) = &machine.spindle else { return nalgebra::Vector3::z() };
    let Some(link) = chain.link(&spindle.link) else { return spindle.direction };
    Geometry::nominal(chain).pose(link, positions, None).rotation * spindle.direction
}

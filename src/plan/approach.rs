//! Where the machine parks between tests and the checked way from there to the start of a run; the retreat is the same way back.
//!
//! Cups, balls and stand are mounted on the way, the bar is not: it is put on at the start of the run-in. Setups are
//! changed at the park position, so that every program starts and ends there and tests may run in any order.

use crate::bodies::Bodies;
use crate::chain::{Branch, Chain, Geometry};
use crate::collision::{Aside, Leg, NoWay, Scene, Scratch, clear_way};
use crate::machine::{AxisKind, Machine};

/// The way to a test.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Positions of all axes where setups are changed, mm and rad.
    pub park: Vec<f64>,
    /// Axes in the order in which they go to park from wherever the machine stands: away from the table first.
    pub park_order: Vec<usize>,
    /// From park to the start of the run-in, one axis at a time.
    pub legs: Vec<Leg>,
}

impl Approach {
    /// The same way back: from the start of the run-in to park.
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
}

/// Park positions that come into question and ways aside, best first.
#[derive(Debug, Clone)]
pub struct Parking {
    parks: Vec<Vec<f64>>,
    park_order: Vec<usize>,
    asides: Vec<Aside>,
}

/// Travel aside of an axis without range, mm.
const FREE_TRAVEL_MM: f64 = 300.0;
/// Ends of ranges are kept off, mm: a control stops at its limit.
const OFF_LIMIT_MM: f64 = 1.0;

impl Parking {
    /// Park positions of a machine: spindle and table apart, other axes at zero or in the middle.
    pub fn of(machine: &Machine, bodies: &Bodies) -> Parking {
        let chain = Chain::of(machine);
        let linear: Vec<usize> =
            (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear).collect();
        let ends = |k: usize| {
            let (low, high) = machine.axes[k].range.unwrap_or((-FREE_TRAVEL_MM, FREE_TRAVEL_MM));
            let off = OFF_LIMIT_MM.min(0.25 * (high - low));
            [low + off, high - off]
        };
        let zero: Vec<f64> =
            machine.axes.iter().map(|axis| axis.range.map_or(0.0, |(low, high)| 0f64.clamp(low, high))).collect();
        let up = spindle_up(&chain, bodies, &zero);
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
        Parking { parks, park_order, asides }
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
        let legs = clear_way(scene, park, start, &self.asides, margin_mm, scratch)?;
        Ok(Approach { park: park.clone(), park_order: self.park_order.clone(), legs })
    }
}

/// Direction from the table into the spindle in the bed frame.
fn spindle_up(chain: &Chain, bodies: &Bodies, positions: &[f64]) -> nalgebra::Vector3<f64> {
    let Some(spindle) = &bodies.spindle else { return nalgebra::Vector3::z() };
    let Some(link) = chain.link(&spindle.link) else { return spindle.direction };
    Geometry::nominal(chain).pose(link, positions, None).rotation * spindle.direction
}

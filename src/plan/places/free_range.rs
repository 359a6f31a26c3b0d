//! What avoided regions leave of an axis's range, and the sweep that fits there. It places nothing.

use super::candidate::Avoid;
use super::run_in::{OFF_LIMIT, RUN_IN, shortest_deg};
use crate::machine::{AxisKind, Machine};

/// Parts of an axis's range outside the avoided regions in rising order, mm or rad; a rotary axis without limits has one turn
/// to either side.
pub fn free_parts(machine: &Machine, axis: usize, avoid: &Avoid) -> Vec<(f64, f64)> {
    let endless = match machine.axes[axis].kind {
        AxisKind::Rotary => std::f64::consts::TAU,
        AxisKind::Linear => f64::INFINITY,
    };
    let regions = avoid.iter().filter(|(other, ..)| *other == axis).map(|&(_, from, to)| (from, to)).collect();
    outside(machine.axes[axis].range.unwrap_or((-endless, endless)), regions)
}

/// Parts of a range outside some regions.
fn outside((low, high): (f64, f64), mut regions: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if regions.is_empty() {
        return vec![(low, high)];
    }
    regions.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut parts = Vec::new();
    let mut start = low;
    for (from, to) in regions {
        parts.push((start, from.min(high)));
        start = start.max(to);
    }
    parts.push((start, high));
    parts.retain(|(from, to)| from < to);
    parts
}

/// The widest part of an axis's range that a run may use: outside avoided regions and off the limits.
pub(crate) fn widest(machine: &Machine, axis: usize, avoid: &Avoid) -> Option<(f64, f64)> {
    let off_rad = OFF_LIMIT.to_radians();
    let limits = machine.axes[axis].range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let off = |(low, high): (f64, f64)| (low.max(limits.0 + off_rad), high.min(limits.1 - off_rad));
    let wider = |a: (f64, f64), b: (f64, f64)| if b.1 - b.0 > a.1 - a.0 { b } else { a };
    free_parts(machine, axis, avoid).into_iter().map(off).reduce(wider)
}

/// The sweep asked of a rotary axis: the widest part that a run may use less the run-in at both ends, a full turn at most;
/// `None` when no capture arc fits.
pub(crate) fn sweep_wanted(machine: &Machine, axis: usize, avoid: &Avoid) -> Option<(f64, f64)> {
    let (low, high) = widest(machine, axis, avoid)?;
    let (low, high) = (low + RUN_IN.to_radians(), high - RUN_IN.to_radians());
    let turn = std::f64::consts::TAU;
    if high - low >= turn {
        let middle = (low + high) * 0.5;
        return Some((middle - 0.5 * turn, middle + 0.5 * turn));
    }
    (high - low >= shortest_deg(machine, axis).to_radians() - 1e-9).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::{outside, sweep_wanted};
    use crate::machine::{Axis, AxisKind, Directions, Machine, StructuralCode};
    use nalgebra::Vector3;

    #[test]
    fn a_range_of_just_one_turn_and_its_ends_takes_the_turn_wherever_it_lies() {
        let code = StructuralCode::parse("[wCbt]").expect("a code");
        for tenths in -3681..0 {
            let low = (0.1 * f64::from(tenths)).to_radians();
            let axis = Axis {
                name: "C".into(),
                kind: AxisKind::Rotary,
                direction: Vector3::z(),
                origin: Vector3::zeros(),
                range: Some((low, (0.1 * f64::from(tenths) + 368.2).to_radians())),
                reversed: false,
                location_errors: [0.0; 6],
                component_errors: Vec::new(),
            };
            let machine = Machine::plain("one axis".into(), code.clone(), Directions::Iso841, vec![axis]);
            let (from, to) = sweep_wanted(&machine, 0, &Vec::new()).expect("a sweep");
            assert!((to - from - std::f64::consts::TAU).abs() < 1e-9 && from > low, "{tenths}");
        }
    }

    #[test]
    fn regions_in_any_order_leave_what_is_between_them() {
        assert_eq!(outside((-10.0, 20.0), vec![]), [(-10.0, 20.0)]);
        assert_eq!(outside((-10.0, 20.0), vec![(5.0, 7.0), (-20.0, -4.0)]), [(-4.0, 5.0), (7.0, 20.0)]);
        assert_eq!(outside((-10.0, 20.0), vec![(0.0, 8.0), (5.0, 9.0), (1.0, 2.0)]), [(-10.0, 0.0), (9.0, 20.0)]);
        assert_eq!(outside((-10.0, 20.0), vec![(-30.0, 5.0), (5.0, 40.0)]), []);
        assert_eq!(outside((-10.0, 20.0), vec![(30.0, 50.0)]), [(-10.0, 20.0)]);
    }
}

//! The one rule for positions outside an axis's range. It knows no file.

use crate::machine::Machine;

/// Message when a position (mm, rad) lies outside its axis's range.
pub fn outside_range(machine: &Machine, axis: usize, value: f64) -> Option<String> {
    let axis = &machine.axes[axis];
    let (from, to) = axis.range?;
    // positions are printed to 1e-5; the ends themselves are allowed
    let slack = 1e-4 * (1.0 + value.abs());
    (value < from - slack || value > to + slack).then(|| {
        // degrees come back from radians with a stirred last digit
        let file = |value: f64| (axis.kind.to_file_unit(value) * 1e9).round() / 1e9;
        format!(
            "{} = {} {} is outside the axis's range {} … {} {}",
            axis.name,
            file(value),
            axis.kind.position_unit(),
            file(from),
            file(to),
            axis.kind.position_unit()
        )
    })
}

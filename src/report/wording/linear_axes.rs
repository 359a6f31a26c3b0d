//! The budget of the linear axes in words and as JSON. What it means for a fit is `identify`'s.

use serde::Serialize;

use crate::machine::{AxisKind, LinearClass, Machine};

/// The budget, one standard deviation each.
#[derive(Debug, Clone, Serialize)]
pub struct LinearAxesJson {
    /// `new`, `used`, `worn`; null for numbers of the machine file.
    pub class: Option<&'static str>,
    /// The machine file says so; else it is assumed.
    pub stated: bool,
    /// Along an axis, per length moved from its zero.
    pub positioning_um_per_m: f64,
    /// Across an axis.
    pub straightness_um_per_m: f64,
    pub squareness_urad: f64,
    /// In words.
    pub says: String,
}

/// The budget of a machine; `None` without linear axes.
pub fn linear_axes_json(machine: &Machine) -> Option<LinearAxesJson> {
    if machine.axes.iter().all(|axis| axis.kind == AxisKind::Rotary) {
        return None;
    }
    let budget = &machine.linear_axes;
    // thousandths are enough of a standard deviation, and hide what rounding leaves of a unit
    let per_million = |value: f64| (value * 1e9).round() / 1e3;
    let (along, across, square) =
        (per_million(budget.positioning), per_million(budget.straightness), per_million(budget.squareness_rad));
    let class = budget.class.map(LinearClass::name);
    let numbers = match along == across {
        true => format!("± {along} µm/m, out of square ± {square} µrad"),
        false => format!("± {along} µm/m along, ± {across} µm/m across, out of square ± {square} µrad"),
    };
    let says = match (class, budget.is_stated) {
        (Some(class), true) => format!("linear axes '{class}' by the machine file: {numbers}"),
        (Some(class), false) => {
            format!("linear axes assumed '{class}': {numbers} (state linear_axes: new, used, worn or numbers)")
        }
        (None, _) => format!("linear axes by the machine file: {numbers}"),
    };
    Some(LinearAxesJson {
        class,
        stated: budget.is_stated,
        positioning_um_per_m: along,
        straightness_um_per_m: across,
        squareness_urad: square,
        says,
    })
}

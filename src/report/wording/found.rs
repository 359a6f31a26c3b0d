//! What a user of findings has to know of them, in words: causes that are open, tables that end with the recordings. It decides nothing.

use crate::disturbances::{Remembered, TableEnd};
use crate::machine::{AxisKind, Effect, Machine};

/// One sentence for each cause that the recordings leave open.
pub fn open_causes(machine: &Machine, effects: &[Effect]) -> Vec<String> {
    let of = |effect: &Effect| {
        effect.cannot_tell_from.as_ref().map(|rival| {
            format!(
                "the cause is open: {} of {} was found, and the recordings hardly tell it from {rival}; if it is the other one, what is taken out for it does harm: run the test that 'diagnose' proposes first",
                effect.kind,
                effect.place.name(machine)
            )
        })
    };
    effects.iter().filter_map(of).collect()
}

/// One sentence for each table that ends where the recordings end.
pub fn ends_of_tables(machine: &Machine, ends: &[TableEnd]) -> Vec<String> {
    let of = |end: &TableEnd| {
        let axis = &machine.axes[end.axis];
        let unit = if axis.kind == AxisKind::Linear { "mm" } else { "deg" };
        let shown = |q: f64| format!("{:.1}", axis.kind.to_file_unit(q) + 0.0);
        format!(
            "{} of {} was recorded from {} to {} {unit}: beyond that its last value is held, which nobody has measured",
            end.effect,
            axis.name,
            shown(end.from),
            shown(end.to)
        )
    };
    ends.iter().map(of).collect()
}

/// One sentence for what is run along the program.
pub fn along_the_program(machine: &Machine, remembered: &[Remembered]) -> Vec<String> {
    let of = |one: &Remembered| {
        format!(
            "{} of {} is taken out along the commands, from the middle of it until {} has moved: see that the control does not compensate it too",
            one.kind, machine.axes[one.axis].name, machine.axes[one.driving].name
        )
    };
    remembered.iter().map(of).collect()
}

//! Topologies that are one machine on the envelope: which stands for which. It plans nothing.
//!
//! Linear axes with no rotary axis between them, the bed apart, only shift one side against the other: in which order they
//! come, and on which side of the bed, changes no distance and no length, nor what their errors do to a length, for the
//! location error of a linear axis turns its direction alone. Travels are the same either way, and what stands beside the
//! table is carried by the link next to the first rotary axis from there.

use crate::machine::StructuralCode;

/// The topology that stands for a code: linear axes in alphabetical order wherever no rotary axis lies between them, the bed as
/// near the workpiece as the rotary axes leave it.
pub fn representative(code: &StructuralCode) -> StructuralCode {
    let is_rotary = |name: &&String| matches!(name.as_str(), "A" | "B" | "C");
    let on_workpiece = code.workpiece_side.iter().filter(is_rotary).count();
    let mut names: Vec<String> = code.axis_names().map(|name| name.to_string()).collect();
    for run in names.split_mut(|name| is_rotary(&name)) {
        run.sort();
    }
    let last = (0..names.len()).filter(|&place| is_rotary(&&names[place])).take(on_workpiece).last();
    let tool_side = names.split_off(last.map_or(0, |place| place + 1));
    StructuralCode { workpiece_side: names, tool_side }
}

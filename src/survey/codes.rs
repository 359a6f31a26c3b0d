//! The structural codes of all serial five-axis machines: three linear and two rotary axes in any order, the bed anywhere. It describes no machine.

use crate::machine::StructuralCode;

/// Pairs of rotary axes about different directions.
const ROTARY_PAIRS: [[&str; 2]; 3] = [["A", "B"], ["A", "C"], ["B", "C"]];

/// All codes, by the number of axes that carry the workpiece, then the rotary pair, then the order of the axes.
pub fn codes() -> Vec<StructuralCode> {
    let mut codes = Vec::new();
    for on_workpiece_side in 0..=5 {
        for [first, second] in ROTARY_PAIRS {
            let mut orders = Vec::new();
            permute(&["X", "Y", "Z", first, second], &mut Vec::new(), &mut orders);
            codes.extend(orders.into_iter().map(|order| StructuralCode {
                workpiece_side: order[..on_workpiece_side].to_vec(),
                tool_side: order[on_workpiece_side..].to_vec(),
            }));
        }
    }
    codes
}

/// All orders of `left` behind what is `taken`.
fn permute(left: &[&str], taken: &mut Vec<String>, orders: &mut Vec<Vec<String>>) {
    if left.is_empty() {
        orders.push(taken.clone());
    }
    for (index, letter) in left.iter().enumerate() {
        let mut rest = left.to_vec();
        rest.remove(index);
        taken.push(letter.to_string());
        permute(&rest, taken, orders);
        taken.pop();
    }
}

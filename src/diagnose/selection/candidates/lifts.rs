//! Stretches over which a part may sit in another way. It judges nothing.

use super::family::Refined;
use crate::effects::CLAMP_LIFT;
use crate::machine::{Effect, ParameterValue, Place};

/// Places at which a stretch may begin or end, the ends of the travel among them.
const EDGES: usize = 13;

/// Stretches of a travel over which a part may be lifted, and how they are refined; `late` is the first step of the hysteresis.
pub(super) fn stretches(place: Place, (from, to): (f64, f64), late: f64) -> (Vec<Effect>, Vec<Refined>) {
    let step = (to - from) / (EDGES - 1) as f64;
    let edge = |k: usize| ParameterValue::Number(from + step * k as f64);
    let stretch = |begins, ends| {
        let lift = Effect::new(CLAMP_LIFT.name, place).with("from", edge(begins)).with("to", edge(ends));
        lift.with("hysteresis", ParameterValue::Number(0.0)).with("rise", ParameterValue::Number(0.0))
    };
    let pairs = (0..EDGES).flat_map(|begins| (begins + 1..EDGES).map(move |ends| (begins, ends)));
    let whole = (0, EDGES - 1);
    let grid = pairs.filter(|pair| *pair != whole).map(|(begins, ends)| stretch(begins, ends)).collect();
    let refined = |name, least, most, step| Refined { name, least, most, step, element: None };
    let shape = vec![
        refined("from", from - step, to, 0.5 * step),
        refined("to", from, to + step, 0.5 * step),
        refined("hysteresis", 0.0, to - from, late),
        refined("rise", 0.0, 10.0, 0.4),
    ];
    (grid, shape)
}

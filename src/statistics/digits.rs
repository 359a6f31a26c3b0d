//! Digits with which numbers were written.

/// Steps that are looked for; finer ones do no harm.
const STEPS: [f64; 5] = [10.0, 1.0, 0.1, 0.01, 0.001];

/// How near to a multiple of its step a value lies: a tenth of the last digit that files have.
pub const ON_STEP: f64 = 1e-7;

/// The largest step of which all values are multiples, from 10 down to 0.001 by tens.
pub fn step_of<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> Option<f64> {
    let is_on = |step: &f64| {
        values().all(|value| {
            let steps = value / step;
            (steps - steps.round()).abs() * step < ON_STEP
        })
    };
    STEPS.into_iter().find(is_on)
}

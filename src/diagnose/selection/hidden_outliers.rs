//! Readings that are gross only once an effect is taken from them. It looks for no effects.

use crate::identify::{self, Fit, Problem};

/// Share of the readings that may hide as outliers under an effect: more is the rest of its form.
const MOST_HIDDEN: f64 = 0.005;

/// The fit without readings that are far off once an effect is taken from the residuals; `None` where there are none.
pub(crate) fn without_hidden_outliers(problem: &Problem, fit: &Fit, left_mm: &[Vec<f64>]) -> Option<Fit> {
    let mut fit = fit.clone();
    let (mut hidden, mut readings) = (0, 0);
    for (test, near) in fit.tests.iter_mut().zip(identify::kept_rows(problem, left_mm)) {
        readings += test.kept.len();
        for row in (0..near.len()).filter(|&row| !near[row]) {
            if test.kept[row] {
                hidden += 1;
                test.kept[row] = false;
                test.left_out.push(row);
            }
        }
        test.left_out.sort_unstable();
    }
    (hidden > 0 && (hidden as f64) < MOST_HIDDEN * readings as f64).then_some(fit)
}

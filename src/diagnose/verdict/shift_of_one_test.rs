//! A search may find that positions and lengths of one test do not belong together: a mistake in the files, told as one.

use crate::diagnose::preflight::data_fault::DataFault;
use crate::diagnose::selection::selected::Search;

/// The shift of a single test that a search found.
pub(crate) fn shift_of_one_test(search: &Search) -> Option<DataFault> {
    let found = search.found.iter().find(|found| found.chosen.is_shift_of_one_test())?;
    let tests = found.chosen.effect.tests.clone().unwrap_or_default();
    let shift_ms = found.chosen.judgement.amplitudes.first().copied()?;
    let before_mm2 = search.residual_before_mm2;
    Some(DataFault::time_shift(
        shift_ms / 1e3,
        tests,
        1e3 * before_mm2.sqrt(),
        1e3 * (before_mm2 - found.fall_mm2).max(0.0).sqrt(),
    ))
}

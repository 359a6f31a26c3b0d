//! What recordings and session say against each other, seen without a fit: one recording in two tests, clocks, rows that stand still, lost digits, lost noise, arcs.

mod arcs;
mod directions;
mod ends;
mod quiet;
mod rounded;
mod same_rows;
mod standstill;
mod straight;
mod times;

pub(crate) use arcs::{agrees_with_sweep, unit_instead};
pub(crate) use same_rows::is_read;

use crate::diagnose::preflight::data_fault::DataFault;
use crate::diagnose::preflight::readings::taken_off::lacking;
use crate::session::Session;

/// What no other mistake can look like; lost digits and copies come first, for readings without digits agree by chance, and a copied
/// file contradicts its test in other ways too.
pub(crate) fn contradiction(session: &Session) -> Option<DataFault> {
    ends::exchanged(session)
        .or_else(|| rounded::rounded(session))
        .or_else(|| copied_rows(session))
        .or_else(|| arcs::uncut(session))
        .or_else(|| arcs::in_other_unit(session))
        .or_else(|| standstill::missing(session))
        // while axes stand a gauge in order may show one figure for long
        .or_else(|| standstill::standing(session))
        .or_else(|| standstill::stuck(session))
        .or_else(|| straight::drawn(session))
        // a slow run takes longer than the fast one in whose place it stands
        .or_else(|| times::at_other_feeds(session))
        .or_else(|| times::overlapping(session))
        .or_else(|| lacking(session))
}

/// Readings that stand in the files twice, of any instrument.
pub(crate) fn copied_rows(session: &Session) -> Option<DataFault> {
    same_rows::copied(session).or_else(|| same_rows::appended(session))
}

/// What a wrong unit or order of a column would look like too: asked when none of these explains the readings.
pub(crate) fn further_contradiction(session: &Session) -> Option<DataFault> {
    quiet::quiet(session)
        .or_else(|| quiet::finer_than_a_gauge(session))
        .or_else(|| arcs::other_arc(session))
        .or_else(|| directions::against_its_name(session))
        .or_else(|| times::other_speed(session))
        .or_else(|| times::other_scale(session))
}

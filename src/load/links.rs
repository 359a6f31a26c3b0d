//! The one rule for names of links in files of machines and sessions. It knows no keys.

use crate::chain::Chain;
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::{LoadError, did_you_mean};

/// Refuses a link that the machine has not.
pub(crate) fn known_link(document: &Document, chain: &Chain, place: &[Step], name: &str) -> Result<(), LoadError> {
    if chain.link(name).is_some() {
        return Ok(());
    }
    let known = chain.link_names();
    let hint = did_you_mean(name, &known);
    Err(document.refuse(place, format!("no link is called '{name}'{hint} (links: {})", known.join(" "))))
}

//! Which spindle ball and which pivot may be paired for the sweep of an axis. No bar is placed between them here.

use super::ball_places::Offer;
use super::candidate::{Candidates, PivotSite};
use crate::chain::Chain;

/// Smallest lever that a carried ball may have, mm: below, nothing of the axis is seen.
pub(crate) const LEAST_LEVER_MM: f64 = 30.0;
/// Balls nearer than this to a bar's length from the line count as h = 0, mm: places are stated to the nanometre.
pub(crate) const SAME_LENGTH_MM: f64 = 5e-6;

/// A spindle ball and a pivot of which the swept axis carries one, by index.
pub(crate) struct Pairing {
    pub place: usize,
    pub site: usize,
    /// The axis carries the spindle ball.
    pub on_tool: bool,
}

/// Balls that may be paired for the sweep of an axis.
pub(crate) fn pairings(all: &Candidates, chain: &Chain, axis: usize, offer: Offer) -> Vec<Pairing> {
    let mut list = Vec::new();
    for (place_index, place) in all.places.iter().enumerate() {
        let on_tool = chain.carries(axis, place.link);
        if !on_tool && place.aside_mm > 0.0 && offer != Offer::Common {
            // a fixture brings nothing when the axis does not carry it
            continue;
        }
        for (site_index, site) in all.sites.iter().enumerate() {
            // a pivot that stands still may stand anywhere: every third place is enough
            let is_taken = match offer {
                Offer::Common | Offer::Near => true,
                Offer::Level if stands_on_line(chain, axis, site) => true,
                Offer::Level | Offer::Spread => !on_tool || site_index % 3 == place_index % 3,
            };
            if chain.carries(axis, site.link) != on_tool && is_taken {
                list.push(Pairing { place: place_index, site: site_index, on_tool });
            }
        }
    }
    list
}

/// A pivot on the line of an axis with all axes at zero: methods of the thesis set it there, and no slide has to move far.
pub(crate) fn stands_on_line(chain: &Chain, axis: usize, site: &PivotSite) -> bool {
    let joint = chain.joint(axis);
    (site.at - joint.origin).cross(&joint.direction).norm() < SAME_LENGTH_MM
}

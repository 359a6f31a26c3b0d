//! The row of figures at the head of a page; it computes none of them.

use std::fmt::Write;

/// A figure with what it is and what it means.
pub struct Card {
    pub label: &'static str,
    pub figure: String,
    pub note: String,
}

/// Appends a row of cards to a page. Labels, figures and notes are markup already.
pub fn cards(page: &mut String, cards: &[Card]) {
    page.push_str("<section class=\"cards\">\n");
    for Card { label, figure, note } in cards {
        let _ = writeln!(
            page,
            "<div class=\"card\"><span class=\"label\">{label}</span><span class=\"figure\">{figure}</span><span class=\"note\">{note}</span></div>"
        );
    }
    page.push_str("</section>\n");
}

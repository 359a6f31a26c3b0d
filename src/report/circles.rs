//! Figures of planar circles as a terminal table; their JSON is their own serialisation. Computes nothing.

use crate::methods::{AxisReversals, CircleFigures, DirectionFigures};
use crate::report::wording::table::Table;

/// All circles of a session: ISO 230-4 figures, parts, reversals. Empty without circles.
pub fn circles_text(circles: &[CircleFigures]) -> String {
    if circles.is_empty() {
        return String::new();
    }
    let mut figures = Table::new(&[
        "plane",
        "feed",
        "arc",
        "G ccw",
        "G cw",
        "G(b)",
        "H",
        "F ccw max",
        "F ccw min",
        "F cw max",
        "F cw min",
        "D",
    ]);
    let mut parts =
        Table::new(&["plane", "feed", "centre µm", "", "radius µm", "squareness", "", "scale mismatch", "", "rms µm"]);
    let mut reversals =
        Table::new(&["plane", "feed", "axis", "backlash µm", "half gap µm", "end", "step µm", "spike µm"]);
    for circle in circles {
        let feed = circle.feed_mm_per_min.map_or("–".into(), |feed| format!("{feed:.0}"));
        let of = |direction: &Option<DirectionFigures>, figure: fn(&DirectionFigures) -> Option<f64>| {
            optional(direction.as_ref().and_then(figure))
        };
        figures.row(vec![
            circle.plane.clone(),
            feed.clone(),
            format!("{:.0}°", circle.arc_deg),
            of(&circle.ccw, |figures| Some(figures.circular_deviation_um)),
            of(&circle.cw, |figures| Some(figures.circular_deviation_um)),
            optional(circle.bidirectional_circular_deviation_um),
            optional(circle.circular_hysteresis_um),
            of(&circle.ccw, |figures| figures.radial_deviation_max_um),
            of(&circle.ccw, |figures| figures.radial_deviation_min_um),
            of(&circle.cw, |figures| figures.radial_deviation_max_um),
            of(&circle.cw, |figures| figures.radial_deviation_min_um),
            optional(circle.mean_bidirectional_radial_deviation_um),
        ]);
        parts.row(vec![
            circle.plane.clone(),
            feed.clone(),
            format!("{:+.2}", circle.centre_um[0]),
            format!("{:+.2}", circle.centre_um[1]),
            circle.radius_deviation_um.map_or("–".into(), |radius| format!("{radius:+.2}")),
            format!("{:+.1} µm/m", circle.squareness.angle_um_per_m),
            format!("{} {:+.2} arcsec", circle.squareness.location_error, circle.squareness.location_error_arcsec),
            format!("{:+.2} µm", circle.scale_mismatch_um),
            format!("{:+.1} ppm", circle.scale_mismatch_ppm),
            format!("{:.2}", circle.rms_um),
        ]);
        for axis in &circle.axes {
            add_reversals(&mut reversals, circle, &feed, axis);
        }
    }
    format!(
        "\nPlanar circles, ISO 230-4, µm (F about the fitted centre for a full turn, as set up for a shorter arc)\n{}\n\
         parts of the paths (squareness: angle between the positive directions beyond 90°)\n{}\n\
         reversals (step and spike: outward is positive)\n{}",
        figures.text(),
        parts.text(),
        reversals.text()
    )
}

fn add_reversals(table: &mut Table, circle: &CircleFigures, feed: &str, axis: &AxisReversals) {
    for (index, end) in axis.ends.iter().enumerate() {
        let once = |text: String| if index == 0 { text } else { String::new() };
        table.row(vec![
            once(circle.plane.clone()),
            once(feed.to_string()),
            once(axis.axis.clone()),
            once(optional(axis.backlash_um)),
            once(optional(axis.half_gap_um)),
            end.end.clone(),
            format!("{:+.2}", end.step_um),
            format!("{:+.2}", end.spike_um),
        ]);
    }
}

fn optional(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| format!("{value:.2}"))
}

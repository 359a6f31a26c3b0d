//! Errors over the work volume as tables, JSON, CSV and a page with maps. It computes no poses.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::machine::{AxisKind, Machine};
use crate::report::pictures::cards::{Card, cards};
use crate::report::wording::markup::{escape, machine_head};
use crate::report::wording::table::Table;
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};
use crate::volume::{Cause, Figures, Part, PoseError, Share, Spread};

/// What is reported.
pub struct VolumeReport<'a> {
    pub machine: &'a Machine,
    pub part: Option<Part>,
    pub figures: Figures,
    pub causes: Vec<Cause>,
    /// By the fit that the errors come from.
    pub spread: Option<Spread>,
    pub poses: &'a [Vec<f64>],
    pub errors: &'a [PoseError],
}

/// Rows of a set of figures: name, unit, factor to the unit, values.
fn rows(figures: &Figures) -> [(&'static str, &'static str, f64, Share); 3] {
    [
        ("position", "µm", UM_PER_MM, figures.position_mm),
        ("position, zero taken on the part", "µm", UM_PER_MM, figures.zeroed_mm),
        ("direction", "arcsec", ARCSEC_PER_RAD, figures.direction_rad),
    ]
}

/// As text.
pub fn volume_text(report: &VolumeReport) -> String {
    let over = match &report.part {
        None => "the travel of all axes".to_string(),
        Some(part) => format!("a part from ({}) to ({}) mm", corner(&part.low), corner(&part.high)),
    };
    let mut text =
        format!("{}: tool tip in the workpiece over {over}, {} poses\n\n", report.machine.name, report.poses.len());
    let mut table = Table::new(&["error", "mean", "95 %", "largest", "unit"]);
    for (k, (name, unit, factor, share)) in rows(&report.figures).into_iter().enumerate() {
        let sigma = report.spread.as_ref().map(|spread| rows(&spread.sigma)[k].3);
        let cell = |value: f64, sigma: Option<f64>| match sigma {
            None => format!("{:.1}", value * factor),
            Some(sigma) => format!("{:.1} ± {:.1}", value * factor, sigma * factor),
        };
        table.row(vec![
            name.into(),
            cell(share.mean, sigma.map(|sigma| sigma.mean)),
            cell(share.p95, sigma.map(|sigma| sigma.p95)),
            cell(share.largest, sigma.map(|sigma| sigma.largest)),
            unit.into(),
        ]);
    }
    text.push_str(&table.text());
    text.push_str("\nThe largest is that of the sampled poses: between them it may be more.\n");
    if let Some(spread) = &report.spread {
        let _ = writeln!(
            text,
            "\nThe fit knows these errors to {:.1} µm and {:.1} arcsec at the tip (95 % of poses): a correction by it leaves that much.",
            spread.left.position_mm.p95 * UM_PER_MM,
            spread.left.direction_rad.p95 * ARCSEC_PER_RAD
        );
    }
    text.push_str("\nEach error alone:\n");
    let mut table =
        Table::new(&["error", "value", "unit", "position mean µm", "95 %", "largest", "direction 95 % arcsec"]);
    for cause in &report.causes {
        let (value, unit) = match cause.value {
            Some(value) => (format!("{:.2}", cause.component.measure().to_output(value)), unit_of(cause)),
            None => (String::new(), "over position".into()),
        };
        let um = |value: f64| format!("{:.1}", value * UM_PER_MM);
        let position = &cause.figures.position_mm;
        table.row(vec![
            cause.name.clone(),
            value,
            unit,
            um(position.mean),
            um(position.p95),
            um(position.largest),
            format!("{:.1}", cause.figures.direction_rad.p95 * ARCSEC_PER_RAD),
        ]);
    }
    text.push_str(&table.text());
    text
}

fn unit_of(cause: &Cause) -> String {
    if cause.component.is_angle() { "arcsec".into() } else { "µm".into() }
}

fn corner(at: &nalgebra::Vector3<f64>) -> String {
    format!("{}, {}, {}", at.x, at.y, at.z)
}

fn share_json(share: &Share, factor: f64) -> Value {
    json!({ "mean": share.mean * factor, "p95": share.p95 * factor, "largest": share.largest * factor })
}

fn figures_json(figures: &Figures) -> Value {
    json!({
        "position_um": share_json(&figures.position_mm, UM_PER_MM),
        "position_zeroed_um": share_json(&figures.zeroed_mm, UM_PER_MM),
        "direction_arcsec": share_json(&figures.direction_rad, ARCSEC_PER_RAD),
    })
}

/// As JSON.
pub fn volume_json(report: &VolumeReport) -> Value {
    let causes: Vec<Value> = report
        .causes
        .iter()
        .map(|cause| {
            let unit = if cause.component.is_angle() { "arcsec" } else { "um" };
            json!({
                "error": cause.name,
                "axis": report.machine.axes[cause.axis].name,
                "value": cause.value.map(|value| cause.component.measure().to_output(value)),
                "unit": unit,
                "alone": figures_json(&cause.figures),
            })
        })
        .collect();
    json!({
        "machine": report.machine.name,
        "part_mm": report.part.as_ref().map(|part| [part.low.as_slice(), part.high.as_slice()]),
        "poses": report.poses.len(),
        "figures": figures_json(&report.figures),
        "sigma": report.spread.as_ref().map(|spread| figures_json(&spread.sigma)),
        "left_by_the_fit": report.spread.as_ref().map(|spread| figures_json(&spread.left)),
        "causes": causes,
    })
}

/// Every pose: positions, tip, error.
pub fn volume_csv(report: &VolumeReport) -> String {
    let mut text = String::new();
    for axis in &report.machine.axes {
        let _ = write!(text, "{}_{},", axis.name, axis.kind.position_unit());
    }
    text.push_str("tip_x_mm,tip_y_mm,tip_z_mm,error_x_um,error_y_um,error_z_um,direction_arcsec\n");
    for (pose, error) in report.poses.iter().zip(report.errors) {
        for (axis, &q) in report.machine.axes.iter().zip(pose) {
            let _ = write!(text, "{:.4},", axis.kind.to_file_unit(q));
        }
        let (tip, off) = (error.tip_mm, error.off_mm * UM_PER_MM);
        let _ = writeln!(
            text,
            "{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}",
            tip.x,
            tip.y,
            tip.z,
            off.x,
            off.y,
            off.z,
            error.turned_rad * ARCSEC_PER_RAD
        );
    }
    text
}

/// Cells of a map along each side.
const CELLS: usize = 24;

/// One map: mean position error over two coordinates of the poses.
struct Map {
    title: String,
    across: (String, f64, f64),
    up: (String, f64, f64),
    /// Mean error by cell, row by row from below, µm; `None` where no pose lies.
    cells: Vec<Option<f64>>,
}

/// Maps over the slides (or over the part) and over the rotary axes.
fn maps(report: &VolumeReport) -> Vec<Map> {
    let machine = report.machine;
    let of_kind = |kind| (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == kind).collect::<Vec<usize>>();
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    match report.part {
        Some(_) => {
            for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
                columns.push((
                    format!("{name} on the part, mm"),
                    report.errors.iter().map(|error| error.tip_mm[k]).collect(),
                ));
            }
        }
        None => {
            for axis in of_kind(AxisKind::Linear) {
                columns.push((
                    format!("{} mm", machine.axes[axis].name),
                    report.poses.iter().map(|pose| pose[axis]).collect(),
                ));
            }
        }
    }
    let slides = columns.len();
    for axis in of_kind(AxisKind::Rotary) {
        let degrees = report.poses.iter().map(|pose| pose[axis].to_degrees()).collect();
        columns.push((format!("{} deg", machine.axes[axis].name), degrees));
    }
    let within = |from: usize, to: usize| (from..to).flat_map(move |a| (a + 1..to).map(move |b| (a, b)));
    within(0, slides)
        .chain(within(slides, columns.len()))
        .map(|(a, b)| map(report.errors, &columns[a], &columns[b]))
        .collect()
}

fn map(errors: &[PoseError], across: &(String, Vec<f64>), up: &(String, Vec<f64>)) -> Map {
    let ends = |values: &[f64]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low, high.max(low + 1e-9))
    };
    let ((left, right), (below, above)) = (ends(&across.1), ends(&up.1));
    let mut sums = vec![(0.0, 0usize); CELLS * CELLS];
    let cell =
        |value: f64, low: f64, high: f64| (((value - low) / (high - low) * CELLS as f64) as usize).min(CELLS - 1);
    for ((error, &x), &y) in errors.iter().zip(&across.1).zip(&up.1) {
        let sum = &mut sums[cell(y, below, above) * CELLS + cell(x, left, right)];
        sum.0 += error.off_mm.norm() * UM_PER_MM;
        sum.1 += 1;
    }
    let name = |label: &str| label.split([',', ' ']).next().unwrap_or_default().to_string();
    Map {
        title: format!("{} and {}", name(&across.0), name(&up.0)),
        across: (across.0.clone(), left, right),
        up: (up.0.clone(), below, above),
        cells: sums.iter().map(|&(sum, count)| (count > 0).then(|| sum / count as f64)).collect(),
    }
}

/// Colour of a share of the largest error: light to dark, readable on light and dark pages.
fn colour(share: f64) -> String {
    let share = share.clamp(0.0, 1.0);
    format!("hsl({:.0} 75% {:.0}%)", 225.0 - 205.0 * share, 88.0 - 42.0 * share)
}

/// A map as SVG; `largest` is the error of full colour, µm.
fn map_svg(map: &Map, largest: f64) -> String {
    let (left, top, side) = (58.0, 10.0, 300.0);
    let cell = side / CELLS as f64;
    let mut svg =
        format!("<svg viewBox=\"0 0 430 360\" role=\"img\" aria-label=\"Mean position error over {}\">", map.title);
    for (index, value) in map.cells.iter().enumerate() {
        let Some(value) = value else { continue };
        let (row, column) = (index / CELLS, index % CELLS);
        let _ = write!(
            svg,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{w:.2}\" height=\"{w:.2}\" fill=\"{}\"><title>{value:.1} µm</title></rect>",
            left + column as f64 * cell,
            top + side - (row + 1) as f64 * cell,
            colour(value / largest),
            w = cell + 0.3
        );
    }
    // what the colours mean, from below
    let scale = left + side + 12.0;
    for row in 0..CELLS {
        let _ = write!(
            svg,
            "<rect x=\"{scale}\" y=\"{:.2}\" width=\"12\" height=\"{:.2}\" fill=\"{}\"/>",
            top + side - (row + 1) as f64 * cell,
            cell + 0.3,
            colour((row as f64 + 0.5) / CELLS as f64)
        );
    }
    let (bottom, middle) = (top + side, left + 0.5 * side);
    let label = |x: f64, y: f64, anchor: &str, text: &str| {
        format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"12\" fill=\"currentColor\">{text}</text>"
        )
    };
    svg.push_str(&label(scale + 18.0, bottom, "start", "0"));
    svg.push_str(&label(scale + 18.0, top + 0.5 * side, "start", &format!("{:.1}", 0.5 * largest)));
    svg.push_str(&label(scale + 18.0, top + 10.0, "start", &format!("{largest:.1}")));
    svg.push_str(&label(left, bottom + 16.0, "start", &format!("{:.0}", map.across.1)));
    svg.push_str(&label(left + side, bottom + 16.0, "end", &format!("{:.0}", map.across.2)));
    svg.push_str(&label(middle, bottom + 32.0, "middle", &map.across.0));
    svg.push_str(&label(left - 6.0, bottom, "end", &format!("{:.0}", map.up.1)));
    svg.push_str(&label(left - 6.0, top + 10.0, "end", &format!("{:.0}", map.up.2)));
    let _ = write!(
        svg,
        "<text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\" font-size=\"12\" fill=\"currentColor\">{}</text></svg>",
        top + 0.5 * side,
        map.up.0
    );
    svg
}

/// The page.
pub fn volume_page(report: &VolumeReport) -> String {
    let says = format!("Tool tip in the workpiece, {} poses", report.poses.len());
    let mut page = machine_head("Work volume", "Volume", &report.machine.name, &says);
    let figures = rows(&report.figures);
    let heads: Vec<Card> = ["Position error", "after the zero is taken", "Direction error"]
        .into_iter()
        .zip(&figures)
        .map(|(label, (_, unit, factor, share))| Card {
            label,
            figure: format!("{:.1} {unit}", share.p95 * factor),
            note: format!("in 95 % of poses; mean {:.1}, largest {:.1}", share.mean * factor, share.largest * factor),
        })
        .collect();
    cards(&mut page, &heads);
    page.push_str("<h2>Where</h2><p class=\"small\">Mean position error over the other axes; one scale for all maps.</p><div class=\"tests\">\n");
    let maps = maps(report);
    let largest = maps.iter().flat_map(|map| map.cells.iter().flatten()).copied().fold(1e-3, f64::max);
    for map in &maps {
        let _ = writeln!(
            page,
            "<figure>{}<figcaption>{}, 0 to {largest:.1} µm</figcaption></figure>",
            map_svg(map, largest),
            map.title
        );
    }
    page.push_str("</div>\n<h2>Each error alone</h2><div class=\"wide\"><table><thead><tr><th>error</th><th class=\"n\">value</th><th class=\"n\">position mean µm</th><th class=\"n\">95 %</th><th class=\"n\">largest</th><th class=\"n\">direction 95 % arcsec</th></tr></thead><tbody>\n");
    for cause in &report.causes {
        let value = cause.value.map_or("over position".to_string(), |value| {
            format!("{:.2} {}", cause.component.measure().to_output(value), unit_of(cause))
        });
        let position = cause.figures.position_mm;
        let _ = writeln!(
            page,
            "<tr><th>{}</th><td class=\"n\">{value}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td><td class=\"n\">{:.1}</td></tr>",
            escape(&cause.name),
            position.mean * UM_PER_MM,
            position.p95 * UM_PER_MM,
            position.largest * UM_PER_MM,
            cause.figures.direction_rad.p95 * ARCSEC_PER_RAD
        );
    }
    page.push_str("</tbody></table></div>\n");
    if let Some(spread) = &report.spread {
        let _ = writeln!(
            page,
            "<p>The fit knows these errors to {:.1} µm and {:.1} arcsec at the tip in 95 % of poses: a correction by it leaves that much.</p>",
            spread.left.position_mm.p95 * UM_PER_MM,
            spread.left.direction_rad.p95 * ARCSEC_PER_RAD
        );
    }
    page.push_str("<footer>fiveaxis volume</footer></main></body></html>\n");
    page
}

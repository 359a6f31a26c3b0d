//! The machine as a drawn chain, workpiece to tool, with the places of findings marked. It knows no geometry.

use std::fmt::Write as _;

use super::diagnosis::FindingJson;
use crate::machine::AxisKind;
use crate::readings::Kind;
use crate::report::wording::markup::escape;
use crate::session::{Session, Test};

/// A box of the drawing.
struct Node {
    /// Place of findings.
    name: String,
    /// What stands in the box.
    label: String,
    note: &'static str,
    x: f64,
    y: f64,
}

const BOX_WIDTH: f64 = 92.0;
const BOX_HEIGHT: f64 = 46.0;
const GAP: f64 = 30.0;
/// Letters that a box holds at the usual size; smaller beyond.
const LONG_LABEL: usize = 9;
const LEFT: f64 = 24.0;
const CHAIN_Y: f64 = 44.0;
const BELOW_Y: f64 = 150.0;
/// Recorder and control stand apart from the bar.
const APART_Y: f64 = 226.0;
const HEIGHT: f64 = 292.0;

/// The chain as SVG; findings are numbered in their order.
pub fn chain_map(session: &Session, findings: &[FindingJson]) -> String {
    let machine = &session.machine;
    let (nodes, width) = nodes(session, findings);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {HEIGHT}\" width=\"{width}\" height=\"{HEIGHT}\" role=\"img\" \
         class=\"map\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\" fill=\"#1c2128\">\n<title>Chain of {}</title>\n\
         <style>@media (prefers-color-scheme: dark){{.map{{fill:#e6e9ee}}.map-ground{{fill:#14181f}}.map-line{{stroke:#e6e9ee}}\
         .map-box{{fill:#1c222b;stroke:#a3adb8}}.map-hit{{fill:#4a1d22;stroke:#ff8087}}.map-badge{{fill:#ff8087}}.map-number{{fill:#14181f}}}}</style>\n\
         <rect class=\"map-ground\" width=\"{width}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n",
        escape(&machine.name)
    );
    let place = |name: &str| nodes.iter().find(|node| node.name == name);
    svg.push_str("<g class=\"map-line\" stroke=\"#1c2128\" stroke-width=\"2\" stroke-opacity=\"0.55\">\n");
    let chain: Vec<&Node> = nodes.iter().filter(|node| node.y == CHAIN_Y).collect();
    for pair in chain.windows(2) {
        line(&mut svg, (pair[0].x + BOX_WIDTH, middle(pair[0])), (pair[1].x, middle(pair[1])), "");
    }
    let ends = [(chain.first(), "pivot"), (chain.last(), "spindle-ball")];
    for (end, ball) in ends {
        if let (Some(end), Some(ball)) = (end, place(ball)) {
            line(&mut svg, (end.x + BOX_WIDTH / 2.0, end.y + BOX_HEIGHT), (ball.x + BOX_WIDTH / 2.0, ball.y), "");
        }
    }
    if let (Some(pivot), Some(bar), Some(ball)) = (place("pivot"), place("bar"), place("spindle-ball")) {
        line(&mut svg, (pivot.x + BOX_WIDTH, middle(pivot)), (bar.x, middle(bar)), "stroke-dasharray=\"7 4\"");
        line(&mut svg, (bar.x + BOX_WIDTH, middle(bar)), (ball.x, middle(ball)), "stroke-dasharray=\"7 4\"");
    }
    if let (Some(instrument), None, Some(target)) = (place("pivot"), place("bar"), place("spindle-ball")) {
        let (from, to) = ((instrument.x + BOX_WIDTH, middle(instrument)), (target.x, middle(target)));
        line(&mut svg, from, to, "stroke-dasharray=\"2 5\"");
    }
    svg.push_str("</g>\n");
    for node in &nodes {
        draw(&mut svg, node, findings);
    }
    svg.push_str("</svg>\n");
    svg
}

/// What stands at the pivot, at the spindle ball and between them, in the words of what was read; `None`: nothing.
fn read_by(session: &Session) -> (&'static str, &'static str, Option<&'static str>) {
    let kind = |test: &Test| test.reading.part().map_or(Kind::Length, |part| part.kind);
    let all_of = |kinds: &[Kind]| session.tests.iter().all(|test| kinds.contains(&kind(test)));
    match session.tests.is_empty() || session.tests.iter().any(|test| kind(test) == Kind::Length) {
        true => ("pivot", "spindle-ball", Some("bar")),
        false if all_of(&[Kind::SamePoint]) => ("socket", "ball", None),
        false if all_of(&[Kind::Displacement]) => ("sensor", "target", None),
        false => ("instrument", "target", None),
    }
}

fn nodes(session: &Session, findings: &[FindingJson]) -> (Vec<Node>, f64) {
    let machine = &session.machine;
    let note = |name: &str| {
        machine.axis_index(name).map_or("", |axis| match machine.axes[axis].kind {
            AxisKind::Linear => "slides",
            AxisKind::Rotary => "turns",
        })
    };
    let mut names: Vec<(String, &'static str)> = vec![("workpiece".into(), "")];
    names.extend(machine.code.workpiece_side.iter().map(|name| (name.clone(), note(name))));
    names.push(("bed".into(), ""));
    names.extend(machine.code.tool_side.iter().map(|name| (name.clone(), note(name))));
    names.push(("tool".into(), ""));
    let mut nodes: Vec<Node> = names
        .into_iter()
        .enumerate()
        .map(|(k, (name, note))| {
            let label = name.clone();
            Node { name, label, note, x: LEFT + k as f64 * (BOX_WIDTH + GAP), y: CHAIN_Y }
        })
        .collect();
    let right = nodes.last().map_or(LEFT, |node| node.x);
    // the drawing holds five boxes below even for short chains
    let width = (right + BOX_WIDTH + LEFT).max(5.0 * (BOX_WIDTH + GAP) + LEFT);
    let node =
        |name: &str, label: &str, x: f64, y: f64| Node { name: name.into(), label: label.into(), note: "", x, y };
    let (at_pivot, at_spindle, between) = read_by(session);
    let middle = (LEFT + right) / 2.0;
    nodes.push(node("pivot", at_pivot, LEFT, BELOW_Y));
    let is_found = |place: &str| findings.iter().any(|finding| finding.place == place);
    if let Some(label) = between.or(is_found("bar").then_some("bar")) {
        nodes.push(node("bar", label, middle, BELOW_Y));
    }
    nodes.push(node("spindle-ball", at_spindle, right, BELOW_Y));
    nodes.push(node("recorder", "recorder", middle + 0.6 * BOX_WIDTH, APART_Y));
    nodes.push(node("control", "control", middle - 0.6 * BOX_WIDTH, APART_Y));
    (nodes, width)
}

fn middle(node: &Node) -> f64 {
    node.y + BOX_HEIGHT / 2.0
}

fn line(svg: &mut String, from: (f64, f64), to: (f64, f64), style: &str) {
    let _ = writeln!(
        svg,
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" {style}/>",
        from.0, from.1, to.0, to.1
    );
}

fn draw(svg: &mut String, node: &Node, findings: &[FindingJson]) {
    let numbers: Vec<String> = findings
        .iter()
        .enumerate()
        .filter(|(_, finding)| finding.place == node.name)
        .map(|(k, _)| (k + 1).to_string())
        .collect();
    let (class, fill, stroke, width) = if numbers.is_empty() {
        ("map-box", "#f5f7f9", "#5b6470", 1.2)
    } else {
        ("map-hit", "#fbe3e4", "#b3202c", 2.6)
    };
    let _ = writeln!(
        svg,
        "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{BOX_WIDTH}\" height=\"{BOX_HEIGHT}\" rx=\"8\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>",
        node.x, node.y
    );
    let centre = node.x + BOX_WIDTH / 2.0;
    let raised = if node.note.is_empty() { 5.0 } else { -1.0 };
    let _ = writeln!(
        svg,
        "<text x=\"{centre:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-weight=\"600\"{}>{}</text>",
        middle(node) + raised,
        if node.label.len() > LONG_LABEL { " font-size=\"12\"" } else { "" },
        escape(&node.label)
    );
    if !node.note.is_empty() {
        let _ = writeln!(
            svg,
            "<text x=\"{centre:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"11\" fill-opacity=\"0.7\">{}</text>",
            middle(node) + 14.0,
            node.note
        );
    }
    for (k, number) in numbers.iter().enumerate() {
        let x = node.x + BOX_WIDTH - 4.0 - 24.0 * k as f64;
        let _ = writeln!(
            svg,
            "<circle class=\"map-badge\" cx=\"{x:.1}\" cy=\"{0:.1}\" r=\"11\" fill=\"#b3202c\"/><text class=\"map-number\" x=\"{x:.1}\" y=\"{1:.1}\" text-anchor=\"middle\" font-size=\"12\" font-weight=\"600\" fill=\"#ffffff\">{number}</text>",
            node.y,
            node.y + 4.0
        );
    }
}

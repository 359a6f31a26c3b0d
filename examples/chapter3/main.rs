//! Chapter 3 of the thesis behind the tool: what each location error of the rotary axes does to the bar's length in
//! its four steps (Figs 3.7, 3.8, Table 3.1) and what squareness does to a planar circle (Fig. 2.14). No measurement.
//!
//! `cargo run --release --example chapter3 -- DIR` writes the figures as SVG and the traces as CSV into DIR.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::load::load_session;
use fiveaxis::machine::ErrorName;
use fiveaxis::report::polar::{PolarPlot, PolarTrace, Stroke, division_um};
use fiveaxis::session::Session;
use fiveaxis::simulate::trace;
use fiveaxis::units::{Measure, UM_PER_MM, parse_quantity};

/// Errors of the thesis's Table 2.1 with the sizes inserted.
const ERRORS: [(&str, &str); 8] = [
    ("EY0A", "10 um"),
    ("EZ0A", "10 um"),
    ("EB0A", "0.01 deg"),
    ("EC0A", "0.01 deg"),
    ("EX0C", "10 um"),
    ("EY0C", "10 um"),
    ("EA0C", "0.01 deg"),
    ("EB0C", "0.01 deg"),
];
/// Steps with the right D = 50√5 mm; in those named "as printed" the spindle ball stands at 50√2 mm.
const STEPS: [(&str, &str); 6] = [
    ("A1", "A turns, short bar"),
    ("A2", "A turns, extended bar"),
    ("A2 as printed", "A turns, extended bar, D = 50√2"),
    ("C1", "C turns, short bar"),
    ("C2", "C turns, extended bar"),
    ("C2 as printed", "C turns, extended bar, D = 50√2"),
];
/// Name, steps and, from and to, the errors shown. The thesis draws the A tests alone and only A's errors.
type Figure = (&'static str, &'static [(&'static str, &'static str)], (usize, usize));
const FIGURES: [Figure; 4] = [
    ("Fig 3.7", STEPS.first_chunk::<1>().unwrap(), (0, 4)),
    ("Fig 3.8", STEPS.split_at(1).1.first_chunk::<2>().unwrap(), (0, 4)),
    ("A tests and errors of C", STEPS.first_chunk::<3>().unwrap(), (4, 8)),
    ("C tests", STEPS.last_chunk::<3>().unwrap(), (0, 8)),
];
/// Below this an error does not show in a step: second-order remainders of the sizes above reach 0.002 µm.
const SHOWS_UM: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "chapter3".into()));
    std::fs::create_dir_all(&folder)?;
    let session = load_session(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/chapter3/session.yaml"))?;
    let mut csv = String::from("step,error,inserted,theta_deg,dL_first_order_um,dL_exact_um\n");
    let mut shows = String::new();
    for (figure, steps, errors) in FIGURES {
        for &(step, what) in steps {
            let errors = &ERRORS[errors.0..errors.1];
            let mut traces = Vec::new();
            for &(name, size) in errors {
                let points = deviations(&session, step, &[(name, size)], Composition::FirstOrder)?;
                let exact = deviations(&session, step, &[(name, size)], Composition::Exact)?;
                for ((theta, first_order), (_, exact)) in points.iter().zip(&exact) {
                    writeln!(csv, "{step},{name},{size},{:.0},{first_order:.6},{exact:.6}", theta.to_degrees())?;
                }
                traces.push(PolarTrace {
                    label: format!("{name} = {}", size.replace("um", "µm").replace(" deg", "°")),
                    points,
                    stroke: Stroke::Own(traces.len()),
                });
            }
            let mut plot = PolarPlot::new(format!("{figure}: {what}"), traces);
            plot.subtitle = "first-order product of the thesis".into();
            let file = format!("{figure} {step}").to_lowercase().replace([' ', '.'], "-");
            std::fs::write(folder.join(format!("{file}.svg")), plot.to_svg())?;
        }
    }
    for (name, size) in ERRORS {
        write!(shows, "{name}  ")?;
        for (step, _) in STEPS {
            write!(shows, "{:>22}", seen(&deviations(&session, step, &[(name, size)], Composition::FirstOrder)?))?;
        }
        shows.push('\n');
    }
    std::fs::write(folder.join("traces.csv"), csv)?;
    std::fs::write(folder.join("fig-2-14.svg"), squareness_figure(&session)?)?;
    println!(
        "Table 3.1's errors, 10 µm and 0.01°: what shows in which step (deviation in µm over the arc; c constant, else it varies)\n"
    );
    print!("{:6}", "");
    STEPS.iter().for_each(|(step, _)| print!("{step:>22}"));
    println!();
    print!("{shows}");
    println!("\nfigures and traces: {}", folder.display());
    Ok(())
}

/// Deviation from the nominal length (µm) over the angle of the moving ball (rad) with the given errors inserted.
fn deviations(
    session: &Session,
    step: &str,
    errors: &[(&str, &str)],
    composition: Composition,
) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let machine = &session.machine;
    let chain = Chain::of(machine);
    let mut values = machine.location_errors();
    for (name, size) in errors {
        let name = ErrorName::parse(name, &machine.axis_names())?;
        let axis = machine.axis_index(&name.axis).ok_or("no such axis")?;
        values[axis][name.component.index()] = parse_quantity(size, name.component.measure())?;
    }
    let test = session.tests.iter().find(|test| test.name == step).ok_or("no such step")?;
    let with_errors = trace(session, &Geometry::new(&chain, &values, composition), test)?;
    let nominal = trace(session, &Geometry::nominal(&chain), test)?;
    let motion = &nominal.motion;
    let angle = |row: usize| match motion.moving[..] {
        [first, second, ..] => motion.row(row)[second].atan2(motion.row(row)[first]),
        _ => motion.row(row)[motion.moving[0]],
    };
    let lengths = with_errors.length_mm.iter().zip(&nominal.length_mm).enumerate();
    Ok(lengths.map(|(row, (length, nominal))| (angle(row), (length - nominal) * UM_PER_MM)).collect())
}

/// Range of a trace for the table.
fn seen(trace: &[(f64, f64)]) -> String {
    let low = trace.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
    let high = trace.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
    match (high.abs().max(low.abs()) > SHOWS_UM, high - low > SHOWS_UM) {
        (false, _) => "–".into(),
        (true, true) => format!("{low:+.2} … {high:+.2}"),
        (true, false) => format!("c {:+.2}", (low + high) / 2.0),
    }
}

/// Fig. 2.14: the planar circle of X and Y with squareness errors of ±0.01°.
fn squareness_figure(session: &Session) -> Result<String, Box<dyn Error>> {
    let mut traces = Vec::new();
    for size in ["0.01 deg", "-0.01 deg"] {
        let points = deviations(session, "XY circle", &[("EC0Y", size)], Composition::Exact)?;
        let label = format!("EC0Y = {}°", size.replace(" deg", ""));
        traces.push(PolarTrace { label, points, stroke: Stroke::Own(traces.len()) });
    }
    let mut plot = PolarPlot::new("Fig. 2.14: squareness of X and Y on a planar circle", traces);
    plot.subtitle = "radius 100 mm · an ellipse along one diagonal".into();
    let amplitude_um = parse_quantity("0.01 deg", Measure::Angle)? * 100.0 / 2.0 * UM_PER_MM;
    plot.division_um = division_um(amplitude_um);
    Ok(plot.to_svg())
}

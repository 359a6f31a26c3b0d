//! `fiveaxis reconcile`: results of several methods on one machine against each other.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::load::load_claim;
use fiveaxis::reconcile::{Limits, Prepared};
use fiveaxis::report::reconciliation::{reconciliation_json, reconciliation_text};
use fiveaxis::units::{Measure, UM_PER_MM, parse_quantity};

use super::Refusal;
use super::output::{print, print_json, settle};
use super::progress::Working;

/// Arguments of `reconcile`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis reconcile examples/thesis/published/chapter4.yaml examples/thesis/published/chapter5.yaml examples/thesis/published/chapter6.yaml"
)]
pub struct Arguments {
    /// Files of results (docs/formats.md): errors with their scatter, the session that is their design, the method
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Limit of the bar's reading over one circle, such as "1 um" (a maker's ± accuracy)
    #[arg(long, value_name = "LENGTH", default_value = "1 um")]
    bar: String,
    /// Limit of the place to which the slides bring the spindle ball
    #[arg(long, value_name = "LENGTH", default_value = "1 um")]
    slides: String,
    /// Limit of the spindle ball's own place in one result
    #[arg(long, value_name = "LENGTH", default_value = "1 um")]
    ball: String,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let mut claims = Vec::new();
    for file in &arguments.files {
        settle(file)?;
        claims.push(load_claim(file)?);
    }
    let limits = Limits {
        bar_um: limit("--bar", &arguments.bar)?,
        slides_um: limit("--slides", &arguments.slides)?,
        ball_um: limit("--ball", &arguments.ball)?,
    };
    let working = Working::on("comparing results".to_string());
    let prepared = Prepared::of(&claims, &limits)?;
    let found = prepared.judge(&prepared.values(&claims));
    drop(working);
    if arguments.json {
        print_json(&reconciliation_json(&claims, &prepared, &found))
    } else {
        print(&reconciliation_text(&claims, &prepared, &found))
    }
}

/// A limit of the command line, µm.
fn limit(option: &str, text: &str) -> Result<f64, Refusal> {
    let size = parse_quantity(text, Measure::Length).map_err(|why| format!("{option} {text}: {why}"))?;
    if !(size > 0.0 && size <= 1.0) {
        return Err(format!("{option} {text}: a limit lies above 0 and up to 1 mm").into());
    }
    Ok(size * UM_PER_MM)
}

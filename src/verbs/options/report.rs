//! `--report DIR` of identify and diagnose: one HTML page, and every plot as an SVG file for papers.

use fiveaxis::diagnose::Diagnosis;
use fiveaxis::identify::Fit;
use fiveaxis::methods::{TestTrace, recorded_passes};
use fiveaxis::report::before_after::{BeforeAfterPlots, TestShown, before_after_plots};
use fiveaxis::report::chain_map::chain_map;
use fiveaxis::report::diagnosis::DiagnosisJson;
use fiveaxis::report::diagnosis_page::diagnosis_page;
use fiveaxis::report::fit::FitJson;
use fiveaxis::report::fit_page::{fit_page, identifier};
use fiveaxis::report::trace_plots::pass_plots;
use fiveaxis::session::Session;

use crate::verbs::Refusal;
use crate::verbs::output::OutputFolder;

/// report.html and plots/*.svg of a fit.
pub fn fit_report(session: &Session, fit: &Fit, json: &FitJson) -> Result<OutputFolder, Refusal> {
    let plots = pass_plots(session, fit, &recorded_passes(session)?);
    let mut output = OutputFolder::default();
    output.add("report.html", fit_page(session, json, fit, &plots));
    for plot in &plots {
        let number = |name: &str| session.tests.iter().position(|test| test.name == name).map_or(0, |index| index + 1);
        // the number keeps names apart that differ only in signs a file name cannot have
        let named = |name: &String| format!("{:02}-{}", number(name), identifier(name));
        if let (Some(round), Some(first)) = (&plot.round, plot.tests.first()) {
            output.add(format!("plots/{}-polar.svg", named(first)), round.as_read.as_str());
            if let Some(centred) = &round.centred {
                output.add(format!("plots/{}-polar-centred.svg", named(first)), centred.as_str());
            }
        }
        for (name, residual) in plot.tests.iter().zip(&plot.residuals) {
            output.add(format!("plots/{}-residual.svg", named(name)), residual.as_str());
        }
    }
    Ok(output)
}

/// The page of a diagnosis, the map of the machine and the residuals of every test.
pub fn diagnosis_report(
    session: &Session,
    diagnosis: &Diagnosis,
    json: &DiagnosisJson,
) -> Result<OutputFolder, Refusal> {
    let passes = recorded_passes(session)?;
    let mut plots: Vec<(usize, BeforeAfterPlots)> = Vec::new();
    for pass in &passes {
        for trace in pass {
            let back = pass.iter().find(|other| other.test != trace.test).map(|other| shown(session, diagnosis, other));
            plots.push((
                trace.test,
                before_after_plots(session, shown(session, diagnosis, trace), back, &json.findings),
            ));
        }
    }
    plots.sort_by_key(|(test, _)| *test);
    let (numbers, plots): (Vec<usize>, Vec<BeforeAfterPlots>) = plots.into_iter().unzip();
    let mut output = OutputFolder::default();
    output.add("report.html", diagnosis_page(session, diagnosis, json, &plots));
    output.add("plots/map.svg", chain_map(session, &json.findings));
    for (index, plot) in numbers.iter().zip(&plots) {
        let name = format!("{:02}-{}", index + 1, identifier(&plot.test));
        if let Some(polar) = &plot.polar {
            output.add(format!("plots/{name}-polar.svg"), polar.as_str());
        }
        output.add(format!("plots/{name}-residual.svg"), plot.unrolled.as_str());
    }
    Ok(output)
}

/// A recorded test as a page of a diagnosis shows it.
fn shown<'a>(session: &'a Session, diagnosis: &'a Diagnosis, trace: &'a TestTrace) -> TestShown<'a> {
    TestShown { test: &session.tests[trace.test], trace, residuals: &diagnosis.tests[trace.test] }
}

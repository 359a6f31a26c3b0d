//! `--report DIR` of identify and diagnose: one HTML page, and every plot as an SVG file for papers.

use fiveaxis::chain::Chain;
use fiveaxis::diagnose::Diagnosis;
use fiveaxis::identify::Fit;
use fiveaxis::methods::{Course, recorded_passes};
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
    let chain = Chain::of(&session.machine);
    let courses: Vec<Course> =
        session.tests.iter().map(|test| Course::of(session, &chain, test)).collect::<Result<_, _>>()?;
    let shown: Vec<TestShown> = (session.tests.iter().zip(&courses).zip(&diagnosis.tests))
        .map(|((test, course), residuals)| TestShown { test, course, residuals })
        .collect();
    let passes = recorded_passes(session)?;
    let back = |test: usize| {
        let pass = passes.iter().find(|pass| pass.iter().any(|one| one.test == test))?;
        pass.iter().map(|one| one.test).find(|other| *other != test).and_then(|other| shown.get(other).copied())
    };
    let plots: Vec<BeforeAfterPlots> = (shown.iter().enumerate())
        .map(|(test, one)| before_after_plots(session, *one, back(test), &json.findings))
        .collect();
    let mut output = OutputFolder::default();
    output.add("report.html", diagnosis_page(session, diagnosis, json, &plots));
    output.add("plots/map.svg", chain_map(session, &json.findings));
    for (index, plot) in plots.iter().enumerate() {
        let name = format!("{:02}-{}", index + 1, identifier(&plot.test));
        if let Some(polar) = &plot.polar {
            output.add(format!("plots/{name}-polar.svg"), polar.as_str());
        }
        output.add(format!("plots/{name}-residual.svg"), plot.unrolled.as_str());
    }
    Ok(output)
}

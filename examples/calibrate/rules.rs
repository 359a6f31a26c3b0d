//! What each number that decides earns: the same sessions diagnosed with one rule after the other out of force.

use super::outcome::Outcome;
use super::score::Answer;
use fiveaxis::diagnose::{Diagnosis, Threshold, Thresholds, diagnose_with, lean};
use fiveaxis::identify::Options;
use fiveaxis::load::{Rows, load_session, load_session_with};
use fiveaxis::report::diagnosis::diagnosis_json;
use std::path::Path;
use std::time::Instant;

/// Diagnoses a session in this process with some thresholds, on one thread.
pub fn diagnosed(place: &Path, thresholds: Thresholds) -> Answer {
    let start = Instant::now();
    let file = place.join("session.yaml");
    let diagnosis = match load_session(&file) {
        Ok(session) => {
            let leaner = lean(&session);
            let searched = leaner.as_ref().map_or(&session, |(searched, _)| searched);
            let diagnosis = diagnose_with(searched, &Options::default(), thresholds);
            diagnosis.map(|diagnosis| (session.machine, diagnosis)).map_err(|e| e.to_string())
        }
        Err(refusal) => load_session_with(&file, Rows::AsRecorded)
            .ok()
            .and_then(|session| Some((session.machine.clone(), Diagnosis::of_implausible(&session)?)))
            .ok_or_else(|| refusal.to_string()),
    };
    let seconds = start.elapsed().as_secs_f64();
    match diagnosis {
        Ok((machine, diagnosis)) => {
            let json = diagnosis_json(&machine, &diagnosis, Vec::new());
            Answer { json: serde_json::to_value(json).ok(), failed: None, seconds }
        }
        Err(message) => Answer { json: None, failed: Some(message), seconds },
    }
}

/// Thresholds by name; all where none is named.
pub fn named(names: &[String]) -> Result<Vec<Threshold>, String> {
    let all = Thresholds::default().list();
    let unknown = names.iter().find(|name| !all.iter().any(|threshold| threshold.name == **name));
    if let Some(name) = unknown {
        let known: Vec<&str> = all.iter().map(|threshold| threshold.name).collect();
        return Err(format!("--rule {name}: not known; choose from {}", known.join(", ")));
    }
    Ok(all
        .into_iter()
        .filter(|threshold| names.is_empty() || names.iter().any(|name| name == threshold.name))
        .collect())
}

/// What counts of a set of sessions.
#[derive(Clone, Copy, PartialEq)]
pub struct Tally {
    pub named: usize,
    pub alarms: usize,
    pub companions: usize,
    pub wrong_claims: usize,
    pub sizes_off: usize,
    pub seconds: f64,
}

impl Tally {
    pub fn of(outcomes: &[Outcome]) -> Self {
        let count = |is: &dyn Fn(&&Outcome) -> bool| outcomes.iter().filter(is).count();
        let claims = outcomes.iter().flat_map(|o| &o.claims);
        Self {
            named: count(&|o| !o.clean && o.visible >= 0.3 && o.in_class),
            alarms: count(&|o| o.alarm),
            companions: count(&|o| o.companion),
            wrong_claims: claims.filter(|c| c.leads && c.probability >= 0.99 && !c.right).count(),
            sizes_off: outcomes.iter().flat_map(|o| &o.sizes).filter(|d| d.sigmas.abs() > 3.0).count(),
            seconds: outcomes.iter().map(|o| o.seconds).sum(),
        }
    }
}

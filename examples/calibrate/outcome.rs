//! What was stated of one session beside what is true of it; counts nothing.

use super::score::{Answer, names, score};
use serde_json::{Value, json};

/// A cause with the probability stated for it.
pub struct Claim {
    pub probability: f64,
    pub right: bool,
    /// First of its finding, not one of those that cannot be told from it.
    pub leads: bool,
    /// Which finding of its session, and the cause that is claimed.
    pub finding: usize,
    pub cause: String,
    /// What held-out readings said of its finding: `passed`, `failed`, `single occurrence`; `none` without a proof.
    pub proof: String,
}

/// A stated number against the true one.
pub struct Deviation {
    pub what: String,
    /// Difference, in stated sigmas.
    pub sigmas: f64,
    pub sigma: f64,
    pub real: f64,
}

pub struct Outcome {
    pub seed: u64,
    pub trial: u64,
    pub effect: String,
    pub visible: f64,
    pub clean: bool,
    pub two: bool,
    /// The cause is none of the catalogue.
    pub stranger: bool,
    pub fault: bool,
    pub noise_family: String,
    pub stated: String,
    pub in_class: bool,
    pub alarm: bool,
    pub companion: bool,
    pub claims: Vec<Claim>,
    pub sizes: Vec<Deviation>,
    pub location: Vec<Deviation>,
    pub seconds: f64,
    pub failed: bool,
}

/// Sizes that are compared belong to causes at least so visible, in noises.
const SEEN: f64 = 0.3;

impl Outcome {
    pub fn of(seed: u64, truth: &Value, answer: &Answer) -> Self {
        let s = score(truth, answer);
        let none = vec![];
        let effects = truth["effects"].as_array().unwrap_or(&none);
        let json = answer.json.as_ref();
        let findings = json.and_then(|j| j["findings"].as_array()).unwrap_or(&none);
        Self {
            seed,
            trial: truth["trial"].as_u64().unwrap_or(0),
            noise_family: truth["noise"]["family"].as_str().unwrap_or("").to_string(),
            claims: findings.iter().enumerate().flat_map(|(k, f)| claims(effects, k, f)).collect(),
            sizes: if s.fault { vec![] } else { sizes(effects, findings) },
            location: if s.fault { vec![] } else { location(truth, json) },
            effect: s.effect,
            visible: s.visible,
            clean: s.clean,
            two: s.two,
            stranger: s.stranger,
            fault: s.fault,
            stated: s.stated,
            in_class: s.in_class,
            alarm: s.false_alarm,
            companion: s.wrong_companion,
            seconds: s.seconds,
            failed: s.failed.is_some(),
        }
    }

    pub fn line(&self) -> String {
        let mark =
            if self.alarm || self.companion || self.failed || (!self.clean && self.visible >= SEEN && !self.in_class) {
                "✗"
            } else {
                "✓"
            };
        let (seed, trial) = (self.seed, self.trial);
        format!("{seed}/{trial} {} {:.2}× → {} {mark} ({:.1} s)", self.effect, self.visible, self.stated, self.seconds)
    }

    pub fn json(&self) -> Value {
        let deviations = |list: &[Deviation]| -> Vec<Value> {
            list.iter().map(|d| json!([d.what, d.sigmas, d.sigma, d.real])).collect()
        };
        let claims: Vec<Value> =
            self.claims.iter().map(|c| json!([c.probability, c.right, c.leads, c.proof, c.finding, c.cause])).collect();
        json!({"seed": self.seed, "trial": self.trial, "effect": self.effect, "visible": self.visible, "clean": self.clean,
            "two": self.two, "stranger": self.stranger, "fault": self.fault, "noise": self.noise_family,
            "stated": self.stated, "in_class": self.in_class, "alarm": self.alarm, "companion": self.companion,
            "claims": claims, "sizes": deviations(&self.sizes), "location": deviations(&self.location),
            "seconds": self.seconds, "failed": self.failed})
    }
}

/// What was claimed of a finding: each effect at a place once, with the sum of what was stated of its components. It is right
/// where one of these is.
fn claims(effects: &[Value], number: usize, finding: &Value) -> Vec<Claim> {
    let others = finding["cannot_tell_from"].as_array().map(Vec::as_slice).unwrap_or_default();
    let proof = finding["cross_validated"].as_str().unwrap_or("none");
    let mut claims: Vec<((&Value, &Value), Claim)> = vec![];
    for (i, stated) in std::iter::once(finding).chain(others).enumerate() {
        let Some(probability) = stated["probability"].as_f64() else { continue };
        let what = (&stated["effect"], &stated["place"]);
        let right = effects.iter().any(|e| names(e, stated));
        match claims.iter_mut().find(|(known, _)| *known == what) {
            Some((_, known)) => {
                known.probability += probability;
                known.right |= right;
            }
            None => {
                let cause = format!("{}@{}", what.0.as_str().unwrap_or(""), what.1.as_str().unwrap_or(""));
                let (leads, proof) = (i == 0, proof.to_string());
                claims.push((what, Claim { probability, right, leads, finding: number, cause, proof }));
            }
        }
    }
    claims.into_iter().map(|(_, claim)| claim).collect()
}

/// Sizes of causes that were named; those of the other kind of number are not compared.
fn sizes(effects: &[Value], findings: &[Value]) -> Vec<Deviation> {
    effects
        .iter()
        .filter(|e| e["visible_over_noise"].as_f64().is_some_and(|v| v >= SEEN) && e["effect"] != "unknown")
        .filter_map(|e| {
            let finding = findings.iter().find(|f| names(e, f))?;
            let size = &finding["size"];
            // over part of a turn an error motion is told by what the travel shows of it
            let part = match size["meaning"].as_str() {
                Some(meaning) if meaning.starts_with("half the range") => {
                    e["params"]["half_range_over_travel"].as_f64().unwrap_or(1.0)
                }
                _ => 1.0,
            };
            let real = part * e["size"].as_f64()?;
            if e["unit"] != size["unit"] {
                return None;
            }
            let sigma = size["sigma"].as_f64().filter(|s| *s > 0.0)?;
            let off = size["value"].as_f64()?.abs() - real.abs();
            Some(Deviation { what: e["id"].as_str().unwrap_or("").to_string(), sigmas: off / sigma, sigma, real })
        })
        .collect()
}

/// Location errors that are said to be determined.
fn location(truth: &Value, json: Option<&Value>) -> Vec<Deviation> {
    let Some(stated) = json.and_then(|j| j["location_errors"].as_object()) else {
        return vec![];
    };
    stated
        .iter()
        .filter(|(_, value)| value["determined"] == true)
        .filter_map(|(name, value)| {
            let real = truth["pige"][name].as_f64()?;
            let sigma = value["sigma"].as_f64().filter(|s| *s > 0.0)?;
            Some(Deviation { what: name.clone(), sigmas: (value["after"].as_f64()? - real) / sigma, sigma, real })
        })
        .collect()
}

//! A diagnosis as JSON, the documented contract. Text and page are made from it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cause_title::what;
use super::shape_words::shape_words;
use crate::diagnose::{
    Cause, DataFault, Diagnosis, FaultKind, Finding, LeftOutSetup, MOST_RIVALS, Rival, ShareOfReadings,
    SignRandomisation, Source, Unseen,
};
use crate::machine::Machine;
use crate::methods::CircleFigures;

/// `fiveaxis diagnose --json`.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnosisJson {
    pub verdict: &'static str,
    /// Why the readings cannot be judged; null else.
    pub reason: Option<String>,
    /// What to look at whatever the verdict is.
    pub warnings: Vec<String>,
    pub findings: Vec<FindingJson>,
    pub blind_to: Vec<BlindJson>,
    /// Short tests that would show most of that, best first.
    pub uncovered_by: Vec<UncoveringJson>,
    /// What the readings are made of, the largest part first.
    pub shares: Vec<ShareJson>,
    pub fit: FitBeforeAfterJson,
    pub location_errors: BTreeMap<String, MovedJson>,
    /// ISO 230-4 figures of the planar circles, as `identify` gives them.
    pub circles: Vec<CircleFigures>,
}

/// One finding.
#[derive(Debug, Clone, Serialize)]
pub struct FindingJson {
    /// The mistake in the files that it is; `None` for physics.
    #[serde(skip)]
    pub fault: Option<FaultKind>,
    pub effect: String,
    pub driver: &'static str,
    pub place: String,
    pub components: Vec<String>,
    pub size: SizeJson,
    /// Where on the axis, how often, how fast, driven by what, in words; null where there is nothing to say.
    pub shape: Option<String>,
    #[serde(rename = "where")]
    pub located: WhereJson,
    pub probability: f64,
    pub cross_validated: Option<&'static str>,
    /// Null where motion does not drive it or too few runs show it.
    pub placebo: Option<PlaceboJson>,
    /// Null where fewer than two setups show it, or nothing of it carries over.
    pub other_setups: Option<OtherSetupsJson>,
    pub cannot_tell_from: Vec<RivalJson>,
    pub next_test: Option<NextTestJson>,
}

/// Gain of a finding with the sense of motion drawn at random, as shares of its true gain.
#[derive(Debug, Clone, Serialize)]
pub struct PlaceboJson {
    pub mean: f64,
    pub largest: f64,
    pub draws: usize,
}

/// How the readings at places of the balls left out in turn follow what the others predict.
#[derive(Debug, Clone, Serialize)]
pub struct OtherSetupsJson {
    pub slope: f64,
    pub sigma: f64,
    pub setups: usize,
    /// Whether the slope is 1 within 0.3 or three sigmas.
    pub carries: bool,
}

/// Size with its unit.
#[derive(Debug, Clone, Serialize)]
pub struct SizeJson {
    pub value: Option<f64>,
    /// `None` where there is no number.
    pub unit: Option<&'static str>,
    pub sigma: Option<f64>,
    pub meaning: String,
}

/// Where a finding shows.
#[derive(Debug, Clone, Serialize)]
pub struct WhereJson {
    pub tests: Vec<String>,
    pub range: Option<RangeJson>,
}

/// Range along an axis or in time.
#[derive(Debug, Clone, Serialize)]
pub struct RangeJson {
    pub axis: String,
    pub from: f64,
    pub to: f64,
}

/// A cause that these recordings cannot exclude.
#[derive(Debug, Clone, Serialize)]
pub struct RivalJson {
    pub effect: String,
    pub driver: &'static str,
    pub place: String,
    pub components: Vec<String>,
    pub probability: f64,
    /// What is wrong and what to do, of a mistake in the files; null for physics.
    pub says: Option<String>,
}

/// Test that would separate a finding from its rivals.
#[derive(Debug, Clone, Serialize)]
pub struct NextTestJson {
    pub says: String,
    pub odds_after: f64,
}

/// What the recordings cannot show.
#[derive(Debug, Clone, Serialize)]
pub struct BlindJson {
    pub effect: String,
    pub place: String,
    pub components: Vec<String>,
    pub smallest_visible: SmallestJson,
    pub test: String,
}

/// Part of the readings that one cause makes.
#[derive(Debug, Clone, Serialize)]
pub struct ShareJson {
    pub name: String,
    /// `location error`, `setup`, `finding`, `other` or `rest`.
    pub kind: &'static str,
    pub rms_um: f64,
    pub share: f64,
}

/// A test with what is mounted, the time it takes, and what it would show by place in `blind_to`.
#[derive(Debug, Clone, Serialize)]
pub struct UncoveringJson {
    pub says: String,
    pub minutes: f64,
    pub uncovers: Vec<usize>,
}

/// Smallest visible size; null when no size shows.
#[derive(Debug, Clone, Serialize)]
pub struct SmallestJson {
    pub value: Option<f64>,
    pub unit: &'static str,
}

/// Fit before and after.
#[derive(Debug, Clone, Serialize)]
pub struct FitBeforeAfterJson {
    /// Readings, and how many of them were left out as gross outliers, with their share.
    pub readings: usize,
    pub left_out: usize,
    pub left_out_share: f64,
    /// Null where nothing could be fitted.
    pub rms_before_um: f64,
    pub rms_after_um: f64,
    /// Null for static poses without readings to spare, and where nothing could be fitted.
    pub noise_um: Option<f64>,
    pub heldout_before_um: Option<f64>,
    pub heldout_after_um: Option<f64>,
    /// What is left of static poses; null for sweeps.
    pub left: Option<LeftJson>,
}

/// What stays unexplained of static poses.
#[derive(Debug, Clone, Serialize)]
pub struct LeftJson {
    /// Share of the mean square before.
    pub share: f64,
    /// Rms of what the readings of a pose share: the arm stands elsewhere.
    pub arm_um: f64,
    /// Rms of what every reading has for itself.
    pub readings_um: f64,
}

/// A location error before and after.
#[derive(Debug, Clone, Serialize)]
pub struct MovedJson {
    pub before: f64,
    pub after: f64,
    pub sigma: f64,
    /// Without what unseen causes may have moved.
    pub seen_sigma: f64,
    pub unit: &'static str,
    pub determined: bool,
    /// Unseen causes that may have moved it by more than `seen_sigma`, the largest first.
    pub hangs_on: Vec<HangsOnJson>,
}

/// An unseen cause that moves a location error.
#[derive(Debug, Clone, Serialize)]
pub struct HangsOnJson {
    /// Its place in `blind_to`.
    pub blind_to: usize,
    /// Shift of the location error by one unit of the cause.
    pub per_unit: f64,
}

/// The JSON value of a diagnosis of a machine, with the figures of its planar circles.
pub fn diagnosis_json(machine: &Machine, diagnosis: &Diagnosis, circles: Vec<CircleFigures>) -> DiagnosisJson {
    DiagnosisJson {
        verdict: diagnosis.verdict.name(),
        reason: diagnosis.unjudged.clone(),
        warnings: diagnosis.warnings.clone(),
        findings: match &diagnosis.data_fault {
            Some(fault) => vec![fault_json(fault)],
            None => diagnosis
                .findings
                .iter()
                .enumerate()
                .map(|(index, finding)| finding_json(machine, diagnosis, index, finding))
                .collect(),
        },
        blind_to: diagnosis.blind_to.iter().map(blind_json).collect(),
        uncovered_by: diagnosis
            .uncovered_by
            .iter()
            .map(|test| UncoveringJson {
                says: test.says.clone(),
                minutes: test.minutes,
                uncovers: test.uncovers.clone(),
            })
            .collect(),
        shares: diagnosis.shares.iter().map(|share| share_json(diagnosis, share)).collect(),
        fit: FitBeforeAfterJson {
            readings: diagnosis.readings(),
            left_out: diagnosis.left_out,
            left_out_share: diagnosis.left_out as f64 / diagnosis.readings().max(1) as f64,
            rms_before_um: diagnosis.rms_before_um,
            rms_after_um: diagnosis.rms_after_um,
            noise_um: diagnosis.noise_um,
            heldout_before_um: diagnosis.proof.as_ref().map(|proof| proof.before_um),
            heldout_after_um: diagnosis.proof.as_ref().map(|proof| proof.after_um),
            left: diagnosis.left.map(|left| LeftJson {
                share: (diagnosis.rms_after_um / diagnosis.rms_before_um).powi(2),
                arm_um: left.arm_um,
                readings_um: left.readings_um,
            }),
        },
        location_errors: diagnosis
            .location_errors
            .iter()
            .map(|moved| {
                let out = |value: f64| moved.measure.to_output(value);
                let json = MovedJson {
                    before: out(moved.before),
                    after: out(moved.after),
                    sigma: out(moved.sigma),
                    seen_sigma: out(moved.seen_sigma),
                    unit: moved.measure.output_unit(),
                    determined: moved.determined,
                    hangs_on: moved
                        .hangs_on
                        .iter()
                        .map(|one| HangsOnJson { blind_to: one.unseen, per_unit: out(one.per_unit) })
                        .collect(),
                };
                (moved.name.clone(), json)
            })
            .collect(),
        circles,
    }
}

/// Sources of one share that are named.
const SOURCES_NAMED: usize = 3;

/// Several sources of a kind, in words.
fn plural(kind: &str) -> &'static str {
    match kind {
        "location error" => "location errors",
        "setup" => "places of balls and bars",
        "finding" => "findings",
        _ => "other sources",
    }
}

/// A share by name; findings by what they are.
fn share_json(diagnosis: &Diagnosis, share: &ShareOfReadings) -> ShareJson {
    let named = |source: &Source| match source {
        Source::Location(name) => (name.clone(), "location error"),
        Source::Setup(label) => (label.clone(), "setup"),
        Source::Other => ("instrument and linear axes".to_string(), "other"),
        Source::Finding(number) => {
            let cause = diagnosis.findings.get(*number).map(|finding| &finding.cause);
            (cause.map_or(String::new(), |cause| what(&cause.effect, &cause.place, &cause.components)), "finding")
        }
        Source::Rest => ("not explained".to_string(), "rest"),
    };
    let all: Vec<(String, &'static str)> = share.sources.iter().map(named).collect();
    let mut kinds: Vec<&'static str> = all.iter().map(|(_, kind)| *kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let kind = match kinds[..] {
        [one] => one,
        _ if kinds.contains(&"finding") => "finding",
        _ => "together",
    };
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    let name = match names.len() {
        0..=SOURCES_NAMED => names.join(" with "),
        count => {
            let (named, more) = (names[..SOURCES_NAMED].join(", "), count - SOURCES_NAMED);
            let of = kinds.iter().map(|kind| plural(kind)).collect::<Vec<_>>().join(" and ");
            format!("{of} that the readings do not tell apart: {named} and {more} more")
        }
    };
    ShareJson { name, kind, rms_um: share.rms_um, share: share.share }
}

fn blind_json(blind: &Unseen) -> BlindJson {
    BlindJson {
        effect: blind.cause.effect.clone(),
        place: blind.cause.place.clone(),
        components: blind.cause.components.clone(),
        smallest_visible: SmallestJson { value: blind.smallest, unit: blind.unit },
        test: blind.test.clone(),
    }
}

/// What may be the cause instead, in the order of probability.
fn likeliest_first(rivals: impl Iterator<Item = RivalJson>) -> Vec<RivalJson> {
    let mut list: Vec<RivalJson> = rivals.collect();
    list.sort_by(|one, other| other.probability.total_cmp(&one.probability));
    list
}

/// A mistake in the files as the only finding.
fn fault_json(fault: &DataFault) -> FindingJson {
    let rival = |rival: &Rival| RivalJson {
        effect: rival.kind.name().to_string(),
        driver: "data fault",
        place: rival.place.clone(),
        components: rival.components.clone(),
        probability: rival.probability,
        says: Some(rival.says.clone()),
    };
    let causes = fault.causes.iter().map(|(cause, probability)| rival_json(cause, *probability));
    FindingJson {
        fault: Some(fault.kind),
        effect: fault.kind.name().to_string(),
        driver: "data fault",
        place: fault.place.clone(),
        components: fault.components.clone(),
        size: SizeJson {
            value: fault.shift_ms,
            unit: fault.shift_ms.map(|_| "ms"),
            sigma: None,
            meaning: fault.says.clone(),
        },
        shape: None,
        located: WhereJson { tests: fault.tests.clone(), range: None },
        probability: fault.probability,
        cross_validated: None,
        placebo: None,
        other_setups: None,
        cannot_tell_from: likeliest_first(causes.chain(fault.rivals.iter().map(rival)).take(MOST_RIVALS)),
        next_test: None,
    }
}

/// Verdict of the held-out proof on a finding.
fn cross_validated(diagnosis: &Diagnosis, index: usize, finding: &Finding) -> Option<&'static str> {
    if finding.single {
        return Some("single occurrence");
    }
    let held_out = diagnosis.proof.as_ref().and_then(|proof| proof.findings.get(index))?;
    Some(if held_out.passed { "passed" } else { "failed" })
}

fn finding_json(machine: &Machine, diagnosis: &Diagnosis, index: usize, finding: &Finding) -> FindingJson {
    let finite = |value: f64| value.is_finite().then_some(value);
    FindingJson {
        fault: None,
        effect: finding.cause.effect.clone(),
        driver: finding.cause.driver.name(),
        place: finding.cause.place.clone(),
        components: finding.cause.components.clone(),
        size: SizeJson {
            value: finite(finding.size.value),
            unit: Some(finding.size.unit),
            sigma: finite(finding.size.sigma),
            meaning: finding.size.meaning.clone(),
        },
        shape: Some(shape_words(machine, finding.told_effects())).filter(|words| !words.is_empty()),
        located: WhereJson {
            tests: finding.tests.clone(),
            range: finding.range.as_ref().map(|range| RangeJson {
                axis: range.axis.clone(),
                from: range.from,
                to: range.to,
            }),
        },
        probability: finding.probability,
        cross_validated: cross_validated(diagnosis, index, finding),
        placebo: diagnosis.placebos.get(index).copied().flatten().map(placebo_json),
        other_setups: diagnosis.transfers.get(index).copied().flatten().map(other_setups_json),
        cannot_tell_from: likeliest_first(
            finding.rivals.iter().map(|(cause, probability)| rival_json(cause, *probability)),
        ),
        next_test: finding
            .next_test
            .as_ref()
            .map(|next| NextTestJson { says: next.says.clone(), odds_after: next.probability_after }),
    }
}

fn placebo_json(placebo: SignRandomisation) -> PlaceboJson {
    let share = |gain: f64| gain / placebo.gain.max(f64::MIN_POSITIVE);
    PlaceboJson { mean: share(placebo.mean), largest: share(placebo.largest), draws: placebo.draws }
}

fn other_setups_json(transfer: LeftOutSetup) -> OtherSetupsJson {
    let LeftOutSetup { slope, sigma, setups } = transfer;
    OtherSetupsJson { slope, sigma, setups, carries: transfer.is_right() }
}

fn rival_json(cause: &Cause, probability: f64) -> RivalJson {
    RivalJson {
        effect: cause.effect.clone(),
        driver: cause.driver.name(),
        place: cause.place.clone(),
        components: cause.components.clone(),
        probability,
        says: None,
    }
}

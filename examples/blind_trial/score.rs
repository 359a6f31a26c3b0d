//! Compares an answer in the JSON contract with the opened truth; forgives no wrong place and no wrong component.

use serde_json::Value;

/// What the binary did with one session.
pub struct Answer {
    pub json: Option<Value>,
    /// Why there is no JSON.
    pub failed: Option<String>,
    pub seconds: f64,
}

/// How one session went.
#[derive(Default, Clone)]
pub struct Score {
    pub case: String,
    /// Main effect of the truth: the most visible one, `clean` without any.
    pub effect: String,
    pub level: String,
    pub design: String,
    pub visible: f64,
    pub clean: bool,
    /// Two effects that can be seen.
    pub two: bool,
    /// Visibility of the less visible of two.
    pub weaker: f64,
    /// A vibration or something that happens once is among the effects that can be seen.
    pub fleeting: bool,
    pub stranger: bool,
    /// The files are wrong, not the machine.
    pub fault: bool,
    /// First finding, `effect@place`.
    pub stated: String,
    pub failed: Option<String>,
    pub right: bool,
    /// The first finding names the truth, or states it as at least half as likely: a class that nothing separates.
    pub in_class: bool,
    pub in_set: bool,
    /// A finding that matches nothing true, the first excluded unless nothing true can be seen.
    pub wrong_companion: bool,
    pub false_alarm: bool,
    pub both_in_sets: bool,
    pub listed_blind: bool,
    pub halved: bool,
    /// Claims at 0.99 or above: made and right.
    pub claims: (usize, usize),
    pub size: Option<SizeCheck>,
    /// Over the noise floor that the answer states, and over the true noise.
    pub heldout_over_noise: Option<f64>,
    pub heldout_over_true_noise: Option<f64>,
    pub seconds: f64,
}

#[derive(Clone)]
pub struct SizeCheck {
    pub within_3_sigma: bool,
    pub within_tenth: bool,
    /// Its stated sigma is 8 % of it at most: the recordings determine it.
    pub determined: bool,
    pub truth: f64,
    pub stated: f64,
    pub sigma: f64,
}

/// Names that mean a contract name.
fn contract_name(id: &str) -> &str {
    match id {
        "worm-cyclic" | "linear-cyclic" | "screw-cyclic" => "cyclic-error",
        "guideway-wear" => "straightness",
        "linear-reversal-spike" => "reversal-spike",
        _ if id.starts_with("unknown") => "unknown",
        _ => id,
    }
}

/// A truth told in other words (`worm-cyclic`, `pivot on C`) in those of the answer contract.
pub fn in_contract_words(mut truth: Value) -> Value {
    for effect in truth["effects"].as_array_mut().into_iter().flatten() {
        if effect["effect"].is_null() {
            effect["effect"] = Value::from(contract_name(text(effect, "id")));
        }
        let place = text(effect, "place");
        if let Some(device) = ["pivot", "spindle-ball"].into_iter().find(|d| place.starts_with(d)) {
            effect["place"] = Value::from(device);
        } else if place.starts_with("spindle ball") {
            effect["place"] = Value::from("spindle-ball");
        }
    }
    truth
}

fn text<'a>(v: &'a Value, key: &str) -> &'a str {
    v[key].as_str().unwrap_or("")
}

fn components(v: &Value) -> Vec<String> {
    let list = v["components"].as_array().map(Vec::as_slice).unwrap_or_default();
    list.iter().filter_map(|c| c.as_str()).map(str::to_string).collect()
}

fn same_place(truth: &Value, stated: &Value) -> bool {
    let (t, s) = (text(truth, "place"), text(stated, "place"));
    // "pivot on C" names the pivot
    s == t || (t == "pivot" && s.starts_with("pivot")) || (t == "spindle-ball" && s.starts_with("spindle-ball"))
}

/// `EC0Y` and `EC0X` are the two sides of one angle.
fn squareness_angle(component: &str) -> Option<&'static str> {
    match component {
        "EC0X" | "EC0Y" => Some("XY"),
        "EB0X" | "EB0Z" => Some("ZX"),
        "EA0Y" | "EA0Z" => Some("YZ"),
        _ => None,
    }
}

/// Whether a statement (a finding or one of its alternatives) names a true effect.
pub fn names(truth: &Value, stated: &Value) -> bool {
    let effect = contract_name(text(truth, "effect"));
    let said = contract_name(text(stated, "effect"));
    if effect == "unknown" {
        return said == "unknown"
            || (same_place(truth, stated)
                && text(truth, "driver") == text(stated, "driver")
                && share_component(truth, stated));
    }
    if effect != said {
        return false;
    }
    match effect {
        "squareness" => {
            let angles = |v| components(v).iter().filter_map(|c| squareness_angle(c)).collect::<Vec<_>>();
            let said = angles(stated);
            angles(truth).iter().any(|a| said.contains(a))
        }
        // growth with time is growth with a temperature that was not read
        // and what recordings are blind to has no driver
        "bar-length" => {
            let stated = text(stated, "driver");
            stated.is_empty() || (text(truth, "driver") == "constant") == (stated == "constant")
        }
        _ if matches!(text(truth, "place"), "pivot" | "spindle-ball" | "recorder") => same_place(truth, stated),
        _ => same_place(truth, stated) && share_component(truth, stated),
    }
}

fn share_component(truth: &Value, stated: &Value) -> bool {
    let said = components(stated);
    components(truth).iter().any(|c| said.contains(c))
}

/// A finding with its alternatives, at most four in all beside it.
fn set(finding: &Value) -> Vec<&Value> {
    let others = finding["cannot_tell_from"].as_array().map(Vec::as_slice).unwrap_or_default();
    std::iter::once(finding).chain(others.iter().take(4)).collect()
}

fn in_set(truth: &Value, finding: &Value) -> bool {
    set(finding).iter().any(|s| names(truth, s))
}

/// Share of a finding's probability from which a cause beside it belongs to its class.
const INSEPARABLE: f64 = 0.5;

fn in_class(truth: &Value, finding: &Value) -> bool {
    let probability = |stated: &Value| stated["probability"].as_f64().unwrap_or(0.0);
    let is_likely = |stated: &&Value| probability(stated) >= INSEPARABLE * probability(finding);
    set(finding).into_iter().filter(is_likely).any(|stated| names(truth, stated))
}

/// What no other part of a recording repeats.
fn is_fleeting(effect: &str) -> bool {
    effect == "vibration" || effect.ends_with("-slip")
}

pub fn score(truth: &Value, answer: &Answer) -> Score {
    let empty = vec![];
    let effects = truth["effects"].as_array().unwrap_or(&empty);
    let visible_of = |e: &Value| e["visible_over_noise"].as_f64().unwrap_or(99.0);
    let main = effects.iter().max_by(|a, b| visible_of(a).total_cmp(&visible_of(b)));
    let mut s = Score {
        case: text(truth, "case").to_string(),
        effect: main.map_or("clean".into(), |e| text(e, "id").to_string()),
        level: main.map_or("clean".into(), |e| text(e, "level_reached").to_string()),
        design: text(truth, "design").to_string(),
        visible: main.map_or(0.0, visible_of),
        clean: effects.is_empty(),
        two: effects.iter().filter(|e| visible_of(e) >= 0.3).count() > 1,
        weaker: effects.iter().map(visible_of).fold(f64::INFINITY, f64::min),
        fleeting: effects.iter().any(|e| visible_of(e) >= 0.3 && is_fleeting(text(e, "effect"))),
        stranger: main.is_some_and(|e| text(e, "effect") == "unknown"),
        fault: main.is_some_and(|e| text(e, "driver") == "data fault"),
        failed: answer.failed.clone(),
        seconds: answer.seconds,
        ..Score::default()
    };
    let Some(json) = &answer.json else {
        s.stated = "no answer".into();
        return s;
    };
    let findings = json["findings"].as_array().unwrap_or(&empty);
    let first = findings.first();
    s.stated = first.map_or("nothing".into(), |f| format!("{}@{}", text(f, "effect"), text(f, "place")));
    if let Some(first) = first {
        // with two causes either may come first
        s.right = effects.iter().any(|e| names(e, first));
        s.in_class = effects.iter().any(|e| in_class(e, first));
        s.in_set = effects.iter().any(|e| in_set(e, first));
    }
    let stray = |f: &Value| !effects.iter().any(|e| in_set(e, f));
    s.false_alarm = s.clean && !findings.is_empty();
    s.wrong_companion = !s.clean && findings.iter().skip(1).any(stray);
    s.both_in_sets = s.two && effects.iter().all(|e| findings.iter().any(|f| in_set(e, f)));
    let blind = json["blind_to"].as_array().unwrap_or(&empty);
    s.listed_blind = main.is_some_and(|e| blind.iter().any(|b| names(e, b)));
    let sure: Vec<&Value> = findings.iter().filter(|f| f["probability"].as_f64().unwrap_or(0.0) >= 0.99).collect();
    s.claims = (sure.len(), sure.iter().filter(|f| effects.iter().any(|e| names(e, f))).count());
    s.size = main.and_then(|e| findings.iter().find(|f| names(e, f)).and_then(|f| size(e, f)));
    let fit = |key: &str| json["fit"][key].as_f64();
    if let (Some(before), Some(after), Some(noise)) =
        (fit("heldout_before_um"), fit("heldout_after_um"), fit("noise_um"))
    {
        // what noise contributes cannot be halved
        let excess = |x: f64| (x * x - noise * noise).max(0.0).sqrt();
        s.halved = after <= 0.5 * before || excess(after) <= 0.5 * excess(before);
        s.heldout_over_noise = (noise > 0.0).then_some(after / noise);
        let true_noise = truth["noise_rms_um"].as_f64().filter(|noise| *noise > 0.0);
        s.heldout_over_true_noise = true_noise.map(|noise| after / noise);
    }
    s
}

/// Stated size against the true one, where both are of the same kind.
fn size(truth: &Value, finding: &Value) -> Option<SizeCheck> {
    if contract_name(text(truth, "effect")) == "unknown" || truth["unit"] != finding["size"]["unit"] {
        return None;
    }
    let real = truth["size"].as_f64()?;
    let stated = finding["size"]["value"].as_f64()?;
    let sigma = finding["size"]["sigma"].as_f64().unwrap_or(0.0);
    let off = (stated.abs() - real.abs()).abs();
    Some(SizeCheck {
        within_3_sigma: off <= 3.0 * sigma,
        within_tenth: off <= 0.1 * real.abs(),
        determined: sigma <= 0.08 * stated.abs(),
        truth: real,
        stated,
        sigma,
    })
}

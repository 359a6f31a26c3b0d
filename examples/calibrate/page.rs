//! The outcomes as a page of tables; runs nothing.

use super::outcome::{Claim, Deviation, Outcome};
use super::rules::Tally;
use fiveaxis::diagnose::Threshold;
use std::fmt::Write;

/// Bins of a stated probability.
const BINS: [(f64, f64); 5] = [(0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 1.01)];

/// Bands of an effect's trace over the noise, after what location errors and balls imitate is taken out.
const BANDS: [(&str, f64, f64); 3] = [("≥ 3.5", 3.5, f64::INFINITY), ("1.5–3.5", 1.5, 3.5), ("0.3–1.5", 0.3, 1.5)];

pub fn page(outcomes: &[Outcome], earned: &[(Threshold, Tally)], command: &str) -> String {
    let mut text = format!(
        "# Calibration: what is stated against what is true\n\n\
         `cargo run --release --example calibrate -- {command}`\n\n\
         Sessions of the blind trial's own simulator, which shares no code with the library: {} in all. \
         The numbers in brackets are counts.\n",
        outcomes.len()
    );
    accuracy(&mut text, outcomes);
    alarms(&mut text, outcomes);
    let inside: Vec<&Outcome> = outcomes.iter().filter(|o| !o.stranger).collect();
    reliability(&mut text, "## Stated probabilities, causes of the catalogue", &inside);
    let outside: Vec<&Outcome> = outcomes.iter().filter(|o| o.stranger).collect();
    reliability(&mut text, "## Stated probabilities, causes outside the catalogue", &outside);
    proofs(&mut text, outcomes);
    coverage(&mut text, outcomes);
    times(&mut text, outcomes);
    rules(&mut text, outcomes, earned);
    text
}

/// `12.5 % (5 of 40)`.
fn share(hits: usize, of: usize) -> String {
    if of == 0 {
        return "–".into();
    }
    format!("{:.1} % ({hits} of {of})", 100.0 * hits as f64 / of as f64)
}

fn line(text: &mut String, cells: &[&str]) {
    let _ = writeln!(text, "| {} |", cells.join(" | "));
}

fn head(text: &mut String, cells: &[&str]) {
    text.push('\n');
    line(text, cells);
    let _ = writeln!(text, "|{}", "---|".repeat(cells.len()));
}

fn accuracy(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## Right cause, or the class that nothing separates, named first\n");
    head(text, &["one cause, rms of its trace over the noise", "named", "wanted"]);
    for ((name, low, high), wanted) in BANDS.iter().zip(["99 %", "97 %", "88 %"]) {
        let band: Vec<&Outcome> = outcomes
            .iter()
            .filter(|o| !o.clean && !o.two && !o.stranger && !o.fault && o.visible >= *low && o.visible < *high)
            .collect();
        line(text, &[name, &share(band.iter().filter(|o| o.in_class).count(), band.len()), wanted]);
    }
    let outside: Vec<&Outcome> = outcomes.iter().filter(|o| o.stranger && o.visible >= 0.3).collect();
    let named = outside.iter().filter(|o| o.in_class).count();
    line(text, &["outside the catalogue: place and driver, or \"unknown\"", &share(named, outside.len()), "95 %"]);
    let faults: Vec<&Outcome> = outcomes.iter().filter(|o| o.fault).collect();
    line(text, &["files are wrong", &share(faults.iter().filter(|o| o.in_class).count(), faults.len()), "–"]);
    let dirty = outcomes.iter().filter(|o| !o.clean);
    let companions = dirty.clone().filter(|o| o.companion).count();
    line(text, &["sessions with a wrong companion", &share(companions, dirty.count()), "≤ 1 %"]);
    let failed = outcomes.iter().filter(|o| o.failed).count();
    line(text, &["sessions without an answer", &share(failed, outcomes.len()), "none"]);
}

fn alarms(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## False alarms on clean sessions (wanted: at most 0.5 %)\n");
    head(text, &["noise", "accused"]);
    for (family, says) in [
        ("bench", "white, first-order per sample, a walk of the zero"),
        ("workshop", "correlated over seconds, loudness from test to test, a tide of the zero"),
        ("rough", "heavy tails, bursts, 1/f"),
    ] {
        let clean: Vec<&Outcome> = outcomes.iter().filter(|o| o.clean && o.noise_family == family).collect();
        let accused = clean.iter().filter(|o| o.alarm).count();
        line(text, &[&format!("{family}: {says}"), &share(accused, clean.len())]);
    }
    let clean: Vec<&Outcome> = outcomes.iter().filter(|o| o.clean).collect();
    line(text, &["all", &share(clean.iter().filter(|o| o.alarm).count(), clean.len())]);
}

/// Number, mean of what was stated and number right of the claims in one bin.
fn bin(claims: &[(f64, bool)], (low, high): (f64, f64)) -> (usize, f64, usize) {
    let inside: Vec<&(f64, bool)> = claims.iter().filter(|c| c.0 >= low && c.0 < high).collect();
    let mean = inside.iter().map(|c| c.0).sum::<f64>() / inside.len().max(1) as f64;
    (inside.len(), mean, inside.iter().filter(|c| c.1).count())
}

/// Expected calibration error: the mean distance of stated from true shares, weighted by the number of claims.
fn calibration_error(claims: &[(f64, bool)]) -> f64 {
    let off = |b: &(f64, f64)| {
        let (n, mean, right) = bin(claims, *b);
        (n as f64 * mean - right as f64).abs()
    };
    BINS.iter().map(off).sum::<f64>() / claims.len().max(1) as f64
}

fn reliability(text: &mut String, title: &str, outcomes: &[&Outcome]) {
    let all = || outcomes.iter().flat_map(|o| &o.claims);
    let leading: Vec<(f64, bool)> = all().filter(|c| c.leads).map(|c| (c.probability, c.right)).collect();
    let every: Vec<(f64, bool)> = all().map(|c| (c.probability, c.right)).collect();
    let _ = writeln!(text, "\n{title}");
    head(text, &["stated", "first cause of each finding: mean stated", "right", "with rivals: mean stated", "right"]);
    for b in BINS {
        let ((n, mean, right), (n_all, mean_all, right_all)) = (bin(&leading, b), bin(&every, b));
        let name = if b.1 > 1.0 { format!("≥ {}", b.0) } else { format!("{}–{}", b.0, b.1) };
        let of = |mean: f64, n: usize| if n == 0 { "–".into() } else { format!("{:.1} %", 100.0 * mean) };
        line(text, &[&name, &of(mean, n), &share(right, n), &of(mean_all, n_all), &share(right_all, n_all)]);
    }
    let _ = writeln!(
        text,
        "\nExpected calibration error: {:.3} of first causes, {:.3} with rivals (wanted: at most 0.04).",
        calibration_error(&leading),
        calibration_error(&every)
    );
}

/// How often first causes are right by what held-out readings said of them.
fn proofs(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## Held-out readings and the first cause of each finding\n");
    head(text, &["held-out readings", "mean stated", "right, causes of the catalogue", "right, all"]);
    for proof in ["passed", "failed", "single occurrence", "none"] {
        let of = |outcome: &&Outcome| outcome.claims.iter().any(|c| c.leads && c.proof == proof);
        let claims = |strangers: bool| -> Vec<&Claim> {
            let taken = outcomes.iter().filter(|o| strangers || !o.stranger).filter(of);
            taken.flat_map(|o| &o.claims).filter(|c| c.leads && c.proof == proof).collect()
        };
        let right = |list: &[&Claim]| share(list.iter().filter(|c| c.right).count(), list.len());
        let (inside, all) = (claims(false), claims(true));
        let mean = all.iter().map(|c| c.probability).sum::<f64>() / all.len().max(1) as f64;
        let stated = if all.is_empty() { "–".into() } else { format!("{:.1} %", 100.0 * mean) };
        line(text, &[proof, &stated, &right(&inside), &right(&all)]);
    }
}

fn coverage(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## Stated sigmas\n");
    head(text, &["number", "within 1 σ", "2 σ", "3 σ", "largest"]);
    let mut row = |name: &str, list: Vec<&Deviation>| {
        let within = |k: f64| share(list.iter().filter(|d| d.sigmas.abs() <= k).count(), list.len());
        let largest = list.iter().max_by(|a, b| a.sigmas.abs().total_cmp(&b.sigmas.abs()));
        let largest = largest.map_or("–".into(), |d| format!("{:.1} σ, {}", d.sigmas, d.what));
        line(text, &[name, &within(1.0), &within(2.0), &within(3.0), &largest]);
    };
    for (name, low, high) in BANDS {
        let band = outcomes.iter().filter(|o| o.visible >= low && o.visible < high);
        row(&format!("size of a cause, {name} × noise"), band.flat_map(|o| &o.sizes).collect());
    }
    row("size of a cause, all", outcomes.iter().flat_map(|o| &o.sizes).collect());
    let clean = outcomes.iter().filter(|o| o.clean);
    row("location errors, clean sessions", clean.flat_map(|o| &o.location).collect());
    let known = outcomes.iter().filter(|o| !o.clean && !o.stranger);
    row("location errors beside causes of the catalogue", known.flat_map(|o| &o.location).collect());
    let strange = outcomes.iter().filter(|o| o.stranger);
    row("location errors beside other causes", strange.flat_map(|o| &o.location).collect());
    text.push_str("\nWanted: 65–75, 93–97 and at least 98 %. Location errors are those said to be determined.\n");
}

fn times(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## Time of a session, one thread\n");
    head(text, &["session", "median s", "longest s"]);
    for (name, clean) in [("clean", true), ("something concealed", false)] {
        let mut list: Vec<f64> = outcomes.iter().filter(|o| o.clean == clean).map(|o| o.seconds).collect();
        list.sort_by(f64::total_cmp);
        if let (Some(middle), Some(longest)) = (list.get(list.len() / 2), list.last()) {
            line(text, &[name, &format!("{middle:.1}"), &format!("{longest:.1}")]);
        }
    }
}

/// What changes without each rule.
fn rules(text: &mut String, outcomes: &[Outcome], earned: &[(Threshold, Tally)]) {
    if earned.is_empty() {
        return;
    }
    let now = Tally::of(outcomes);
    let _ = writeln!(
        text,
        "\n## What each number that decides earns\n\nThe same sessions with one rule after the other out of force. As it is: {} causes \
         named, {} false alarms, {} wrong companions, {} wrong claims at 0.99 or more, {} sizes off by more than 3 σ, {:.0} s.",
        now.named, now.alarms, now.companions, now.wrong_claims, now.sizes_off, now.seconds
    );
    head(text, &["rule", "value", "without", "named", "alarms", "companions", "wrong claims", "sizes off", "time"]);
    let change = |then: usize, now: usize| match then as i64 - now as i64 {
        0 => String::new(),
        change => format!("{change:+}"),
    };
    for (rule, then) in earned {
        line(
            text,
            &[
                &format!("`{}`: {}", rule.name, rule.meaning),
                &format!("{} {}", rule.value, rule.unit),
                &format!("{}", rule.off),
                &change(then.named, now.named),
                &change(then.alarms, now.alarms),
                &change(then.companions, now.companions),
                &change(then.wrong_claims, now.wrong_claims),
                &change(then.sizes_off, now.sizes_off),
                &format!("{:.2}", then.seconds / now.seconds),
            ],
        );
    }
}

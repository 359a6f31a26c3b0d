//! Prints what the scores add up to against the figures to reach; judges nothing itself.

use super::score::Score;
use std::collections::BTreeMap;

/// A share of sessions with its target.
fn line(what: &str, scores: &[&Score], good: impl Fn(&Score) -> bool, target: &str) {
    if scores.is_empty() {
        println!("  {what:<58}    –          ({target})");
        return;
    }
    let hits = scores.iter().filter(|s| good(s)).count();
    let share = 100.0 * hits as f64 / scores.len() as f64;
    println!("  {what:<58} {share:5.1} %  {hits:>4}/{:<4} ({target})", scores.len());
}

pub fn print(scores: &[Score]) {
    confusion(scores);
    let all: Vec<&Score> = scores.iter().collect();
    let pick = |f: &dyn Fn(&Score) -> bool| -> Vec<&Score> { scores.iter().filter(|s| f(s)).collect() };
    let single = |s: &Score| !s.clean && !s.two && !s.stranger && !s.fault;
    println!("\nAgainst the figures to reach");
    let clean = pick(&|s| s.clean);
    line("false alarms on clean sessions", &clean, |s| s.false_alarm, "≤ 1 %");
    let bands = [
        ("visible ≥ 3.5", 3.5, f64::INFINITY, "98 %", "100 %"),
        ("visible 1.5–3.5", 1.5, 3.5, "95 %", "98 %"),
        ("visible 0.3–1.5", 0.3, 1.5, "75 %", "85 %"),
    ];
    for (name, low, high, named, in_set) in bands {
        let band = pick(&|s| single(s) && s.visible >= low && s.visible < high);
        line(&format!("{name}: right cause, or its class, first"), &band, |s| s.in_class, named);
        line("  the cause itself", &band, |s| s.right, "–");
        line(&format!("{name}: in the stated set"), &band, |s| s.in_set, in_set);
    }
    let unseen = pick(&|s| single(s) && s.visible < 0.1);
    line("invisible in the design: no wrong cause claimed", &unseen, quiet, "95 %");
    line("invisible in the design: listed as blind", &unseen, |s| s.listed_blind, "95 %");
    let faint = pick(&|s| single(s) && (0.1..0.3).contains(&s.visible));
    line("visible 0.1–0.3: no wrong cause claimed", &faint, quiet, "–");
    line("further findings that match nothing true", &pick(&|s| !s.clean), |s| s.wrong_companion, "≤ 3 %");
    let stranger = pick(&|s| s.stranger && s.visible >= 0.3);
    line("outside the catalogue: unknown or rightly placed", &stranger, |s| s.right || s.in_set, "90 %");
    line("outside the catalogue: held-out residual halved", &stranger, |s| s.halved, "90 %");
    line("two at once: first finding true", &pick(&|s| s.two), |s| s.in_set, "–");
    line("two at once: both in the sets", &pick(&|s| s.two), |s| s.both_in_sets, "90 %");
    for (name, low, high) in [("≥ 1.5", 1.5, f64::INFINITY), ("0.3–1.5", 0.3, 1.5)] {
        let band = pick(&|s| s.two && s.weaker >= low && s.weaker < high);
        line(&format!("  the weaker one visible {name}: both in the sets"), &band, |s| s.both_in_sets, "–");
    }
    line("data faults that can be seen, named", &pick(&|s| s.fault && s.visible >= 1.5), |s| s.in_set, "–");
    let claims = scores.iter().fold((0, 0), |a, s| (a.0 + s.claims.0, a.1 + s.claims.1));
    let share = 100.0 * claims.1 as f64 / claims.0.max(1) as f64;
    println!("  {:<58} {share:5.1} %  {:>4}/{:<4} (98 %)", "claims made at ≥ 0.99 that are right", claims.1, claims.0);
    let sized = pick(&|s| s.size.is_some());
    line("size within 3 stated sigmas", &sized, |s| s.size.as_ref().is_some_and(|z| z.within_3_sigma), "95 %");
    let strong = pick(&|s| s.size.is_some() && s.visible >= 3.5);
    line("size within 10 % where strong", &strong, |s| s.size.as_ref().is_some_and(|z| z.within_tenth), "95 %");
    let known = pick(&|s| s.visible >= 3.5 && s.size.as_ref().is_some_and(|z| z.determined));
    line("  and stated to 8 % or better", &known, |s| s.size.as_ref().is_some_and(|z| z.within_tenth), "–");
    let heldout = pick(&|s| s.heldout_over_noise.is_some());
    line("held-out residual ≤ 1.1 × stated noise", &heldout, |s| s.heldout_over_noise.is_some_and(|r| r <= 1.1), "–");
    let near = |s: &Score| s.heldout_over_true_noise.is_some_and(|r| r <= 1.1);
    line("held-out residual ≤ 1.1 × true noise", &heldout, near, "–");
    let repeating = pick(&|s| s.heldout_over_true_noise.is_some() && !s.stranger && !s.fleeting);
    line("  effects of the catalogue that repeat", &repeating, near, "–");
    line("sessions without an answer", &all, |s| s.failed.is_some(), "none");
    times(scores);
    let off = |s: &&Score| s.size.as_ref().is_some_and(|z| !z.within_3_sigma || (s.visible >= 3.5 && !z.within_tenth));
    println!("\nSizes that are off");
    for s in scores.iter().filter(off) {
        if let Some(z) = &s.size {
            println!("  {} {}: {:.3} ± {:.3} against {:.3}", s.case, s.effect, z.stated, z.sigma, z.truth);
        }
    }
}

/// Nothing claimed, or what is claimed holds the truth.
fn quiet(s: &Score) -> bool {
    s.failed.is_none() && (s.stated == "nothing" || s.in_set)
}

fn confusion(scores: &[Score]) {
    println!("\nTrue effect (sessions: first / in set) and the first finding");
    let mut rows: BTreeMap<&str, Vec<&Score>> = BTreeMap::new();
    for s in scores {
        rows.entry(if s.two { "two at once" } else { &s.effect }).or_default().push(s);
    }
    for (effect, list) in rows {
        let mut called: BTreeMap<String, usize> = BTreeMap::new();
        for s in &list {
            let name = s.stated.split('@').next().unwrap_or("").to_string();
            let claimed = s.stated != "nothing" && s.stated != "no answer";
            let mark = if claimed && !s.right { " ✗" } else { "" };
            *called.entry(format!("{name}{mark}")).or_default() += 1;
        }
        let mut called: Vec<(String, usize)> = called.into_iter().collect();
        called.sort_by_key(|c| std::cmp::Reverse(c.1));
        let called: Vec<String> = called.iter().map(|(name, n)| format!("{name} ×{n}")).collect();
        let right = list.iter().filter(|s| s.right).count();
        let in_set = list.iter().filter(|s| s.in_set).count();
        println!("  {effect:<22} {:>3}: {right:>3} /{in_set:>3}   {}", list.len(), called.join(", "));
    }
}

fn times(scores: &[Score]) {
    let mut by_design: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for s in scores {
        by_design.entry(&s.design).or_default().push(s.seconds);
    }
    println!("\nTime per session, s (median, longest)");
    for (design, mut list) in by_design {
        list.sort_by(f64::total_cmp);
        println!("  {design:<14} {:6.2} {:6.2}", list[list.len() / 2], list[list.len() - 1]);
    }
}

/// Whether a session deserves a look: anything claimed wrongly, or something visible that was missed.
pub fn failed(s: &Score) -> bool {
    s.failed.is_some()
        || s.false_alarm
        || s.wrong_companion
        || (s.two && !s.both_in_sets)
        || (!s.clean && s.visible >= 0.3 && !s.in_set)
        || (!s.clean && s.visible < 0.3 && !quiet(s))
}

/// One line per failure with what is needed to make the session again.
pub fn failures(scores: &[Score], whose: &str, kept: Option<&std::path::Path>) {
    let bad: Vec<&Score> = scores.iter().filter(|s| failed(s)).collect();
    println!("\nFailures: {} of {}", bad.len(), scores.len());
    for s in bad {
        let place = kept.map_or(String::new(), |k| format!("  {}", k.join(&s.case).display()));
        let why = s.failed.as_deref().map_or(String::new(), |w| format!("  [{w}]"));
        let what = if s.two { "two, strongest " } else { "" };
        println!(
            "  {whose} {}: {what}{} ({}, {:.2} × noise, {}) → {}{}{why}{place}",
            s.case,
            s.effect,
            s.level,
            s.visible,
            s.design,
            s.stated,
            if s.wrong_companion { " and a wrong companion" } else { "" },
        );
    }
}

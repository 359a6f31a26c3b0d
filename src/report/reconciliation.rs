//! Results of several methods compared, as text for a terminal and as JSON; computes nothing, see `reconcile`.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::reconcile::{
    Candidate, Cause, DecidingTest, Difference, Disagreement, Kind, Prepared, Reconciliation, Verdict,
};
use crate::report::fits::fit_text::wrapped;
use crate::report::wording::table::Table;
use crate::session::Claim;
use crate::statistics::Fitted;
use crate::units::ARCSEC_PER_RAD;

const COORDINATES: [char; 3] = ['x', 'y', 'z'];
/// Differences this many times the stated scatter are worth a line in the text.
const WORTH_A_LINE: f64 = 3.0;

/// A circle in words: `A extended at +38.2 mm`.
fn circle(prepared: &Prepared, claim: usize, group: usize) -> String {
    let design = &prepared.designs[claim];
    let of = &design.groups[group];
    let bar = if of.reach_mm.abs() > 1.0 { "extended" } else { "short" };
    format!("{} {bar} at {:+.1} mm", design.session.machine.axes[of.axis].name, of.at_mm)
}

/// A cause in words, without its claim.
fn what(prepared: &Prepared, cause: &Cause) -> String {
    let claim = cause.claim.unwrap_or(0);
    let design = &prepared.designs[claim];
    let axis_name = |axis: usize| design.session.machine.axes[axis].name.as_str();
    match &cause.kind {
        Kind::Bar { group, coordinate } => {
            let along = COORDINATES[design.groups[*group].plane[*coordinate]];
            format!("the bar reads circle {} wrongly along {along}", circle(prepared, claim, *group))
        }
        Kind::LeverSign { axis } => {
            format!("sign of the lever of {}: its circles lie the other way round", axis_name(*axis))
        }
        Kind::LeverLength { axis, factor } => {
            format!("the circles of {} lie {factor} times as far apart", axis_name(*axis))
        }
        Kind::PivotSide { axis } => format!("the pivot of {}'s tests stood on the other side of it", axis_name(*axis)),
        Kind::PrintedD => "D taken as printed, 50√2 for 50√5".into(),
        Kind::OuterTilt { outer, inner, left_in } if *left_in == 1.0 => format!("{outer} not taken out of {inner}"),
        Kind::OuterTilt { outer, inner, .. } => format!("{outer} taken out of {inner} with the wrong sign"),
        Kind::PlaceAlong { axis } => format!("the balls of {}'s tests stood elsewhere along it", axis_name(*axis)),
        Kind::Growth { axis, coordinate } => {
            format!("growth along {} of what {} carries, over half an hour", COORDINATES[*coordinate], axis_name(*axis))
        }
        Kind::Seat { from_group, coordinate } => format!(
            "the spindle ball seated anew before {}, along {}",
            circle(prepared, claim, *from_group),
            COORDINATES[*coordinate]
        ),
        Kind::AxialMotion { axis, is_sine } => {
            format!(
                "{} moves along itself once a turn ({})",
                axis_name(*axis),
                if *is_sine { "sine" } else { "cosine" }
            )
        }
        Kind::WornGuideway { axis, centre_mm, coordinate } => {
            format!("guideway of {} worn at {centre_mm:.0} mm, along {}", axis_name(*axis), COORDINATES[*coordinate])
        }
    }
}

fn named(prepared: &Prepared, claims: &[Claim], cause: usize) -> String {
    let cause = &prepared.causes[cause];
    match cause.claim {
        Some(claim) => format!("{}: {}", claims[claim].name, what(prepared, cause)),
        None => format!("machine: {}", what(prepared, cause)),
    }
}

fn unit(prepared: &Prepared, cause: usize) -> &'static str {
    if prepared.causes[cause].unit == "um" { "µm" } else { "mm" }
}

fn size_text(prepared: &Prepared, verdict: &Verdict) -> String {
    match verdict.size {
        Some(Fitted { value: size, sigma }) => format!("{size:+.1} ± {sigma:.1} {}", unit(prepared, verdict.cause)),
        None => "–".into(),
    }
}

/// Words in lines, each after the margin.
fn in_lines(words: &str, margin: &str) -> String {
    format!("{}\n", wrapped(words, margin, margin).trim_end_matches('\n'))
}

/// The comparison as text.
pub fn reconciliation_text(claims: &[Claim], prepared: &Prepared, found: &Reconciliation) -> String {
    let names: Vec<&str> = claims.iter().map(|claim| claim.name.as_str()).collect();
    let mut text = format!("{} compared; the machine's own errors are free\n\n", names.join(", "));
    text.push_str(&values_table(claims, prepared));
    text.push_str("\ndifferences of more than three times the stated scatter, and by the budgets\n");
    let mut table = Table::new(&["error", "between", "difference", "by scatter", "by budget", "verdict"]);
    let worth = |difference: &&Difference| {
        difference.is_beyond || difference.value.abs() > WORTH_A_LINE * difference.repeatability
    };
    for difference in found.differences.iter().filter(worth) {
        let [a, b] = difference.claims.map(|claim| claims[claim].name.clone());
        table.row(vec![
            difference.name.to_string(),
            format!("{b} − {a}"),
            format!("{:+.2} {}", difference.value, error_unit(difference.name.component.is_angle())),
            format!("{:.1} σ", difference.value.abs() / difference.repeatability),
            format!("{:.1} σ", difference.value.abs() / difference.sigma),
            if difference.is_beyond { "beyond" } else { "within" }.into(),
        ]);
    }
    text.push_str(&table.text());
    text.push_str(&shared_scatter(claims, prepared));
    let _ = writeln!(text, "\nχ² {:.1} with {} degrees of freedom", found.chi2, found.degrees_of_freedom);
    match found.disagreements.len() {
        0 => text.push_str("No circle stands out: within these budgets the results agree.\n"),
        1 => text.push_str("One disagreement:\n"),
        count => {
            let _ = writeln!(text, "{count} disagreements:");
        }
    }
    for (index, disagreement) in found.disagreements.iter().enumerate() {
        text.push_str(&disagreement_text(claims, prepared, index, disagreement));
    }
    if !found.disagreements.is_empty() {
        text.push_str(&causes_text(claims, prepared, found));
    }
    let named = found.verdicts.iter().filter(|verdict| verdict.is_named()).count();
    match &found.deciding {
        Some(deciding) => text.push_str(&deciding_text(claims, prepared, deciding)),
        None if named > 1 => text.push_str("\nno circle of these designs, run again, tells the causes named apart\n"),
        None => {}
    }
    text
}

fn error_unit(is_angle: bool) -> &'static str {
    if is_angle { "″" } else { "µm" }
}

/// All values with the standard uncertainty of the budget.
fn values_table(claims: &[Claim], prepared: &Prepared) -> String {
    let mut header = vec!["error", "unit"];
    header.extend(claims.iter().map(|claim| claim.name.as_str()));
    let mut table = Table::new(&header);
    let mut names: Vec<_> = Vec::new();
    for value in claims.iter().flat_map(|claim| &claim.values) {
        if !names.contains(&&value.name) {
            names.push(&value.name);
        }
    }
    for name in names {
        let mut row = vec![name.to_string(), error_unit(name.component.is_angle()).to_string()];
        for (claim, budget) in claims.iter().zip(&prepared.budgets) {
            let at = claim.values.iter().position(|value| value.name == *name);
            row.push(at.map_or("–".into(), |k| {
                let value = name.component.measure().to_output(claim.values[k].value);
                format!("{value:+.2} ± {:.2}", budget.covariance[(k, k)].sqrt())
            }));
        }
        table.row(row);
    }
    table.text()
}

/// Stated scatter that two independent circles cannot have.
fn shared_scatter(claims: &[Claim], prepared: &Prepared) -> String {
    let mut parts = Vec::new();
    for (claim, budget) in claims.iter().zip(&prepared.budgets) {
        for (value, independent) in claim.values.iter().zip(budget.independent.iter()) {
            let stated = value.name.component.measure().to_output(value.deviation);
            if value.name.component.is_angle() && stated < 0.6 * independent {
                parts.push(format!("{} of {} {stated:.2}″ for {independent:.2}″", value.name, claim.name));
            }
        }
    }
    if parts.is_empty() {
        return String::new();
    }
    in_lines(
        &format!(
            "Stated scatter that circles with the scatter of the stated positions cannot give when each is measured anew: {}.",
            parts.join(", ")
        ),
        "",
    )
}

fn disagreement_text(claims: &[Claim], prepared: &Prepared, index: usize, disagreement: &Disagreement) -> String {
    let moves: Vec<String> = disagreement
        .moves
        .iter()
        .map(|(name, value)| format!("{name} by {value:+.2} {}", error_unit(name.component.is_angle())))
        .collect();
    let Fitted { value: size, sigma } = disagreement.size;
    let mut words = format!(
        "{}. {} by {size:+.1} ± {sigma:.1} µm; with it go {}",
        index + 1,
        named(prepared, claims, disagreement.circle),
        moves.join(", ")
    );
    let alike: Vec<String> = disagreement.alike.iter().map(|cause| named(prepared, claims, *cause)).collect();
    if !alike.is_empty() {
        let _ = write!(words, "; as well: {}", alike.join("; "));
    }
    in_lines(&words, "   ")
}

fn causes_text(claims: &[Claim], prepared: &Prepared, found: &Reconciliation) -> String {
    let mut text = String::from("\nwhat would explain it, each alone\n");
    let mut table = Table::new(&["cause", "size", "explains", "χ² left"]);
    let mut count = 0;
    for verdict in found.verdicts.iter().filter(|verdict| verdict.is_named()) {
        let explains: Vec<String> = verdict.explains.iter().map(|k| (k + 1).to_string()).collect();
        table.row(vec![
            named(prepared, claims, verdict.cause),
            size_text(prepared, verdict),
            explains.join(", "),
            format!("{:.1}", verdict.chi2),
        ]);
        count += 1;
    }
    if count == 0 {
        text.push_str("  no single cause of the list at a plausible size\n");
    } else {
        text.push_str(&table.text());
    }
    text.push_str("\nexcluded: it would do so only beyond its limit\n");
    let mut table = Table::new(&["cause", "needs", "limit"]);
    for verdict in found.verdicts.iter().filter(|verdict| !verdict.explains.is_empty() && !verdict.is_plausible) {
        let limit = prepared.causes[verdict.cause].limit.unwrap_or(0.0);
        table.row(vec![
            named(prepared, claims, verdict.cause),
            size_text(prepared, verdict),
            format!("{limit} {}", unit(prepared, verdict.cause)),
        ]);
    }
    text.push_str(&table.text());
    let rest: Vec<&Verdict> = found.verdicts.iter().filter(|verdict| verdict.explains.is_empty()).collect();
    let _ = writeln!(
        text,
        "\nexcluded: none of these does away with a disagreement ({} in all); assumptions among them",
        rest.len()
    );
    let mut assumptions: Vec<(String, Vec<&str>)> = Vec::new();
    for verdict in rest.iter().filter(|verdict| prepared.causes[verdict.cause].limit.is_none()) {
        let cause = &prepared.causes[verdict.cause];
        let claim = cause.claim.map_or("machine", |claim| claims[claim].name.as_str());
        let words = what(prepared, cause);
        match assumptions.iter_mut().find(|(other, _)| *other == words) {
            Some((_, of)) => of.push(claim),
            None => assumptions.push((words, vec![claim])),
        }
    }
    for (words, mut of) in assumptions {
        of.sort_unstable();
        text.push_str(&in_lines(&format!("{words} ({})", of.join(", ")), "  "));
    }
    text
}

fn candidate_words(claims: &[Claim], prepared: &Prepared, candidate: Candidate) -> String {
    match candidate {
        Candidate::Again { claim, group } => {
            format!(
                "{}: circle {} again at the end, nothing remounted",
                claims[claim].name,
                circle(prepared, claim, group)
            )
        }
        Candidate::ShortInPlace { claim, group } => format!(
            "{}: after circle {}, the short bar with both balls where its standing one is",
            claims[claim].name,
            circle(prepared, claim, group)
        ),
    }
}

fn deciding_text(claims: &[Claim], prepared: &Prepared, deciding: &DecidingTest) -> String {
    let (told, all) = deciding.told_apart;
    let mut text = format!("\nthe test that decides most (tells apart {told} of {all} pairs of these causes)\n");
    text.push_str(&in_lines(&candidate_words(claims, prepared, deciding.candidate), "  "));
    let mut table = Table::new(&["if it is", "its centre lies at, µm"]);
    for (cause, [first, second]) in &deciding.predicted {
        table.row(vec![named(prepared, claims, *cause), format!("{first:+.1}, {second:+.1}")]);
    }
    text.push_str(&table.text());
    text
}

/// The comparison as JSON; µm and arcsec.
pub fn reconciliation_json(claims: &[Claim], prepared: &Prepared, found: &Reconciliation) -> Value {
    let verdict_json = |verdict: &Verdict| {
        let cause = &prepared.causes[verdict.cause];
        json!({
            "cause": what(prepared, cause),
            "result": cause.claim.map(|claim| claims[claim].name.as_str()),
            "size": verdict.size.map(|size| size.value),
            "sigma": verdict.size.map(|size| size.sigma),
            "unit": verdict.size.map(|_| cause.unit),
            "limit": cause.limit,
            "explains": verdict.explains.iter().map(|k| k + 1).collect::<Vec<_>>(),
            "leaves": verdict.leaves,
            "chi2": verdict.chi2,
            "named": verdict.is_named(),
        })
    };
    json!({
        "results": claims.iter().zip(&prepared.budgets).map(|(claim, budget)| json!({
            "name": claim.name,
            "errors": claim.values.iter().enumerate().map(|(k, value)| {
                let measure = value.name.component.measure();
                (value.name.to_string(), json!({
                    "value": measure.to_output(value.value),
                    "unit": measure.output_unit(),
                    "stated_deviation": measure.to_output(value.deviation),
                    "sigma": budget.covariance[(k, k)].sqrt(),
                }))
            }).collect::<serde_json::Map<_, _>>(),
        })).collect::<Vec<_>>(),
        "differences": found.differences.iter().map(|difference| json!({
            "error": difference.name.to_string(),
            "between": difference.claims.map(|claim| claims[claim].name.as_str()),
            "value": difference.value,
            "unit": difference.name.component.measure().output_unit(),
            "sigma_of_repeats": difference.repeatability,
            "sigma": difference.sigma,
            "beyond": difference.is_beyond,
        })).collect::<Vec<_>>(),
        "chi2": found.chi2,
        "degrees_of_freedom": found.degrees_of_freedom,
        "disagreements": found.disagreements.iter().map(|disagreement| json!({
            "circle": named(prepared, claims, disagreement.circle),
            "size_um": disagreement.size.value,
            "sigma_um": disagreement.size.sigma,
            "moves": disagreement.moves.iter().map(|(name, value)| (name.to_string(), json!(value))).collect::<serde_json::Map<_, _>>(),
            "alike": disagreement.alike.iter().map(|cause| named(prepared, claims, *cause)).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "causes": found.verdicts.iter().map(verdict_json).collect::<Vec<_>>(),
        "deciding_test": found.deciding.as_ref().map(|deciding| json!({
            "test": candidate_words(claims, prepared, deciding.candidate),
            "told_apart": deciding.told_apart.0,
            "pairs": deciding.told_apart.1,
            "predicted_centre_um": deciding.predicted.iter().map(|(cause, centre)| json!({
                "cause": named(prepared, claims, *cause), "centre": centre,
            })).collect::<Vec<_>>(),
        })),
        "arcsec_per_um_over": arms(prepared),
    })
}

/// Distances over which each result turns a difference of two centres into a tilt, mm, with arcsec per µm.
fn arms(prepared: &Prepared) -> Value {
    let of = |design: &crate::reconcile::Design| {
        let mut arms = serde_json::Map::new();
        for (k, a) in design.groups.iter().enumerate() {
            for b in design.groups[k + 1..].iter().filter(|b| b.axis == a.axis) {
                let apart_mm = (a.at_mm - b.at_mm).abs();
                if apart_mm > 1.0 {
                    let per_um = ARCSEC_PER_RAD / apart_mm / 1000.0;
                    arms.insert(
                        design.session.machine.axes[a.axis].name.clone(),
                        json!({"mm": apart_mm, "arcsec_per_um": per_um}),
                    );
                }
            }
        }
        Value::Object(arms)
    };
    Value::Array(prepared.designs.iter().map(of).collect())
}

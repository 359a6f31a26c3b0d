//! `reconcile` on the thesis's three designs: planted causes are named, consistent results are not accused, wrong files are refused.

use crate::schema as schema_check;
use std::path::Path;
use std::process::Command;

use fiveaxis::load::load_claim;
use fiveaxis::reconcile::{Kind, Limits, Prepared};
use fiveaxis::session::Claim;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Draws of each kind; `FIVEAXIS_RECONCILE_DRAWS` sets another number, 200 for the figures of docs/thesis.md.
fn draws() -> usize {
    std::env::var("FIVEAXIS_RECONCILE_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(40)
}

fn claims() -> Vec<Claim> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/published");
    [4, 5, 6].map(|chapter| load_claim(&root.join(format!("chapter{chapter}.yaml"))).unwrap()).into()
}

/// One machine's errors seen by all three methods, with what the budgets let them scatter.
fn consistent(prepared: &Prepared, first: &DVector<f64>, random: &mut ChaCha8Rng) -> DVector<f64> {
    let count = prepared.covariance().nrows();
    let scatter = DVector::from_fn(count, |_, _| StandardNormal.sample(random));
    let machine = DVector::from_fn(count, |k, _| first[k % 8]);
    machine + prepared.covariance().clone().cholesky().unwrap().l() * scatter
}

#[test]
fn consistent_results_are_not_accused() {
    let claims = claims();
    let prepared = Prepared::of(&claims, &Limits::default()).unwrap();
    let values = prepared.values(&claims);
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let accused = (0..draws())
        .filter(|_| {
            let found = prepared.judge(&consistent(&prepared, &values, &mut random));
            found.verdicts.iter().any(|verdict| verdict.is_named())
        })
        .count();
    println!("{accused} of {} consistent triples accused", draws());
    // 2 % of the draws
    assert!(accused * 50 <= draws().max(50), "{accused} of {}", draws());
}

/// A disagreement of this many standard deviations shows in nearly every draw: threshold 3.4, scatter 1.
const VISIBLE: f64 = 6.5;

#[test]
fn a_planted_cause_is_among_those_named() {
    let claims = claims();
    let prepared = Prepared::of(&claims, &Limits::default()).unwrap();
    let values = prepared.values(&claims);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut planted, mut named, mut tried) = (0, 0, 0);
    while planted < draws() && tried < 100 * draws() {
        tried += 1;
        let cause = &prepared.causes[random.random_range(0..prepared.causes.len())];
        let truth = consistent(&prepared, &values, &mut random);
        let sign = if random.random_bool(0.5) { -1.0 } else { 1.0 };
        let measured = match cause.limit {
            Some(limit) => &truth + prepared.stacked(cause, &truth) * limit * sign * random.random_range(0.3..1.0),
            None => prepared.unrestated(cause, &truth),
        };
        // a bar within its limit is part of the budget
        let is_bar = matches!(cause.kind, Kind::Bar { .. });
        if is_bar || prepared.sigmas(&(&measured - &truth)) < VISIBLE {
            continue;
        }
        planted += 1;
        let found = prepared.judge(&measured);
        let is_it = found
            .verdicts
            .iter()
            .any(|verdict| verdict.is_named() && std::ptr::eq(&prepared.causes[verdict.cause], cause));
        if !is_it {
            let verdict = found.verdicts.iter().find(|v| std::ptr::eq(&prepared.causes[v.cause], cause));
            println!(
                "missed {:?} in {:?}: {verdict:?}, {} disagreements",
                cause.kind,
                cause.claim,
                found.disagreements.len()
            );
        }
        named += usize::from(is_it);
    }
    println!("{named} of {planted} planted causes named");
    assert_eq!(planted, draws());
    assert!(named * 100 >= 95 * planted, "{named} of {planted}");
}

#[test]
fn thesis_results_end_in_a_verdict() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = [4, 5, 6].map(|chapter| format!("examples/thesis/published/chapter{chapter}.yaml"));
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
        command.arg("reconcile").args(&files).args(more).current_dir(root);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, json, _) = run(&["--json"]);
    assert_eq!(code, Some(0));
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["disagreements"].as_array().unwrap().len(), 1, "{}", value["disagreements"]);
    assert_eq!(value["degrees_of_freedom"], 16);
    let between = |error: &str, a: &str, b: &str| {
        let all = value["differences"].as_array().unwrap();
        let it = all.iter().find(|d| d["error"] == error && d["between"] == serde_json::json!([a, b])).unwrap();
        it["value"].as_f64().unwrap()
    };
    assert!((between("EB0A", "chapter 4", "chapter 5") + 7.91).abs() < 1e-6);
    assert!((between("EB0C", "chapter 5", "chapter 6") + 18.86).abs() < 1e-6);
    // a bar that is believed to a hundredth of a micron leaves more to explain
    let (_, json, _) = run(&["--json", "--bar", "0.1 um", "--slides", "0.1 um", "--ball", "0.1 um"]);
    let strict: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(strict["disagreements"].as_array().unwrap().len() > 1);
    let (code, _, message) = run(&["--bar", "5"]);
    assert_eq!(code, Some(2));
    assert!(message.contains("--bar 5"), "{message}");
}

/// JSON of the published results with more arguments.
fn published_json(more: &[&str]) -> serde_json::Value {
    let files = [4, 5, 6].map(|chapter| format!("examples/thesis/published/chapter{chapter}.yaml"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
    command.arg("reconcile").args(&files).arg("--json").args(more).current_dir(env!("CARGO_MANIFEST_DIR"));
    serde_json::from_slice(&command.output().unwrap().stdout).unwrap()
}

#[test]
fn json_holds_what_its_schema_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("schemas/reconcile.json")).unwrap();
    let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
    let check = |value: &serde_json::Value| schema_check::violations_of(&schema, value);
    // one disagreement; limits so wide that there is none and no cause is tried
    let found = published_json(&[]);
    for value in [&found, &published_json(&["--bar", "9 um", "--slides", "9 um", "--ball", "9 um"])] {
        assert_eq!(check(value), Vec::<String>::new());
    }
    // the check itself can fail
    let mut wrong = found.clone();
    wrong["results"][0]["errors"]["EX0C"]["unit"] = "mm".into();
    wrong["differences"][0]["between"] = serde_json::json!(["chapter 4"]);
    wrong["causes"][0]["explains"] = serde_json::json!(["1"]);
    wrong["further"] = 1.into();
    wrong.as_object_mut().unwrap().remove("chi2");
    assert_eq!(check(&wrong).len(), 5, "{:?}", check(&wrong));
    let documented = std::fs::read_to_string(root.join("docs/json.md")).unwrap();
    let of = |place: &serde_json::Value| place["properties"].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let inner = |key: &str| of(&schema["properties"][key]["items"]);
    let deciding = of(&schema["properties"]["deciding_test"]);
    let keys = [of(&schema), inner("results"), inner("differences"), inner("disagreements"), inner("causes"), deciding];
    for key in keys.concat() {
        assert!(documented.contains(&format!("`{key}`")), "docs/json.md does not name {key}");
    }
}

#[test]
fn wrong_files_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let session = root.join("examples/thesis/chapter5/session.yaml");
    let text = std::fs::read_to_string(root.join("examples/thesis/published/chapter5.yaml")).unwrap();
    let text = text.replace("../chapter5/session.yaml", session.to_str().unwrap());
    let cases: [(&str, &str, &str); 6] = [
        (
            "method: chapter5",
            "method: chapter55",
            "unknown method 'chapter55'; did you mean 'chapter5'? (allowed: chapter4, chapter5, chapter6, fit)",
        ),
        ("value: 4.48 arcsec", "value: 4.48", "4.48"),
        ("EB0C:", "EBC:", "EBC is a component error; results compared are location errors such as EX0C"),
        ("deviation: 0.579 arcsec", "deviation: -0.579 arcsec", "a standard deviation is zero or more"),
        ("EB0C:", "EB0Q:", "no axis 'Q'"),
        ("name:", "title:", "unknown key 'title'"),
    ];
    for (found, replaced, message) in cases {
        let file = folder.path().join("wrong.yaml");
        std::fs::write(&file, text.replace(found, replaced)).unwrap();
        let refusal = load_claim(&file).unwrap_err().to_string();
        assert!(refusal.contains(message) && refusal.contains("wrong.yaml:"), "{refusal}");
    }
    let one = Prepared::of(&claims()[..1], &Limits::default()).err().unwrap().to_string();
    assert_eq!(one, "one result alone cannot disagree; name two or more files");
    let other_method =
        std::fs::write(folder.path().join("six.yaml"), text.replace("method: chapter5", "method: chapter6"));
    other_method.unwrap();
    let claim = load_claim(&folder.path().join("six.yaml")).unwrap();
    let refusal = Prepared::of(&[claims()[0].clone(), claim], &Limits::default()).err().unwrap().to_string();
    assert!(refusal.contains("chapter6 needs tests of A without extension at two positions"), "{refusal}");
}

#[test]
fn any_design_with_the_fit_takes_part() {
    let mut claims = claims();
    claims[0].reduction = fiveaxis::session::Reduction::Fit;
    let prepared = Prepared::of(&claims, &Limits::default()).unwrap();
    let found = prepared.judge(&prepared.values(&claims));
    // least squares over the same circles is as uncertain as the closed formulas, within the weight of pivots and bars
    let by_formula = Prepared::of(&self::claims(), &Limits::default()).unwrap();
    for k in 0..8 {
        let (fit, formula) = (prepared.covariance()[(k, k)].sqrt(), by_formula.covariance()[(k, k)].sqrt());
        println!("{}: {fit:.3} by the fit, {formula:.3} by the formulas", claims[0].values[k].name);
        assert!((fit / formula - 1.0).abs() < 0.15);
    }
    assert_eq!(found.degrees_of_freedom, 16);
}

#[test]
fn results_of_two_machines_are_refused() {
    let mut claims = claims();
    claims[1].session.machine.name = "another".into();
    let said = Prepared::of(&claims, &Limits::default()).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("Hermle C600U") && said.contains("another"), "{said}");
    claims[1].session.machine.name = claims[0].session.machine.name.clone();
    let tilt = claims[1].session.machine.axis_index("A").unwrap();
    claims[1].session.machine.axes[tilt].origin.z += 0.01;
    let said = Prepared::of(&claims, &Limits::default()).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("A about"), "{said}");
}

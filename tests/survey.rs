//! The survey of topologies: all codes, restarts, shards merged against one run, and what is refused.

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::Output;

use fiveaxis::load::standard_kit;
use fiveaxis::machine::StructuralCode;
use fiveaxis::plan::{Settings, plan};
use fiveaxis::survey::{Shard, codes, envelope, outcome, outcome_of, representative, settings};
use rayon::prelude::*;

/// Topologies of all three families whose plans are quick.
const CODES: [&str; 5] = ["[wCAbYXZt]", "[wACXYZbt]", "[wCYbXZAt]", "[wbXYZCAt]", "[wbZBAXYt]"];

fn run(arguments: &[&str]) -> Output {
    assert_cmd::Command::cargo_bin("fiveaxis").expect("built").arg("survey").args(arguments).output().expect("runs")
}

/// Runs the survey of the five topologies with more arguments.
fn survey(more: &[&str]) -> Output {
    let mut arguments: Vec<&str> = CODES.iter().flat_map(|code| ["--code", code]).collect();
    arguments.extend(more);
    run(&arguments)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

#[track_caller]
fn refused(output: &Output, says: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(output.stdout.is_empty());
    assert!(stderr.contains(says), "{stderr}");
    assert_eq!(stderr.trim_end().lines().count(), 1, "{stderr}");
}

#[test]
fn there_are_2160_topologies_and_shards_share_them_out() {
    let all = codes();
    let distinct: HashSet<String> = all.iter().map(|code| code.to_string()).collect();
    assert_eq!(distinct.len(), 2160);
    // three linear and two rotary axes of distinct letters, and each code reads back
    for code in &all {
        let rotary = code.axis_names().filter(|name| "ABC".contains(name.as_str())).count();
        assert_eq!((code.axis_names().count(), rotary), (5, 2), "{code}");
        assert_eq!(StructuralCode::parse(&code.to_string()).as_ref(), Ok(code));
    }
    let mut held = vec![0; all.len()];
    for index in 1..=64 {
        let shard = Shard::parse(&format!("{index}/64")).expect("exists");
        (0..all.len()).filter(|&place| shard.holds(place)).for_each(|place| held[place] += 1);
    }
    assert!(held.iter().all(|&times| times == 1));
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_row_is_what_plan_finds_for_that_topology() {
    assert_eq!(settings(), Settings::default());
    let kit = standard_kit().expect("kit");
    // none of them stands for itself: linear axes in other orders and the bed elsewhere between them, in all families
    let others = ["[wCAYbXZt]", "[wZAXYbCt]", "[wYCXbZAt]", "[wXbBZYCt]", "[wAYXCZbt]"];
    others.par_iter().for_each(|text| {
        let code = StructuralCode::parse(text).expect("code");
        assert_ne!(representative(&code), code);
        let (machine, bodies) = envelope(&code);
        let own = outcome_of(&code, &plan(&machine, &bodies, &kit, &settings()).expect("plans"));
        let row = outcome(&code, &kit, &settings()).expect("plans");
        let off = |one: Option<f64>, other: Option<f64>| (one.unwrap_or(0.0) - other.unwrap_or(0.0)).abs();
        assert!((own.minutes - row.minutes).abs() < 1e-6, "{own:?} {row:?}");
        assert!(off(own.position_mm, row.position_mm) < 1e-9, "{own:?} {row:?}");
        assert!(off(own.orientation_rad, row.orientation_rad) < 1e-12, "{own:?} {row:?}");
        let alike = fiveaxis::survey::Outcome {
            minutes: row.minutes,
            position_mm: row.position_mm,
            orientation_rad: row.orientation_rad,
            one_pivot: row.one_pivot,
            ..own
        };
        assert_eq!(alike, row);
    });
}

#[test]
fn topologies_alike_keep_their_rotary_axes_and_sides() {
    let all = codes();
    let rotary = |code: &StructuralCode| -> (Vec<String>, usize) {
        let is_rotary = |name: &&String| "ABC".contains(name.as_str());
        let names = code.axis_names().map(|name| name.to_string()).filter(|name| is_rotary(&name)).collect();
        (names, code.workpiece_side.iter().filter(is_rotary).count())
    };
    for code in &all {
        let stands = representative(code);
        assert_eq!(rotary(&stands), rotary(code), "{code} {stands}");
        assert_eq!(representative(&stands), stands, "{code}");
    }
    // X, Y and Z fall before, between and behind two rotary axes in either order, three pairs of them, on three sides of the bed
    let classes: HashSet<String> = all.iter().map(|code| representative(code).to_string()).collect();
    assert_eq!(classes.len(), 27 * 2 * 3 * 3);
}

#[test]
fn a_table_table_machine_is_tested_from_one_pivot_and_a_head_is_not_seen_whole() {
    let kit = standard_kit().expect("kit");
    let plan = |code: &str| outcome(&StructuralCode::parse(code).expect("code"), &kit, &settings()).expect("plans");
    let tables = plan("[wCAbYXZt]");
    assert_eq!((tables.errors, tables.visible, tables.determined), (8, 8, 8));
    assert!(tables.is_fully_tested_from_one_pivot());
    // three translations of the whole head move no length but through the pivots
    let heads = plan("[wbXYZCAt]");
    assert_eq!((heads.errors, heads.visible, heads.determined), (8, 5, 5));
    assert_eq!(heads.undetermined, ["EX0C", "EY0C", "EZ0A"]);
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn merged_shards_equal_the_one_run_and_a_stopped_run_goes_on() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let whole = survey(&["--out", text(&at("whole"))]);
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let read = |name: &str| fs::read(at(name)).expect(name);
    for shard in ["1/3", "2/3", "3/3"] {
        // two folders, as two jobs would have them
        let out = if shard == "2/3" { at("second") } else { at("first") };
        assert!(survey(&["--out", text(&out), "--shard", shard]).status.success());
    }
    let merge = run(&["merge", text(&at("first")), text(&at("second")), "--out", text(&at("merged")), "--json"]);
    assert!(merge.status.success(), "{}", String::from_utf8_lossy(&merge.stderr));
    let json: serde_json::Value = serde_json::from_slice(&merge.stdout).expect("JSON alone");
    assert_eq!(json["topologies"], 5);
    for name in ["survey.csv", "survey.html"] {
        assert_eq!(read(&format!("merged/{name}")), read(&format!("whole/{name}")), "{name}");
    }
    let page = String::from_utf8(read("whole/survey.html")).expect("text");
    assert!(page.contains("Which configurations can be fully tested with one pivot setup?"));
    assert!(CODES.iter().all(|code| page.contains(code)));

    // stopped in the third row: two rows stay as they are, even one that was marked, the rest is done again
    let rows = String::from_utf8(read("whole/shard-1-of-1.csv")).expect("text");
    let lines: Vec<&str> = rows.lines().collect();
    assert_eq!(lines.len(), 2 + CODES.len());
    let marked = lines[2].rsplit_once(',').expect("cells").0.to_string() + ",4711";
    let stopped = format!("{}\n{}\n{marked}\n{}\n{}", lines[0], lines[1], lines[3], &lines[4][..lines[4].len() / 2]);
    fs::create_dir(at("stopped")).expect("folder");
    fs::write(at("stopped/shard-1-of-1.csv"), stopped).expect("written");
    assert!(survey(&["--out", text(&at("stopped"))]).status.success());
    let unmarked = String::from_utf8(read("stopped/survey.csv")).expect("text").replace(&marked, lines[2]);
    assert_eq!(unmarked.as_bytes(), read("whole/survey.csv"));
    assert!(String::from_utf8(read("stopped/survey.csv")).expect("text").contains(",4711\n"));
    // nothing left to do: the same files again
    let before = read("whole/survey.html");
    assert!(survey(&["--out", text(&at("whole"))]).status.success());
    assert_eq!(read("whole/survey.html"), before);
}

#[test]
fn bad_shards_are_refused_with_one_message() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let out = at("out");
    let out = text(&out);
    refused(
        &run(&["--out", out, "--shard", "65/64"]),
        "shard 65/64 does not exist; with 64 shards they are 1/64 to 64/64",
    );
    refused(&run(&["--out", out, "--shard", "0/64"]), "shard 0/64 does not exist");
    refused(&run(&["--out", out, "--shard", "1/9999"]), "9999 shards are more than the 2160 topologies");
    refused(
        &run(&["--out", out, "--shard", "three"]),
        "shard 'three' is not understood; write NUMBER/COUNT, e.g. 3/64",
    );
    refused(&run(&["--out", out, "--code", "[wCAbYXZUt]"]), "is none of the 2160 topologies");
    refused(&run(&["--out", out, "--code", "[wCAbYXZt]", "--code", "wCAbYXZt"]), "stands twice");
    assert!(!at("out").exists());
    refused(&run(&["merge", text(&at("nowhere")), "--out", out]), "cannot be read");
    fs::create_dir(at("empty")).expect("folder");
    refused(&run(&["merge", text(&at("empty")), "--out", out]), "holds no shard");

    let shards = at("shards");
    for shard in ["1/2", "2/2"] {
        assert!(survey(&["--out", text(&shards), "--shard", shard]).status.success());
    }
    let (first, second) = (shards.join("shard-1-of-2.csv"), shards.join("shard-2-of-2.csv"));
    let (one, two) = (fs::read_to_string(&first).expect("there"), fs::read_to_string(&second).expect("there"));
    let merge = || run(&["merge", text(&shards), "--out", out]);
    let check = |changed: String, says: &str| {
        fs::write(&second, changed).expect("written");
        refused(&merge(), says);
        fs::write(&second, &two).expect("written");
    };
    check(two[..two.len() - 4].to_string(), "its last row is cut off; run shard 2/2 again");
    check(two.lines().take(3).map(|line| format!("{line}\n")).collect(), "has 1 of 2 rows; run shard 2/2 again");
    check(two.replace("survey rules", "survey rules 9"), "are of different surveys");
    check(two.replace("shard 2/2", "shard 1/2"), "shard 1/2 is there twice");
    check(two.replace(",table-table,", ",table-chair,"), "has 'table-chair' for family");
    check(two.replace("code,family", "code,kind"), "which this version does not write");
    check("X,Y\n1,2\n".into(), "is no shard of a survey");
    let foreign = one.lines().nth(3).expect("row");
    check(two.replace(two.lines().nth(3).expect("row"), foreign), "which is not its own or stands twice");
    check(
        two.replace(two.lines().nth(3).expect("row"), two.lines().nth(2).expect("row")),
        "not its own or stands twice",
    );
    fs::remove_file(&second).expect("removed");
    refused(&merge(), "1 of 2 shards are missing: 2");
    fs::write(&second, two.replace("fiveaxis 0", "fiveaxis 99")).expect("written");
    refused(&survey(&["--out", text(&shards), "--shard", "2/2"]), "is of another survey");
    assert!(!at("out").exists());
}

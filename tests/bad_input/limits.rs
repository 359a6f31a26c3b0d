//! Files larger in some way than any real one: each is refused soon, and the limits stand in docs/formats.md.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use fiveaxis::load::limits;

use super::{MACHINE, RECORDING, SESSION, URDF, changed, folder_with, run};

/// Longest time of a refusal in an unoptimised program on a busy machine: seconds where nothing else runs.
const SOON: Duration = Duration::from_secs(60);

fn check_soon(name: &str, files: &[(&str, &[u8])], file: &str, message: &str) {
    let folder = folder_with(files);
    let start = Instant::now();
    let (code, out, error) = run(folder.path(), &["check", file]);
    let took = start.elapsed();
    assert_eq!((code, out.as_str()), (Some(2), ""), "{name}: {error}");
    assert!(error.contains(message) && error.len() < 2500, "{name}: {error}");
    assert!(took < SOON, "{name}: {took:?}");
}

fn check_machine(name: &str, text: &str, message: &str) {
    check_soon(name, &[("machine.yaml", text.as_bytes())], "machine.yaml", message);
}

fn check_recording(name: &str, text: &str, message: &str) {
    let files = [("machine.yaml", MACHINE), ("a.csv", text), ("session.yaml", SESSION)];
    check_soon(name, &files.map(|(name, text)| (name, text.as_bytes())), "session.yaml", message);
}

/// `count` pieces, each made from its number.
fn many(count: usize, piece: impl Fn(usize) -> String) -> String {
    (0..count).map(piece).collect()
}

#[test]
fn the_limits_stand_in_the_documents() {
    let mut table = String::from("| at most | of | because |\n|---|---|---|\n");
    for limit in limits::ALL {
        let _ = writeln!(table, "| {} | {} | {} |", limit.most, limit.of, limit.reason);
    }
    assert!(include_str!("../../docs/formats.md").contains(&table), "docs/formats.md lacks this table:\n{table}");
}

#[test]
fn recordings() {
    let rows = many(1_000_001, |row| format!("{row},1,1\n"));
    check_recording(
        "rows",
        &format!("time_s,A_deg,length_mm\n{rows}"),
        "a.csv: 1000001 rows of a recording or samples of a path; at most 1000000 are allowed, average the readings of every few rows or make the step wider",
    );
    check_recording("short rows", &"0\n".repeat(5_000_000), "4999999 rows");
    check_recording("empty lines", &"\n".repeat(20_000_000), "a.csv: is empty");
    let columns = many(1000, |column| format!(",c{column}"));
    check_recording(
        "columns",
        &changed(RECORDING, "length_mm", &format!("length_mm{columns}")),
        "a.csv:1: 1003 columns of a recording; at most 100 are allowed, remove columns",
    );
    let columns = many(100_000, |column| format!(",c{column}"));
    check_recording(
        "line",
        &changed(RECORDING, "length_mm", &format!("length_mm{columns}")),
        "bytes of a line; at most 10000 are allowed, check the file's line ends",
    );
    check_recording("one line", &"1".repeat(100_000_000), "a.csv:1: 100000000 bytes of a line");
    check_recording(
        "number",
        &changed(RECORDING, "-19.00", &"9".repeat(5000)),
        "column A_deg: 9999999999999999999999999999999999999999… is not a finite number",
    );
    let test = &SESSION[SESSION.find("  - name").unwrap()..];
    let rows = many(500_000, |row| format!("{row},{},100\n", 1e-4 * row as f64));
    let tests = many(5, |index| changed(test, "name: a", &format!("name: t{index}")));
    let session = format!("name: run\nmachine: machine.yaml\ntests:\n{tests}");
    let recording = format!("time_s,A_deg,length_mm\n{rows}");
    let files = [("machine.yaml", MACHINE), ("a.csv", &recording), ("session.yaml", &session)];
    check_soon(
        "rows of all tests",
        &files.map(|(name, text)| (name, text.as_bytes())),
        "session.yaml",
        "session.yaml:28:5: 2500000 rows of all tests together; at most 2000000 are allowed, average the readings of every few rows or split the session",
    );
}

#[test]
fn machines() {
    let links = many(20_000, |link| format!("  - {{name: l{link}, carried_by: C}}\n"));
    check_machine(
        "links",
        &format!("{MACHINE}links:\n{links}"),
        "machine.yaml:9:1: 20000 links of a machine; at most 1000 are allowed, leave out links that nothing names",
    );
    let names = many(100_000, |axis| format!("J{axis}, "));
    check_machine(
        "axes",
        &format!("name: m\nchain: [w, b, {names}t]\naxes: {{}}\n"),
        "machine.yaml:2:1: 100000 axes of a chain; at most 24 are allowed, leave out what stands still",
    );
    let body = "  - {name: p, link: b, box: {at: [0, 0, 0], size: [1, 1, 1]}}\n";
    check_machine("bodies", &format!("{MACHINE}bodies:\n{}", body.repeat(10_000)), "10000 solids of a machine");
    let corners = "[0, 0, 0], ".repeat(50_000);
    check_machine(
        "hull",
        &format!("{MACHINE}bodies:\n  - {{name: p, link: b, hull: [{corners}]}}\n"),
        "50000 corners of a hull",
    );
    let table = many(20_000, |row| format!("[{row}, 1 um], "));
    let with_table = changed(MACHINE, "C: {", &format!("C: {{component_errors: {{EXC: {{table: [{table}]}}}}, "));
    check_machine("table", &with_table, "20000 rows of a component error's table");
}

#[test]
fn texts_of_yaml() {
    let text = "x".repeat(3_000_000);
    check_machine(
        "value",
        &changed(MACHINE, "mill", &text),
        "3000000 characters of one text; at most 1000 are allowed",
    );
    check_machine("key", &format!("{MACHINE}{text}: 1\n"), "is not valid YAML here");
    check_machine("keys", &format!("{MACHINE}{}", many(50_000, |key| format!("k{key}: 1\n"))), "unknown key 'k0'");
    check_machine("number", &changed(MACHINE, "300]", &format!("{}]", "9".repeat(900))), "found the text");
    check_machine(
        "integer",
        &changed(MACHINE, "300]", "999999999999999999999999999999999999999999]"),
        "is not a finite",
    );
    check_machine("brackets", &"[".repeat(3_000_000), "is nested deeper than 40 levels");
    check_machine("dashes", &"- ".repeat(1_500_000), "is nested deeper than 40 levels");
    check_machine("braces", &"{a: ".repeat(700_000), "is nested deeper than 40 levels");
    let laughs = many(30, |k| format!("k{}: &a{} [{}]\n", k + 1, k + 1, format!("*a{k}, ").repeat(9)));
    check_machine("aliases", &format!("{MACHINE}k0: &a0 [lol]\n{laughs}"), "machine.yaml");
    check_machine("comments", &format!("{MACHINE}{}x: 1\n", "# c\n".repeat(200_000)), "unknown key 'x'");
}

#[test]
fn robot_descriptions() {
    let check = |name: &str, text: &str, message: &str| {
        check_soon(name, &[("arm.urdf", text.as_bytes())], "arm.urdf", message);
    };
    let joint = |k: usize| {
        format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"fixed\"><parent link=\"base\"/><child link=\"l{k}\"/></joint>\n"
        )
    };
    check(
        "joints",
        &changed(URDF, "</robot>", &format!("{}</robot>", many(10_000, joint))),
        "links of a machine; at most 1000 are allowed, leave out links that nothing names",
    );
    let attributes = many(60_000, |k| format!(" a{k}=\"1\""));
    check(
        "attributes",
        &changed(URDF, "<link name=\"base\"/>", &format!("<link name=\"base\"{attributes}/>")),
        "arm.urdf:2: 33 attributes of an element; at most 32 are allowed, remove the others",
    );
    let elements = "<visual/>".repeat(200_000);
    check("elements", &changed(URDF, "</robot>", &format!("{elements}</robot>")), "50001 elements of a robot");
    let text = "x".repeat(1_500_000);
    check("value", &changed(URDF, "\"base\"", &format!("\"{text}\"")), "1500000 characters of one text");
    // as many links as are allowed are read
    let folder =
        folder_with(&[("arm.urdf", changed(URDF, "</robot>", &format!("{}</robot>", many(990, joint))).as_bytes())]);
    let start = Instant::now();
    assert_eq!(run(folder.path(), &["check", "arm.urdf", "--tool-link", "tool"]).0, Some(0));
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
}

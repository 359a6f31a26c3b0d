//! The setup sheet against session, plan and programs written beside it: every number that is in both is the same.

use std::collections::BTreeMap;
use std::path::Path;

use fiveaxis::load::load_session;
use fiveaxis::machine::Machine;
use fiveaxis::session::{Path as TestPath, Test};
use serde_json::Value;

struct Planned {
    folder: tempfile::TempDir,
    json: Value,
    sheet: String,
}

/// Runs `plan --json --out`; `change` edits the machine file.
fn planned(machine: &str, change: impl Fn(String) -> String, arguments: &[&str]) -> Planned {
    let folder = tempfile::tempdir().expect("folder");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(machine);
    let mill = folder.path().join("mill.yaml");
    std::fs::write(&mill, change(std::fs::read_to_string(file).expect("shipped"))).expect("written");
    let out = folder.path().join("plan");
    let mut command = assert_cmd::Command::cargo_bin("fiveaxis").expect("built");
    command.arg("plan").arg(&mill).args(arguments).arg("--json").arg("--out").arg(&out);
    let output = command.output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = serde_json::from_slice(&output.stdout).expect("JSON alone");
    let sheet = std::fs::read_to_string(out.join("setup-sheet.html")).expect("sheet");
    Planned { folder, json, sheet }
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// Text without tags.
fn bare(html: &str) -> String {
    let texts = html.split('<').map(|part| part.split_once('>').map_or("", |(_, text)| text));
    unescaped(&texts.collect::<Vec<_>>().join(" "))
}

/// Rows of all tables: cells without tags.
fn rows(html: &str) -> Vec<Vec<String>> {
    html.split("<tr>")
        .skip(1)
        .map(|row| {
            let row = row.split("</tr>").next().expect("row");
            let cells =
                row.split("</t").map(|cell| format!("<x>{}", cell.trim_start_matches("d>").trim_start_matches("h>")));
            let cells: Vec<String> = cells.map(|cell| bare(&cell).trim().to_string()).collect();
            cells[..cells.len() - 1].to_vec()
        })
        .collect()
}

/// All numbers in a text, in order.
fn numbers(text: &str) -> Vec<f64> {
    let other = |c: char| !(c.is_ascii_digit() || c == '.' || c == '-' || c == '+');
    text.split(other).filter_map(|word| word.trim_end_matches('.').parse().ok()).collect()
}

/// The sheet of paper of a test: keys and values, the table of readings, the pictures.
struct Page {
    values: BTreeMap<String, String>,
    readings: BTreeMap<String, Vec<f64>>,
    pictures: Vec<String>,
    html: String,
}

fn page(sheet: &str, name: &str) -> Page {
    let html = sheet
        .split("<section>")
        .find(|section| section.contains(&format!(": {name}</h2>")))
        .unwrap_or_else(|| panic!("no page of {name}"));
    let mut page = Page {
        values: BTreeMap::new(),
        readings: BTreeMap::new(),
        pictures: html.split("<svg").skip(1).map(|svg| svg.split("</svg>").next().expect("end").to_string()).collect(),
        html: html.to_string(),
    };
    for row in rows(html) {
        match &row[..] {
            [key, value] => {
                assert!(page.values.insert(key.clone(), value.clone()).is_none(), "{key} twice");
            }
            [axis, cells @ ..] if axis.contains(", ") => {
                let axis = axis.split(", ").next().expect("axis").to_string();
                page.readings.insert(axis, cells.iter().map(|cell| cell.parse().expect("number")).collect());
            }
            _ => {}
        }
    }
    page
}

fn near(found: &[f64], due: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), due.len(), "{what}: {found:?} {due:?}");
    assert!(found.iter().zip(due).all(|(a, b)| (a - b).abs() <= tolerance), "{what}: {found:?} {due:?}");
}

/// A test's page against the session test (rising) and the plan's own entry of it.
fn check(plan: &Planned, machine: &Machine, test: &Test, entry: &Value, offsets: &BTreeMap<String, f64>) {
    let name = test.name.strip_suffix("-ccw").expect("rising");
    let page = page(&plan.sheet, name);
    let value = |key: &str| page.values.get(key).unwrap_or_else(|| panic!("{name}: no '{key}'")).as_str();
    let number = |key: &str| entry[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    // mounted
    let (p, s) = (test.pivot.at, test.spindle_ball.at);
    near(&numbers(value("pivot ball")), &[p.x, p.y, p.z], 5e-4, "pivot ball");
    near(&numbers(value("spindle ball")), &[s.x, s.y, s.z], 5e-4, "spindle ball");
    assert!(value("pivot").contains(&format!("(link {})", test.pivot.link)), "{}", value("pivot"));
    assert!(value("pivot").contains(entry["mount"].as_str().expect("mount")));
    assert!(numbers(value("pivot")).iter().any(|x| (x - number("height_mm")).abs() < 5e-4), "{}", value("pivot"));
    let bar = test.bar_length_mm.expect("planned");
    let parts = numbers(value("bar"));
    assert_eq!(parts[0], bar);
    if parts.len() > 1 {
        assert_eq!(parts[1..].iter().sum::<f64>(), bar, "{}", value("bar"));
        assert!(parts[2..].iter().all(|part| [50.0, 150.0, 300.0].contains(part)) && parts[1] == 100.0);
    }
    // what the calibrator certifies: 100, 150 and 300 of the standard kit
    assert_eq!(value("zero the bar").starts_with("on the calibrator at"), [100.0, 150.0, 300.0].contains(&bar));
    // the spindle side: from the nose of the machine file
    let spindle = value("spindle side");
    let of_nose = |at: f64| (machine_nose(plan) - at, spindle.contains("straight stem"));
    let (from_nose, is_straight) = of_nose(s.z);
    assert!(numbers(spindle).iter().any(|x| (x - from_nose).abs() < 5e-4), "{spindle}: {from_nose}");
    assert_eq!(is_straight, s.x.hypot(s.y) < 1e-6, "{spindle}");
    if !is_straight {
        let arm = s.x.hypot(s.y);
        assert!(spindle.contains(&format!("arm {arm} mm")), "{spindle}");
        let towards = if s.x.abs() > s.y.abs() { ('x', s.x) } else { ('y', s.y) };
        assert!(
            spindle.contains(&format!("towards {}{}", if towards.1 > 0.0 { '+' } else { '-' }, towards.0)),
            "{spindle}"
        );
    }
    let mounting = &entry["mounting"];
    near(&[mounting["nose_to_ball_mm"].as_f64().expect("mm")], &[from_nose], 1e-6, "nose to ball");
    assert_eq!(mounting["arm_mm"].is_null(), is_straight);
    let parts = mounting["bar_parts_mm"].as_array().expect("parts");
    assert_eq!(parts.iter().filter_map(Value::as_f64).sum::<f64>(), bar);
    // where the pivot is placed: the shipped machines of these tests carry the spindle ball by all slides, or the table by some
    assert!(
        value("place it").contains("jog to") && value("place it").contains("within 0.06 mm, 3 sigma"),
        "{}",
        value("place it")
    );
    // run
    let (from, to) = match test.path.as_ref().expect("path") {
        TestPath::Sweep { from, to, .. } | TestPath::Circle { from, to, .. } => (*from, *to),
    };
    near(&numbers(value("sweep")), &[from, to], 0.0, "sweep");
    let feed = numbers(value("feed"));
    assert_eq!(feed[0], test.feed_mm_per_min.expect("planned"));
    assert!((feed[1] - 2.0 * number("minutes")).abs() < 0.051, "{feed:?}");
    assert!(numbers(value("run-in")).iter().all(|x| *x == test.overshoot.expect("planned")));
    assert!((numbers(value("least clearance"))[0] - number("clearance_mm")).abs() < 0.051);
    for part in entry["nearest"].as_array().expect("pair") {
        assert!(value("least clearance").contains(part.as_str().expect("name")));
    }
    let ends = value("arc ends at");
    for end in entry["sweep_ended_by"].as_array().expect("ends").iter().filter(|_| to - from < 360.0) {
        let end = end.as_str().expect("text");
        assert!(
            ends.contains(end) || end == "axis range" && (ends.contains("range") || ends.contains("turn")),
            "{ends}: {end}"
        );
    }
    assert_eq!(value("recordings"), format!("{name}-ccw.csv, {name}-cw.csv"));
    let programs: Vec<&str> = value("program").split(", ").collect();
    assert_eq!(programs.len(), 4);
    for program in programs {
        assert!(plan.sheet.contains(&program.replace(name, "dry-run")), "{program}");
        assert!(plan.folder.path().join("plan").join(program).is_file(), "{program}");
        assert!(program.contains(name));
    }
    // readings: park, start, arc, end
    for (axis, reading) in &page.readings {
        let k = machine.axis_index(axis).expect("axis");
        let park = entry["park"][axis].as_f64().expect("park") + offsets[axis];
        assert!((reading[0] - park).abs() < 0.6e-4, "{axis} {reading:?} {park}");
        if let Some(q) = test.positions[k] {
            let q = machine.axes[k].kind.to_file_unit(q) + offsets[axis];
            assert!(reading[1..].iter().all(|x| (x - q).abs() < 0.6e-4), "{axis} {reading:?} {q}");
        }
        if let Some(TestPath::Sweep { axis: swept, .. }) = &test.path
            && *swept == k
        {
            near(&reading[2..4], &[from + offsets[axis], to + offsets[axis]], 0.6e-4, "arc");
        }
    }
    assert_eq!(page.readings.len(), machine.axes.len());
    // the way: where each axis comes to stand
    let way = value("way to the start");
    for leg in entry["approach"].as_array().expect("legs") {
        let (axis, to) = (leg[0].as_str().expect("axis"), leg[1].as_f64().expect("place"));
        let to = ((to + offsets[axis]) * 1e4).round() * 1e-4 + 0.0;
        // the JSON and the sheet round a fifth digit in their own ways
        let is_there = [0.0, -1e-4, 1e-4].iter().any(|off| way.contains(&format!("{axis} {:.4}", to + off)));
        assert!(is_there, "{way}: {axis} {to}");
    }
    pictures(&page, bar);
}

/// Height of the nose above the machine file's zero; the shipped machines of these tests have it on z.
fn machine_nose(plan: &Planned) -> f64 {
    let text = std::fs::read_to_string(plan.folder.path().join("mill.yaml")).expect("machine");
    let nose = text.lines().find(|line| line.starts_with("spindle:")).expect("spindle");
    let nose = numbers(nose.split("nose: ").nth(1).expect("nose").split(']').next().expect("end"));
    assert_eq!(nose[..2], [0.0, 0.0]);
    nose[2]
}

/// Two views to scale: the balls lie a bar's length apart, names and scale are there.
fn pictures(page: &Page, bar: f64) {
    assert_eq!(page.pictures.len(), 2);
    let circles: Vec<Vec<[f64; 2]>> = page
        .pictures
        .iter()
        .map(|svg| {
            let of = |circle: &str, key: &str| -> f64 {
                circle
                    .split(&format!("{key}=\""))
                    .nth(1)
                    .expect(key)
                    .split('"')
                    .next()
                    .expect("end")
                    .parse()
                    .expect("number")
            };
            svg.split("<circle ").skip(1).map(|circle| [of(circle, "cx"), of(circle, "cy")]).collect()
        })
        .collect();
    let [front, right] = [&circles[0], &circles[1]];
    assert_eq!((front.len(), right.len()), (2, 2));
    let along = |views: &[[f64; 2]], k: usize| views[1][k] - views[0][k];
    let length = along(front, 0).hypot(along(right, 0)).hypot(along(front, 1));
    assert!((length - bar).abs() < 0.2, "{length} {bar}");
    assert!((along(front, 1) - along(right, 1)).abs() < 0.15);
    for (svg, names) in page.pictures.iter().zip([["x", "z"], ["y", "z"]]) {
        for word in ["pivot ball", "spindle ball", &format!("bar {bar} mm"), names[0], names[1]] {
            assert!(svg.contains(&format!(">{word}</text>")), "{word}");
        }
        // the scale bar is as long as it says
        let drawn: f64 = svg
            .split(" d=\"")
            .nth(1)
            .and_then(|d| d.split('h').nth(1))
            .and_then(|d| d.split('M').next())
            .expect("scale")
            .parse()
            .expect("mm");
        assert!(svg.ends_with(&format!(">{drawn} mm</text>")), "{drawn}");
    }
}

/// A whole sheet.
fn check_sheet(plan: &Planned) {
    let session = load_session(&plan.folder.path().join("plan/session.yaml")).expect("session");
    let machine = &session.machine;
    let zero = |k: usize| if machine.machine_zero.iter().all(Option::is_some) { machine.machine_zero[k] } else { None };
    let offsets: BTreeMap<String, f64> =
        (0..machine.axes.len()).map(|k| (machine.axes[k].name.clone(), zero(k).unwrap_or(0.0))).collect();
    let entries = plan.json["tests"].as_array().expect("tests");
    assert_eq!(entries.len(), session.tests.len());
    assert!(!entries.is_empty());
    for (test, entry) in session.tests.iter().zip(entries).filter(|(test, _)| test.name.ends_with("-ccw")) {
        assert_eq!(entry["name"], test.name.as_str());
        check(plan, machine, test, entry, &offsets);
    }
    // the plan's own page: order, forecast, curve
    let first = plan.sheet.split("<section>").next().expect("overview");
    let cells = rows(first);
    let row = |key: &str| cells.iter().find(|row| row[0] == key).unwrap_or_else(|| panic!("no row {key}"));
    for (name, error) in plan.json["location_errors"].as_object().expect("errors") {
        let found = [numbers(&row(name)[1])[0], numbers(&row(name)[2])[0]];
        let due = ["sigma", "sigma_relative"].map(|key| error[key].as_f64().expect(key));
        near(&found, &due, 0.0051, name);
        assert_eq!(row(name)[3].starts_with("undetermined"), error["determined"] == false, "{name}");
        assert!(row(name)[3].ends_with(error["reason"].as_str().expect("reason")), "{name}");
    }
    let minutes = plan.json["minutes"].as_f64().expect("minutes");
    assert!(bare(first).contains(&format!("about {minutes:.0} minutes")));
    let curve = plan.json["trade_off"].as_array().expect("curve");
    let shown: Vec<&Vec<String>> = cells.iter().skip_while(|row| row[0] != "tests").skip(1).take(curve.len()).collect();
    for (row, point) in shown.iter().zip(curve) {
        let found: Vec<f64> = row.iter().map(|cell| numbers(cell)[0]).collect();
        let keys = ["tests", "minutes", "pivot_setups", "worst_position_um", "worst_orientation_arcsec"];
        near(&found, &keys.map(|key| point[key].as_f64().expect(key)), 0.051, "curve");
    }
    // two curves with a dot a point; those of this plan are large
    assert_eq!(first.matches("<circle ").count(), 2 * curve.len());
    assert_eq!(first.matches("r=\"6\"").count(), 2);
    // it stands alone
    assert!(!plan.sheet.contains("http") && !plan.sheet.contains("src="));
    assert_eq!(plan.sheet.matches("<section").count(), 1 + entries.len() / 2);
}

#[test]
fn following_runs_and_circles() {
    let plan = planned("hermle-c600u.yaml", |text| text, &["--circles"]);
    check_sheet(&plan);
    assert!(plan.sheet.contains("4 µm and 4 arcsec (one standard deviation): reached"));
    assert!(plan.sheet.contains("at least 5 mm clear"));
    assert!(plan.sheet.contains("100 mm ball bar with extensions: 100 mm bar; extensions 50, 150, 300 mm"));
}

#[test]
fn machine_coordinates_and_other_conditions() {
    let zeros = "machine_zero: {X: 312.5, Y: -410, Z: 96.125, A: -0.5, C: 12.25}\ngauge_length: 110\naxes:\n";
    let arguments = ["--method", "chapter5", "--margin", "4", "--sigma", "6um,8arcsec", "--feed", "350"];
    // a range that ends a sweep before anything else does
    let short = |text: String| text.replacen("axes:\n", zeros, 1).replacen("[-110, 30]", "[-110, 20]", 1);
    let plan = planned("hermle-c600u.yaml", short, &arguments);
    check_sheet(&plan);
    let overview = bare(plan.sheet.split("<section>").next().expect("overview"));
    for words in [
        "machine coordinates of the control",
        "X 312.5000",
        "6 µm and 8 arcsec",
        "at least 4 mm clear",
        "350 mm/min",
        "method of chapter 5",
    ] {
        assert!(overview.contains(words), "{words}: {overview}");
    }
    assert!(plan.sheet.contains("The control reads (machine coordinates"));
    let names = plan.json["tests"].as_array().expect("tests").iter();
    let names = names.filter_map(|test| test["name"].as_str()?.strip_suffix("-ccw"));
    let all: Vec<String> = names.map(|name| page(&plan.sheet, name).values["arc ends at"].clone()).collect();
    assert!(all.iter().any(|ends| ends.contains("15°: the range of A, run-in and 0.1° kept off")), "{all:?}");
    // what the sheet says of the start is where the program goes
    let page = page(&plan.sheet, "a-100-1");
    let program = std::fs::read_to_string(plan.folder.path().join("plan/nc/sinumerik/a-100-1.mpf")).expect("program");
    for (axis, reading) in &page.readings {
        assert!(program.contains(&format!("G0 {axis}{:.5} SUPA", reading[0])), "{axis} {reading:?}");
    }
    // the run ends where the sheet says
    assert!(program.contains(&format!("G1 A{:.5} ", page.readings["A"][4])));
    let partly = planned(
        "hermle-c600u.yaml",
        |text| text.replacen("axes:\n", "machine_zero: {X: 312.5}\naxes:\n", 1),
        &["--method", "chapter5"],
    );
    check_sheet(&partly);
    assert!(partly.sheet.contains("machine_zero is stated for X 312.5000 but not for C, A, Y, Z and is not used"));
    assert_eq!(partly.json["without_machine_zero"], serde_json::json!(["C", "A", "Y", "Z"]));
}

#[test]
fn fixtures_and_bars_of_parts() {
    let plan = planned("fig-1-1-head-head-cb.yaml", |text| text, &["--method", "chapter7"]);
    check_sheet(&plan);
    assert!(plan.sheet.contains("flat fixture, arm 200 mm"));
    assert!(plan.sheet.contains("250 mm = 100 mm bar + 150 mm extension"));
    assert!(plan.sheet.contains("the calibrator has no 250 mm: zero the 100 mm part on it"));
}

#[test]
fn a_spindle_that_is_indexed_is_told_in_the_order_of_the_hands() {
    let plan = planned("hermle-c600u.yaml", |text| text, &["--method", "chapter5", "--index-spindle"]);
    check_sheet(&plan);
    let overview = bare(plan.sheet.split("<section>").next().expect("overview"));
    assert!(overview.contains("lock it before the spindle cup is mounted"), "{overview}");
    let names: Vec<&str> = plan.json["tests"]
        .as_array()
        .expect("tests")
        .iter()
        .filter_map(|test| test["name"].as_str()?.strip_suffix("-ccw"))
        .collect();
    let indexed: Vec<&&str> = names.iter().filter(|name| name.contains("indexed")).collect();
    assert!(!indexed.is_empty());
    for name in indexed {
        let at = names.iter().position(|other| other == name).expect("itself");
        let twin = name.replace("-indexed", "");
        // the same test at 0 degrees is run just before
        assert_eq!(names[at - 1], twin);
        let text = page(&plan.sheet, name);
        assert!(
            text.values["spindle at"].starts_with("180°") && text.values["spindle at"].contains(&twin),
            "{:?}",
            text.values["spindle at"]
        );
        assert!(text.html.contains("Mount before this test: spindle to 180°, cup left in"));
        assert!(page(&plan.sheet, &twin).values["spindle at"].starts_with("0°, locked; the same again at 180° is"));
    }
}

/// Plans of machine files: the sheet's first page in plain text, and every program.
fn sheet_and_programs(machine: &Path, out: &Path) -> (String, Vec<(String, String)>) {
    let mut command = assert_cmd::Command::cargo_bin("fiveaxis").expect("built");
    command.arg("plan").arg(machine).arg("--out").arg(out).assert().success();
    let sheet = std::fs::read_to_string(out.join("setup-sheet.html")).expect("sheet");
    let overview = bare(sheet.split("<section>").next().expect("overview"));
    let mut programs = Vec::new();
    for folder in ["generic", "linuxcnc", "heidenhain", "sinumerik"] {
        for file in std::fs::read_dir(out.join("nc").join(folder)).expect("programs") {
            let file = file.expect("file").path();
            programs.push((file.display().to_string(), std::fs::read_to_string(&file).expect("program")));
        }
    }
    (overview, programs)
}

#[test]
fn the_sheet_and_every_program_say_where_zero_is() {
    let folder = tempfile::tempdir().expect("folder");
    let mill = folder.path().join("dmu.yaml");
    let words = "--travels 500,450,400 --nose-to-table 80..480 --table 630 --tilt-above-table 0 --range B=-5..110 \
                 --range C=-360..360 --directions iso841";
    let mut command = assert_cmd::Command::cargo_bin("fiveaxis").expect("built");
    command
        .arg("init")
        .arg(&mill)
        .args(["--name", "DMU 50 like", "--code", "[wCBbXYZt]"])
        .args(words.split_whitespace());
    command.assert().success();
    let shipped = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let zeroed = folder.path().join("zeroed.yaml");
    let text = std::fs::read_to_string(shipped("hermle-c600u.yaml")).expect("shipped");
    let zeros = "machine_zero: {X: 312.5, Y: -410, Z: 96.125, A: -0.5, C: 12.25}\naxes:\n";
    // the line of C 20 mm to the right of the spindle
    let text = text.replacen("axes:\n", zeros, 1).replacen("C: {origin: [0, 0, 0]", "C: {origin: [20, 0, 0]", 1);
    std::fs::write(&zeroed, text).expect("written");
    let cases = [
        (mill, vec!["Z 0: spindle nose 185.000 mm above table top", "X 0 Y 0: spindle over the line of C"]),
        (
            zeroed,
            vec![
                "Z 0: spindle nose 185.000 mm above table top",
                "Z 0: spindle nose 110.000 mm above the line of A",
                "X 0 Y 0: spindle aside of the line of C by x -20.000 mm",
            ],
        ),
        (
            shipped("table-head-ba-horizontal.yaml"),
            vec![
                "Z 0: spindle nose 660.000 mm in front of the line of B",
                "line of the spindle 150.000 mm above table top",
            ],
        ),
        (shipped("head-head-ca-overhead-gantry.yaml"), vec!["Z 0: spindle nose", "X 0 Y 0: spindle", "middle of"]),
    ];
    for (k, (machine, due)) in cases.into_iter().enumerate() {
        let (overview, programs) = sheet_and_programs(&machine, &folder.path().join(format!("plan-{k}")));
        println!(
            "{}",
            overview.split("of the machine file, all axes at 0").nth(1).expect("zero").split("  ").next().expect("row")
        );
        for words in due {
            assert!(overview.contains(words), "{words}: {overview}");
            for (name, text) in &programs {
                let is_told = text.to_uppercase().contains(&words.to_uppercase());
                assert!(is_told, "{name}: {words}: {}", &text[..text.len().min(2000)]);
            }
        }
        assert!(!overview.contains("Nothing is mounted"), "{overview}");
        for words in ["one piece", "Do not cut it", "fiveaxis import NAME.csv --session session.yaml --out imported"] {
            assert!(overview.contains(words), "{words}: {overview}");
        }
        assert!(!overview.contains("Save the two directions"), "{overview}");
        if k == 1 {
            assert!(overview.contains("Z 96.1250"), "{overview}");
            let is_there = |(name, text): &(String, String)| name.contains("generic") || text.contains("Z 96.1250");
            assert!(programs.iter().all(is_there));
        }
    }
}

//! The catalogue of effects as the documents state it: the tables of docs/effects.md and the enumeration of the schema are made
//! from the library. `FIVEAXIS_WRITE=1 cargo test --test all catalogue::` writes them anew.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use fiveaxis::diagnose::{FaultKind, Threshold, Thresholds};
use fiveaxis::effects::{Driver, KINDS, Kind};
use fiveaxis::report::finding_words::what_mistake;

fn root(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// A table of Markdown with a row for every kind.
fn table(head: &[&str], cells: impl Fn(&Kind) -> Vec<String>) -> String {
    let row = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let head: Vec<String> = head.iter().map(|cell| cell.to_string()).collect();
    let rows = KINDS.iter().map(|kind| row(&cells(kind)));
    row(&head) + &format!("|{}\n", "---|".repeat(head.len())) + &rows.collect::<String>()
}

/// Tests of one document write it one after the other.
static WRITING: Mutex<()> = Mutex::new(());

/// What stands between a mark and the next end, or its replacement where it is to be written.
fn held(file: &str, mark: &str, end: &str, wanted: &str) {
    let _writing = WRITING.lock();
    let path = root(file);
    let text = std::fs::read_to_string(&path).expect("a document of the repository");
    let start = text.find(mark).unwrap_or_else(|| panic!("{file} has no mark {mark:?}")) + mark.len();
    let length = text[start..].find(end).unwrap_or_else(|| panic!("{file} has no end {end:?} after {mark:?}"));
    if std::env::var_os("FIVEAXIS_WRITE").is_some() {
        let written = format!("{}{wanted}{}", &text[..start], &text[start + length..]);
        std::fs::write(&path, written).expect("the document can be written");
        return;
    }
    let stands = &text[start..start + length];
    assert_eq!(
        stands, wanted,
        "{file} is not what the catalogue says: FIVEAXIS_WRITE=1 cargo test --test all catalogue::"
    );
}

#[test]
fn the_table_of_effects_is_made_from_the_catalogue() {
    let head = ["effect", "place", "components", "functions and formula", "parameters", "unit of size"];
    let cells = |kind: &Kind| {
        let d = &kind.documented;
        let name = format!("`{}`", kind.name);
        [name.as_str(), d.place, d.components, d.functions, d.parameters, d.unit].map(str::to_string).to_vec()
    };
    held("docs/effects.md", "<!-- made from the catalogue -->\n", "<!-- end -->", &table(&head, cells));
}

#[test]
fn the_table_of_causes_is_made_from_the_catalogue() {
    let cells = |kind: &Kind| vec![format!("`{}`", kind.name), kind.cause.to_string(), kind.remedy.to_string()];
    let wanted = table(&["effect", "usual cause", "remedy"], cells);
    held("docs/effects.md", "<!-- causes made from the catalogue -->\n", "<!-- end -->", &wanted);
}

#[test]
fn every_shape_parameter_is_documented_in_its_row() {
    for kind in KINDS {
        for parameter in kind.parameters {
            let named = format!("`{}`", parameter.name);
            assert!(kind.documented.parameters.contains(&named), "{}: {named} is not documented", kind.name);
        }
    }
}

#[test]
fn the_schema_of_diagnose_knows_every_effect_and_every_mistake_and_no_other() {
    let effects = KINDS.iter().map(|kind| kind.name);
    let names = effects.chain(FaultKind::ALL.iter().map(|kind| kind.name())).map(|name| format!("\"{name}\""));
    let mark = "\"effect\": {\n            \"type\": \"string\",\n            \"enum\": [";
    held("schemas/diagnose.json", mark, "]", &names.collect::<Vec<_>>().join(", "));
}

#[test]
fn the_schema_of_diagnose_knows_every_driver() {
    let names: Vec<String> = Driver::ALL.iter().map(|driver| format!("\"{}\"", driver.name())).collect();
    let mark = "\"driver\": {\n            \"type\": \"string\",\n            \"enum\": [";
    held("schemas/diagnose.json", mark, ", \"data fault\"", &names.join(", "));
}

#[test]
fn the_table_of_numbers_that_decide_is_made_from_the_library() {
    let number = |value: f64| if value.is_finite() { value.to_string() } else { "–".into() };
    let row =
        |t: &Threshold| format!("| `{}` | {} {} | {} | {} |\n", t.name, t.value, t.unit, number(t.off), t.meaning);
    let rows: String = Thresholds::default().list().iter().map(row).collect();
    let wanted = format!("| number | value | without the rule | meaning |\n|---|---|---|---|\n{rows}");
    held("docs/diagnosis.md", "<!-- thresholds made from the library -->\n", "<!-- end -->", &wanted);
}

#[test]
fn every_mistake_in_files_has_a_name_and_a_title_of_its_own_and_a_row() {
    let docs = std::fs::read_to_string(root("docs/diagnosis.md")).expect("a document");
    let mut told = BTreeSet::new();
    for kind in FaultKind::ALL {
        let name = kind.name();
        assert!(docs.contains(&format!("`{name}`")), "docs/diagnosis.md has no row with `{name}`");
        assert!(fiveaxis::effects::kind(name).is_none(), "{name} is an effect as well");
        let title = what_mistake(*kind, "pivot", &["C".to_string()]);
        assert!(title.starts_with("Data fault: "), "{name}: {title}");
        assert!(told.insert(name.to_string()) && told.insert(title), "{name} is told twice");
    }
    assert!(FaultKind::ALL.len() > 30);
}

#[test]
fn no_mistake_is_named_in_the_source_but_where_all_are() {
    let mut folders = vec![root("src")];
    // names of one word are those of other things as well
    let names: Vec<&str> = FaultKind::ALL.iter().map(|kind| kind.name()).filter(|name| name.contains('-')).collect();
    let mut listed = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of the source").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let source = std::fs::read_to_string(&path).expect("a source file");
            let named: Vec<&&str> = names.iter().filter(|name| source.contains(&format!("\"{name}\""))).collect();
            match path.ends_with("diagnose/fault_kind.rs") {
                true => listed = named.len(),
                false => assert!(named.is_empty(), "{} names {named:?}", path.display()),
            }
        }
    }
    assert_eq!(listed, names.len());
}

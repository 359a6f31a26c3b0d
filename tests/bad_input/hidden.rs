//! Names of any characters: refused, or shown as they are; nothing that a terminal obeys leaves the program, YAML reads back.

use std::path::Path;

use fiveaxis::load::printable::{escaped_lines, hidden_in};
use fiveaxis::load::{load_session, machine_from_yaml, recording_from_csv};
use fiveaxis::report::{machine_yaml, session_yaml};
use proptest::prelude::*;

use super::{MACHINE, RECORDING, SESSION, URDF, changed, folder_with, run};

/// Characters that do harm somewhere: to terminals, YAML, HTML, NC programs, eyes.
const HARMFUL: [&str; 24] = [
    "\u{1b}[31m",
    "\n",
    "\r",
    "\t",
    "\0",
    "\u{7}",
    "\u{85}",
    "\u{9b}",
    "\u{200b}",
    "\u{202e}",
    "\u{2066}",
    "\u{2028}",
    "\u{feff}",
    "\u{ad}",
    "\u{fffe}",
    "\u{e0041}",
    "'",
    "\"",
    ": ",
    " #",
    "- ",
    "\\",
    "<b>",
    "µ",
];

fn name() -> impl Strategy<Value = String> {
    let word =
        prop_oneof![any::<String>(), (0..HARMFUL.len()).prop_map(|k| HARMFUL[k].to_string()), "[a-z ~0-9.]{0,6}"];
    prop::collection::vec(word, 1..4).prop_map(|words| words.concat().chars().take(150).collect())
}

/// One visible message, its caret's lines kept.
fn is_visible(message: &str) -> bool {
    escaped_lines(message) == message
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn names_are_written_as_they_are_read(name in name()) {
        let mut machine = machine_from_yaml(Path::new("m.yaml"), MACHINE.into()).unwrap();
        machine.name = name.clone();
        match machine_from_yaml(Path::new("m.yaml"), machine_yaml(&machine)) {
            Ok(read) => prop_assert!(read == machine && hidden_in(&name).is_none()),
            Err(why) => prop_assert!(hidden_in(&name).is_some() && is_visible(&why.to_string()), "{:?}: {}", name, why),
        }
    }

    /// JSON's text is YAML's: whatever is typed comes in as this name, or not at all.
    #[test]
    fn no_hidden_character_of_a_name_is_read(name in name()) {
        let quoted = serde_json::to_string(&name).unwrap();
        for text in [
            changed(MACHINE, "mill", &quoted),
            format!("{MACHINE}links: [{{name: {quoted}, carried_by: C}}]\n"),
            format!("{MACHINE}{quoted}: 1\n"),
        ] {
            match machine_from_yaml(Path::new("m.yaml"), text) {
                Ok(machine) => prop_assert!(hidden_in(&machine.name).is_none() && machine.link_names.iter().all(|(name, _)| hidden_in(name).is_none())),
                Err(why) => prop_assert!(is_visible(&why.to_string()), "{}", why),
            }
        }
    }

    #[test]
    fn headers_and_fields_of_recordings_are_shown_or_refused(name in name()) {
        let machine = machine_from_yaml(Path::new("m.yaml"), MACHINE.into()).unwrap();
        let extra = RECORDING.replacen("length_mm\n", &format!("length_mm,{name}\n"), 1).replace(".00,", ".00,1,");
        for text in [extra, RECORDING.replacen("-19.00", &name, 1), RECORDING.replacen("A_deg", &name, 1)] {
            match recording_from_csv(Path::new("a.csv"), &text, &machine, Some(100.002)) {
                Ok(recording) => prop_assert!(recording.channels.iter().all(|(name, _)| hidden_in(name).is_none())),
                Err(why) => prop_assert!(is_visible(&why.to_string()), "{}", why),
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sessions_are_written_as_they_are_read(name in name(), setup in name(), file in name()) {
        let folder = folder_with(&[("machine.yaml", MACHINE.as_bytes()), ("a.csv", RECORDING.as_bytes()), ("session.yaml", SESSION.as_bytes())]);
        let path = folder.path().join("session.yaml");
        let mut session = load_session(&path).unwrap();
        session.name = name.clone();
        session.tests[0].pivot.setup = Some(setup.clone());
        session.tests[0].bar_setup = Some(file.clone());
        std::fs::write(&path, session_yaml(&session)).unwrap();
        let is_plain = [&name, &setup, &file].iter().all(|name| hidden_in(name).is_none());
        match load_session(&path) {
            Ok(read) => prop_assert!(read == session && is_plain),
            Err(why) => prop_assert!(!is_plain && is_visible(&why.to_string()), "{}", why),
        }
    }
}

fn check_output(name: &str, files: &[(&str, &[u8])], arguments: &[&str], message: &str) {
    let folder = folder_with(files);
    let (code, out, error) = run(folder.path(), arguments);
    assert_eq!(code, Some(2), "{name}: {error}");
    assert!(is_visible(&out) && is_visible(&error) && error.contains(message), "{name}: {error:?}");
}

#[test]
fn the_place_of_a_hidden_character_is_told() {
    let not_allowed = "line breaks, control characters and invisible ones are not allowed, remove it";
    let machine = changed(MACHINE, "mill", "\"mi\\e[31mll\"");
    check_output(
        "machine",
        &[("machine.yaml", machine.as_bytes())],
        &["check", "machine.yaml"],
        &format!("machine.yaml:1:7: name: the text holds the hidden character U+001B; {not_allowed}"),
    );
    let session = changed(SESSION, "name: a", "name: \"a\u{202e}b\"");
    let files = [("machine.yaml", MACHINE), ("a.csv", RECORDING), ("session.yaml", &session)];
    check_output(
        "test",
        &files.map(|(name, text)| (name, text.as_bytes())),
        &["check", "session.yaml"],
        &format!("session.yaml:4:11: tests[0].name: the text holds the hidden character U+202E; {not_allowed}"),
    );
    let recording = changed(RECORDING, "time_s", "\u{200b}time_s");
    let files = [("machine.yaml", MACHINE), ("a.csv", &recording), ("session.yaml", SESSION)];
    check_output(
        "header",
        &files.map(|(name, text)| (name, text.as_bytes())),
        &["check", "session.yaml"],
        "a.csv:1: column 1 has the hidden character U+200B in its name; remove it",
    );
    for (name, text, message) in [
        (
            "link",
            changed(URDF, "\"base\"", "\"ba\u{7}se\""),
            "attribute name of <link> holds the hidden character U+0007",
        ),
        ("reference", changed(URDF, "\"base\"", "\"ba&#27;se\""), "holds a character reference (&#…)"),
    ] {
        check_output(name, &[("arm.urdf", text.as_bytes())], &["check", "arm.urdf"], message);
    }
    let files: [(&str, &[u8]); 1] = [("m\u{1b}[2J.yaml", MACHINE.as_bytes())];
    check_output(
        "file",
        &files,
        &["check", "m\u{1b}[2J.yaml"],
        "m\\u{1b}[2J.yaml: has the hidden character U+001B in its name; rename it",
    );
    let files: [(&str, &[u8]); 1] = [("machine.yaml", MACHINE.as_bytes())];
    check_output(
        "option",
        &files,
        &["check", "machine.yaml", "--at", "\u{1b}[2J=3"],
        "the machine has no axis '\\u{1b}[2J'",
    );
}

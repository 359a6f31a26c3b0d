//! Property tests of every reader: no panic and no hang on arbitrary, mutated or cut text; what is printed reads back.

use std::path::Path;

use fiveaxis::load::{
    LinkChoice, load_session, machine_from_urdf, machine_from_yaml, positions_from_text, recording_from_csv,
};
use fiveaxis::machine::{ErrorName, Machine, StructuralCode};
use fiveaxis::report::machine_yaml;
use fiveaxis::units::{Measure, parse_quantity};
use proptest::prelude::*;

const MACHINE: &str = include_str!("../examples/thesis/chapter5/machine.yaml");
const SESSION: &str = include_str!("../examples/thesis/chapter5/session.yaml");
const ROBOT: &str = include_str!("../machines/irb120.urdf");
const RECORDING: &str = include_str!("../examples/thesis/chapter5/a-short-cw-1.csv");

const DETAILED: &str = r#"name: "detailed"
chain: [w, T1, b, J1, J_2, t]
axes:
  T1: {type: rotary, direction: [0, 0.7071, -0.7071], origin: [1, 2, 3], range: [-5, 185], reversed: true,
       errors: {EX0T1: 1.3 um, EA0T1: -22.32 arcsec},
       component_errors: {EZT1: {fourier: [{per_turn: 2, cos: 1 um, sin: 0.5 um}]}, EXT1: {table: [[-5, 1 um], [3, 2 um]]}}}
  J1: {type: linear, direction: [1, 0, 0], component_errors: {EXJ1: {polynomial: [1 nm, 2 nm]}}}
  J_2: {type: rotary, direction: [0, 0, 1]}
gravity: [0, 0, -1]
machine_zero: {J1: 120.5}
gauge_length: 150
links: [{name: plate, carried_by: T1}]
"#;

const COLUMNS: &str = "time_s;A_deg;length_mm;temperature_degC\n0,0;1,5;100,01;20,1\n0,1;1,6;;20,2\n0,2;1,7;100,02;\n";

fn mill() -> Machine {
    machine_from_yaml(Path::new("machine.yaml"), MACHINE.into()).unwrap()
}

/// One of several valid texts.
fn one_of(texts: &'static [&'static str]) -> impl Strategy<Value = &'static str> {
    (0..texts.len()).prop_map(move |index| texts[index])
}

/// Words that readers have special rules for.
const SPICE: [&str; 28] = [
    "[", "]", "{", "}", ":", "-", "\n", "\t", "\"", "'", "&a", "*a", "!!x", ".nan", "-.inf", "1e999", "θya", "µm", ";",
    ",", "\u{feff}", "\r", "<", ">", "<!--", "/>", "&lt;", "\0",
];

/// A valid text with a few places replaced, doubled, removed or cut off.
fn mutated(texts: &'static [&'static str]) -> impl Strategy<Value = String> {
    let change = (any::<prop::sample::Index>(), 0usize..12, 0usize..SPICE.len(), 0u8..4);
    (one_of(texts), prop::collection::vec(change, 1..6)).prop_map(|(text, changes)| {
        let mut characters: Vec<char> = text.chars().take(20_000).collect();
        for (place, length, spice, kind) in changes {
            let at = place.index(characters.len() + 1);
            let end = (at + length).min(characters.len());
            match kind {
                0 => drop(characters.splice(at..end, SPICE[spice].chars())),
                1 => drop(characters.drain(at..end)),
                2 => {
                    let piece: Vec<char> = characters[at..end].to_vec();
                    characters.splice(at..at, piece.repeat(3));
                }
                _ => characters.truncate(at.max(1)),
            }
            if characters.is_empty() {
                characters.push(' ');
            }
        }
        characters.into_iter().collect()
    })
}

/// Lines of valid texts in any order.
fn shuffled(texts: &'static [&'static str]) -> impl Strategy<Value = String> {
    one_of(texts).prop_flat_map(|text| {
        let lines: Vec<&str> = text.lines().take(60).collect();
        Just(lines).prop_shuffle().prop_map(|lines| lines.join("\n"))
    })
}

/// A refusal says where and is one message.
fn is_message(message: &str, file: &str) {
    assert!(message.starts_with(file) && message.len() > file.len() + 10, "{message}");
}

fn read_machine(text: String) {
    match machine_from_yaml(Path::new("m.yaml"), text) {
        // what is accepted is written and read again
        Ok(machine) => {
            let written = machine_yaml(&machine);
            let again = machine_from_yaml(Path::new("w.yaml"), written.clone());
            assert!(again.is_ok(), "{}\n{written}", again.unwrap_err());
        }
        Err(why) => is_message(&why.to_string(), "m.yaml"),
    }
}

fn read_urdf(text: &str) {
    match machine_from_urdf(Path::new("m.urdf"), text, &LinkChoice::default()) {
        Ok(machine) => {
            let again = machine_from_yaml(Path::new("w.yaml"), machine_yaml(&machine));
            assert!(again.is_ok(), "{}", again.unwrap_err());
        }
        Err(why) => is_message(&why.to_string(), "m.urdf"),
    }
}

fn read_recording(text: &str) {
    for bar in [None, Some(99.9881)] {
        match recording_from_csv(Path::new("a.csv"), text, &mill(), bar) {
            Ok(recording) => {
                assert!(recording.readings() > 0 && recording.leading_texts.len() == recording.len());
                assert!(recording.positions.iter().all(|column| column.len() == recording.len()));
                assert!(recording.positions.iter().flatten().all(|value| value.is_finite()));
            }
            Err(why) => is_message(&why.to_string(), "a.csv"),
        }
    }
}

fn read_session(text: &str) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.yaml"), MACHINE).unwrap();
    for name in ["a-short-cw-1.csv", "a-short-ccw-1.csv"] {
        std::fs::write(folder.path().join(name), RECORDING).unwrap();
    }
    let file = folder.path().join("session.yaml");
    std::fs::write(&file, text).unwrap();
    if let Err(why) = load_session(&file) {
        is_message(&why.to_string(), &folder.path().display().to_string());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn machine_text_never_panics(text in prop_oneof![any::<String>(), mutated(&[MACHINE, DETAILED]), shuffled(&[MACHINE, DETAILED])]) {
        read_machine(text);
    }

    #[test]
    fn robot_text_never_panics(text in prop_oneof![any::<String>(), mutated(&[ROBOT]), shuffled(&[ROBOT])]) {
        read_urdf(&text);
    }

    #[test]
    fn recording_text_never_panics(text in prop_oneof![any::<String>(), mutated(&[RECORDING, COLUMNS]), shuffled(&[RECORDING, COLUMNS])]) {
        read_recording(&text);
    }

    #[test]
    fn codes_and_names_never_panic(text in prop_oneof![any::<String>(), "[\\[\\]wbtXYZABCJ0-9, θeE_]{0,12}"]) {
        if let Ok(code) = StructuralCode::parse(&text) {
            prop_assert_eq!(StructuralCode::parse(&code.to_string()), Ok(code));
        }
        if let Ok(name) = ErrorName::parse(&text, &["X", "A", "J1", "j1", "0"]) {
            prop_assert_eq!(ErrorName::parse(&name.to_string(), &["X", "A", "J1", "j1", "0"]), Ok(name));
        }
        let _ = positions_from_text(&text, &mill());
    }

    #[test]
    fn codes_of_letters_print_and_read_back(
        letters in Just("XYZABCUVW".chars().collect::<Vec<char>>()).prop_shuffle(),
        count in 1usize..9,
        bed in any::<prop::sample::Index>(),
    ) {
        let mut inner: String = letters[..count].iter().collect();
        inner.insert(bed.index(count + 1), 'b');
        let code = format!("[w{inner}t]");
        prop_assert_eq!(StructuralCode::parse(&code).unwrap().to_string(), code);
    }

    #[test]
    fn codes_of_names_print_and_read_back(
        names in prop::collection::btree_set("[A-Za-z_][A-Za-z0-9_./-]{1,8}", 1..9),
        bed in any::<prop::sample::Index>(),
    ) {
        let mut words: Vec<String> = names.into_iter().collect();
        words.insert(bed.index(words.len() + 1), "b".into());
        let code = format!("[w, {}, t]", words.join(", "));
        prop_assert_eq!(StructuralCode::parse(&code).unwrap().to_string(), code);
    }

    #[test]
    fn quantities_read_the_number_times_its_unit(value in -1e6f64..1e6, blank in "[ ]{0,2}", unit in any::<prop::sample::Index>()) {
        for measure in [Measure::Length, Measure::Angle, Measure::Time, Measure::LengthPerKelvin] {
            let (name, factor) = measure.units()[unit.index(measure.units().len())];
            let read = parse_quantity(&format!("{value}{blank}{name}"), measure);
            prop_assert_eq!(read, Ok(value * factor));
            let bare = parse_quantity(&value.to_string(), measure);
            prop_assert!(bare.is_err());
        }
    }

    #[test]
    fn quantity_text_never_panics(text in any::<String>()) {
        let _ = parse_quantity(&text, Measure::Length);
        let _ = parse_quantity(&text, Measure::Angle);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn session_text_never_panics(text in prop_oneof![any::<String>(), mutated(&[SESSION]), shuffled(&[SESSION])]) {
        read_session(&text);
    }
}

/// Every prefix of a text, in characters.
fn prefixes(text: &str) -> impl Iterator<Item = &str> {
    text.char_indices().map(|(at, _)| &text[..at]).chain([text])
}

#[test]
fn files_cut_at_any_place_are_read_or_refused() {
    prefixes(MACHINE).chain(prefixes(DETAILED)).for_each(|text| read_machine(text.into()));
    prefixes(ROBOT).for_each(read_urdf);
    prefixes(COLUMNS).for_each(read_recording);
    prefixes(&RECORDING[..2000]).for_each(read_recording);
    let start = SESSION.find("  - name").unwrap();
    prefixes(&SESSION[..start + 600]).step_by(7).for_each(read_session);
}

/// A robot description cut anywhere is never taken for a whole one.
#[test]
fn cut_robot_descriptions_are_refused() {
    let whole = ROBOT.trim_end();
    for text in prefixes(whole).filter(|text| text.len() < whole.len()) {
        assert!(machine_from_urdf(Path::new("m.urdf"), text, &LinkChoice::default()).is_err(), "{}", text.len());
    }
}

#[test]
fn a_code_without_quotes_is_the_same_machine() {
    let read = |code: &str| {
        let text = format!("name: mill\ncode: {code}\naxes: {{C: {{range: [-360, 360]}}}}\n");
        fiveaxis::load::machine_from_yaml(std::path::Path::new("machine.yaml"), text).map_err(|why| why.to_string())
    };
    assert_eq!(read("[wCAbYXZt]").unwrap(), read("\"[wCAbYXZt]\"").unwrap());
    let list = read("[w, C]").unwrap_err();
    assert_eq!(list, "machine.yaml:2:1: code is no text; write for example code: \"[wCAYbXZt]\"");
}

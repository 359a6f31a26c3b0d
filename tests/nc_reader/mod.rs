//! Reads programs back into motions, word by word and for itself: no code of the writers. What it does not know is an error.

use std::collections::{BTreeMap, BTreeSet};

/// One thing that a program makes the machine do. Positions as written, by axis name.
#[derive(Debug, Clone, PartialEq)]
pub enum Act {
    Rapid(BTreeMap<String, f64>),
    /// A block at a feed.
    Feed {
        to: BTreeMap<String, f64>,
        pace: Pace,
    },
    /// Relative end and centre of two axes; the sense as written.
    Arc {
        plane: String,
        end: BTreeMap<String, f64>,
        centre: BTreeMap<String, f64>,
        counter_clockwise: bool,
        feed: f64,
    },
    Dwell(f64),
    Stop,
    End,
}

/// How fast a block is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// mm/min, or deg/min where a rotary axis moves alone.
    PerMinute(f64),
    /// The whole block, s.
    Seconds(f64),
}

/// A program as read.
#[derive(Debug, Clone, Default)]
pub struct Program {
    pub acts: Vec<Act>,
    pub comments: Vec<String>,
    /// `O` number of the generic dialect.
    pub number: Option<u32>,
    /// Moves are in machine coordinates: all of them or none, relative arcs apart.
    pub in_machine_coordinates: bool,
    /// G words in force at the end by group, of ISO programs.
    pub modes: BTreeMap<&'static str, String>,
}

/// A generic ISO 6983 or a Sinumerik program; `modes` are those found before it, by group.
pub fn read_iso(text: &str, sinumerik: bool, modes: &[(&'static str, &str)]) -> Program {
    let mut program =
        Program { modes: modes.iter().map(|(group, word)| (*group, word.to_string())).collect(), ..Program::default() };
    let mut saved: BTreeMap<String, String> = BTreeMap::new();
    let mut straightened: BTreeSet<String> = BTreeSet::new();
    let mut machine_blocks = [0, 0];
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && *line != "%") {
        // O and four digits, then the name: what controls of Fanuc's kind find a program by
        if let Some((number, name)) = line.strip_prefix('O').and_then(|rest| rest.split_once(' ')) {
            assert!(!sinumerik && program.number.is_none(), "{line}");
            assert_eq!(number.len(), 4, "{line}");
            program.number = Some(number.parse().expect("a program number"));
            program.comments.extend(comment(name, sinumerik));
            continue;
        }
        if let Some(comment) = comment(line, sinumerik) {
            program.comments.push(comment);
            continue;
        }
        if sinumerik && (line.starts_with("DEF INT ") || line.contains("$P_GG[") || line.starts_with("G[")) {
            variables(line, &mut saved, &mut program.modes);
            continue;
        }
        if sinumerik && ["TRAFOOF", "D0"].contains(&line) {
            continue;
        }
        if sinumerik && ["TRANS", "TOROTOF", "PAROTOF"].contains(&line) {
            straightened.insert(line.to_string());
            continue;
        }
        let words: Vec<(String, f64)> = line.split(' ').filter(|word| *word != "SUPA").map(word).collect();
        let in_machine = line.ends_with(" SUPA") || words.contains(&("G".into(), 53.0));
        let mut axes = BTreeMap::new();
        let mut centre = BTreeMap::new();
        let (mut feed, mut dwell, mut is_dwell) = (None, None, false);
        for (letter, value) in &words {
            match (letter.as_str(), *value) {
                ("G", 4.0) => is_dwell = true,
                ("G", 53.0) => {}
                ("G", code) => {
                    let word = format!("G{code}");
                    if word == "G69" {
                        straightened.insert(word.clone());
                    }
                    // controls of Fanuc's kind take no plane while coordinates are turned
                    assert!(group(&word) != "plane" || sinumerik || straightened.contains("G69"), "{line}");
                    program.modes.insert(group(&word), word);
                }
                ("M", 0.0) => program.acts.push(Act::Stop),
                ("M", 30.0) => program.acts.push(Act::End),
                ("M", 5.0 | 9.0) => {}
                ("F", value) if is_dwell => dwell = Some(value),
                ("X", value) if is_dwell => dwell = Some(value),
                ("F", value) => feed = Some(value),
                ("ADIS", value) => assert_eq!(value, 0.001),
                ("I" | "J" | "K", value) => {
                    centre.insert(["X", "Y", "Z"]["IJK".find(letter.as_str()).expect("centre")].to_string(), value);
                }
                (name, value) if is_axis(name) => {
                    axes.insert(name.to_string(), value);
                }
                other => panic!("word {other:?} in '{line}'"),
            }
        }
        if is_dwell {
            assert!(dwell.is_some(), "{line}");
            program.acts.extend(dwell.map(Act::Dwell));
            continue;
        }
        if axes.is_empty() {
            continue;
        }
        // what an earlier program left turned is off before anything moves
        assert_eq!(straightened.len(), if sinumerik { 3 } else { 1 }, "{line}");
        let mode = |group: &str| program.modes.get(group).map_or("", String::as_str);
        let act = match mode("motion") {
            "G0" => Act::Rapid(axes),
            "G1" => {
                let feed = feed.unwrap_or_else(|| panic!("no feed in '{line}'"));
                let pace = match mode("feed") {
                    "G93" => Pace::Seconds(60.0 / feed),
                    "G94" => Pace::PerMinute(feed),
                    other => panic!("{other}"),
                };
                Act::Feed { to: axes, pace }
            }
            arc @ ("G2" | "G3") => {
                assert_eq!((mode("distance"), mode("feed")), ("G91", "G94"), "{line}");
                let plane = match mode("plane") {
                    "G17" => "XY",
                    "G18" => "ZX",
                    "G19" => "YZ",
                    other => panic!("{other}"),
                };
                let counter_clockwise = arc == "G3";
                let feed = feed.unwrap_or_else(|| panic!("no feed in '{line}'"));
                Act::Arc { plane: plane.into(), end: axes, centre, counter_clockwise, feed }
            }
            other => panic!("motion '{other}' in '{line}'"),
        };
        if !matches!(act, Act::Arc { .. }) {
            assert_eq!(mode("distance"), "G90", "{line}");
            machine_blocks[usize::from(in_machine)] += 1;
        }
        program.acts.push(act);
    }
    assert!(machine_blocks.contains(&0), "some moves in machine, some in work coordinates: {machine_blocks:?}");
    program.in_machine_coordinates = machine_blocks[1] > 0;
    program
}

/// A Heidenhain conversational program.
pub fn read_heidenhain(text: &str) -> Program {
    let mut program = Program::default();
    let mut centre = BTreeMap::new();
    let mut straightened = 0;
    let mut machine_blocks = [0, 0];
    for (index, line) in text.lines().enumerate() {
        let (number, line) = line.split_once(' ').expect("a number before each block");
        assert_eq!(number.parse(), Ok(index), "{line}");
        if let Some(comment) = line.strip_prefix("; ") {
            program.comments.push(comment.into());
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        // a position is an axis, a sign and at most five and four places
        let position = |word: &str| -> (String, f64) {
            let at = word.find(['+', '-']).unwrap_or_else(|| panic!("'{word}' has no sign"));
            let (_, decimals) = word.split_once('.').unwrap_or_else(|| panic!("'{word}' has no point"));
            assert!(decimals.len() <= 4, "'{word}' has more places than the control");
            (word[..at].to_string(), word[at..].parse().expect("number"))
        };
        match words[0] {
            "BEGIN" => assert_eq!(index, 0),
            "END" => program.acts.push(Act::End),
            "STOP" => program.acts.push(Act::Stop),
            "M129" | "M127" | "M5" | "M9" => {}
            "PLANE" | "CYCL"
                if ["PLANE RESET STAY", "CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"].contains(&line) =>
            {
                straightened += 1;
            }
            "CYCL" if words[2] == "9.0" => {}
            "CYCL" => program.acts.push(Act::Dwell(words[4].parse().expect("seconds"))),
            "CC" => {
                centre = words[1..].iter().map(|word| position(word.strip_prefix('I').expect("relative"))).collect();
            }
            "C" => {
                let relative = words[1..].iter().filter_map(|word| word.strip_prefix('I'));
                let end: BTreeMap<String, f64> = relative.map(position).collect();
                let axes: String = words[1..3].iter().map(|word| word[1..2].to_string()).collect();
                let counter_clockwise = words.contains(&"DR+");
                assert!(counter_clockwise != words.contains(&"DR-") && words.contains(&"R0"), "{line}");
                let feed = words[words.len() - 1].strip_prefix('F').expect("feed").parse().expect("feed");
                let centre = centre.clone();
                program.acts.push(Act::Arc { plane: axes, end, centre, counter_clockwise, feed });
            }
            "L" => {
                assert_eq!(straightened, 3, "{line}");
                machine_blocks[usize::from(words.contains(&"M91"))] += 1;
                let words: Vec<&str> = words[1..].iter().copied().filter(|word| *word != "M91").collect();
                let (feed, words) = words.split_last().expect("words");
                let (radius, axes) = words.split_last().expect("words");
                assert_eq!(*radius, "R0", "{line}");
                let to: BTreeMap<String, f64> = axes.iter().map(|word| position(word)).collect();
                program.acts.push(match (feed.strip_prefix("FT"), feed.strip_prefix('F')) {
                    (Some(time), _) => Act::Feed { to, pace: Pace::Seconds(time.parse().expect("time")) },
                    (_, Some("MAX")) => Act::Rapid(to),
                    (_, Some(feed)) => Act::Feed { to, pace: Pace::PerMinute(feed.parse().expect("feed")) },
                    _ => panic!("{line}"),
                });
            }
            other => panic!("'{other}' in '{line}'"),
        }
    }
    assert!(machine_blocks.contains(&0));
    program.in_machine_coordinates = machine_blocks[1] > 0;
    program
}

fn comment(line: &str, sinumerik: bool) -> Option<String> {
    if sinumerik { line.strip_prefix("; ") } else { line.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) }
        .map(str::to_string)
}

/// `DEF INT NAME`, `NAME=$P_GG[group]`, `G[group]=NAME`.
fn variables(line: &str, saved: &mut BTreeMap<String, String>, modes: &mut BTreeMap<&'static str, String>) {
    let number = |text: &str| text.split(['[', ']']).nth(1).expect("index").to_string();
    if let Some(name) = line.strip_prefix("DEF INT ") {
        saved.insert(name.into(), String::new());
    } else if let Some((name, read)) = line.split_once("=$P_GG") {
        let mode = modes[sinumerik_group(&number(read))].clone();
        *saved.get_mut(name).expect("defined before it is used") = mode;
    } else if let Some((group, name)) = line.split_once('=') {
        assert!(!saved[name].is_empty(), "{name} was not read");
        modes.insert(sinumerik_group(&number(group)), saved[name].clone());
    }
}

/// Numbers of G groups in Siemens's lists of G commands.
fn sinumerik_group(number: &str) -> &'static str {
    match number {
        "6" => "plane",
        "10" => "path",
        "13" => "unit",
        "14" => "distance",
        "15" => "feed",
        other => panic!("group {other}"),
    }
}

fn group(word: &str) -> &'static str {
    match word {
        "G0" | "G1" | "G2" | "G3" => "motion",
        "G17" | "G18" | "G19" => "plane",
        "G20" | "G21" | "G70" | "G71" | "G700" | "G710" => "unit",
        "G40" => "radius",
        "G68" | "G69" => "turn",
        "G49" => "length",
        "G60" | "G61" | "G64" | "G641" => "path",
        "G90" | "G91" => "distance",
        "G93" | "G94" | "G95" => "feed",
        other => panic!("{other}"),
    }
}

/// `X12.5`, `X1=12.5`, `ADIS=0.001`.
fn word(text: &str) -> (String, f64) {
    let number = |value: &str| value.parse().unwrap_or_else(|_| panic!("'{text}'"));
    if let Some((name, value)) = text.split_once('=') {
        return (name.to_string(), number(value));
    }
    (text[..1].to_string(), number(&text[1..]))
}

fn is_axis(name: &str) -> bool {
    "XYZABCUVW".contains(&name[..1]) && name[1..].chars().all(|letter| letter.is_ascii_digit())
}

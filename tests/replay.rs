//! All programs of all shipped machines replayed in both senses by kinematics of this test's own, from the machine files alone.
//!
//! No transform of the library is used: links are 4×4 products written here from the YAML. The bar must be within 0.2 mm of
//! nominal in run-in and run-out and within 0.5 um of the session's own length inside the arc.

use crate::nc_reader;
use crate::shipped;
use std::collections::BTreeMap;
use std::path::PathBuf;

use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{PlannedTest, Settings, plan};
use fiveaxis::session::{Follow, Path as TestPath};
use nc_reader::{Act, Pace, read_heidenhain, read_iso};
use rayon::prelude::*;
use serde_yaml::Value;

type Matrix = [[f64; 4]; 4];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn shift(by: [f64; 3]) -> Matrix {
    [[1.0, 0.0, 0.0, by[0]], [0.0, 1.0, 0.0, by[1]], [0.0, 0.0, 1.0, by[2]], [0.0, 0.0, 0.0, 1.0]]
}

/// Right-handed turn about a line through a point.
fn turn(u: [f64; 3], through: [f64; 3], angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let [x, y, z] = u;
    let v = 1.0 - c;
    let about_zero = [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0.0],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0.0],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    product(&product(&shift(through), &about_zero), &shift(through.map(|x| -x)))
}

/// A machine as its file says it, and nothing else.
struct Replay {
    /// Axes from the bed to the workpiece and to the tool.
    branches: [Vec<char>; 2],
    axes: BTreeMap<char, ([f64; 3], [f64; 3])>,
    /// Axes in the code's order.
    order: Vec<char>,
    iso841: bool,
}

fn three(value: &Value) -> Option<[f64; 3]> {
    let list = value.as_sequence()?;
    Some([list[0].as_f64()?, list[1].as_f64()?, list[2].as_f64()?])
}

impl Replay {
    fn of(text: &str, iso841: bool) -> Replay {
        let file: Value = serde_yaml::from_str(text).expect("YAML");
        let code = file["code"].as_str().expect("code").trim_matches(['[', ']']);
        let (table, head) = code.trim_start_matches('w').trim_end_matches('t').split_once('b').expect("the bed");
        let axes = code
            .chars()
            .filter(char::is_ascii_uppercase)
            .map(|name| {
                let entry = &file["axes"][name.to_string().as_str()];
                assert!(entry["reversed"].is_null());
                let along = match name {
                    'X' | 'A' => [1.0, 0.0, 0.0],
                    'Y' | 'B' => [0.0, 1.0, 0.0],
                    _ => [0.0, 0.0, 1.0],
                };
                let u = three(&entry["direction"]).unwrap_or(along);
                let length = (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).sqrt();
                (name, (u.map(|x| x / length), three(&entry["origin"]).unwrap_or_default()))
            })
            .collect();
        let order = table.chars().chain(head.chars()).collect();
        Replay { branches: [table.chars().rev().collect(), head.chars().collect()], axes, order, iso841 }
    }

    /// A point that a link carries, where it stands with the axes at these readings, mm and deg.
    fn point(&self, link: &str, at: [f64; 3], readings: &BTreeMap<char, f64>) -> [f64; 3] {
        let name = link.chars().next().expect("a link");
        let [table, head] = &self.branches;
        let (branch, sign) = match name {
            'b' => return at,
            'w' => (table, true),
            't' => (head, false),
            _ if table.contains(&name) => (table, true),
            _ => (head, false),
        };
        let sign = if sign && self.iso841 { -1.0 } else { 1.0 };
        let end = branch.iter().position(|axis| *axis == name).map_or(branch.len(), |k| k + 1);
        let pose = branch[..end].iter().fold(shift([0.0; 3]), |pose, axis| {
            let (u, origin) = self.axes[axis];
            let q = sign * readings[axis];
            let joint = if "XYZ".contains(*axis) { shift(u.map(|x| x * q)) } else { turn(u, origin, q.to_radians()) };
            product(&pose, &joint)
        });
        std::array::from_fn(|i| pose[i][0] * at[0] + pose[i][1] * at[1] + pose[i][2] * at[2] + pose[i][3])
    }

    /// Distance of the balls of a test.
    fn bar(&self, planned: &PlannedTest, readings: &BTreeMap<char, f64>) -> f64 {
        let ball = |ball: &fiveaxis::session::Ball| self.point(&ball.link, [ball.at.x, ball.at.y, ball.at.z], readings);
        let (p, s) = (ball(&planned.test.pivot), ball(&planned.test.spindle_ball));
        (0..3).map(|k| (p[k] - s[k]).powi(2)).sum::<f64>().sqrt()
    }
}

/// Parts into which a block is cut.
const PARTS: u32 = 90;

/// Readings along a block from where the machine stands; leaves it at its end.
fn along(here: &mut BTreeMap<char, f64>, act: &Act) -> Vec<BTreeMap<char, f64>> {
    let start = here.clone();
    let letter = |name: &String| name.chars().next().expect("a letter");
    let places: Vec<BTreeMap<char, f64>> = match act {
        Act::Rapid(to) | Act::Feed { to, .. } => (1..=PARTS)
            .map(|k| {
                let mut place = start.clone();
                for (name, to) in to {
                    let from = start.get(&letter(name)).copied().unwrap_or(*to);
                    place.insert(letter(name), from + (to - from) * f64::from(k) / f64::from(PARTS));
                }
                place
            })
            .collect(),
        Act::Arc { plane, end, centre, counter_clockwise, .. } => {
            let names = [&plane[..1], &plane[1..]];
            let middle = names.map(|name| centre[name]);
            let angle = |x: f64, y: f64| (y - middle[1]).atan2(x - middle[0]);
            let (from, to) = (angle(0.0, 0.0), angle(end[names[0]], end[names[1]]));
            // the shortest turn in the sense of the word, which is that seen against the third axis
            let full = std::f64::consts::TAU;
            let turned = if *counter_clockwise { (to - from).rem_euclid(full) } else { -(from - to).rem_euclid(full) };
            let radius = middle[0].hypot(middle[1]);
            (1..=8 * PARTS)
                .map(|k| {
                    let part = f64::from(k) / f64::from(8 * PARTS);
                    let (sin, cos) = (from + turned * part).sin_cos();
                    let mut place = start.clone();
                    for (name, by) in end {
                        let moved = match names.iter().position(|other| *other == name.as_str()) {
                            Some(0) => middle[0] + radius * cos,
                            Some(_) => middle[1] + radius * sin,
                            None => by * part,
                        };
                        *place.get_mut(&letter(name)).expect("stands somewhere") += moved;
                    }
                    place
                })
                .collect()
        }
        _ => Vec::new(),
    };
    if let Some(last) = places.last() {
        *here = last.clone();
    }
    places
}

/// Worst bar outside and inside the arc, mm.
#[derive(Debug, Clone, Copy, Default)]
struct Worst {
    outside: f64,
    inside: f64,
}

/// Replays one program between its rests.
fn replay(machine: &Replay, planned: &PlannedTest, dialect: Dialect, text: &str) -> Worst {
    let found = match dialect {
        Dialect::Heidenhain => read_heidenhain(text),
        _ => read_iso(
            text,
            dialect == Dialect::Sinumerik,
            &[("plane", "G17"), ("distance", "G90"), ("feed", "G94"), ("path", "G60"), ("unit", "G71")],
        ),
    };
    let nominal = planned.test.bar_length_mm.expect("planned");
    let mut here = BTreeMap::new();
    let mut worst = Worst::default();
    let mut rests = 0;
    for act in &found.acts {
        rests += usize::from(matches!(act, Act::Dwell(_)));
        assert!(!matches!(act, Act::Feed { pace: Pace::PerMinute(feed), .. } if !feed.is_finite()));
        let places = along(&mut here, act);
        // between the rests of a direction the bar is on
        let runs = if planned.test.marks.is_some() { [3, 8] } else { [1, 3] };
        let is_mark = planned.test.marks.is_some() && (1..11).contains(&rests) && !runs.contains(&rests);
        if is_mark {
            // it changes the bar by its move at most
            for place in &places {
                let longer = machine.bar(planned, place) - nominal;
                let most = planned.test.marks.map_or(0.0, |marks| marks.move_mm);
                assert!((most.min(0.0) - 0.2..most.max(0.0) + 0.2).contains(&longer), "a mark of {longer} mm");
            }
            continue;
        }
        if !runs.contains(&rests) {
            continue;
        }
        for place in &places {
            let bar = machine.bar(planned, place);
            let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
            let swept = match &planned.test.path {
                Some(TestPath::Sweep { .. }) => Some(place[&axis_of(planned)]),
                _ => None,
            };
            worst.outside = worst.outside.max((bar - nominal).abs());
            // the session's own length at this turn: of its standing positions, or the bar's nominal where axes follow
            if swept.is_none_or(|at| at >= from && at <= to) {
                let own = match &planned.test.path {
                    Some(TestPath::Sweep { follow: Follow::None, .. }) => {
                        let mut own = own_positions(machine, planned);
                        own.insert(axis_of(planned), swept.expect("a sweep"));
                        machine.bar(planned, &own)
                    }
                    _ => nominal,
                };
                worst.inside = worst.inside.max((bar - own).abs());
            }
        }
    }
    assert_eq!(rests, if planned.test.marks.is_some() { 11 } else { 4 });
    worst
}

fn axis_of(planned: &PlannedTest) -> char {
    // the plan's names: `a-100-1`, `c-axial-100-1`
    planned.test.name.chars().next().expect("a name").to_ascii_uppercase()
}

/// Where the session says that axes stand, mm and deg.
fn own_positions(machine: &Replay, planned: &PlannedTest) -> BTreeMap<char, f64> {
    let shown = |name: &char, q: f64| if "XYZ".contains(*name) { q } else { q.to_degrees() };
    let stands = machine.order.iter().zip(&planned.test.positions);
    stands.filter_map(|(name, q)| Some((*name, shown(name, (*q)?)))).collect()
}

/// The machine file in another sense.
fn in_sense(text: &str, sense: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("directions:"));
    lines
        .flat_map(|line| {
            let stated = line.starts_with("code:").then(|| format!("directions: {sense}"));
            std::iter::once(line.to_string()).chain(stated)
        })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn every_program_of_every_machine_keeps_the_bar() {
    // two of three machines in one of the senses, in turn; FIVEAXIS_TESTS=all for all of them in both, which takes three times
    // as long
    let both = shipped::is_thorough();
    let mut files = [shipped::some_machines(0, 3), shipped::some_machines(1, 3)].concat();
    files.sort();
    files.dedup();
    let cases: Vec<(&PathBuf, &str)> = files
        .iter()
        .enumerate()
        .flat_map(|(turn, file)| {
            let senses = ["iso841", "carried"];
            senses
                .into_iter()
                .enumerate()
                .filter(move |(k, _)| both || k % 2 == turn % 2)
                .map(move |(_, sense)| (file, sense))
        })
        .collect();
    let kit = standard_kit().expect("kit");
    let worst = cases
        .par_iter()
        .map(|(file, sense)| {
            let text = in_sense(&std::fs::read_to_string(file).expect("read"), sense);
            let folder = tempfile::tempdir().expect("folder");
            let copy = folder.path().join("machine.yaml");
            std::fs::write(&copy, &text).expect("written");
            let (machine, bodies) = load_machine_and_bodies(&copy).expect("shipped machine");
            let mut settings = Settings::default();
            settings.coupled.circles = true;
            let plan = plan(&machine, &bodies, &kit, &settings).expect("plan");
            let own = Replay::of(&text, *sense == "iso841");
            let mut worst = Worst::default();
            for planned in &plan.tests {
                for dialect in [Dialect::Generic, Dialect::Heidenhain, Dialect::Sinumerik] {
                    let found = replay(&own, planned, dialect, &program(&machine, planned, &[], dialect));
                    let said = format!("{} {sense} {} {dialect:?}: {found:?}", file.display(), planned.test.name);
                    assert!(found.outside < 0.2 && found.inside < 0.5e-3, "{said}");
                    worst.outside = worst.outside.max(found.outside);
                    worst.inside = worst.inside.max(found.inside);
                }
            }
            worst
        })
        .reduce(Worst::default, |a, b| Worst { outside: a.outside.max(b.outside), inside: a.inside.max(b.inside) });
    println!("bar within {:.4} mm outside the arc, {:.3} um inside", worst.outside, worst.inside * 1e3);
}

//! NC programs of all dialects, read back by a reader of their own: places, pace of the ball, limits, heads, modes left behind.

use crate::nc_reader;
use crate::planned;
use std::collections::BTreeMap;
use std::path::Path;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::collision::Leg;
use fiveaxis::import::{Course, Feeds, Pair};
use fiveaxis::load::load_machine_and_bodies;
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{Approach, ClearSweep, Mounting, Placing, PlannedTest, bare_session};
use fiveaxis::session::{Ball, CirclePlane, Follow, Marks, Path as TestPath, Test};
use nalgebra::Vector3;
use nc_reader::{Act, Pace, Program, read_heidenhain, read_iso};
use planned::planned;

/// Modes that a Sinumerik stands in before a program, other than the program's own.
const BEFORE: [(&str, &str); 5] =
    [("plane", "G18"), ("path", "G60"), ("unit", "G70"), ("distance", "G91"), ("feed", "G95")];

fn read(machine: &Machine, planned: &PlannedTest, dialect: Dialect) -> Program {
    let text = program(machine, planned, &[], dialect);
    match dialect {
        Dialect::Heidenhain => read_heidenhain(&text),
        _ => read_iso(&text, dialect == Dialect::Sinumerik, &BEFORE),
    }
}

/// A stretch of motion: places by axis in mm and rad from the machine file's zero, and the time it takes, s.
struct Stretch {
    places: Vec<Vec<f64>>,
    seconds: f64,
}

/// What a machine does with a program.
struct Run<'m> {
    machine: &'m Machine,
    /// Added to a position of the machine file, mm or deg by axis.
    offsets: Vec<f64>,
    here: Vec<f64>,
}

impl Run<'_> {
    fn index(&self, name: &str) -> usize {
        self.machine.axis_index(name).unwrap_or_else(|| panic!("no axis {name}"))
    }

    fn at(&self, words: &BTreeMap<String, f64>) -> Vec<f64> {
        let mut to = self.here.clone();
        for (name, value) in words {
            let k = self.index(name);
            to[k] = self.machine.axes[k].kind.from_file_unit(value - self.offsets[k]);
        }
        to
    }

    fn feed(&mut self, to: &BTreeMap<String, f64>, pace: Pace) -> Stretch {
        let (from, to) = (self.here.clone(), self.at(to));
        let seconds = match pace {
            Pace::Seconds(seconds) => seconds,
            Pace::PerMinute(feed) => {
                let moved: Vec<usize> = (0..to.len()).filter(|&k| to[k] != from[k]).collect();
                assert!(moved.len() < 2, "a feed per minute with {} axes", moved.len());
                let way = |k: &usize| self.machine.axes[*k].kind.to_file_unit((to[*k] - from[*k]).abs());
                moved.first().map_or(0.0, way) / feed * 60.0
            }
        };
        let on = |part: f64| from.iter().zip(&to).map(|(a, b)| a + (b - a) * part).collect();
        self.here = to.clone();
        // a turn is a long way round, a block of several axes a short one
        let count = if matches!(pace, Pace::PerMinute(_)) { 360 } else { 4 };
        Stretch { places: (0..=count).map(|k| on(f64::from(k) / f64::from(count))).collect(), seconds }
    }

    fn arc(
        &mut self,
        plane: &str,
        end: &BTreeMap<String, f64>,
        centre: &BTreeMap<String, f64>,
        counter_clockwise: bool,
        feed: f64,
    ) -> Stretch {
        let names = [&plane[..1], &plane[1..]];
        let [one, other] = names.map(|name| self.index(name));
        let middle = names.map(|name| centre[name]);
        let from = (-middle[1]).atan2(-middle[0]);
        let mut turn = (end[names[1]] - middle[1]).atan2(end[names[0]] - middle[0]) - from;
        // the sense is seen from the third axis
        let tau = std::f64::consts::TAU;
        if counter_clockwise && turn <= 1e-6 {
            turn += tau;
        } else if !counter_clockwise && turn >= -1e-6 {
            turn -= tau;
        }
        let radius = middle[0].hypot(middle[1]);
        let start = self.here.clone();
        // what is no axis of the plane goes evenly
        let along: Vec<(usize, f64)> = end
            .iter()
            .filter(|(name, _)| !names.contains(&name.as_str()))
            .map(|(name, by)| (self.index(name), self.machine.axes[self.index(name)].kind.from_file_unit(*by)))
            .collect();
        let on = |part: f64| {
            let (sin, cos) = (from + turn * part).sin_cos();
            let mut place = start.clone();
            place[one] += middle[0] + radius * cos;
            place[other] += middle[1] + radius * sin;
            along.iter().for_each(|(k, by)| place[*k] += by * part);
            place
        };
        let count = 720;
        let places: Vec<Vec<f64>> = (0..=count).map(|k| on(f64::from(k) / f64::from(count))).collect();
        for (name, by) in end {
            let k = self.index(name);
            self.here[k] += self.machine.axes[k].kind.from_file_unit(*by);
        }
        Stretch { places, seconds: turn.abs() * radius / feed * 60.0 }
    }
}

/// How far the bar may be off in the middle of a block by plan, mm.
const CHORD_MM: f64 = 0.26e-3;

/// Everything that must hold for one program.
fn check(machine: &Machine, planned: &PlannedTest, dialect: Dialect, offsets: &[f64], worst_slow: &mut f64) {
    let said = format!("{dialect:?} {}", planned.test.name);
    let found = read(machine, planned, dialect);
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let links = planned.test.links(&chain).expect("links");
    let balls = |q: &[f64]| -> (Vector3<f64>, Vector3<f64>) {
        (
            geometry.point(links.0, &planned.test.pivot.at, q, None),
            geometry.point(links.1, &planned.test.spindle_ball.at, q, None),
        )
    };
    // half of the last of four decimals, mm or deg; after relative arcs three times that
    let near = 0.51e-4;
    let digits = if matches!(planned.test.path, Some(TestPath::Circle { .. })) { 3.0 } else { 1.0 };
    // what half a digit on every axis makes of the bar at a pose, all in the worst direction
    let by_rounding = |q: &[f64]| -> f64 {
        let length = |q: &[f64]| {
            let (p, s) = balls(q);
            (p - s).norm()
        };
        let of = |k: usize| {
            let mut moved = q.to_vec();
            moved[k] += machine.axes[k].kind.from_file_unit(digits * near);
            (length(&moved) - length(q)).abs()
        };
        (0..q.len()).map(of).sum()
    };
    let mut run = Run { machine, offsets: offsets.to_vec(), here: vec![f64::NAN; machine.axes.len()] };
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let dwells: Vec<usize> = (0..found.acts.len()).filter(|&k| matches!(found.acts[k], Act::Dwell(_))).collect();
    let first = dwells[0];
    let last = dwells[dwells.len() - 1];
    let due: Vec<f64> = match planned.test.marks {
        None => vec![3.0; 4],
        Some(Marks { hold_s: hold, rest_s: rest, gap_s: gap, .. }) => {
            vec![3.0, hold, rest, rest, hold, gap, hold, rest, rest, hold, 3.0]
        }
    };
    let seen: Vec<f64> = dwells.iter().map(|&k| if let Act::Dwell(s) = found.acts[k] { s } else { f64::NAN }).collect();
    assert_eq!(seen.len(), due.len(), "{said}: {seen:?}");
    assert!(seen.iter().zip(&due).all(|(seen, due)| (seen - due).abs() < 1e-6), "{said}: {seen:?} {due:?}");
    assert_eq!(found.acts[0], Act::Stop, "{said}");
    // the bar goes on and off where the machine stands
    assert_eq!((&found.acts[first - 1], &found.acts[last + 1]), (&Act::Stop, &Act::Stop), "{said}");
    let corners = planned.approach.corners();
    let mut aside = vec![planned.approach.park.clone()];
    for Leg { axis, to } in &planned.approach.aside_and_back {
        let mut corner = planned.approach.park.clone();
        corner[*axis] = *to;
        aside.push(corner);
    }
    let there = way(&mut run, &found.acts[1..first - 1], planned, &balls, &said);
    let from_park = &there[planned.approach.park.len() - 1..];
    visits(from_park, &[&aside[..], &corners[1..]].concat(), near, &said);

    let feed_mm_per_s = planned.test.feed_mm_per_min.expect("planned") / 60.0;
    let bar = planned.test.bar_length_mm.expect("planned");
    let mut stretches = |acts: &[Act]| -> Vec<Stretch> {
        acts.iter()
            .map(|act| match act {
                Act::Feed { to, pace } => run.feed(to, *pace),
                Act::Arc { plane, end, centre, counter_clockwise, feed } => {
                    run.arc(plane, end, centre, *counter_clockwise, *feed)
                }
                other => panic!("{said}: {other:?}"),
            })
            .collect()
    };
    let is_axial = matches!(planned.test.path, Some(TestPath::Sweep { follow: Follow::Axial, .. }));
    // between the dwells: out, back, the run, out, back, and nothing between the directions
    let of_run = if planned.test.marks.is_some() { [2, 7] } else { [0, 2] };
    let mut marks: Vec<Stretch> = Vec::new();
    let mut runs: Vec<Vec<Stretch>> = Vec::new();
    for (k, pair) in dwells.windows(2).enumerate() {
        let piece = stretches(&found.acts[pair[0] + 1..pair[1]]);
        if of_run.contains(&k) { runs.push(piece) } else { marks.extend(piece) }
    }
    check_marks(planned, &marks, &balls, &by_rounding, &said);
    let rows: [Vec<Vec<f64>>; 2] = [planned.run.clone(), planned.run.iter().rev().cloned().collect()];
    assert_eq!(runs.len(), 2, "{said}");
    for (way, rows) in runs.iter().zip(rows) {
        let last = |stretch: &Stretch| stretch.places[stretch.places.len() - 1].clone();
        for (end, row) in [(&way[0].places[0], &rows[0]), (&last(&way[way.len() - 1]), &rows[rows.len() - 1])] {
            // blocks end on readings that are written in full: half a digit of the turning axis takes the slides along
            let most = |a: f64, pair: &[Vec<f64>]| {
                let turned = (pair[1][planned.axis] - pair[0][planned.axis]).abs();
                if turned > 1e-6 { a.max(off(&pair[0], &pair[1]) / turned) } else { a }
            };
            let per_rad = if planned.is_coupled() { rows.windows(2).fold(0.0, most) } else { 0.0 };
            assert!(off(end, row) < 4.0 * near + near.to_radians() * per_rad, "{said}: {end:?} {row:?}");
        }
        // every row of the plan lies on the run
        let places: Vec<&Vec<f64>> = way.iter().flat_map(|stretch| &stretch.places).collect();
        let swept = |q: &[f64]| q[planned.axis];
        if !planned.is_coupled() {
            assert_eq!(way.len(), 1, "{said}: a sweep is one block");
        } else if !matches!(planned.test.path, Some(TestPath::Circle { .. })) {
            for row in &rows[1..rows.len() - 1] {
                let nearest = places.iter().min_by(|a, b| {
                    let away = |q: &&&Vec<f64>| (swept(q) - swept(row)).abs();
                    away(a).total_cmp(&away(b))
                });
                assert!(off(nearest.expect("places"), row) < 2.0, "{said}");
            }
        }
        // from run-in to run-out the bar keeps its length where it does in the plan, and the pace of the ball is the planned
        let mut total_s = [0.0; 2];
        for stretch in way {
            let mut walked = [0.0; 2];
            for pair in stretch.places.windows(2) {
                let ((p, s), (p1, s1)) = (balls(&pair[0]), balls(&pair[1]));
                let linear = (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear);
                let slides = linear.map(|k| (pair[1][k] - pair[0][k]).powi(2)).sum::<f64>().sqrt();
                walked[0] += ((p1 - s1) - (p - s)).norm();
                walked[1] += slides;
                let off_bar = ((p1 - s1).norm() - bar).abs();
                assert!(off_bar < CHORD_MM + by_rounding(&pair[1]), "{said}: {off_bar} off the bar");
            }
            // a bar that keeps its direction: the ball goes about the axis on the slides' way
            let way_mm = if is_axial { walked[1] } else { walked[0] };
            let planned_s = way_mm / feed_mm_per_s;
            // positions are rounded: a short block is longer or shorter by a digit, at the slides and at the lever
            let rounding_s = 2.0 * near * 1.8 * (1.0 + bar / 57.0 + walked[1] / way_mm) / feed_mm_per_s;
            assert!(
                stretch.seconds > planned_s * (1.0 - 2e-4) - rounding_s,
                "{said}: {} s in place of {planned_s}",
                stretch.seconds
            );
            // whole milliseconds of FT, rounded up; elsewhere straight blocks last 0.02 ms beyond whole ones
            let slower_s = stretch.seconds - rounding_s - planned_s;
            let most_s = if dialect == Dialect::Heidenhain { 1e-3 } else { (2e-3 * planned_s).max(1.02e-3) };
            assert!(slower_s < most_s, "{said}: {} s in place of {planned_s}", stretch.seconds);
            total_s[0] += stretch.seconds;
            total_s[1] += planned_s;
            for place in &stretch.places {
                for (k, (axis, q)) in machine.axes.iter().zip(place).enumerate() {
                    let (Some((low, high)), false) = (axis.range, rows.iter().all(|row| row[k] == rows[0][k])) else {
                        continue;
                    };
                    let to = |limit: f64| axis.kind.to_file_unit((q - limit).abs());
                    assert!(to(low).min(to(high)) > 0.1 - 2.0 * near, "{said}: {} at its limit", axis.name);
                }
            }
        }
        // blocks of whole milliseconds together last less than one longer
        *worst_slow = worst_slow.max((total_s[0] - total_s[1] - 1e-3) / total_s[1]);
    }
    let (end, back) = found.acts[last + 2..].split_last().expect("the way back");
    assert_eq!(end, &Act::End, "{said}");
    let mut back = way(&mut run, back, planned, &balls, &said);
    back.insert(0, corners[corners.len() - 1].clone());
    visits(&back, &corners.iter().rev().cloned().collect::<Vec<_>>(), near, &said);
}

/// Marks go out and back along the bar, in their time, and end where they began.
fn check_marks(
    planned: &PlannedTest,
    marks: &[Stretch],
    balls: &Balls,
    by_rounding: &dyn Fn(&[f64]) -> f64,
    said: &str,
) {
    let Some(due) = planned.test.marks else {
        assert!(marks.is_empty(), "{said}");
        return;
    };
    assert_eq!(marks.len(), 8, "{said}");
    let bar_mm = planned.test.bar_length_mm.expect("planned");
    for pair in marks.chunks(2) {
        let [out, back] = pair else { unreachable!() };
        let gap = |q: &[f64]| {
            let (p, s) = balls(q);
            s - p
        };
        let (begin, end, again) = (&out.places[0], &back.places[0], &back.places[back.places.len() - 1]);
        let rounding = 2.0 * (by_rounding(begin) + by_rounding(end));
        let longer = gap(end).norm() - gap(begin).norm();
        assert!((longer - due.move_mm).abs() < CHORD_MM + rounding, "{said}: a mark of {longer}");
        // along the bar: across it the ball goes by rounding alone
        let across = gap(begin).normalize().cross(&(gap(end) - gap(begin))).norm();
        assert!(across < CHORD_MM + 3.0 * rounding + 2e-4, "{said}: a mark goes {across} aside");
        assert!((gap(again) - gap(begin)).norm() < CHORD_MM + 2e-4 + rounding, "{said}");
        assert!((gap(begin).norm() - bar_mm).abs() < 0.2, "{said}");
        let seconds = due.move_mm.abs() / due.feed_mm_per_min * 60.0;
        assert!([out, back].iter().all(|way| (way.seconds / seconds - 1.0).abs() < 2e-3), "{said}: {}", out.seconds);
    }
}

/// Distance of the balls below which a move must be at feed and follow a stop, mm beyond the bar.
const NEAR_MM: f64 = 95.0;

/// Where pivot ball and spindle ball stand.
type Balls<'a> = dyn Fn(&[f64]) -> (Vector3<f64>, Vector3<f64>) + 'a;

/// Places along a way of single axes; near the cups every leg is at feed, after a stop.
fn way(run: &mut Run, acts: &[Act], planned: &PlannedTest, balls: &Balls, said: &str) -> Vec<Vec<f64>> {
    let bar = planned.test.bar_length_mm.expect("planned");
    let mut places: Vec<Vec<f64>> = Vec::new();
    // the machine waits where a way begins
    let mut stopped = true;
    for act in acts {
        let (to, is_rapid) = match act {
            Act::Rapid(to) => (to, true),
            Act::Feed { to, pace: Pace::PerMinute(_) } => (to, false),
            Act::Stop => {
                stopped = true;
                continue;
            }
            other => panic!("{said}: {other:?}"),
        };
        assert_eq!(to.len(), 1, "{said}: one axis at a time");
        let (from, to) = (run.here.clone(), run.at(to));
        if from.iter().all(|q| q.is_finite()) {
            let apart = |part: f64| {
                let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + (b - a) * part).collect();
                let (p, s) = balls(&q);
                (p - s).norm()
            };
            let nearest = (0..=40).map(|k| apart(f64::from(k) / 40.0)).fold(f64::MAX, f64::min);
            assert!(!is_rapid || nearest > bar + NEAR_MM, "{said}: a rapid move {nearest} mm from ball to ball");
            assert!(is_rapid || stopped, "{said}: no stop before a leg near the cups");
            assert!(from != to, "{said}: a block that moves nothing");
        }
        stopped = false;
        run.here = to;
        places.push(run.here.clone());
    }
    places
}

/// The corners in order, other places between two of them on the way.
fn visits(places: &[Vec<f64>], corners: &[Vec<f64>], near: f64, said: &str) {
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let mut next = 0;
    for place in places {
        if next < corners.len() && off(place, &corners[next]) < near {
            next += 1;
            continue;
        }
        let (Some(from), Some(to)) = (corners.get(next.wrapping_sub(1)), corners.get(next)) else {
            panic!("{said}: {place:?} is on no leg")
        };
        let between = |k: usize| place[k] > from[k].min(to[k]) - near && place[k] < from[k].max(to[k]) + near;
        assert!((0..place.len()).all(between), "{said}: {place:?} is not on the way from {from:?} to {to:?}");
    }
    assert_eq!(next, corners.len(), "{said}: {places:?} {corners:?}");
}

/// Axes' offsets in a program: machine coordinates on controls that feed in them.
fn offsets(machine: &Machine, dialect: Dialect) -> Vec<f64> {
    let all: Option<Vec<f64>> = machine.machine_zero.iter().copied().collect();
    match (dialect, all) {
        (Dialect::Generic, _) | (_, None) => vec![0.0; machine.axes.len()],
        (_, Some(zeros)) => zeros,
    }
}

#[test]
fn programs_read_back_keep_places_bar_and_pace() {
    let mut counted = [0; 3];
    for name in ["hermle-c600u.yaml", "fig-1-1-table-head-ca.yaml", "head-head-ab-profiler.yaml"] {
        let (mut machine, tests) = planned(name);
        for zeros in [vec![None; 5], vec![Some(312.5), Some(-3.25), Some(-410.0), Some(-0.5), Some(96.125)]] {
            machine.machine_zero = zeros;
            for dialect in [Dialect::Generic, Dialect::Heidenhain, Dialect::Sinumerik] {
                assert_eq!(dialect.unknown_axis(&machine), None);
                let mut worst_slow = 0.0;
                for planned in &tests {
                    check(&machine, planned, dialect, &offsets(&machine, dialect), &mut worst_slow);
                    counted[match planned.test.path {
                        Some(TestPath::Circle { .. }) => 2,
                        _ => usize::from(planned.is_coupled()),
                    }] += 1;
                }
                println!("{name} {dialect:?}: at most {:.2} % slower than planned", worst_slow * 100.0);
                // over whole runs: feeds are rounded down to three decimals
                assert!(worst_slow < 5e-5, "{worst_slow}");
            }
        }
    }
    println!("{counted:?} sweeps, following runs, circles");
    assert!(counted.iter().all(|count| *count >= 6), "{counted:?}");
}

/// Straight blocks take the time of the session's feed on every control, not a part of a millisecond more for each block.
#[test]
fn runs_in_blocks_take_the_time_that_import_counts_on() {
    let mut counted = 0;
    let planned = ["nutating-head-45.yaml", "table-1-1-head-head-ca.yaml"].map(planned);
    let coupled = planned.iter().flat_map(|(machine, tests)| tests.iter().map(move |test| (machine, test)));
    for (machine, planned) in coupled.filter(|(_, test)| test.is_coupled()) {
        let mut session = bare_session(machine);
        session.tests = planned.both_ways().to_vec();
        let course = Course::of(&session, Pair { tests: [0, 1] }, Feeds::Programmed).expect("a run");
        for dialect in [Dialect::Generic, Dialect::Heidenhain, Dialect::Sinumerik] {
            let said = format!("{dialect:?} {}", planned.test.name);
            for piece in read(machine, planned, dialect).acts.split(|act| matches!(act, Act::Dwell(_))) {
                let seconds = piece.iter().map(|act| match act {
                    Act::Feed { pace: Pace::Seconds(seconds), .. } => Some(*seconds),
                    _ => None,
                });
                // a mark is two blocks of its own
                let Some(blocks) = seconds.collect::<Option<Vec<f64>>>().filter(|blocks| blocks.len() > 8) else {
                    continue;
                };
                let longer_s = blocks.iter().sum::<f64>() - course.run_s;
                println!("{said}: {} blocks, {:.2} ms longer than {:.3} s", blocks.len(), 1e3 * longer_s, course.run_s);
                assert!((-1e-4..1.2e-3).contains(&longer_s), "{said}: {longer_s} s of {}", course.run_s);
                counted += 1;
            }
        }
    }
    assert!(counted >= 12, "{counted} runs in blocks");
}

#[test]
fn no_time_or_feed_is_rounded_to_faster() {
    let (machine, tests) = planned("hermle-c600u.yaml");
    let mut planned = tests.iter().find(|test| !test.is_coupled()).expect("a sweep").clone();
    // 500 mm/min at this lever is 123.45678 deg/min
    planned.rho_mm = 500f64.to_degrees() / 123.456_78;
    for dialect in [Dialect::Generic, Dialect::Heidenhain, Dialect::Sinumerik] {
        let feeds: Vec<f64> = read(&machine, &planned, dialect)
            .acts
            .iter()
            .filter_map(|act| match act {
                Act::Feed { pace: Pace::PerMinute(feed), .. } => Some(*feed),
                _ => None,
            })
            .collect();
        assert_eq!(feeds.iter().filter(|feed| **feed == 123.456).count(), 2, "{dialect:?} {feeds:?}");
        assert!(!feeds.contains(&123.457), "{dialect:?}");
    }
}

#[test]
fn heads_tell_lengths_and_offsets() {
    let (mut machine, tests) = planned("hermle-c600u.yaml");
    let planned = &tests[0];
    let head = |machine: &Machine, dialect| read(machine, planned, dialect).comments.join("\n");
    let dialects = [Dialect::Generic, Dialect::Heidenhain, Dialect::Sinumerik];
    for dialect in dialects {
        let head = head(&machine, dialect);
        // the generic dialect has capitals alone
        let said = |words: &str| match dialect {
            Dialect::Generic => head.contains(&words.to_uppercase().replace('_', " ")),
            _ => head.contains(words),
        };
        assert!(said("gauge length 110.000 mm"), "{head}");
        assert!(said("ball bar 100 mm"), "{head}");
        assert!(said("positions in work coordinates") && said("no machine_zero"), "{head}");
        assert_eq!(said("G4 X is a dwell in seconds"), dialect == Dialect::Generic, "{head}");
        for caveat in &machine.caveats {
            let first = caveat.split(|c: char| !c.is_ascii_alphanumeric() && c != ' ').next().expect("words");
            assert!(said(&format!("assumed: {first}")), "{head}: {caveat}");
        }
    }
    let x = machine.axis_index("X").expect("X");
    machine.machine_zero[x] = Some(312.5);
    for dialect in dialects {
        let found = read(&machine, planned, dialect);
        let head = found.comments.join("\n").to_lowercase().replace("machine zero", "machine_zero");
        assert!(head.contains("stated for x 312.5000 but not for c a y z: it is not used"), "{head}");
        assert!(head.contains("positions in work coordinates") && !found.in_machine_coordinates, "{head}");
    }
    machine.machine_zero = vec![Some(0.0), Some(-0.5), Some(-410.0), Some(312.5), Some(96.125)];
    for dialect in dialects {
        let found = read(&machine, planned, dialect);
        let head = found.comments.join("\n").to_lowercase().replace("machine zero", "machine_zero");
        // a G53 block is a rapid one on Fanuc's controls
        let is_machine = dialect != Dialect::Generic;
        assert_eq!(found.in_machine_coordinates, is_machine, "{head}");
        let said = if is_machine { "positions in machine coordinates, machine_zero " } else { "from machine_zero: " };
        assert!(head.contains(&format!("{said}c 0.0000 a -0.5000 y -410.0000 x 312.5000 z 96.1250")), "{head}");
    }
}

/// The thesis's short test of A, and a quarter of a circle in XY: programs short enough to be read.
fn by_hand() -> (Machine, [PlannedTest; 2]) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    let (mut machine, _) = load_machine_and_bodies(&file).expect("shipped machine");
    let axis = |name: &str| machine.axis_index(name).expect("axis");
    let [c, a, y, x, z] = ["C", "A", "Y", "X", "Z"].map(axis);
    assert_eq!([c, a, y, x, z], [0, 1, 2, 3, 4]);
    machine.machine_zero = vec![Some(0.0), Some(-0.5), Some(-410.0), Some(312.5), Some(96.125)];
    // the arcs of these programs, whatever the sense of the shipped file
    machine.axes[a].range = Some(((-30f64).to_radians(), 110f64.to_radians()));
    let ball = |link: &str, at: [f64; 3]| Ball {
        link: link.into(),
        at: Vector3::from(at),
        setup: None,
        spread_mm: None,
        indexed_about: None,
    };
    let test = |name: &str, path: TestPath, pivot: [f64; 3], positions: [Option<f64>; 5]| Test {
        name: name.into(),
        recording_file: None,
        recording: None,
        path: Some(path),
        started_at_s: 0.0,
        bar_length_mm: Some(100.0),
        bar_setup: None,
        zero: Default::default(),
        bar_error_mm: 0.0,
        pivot: ball("C", pivot),
        spindle_ball: ball("Z", [0.0; 3]),
        positions: positions.to_vec(),
        feed_mm_per_min: Some(500.0),
        overshoot: Some(4.0),
        marks: None,
        approached: Vec::new(),
        reading: fiveaxis::readings::Reading::Length,
    };
    let planned = |test: Test, axis: usize, ends: [f64; 2], legs: Vec<Leg>, height_mm: f64| PlannedTest {
        number: axis,
        test,
        placing: Placing {
            jog: Some(vec![0.0, 0.0, -4.0, 100.0, 60.0]),
            pivot_mm: 0.06,
            reason: "3 sigma of the 20 um that the session counts on".into(),
            gauge_length_mm: 0.009,
        },
        axis,
        rho_mm: 100.0,
        h_mm: 0.0,
        way_radius_mm: 100.0,
        sweep: ClearSweep {
            from_deg: ends[0],
            to_deg: ends[1],
            clearance_mm: 6.0,
            pair: ("table".into(), "spindle housing".into()),
            ends: [None, None],
        },
        minutes: 1.0,
        mount: "table top".into(),
        height_mm,
        run: Vec::new(),
        middle: Vec::new(),
        approach: Approach {
            park: vec![0.0, 0.0, 0.0, 0.0, 329.0],
            park_order: vec![z, c, a, y, x],
            aside_and_back: Vec::new(),
            legs,
        },
        mounting: Mounting { bar_parts_mm: vec![100.0], calibrator_mm: Some(100.0), nose_to_ball_mm: 110.0, arm: None },
    };
    let zero = Some(0.0);
    let sweep = TestPath::Sweep { axis: a, from: -20.0, to: 70.0, step: 0.5, follow: Follow::None, length_mm: None };
    let short = test("a-short", sweep, [0.0, -100.0, 0.0], [zero, None, zero, zero, zero]);
    let turned = Leg { axis: a, to: (-24f64).to_radians() };
    let plane = CirclePlane { first: x, second: y };
    let circle = TestPath::Circle { plane, radius_mm: 100.0, from: 0.0, to: 90.0, step: 0.5 };
    let quarter = test("xy-quarter", circle, [0.0, 0.0, 60.0], [zero, zero, None, None, Some(60.0)]);
    // 4 mm before the arc on the same circle
    let (sin, cos) = 0.04f64.sin_cos();
    let aside = vec![Leg { axis: x, to: 100.0 * cos }, Leg { axis: y, to: -100.0 * sin }, Leg { axis: z, to: 60.0 }];
    let tests = [
        planned(short, a, [-20.0, 70.0], vec![turned, Leg { axis: z, to: 0.0 }], 75.0),
        planned(quarter, x, [0.0, 90.0], aside, 135.0),
    ];
    (machine, tests)
}

#[test]
fn short_programs_read_as_written_by_hand() {
    let (machine, tests) = by_hand();
    for planned in &tests {
        for (dialect, ending) in Dialect::ALL {
            let file = format!("tests/data/nc/{}.{ending}", planned.test.name);
            let found = program(&machine, planned, &[], dialect);
            let due = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(&file)).expect("reference");
            for (number, (found, due)) in found.lines().zip(due.lines()).enumerate() {
                assert_eq!(found, due, "{file}:{}", number + 1);
            }
            assert_eq!(found.lines().count(), due.lines().count(), "{file}");
        }
    }
}

#[test]
fn names_stay_inside_their_comments() {
    let (mut machine, tests) = planned("fig-1-1-head-head-cb.yaml");
    let as_planned = program(&machine, &tests[0], &[], Dialect::Generic).lines().count();
    machine.name = format!("Mill\nG0 Z-100\r\nM3 (run) ; now % {}", "long ".repeat(200));
    for (dialect, _) in Dialect::ALL {
        let text = program(&machine, &tests[0], &[], dialect);
        let lines: Vec<&str> = text.split(['\n', '\r']).collect();
        let named: Vec<&&str> = lines.iter().filter(|line| line.contains("G0 Z-100")).collect();
        assert_eq!(named.len(), 1, "{dialect:?}");
        let is_comment = |line: &str| match dialect {
            Dialect::Generic | Dialect::LinuxCnc => line.starts_with('(') && line.ends_with(')'),
            _ => line.contains("; machine Mill"),
        };
        assert!(is_comment(named[0]), "{dialect:?}: {}", named[0]);
        assert!(lines.iter().all(|line| line.len() <= 250), "{dialect:?}");
    }
    assert_eq!(program(&machine, &tests[0], &[], Dialect::Generic).lines().count(), as_planned);
}

#[test]
fn an_arm_at_the_spindle_is_to_be_locked() {
    let (machine, tests) = planned("fig-1-1-head-head-cb.yaml");
    let (mut with_arm, mut without) = (0, 0);
    for planned in &tests {
        let says = program(&machine, planned, &[], Dialect::Heidenhain).contains("lock it before anything is mounted");
        assert_eq!(says, planned.mounting.arm.is_some(), "{}", planned.test.name);
        if says { with_arm += 1 } else { without += 1 }
    }
    assert!(with_arm + without > 0);
}

#[test]
fn modes_are_left_as_they_were() {
    let (machine, tests) = planned("hermle-c600u.yaml");
    for planned in &tests {
        let after = read(&machine, planned, Dialect::Sinumerik).modes;
        for (group, word) in BEFORE {
            assert_eq!(after[group], word, "{} {group}", planned.test.name);
        }
        // a control without a word for it stands as after power-on
        let after = read(&machine, planned, Dialect::Generic).modes;
        for (group, word) in [("plane", "G17"), ("unit", "G21"), ("distance", "G90"), ("feed", "G94")] {
            assert_eq!(after[group], word, "{} {group}", planned.test.name);
        }
    }
}

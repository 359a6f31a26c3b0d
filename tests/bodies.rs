//! Bodies of shipped machines over their whole travel, against parry with link poses by plain transforms of the test's own.

use crate::shipped;
use std::path::Path;

use fiveaxis::bodies::{Bodies, Body};
use fiveaxis::chain::{Chain, Pose};
use fiveaxis::collision::{Convex, Meeting, Scratch, World, parry_shape};
use fiveaxis::load::{load_kit, load_machine_and_bodies};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::plan::{Settings, plan};
use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use parry3d::math::Pose as Placed;
use parry3d::shape::SharedShape;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shipped::machine_files;

/// Axes that carry a link, from the bed outward.
fn carriers(machine: &Machine, link: &str) -> Vec<usize> {
    let on_table = machine.code.workpiece_side.len();
    let table: Vec<usize> = (0..on_table).rev().collect();
    let tool: Vec<usize> = (on_table..machine.axes.len()).collect();
    match (link, machine.axis_index(link)) {
        ("b", _) => Vec::new(),
        ("w", _) => table,
        ("t", _) => tool,
        (_, Some(axis)) if axis < on_table => table.into_iter().take_while(|&k| k >= axis).collect(),
        (_, axis) => tool.into_iter().take_while(|&k| Some(k) <= axis).collect(),
    }
}

/// The bed from a link, by transforms one after the other.
fn pose(machine: &Machine, link: &str, q: &[f64]) -> Isometry3<f64> {
    carriers(machine, link).into_iter().fold(Isometry3::identity(), |pose, k| {
        let axis = &machine.axes[k];
        let by = machine.motion_sign(k) * q[k];
        pose * match axis.kind {
            AxisKind::Linear => Isometry3::from(Translation3::from(axis.direction * by)),
            AxisKind::Rotary => {
                let to = Translation3::from(axis.origin);
                to * UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis.direction), by) * to.inverse()
            }
        }
    })
}

/// Distance of two bodies by parry, mm; not above zero in contact.
fn apart(machine: &Machine, one: &Body, other: &Body, q: &[f64]) -> f64 {
    let placed = |body: &Body| -> Vec<_> {
        let at = pose(machine, &body.link, q);
        let rotation: Matrix3<f64> = *at.rotation.to_rotation_matrix().matrix();
        let link = Pose { rotation, translation_mm: at.translation.vector };
        let solids = body.solids.iter().map(|solid| Convex::of(solid, body.at.rotation, body.at.translation_mm));
        solids.map(|convex| parry_shape(&convex, &link).expect("shape")).collect()
    };
    let mut least = f64::MAX;
    for (shape, at) in &placed(one) {
        for (other_shape, other_at) in &placed(other) {
            let found = parry3d::query::distance(at, &*shape.0, other_at, &*other_shape.0).expect("supported");
            // of two boxes parry's separating axes may miss the nearest corner: what projections find is an upper bound
            let boxes = shape.as_cuboid().is_some() && other_shape.as_cuboid().is_some();
            let bound = if boxes { by_projections((at, shape), (other_at, other_shape)) } else { f64::MAX };
            least = least.min(found.distance).min(bound);
        }
    }
    least
}

/// Distance of two convex solids by projecting a point on one and the other in turn (von Neumann; Cheney and Goldstein 1959): from
/// above, to 1e-6 mm.
fn by_projections((at, one): (&Placed, &SharedShape), (other_at, other): (&Placed, &SharedShape)) -> f64 {
    let mut point = other_at.translation;
    let mut last = f64::MAX;
    for _ in 0..100_000 {
        let near = one.project_point(at, point, true).point;
        point = other.project_point(other_at, near, true).point;
        let apart = (near - point).length();
        if last - apart < 1e-12 {
            return apart;
        }
        last = apart;
    }
    last
}

/// Unlisted pairs of bodies with an axis between, and these axes.
fn unlisted<'b>(machine: &Machine, bodies: &'b Bodies) -> Vec<(&'b Body, &'b Body, Vec<usize>)> {
    let mut pairs = Vec::new();
    for (k, one) in bodies.bodies.iter().enumerate() {
        for other in &bodies.bodies[k + 1..] {
            let (own, far) = (carriers(machine, &one.link), carriers(machine, &other.link));
            let mut axes: Vec<usize> = own.iter().copied().filter(|axis| !far.contains(axis)).collect();
            axes.extend(far.iter().filter(|axis| !own.contains(axis)));
            let is = |a: &str, b: &str| (a == one.name && b == other.name) || (a == other.name && b == one.name);
            if !axes.is_empty() && !bodies.touching.iter().any(|(a, b)| is(a, b)) {
                pairs.push((one, other, axes));
            }
        }
    }
    pairs
}

fn range(machine: &Machine, axis: usize) -> (f64, f64) {
    machine.axes[axis].range.expect("shipped machines state ranges")
}

#[test]
fn neighbours_of_shipped_machines_never_touch_unless_listed() {
    for file in machine_files() {
        let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
        let world = World::new(&Chain::of(&machine), &bodies).expect("links");
        assert_eq!((world.meetings_at_zero(&machine), world.meetings_by_one_axis(&machine)), (vec![], vec![]));
        assert!(!bodies.touching.is_empty(), "{}", file.display());
        let mut q = vec![0.0; machine.axes.len()];
        for (one, other, axes) in unlisted(&machine, &bodies) {
            assert!(apart(&machine, one, other, &q) > 0.0, "{}: {} – {}", file.display(), one.name, other.name);
            let &[axis] = axes.as_slice() else { continue };
            let (low, high) = range(&machine, axis);
            for k in 0..=120 {
                q[axis] = low + (high - low) * f64::from(k) / 120.0;
                let mm = apart(&machine, one, other, &q);
                assert!(mm > 1.0, "{}: {} – {} {mm} at {}", file.display(), one.name, other.name, q[axis]);
            }
            q[axis] = 0.0;
        }
    }
}

#[test]
fn least_distances_at_random_poses_are_those_of_all_unlisted_pairs() {
    let seed = 29;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for file in machine_files() {
        let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
        let world = World::new(&Chain::of(&machine), &bodies).expect("links");
        let scene = world.scene();
        let pairs = unlisted(&machine, &bodies);
        assert_eq!(scene.pairs().len(), pairs.len(), "{}: one solid a body", file.display());
        let (mut scratch, mut clear) = (Scratch::default(), 0);
        for _ in 0..60 {
            let draw = |axis| {
                let (low, high) = range(&machine, axis);
                random.random_range(low..high)
            };
            let q: Vec<f64> = (0..machine.axes.len()).map(draw).collect();
            let due = pairs.iter().map(|(one, other, _)| apart(&machine, one, other, &q)).fold(f64::MAX, f64::min);
            let found = scene.clearance(&q, &mut scratch).mm;
            if due > 1e-3 {
                clear += 1;
                assert!((found - due).abs() < 1e-3, "{} {q:?}: {found} {due}", file.display());
            } else {
                assert!(found < 2e-3, "{} {q:?}: {found} {due}", file.display());
            }
        }
        assert!(clear > 5, "{}: {clear} clear", file.display());
    }
}

/// A shipped machine with a part of its text replaced.
fn changed(name: &str, changes: &[(&str, &str)]) -> (Machine, Bodies) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let mut text = std::fs::read_to_string(file).expect("shipped machine");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join(name), text).expect("written");
    load_machine_and_bodies(&folder.path().join(name)).expect("valid")
}

fn meeting<'m>(found: &'m [Meeting], one: &str, other: &str) -> &'m Meeting {
    found.iter().find(|m| (m.pair.0.as_str(), m.pair.1.as_str()) == (one, other)).unwrap_or_else(|| panic!("{found:?}"))
}

/// On the table of the C600U, its corners 7.70 mm deeper than the cradle arms' inner faces when they point there.
const VICE: (&str, &str) =
    ("bodies:\n", "bodies:\n  - {name: vice, link: C, box: {at: [0, 0, -45], size: [120, 313.2, 60]}}\n");

#[test]
fn a_vice_that_turns_into_the_cradle_is_found_and_planned_around() {
    let (machine, bodies) = changed("hermle-c600u.yaml", &[VICE]);
    let world = World::new(&Chain::of(&machine), &bodies).expect("links");
    assert_eq!(world.meetings_at_zero(&machine), vec![]);
    let found = world.meetings_by_one_axis(&machine);
    let due = 60f64.hypot(156.6) - 160.0;
    for arm in ["cradle arm left", "cradle arm right"] {
        let meeting = meeting(&found, "vice", arm);
        assert!((meeting.depth_mm - due).abs() < 0.01, "{} {due}", meeting.depth_mm);
        let [(axis, at)] = meeting.at[..] else { panic!("one axis") };
        assert_eq!(machine.axes[axis].name, "C");
        // a corner of the vice points along x
        let corner = at.sin().abs() * 156.6 + at.cos().abs() * 60.0;
        assert!((corner - 60f64.hypot(156.6)).abs() < 0.02, "{at}");
    }
    // a plan may turn the vice only where it is clear of the arms
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("kit");
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("plan");
    for test in &found.tests {
        let corners = test.approach.corners();
        for leg in test.run.windows(2).chain(corners.windows(2)) {
            for k in 0..=50 {
                let part = f64::from(k) / 50.0;
                let q: Vec<f64> = leg[0].iter().zip(&leg[1]).map(|(a, b)| a + (b - a) * part).collect();
                for (one, other, _) in unlisted(&machine, &bodies).iter().filter(|(one, ..)| one.name == "vice") {
                    let mm = apart(&machine, one, other, &q);
                    assert!(mm > 5.0 - 1e-6, "{}: vice – {} {mm}", test.test.name, other.name);
                }
            }
        }
    }
}

#[test]
fn a_beam_that_runs_into_the_wall_behind_it_is_found() {
    let wall = ("at: [0, 830, 100]", "at: [0, 640, 100]");
    let (machine, bodies) = changed("hermle-c600u.yaml", &[wall]);
    let world = World::new(&Chain::of(&machine), &bodies).expect("links");
    let found = world.meetings_by_one_axis(&machine);
    assert_eq!(found.len(), 1);
    // the beam's lower 90 mm are level with the wall
    assert!((meeting(&found, "back wall", "gantry beam").depth_mm - 90.0).abs() < 1e-6, "{found:?}");
    let slide = ("slide Y, link: Y, box: {at: [200, 60, 560]", "slide Y, link: Y, box: {at: [223, 60, 560]");
    let unlisted = ("  - [portal beam, slide Y]\n", "");
    let (machine, bodies) = changed("table-table-ca-portal.yaml", &[slide, unlisted]);
    let world = World::new(&Chain::of(&machine), &bodies).expect("links");
    let found = world.meetings_at_zero(&machine);
    assert!((meeting(&found, "portal beam", "slide Y").depth_mm - 23.0).abs() < 1e-6, "{found:?}");
    let why = world.refuse_overlaps(&machine).expect_err("refused");
    assert!(why.contains("by 23.0 mm") && why.contains("touching: [[portal beam, slide Y]]"), "{why}");
}

#[test]
fn what_lies_closer_than_the_margin_by_design_does_not_keep_plans_from_being_made() {
    // the table runs 3 mm over the cradle, which nothing on the machine changes
    let over = ("cylinder: {from: [0, 0, -111]", "cylinder: {from: [0, 0, -118]");
    let unlisted = ("  - [table, cradle plate]\n", "");
    let (machine, bodies) = changed("hermle-c600u.yaml", &[over, unlisted]);
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("kit");
    let settings = Settings { method: Some(fiveaxis::plan::Method::Chapter5), ..Settings::default() };
    let found = plan(&machine, &bodies, &kit, &settings).expect("plan");
    assert!(!found.tests.is_empty());
    for test in &found.tests {
        // and it is told as the least that is there
        assert!((test.sweep.clearance_mm - 3.0).abs() < 0.05, "{}", test.sweep.clearance_mm);
        let pair = (test.sweep.pair.0.as_str(), test.sweep.pair.1.as_str());
        assert!(pair == ("table", "cradle plate") || pair == ("cradle plate", "table"), "{pair:?}");
    }
}

#[test]
fn whole_travels_certified_clear_are_clear_at_random_poses() {
    let seed = 31;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let limit_mm = 5.0;
    let mut settled = 0;
    for file in machine_files() {
        let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
        let world = World::new(&Chain::of(&machine), &bodies).expect("links");
        let rest = world.without_settled_pairs(&machine, limit_mm);
        let (all, rest) = (world.scene(), rest.scene());
        let name = |pair: &(usize, usize)| [&all.parts()[pair.0].name, &all.parts()[pair.1].name];
        let kept: Vec<_> = rest.pairs().iter().map(name).collect();
        for (one, other, axes) in unlisted(&machine, &bodies) {
            if kept.iter().any(|pair| pair.contains(&&one.name) && pair.contains(&&other.name)) {
                continue;
            }
            settled += 1;
            for _ in 0..100 {
                let mut q = vec![0.0; machine.axes.len()];
                for &axis in &axes {
                    let (low, high) = range(&machine, axis);
                    // ends of travels count as much as what lies between
                    q[axis] = random.random_range(low - 0.3 * (high - low)..high + 0.3 * (high - low)).clamp(low, high);
                }
                let mm = apart(&machine, one, other, &q);
                assert!(mm > limit_mm, "{}: {} – {} {mm}", file.display(), one.name, other.name);
            }
        }
    }
    println!("{settled} pairs settled");
    assert!(settled > 200);
}

#[test]
fn directions_of_symmetric_travels_do_not_matter_to_neighbours() {
    use fiveaxis::machine::Directions;
    for file in machine_files() {
        let (mut machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
        for directions in [Directions::Carried, Directions::Iso841] {
            machine.directions = Some(directions);
            let world = World::new(&Chain::of(&machine), &bodies).expect("links");
            let symmetric = |m: &Meeting| machine.axes[m.at[0].0].range.is_some_and(|(low, high)| low == -high);
            let mut found = world.meetings_by_one_axis(&machine);
            found.retain(symmetric);
            assert_eq!(found, vec![], "{}", file.display());
        }
    }
}

#[test]
fn a_stand_is_excused_from_the_one_body_under_it_alone() {
    // a raised rim of the table as a body of its own: the stand is compared with it
    let rim = ("bodies:\n", "bodies:\n  - {name: rim, link: C, box: {at: [-100, 0, -60], size: [20, 20, 29]}}\n");
    let (machine, bodies) = changed("hermle-c600u.yaml", &[rim]);
    let world = World::new(&Chain::of(&machine), &bodies).expect("links");
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("kit");
    let ball = |link: &str, at| fiveaxis::session::Ball {
        link: link.into(),
        at,
        setup: None,
        spread_mm: None,
        indexed_about: None,
    };
    let test = fiveaxis::session::Test {
        name: "a".into(),
        recording_file: None,
        recording: None,
        path: None,
        started_at_s: 0.0,
        bar_length_mm: Some(100.0),
        bar_setup: None,
        zero: Default::default(),
        bar_error_mm: 0.0,
        pivot: ball("C", Vector3::new(-100.0, 0.0, 0.0)),
        spindle_ball: ball("Z", Vector3::zeros()),
        positions: vec![Some(0.0); machine.axes.len()],
        feed_mm_per_min: None,
        overshoot: None,
        marks: None,
        approached: Vec::new(),
        reading: fiveaxis::readings::Reading::Length,
    };
    let instrument = fiveaxis::collision::Instrument::of(&world, &machine, &bodies, &kit, &test).expect("instrument");
    let scene = instrument.scene(&world);
    let with = |one: &str, other: &str| {
        let name = |part: usize| scene.parts()[part].name.as_str();
        let is = |&&(a, b): &&(usize, usize)| [name(a), name(b)] == [one, other] || [name(b), name(a)] == [one, other];
        scene.pairs().iter().filter(is).count()
    };
    assert_eq!((with("table", "pivot base"), with("table", "pivot stem")), (0, 0));
    assert_eq!((with("rim", "pivot base"), with("rim", "pivot stem")), (1, 1));
    assert_eq!((with("table", "pivot cup"), with("table", "bar") > 0), (1, true));
    assert_eq!((with("spindle housing", "spindle stem"), with("head", "spindle stem")), (0, 1));
    let nearest = scene.clearance(&vec![0.0; machine.axes.len()], &mut Scratch::default());
    assert!(nearest.mm < 0.0, "{nearest:?}");
}

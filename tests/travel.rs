//! Ways between tests: every approach of a plan sampled densely, obstacles planted on the way, walls that leave none.

use crate::planned::plan_of;
use std::path::Path;
use std::sync::Arc;

use fiveaxis::bodies::{Bodies, Body, Solid};
use fiveaxis::chain::{Chain, Pose};
use fiveaxis::collision::{Instrument, Leg, Scratch, World, clear_way};
use fiveaxis::load::{load_machine_and_bodies, machine_from_yaml, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::nc::{Coordinates, Curves, Step, steps};
use fiveaxis::plan::{Coupled, Plan, PlannedTest, Settings};
use nalgebra::{Matrix3, Vector3};

fn load(name: &str) -> (Machine, Bodies) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    load_machine_and_bodies(&file).expect("shipped machine")
}

/// A plan in which every test turns one axis alone.
fn planned_sweeps(machine: &Machine, bodies: &Bodies) -> Arc<Plan> {
    let settings = Settings { coupled: Coupled::default(), ..Settings::default() };
    plan_of(machine, bodies, &settings)
}

fn body(name: &str, link: &str, solid: Solid, at: [f64; 3]) -> Body {
    let at = Pose { rotation: Matrix3::identity(), translation_mm: Vector3::from(at) };
    Body { name: name.into(), link: link.into(), solids: vec![solid], at }
}

/// Least clearance along some corners at 0.2 deg and 0.5 mm, bar off, and the pair.
fn sampled(machine: &Machine, bodies: &Bodies, test: &PlannedTest, corners: &[Vec<f64>]) -> (f64, String) {
    let chain = Chain::of(machine);
    let world = World::new(&chain, bodies).expect("links");
    let kit = standard_kit().expect("kit");
    let instrument = Instrument::of(&world, machine, bodies, &kit, &test.test).expect("instrument");
    let scene = instrument.scene_without_bar(&world);
    assert!(scene.parts().iter().all(|part| part.name != "bar"));
    let mut scratch = Scratch::default();
    let mut least = (f64::MAX, String::new());
    for pair in corners.windows(2) {
        let far = pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        let count = (far / if far > 7.0 { 0.5 } else { 0.0035 }).ceil().max(1.0) as usize;
        for k in 0..=count {
            let t = k as f64 / count as f64;
            let q: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| a + (b - a) * t).collect();
            let (mm, pair) = scene.least(&q, &mut scratch);
            if let Some((one, other)) = pair.filter(|_| mm < least.0) {
                least = (mm, format!("{} – {}", scene.parts()[one].name, scene.parts()[other].name));
            }
        }
    }
    least
}

/// Axis and place of a move of one axis.
fn moved(step: &Step) -> Option<(String, f64)> {
    match step {
        Step::Rapid { axis, to } | Step::Feed { axis, to, .. } => Some((axis.clone(), *to)),
        _ => None,
    }
}

/// Axes that stand in the run come from 10 mm or deg away, in the sense that their test states.
fn come_in_stated_senses(machine: &Machine, test: &PlannedTest, moves: &[(String, f64)]) {
    let mut at: Vec<f64> = vec![f64::NAN; machine.axes.len()];
    let mut from = at.clone();
    for (axis, to) in moves {
        let k = machine.axis_index(axis).expect("axis");
        let goes_on = (at[k] - from[k]) * (machine.axes[k].kind.from_file_unit(*to) - at[k]) > 0.0;
        if !goes_on {
            from[k] = at[k];
        }
        at[k] = machine.axes[k].kind.from_file_unit(*to);
    }
    for k in 0..machine.axes.len() {
        let stands = test.run.iter().all(|row| (row[k] - test.run[0][k]).abs() < 1e-6);
        let sense = test.test.approached[k];
        assert!(stands || sense.is_none(), "{}: {}", test.test.name, machine.axes[k].name);
        if let Some(sense) = sense {
            let way = machine.axes[k].kind.to_file_unit(at[k] - from[k]);
            assert!(sense * way > 10.0 - 1e-6, "{} {}: {way}", test.test.name, machine.axes[k].name);
        }
    }
}

#[test]
fn approaches_of_plans_are_clear_end_where_the_run_starts_and_come_back() {
    for name in ["hermle-c600u.yaml", "table-head-ab-blade.yaml", "table-table-ca-portal.yaml", "nutating-head-45.yaml"]
    {
        let (machine, bodies) = load(name);
        let plan = plan_of(&machine, &bodies, &Settings::default());
        assert!(!plan.tests.is_empty());
        for test in &plan.tests {
            let corners = test.approach.corners();
            let (least, pair) = sampled(&machine, &bodies, test, &corners);
            assert!(least > 5.0 - 1e-6, "{name} {}: {least} {pair}", test.test.name);
            let start = corners.last().expect("park");
            for (k, q) in start.iter().enumerate() {
                let (low, high) = machine.axes[k].range.unwrap_or((f64::MIN, f64::MAX));
                let wanted = match test.test.positions[k] {
                    Some(wanted) => wanted,
                    // on by 4 mm or 4 deg of the fastest axis, which is compared in the plan's own test
                    None if test.is_coupled() => test.run[0][k],
                    None => (test.sweep.from_deg - 4.0).to_radians().clamp(low, high),
                };
                assert!((q - wanted).abs() < 1e-12, "{name} {}", test.test.name);
            }
            // the program goes to park, out, and back to park, one axis a block; what comes near the cups is no rapid move
            let steps = steps(&machine, test, &Coordinates::of(&machine), Curves::Carrying);
            let last = steps.iter().filter(|step| matches!(step, Step::Dwell(_))).count();
            let moves: Vec<(String, f64)> = steps
                .split(|step| matches!(step, Step::Dwell(_)))
                .enumerate()
                .filter(|(part, _)| [0, last].contains(part))
                .flat_map(|(_, steps)| steps.to_vec())
                .filter_map(|step| moved(&step))
                .collect();
            let axes = machine.axes.len();
            // what goes aside from park and back is clear, too, and comes before the way
            let asides = &test.approach.aside_and_back;
            for pair in asides.chunks(2) {
                let mut aside = test.approach.park.clone();
                aside[pair[0].axis] = pair[0].to;
                let (least, pair) = sampled(&machine, &bodies, test, &[test.approach.park.clone(), aside]);
                assert!(least > 5.0 - 1e-6, "{name} {}: aside {least} {pair}", test.test.name);
            }
            let there = steps.iter().take_while(|step| !matches!(step, Step::Dwell(_))).filter_map(moved);
            come_in_stated_senses(&machine, test, &there.collect::<Vec<_>>());
            let moves = [&moves[..axes], &moves[axes + asides.len()..]].concat();
            assert!(moves.len() >= axes + 2 * (corners.len() - 1), "{name} {}", test.test.name);
            // every move lies on a leg of the way
            for (axis, to) in &moves[axes..] {
                let k = machine.axis_index(axis).expect("axis");
                let on_the_way = corners.windows(2).any(|leg| {
                    let ends = [leg[0][k], leg[1][k]].map(|q| machine.axes[k].kind.to_file_unit(q));
                    *to > ends[0].min(ends[1]) - 1e-9 && *to < ends[0].max(ends[1]) + 1e-9
                });
                assert!(on_the_way, "{axis} {to}");
            }
            let mut back = start.clone();
            for Leg { axis, to } in test.approach.retreat() {
                back[axis] = to;
            }
            assert_eq!(back, test.approach.park);
        }
        // one place to park for all tests of a plan
        assert!(plan.tests.iter().all(|test| test.approach.park == plan.tests[0].approach.park), "{name}");
    }
}

#[test]
fn an_obstacle_on_the_way_to_the_start_is_avoided() {
    let (machine, bodies) = load("hermle-c600u.yaml");
    let a = machine.axis_index("A").expect("A");
    let c = machine.axis_index("C").expect("C");
    let before = planned_sweeps(&machine, &bodies);
    // tests of A that stand at another C than the park position
    let tests = before.tests.iter().filter(|test| {
        test.axis == a && (test.test.positions[c].expect("C stands") - test.approach.park[c]).abs() > 0.5
    });
    let planted = tests.map(|test| {
        // a post on the cradle half-way round, where C carries the pivot's stand past it but A does not
        let half = machine.motion_sign(c) * 0.5 * (test.test.positions[c].expect("C stands") + test.approach.park[c]);
        let pivot = test.test.pivot.at;
        let turned = nalgebra::Rotation3::new(Vector3::z() * half) * Vector3::new(pivot.x, pivot.y, 0.0);
        let mut blocked = bodies.clone();
        let post = Solid::Cylinder { radius_mm: 3.0, half_mm: 30.0 };
        blocked.bodies.push(body("post", "A", post, [turned.x, turned.y, -38.0]));
        (test, blocked)
    });
    // the way meets the post, the sweep itself does not
    let on_the_way_alone = |(test, blocked): &(&PlannedTest, Bodies)| {
        let (least, pair) = sampled(&machine, blocked, test, &test.approach.corners());
        let from = test.approach.corners().pop().expect("start");
        let mut sweep = from.clone();
        sweep[a] = (test.sweep.to_deg + 4.0).to_radians();
        least <= 0.0 && pair.contains("post") && sampled(&machine, blocked, test, &[from, sweep]).0 > 5.0
    };
    let (_, blocked) = planted.into_iter().find(on_the_way_alone).expect("a way with a post on it");
    let after = planned_sweeps(&machine, &blocked);
    assert!(after.tests.iter().any(|test| test.axis == a));
    for test in &after.tests {
        let (least, pair) = sampled(&machine, &blocked, test, &test.approach.corners());
        assert!(least > 5.0 - 1e-6, "{}: {least} {pair}", test.test.name);
    }
}

/// A spindle over a bed with a wall between its two places.
fn wall(z_high: f64) -> (Machine, Bodies) {
    let text =
        format!("name: m\ncode: \"[wbXZt]\"\naxes:\n  X: {{range: [-200, 200]}}\n  Z: {{range: [0, {z_high}]}}\n");
    let machine = machine_from_yaml(Path::new("m"), text).expect("valid");
    let bodies = vec![
        body("tool", "Z", Solid::Cylinder { radius_mm: 10.0, half_mm: 40.0 }, [0.0, 0.0, 40.0]),
        body("wall", "b", Solid::Box { half_mm: Vector3::new(0.5, 100.0, 50.0) }, [30.0, 0.0, 0.0]),
    ];
    (machine, Bodies { bodies, ..Bodies::default() })
}

#[test]
fn a_way_goes_over_a_wall_or_names_it() {
    for (z_high, over) in [(150.0, true), (52.0, false)] {
        let (machine, bodies) = wall(z_high);
        let world = World::new(&Chain::of(&machine), &bodies).expect("links");
        let scene = world.scene();
        let mut scratch = Scratch::default();
        let asides = [vec![], vec![(0, -199.0)], vec![(1, z_high)]];
        let found = clear_way(&scene, &[-100.0, 0.0], &[100.0, 0.0], &asides, 5.0, &mut scratch);
        if over {
            let wanted = [(1, 150.0), (0, 100.0), (1, 0.0)].map(|(axis, to)| Leg { axis, to });
            assert_eq!(found.expect("over the wall"), wanted);
        } else {
            let no_way = found.expect_err("the wall is higher than Z reaches");
            assert_eq!(no_way.hit.pair, ("tool".into(), "wall".into()));
            assert_eq!((no_way.axis, no_way.tried), (0, 3));
        }
    }
}

#[test]
fn a_plan_without_any_way_to_a_start_says_so() {
    let (machine, mut bodies) = load("hermle-c600u.yaml");
    // the head passes below the lid, but at zero and above it is too near: nowhere to park
    let lid = Solid::Box { half_mm: Vector3::new(600.0, 400.0, 10.0) };
    bodies.bodies.push(body("lid", "b", lid, [0.0, 0.0, 662.0]));
    // beam and slide run in slots of it
    bodies.touching.extend(["gantry beam", "slide X"].map(|name| (name.into(), "lid".into())));
    let plan = plan_of(&machine, &bodies, &Settings::default());
    assert!(plan.tests.is_empty());
    for error in plan.errors.iter().filter(|error| error.name.ends_with('C')) {
        let reason = &error.reason;
        assert!(reason.contains("no way from a park position to its start is: most often head – lid"), "{reason}");
    }
}

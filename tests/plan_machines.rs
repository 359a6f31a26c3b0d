//! Plans of all shipped machines: checked again by brute force, the thesis's methods, forecasts against Monte Carlo.

use crate::planned::plan_of;
use crate::shipped;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fiveaxis::bodies::{Bodies, Kit};
use fiveaxis::chain::{Chain, Composition, Geometry, LinkId, Pose};
use fiveaxis::collision::{Instrument, World, parry_shape};
use fiveaxis::load::{load_machine_and_bodies, load_session, standard_kit};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::{Coordinates, Curves, Step, steps};
use fiveaxis::plan::{Coupled, Method, Plan, PlannedTest, Settings, Uncertainty, beyond_path, plan};
use fiveaxis::session::{Follow, Motion, Path as TestPath, Session, Spread, Test};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use shipped::{machine_files, some_machines};

fn load(name: &str) -> (Machine, Bodies, Kit) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    (machine, bodies, standard_kit().expect("kit"))
}

/// Positions along a path as a session's motion gives them, from and to other angles, deg, in steps of about `step`.
fn along(machine: &Machine, test: &Test, (from, to): (f64, f64), step_deg: f64) -> Vec<Vec<f64>> {
    let mut path = test.path.as_ref().expect("planned").between(from, to);
    let (TestPath::Sweep { step, .. } | TestPath::Circle { step, .. }) = &mut path;
    *step = step_deg;
    let test = Test { path: Some(path), ..test.clone() };
    let session = session(machine, Vec::new());
    let motion = Motion::of(&session, &Chain::of(machine), &test).expect("motion");
    (0..motion.rows()).map(|row| motion.row(row).to_vec()).collect()
}

fn session(machine: &Machine, tests: Vec<Test>) -> Session {
    let machine = machine.clone();
    Session { name: "plan".into(), machine_file: String::new(), machine, spread: Spread::default(), tests }
}

/// The whole run at 0.05°, run-in and run-out included: it begins and ends where the run of the plan does.
fn fine_rows(machine: &Machine, planned: &PlannedTest) -> Vec<Vec<f64>> {
    let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
    let motion = Motion::of(&session(machine, Vec::new()), &Chain::of(machine), &planned.test).expect("motion");
    let [before, after] = beyond_path(machine, &planned.test, &motion).expect("a run");
    let rows = along(machine, &planned.test, (from - before, to + after), 0.05);
    for (run, row) in [(planned.run.first(), rows.first()), (planned.run.last(), rows.last())] {
        let (run, row) = (run.expect("run"), row.expect("row"));
        let off = run.iter().zip(row).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{}: {run:?} {row:?}", planned.test.name);
    }
    rows
}

/// Least distance over a sweep with run-in at 0.05° steps: every pair with parry, poses from the chain's own geometry.
fn brute_force(machine: &Machine, bodies: &Bodies, kit: &Kit, planned: &PlannedTest) -> f64 {
    let chain = Chain::of(machine);
    let world = World::new(&chain, bodies).expect("links");
    let instrument = Instrument::of(&world, machine, bodies, kit, &planned.test).expect("instrument");
    let scene = instrument.scene(&world);
    let geometry = Geometry::nominal(&chain);
    let workpiece = chain.branch(fiveaxis::chain::Branch::Workpiece).len();
    let link = |frame: usize| match frame {
        f if f <= workpiece => LinkId { branch: fiveaxis::chain::Branch::Workpiece, depth: f },
        f => LinkId { branch: fiveaxis::chain::Branch::Tool, depth: f - workpiece },
    };
    let still: Vec<_> =
        scene.parts().iter().map(|part| parry_shape(&part.convex, &Pose::identity()).expect("shape")).collect();
    let radius: Vec<f64> = scene.parts().iter().map(|part| part.convex.reach_mm()).collect();
    let (pivot, spindle) = planned.test.links(&chain).expect("links");
    let mut least = f64::MAX;
    for q in &fine_rows(machine, planned) {
        let mut frames: Vec<Pose> = (0..=chain.axis_count()).map(|f| geometry.pose(link(f), q, None)).collect();
        let at = geometry.point(pivot, &planned.test.pivot.at, q, None);
        let way = geometry.point(spindle, &planned.test.spindle_ball.at, q, None) - at;
        frames.push(Pose { rotation: fiveaxis::bodies::frame_along(&way.normalize()), translation_mm: at });
        let centre = |part: usize| {
            let part = &scene.parts()[part];
            frames[part.frame].point(&part.convex.centre)
        };
        for &(one, other) in scene.pairs() {
            if (centre(one) - centre(other)).norm() - radius[one] - radius[other] > least {
                continue;
            }
            let place = |part: usize| {
                let link = &frames[scene.parts()[part].frame];
                let columns: Vec<parry3d::math::Vector> = (0..3)
                    .map(|k| {
                        let c = link.rotation.column(k);
                        parry3d::math::Vector::new(c.x, c.y, c.z)
                    })
                    .collect();
                let matrix = parry3d::math::Matrix::from_cols(columns[0], columns[1], columns[2]);
                let t = link.translation_mm;
                parry3d::math::Pose::from_parts(
                    parry3d::math::Vector::new(t.x, t.y, t.z),
                    parry3d::math::Rotation::from_mat3(&matrix).normalize(),
                ) * still[part].1
            };
            let found = parry3d::query::distance(&place(one), &*still[one].0.0, &place(other), &*still[other].0.0);
            least = least.min(found.expect("supported").distance);
        }
    }
    least
}

fn settings(method: Option<Method>) -> Settings {
    Settings { method, ..Settings::default() }
}

#[test]
fn every_shipped_machine_gets_a_plan_that_brute_force_finds_clear() {
    check_plans(some_machines(0, 5), &settings(None));
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn plans_with_circles_are_clear_by_brute_force_too() {
    let coupled = Coupled { follow: Vec::new(), circles: true };
    let plans = check_plans(some_machines(1, 6), &Settings { coupled, ..Settings::default() });
    for (file, machine, plan) in &plans {
        let planes: std::collections::BTreeSet<String> = plan
            .tests
            .iter()
            .filter_map(|test| match &test.test.path {
                Some(TestPath::Circle { plane, .. }) => {
                    Some([plane.first, plane.second].map(|axis| machine.axes[axis].name.as_str()).concat())
                }
                _ => None,
            })
            .collect();
        assert_eq!(planes.len(), 3, "{}: {planes:?}", file.display());
        assert!(plan.errors.iter().any(|error| error.name == "EC0Y" && error.determined), "{}", file.display());
    }
}

fn check_plans(files: Vec<PathBuf>, settings: &Settings) -> Vec<(PathBuf, Machine, Arc<Plan>)> {
    let kit = standard_kit().expect("kit");
    let planned: Vec<(PathBuf, Machine, Bodies, Arc<Plan>)> = files
        .into_par_iter()
        .map(|file| {
            let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
            let plan = plan_of(&machine, &bodies, settings);
            (file, machine, bodies, plan)
        })
        .collect();
    for (file, machine, bodies, plan) in &planned {
        assert!(!plan.tests.is_empty(), "{}: no test", file.display());
        for error in &plan.errors {
            assert!(error.determined || !error.reason.is_empty(), "{}: {} without reason", file.display(), error.name);
        }
        plan.tests.par_iter().for_each(|test| {
            let least = brute_force(machine, bodies, &kit, test);
            // the rows that were certified are those that a session's motion gives
            let rows = along(machine, &test.test, (test.sweep.from_deg, test.sweep.to_deg), 0.5);
            if test.is_coupled() {
                assert_eq!(test.run.len(), rows.len() + 2);
                for (run, row) in test.run[1..].iter().zip(&rows) {
                    let off = run.iter().zip(row).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-6, "{} {}: {off}", file.display(), test.test.name);
                }
            }
            // the margin is 5 mm; what is reported is right to 0.05 mm
            assert!(least > 5.0 - 1e-6, "{} {}: {least}", file.display(), test.test.name);
            let claimed = test.sweep.clearance_mm;
            assert!((least - claimed).abs() < 0.05, "{} {}: {least} {claimed}", file.display(), test.test.name);
        });
        let rotary = |k: usize| machine.axes[k].kind == AxisKind::Rotary;
        let table_table = (0..machine.axes.len()).filter(|&k| rotary(k)).all(|k| k < machine.code.workpiece_side.len());
        if table_table {
            assert!(plan.errors.iter().all(|error| error.determined), "{}", file.display());
        }
        println!(
            "{}: {} tests, {} with several axes, {} determined",
            file.display(),
            plan.tests.len(),
            plan.tests.iter().filter(|test| test.is_coupled()).count(),
            plan.errors.iter().filter(|e| e.determined).count()
        );
    }
    planned.into_iter().map(|(file, machine, _, plan)| (file, machine, plan)).collect()
}

#[test]
fn chapter_5_on_the_c600u_gives_the_thesis_setups() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let plan = plan_of(&machine, &bodies, &settings(Some(Method::Chapter5)));
    assert_eq!(plan.tests.len(), 4);
    assert_eq!(plan.pivot_setups, 1);
    let a = machine.axis_index("A").expect("A");
    let d = 50.0 * 5f64.sqrt();
    for test in &plan.tests {
        assert!((test.rho_mm - 100.0).abs() < 1e-6, "R {}", test.rho_mm);
        match test.test.bar_length_mm.expect("bar") {
            100.0 => assert!(test.h_mm.abs() < 1e-6),
            150.0 => assert!((test.h_mm.abs() - d).abs() < 1e-6, "D {}", test.h_mm),
            other => panic!("bar {other}"),
        }
        if test.axis == a {
            // the thesis ran A from -20 to 70, counted as the table moves
            assert!(test.sweep.to_deg >= 10.0 && test.sweep.to_deg <= 30.0, "{}", test.sweep.to_deg);
            assert!(test.sweep.from_deg <= -60.0 && test.sweep.from_deg >= -85.0, "{}", test.sweep.from_deg);
        } else {
            assert_eq!((test.sweep.from_deg, test.sweep.to_deg), (-180.0, 180.0));
        }
    }
    assert!(plan.errors.iter().all(|error| error.determined));
    // a wider spindle housing ends the sweep earlier: the range is the bodies', not a constant
    let mut wider = bodies.clone();
    for body in wider.bodies.iter_mut().filter(|body| body.name == "spindle housing") {
        body.solids = vec![fiveaxis::bodies::Solid::Cylinder { radius_mm: 110.0, half_mm: 70.0 }];
    }
    let other = fiveaxis::plan::plan(&machine, &wider, &kit, &settings(Some(Method::Chapter5))).expect("fits");
    let end = |plan: &Plan| plan.tests.iter().filter(|t| t.axis == a).map(|t| t.sweep.from_deg).fold(0.0, f64::min);
    assert!(end(&other) > end(&plan), "{} {}", end(&other), end(&plan));
}

#[test]
fn chapters_4_6_and_7_come_out_of_the_same_solver() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let four = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter4))).expect("fits");
    assert_eq!(four.tests.len(), 4);
    let six = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter6))).expect("fits");
    assert!(six.tests.iter().all(|test| test.h_mm.abs() < 1e-6 && test.test.bar_length_mm == Some(100.0)));
    for name in ["head-head-ca-moving-table.yaml", "fig-1-1-table-head-ca.yaml"] {
        let (machine, bodies, kit) = load(name);
        let seven = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter7))).expect(name);
        for test in &seven.tests {
            let (bar, rho) = (test.test.bar_length_mm.expect("bar"), test.rho_mm);
            assert!(
                (test.h_mm.abs() - (bar * bar - rho * rho).max(0.0).sqrt()).abs() < 1e-6,
                "{name} H_l {}",
                test.h_mm
            );
        }
        assert!(seven.tests.iter().any(|test| test.h_mm.abs() > 10.0), "{name}");
    }
}

#[test]
fn limits_that_leave_no_setup_are_named_with_the_amount() {
    let (mut machine, bodies, kit) = load("hermle-c600u.yaml");
    let z = machine.axis_index("Z").expect("Z");
    machine.axes[z].range = Some((300.0, 330.0));
    // with Z following there are setups even so
    let settings = Settings { coupled: Coupled::default(), ..Settings::default() };
    let plan = plan(&machine, &bodies, &kit, &settings).expect("plan");
    let reason = &plan.errors.iter().find(|error| error.name == "EY0A").expect("EY0A").reason;
    assert!(reason.contains("needs Z = ") && reason.contains("mm beyond its range"), "{reason}");
    // the amount: with the range up to there and a hair more, that setup is reachable; with a hair less it is not
    let after = |text: &str| -> f64 {
        let rest = reason.split(text).nth(1).expect("number");
        rest.split(" mm").next().and_then(|number| number.parse().ok()).expect("number")
    };
    let (at, beyond) = (after("needs Z = "), after(" mm, "));
    assert!((300.0 - at - beyond).abs() < 0.11, "{at} {beyond}");
    for (more, reachable) in [(0.1, true), (-0.1, false)] {
        machine.axes[z].range = Some((at - more, 330.0));
        let all = fiveaxis::plan::candidates(&machine, &bodies, &kit, &Vec::new(), &Coupled::default());
        let a = machine.axis_index("A").expect("A");
        assert_eq!(all.list.iter().any(|candidate| candidate.axis == a), reachable, "{at} {more}");
    }
}

#[test]
fn programs_run_the_planned_arc_both_ways_at_the_ball_feed() {
    let (machine, bodies, _) = load("hermle-c600u.yaml");
    let plan = plan_of(&machine, &bodies, &settings(Some(Method::Chapter5)));
    for planned in &plan.tests {
        let sweeps = steps(&machine, planned, &Coordinates::of(&machine), Curves::Carrying);
        let runs: Vec<(f64, f64)> = sweeps
            .windows(3)
            .filter_map(|three| match three {
                [Step::Dwell(_), Step::Feed { to, per_minute, .. }, Step::Dwell(_)] => Some((*to, *per_minute)),
                _ => None,
            })
            .collect();
        let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
        let ends: Vec<f64> = runs.iter().map(|run| run.0).collect();
        // run-in, arc and run-out are one block; the way there ends where the first begins
        let wanted = [to + 4.0, from - 4.0];
        assert_eq!(ends.len(), wanted.len());
        assert!(ends.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{ends:?} {wanted:?}");
        // 500 mm/min at 100 mm
        assert!((runs[1].1 - 5f64.to_degrees()).abs() < 1e-9);
    }
}

#[test]
fn forecasts_agree_with_a_thousand_simulated_sessions() {
    let (machine, bodies, _) = load("hermle-c600u.yaml");
    let five = plan_of(&machine, &bodies, &settings(Some(Method::Chapter5)));
    check_forecasts(&machine, &five);
    let free = plan_of(&machine, &bodies, &settings(None));
    let kinds = |wanted: Follow| {
        let is_it =
            |test: &&PlannedTest| matches!(test.test.path, Some(TestPath::Sweep { follow, .. }) if follow == wanted);
        free.tests.iter().filter(is_it).count()
    };
    assert!(kinds(Follow::Axial) > 0 && kinds(Follow::Tangential) > 0, "the plan has following tests");
    check_forecasts(&machine, &free);
}

#[test]
fn forecasts_of_heads_agree_with_a_thousand_simulated_sessions() {
    for name in ["fig-1-1-table-head-ca.yaml", "fig-1-1-head-head-cb.yaml"] {
        let (machine, bodies, _) = load(name);
        let free = plan_of(&machine, &bodies, &settings(None));
        assert!(free.errors.iter().filter(|error| error.determined).count() >= 5, "{name}");
        check_forecasts(&machine, &free);
    }
}

/// Standard deviations seen in 1,000 sessions against those that a plan promises, of the errors that it determines: of the
/// others the wide prior is promised, from which nothing is drawn.
fn check_forecasts(machine: &Machine, plan: &Plan) {
    let u = Uncertainty::default();
    let chain = Chain::of(machine);
    // unknowns: location errors, pivots, spindle balls, bars, for each test the linear axes' misplacement and their scale
    let mut slots: Vec<(usize, usize, f64)> = Vec::new();
    for kind in [AxisKind::Rotary, AxisKind::Linear] {
        for (axis, entry) in machine.axes.iter().enumerate().filter(|(_, entry)| entry.kind == kind) {
            for component in entry.slots() {
                let sigma = match (kind, component.is_angle()) {
                    (AxisKind::Rotary, false) => u.wanted_mm,
                    (AxisKind::Rotary, true) => u.wanted_rad,
                    _ => machine.linear_axes.squareness_rad,
                };
                slots.push((axis, component.index(), sigma));
            }
        }
    }
    let wanted = 8;
    let (n_slots, tests) = (slots.len(), plan.tests.len());
    let linear: Vec<usize> = (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear).collect();
    // positions at the middles of equal parts of the arc
    let samples: Vec<Vec<Vec<f64>>> = plan
        .tests
        .iter()
        .map(|test| {
            let (from, to) = (test.sweep.from_deg, test.sweep.to_deg);
            let count = (2.0 * u.samples_per_turn * (to - from) / 360.0).round();
            let part = (to - from) / count;
            along(machine, &test.test, (from + 0.5 * part, to - 0.5 * part), part)
        })
        .collect();
    let middle = |test: usize, k: usize| samples[test].iter().map(|q| q[k]).sum::<f64>() / samples[test].len() as f64;
    let middles: Vec<Vec<f64>> = (0..tests).map(|test| linear.iter().map(|&k| middle(test, k)).collect()).collect();
    let moved: Vec<f64> = middles.iter().map(|middle| middle.iter().map(|q| q * q).sum::<f64>().sqrt()).collect();
    // tests that stand at one place, or swing about it, share what the axes are off there
    let stand_of: Vec<usize> = (0..tests)
        .map(|test| {
            let same = |other: &usize| middles[*other].iter().zip(&middles[test]).all(|(a, b)| (a - b).abs() < 1e-3);
            (0..test).find(same).unwrap_or(test)
        })
        .collect();
    let shared = |key: &dyn Fn(&Test) -> [i64; 3]| -> Vec<usize> {
        (0..tests)
            .map(|t| (0..=t).find(|&o| key(&plan.tests[o].test) == key(&plan.tests[t].test)).expect("itself"))
            .collect()
    };
    let place = |at: &Vector3<f64>| [at.x, at.y, at.z].map(|x| (x * 1e6).round() as i64);
    let pivot_of = shared(&|test| place(&test.pivot.at));
    let ball_of = shared(&|test| place(&test.spindle_ball.at));
    let bar_of = shared(&|test| [test.bar_length_mm.map_or(0, |bar| (bar * 1e6) as i64), 0, 0]);
    let per_test = 3 + 3 + 1 + 3 + linear.len();
    let size = n_slots + per_test * tests;
    let first = |test: usize, what: usize| n_slots + per_test * test + what;
    let one_test = |test: usize| -> Vec<f64> {
        let stand = (machine.linear_axes.positioning * moved[test]).max(1e-12);
        let mut one = [u.spread.pivot_mm; 3].to_vec();
        one.extend([u.spread.spindle_ball_mm; 3]);
        one.push(u.spread.bar_length_mm);
        one.extend([stand; 3]);
        one.extend(linear.iter().map(|_| machine.linear_axes.positioning));
        one
    };
    let prior: Vec<f64> = slots.iter().map(|slot| slot.2).chain((0..tests).flat_map(one_test)).collect();
    let lengths = |x: &DVector<f64>| -> Vec<f64> {
        let mut errors = vec![[0.0; 6]; machine.axes.len()];
        for (k, &(axis, component, _)) in slots.iter().enumerate() {
            errors[axis][component] = x[k];
        }
        let geometry = Geometry::new(&chain, &errors, Composition::Exact);
        let three = |at: usize| Vector3::new(x[at], x[at + 1], x[at + 2]);
        let mut all = Vec::new();
        for (index, planned) in plan.tests.iter().enumerate() {
            let (pivot, spindle) = planned.test.links(&chain).expect("links");
            let stand = stand_of[index];
            for sample in &samples[index] {
                let mut q = sample.clone();
                for (k, &axis) in linear.iter().enumerate() {
                    q[axis] += x[first(stand, 10 + k)] * (sample[axis] - middles[stand][k]);
                }
                let p = geometry.point(pivot, &(planned.test.pivot.at + three(first(pivot_of[index], 0))), &q, None);
                let ball = planned.test.spindle_ball.at + three(first(ball_of[index], 3));
                let s = geometry.point(spindle, &ball, &q, None) + three(first(stand, 7));
                all.push((p - s).norm() + x[first(bar_of[index], 6)]);
            }
        }
        all
    };
    let zero = DVector::zeros(size);
    let nominal = DVector::from_vec(lengths(&zero));
    let columns: Vec<DVector<f64>> = (0..size)
        .map(|k| {
            let step = prior[k].clamp(1e-9, 1e-5);
            let mut x = zero.clone();
            x[k] = step;
            let high = DVector::from_vec(lengths(&x));
            x[k] = -step;
            (high - DVector::from_vec(lengths(&x))) / (2.0 * step)
        })
        .collect();
    let jacobian = DMatrix::from_columns(&columns);
    let weights = DVector::from_iterator(size, prior.iter().map(|s| 1.0 / (s * s)));
    let normal = jacobian.transpose() * &jacobian / (u.noise_mm * u.noise_mm) + DMatrix::from_diagonal(&weights);
    let factor = normal.cholesky().expect("positive");
    let seed = 5;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let runs = 1000;
    let mut squares = vec![0.0; wanted];
    for _ in 0..runs {
        // location errors of ordinary size: the estimator is linear
        let truth = DVector::from_fn(size, |k, _| draw() * if k < wanted { prior[k] * 0.03 } else { prior[k] });
        let readings = DVector::from_vec(lengths(&truth)).map(|l| l + u.noise_mm * draw());
        let estimate = factor.solve(&(jacobian.transpose() * (readings - &nominal) / (u.noise_mm * u.noise_mm)));
        for k in 0..wanted {
            squares[k] += (estimate[k] - truth[k]).powi(2);
        }
    }
    for (k, error) in plan.errors.iter().enumerate().filter(|(_, error)| error.determined) {
        let seen = (squares[k] / f64::from(runs)).sqrt();
        let ratio = seen / error.sigma;
        println!("{}: predicted {:.3e} seen {seen:.3e} ratio {ratio:.3}", error.name, error.sigma);
        // 1,000 draws scatter a standard deviation by 2.2 %
        assert!((ratio - 1.0).abs() < 0.10, "{} ratio {ratio}", error.name);
    }
}

#[test]
fn the_session_file_of_a_plan_loads_and_is_clear() {
    let folder = tempfile::tempdir().expect("folder");
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    let run = |arguments: &[&str]| {
        assert_cmd::Command::cargo_bin("fiveaxis").expect("built").args(arguments).output().expect("runs")
    };
    let out = folder.path().to_str().expect("text");
    let machine = machine.to_str().expect("text");
    let first = run(&["plan", machine, "--method", "chapter5", "--json", "--out", out]);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let json: serde_json::Value = serde_json::from_slice(&first.stdout).expect("JSON alone");
    assert_eq!(json["tests"].as_array().map(Vec::len), Some(8));
    assert_eq!(json["location_errors"]["EY0A"]["determined"], true);
    let session = load_session(&folder.path().join("session.yaml")).expect("loads");
    assert_eq!(session.tests.len(), 8);
    let clear = run(&["clearance", folder.path().join("session.yaml").to_str().expect("text"), "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&clear.stdout).expect("JSON alone");
    for test in json["tests"].as_array().expect("tests") {
        assert!(test["clearance_mm"].as_f64().expect("number") > 4.9, "{test}");
    }
    for file in ["setup-sheet.html", "nc/linuxcnc/a-100-1.ngc", "nc/heidenhain/a-100-1.h", "nc/sinumerik/a-100-1.mpf"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
    for bad in [["plan", machine, "--avoid", "Q=1..2"], ["plan", machine, "--sigma", "4um,4um"]] {
        assert_eq!(run(&bad).status.code(), Some(2));
    }
}

#[test]
fn one_pivot_stands_a_bar_length_from_lines_that_do_not_meet() {
    let (machine, bodies, kit) = load("table-table-cb-moving-table.yaml");
    let planned = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter5))).expect("plan");
    assert_eq!((planned.tests.len(), planned.pivot_setups), (4, 1));
    // all axes at zero: the distance of the one pivot ball from both lines, from the machine file alone
    let pivot = Vector3::from(planned.tests[0].test.pivot.at);
    for axis in machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary) {
        let lever = (pivot - axis.origin).cross(&axis.direction).norm();
        assert!((lever - 100.0).abs() < 1e-5, "{} {lever}", axis.name);
    }
}

#[test]
fn methods_of_the_thesis_fit_axes_at_45_degrees() {
    for (name, methods) in [
        ("nutating-head-45.yaml", [Method::Chapter4, Method::Chapter5, Method::Chapter6, Method::Chapter7]),
        ("nutating-table-45.yaml", [Method::Chapter4, Method::Chapter5, Method::Chapter6, Method::Chapter7]),
    ] {
        let (machine, bodies, kit) = load(name);
        for method in methods {
            let planned = plan(&machine, &bodies, &kit, &settings(Some(method))).expect(name);
            assert_eq!(planned.tests.len(), 4, "{name} {method:?}");
            for test in planned.tests.iter().filter(|test| machine.axes[test.axis].name == "B") {
                let bar = test.test.bar_length_mm.expect("bar");
                // the distance of the carried ball from the inclined line, from the machine file alone
                let axis = &machine.axes[test.axis];
                let ball = if name.contains("head") { test.test.spindle_ball.at } else { test.test.pivot.at };
                let rho = (ball - axis.origin).cross(&axis.direction).norm();
                let at_zero = test.test.positions.iter().enumerate().all(|(k, q)| {
                    machine.axes[k].kind == AxisKind::Linear || name.contains("head") || q.unwrap_or(0.0) == 0.0
                });
                assert!(!at_zero || (rho - test.rho_mm).abs() < 1e-5, "{name} {method:?}: {rho} {}", test.rho_mm);
                assert!(test.h_mm != 0.0 || (test.rho_mm - bar).abs() < 1e-5, "{name} {method:?}");
                assert!(brute_force(&machine, &bodies, &kit, test) > 5.0 - 1e-6, "{name} {method:?}");
            }
        }
    }
}

#[test]
fn chapter_6_takes_the_two_places_that_tell_most() {
    let (machine, bodies, kit) = load("table-table-cb-moving-table.yaml");
    let six = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter6))).expect("fits");
    let b: Vec<&PlannedTest> = six.tests.iter().filter(|test| machine.axes[test.axis].name == "B").collect();
    assert_eq!(b.len(), 2);
    for test in &b {
        // 160 mm apart, B -15...95 is clear on both; as far apart as the table is wide, 45 deg are left
        assert!(test.sweep.to_deg - test.sweep.from_deg >= 80.0, "{:?}", test.sweep);
        assert!(brute_force(&machine, &bodies, &kit, test) > 5.0 - 1e-6);
    }
}

#[test]
fn chapter_7_takes_the_setups_that_tell_most() {
    let (machine, bodies, kit) = load("head-head-ca-overhead-gantry.yaml");
    let planned = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter7))).expect("fits");
    // beside the angle plate C turns by 48 and 116 deg, over the floor plate by a whole turn
    let c = machine.axis_index("C").expect("C");
    for test in planned.tests.iter().filter(|test| test.axis == c) {
        assert_eq!(test.sweep.to_deg - test.sweep.from_deg, 360.0, "{}: {:?}", test.mount, test.sweep);
        assert!(brute_force(&machine, &bodies, &kit, test) > 5.0 - 1e-6, "{}", test.test.name);
    }
}

#[test]
fn chapter_7_finds_the_lowest_stand_beside_a_head() {
    let (machine, bodies, kit) = load("table-head-ab-blade.yaml");
    // with the pivot of B's long bar 60 mm above the angle plate Y would have to be 5.8 mm beyond its limit
    for method in [Method::Chapter4, Method::Chapter7] {
        let planned = plan(&machine, &bodies, &kit, &settings(Some(method))).expect("fits");
        assert_eq!(planned.tests.len(), 4);
        for test in &planned.tests {
            assert!(brute_force(&machine, &bodies, &kit, test) > 5.0 - 1e-6, "{}", test.test.name);
        }
    }
}

#[test]
fn chapter_7_tests_the_outer_head_axis_before_the_inner_on_every_code_of_the_thesis() {
    let kit = standard_kit().expect("kit");
    let mut heads = 0;
    let name = |file: &Path| file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    for file in machine_files() {
        if !["table-1-1-", "fig-1-1-"].iter().any(|set| name(&file).starts_with(set)) {
            continue;
        }
        let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
        let rotary = |axis: &String| machine.axes[machine.axis_index(axis).unwrap()].kind == AxisKind::Rotary;
        let head: Vec<&String> = machine.code.tool_side.iter().filter(|axis| rotary(axis)).collect();
        if head.is_empty() {
            continue;
        }
        heads += 1;
        let planned = plan(&machine, &bodies, &kit, &settings(Some(Method::Chapter7))).expect("fits");
        let first = |axis: &str| planned.tests.iter().position(|test| machine.axes[test.axis].name == axis);
        let order: Vec<usize> = head.iter().map(|axis| first(axis).expect("each head axis is tested")).collect();
        assert!(order.is_sorted(), "{}: {head:?} in places {order:?}", name(&file));
        // short and long bar on each axis, eq. 7.1: the long one reaches along the axis by √(Re² − Rn²)
        assert_eq!(planned.tests.len(), 4, "{}", name(&file));
        for error in &planned.errors {
            assert!(error.determined || !error.reason.is_empty(), "{}: {}", name(&file), error.name);
        }
    }
    // six codes of Table 1.1 and two of Fig. 1.1 have a head
    assert_eq!(heads, 8);
}

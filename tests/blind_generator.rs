//! The blind trial's generator against the 60-digit oracle and against sessions made by another simulator.

use crate::examples::blind_trial::{
    designs, draw, effects, kinematics, machines, nuisance, plan, recordings, visibility,
};
use crate::shared_data;
use designs::{Manner, build};
use draw::Draw;
use kinematics::{AXES, Ball, Disturbance, Link, Location, Setup, V3, distance};
use nuisance::{ARCSEC, COMPONENTS};
use plan::Plan;
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

fn shared() -> Option<PathBuf> {
    shared_data::folder("recordings")?.parent().map(Path::to_path_buf)
}

/// The oracle's eight location errors of a case, or none for one it does not use.
fn oracle_case(name: &str) -> Option<Location> {
    let slots = [(0, 4), (0, 5), (0, 1), (0, 2), (1, 3), (1, 4), (1, 0), (1, 1)];
    let names = ["ty0a", "tz0a", "ey0a", "ez0a", "tx0c", "ty0c", "ex0c", "ey0c"];
    let deg = |d: f64| d.to_radians();
    let one = [deg(0.01), deg(0.01), 0.01, 0.01, deg(0.01), deg(0.01), 0.01, 0.01];
    let mixed = [deg(0.01), deg(-0.007), 0.010, -0.008, deg(0.006), deg(-0.009), 0.005, -0.004];
    let values: Vec<f64> = match name {
        "none" => vec![0.0; 8],
        "all" => one.to_vec(),
        "mixed" => mixed.to_vec(),
        "big" => mixed.iter().map(|v| v * 100.0).collect(),
        _ => {
            let k = names.iter().position(|n| *n == name)?;
            (0..8).map(|i| if i == k { one[i] } else { 0.0 }).collect()
        }
    };
    let mut location = [[0.0; 6]; AXES];
    for ((joint, c), v) in slots.into_iter().zip(values) {
        location[joint][c] = v;
    }
    Some(location)
}

#[test]
fn kinematics_agree_with_the_oracle() {
    let Some(shared) = shared() else { return };
    let machine = machines::plain("[wCAbYXZt]");
    let (a, c, z) = (machine.axis("A"), machine.axis("C"), machine.axis("Z"));
    let order = [a, c];
    let lever = 12500.0f64.sqrt();
    let text = std::fs::read_to_string(shared.join("reference/reference_traces.csv")).expect("reference traces");
    let (mut worst, mut rows) = (0.0f64, 0);
    for line in text.lines().skip(1) {
        let f: Vec<&str> = line.split(',').collect();
        let Some(of_two) = oracle_case(f[1]) else {
            continue;
        };
        let mut location = [[0.0; 6]; AXES];
        order.iter().enumerate().for_each(|(i, &j)| location[j] = of_two[i]);
        let (axis, at, s): (usize, V3, V3) = match f[0] {
            "A1" => (a, [0.0, 100.0, 0.0], [0.0; 3]),
            "A2" => (a, [0.0, 100.0, 0.0], [-lever, 0.0, 0.0]),
            "C1" => (c, [100.0, 0.0, 0.0], [0.0; 3]),
            _ => (c, [100.0, 0.0, 0.0], [0.0, 0.0, lever]),
        };
        let setup = Setup {
            pivot: Ball { link: Link::Axis(c), at },
            pivot_offset: [0.0; 3],
            ball: Ball { link: Link::Axis(z), at: s },
            ball_offset: [0.0; 3],
        };
        let mut q = [0.0; AXES];
        q[axis] = f[2].parse().expect("angle");
        let exact: f64 = f[4].parse().expect("length");
        let got = distance(&machine, &location, &setup, &q, &Disturbance::default());
        worst = worst.max((got - exact).abs());
        rows += 1;
    }
    println!("{rows} rows, worst {worst:.2e} mm");
    assert!(rows > 10_000);
    assert!(worst < 1e-9, "worst difference {worst:e} mm");
}

/// A published session: its plan rebuilt here, its true errors, its readings.
struct Published {
    plan: Plan,
    location: Location,
    read_mm: Vec<Vec<f64>>,
    /// Largest difference between its commanded positions and those of the plan, mm or deg.
    positions_off: f64,
    truth: Value,
}

fn published(shared: &Path, case: &str) -> Published {
    let root = shared.join("recordings/practice");
    let text = std::fs::read_to_string(root.join(format!("truth/{case}.json"))).expect("truth");
    let truth: Value = serde_json::from_str(&text).expect("truth is JSON");
    let machine = machines::plain(truth["code"].as_str().expect("code"));
    let design = truth["design"].as_str().expect("design");
    let mut plan = build(&machine, design, &Manner::usual(), &mut Draw::seeded(1, 1));
    let text = std::fs::read_to_string(root.join(case).join("session.yaml")).expect("session");
    let session: serde_yaml::Value = serde_yaml::from_str(&text).expect("session is YAML");
    let listed = session["tests"].as_sequence().expect("tests");
    let mut read_mm = vec![];
    let mut positions_off = 0.0f64;
    plan.tests.sort_by_key(|t| listed.iter().position(|l| l["name"].as_str() == Some(&t.name)));
    assert_eq!(plan.tests.len(), listed.len(), "{case}");
    for (i, entry) in listed.iter().enumerate() {
        let name = plan.tests[i].name.clone();
        assert_eq!(entry["name"].as_str(), Some(name.as_str()), "{case}");
        let text = std::fs::read_to_string(root.join(case).join(format!("{name}.csv"))).expect("recording");
        let header: Vec<&str> = text.lines().next().expect("header").split(',').collect();
        let rows: Vec<Vec<f64>> =
            text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().expect("number")).collect()).collect();
        let test = &mut plan.tests[i];
        test.started_at_s = entry["started_at"].as_f64().expect("start");
        test.rows = rows.len();
        // times are printed to 0.1 ms; recorders sample at a whole rate
        let rate_hz = (rows.len() - 1) as f64 / (rows[rows.len() - 1][0] - rows[0][0]);
        test.step_s = 1.0 / rate_hz.round();
        let test = plan.tests[i].clone();
        for (k, row) in rows.iter().enumerate() {
            let q = plan.axes_at(&test, k as f64 * test.step_s);
            for (name, x) in header.iter().zip(row) {
                if let Some(j) = machine.joints.iter().position(|j| name.starts_with(&format!("{}_", j.name))) {
                    positions_off = positions_off.max((q[j] - x).abs());
                }
            }
        }
        read_mm.push(rows.iter().map(|r| r[r.len() - 1]).collect());
    }
    let location = seal_in(&mut plan, &truth);
    Published { plan, location, read_mm, positions_off, truth }
}

/// Puts the true placement errors into the plan and returns the location errors.
fn seal_in(plan: &mut Plan, truth: &Value) -> Location {
    let mut location = [[0.0; 6]; AXES];
    for (slot, value) in truth["pige"].as_object().expect("pige") {
        let j = plan.machine.axis(&slot[3..]);
        let c = COMPONENTS.iter().position(|k| *k == &slot[..2]).expect("component");
        location[j][c] = value.as_f64().expect("value") * if c < 3 { 1e-3 } else { ARCSEC };
    }
    let machine = plan.machine.clone();
    for (seats, key) in [(&mut plan.pivots, "pivots"), (&mut plan.balls, "spindle_balls")] {
        for seat in seats.iter_mut() {
            let Link::Axis(on) = seat.ball.link else {
                continue;
            };
            let same = |p: &&Value| {
                p["on"].as_str() == Some(&machine.joints[on].name)
                    && (0..3).all(|i| (p["at"][i].as_f64().unwrap_or(f64::NAN) - seat.ball.at[i]).abs() < 1e-6)
            };
            let found = truth[key].as_array().expect("seats").iter().find(same).expect("seat");
            seat.offset_mm = [0, 1, 2].map(|i| found["error_um"][i].as_f64().expect("error") * 1e-3);
        }
    }
    let bars: HashMap<i64, f64> = truth["bars"]
        .as_array()
        .expect("bars")
        .iter()
        .map(|b| (b["nominal"].as_f64().expect("mm").round() as i64, b["reading_error_um"].as_f64().expect("um")))
        .collect();
    for bar in &mut plan.bars {
        bar.reading_error_mm = bars[&(bar.nominal_mm.round() as i64)] * 1e-3;
    }
    location
}

impl Published {
    fn residual_um(&self, rows: &[Vec<Disturbance>]) -> f64 {
        let mut exact = recordings::lengths(&self.plan, &self.location, rows);
        for (e, r) in exact.iter_mut().zip(&self.read_mm) {
            e.iter_mut().zip(r).for_each(|(e, r)| *e -= r);
        }
        visibility::rms(&exact) * 1e3
    }
}

/// Every practice session, its concealed effect left out: what stays is that effect and the noise, and no more.
#[test]
fn published_sessions_are_reproduced_to_their_noise() {
    let Some(shared) = shared() else { return };
    let mut wrong = vec![];
    for k in 1..=12 {
        let case = format!("case-{k:03}");
        let p = published(&shared, &case);
        let number = |key: &str| p.truth[key].as_f64().expect("number");
        let (noise_um, effect_um) = (number("noise_rms_um"), number("total_rms_um"));
        let residual_um = p.residual_um(&effects::still(&p.plan));
        let expected_um = noise_um.hypot(effect_um);
        let rank = visibility::Absorbed::of(&p.plan).rank();
        println!(
            "{case}: residual {residual_um:.4}, expected {expected_um:.4} µm, rank {rank}, positions {:.1e}",
            p.positions_off
        );
        check(&mut wrong, p.positions_off < 2e-5, &case, "positions");
        // noise and effect are not quite uncorrelated in one session
        check(&mut wrong, (residual_um - expected_um).abs() < 0.1 * expected_um, &case, "residual");
        if effect_um == 0.0 {
            check(&mut wrong, (residual_um - noise_um).abs() < 0.001, &case, "residual of a clean session");
        }
        check(&mut wrong, p.truth["explained_rank"].as_u64() == Some(rank as u64), &case, "rank");
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The generator's own laws at the published sizes take most of a published effect away.
#[test]
fn laws_account_for_published_effects() {
    let Some(shared) = shared() else { return };
    let mut wrong = vec![];
    for (case, left_at_most) in [
        ("case-001", 1.1),
        ("case-006", 1.1),
        ("case-007", 1.1),
        ("case-008", 1.3),
        ("case-009", 1.12),
        ("case-004", 1.1),
        ("case-012", 1.3),
    ] {
        let p = published(&shared, case);
        let noise_um = p.truth["noise_rms_um"].as_f64().expect("noise");
        let mut rows = effects::still(&p.plan);
        for effect in p.truth["effects"].as_array().expect("effects") {
            let size = effect["size"].as_f64().expect("size");
            law(&p.plan, effect).disturb(&p.plan, size, &mut rows);
        }
        let before_um = p.residual_um(&effects::still(&p.plan));
        let after_um = p.residual_um(&rows);
        println!("{case}: {before_um:.3} → {after_um:.3} µm, noise {noise_um} µm");
        check(&mut wrong, after_um < left_at_most * noise_um, case, "what is left");
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Notes what does not hold and goes on, so that one run shows every session.
fn check(wrong: &mut Vec<String>, holds: bool, case: &str, what: &str) {
    if !holds {
        wrong.push(format!("{case}: {what}"));
    }
}

/// The generator's law for a published effect with its published parameters.
fn law(plan: &Plan, effect: &Value) -> Box<dyn effects::Law> {
    let place = effect["place"].as_str().expect("place");
    let axis = plan.machine.axis(place);
    let p = &effect["params"];
    let number = |key: &str| p[key].as_f64().unwrap_or_else(|| panic!("{key} of {effect}"));
    let id = effect["id"].as_str().expect("id");
    match id {
        "rotary-backlash" | "linear-backlash" => Box::new(effects::backlash::Play {
            axis,
            take_up: number("take_up"),
            windup: number("windup_share"),
            load: number("gravity_bias"),
            to_own: if id == "rotary-backlash" { 1.0 / 3600.0 } else { 1e-3 },
        }),
        "squareness" => Box::new(effects::shapes::Lean { axis, aside: [-number("sign"), 0.0, 0.0] }),
        "guideway-wear" => Box::new(effects::shapes::Wear {
            axis,
            across: [0.0, 0.0, 1.0],
            about: [0.0; 3],
            bow: false,
            centre_mm: number("centre_mm"),
            width_mm: number("width_mm"),
            skew: number("skew"),
            slope_share: 0.0,
            sign: number("sign"),
        }),
        "pivot-slip" => Box::new(effects::slips::Slip {
            of_pivot: true,
            seat: 0,
            at_s: effect["range"]["time_s"][0].as_f64().expect("time"),
            direction: [0, 1, 2].map(|i| p["direction"][i].as_f64().expect("direction")),
            creep: number("creep_share"),
            creep_tau_s: 30.0,
        }),
        "linear-reversal-spike" => Box::new(effects::spikes::Reversal {
            axis,
            presliding_mm: number("presliding_mm"),
            servo_hz: number("servo_hz"),
            damping: number("servo_damping"),
        }),
        "unknown-clamp" => Box::new(effects::strangers::Clamp {
            axis,
            lift: [0.0, 0.0, 1.0],
            tilt: [1.0, 0.0, 0.0],
            tilt_rad_per_mm: number("tilt_arcsec_per_um") * ARCSEC * 1e3,
            from_deg: effect["range"]["deg"][0].as_f64().expect("angle"),
            to_deg: effect["range"]["deg"][1].as_f64().expect("angle"),
            hysteresis_deg: number("hysteresis_deg"),
            rise_s: number("lift_time_s"),
        }),
        _ => panic!("no law for {id}"),
    }
}

/// The library's `simulate` on machines and sessions of every family drawn here, with true errors in the files.
#[test]
fn simulate_agrees_with_the_generator() {
    let mut worst = 0.0f64;
    let mut rows = 0;
    for seed in 0..24 {
        let rng = &mut Draw::seeded(seed, 3);
        let machine = machines::draw(rng);
        let manner = Manner { density: 0.08, ..Manner::draw(rng) };
        let design = *rng.pick(&["bidirectional", "synchronous", "planar", "mixed"]);
        let mut plan = build(&machine, design, &manner, rng);
        // places as the file will print them
        for seat in plan.pivots.iter_mut().chain(plan.balls.iter_mut()) {
            seat.ball.at = seat.ball.at.map(|x| ((x + 0.03 * rng.normal()) * 1e6).round() / 1e6);
        }
        let mut location = nuisance::draw_location(&machine, rng);
        for (axis, slot) in [("Y", 5), ("Z", 4), ("Z", 3)] {
            location[machine.axis(axis)][slot] = 20.0 * ARCSEC * rng.normal();
        }
        let folder = tempfile::tempdir().expect("a scratch folder");
        let dummies = plan.tests.iter().map(|t| vec![Some(plan.bars[t.bar].calibrated_mm); t.rows]).collect();
        let mut made = recordings::recordings(&plan, dummies, || 0.0);
        round(&mut made);
        let order: Vec<usize> = (0..plan.tests.len()).collect();
        recordings::write(folder.path(), "exact", &plan, &order, &made).expect("session written");
        let with_errors = machine_with_errors(&machine, &location);
        std::fs::write(folder.path().join("machine.yaml"), with_errors).expect("machine written");
        let out = folder.path().join("out");
        let run = assert_cmd::Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
            .args([
                "simulate".as_ref(),
                folder.path().join("session.yaml").as_os_str(),
                "--out".as_ref(),
                out.as_os_str(),
            ])
            .output()
            .expect("simulate runs");
        assert!(run.status.success(), "seed {seed}: {}", String::from_utf8_lossy(&run.stderr));
        for (test, recording) in plan.tests.iter().zip(&made) {
            let text = std::fs::read_to_string(out.join(format!("{}.csv", test.name))).expect("simulated recording");
            let setup = visibility::setup(&plan, test);
            for (row, line) in text.lines().skip(1).enumerate() {
                let simulated: f64 = line.split(',').next_back().expect("length").parse().expect("number");
                let q = recording.axes(row);
                let here = distance(&machine, &location, &setup, &q, &Disturbance::default());
                worst = worst.max((simulated - here).abs());
                rows += 1;
            }
        }
        assert!(worst < 2e-9, "seed {seed} {} {design}: {worst:e} mm apart", machine.code);
    }
    println!("{rows} rows on 24 machines, worst {worst:.2e} mm");
    assert!(rows > 10_000);
}

/// Positions to the digits that files hold.
fn round(made: &mut [recordings::Recording]) {
    for recording in made {
        recording.columns.iter_mut().flat_map(|c| &mut c.1).for_each(|x| *x = (*x * 1e5).round() / 1e5);
        recording.standing.iter_mut().for_each(|s| s.1 = (s.1 * 1e6).round() / 1e6);
    }
}

fn machine_with_errors(machine: &kinematics::Machine, location: &Location) -> String {
    let mut text = recordings::machine_yaml(machine);
    for (j, joint) in machine.joints.iter().enumerate() {
        let errors: Vec<String> = (0..6)
            .filter(|&c| location[j][c] != 0.0)
            .map(|c| {
                let (value, unit) =
                    if c < 3 { (location[j][c] * 1e3, "um") } else { (location[j][c] / ARCSEC, "arcsec") };
                format!("{}0{}: {value:.12} {unit}", COMPONENTS[c], joint.name)
            })
            .collect();
        if !errors.is_empty() {
            let line = format!("  {}: {{", joint.name);
            text = text.replace(&line, &format!("{line}errors: {{{}}}, ", errors.join(", ")));
        }
    }
    text
}

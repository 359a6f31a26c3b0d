//! What a plan says where something limits it: the limit that does, by how much, and what to do; options that do not go together.

use std::path::Path;

use assert_cmd::Command;
use fiveaxis::bodies::{Bodies, Kit, Mount};
use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{Coupled, Goal, Method, Plan, PlannedTest, Settings, candidates, plan, plan_with_advice};

fn load(name: &str) -> (Machine, Bodies, Kit) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    (machine, bodies, standard_kit().expect("kit"))
}

fn undetermined(plan: &Plan) -> Vec<&str> {
    plan.errors.iter().filter(|error| !error.determined).map(|error| error.reason.as_str()).collect()
}

/// A number that follows a text.
fn number_after(reason: &str, text: &str) -> f64 {
    let rest = reason.split(text).nth(1).unwrap_or_else(|| panic!("'{text}' in: {reason}"));
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '-').unwrap_or(rest.len());
    rest[..end].trim_end_matches('.').parse().unwrap_or_else(|_| panic!("number after '{text}' in: {reason}"))
}

#[test]
fn a_narrow_range_is_named_with_what_is_missing() {
    let (mut machine, bodies, kit) = load("hermle-c600u.yaml");
    let a = machine.axis_index("A").expect("A");
    machine.axes[a].range = Some((-2f64.to_radians(), 2f64.to_radians()));
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("plan");
    let reasons = undetermined(&found);
    assert!(reasons.len() >= 4, "{reasons:?}");
    for reason in reasons {
        assert!(reason.contains("the range of axis A, -2…2°, is "), "{reason}");
        assert!(!reason.contains("clear over") && !reason.contains("useful lever"), "{reason}");
        // the amount: that much more and a hair, and there are sweeps; a hair less, and there are none
        let missing = number_after(reason, "-2…2°, is ");
        for (more_deg, there) in [(0.06, true), (-0.06, false)] {
            let half = (2.0 + 0.5 * (missing + more_deg)).to_radians();
            machine.axes[a].range = Some((-half, half));
            let all = candidates(&machine, &bodies, &kit, &Vec::new(), &Coupled::default());
            assert_eq!(all.list.iter().any(|candidate| candidate.axis == a), there, "{missing} {more_deg}");
        }
    }
}

#[test]
fn an_avoided_region_is_named_and_kept_out_of() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let [a, z] = ["A", "Z"].map(|name| machine.axis_index(name).expect(name));
    for region in [(a, -120f64.to_radians(), 10f64.to_radians()), (z, -50.0, 325.0)] {
        let settings = Settings { avoid: vec![region], ..Settings::default() };
        let found = plan_with_advice(&machine, &bodies, &kit, &settings).expect("plan");
        let reasons = undetermined(&found);
        let option = format!("--avoid {}=", machine.axes[region.0].name);
        assert!(!reasons.is_empty());
        for reason in reasons {
            assert!(reason.starts_with("left out by ") && reason.contains(&option), "{reason}");
        }
        for planned in &found.tests {
            let stays_out = |q: &Vec<f64>| q[region.0] <= region.1 + 1e-9 || q[region.0] >= region.2 - 1e-9;
            assert!(planned.run.iter().all(stays_out), "{}", planned.test.name);
            assert_stays_out_on_its_ways(planned, region);
        }
    }
}

/// No leg from park to a run's start and back touches the open region.
fn assert_stays_out_on_its_ways(planned: &PlannedTest, (axis, from, to): (usize, f64, f64)) {
    let corners = planned.approach.corners();
    let off = 1e-5;
    for way in corners.windows(2).map(|pair| [pair[0][axis], pair[1][axis]]).chain([[corners[0][axis]; 2]]) {
        let (low, high) = (way[0].min(way[1]), way[0].max(way[1]));
        assert!(low >= to - off || high <= from + off, "{}: {low}..{high} in {from}..{to}", planned.test.name);
    }
}

#[test]
fn park_positions_and_ways_keep_out_of_avoided_regions_too() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let index = |name: &str| machine.axis_index(name).expect(name);
    let deg = f64::to_radians;
    // where the machine would park (Z 329), a strip on either side of which tests stand, and one near the middle of a slide
    let regions = [("Z", 300.0, 330.0), ("C", deg(-20.0), deg(20.0)), ("X", -60.0, -20.0)];
    let mut across = 0;
    for (name, from, to) in regions {
        let region = (index(name), from, to);
        let settings = Settings { avoid: vec![region], ..Settings::default() };
        let found = plan(&machine, &bodies, &kit, &settings).expect("plan");
        assert!(!found.tests.is_empty(), "{name}");
        found.tests.iter().for_each(|planned| assert_stays_out_on_its_ways(planned, region));
        // the one thing left is the operator's: from one park position to another, and then the plan says so
        let is_below = |planned: &PlannedTest| planned.approach.park[region.0] < 0.5 * (from + to);
        let below = found.tests.iter().filter(|planned| is_below(planned)).count();
        let is_across = below > 0 && below < found.tests.len();
        let said = found.advice.iter().any(|line| line.starts_with(&format!("{name} goes through ")));
        assert_eq!(said, is_across, "{name}: {:?}", found.advice);
        across += usize::from(is_across);
    }
    assert!(across > 0, "no plan stands on both sides of a region: choose another one to see the words");
}

#[test]
fn a_time_too_short_is_named_with_the_time_needed() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let within = |minutes: f64| {
        let goal = Goal { minutes: Some(minutes), ..Settings::default().goal };
        plan(&machine, &bodies, &kit, &Settings { goal, ..Settings::default() }).expect("plan")
    };
    for minutes in [5.0, 19.0] {
        let found = within(minutes);
        let reasons = undetermined(&found);
        assert!(!reasons.is_empty());
        // several errors need the same time
        let mut enough: Vec<f64> = Vec::new();
        for reason in reasons {
            assert!(reason.starts_with(&format!("not within {minutes} minutes")), "{reason}");
            // what was found, and no bound
            assert!(
                reason.contains("the shortest plan found") && reason.ends_with("shorter ones may exist"),
                "{reason}"
            );
            let needed = number_after(reason, "(--minutes ");
            if !enough.contains(&needed) {
                assert!(needed > minutes && undetermined(&within(needed)).is_empty(), "{reason}");
                enough.push(needed);
            }
        }
    }
}

#[test]
fn a_wide_margin_is_named_beside_the_pair() {
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let found = plan_with_advice(&machine, &bodies, &kit, &Settings { margin_mm: 60.0, ..Settings::default() });
    for reason in undetermined(&found.expect("plan")) {
        assert!(reason.starts_with("left out by --margin 60: with 5 mm"), "{reason}");
        assert!(reason.contains("stays 60 mm clear over a useful sweep: most often "), "{reason}");
        // how many were looked at, where that is not all
        assert!(
            reason.contains("no reachable setup tried of axis") || reason.contains(" setups looked at, of "),
            "{reason}"
        );
    }
}

#[test]
fn advice_on_squareness_gives_the_figures_that_the_plan_with_circles_has() {
    let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
    let goal = Goal { position_mm: 4e-3, orientation_rad: arcsec, minutes: None };
    let settings = Settings { goal, ..Settings::default() };
    let (machine, bodies, kit) = load("hermle-c600u.yaml");
    let found = plan_with_advice(&machine, &bodies, &kit, &settings).expect("plan");
    let limited: Vec<_> = found.errors.iter().filter(|error| error.by_linear_axes).collect();
    assert!(!limited.is_empty() && !found.goal_reached);
    assert!(limited.iter().all(|error| error.reason.contains("out of square")), "{limited:#?}");
    let [advice] = found.advice.as_slice() else { panic!("{:?}", found.advice) };
    assert!(advice.starts_with("with --circles in ") && advice.ends_with("all of them within the goal"), "{advice}");
    let coupled = Coupled { circles: true, ..settings.coupled.clone() };
    let with = plan(&machine, &bodies, &kit, &Settings { coupled, ..settings }).expect("plan");
    for error in limited {
        let told = number_after(&format!("{} ", advice.split(&error.name).nth(1).expect("named")), " to ");
        let sigma = with.errors.iter().find(|other| other.name == error.name).expect("same").sigma_relative / arcsec;
        assert!((told - sigma).abs() < 0.006 && sigma <= 1.001, "{advice}: {sigma}");
    }
}

#[test]
fn a_method_that_does_not_fit_says_what_is_missing() {
    let (machine, bodies, mut kit) = load("hermle-c600u.yaml");
    let refused = |machine: &Machine, bodies: &Bodies, kit: &Kit, settings: Settings| {
        plan(machine, bodies, kit, &settings).expect_err("refused").to_string()
    };
    let with = |method| Settings { method: Some(method), ..Settings::default() };
    // the pair in the way
    let crowded = Settings { margin_mm: 20.0, ..with(Method::Chapter5) };
    let why = refused(&machine, &bodies, &kit, crowded);
    assert!(why.contains("clear by 20 mm") && why.contains("most often bar – "), "{why}");
    // a table and a head that no pivot tried serves alike: what was tried is said, not that nothing can
    let (mill, mill_bodies, _) = load("table-head-cb-moving-table-y.yaml");
    let why = refused(&mill, &mill_bodies, &kit, with(Method::Chapter5));
    assert!(why.contains("pivot places tried") && why.contains("the lines of C and B alike"), "{why}");
    // a mount whose slots stand at no bar's length
    let (portal, portal_bodies, _) = load("table-table-ca-portal.yaml");
    let why = refused(&portal, &portal_bodies, &kit, with(Method::Chapter4));
    assert!(why.contains("a bar's length from the line of axis C") && why.contains("100, 150, 250"), "{why}");
    // the second bar
    kit.bar.extensions_mm.clear();
    for method in [Method::Chapter4, Method::Chapter5, Method::Chapter7] {
        let why = refused(&machine, &bodies, &kit, with(method));
        assert!(why.contains("a second bar longer than that is missing") && why.contains("makes 100 mm"), "{why}");
    }
    assert!(plan(&machine, &bodies, &kit, &with(Method::Chapter6)).is_ok(), "one bar is enough for chapter 6");
}

#[test]
fn options_that_mean_nothing_together_are_refused() {
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    for (arguments, says) in [
        (&["--method", "chapter5", "--minutes", "30"][..], "cannot be used with '--minutes"),
        (&["--sigma", "4um,4arcsec", "--minutes", "30"], "cannot be used with '--minutes"),
        (&["--method", "chapter5", "--circles"], "cannot be used with"),
        (&["--method", "chapter5", "--pivots", "1"], "cannot be used with"),
        (&["--method", "chapter5", "--follow", "axial"], "cannot be used with"),
        (&["--minutes", "-5"], "--minutes -5 is not between 1 and 10000 min"),
        (&["--minutes", "NaN"], "--minutes NaN is not between"),
        (&["--minutes", "1e300"], "--minutes 1e300 is not between"),
        (&["--margin", "-1"], "--margin -1 is not between 0 and 500 mm"),
        (&["--feed", "inf"], "--feed inf is not between"),
        (&["--sigma", "1e300um,1arcsec"], "--sigma 1e300um is not between"),
        (&["--sigma", "-4um,1arcsec"], "--sigma -4um is not between"),
        (&["--avoid", "A=-360..360"], "--avoid covers the whole range of A, -110…30°"),
        (&["--avoid", "X=-400..10", "--avoid", "X=5..400"], "--avoid covers the whole range of X, -300…300 mm"),
    ] {
        let run = Command::cargo_bin("fiveaxis").expect("built").arg("plan").arg(&machine).args(arguments).output();
        let run = run.expect("runs");
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.contains(says) && text.len() < 600 && run.stdout.is_empty(), "{arguments:?}: {text}");
    }
}

#[test]
fn balls_stand_on_slots_only_where_a_mount_has_slots() {
    let (machine, mut bodies, kit) = load("hermle-c600u.yaml");
    let offsets = |bodies: &Bodies| -> Vec<f64> {
        let all = candidates(&machine, bodies, &kit, &Vec::new(), &Coupled::default());
        let across = |site: &fiveaxis::plan::PivotSite| {
            let mount = &bodies.mounts[site.mount];
            (site.at - mount.middle).dot(&mount.normal.cross(&mount.along))
        };
        all.sites.iter().map(across).collect()
    };
    let off_slot = |offset: &&f64| (**offset / 63.0 - (**offset / 63.0).round()).abs() > 1e-6;
    assert!(offsets(&bodies).iter().any(|offset| off_slot(&offset)), "without slots balls stand anywhere");
    bodies.mounts.iter_mut().for_each(|mount| mount.slot_pitch_mm = Some(63.0));
    let on_slots = offsets(&bodies);
    assert!(on_slots.iter().any(|offset| offset.abs() > 1.0), "more than the middle slot is used");
    assert_eq!(on_slots.iter().find(off_slot), None);
    // and a plan keeps to them
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("plan");
    assert!(!found.tests.is_empty());
    for planned in &found.tests {
        let mount = bodies.mounts.iter().find(|mount| mount.name == planned.mount).expect("mount");
        let offset = (planned.test.pivot.at - mount.middle).dot(&mount.normal.cross(&mount.along));
        assert!(!off_slot(&&offset), "{}: {offset}", planned.test.name);
    }
}

#[test]
fn a_calibrator_certifies_the_longest_part_that_it_has() {
    let mut kit = standard_kit().expect("kit");
    let certified = |kit: &Kit, length_mm: f64| kit.calibrated_mm(&kit.parts_mm(length_mm).expect("made"));
    // 50, 100, 150 and 300 mm; 250 is 100 + 150, 450 is 100 + 50 + 300, 300 needs 100 + 50 + 150
    for (length_mm, of) in [(100.0, 100.0), (150.0, 150.0), (250.0, 100.0), (300.0, 300.0), (450.0, 150.0)] {
        assert_eq!(certified(&kit, length_mm), Some(of), "{length_mm}");
    }
    kit.calibrator_mm = vec![250.0];
    assert_eq!(certified(&kit, 250.0), Some(250.0));
    assert_eq!(certified(&kit, 100.0), None);
    // a plan states it for every test
    let (machine, bodies, _) = load("hermle-c600u.yaml");
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("plan");
    for planned in &found.tests {
        let bar_mm = planned.test.bar_length_mm.expect("planned");
        assert_eq!(planned.mounting.calibrator_mm, certified(&kit, bar_mm), "{}", planned.test.name);
    }
}

#[test]
fn what_no_length_shows_is_blamed_on_no_option() {
    let (machine, bodies, kit) = load("table-head-ab-blade.yaml");
    let with = |minutes: Option<f64>, margin_mm: f64| {
        let goal = Goal { minutes, ..Settings::default().goal };
        plan_with_advice(&machine, &bodies, &kit, &Settings { goal, margin_mm, ..Settings::default() }).expect("plan")
    };
    let plain = with(None, 5.0);
    let laws: Vec<&str> =
        plain.errors.iter().filter(|error| !error.determined).map(|error| error.name.as_str()).collect();
    // Z of the A axis against Z of the head, and X of the whole head
    assert_eq!(laws, ["EZ0A", "EX0B", "EZ0B"]);
    for (minutes, margin_mm) in [(Some(20.0), 5.0), (None, 40.0)] {
        let found = with(minutes, margin_mm);
        for error in found.errors.iter().filter(|error| !error.determined) {
            let is_law = error.reason.contains("changes no ball-bar length") || error.reason.contains("changes none");
            assert_eq!(
                is_law,
                laws.contains(&error.name.as_str()),
                "{minutes:?} {margin_mm} {}: {}",
                error.name,
                error.reason
            );
            assert!(!error.reason.contains("useful lever"), "{}", error.reason);
            let by_time = error.reason.starts_with("not within");
            assert!(is_law || margin_mm > 5.0 || by_time, "{minutes:?}: {}: {}", error.name, error.reason);
        }
    }
}

#[test]
fn a_surface_listed_twice_is_one() {
    let (machine, mut bodies, kit) = load("hermle-c600u.yaml");
    let once = candidates(&machine, &bodies, &kit, &Vec::new(), &Coupled::default());
    let mount = bodies.mounts[0].clone();
    bodies.mounts.extend((0..300).map(|k| Mount { name: format!("table top {k}"), ..mount.clone() }));
    let many = candidates(&machine, &bodies, &kit, &Vec::new(), &Coupled::default());
    assert_eq!((many.sites.len(), many.list.len()), (once.sites.len(), once.list.len()));
    // and a plan is made from them: none is refused for having no place of its own
    let settings = Settings { method: Some(Method::Chapter5), ..Settings::default() };
    let tests = |bodies: &Bodies| plan(&machine, bodies, &kit, &settings).expect("plan").tests;
    let [first, other] = [&load("hermle-c600u.yaml").1, &bodies].map(tests);
    assert!(!first.is_empty() && first == other);
    // one of another height is another one
    bodies.mounts.push(Mount { middle: mount.middle + mount.normal * 5.0, ..mount });
    let other = candidates(&machine, &bodies, &kit, &Vec::new(), &Coupled::default());
    assert!(other.sites.len() > once.sites.len());
}

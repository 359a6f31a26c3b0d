//! One concealed session: draws machine, design, causes and noise, and seals the truth; diagnoses nothing.

use super::designs::{DESIGNS, Manner, build};
use super::draw::Draw;
use super::effects::{Cause, KINDS, still};
use super::faults::{self, FAULTS, Fault};
use super::kinematics::{Disturbance, Location, Machine, distance};
use super::machines;
use super::noise;
use super::nuisance::{ARCSEC, draw_location, misplace, slot_name, slots};
use super::plan::Plan;
use super::recordings::{Recording, lengths, recordings};
use super::visibility::{Absorbed, rms, setup};
use serde_json::{Map, Value, json};

/// What the user fixed; everything else is drawn.
#[derive(Clone, Default)]
pub struct Wishes {
    pub effect: Option<String>,
    pub design: Option<String>,
    pub clean: bool,
    /// Multiplies the number of rows.
    pub density: Option<f64>,
    pub code: Option<String>,
}

/// A session ready to be written, with its truth apart.
pub struct Case {
    pub name: String,
    pub plan: Plan,
    /// Order of the tests in the file.
    pub order: Vec<usize>,
    pub recordings: Vec<Recording>,
    pub truth: Value,
}

/// What is concealed in a session.
enum Secret {
    Nothing,
    Fault,
    Causes { count: usize, catalogued: bool },
}

/// Bands of the rms of what is left of an effect's trace over the rms of the noise.
const LEVELS: &[(&str, f64, f64)] =
    &[("strong", 3.5, 10.0), ("medium", 1.5, 3.5), ("weak", 0.3, 1.5), ("faint", 0.1, 0.3), ("invisible", 0.0, 0.1)];

pub fn level(visible: f64) -> &'static str {
    LEVELS.iter().find(|l| visible >= l.1).map_or("invisible", |l| l.0)
}

/// A cause at a size with what it does to the readings.
struct Dosed {
    cause: Cause,
    size: f64,
    trace: Vec<Vec<f64>>,
    left: Vec<Vec<f64>>,
    wanted: &'static str,
}

pub fn make(seed: u64, index: u64, wishes: &Wishes) -> Case {
    let rng = &mut Draw::seeded(seed, index);
    let secret = draw_secret(rng, wishes);
    let machine = wishes.code.as_deref().map_or_else(|| machines::draw(rng), machines::plain);
    let weights: Vec<f64> = DESIGNS.iter().map(|d| d.1).collect();
    let drawn = DESIGNS[rng.weighted(&weights)].0;
    let design = wishes.design.clone().unwrap_or_else(|| drawn.to_string());
    let mut manner = Manner::draw(rng);
    manner.density *= wishes.density.unwrap_or(1.0);
    let mut plan = build(&machine, &design, &manner, rng);
    misplace(&mut plan, rng);
    let location = draw_location(&machine, rng);
    let noise = noise::draw(&plan, rng);
    let absorbed = Absorbed::of(&plan);
    let noise_rms_um = rms(&noise.rows_mm) * 1e3;
    let noise_left_um = rms(&absorbed.remainder(&noise.rows_mm)) * 1e3;
    let base = lengths(&plan, &location, &still(&plan));

    let mut fault = None;
    let mut dosed: Vec<Dosed> = vec![];
    match secret {
        Secret::Nothing => {}
        Secret::Fault => fault = draw_fault(rng, &plan, wishes),
        Secret::Causes { count, catalogued } => {
            while dosed.len() < count {
                let world = World { location: &location, absorbed: &absorbed, base: &base, noise_um: noise_rms_um };
                match draw_cause(rng, &mut plan, &world, catalogued, &dosed, wishes) {
                    Some(d) => dosed.push(d),
                    None => break,
                }
            }
        }
    }
    let mut rows = still(&plan);
    dosed.iter().for_each(|d| d.cause.law.disturb(&plan, d.size, &mut rows));
    if let Some(fault) = &fault {
        fault.disturb(&plan, &mut rows);
    }
    let mut exact = lengths(&plan, &location, &rows);
    for (list, noise) in exact.iter_mut().zip(&noise.rows_mm) {
        list.iter_mut().zip(noise).for_each(|(x, n)| *x += n);
    }
    let (read, spoiled) = noise::record(&exact, rng);
    let mut recordings = recordings(&plan, read, || 0.03 * rng.normal());
    if let Some(fault) = &fault {
        fault.spoil(&mut recordings);
    }
    let fault_seen = fault.as_ref().filter(|f| !f.is_gross()).map(|_| {
        let written = |i: usize, row: usize| recordings[i].axes(row);
        let trace = fault_trace(&plan, &location, &rows, &recordings);
        rms(&Absorbed::at(&plan, &written).remainder(&trace)) * 1e3 / noise_rms_um
    });
    let order = file_order(&mut plan, rng);
    let name = format!("case-{:03}", index + 1);
    let mut truth = json!({
        "case": name, "seed": seed, "trial": index, "machine": plan.machine.name, "code": plan.machine.code,
        "design": design, "clean": dosed.is_empty() && fault.is_none(),
        "noise": noise.says, "noise_rms_um": noise_rms_um, "noise_visible_rms_um": noise_left_um,
        "spoiled": spoiled, "explained_rank": absorbed.rank(), "session_length_s": plan.end_s(),
    });
    truth["effects"] = match &fault {
        Some(f) => {
            json!([{"effect": f.effect, "id": f.effect, "driver": "data fault", "place": "recorder",
            "components": [], "says": f.says, "level_reached": fault_seen.map_or("strong", level),
                "visible_over_noise": fault_seen}])
        }
        None => dosed.iter().map(|d| describe(d, &plan, noise_rms_um)).collect(),
    };
    describe_nuisance(&mut truth, &plan, &location);
    Case { name, plan, order, recordings, truth }
}

fn draw_secret(rng: &mut Draw, wishes: &Wishes) -> Secret {
    let drawn = rng.weighted(&[0.12, 0.05, 0.62, 0.11, 0.10]);
    if wishes.clean {
        return Secret::Nothing;
    }
    if let Some(effect) = &wishes.effect {
        if FAULTS.contains(&effect.as_str()) {
            return Secret::Fault;
        }
        let catalogued = KINDS.iter().any(|k| k.0 == effect && k.2);
        return Secret::Causes { count: 1, catalogued };
    }
    match drawn {
        0 => Secret::Nothing,
        1 => Secret::Fault,
        2 => Secret::Causes { count: 1, catalogued: true },
        3 => Secret::Causes { count: 2, catalogued: true },
        _ => Secret::Causes { count: 1, catalogued: false },
    }
}

fn draw_fault(rng: &mut Draw, plan: &Plan, wishes: &Wishes) -> Option<Fault> {
    (0..20).find_map(|_| {
        let kind = wishes.effect.as_deref().unwrap_or(FAULTS[rng.below(FAULTS.len())]);
        faults::draw(kind, rng, plan)
    })
}

/// What stays the same while causes are tried.
struct World<'a> {
    location: &'a Location,
    absorbed: &'a Absorbed,
    base: &'a [Vec<f64>],
    noise_um: f64,
}

impl World<'_> {
    fn dose(&self, plan: &Plan, cause: &Cause, size: f64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>, f64) {
        let mut rows = still(plan);
        cause.law.disturb(plan, size, &mut rows);
        let mut trace = lengths(plan, self.location, &rows);
        for (list, base) in trace.iter_mut().zip(self.base) {
            list.iter_mut().zip(base).for_each(|(x, b)| *x -= b);
        }
        let left = self.absorbed.remainder(&trace);
        let visible = rms(&left) * 1e3 / self.noise_um;
        (trace, left, visible)
    }
}

/// Tries kinds and places until one reaches the wanted visibility within plausible sizes.
fn draw_cause(
    rng: &mut Draw,
    plan: &mut Plan,
    world: &World,
    catalogued: bool,
    others: &[Dosed],
    wishes: &Wishes,
) -> Option<Dosed> {
    let wanted = ["strong", "medium", "weak", "any"][rng.weighted(&[0.4, 0.25, 0.2, 0.15])];
    let span = LEVELS.iter().find(|l| l.0 == wanted);
    let target = span.map(|l| rng.log_between(l.1, l.2));
    let weights: Vec<f64> = KINDS
        .iter()
        .map(|k| match &wishes.effect {
            Some(effect) => f64::from(u8::from(k.0 == effect)),
            None if k.2 == catalogued => k.1,
            None => 0.0,
        })
        .collect();
    let mut last = None;
    // the kind is drawn first so that kinds that are often hidden by the design are not crowded out
    let mut kind = rng.weighted(&weights);
    for attempt in 0..36 {
        if attempt % 12 == 11 {
            kind = rng.weighted(&weights);
        }
        let Some(cause) = KINDS[kind].3(rng, plan) else {
            continue;
        };
        if others.iter().any(|o| o.cause.place == cause.place || o.cause.effect == cause.effect) {
            continue;
        }
        let (low, high) = cause.sizes;
        let mut size = rng.log_between(low, high);
        if let Some(target) = target {
            for _ in 0..2 {
                let visible = world.dose(plan, &cause, size).2;
                size = (size * target / visible.max(1e-9)).clamp(low, high);
            }
        }
        let (trace, left, visible) = world.dose(plan, &cause, size);
        let reached = span.is_none_or(|l| visible >= l.1 && visible < l.2 * 1.05);
        last = Some(Dosed { cause, size, trace, left, wanted });
        if reached {
            break;
        }
    }
    last
}

/// What a fault leaves unexplained: readings as made against readings at the positions as written.
fn fault_trace(plan: &Plan, location: &Location, rows: &[Vec<Disturbance>], recordings: &[Recording]) -> Vec<Vec<f64>> {
    let made = lengths(plan, location, rows);
    plan.tests
        .iter()
        .enumerate()
        .map(|(i, test)| {
            let (setup, recording) = (setup(plan, test), &recordings[i]);
            (0..test.rows)
                .map(|row| {
                    let q = recording.axes(row);
                    let here = distance(&plan.machine, location, &setup, &q, &Disturbance::default());
                    let bar = plan.bars[test.bar].reading_error_mm;
                    made[i][row] - (here + bar)
                })
                .collect()
        })
        .collect()
}

/// Sometimes the file lists tests in another order, or by numbers.
fn file_order(plan: &mut Plan, rng: &mut Draw) -> Vec<usize> {
    let mut order: Vec<usize> = (0..plan.tests.len()).collect();
    if rng.chance(0.1) {
        for i in (1..order.len()).rev() {
            order.swap(i, rng.below(i + 1));
        }
    }
    if rng.chance(0.08) {
        plan.tests.iter_mut().enumerate().for_each(|(i, t)| t.name = format!("t{:02}", i + 1));
    }
    order
}

fn describe(d: &Dosed, plan: &Plan, noise_um: f64) -> Value {
    let visible_um = rms(&d.left) * 1e3;
    let of = |trace: &[f64]| rms(std::slice::from_ref(&trace.to_vec())) * 1e3;
    let tests: Vec<Value> = plan
        .tests
        .iter()
        .zip(d.trace.iter().zip(&d.left))
        .map(|(t, (trace, left))| json!({"test": t.name, "rms_um": of(trace), "visible_rms_um": of(left)}))
        .collect();
    let best = d.left.iter().map(|l| of(l)).fold(0.0, f64::max);
    let largest = d.trace.iter().flatten().fold(0.0f64, |a, x| a.max(x.abs())) * 1e3;
    let c = &d.cause;
    json!({
        "effect": c.effect, "id": c.id, "driver": c.driver, "place": c.place, "components": c.components,
        "size": d.size, "unit": c.unit, "meaning": c.meaning, "range": c.range, "params": c.params,
        "level_wanted": d.wanted, "level_reached": level(visible_um / noise_um),
        "visible_rms_um": visible_um, "visible_over_noise": visible_um / noise_um,
        "best_test_visible_over_noise": best / noise_um,
        "max_um": largest, "rms_um": rms(&d.trace) * 1e3, "tests": tests,
    })
}

fn describe_nuisance(truth: &mut Value, plan: &Plan, location: &Location) {
    let machine: &Machine = &plan.machine;
    let (mut pige, mut units) = (Map::new(), Map::new());
    for slot in slots(machine) {
        let raw = location[slot.0][slot.1];
        let (value, unit) = if slot.1 < 3 { (raw * 1e3, "um") } else { (raw / ARCSEC, "arcsec") };
        pige.insert(slot_name(machine, slot), json!(value));
        units.insert(slot_name(machine, slot), json!(unit));
    }
    let seats = |seats: &[super::plan::Placed]| -> Vec<Value> {
        seats
            .iter()
            .map(|s| {
                let on = match s.ball.link {
                    super::kinematics::Link::Bed => "b",
                    super::kinematics::Link::Axis(j) => &machine.joints[j].name,
                };
                json!({"on": on, "at": s.ball.at, "error_um": s.offset_mm.map(|x| x * 1e3)})
            })
            .collect()
    };
    truth["pige"] = Value::Object(pige);
    truth["pige_units"] = Value::Object(units);
    truth["pivots"] = json!(seats(&plan.pivots));
    truth["spindle_balls"] = json!(seats(&plan.balls));
    truth["bars"] = plan
        .bars
        .iter()
        .map(|b| json!({"nominal": b.nominal_mm, "calibrated": b.calibrated_mm, "reading_error_um": b.reading_error_mm * 1e3}))
        .collect();
}

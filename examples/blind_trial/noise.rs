//! Three families of gauge noise, outliers, gaps and quantisation; knows nothing of machines.

use super::draw::Draw;
use super::plan::Plan;
use serde_json::{Value, json};

/// Resolution of the gauge, mm.
const STEP_MM: f64 = 1e-4;

/// Noise of a whole session.
pub struct Noise {
    /// Per test and row, mm.
    pub rows_mm: Vec<Vec<f64>>,
    pub says: Value,
}

/// Families and how often each is drawn; the last is outside what a white, AR(1) and slow-drift fit assumes.
const FAMILIES: &[(&str, f64)] = &[("bench", 5.0), ("workshop", 3.0), ("rough", 2.0)];

pub fn draw(plan: &Plan, rng: &mut Draw) -> Noise {
    let weights: Vec<f64> = FAMILIES.iter().map(|f| f.1).collect();
    match FAMILIES[rng.weighted(&weights)].0 {
        "bench" => bench(plan, rng),
        "workshop" => workshop(plan, rng),
        _ => rough(plan, rng),
    }
}

/// White, AR(1) per sample and a random walk over the session.
fn bench(plan: &Plan, rng: &mut Draw) -> Noise {
    let white_um = rng.between(0.10, 0.22);
    let ar_um = rng.between(0.08, 0.25);
    let rho = rng.between(0.94, 0.988);
    let walk_um = if rng.chance(0.4) { 0.0 } else { rng.between(0.1, 0.3) };
    let end_s = plan.end_s();
    let mut walk = 0.0;
    let mut clock_s = 0.0;
    let rows_mm = each_test_in_time(plan, |test, rows| {
        let mut ar = ar_um * rng.normal();
        for (k, x) in rows.iter_mut().enumerate() {
            let t = test.started_at_s + k as f64 * test.step_s;
            walk += walk_um * ((t - clock_s).max(0.0) / end_s).sqrt() * rng.normal();
            clock_s = t;
            ar = rho * ar + ar_um * (1.0 - rho * rho).sqrt() * rng.normal();
            *x = (white_um * rng.normal() + ar + walk) * 1e-3;
        }
    });
    let says = json!({"family": "bench", "white_um": white_um, "ar_um": ar_um, "ar_rho": rho,
        "walk_end_sd_um": walk_um, "quantisation_um": STEP_MM * 1e3});
    Noise { rows_mm, says }
}

/// Correlated in seconds instead of samples, louder at speed and from test to test, with a slow tide of the hall.
fn workshop(plan: &Plan, rng: &mut Draw) -> Noise {
    let white_um = rng.between(0.08, 0.2);
    let ar_um = rng.between(0.08, 0.22);
    let tau_s = rng.log_between(0.3, 6.0);
    let tide_um = rng.between(0.0, 0.3);
    let period_s = rng.between(1500.0, 6000.0);
    let phase = rng.between(0.0, std::f64::consts::TAU);
    let rows_mm = each_test_in_time(plan, |test, rows| {
        let loud = rng.log_between(0.75, 1.35) * (test.feed / 800.0).powf(0.15);
        let rho = (-test.step_s / tau_s).exp();
        let mut ar = ar_um * rng.normal();
        for (k, x) in rows.iter_mut().enumerate() {
            let t = test.started_at_s + k as f64 * test.step_s;
            ar = rho * ar + ar_um * (1.0 - rho * rho).sqrt() * rng.normal();
            let tide = tide_um * (std::f64::consts::TAU * t / period_s + phase).sin();
            *x = (loud * white_um * rng.normal() + ar + tide) * 1e-3;
        }
    });
    let says = json!({"family": "workshop", "white_um": white_um, "ar_um": ar_um, "ar_tau_s": tau_s,
        "tide_um": tide_um, "tide_s": period_s, "quantisation_um": STEP_MM * 1e3});
    Noise { rows_mm, says }
}

/// Heavy tails, bursts and 1/f.
fn rough(plan: &Plan, rng: &mut Draw) -> Noise {
    let white_um = rng.between(0.07, 0.14);
    let pink_um = rng.between(0.06, 0.14);
    let bursts_per_min = rng.between(0.2, 1.5);
    let rows_mm = each_test_in_time(plan, |test, rows| {
        // 1/f as a sum of relaxations an octave apart
        let taus: Vec<f64> = (0..9).map(|k| 0.05 * 2.5f64.powi(k)).collect();
        let mut pink: Vec<f64> = taus.iter().map(|_| rng.normal()).collect();
        let mut burst_left_s = 0.0;
        for x in rows.iter_mut() {
            burst_left_s -= test.step_s;
            if rng.chance(bursts_per_min / 60.0 * test.step_s) {
                burst_left_s = rng.between(0.5, 3.0);
            }
            for (p, tau) in pink.iter_mut().zip(&taus) {
                let rho = (-test.step_s / tau).exp();
                *p = rho * *p + (1.0 - rho * rho).sqrt() * rng.normal();
            }
            let loud = if burst_left_s > 0.0 { 3.5 } else { 1.0 };
            let tail = rng.student(3).clamp(-15.0, 15.0);
            *x = (loud * white_um * tail + pink_um * pink.iter().sum::<f64>() / 1.6) * 1e-3;
        }
    });
    let says = json!({"family": "rough", "white_um": white_um, "pink_um": pink_um,
        "bursts_per_min": bursts_per_min, "quantisation_um": STEP_MM * 1e3});
    Noise { rows_mm, says }
}

/// Fills the rows of every test in order of time.
fn each_test_in_time(plan: &Plan, mut fill: impl FnMut(&super::plan::Test, &mut [f64])) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = plan.tests.iter().map(|t| vec![0.0; t.rows]).collect();
    let mut order: Vec<usize> = (0..plan.tests.len()).collect();
    order.sort_by(|&a, &b| plan.tests[a].started_at_s.total_cmp(&plan.tests[b].started_at_s));
    for i in order {
        fill(&plan.tests[i], &mut rows[i]);
    }
    rows
}

/// Readings as the file holds them: quantised, some far off, some missing (`None`).
pub fn record(lengths_mm: &[Vec<f64>], rng: &mut Draw) -> (Vec<Vec<Option<f64>>>, Value) {
    let spoiled = rng.chance(0.6);
    let outliers = if spoiled { rng.log_between(1e-4, 3e-3) } else { 0.0 };
    let missing = if spoiled { rng.log_between(2e-4, 6e-3) } else { 0.0 };
    let (mut far, mut gone) = (0, 0);
    let written = lengths_mm
        .iter()
        .map(|rows| {
            let mut gap = 0usize;
            rows.iter()
                .map(|&x| {
                    if gap == 0 && rng.chance(missing) {
                        gap = if rng.chance(0.3) { 2 + rng.below(12) } else { 1 };
                    }
                    if gap > 0 {
                        gap -= 1;
                        gone += 1;
                        return None;
                    }
                    let kick = if rng.chance(outliers) {
                        far += 1;
                        rng.sign() * rng.log_between(0.004, 0.05)
                    } else {
                        0.0
                    };
                    Some(((x + kick) / STEP_MM).round() * STEP_MM)
                })
                .collect()
        })
        .collect();
    (written, json!({"outliers": far, "missing": gone}))
}

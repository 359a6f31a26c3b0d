//! The contradictions of the thesis (`../shared/thesis/README.md`), each that can be computed shown by a computation; and
//! its names and published tables as shipped.

use crate::published;
use crate::shared_data;
use crate::shipped;
use crate::trunnion;
use fiveaxis::chain::Composition;
use fiveaxis::machine::{ErrorName, StructuralCode};
use fiveaxis::methods::fit_circle;
use fiveaxis::units::{ARCSEC_PER_RAD, UM_PER_MM};
use nalgebra::{Matrix3, Vector2, Vector3};
use published::published;
use shipped::TABLE_1_1;
use trunnion::{Balls, Errors};

/// Distance of the two balls' planes with the extended bar, `√(150² − 100²) = 50√5` mm.
const D_MM: f64 = 111.803_398_874_989_48;
/// Radius of the pivot's circle, mm.
const R_MM: f64 = 100.0;
/// What eq. 3.13 prints for D.
const D_PRINTED_MM: f64 = 70.710_678_118_654_76;
/// 0.01° in arcsec.
const HUNDREDTH_DEG: f64 = 36.0;
const CHAPTERS: [u8; 3] = [4, 5, 6];

/// One axis turns, the spindle ball rests.
#[derive(Clone, Copy)]
struct Arc {
    axis: char,
    balls: Balls,
}

impl Arc {
    /// The pivot on the C table.
    fn new(axis: char, pivot: [f64; 3], spindle: [f64; 3]) -> Arc {
        Arc { axis, balls: Balls { pivot: ("C", pivot), spindle } }
    }

    fn length_mm(&self, errors: Errors, at_deg: f64) -> f64 {
        let axes = if self.axis == 'A' { [at_deg, 0.0] } else { [0.0, at_deg] };
        self.balls.length_mm(errors, Composition::Exact, axes)
    }

    /// Angles that the thesis drives, degrees.
    fn angles(&self) -> Vec<f64> {
        let (from, to) = if self.axis == 'A' { (-20, 70) } else { (0, 359) };
        (from..=to).map(f64::from).collect()
    }

    /// Change of length over the arc, µm.
    fn change_um(&self, errors: Errors) -> Vec<f64> {
        self.angles().into_iter().map(|at| (self.length_mm(errors, at) - self.length_mm(&[], at)) * UM_PER_MM).collect()
    }

    /// Centre of the circle of section 4.2 in µm, the cone reduced with height `h_mm`; drawn at the pivot's own angle.
    fn centre_um(&self, errors: Errors, h_mm: f64) -> Vector2<f64> {
        let [x, y, z] = self.balls.pivot.1;
        let own = if self.axis == 'A' { z.atan2(y) } else { y.atan2(x) };
        let place = |at: f64| {
            let length = self.length_mm(errors, at);
            let angle = at.to_radians() + own;
            Vector2::new(angle.cos(), angle.sin()) * (length * length - h_mm * h_mm).sqrt()
        };
        let points: Vec<_> = self.angles().into_iter().map(place).collect();
        fit_circle(&points).expect("circle").centre_mm * UM_PER_MM
    }
}

fn a_short() -> Arc {
    Arc::new('A', [0.0, R_MM, 0.0], [0.0; 3])
}

fn a_long(d_mm: f64) -> Arc {
    Arc::new('A', [0.0, R_MM, 0.0], [-d_mm, 0.0, 0.0])
}

fn c_short() -> Arc {
    Arc::new('C', [R_MM, 0.0, 0.0], [0.0; 3])
}

fn c_long(d_mm: f64) -> Arc {
    Arc::new('C', [R_MM, 0.0, 0.0], [0.0, 0.0, d_mm])
}

/// Largest change of length, µm.
fn amplitude(changes: Vec<f64>) -> f64 {
    changes.into_iter().map(f64::abs).fold(0.0, f64::max)
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
    println!("  {what}: {found:.6}");
}

/// What second order moves the centre of a quarter of a circle that lies `centre_um` off: up to six times `c²/2R`.
fn second_order_um(centre_um: f64) -> f64 {
    6.0 * centre_um * centre_um * 1e-3 / (2.0 * R_MM)
}

fn average(chapter: u8, error: &str) -> f64 {
    published(chapter, error).average
}

/// Why an erratum has no test.
enum Shown {
    By(fn()),
    /// Words against words: nothing to compute.
    NotComputable(&'static str),
}
use Shown::{By, NotComputable};

const ERRATA: [Shown; 32] = [
    By(d_is_50_root_5),
    By(products_of_tilts),
    By(pivot_on_the_other_side),
    By(phase_of_one_mounting),
    NotComputable("one quantity under two names"),
    By(angles_from_zero),
    By(normal_equations_without_minus),
    By(count_of_points),
    NotComputable("one symbol for two distances; both readings have the same centre"),
    By(sign_of_the_cone),
    By(bound_of_eq_4_5),
    By(pairing_of_chapter_5),
    By(signs_by_the_matrices),
    By(local_values_of_chapter_6),
    By(ey0a_cancels),
    By(literal_table_5_1),
    By(codes),
    By(names_of_linear_zeros),
    NotComputable("guides and cylinders are counted twice; no number follows"),
    By(offset_holds_a_tilt),
    By(da_is_the_whole_distance),
    By(height_of_step_4),
    By(overshoot_counted_once),
    By(digits_of_the_tables),
    By(chapter_3_cannot_be_chapter_6),
    By(head_of_chapter_7),
    NotComputable("the order in which the steps are told"),
    By(claimed_agreement),
    By(duration_of_a_step),
    By(size_of_the_offsets),
    By(thx0c_of_chapters_4_and_5),
    By(unequal_scatter),
];

#[test]
fn every_erratum_is_shown_or_said_to_be_words() {
    for (index, erratum) in ERRATA.iter().enumerate() {
        match erratum {
            By(show) => {
                println!("erratum {}", index + 1);
                show();
            }
            NotComputable(why) => println!("erratum {}: not computable, {why}", index + 1),
        }
    }
    assert_eq!(ERRATA.iter().filter(|erratum| matches!(erratum, By(_))).count(), 28);
}

fn d_is_50_root_5() {
    near("D", (150.0f64.powi(2) - 100.0f64.powi(2)).sqrt(), 50.0 * 5f64.sqrt(), 1e-12);
    let ideal = |d| a_long(d).length_mm(&[], 0.0);
    near("ideal bar with the right D", ideal(D_MM), 150.0, 1e-12);
    near("ideal bar with the printed D", ideal(D_PRINTED_MM), 122.474_487, 5e-7);
    // the largest change of a full turn of C: amplitudes that the figures would show
    let c = |d, error, size| amplitude(c_long(d).change_um(&[(error, size)]));
    near("tilt of 0.01°, right", c(D_MM, "EB0C", HUNDREDTH_DEG), 13.01, 0.005);
    near("tilt of 0.01°, printed", c(D_PRINTED_MM, "EB0C", HUNDREDTH_DEG), 10.08, 0.005);
    near("offset of 10 µm, right", c(D_MM, "EX0C", 10.0), 6.67, 0.005);
    near("offset of 10 µm, printed", c(D_PRINTED_MM, "EX0C", 10.0), 8.16, 0.006);
    // had the readings been reduced with it, the long bar's centre would shrink against the short bar's
    let offset = [("EY0A", 35.0)];
    let shrunk = a_long(D_MM).centre_um(&offset, D_PRINTED_MM).x;
    // printed to three digits; the circle's own second order is c²/2R = 6 nm
    near("share of an offset", shrunk / 35.0, 0.756, 5e-4);
    let fictitious = (35.0 - shrunk) * 1e-3 / D_PRINTED_MM * ARCSEC_PER_RAD;
    near("fictitious tilt", fictitious, 25.0, 0.5);
    for error in ["EB0A", "EC0A"] {
        let apart = (average(4, error) - average(6, error)).abs();
        assert!(apart < 1.1 && apart < fictitious / 10.0, "chapters 4 and 6 differ by {apart}″ in {error}");
    }
}

fn products_of_tilts() {
    // I + [ε]× about x, then about y: the product stays in the second row alone
    let (thx, thy) = (average(4, "EA0C") / ARCSEC_PER_RAD, average(4, "EB0C") / ARCSEC_PER_RAD);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, -thx, 0.0, thx, 1.0);
    let about_y = Matrix3::new(1.0, 0.0, thy, 0.0, 1.0, 0.0, -thy, 0.0, 1.0);
    let dropped = Matrix3::new(1.0, 0.0, thy, 0.0, 1.0, -thx, -thy, thx, 1.0);
    let kept = about_x * about_y - dropped;
    near("product in the second row, rad²", kept[(1, 0)], thx * thy, 1e-24);
    assert_eq!(kept.iter().filter(|value| **value != 0.0).count(), 1);
    let moved = (kept * Vector3::new(R_MM, 0.0, 0.0)).norm();
    assert!(moved < 1e-6, "{moved} mm: below a nanometre, whichever is printed");
}

fn pivot_on_the_other_side() {
    let drawn = Arc::new('A', [0.0, -R_MM, 0.0], [0.0; 3]);
    let offset = [("EY0A", 10.0)];
    for (tested, drawn) in a_short().change_um(&offset).into_iter().zip(drawn.change_um(&offset)) {
        near("sum of both sides", tested + drawn, 0.0, 2e-3);
    }
}

fn phase_of_one_mounting() {
    let y = Arc::new('C', [0.0, R_MM, 0.0], [0.0; 3]);
    let offset = [("EX0C", 10.0)];
    let (on_x, on_y) = (c_short().change_um(&offset), y.change_um(&offset));
    let shifted = (0..360).map(|k| (on_y[k] - on_x[(k + 90) % 360]).abs()).fold(0.0, f64::max);
    near("after 90°", shifted, 0.0, 1e-9);
    assert!((0..360).map(|k| (on_y[k] - on_x[k]).abs()).fold(0.0, f64::max) > 10.0);
}

/// Points of a circle about a centre in mm over −20° … 70°, drawn at the angle plus `added_deg`.
fn arc_points(centre: Vector2<f64>, count: usize, added_deg: f64) -> Vec<Vector2<f64>> {
    let point = |k: usize| {
        let angle = (-20.0 + 90.0 * k as f64 / (count - 1) as f64).to_radians();
        let u = Vector2::new(angle.cos(), angle.sin());
        let along = centre.dot(&u);
        let rho = along + (R_MM * R_MM - centre.norm_squared() + along * along).sqrt();
        let drawn = angle + added_deg.to_radians();
        Vector2::new(drawn.cos(), drawn.sin()) * rho
    };
    (0..count).map(point).collect()
}

fn angles_from_zero() {
    let centre = Vector2::new(0.0342, -0.0353);
    let right = fit_circle(&arc_points(centre, 91, 0.0)).unwrap().centre_mm;
    near("y at its own angles", right.x, 0.0342, 1e-9);
    let turned = fit_circle(&arc_points(centre, 91, 20.0)).unwrap().centre_mm * 1e3;
    near("y with angles from 0", turned.x, 44.2, 0.05);
    near("z with angles from 0", turned.y, -21.4, 0.1);
}

/// Solution a, b, c of the normal equations of section 4.2, with the sign of the right-hand side and the last element given.
fn normal_equations(points: &[Vector2<f64>], sign: f64, last: f64) -> Vector3<f64> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for point in points {
        let row = Vector3::new(point.x, point.y, 1.0);
        normal += row * row.transpose();
        right += row * point.norm_squared() * sign;
    }
    normal[(2, 2)] = last;
    normal.lu().solve(&right).unwrap()
}

fn normal_equations_without_minus() {
    let points = arc_points(Vector2::new(0.0342, -0.0353), 91, 0.0);
    let right = normal_equations(&points, -1.0, 91.0);
    near("ey0a with the minus", -right.x / 2.0, 0.0342, 1e-8);
    let printed = normal_equations(&points, 1.0, 91.0);
    near("ey0a as printed", -printed.x / 2.0, -0.0342, 1e-8);
    near("ez0a as printed", -printed.y / 2.0, 0.0353, 1e-8);
    let radicand = printed.x.powi(2) + printed.y.powi(2) - 4.0 * printed.z;
    assert!(radicand < 0.0, "R would be the root of {radicand}");
}

fn count_of_points() {
    let points = arc_points(Vector2::new(0.0342, -0.0353), 1001, 0.0);
    let literal = normal_equations(&points, -1.0, 1000.0);
    let moved = (Vector2::new(-literal.x / 2.0, -literal.y / 2.0) - Vector2::new(0.0342, -0.0353)).norm();
    assert!(moved > 1.0, "N in place of N + 1 moves the centre by {moved} mm");
    println!("  N for N + 1 moves the centre by {moved:.2} mm");
}

fn sign_of_the_cone() {
    // E to O' and O' to E differ in sign, and so does every tilt of chapters 4 and 5
    let tilt = [("EB0A", 6.62)];
    let (short, long) = (a_short().centre_um(&tilt, 0.0), a_long(D_MM).centre_um(&tilt, D_MM));
    let by = |difference: f64| (difference * 1e-3 / D_MM).atan() * ARCSEC_PER_RAD;
    near("by EP + PO'", by(long.y - short.y), 6.62, 0.02);
    near("by O'P − EP", by(short.y - long.y), -6.62, 0.02);
}

fn bound_of_eq_4_5() {
    let centre_mm = average(4, "EY0A").hypot(average(4, "EZ0A")) * 1e-3;
    // 1/(cos a cos b) − 1 without cancellation
    let delta = |a: f64, b: f64| {
        let less = |angle: f64| 2.0 * (angle / 2.0).sin().powi(2);
        let product = less(a) + less(b) - less(a) * less(b);
        centre_mm * product / (1.0 - product)
    };
    let degree = 1f64.to_radians();
    near("at 1°, mm", delta(degree, degree), 1.4975e-5, 5e-9);
    near("at 132″, mm", delta(131.6 / ARCSEC_PER_RAD, 131.6 / ARCSEC_PER_RAD), 2e-8, 5e-10);
    near("at 131.6″ of one tilt, mm", delta(131.6 / ARCSEC_PER_RAD, 0.0), 1e-8, 1e-10);
    let published = delta(average(4, "EB0A") / ARCSEC_PER_RAD, average(4, "EC0A") / ARCSEC_PER_RAD);
    near("at the published tilts, mm", published, 2.74e-11, 5e-14);
}

/// Centre of the long bar minus that of the short one, µm.
fn between(short: Arc, long: Arc, errors: Errors) -> Vector2<f64> {
    long.centre_um(errors, D_MM) - short.centre_um(errors, 0.0)
}

fn pairing_of_chapter_5() {
    let of = |error| between(a_short(), a_long(D_MM), &[(error, HUNDREDTH_DEG)]);
    let moved_um = HUNDREDTH_DEG / ARCSEC_PER_RAD * D_MM * 1e3;
    near("θy0a in z", of("EB0A").y, moved_um, 0.01);
    near("θy0a in y", of("EB0A").x, 0.0, 0.01);
    near("θz0a in y", of("EC0A").x, -moved_um, 0.01);
    near("θz0a in z", of("EC0A").y, 0.0, 0.01);
}

fn signs_by_the_matrices() {
    let moved_um = |distance: f64| HUNDREDTH_DEG / ARCSEC_PER_RAD * distance * 1e3;
    // chapters 4 and 5, C: OP − EP is the short bar's centre minus the long bar's
    let of = |error| -between(c_short(), c_long(D_MM), &[(error, HUNDREDTH_DEG)]);
    near("θy0a in x", of("EB0A").x, -moved_um(D_MM), 0.01);
    near("θy0c in x", of("EB0C").x, -moved_um(D_MM), 0.01);
    near("θx0c in y", of("EA0C").y, moved_um(D_MM), 0.01);
    // chapter 6, C raised by 78 mm
    let raised = Arc::new('C', [R_MM, 0.0, 78.0], [0.0, 0.0, 78.0]);
    let of = |error| {
        let errors = [(error, HUNDREDTH_DEG)];
        raised.centre_um(&errors, 0.0) - c_short().centre_um(&errors, 0.0)
    };
    near("chapter 6: θy0a in x", of("EB0A").x, moved_um(78.0), 0.01);
    near("chapter 6: θy0c in x", of("EB0C").x, moved_um(78.0), 0.01);
    near("chapter 6: θx0c in y", of("EA0C").y, -moved_um(78.0), 0.01);
}

/// Chapter 6's A test at a place along X.
fn a_at(x_mm: f64) -> Arc {
    Arc::new('A', [x_mm, R_MM, 0.0], [x_mm, 0.0, 0.0])
}

fn local_values_of_chapter_6() {
    let moved_um = HUNDREDTH_DEG / ARCSEC_PER_RAD * 275.0 * 1e3;
    for side in [1.0, -1.0] {
        let of = |error| a_at(side * 275.0).centre_um(&[(error, HUNDREDTH_DEG)], 0.0);
        near("θz0a in y, plus as printed", of("EC0A").x, side * moved_um, second_order_um(moved_um));
        near("θy0a in z, minus", of("EB0A").y, -side * moved_um, second_order_um(moved_um));
    }
}

fn ey0a_cancels() {
    let raised = Arc::new('C', [R_MM, 0.0, 78.0], [0.0, 0.0, 78.0]);
    let errors = [("EY0A", 35.0)];
    near("in the lower circle", c_short().centre_um(&errors, 0.0).y, 35.0, 0.02);
    near("in the tilt", raised.centre_um(&errors, 0.0).y - c_short().centre_um(&errors, 0.0).y, 0.0, 1e-6);
}

fn literal_table_5_1() {
    let errors = [("EC0A", HUNDREDTH_DEG), ("EY0A", 35.0)];
    let y_of_a = a_long(D_MM).centre_um(&errors, D_MM).x;
    let step_4 = c_long(D_MM).centre_um(&errors, D_MM).y;
    let step_3 = c_short().centre_um(&errors, 0.0).y;
    let tilt = |difference_um: f64| difference_um * 1e-3 / D_MM * ARCSEC_PER_RAD;
    near("θx0c with ey0a taken out of both", tilt((step_4 - 35.0) - (step_3 - 35.0)), 0.0, 0.03);
    near("θx0c with ey0a,bot taken out of step 4", tilt((step_4 - y_of_a) - (step_3 - 35.0)), HUNDREDTH_DEG, 0.05);
    let x = between(c_short(), c_long(D_MM), &[("EB0A", HUNDREDTH_DEG)]).x;
    near("θy0a in the x offsets of step 4", tilt(x), HUNDREDTH_DEG, 0.02);
}

const FIG_1_1: [&str; 3] = ["[wXbYZCBt]", "[wCXbYZAt]", "[wCAYbXZt]"];

fn codes() {
    for code in TABLE_1_1 {
        let parsed = StructuralCode::parse(code).unwrap();
        assert!(["X", "Y"].iter().all(|name| parsed.workpiece_side.iter().any(|axis| axis == name)), "{code}");
        assert!(parsed.tool_side.iter().any(|axis| axis == "Z"), "{code}");
    }
    for code in FIG_1_1.iter().chain(&["[wCAbYXZt]"]) {
        assert!(!TABLE_1_1.contains(code), "{code}");
        let parsed = StructuralCode::parse(code).unwrap();
        assert!(["X", "Y"].iter().any(|name| parsed.tool_side.iter().any(|axis| axis == name)), "{code}");
    }
}

fn names_of_linear_zeros() {
    for (slip, length, angle) in [("thx0x", "EX0X", "EA0X"), ("θy0y", "EY0Y", "EB0Y"), ("thz0z", "EZ0Z", "EC0Z")] {
        let refusal = ErrorName::parse(slip, &["X", "Y", "Z", "A", "C"]).unwrap_err().to_string();
        assert!(refusal.contains(length) && refusal.contains(angle), "{refusal}");
    }
}

fn offset_holds_a_tilt() {
    let errors = [("EY0A", 35.0), ("EC0A", HUNDREDTH_DEG)];
    near("at x = 0", a_at(0.0).centre_um(&errors, 0.0).x, 35.0, second_order_um(35.0));
    let tilt_um = HUNDREDTH_DEG / ARCSEC_PER_RAD * 100.0 * 1e3;
    near("at x = 100 mm", a_at(100.0).centre_um(&errors, 0.0).x, 35.0 + tilt_um, second_order_um(35.0 + tilt_um));
}

fn da_is_the_whole_distance() {
    // means of two positions of equal scatter: the difference has twice the printed scatter
    let by = |position, tilt| {
        2.0 * published(6, position).deviation * 1e-3 / (published(6, tilt).deviation / ARCSEC_PER_RAD)
    };
    let (y, z) = (by("EY0A", "EC0A"), by("EZ0A", "EB0A"));
    near("distance from y, mm", y, 524.0, 1.0);
    near("distance from z, mm", z, 635.0, 1.0);
    assert!((y / 550.0).ln().abs() < (y / 1100.0).ln().abs() && (z / 550.0).ln().abs() < (z / 1100.0).ln().abs());
}

fn height_of_step_4() {
    assert!(c_long(D_MM).balls.spindle[2] > 78.0, "chapters 4 and 5 raise the same ball higher than chapter 6's 78 mm");
}

fn overshoot_counted_once() {
    near("C's 450°", 360.0 + 2.0 * 45.0, 450.0, 0.0);
    near("A's −20° to 70°", 70.0 + 20.0, 90.0, 0.0);
}

fn digits_of_the_tables() {
    assert_eq!(published(4, "EX0C"), published(5, "EX0C"));
    let text = include_str!("../examples/thesis/published/chapter5.yaml");
    let decimals = |line: &str| line.split("deviation: 0.").nth(1).map(|rest| rest.find(' ').unwrap_or(0));
    let tilts: Vec<_> = text.lines().filter(|line| line.contains("arcsec")).filter_map(decimals).collect();
    assert_eq!(tilts, [3, 4, 3, 3]);
}

fn chapter_3_cannot_be_chapter_6() {
    // eq. 3.12 and 3.18 move the spindle ball away from the pivot's plane, which chapter 6 never does
    for (arc, along) in [(a_long(D_MM), 0), (c_long(D_MM), 2)] {
        near("out of the pivot's plane, mm", (arc.balls.spindle[along] - arc.balls.pivot.1[along]).abs(), D_MM, 1e-9);
    }
}

fn head_of_chapter_7() {
    let code = StructuralCode::parse(FIG_1_1[0]).unwrap();
    assert!(code.tool_side.iter().any(|axis| axis == "B") && !code.tool_side.iter().any(|axis| axis == "A"));
}

fn claimed_agreement() {
    let apart = |error: &str, a: u8, b: u8| (average(a, error) - average(b, error)).abs();
    let sigma = |error: &str, a: u8, b: u8| published(a, error).deviation.hypot(published(b, error).deviation);
    near("ey0a, chapters 4 and 5", apart("EY0A", 4, 5), 1.1, 1e-9);
    near("ez0a, chapters 4 and 5", apart("EZ0A", 4, 5), 1.9, 1e-9);
    let widest = |error| [(4, 5), (4, 6), (5, 6)].map(|(a, b)| apart(error, a, b)).into_iter().fold(0.0, f64::max);
    near("ey0a, all", widest("EY0A"), 1.8, 1e-9);
    near("ez0a, all", widest("EZ0A"), 2.2, 1e-9);
    near("ey0c, all", widest("EY0C"), 1.6, 1e-9);
    for (error, a, b) in [("EY0A", 4, 5), ("EZ0A", 4, 5), ("EY0A", 5, 6), ("EZ0A", 5, 6), ("EY0A", 4, 6)] {
        let ratio = apart(error, a, b) / sigma(error, a, b);
        assert!((3.0..6.5).contains(&ratio), "{error} {a} {b}: {ratio}");
    }
}

fn duration_of_a_step() {
    let seconds = |degrees: f64| degrees.to_radians() * R_MM / (500.0 / 60.0);
    near("a turn, s", seconds(360.0), 75.40, 0.005);
    near("with overshoot, s", seconds(450.0), 94.25, 0.005);
    assert!(seconds(360.0) > 60.0);
}

fn size_of_the_offsets() {
    let um = (average(4, "EA0C") / ARCSEC_PER_RAD).tan() * D_MM * 1e3;
    near("θx0c between the circles, µm", um, -12.10, 0.005);
}

fn thx0c_of_chapters_4_and_5() {
    near("θx0c, chapters 4 and 5, arcsec", average(5, "EA0C") - average(4, "EA0C"), 0.04, 1e-9);
    assert!((average(6, "EA0C") - average(4, "EA0C")).abs() > 3.0);
}

fn unequal_scatter() {
    // a tilt of two independent circles scatters at least as the short one's centre does over the distance
    let least = |chapter, position| published(chapter, position).deviation * 1e-3 / D_MM * ARCSEC_PER_RAD;
    for (chapter, tilt, position, bound) in
        [(4, "EB0A", "EZ0A", 0.68), (4, "EA0C", "EY0C", 1.11), (5, "EB0A", "EZ0A", 0.54), (5, "EA0C", "EY0C", 0.90)]
    {
        near("least scatter, arcsec", least(chapter, position), bound, 0.006);
        assert!(published(chapter, tilt).deviation < least(chapter, position), "chapter {chapter} {tilt}");
    }
    for chapter in [4, 5] {
        assert!(least(chapter, "EY0C") / published(chapter, "EA0C").deviation > 2.0);
    }
}

/// The thesis in numbers, or `None` with a line that says so.
fn tables() -> Option<serde_yaml::Value> {
    let folder = shared_data::folder("thesis")?;
    let text = std::fs::read_to_string(folder.join("tables.yaml")).expect("tables.yaml");
    Some(serde_yaml::from_str(&text).expect("YAML"))
}

fn words(value: &serde_yaml::Value) -> Vec<String> {
    value.as_sequence().into_iter().flatten().filter_map(|word| word.as_str().map(String::from)).collect()
}

#[test]
fn table_2_1_is_read_name_by_name() {
    let Some(tables) = tables() else { return };
    let axes = ["X", "Y", "Z", "A", "B", "C"];
    let name = |text: &str| ErrorName::parse(text, &axes).map(|name| name.to_string());
    let (mut same, mut refused) = (0, 0);
    for row in tables["table_2_1"]["rows"].as_sequence().unwrap() {
        let axis = row["axis"].as_str().unwrap();
        let is_location = row["kind"].as_str() == Some("PIGE");
        let mut pairs: Vec<_> = words(&row["iso"]).into_iter().zip(words(&row["thesis"])).collect();
        if let (Some(iso), Some(thesis)) = (row["ignored"]["iso"].as_str(), row["ignored"]["thesis"].as_str()) {
            pairs.push((iso.into(), thesis.into()));
        }
        for (iso, thesis) in pairs {
            assert_eq!(name(&iso).as_deref(), Ok(iso.as_str()), "the ISO name itself");
            let about_itself = "ABC".find(axis).is_some_and(|own| "xyz".find(&thesis[2..3]) == Some(own));
            // chapter 5's slip: a tilt of a rotary axis without its 0; Table 2.1's slip: a length paired with an angle
            let slip_of_chapter_5 = !is_location && thesis.starts_with("th") && "ABC".contains(axis) && !about_itself;
            let slip_of_the_table = is_location && "XYZ".contains(axis) && ["EX0X", "EY0Y", "EZ0Z"].contains(&&*iso);
            if slip_of_chapter_5 || slip_of_the_table {
                let refusal = name(&thesis).unwrap_err().to_string();
                assert!(refusal.contains(&iso), "{refusal}");
                refused += 1;
            } else {
                assert_eq!(name(&thesis).as_deref(), Ok(iso.as_str()), "{thesis}");
                same += 1;
            }
        }
    }
    // six component and three or five location names for each of three linear and three rotary axes
    assert_eq!((same, refused), (6 * 6 + 3 * 3 + 3 * 5 - 9, 9));
}

#[test]
fn codes_are_those_of_table_1_1_and_fig_1_1() {
    let Some(tables) = tables() else { return };
    assert_eq!(words(&tables["table_1_1"]["codes"]), TABLE_1_1);
    let figure: Vec<_> = tables["fig_1_1"]["rows"].as_sequence().unwrap().iter().map(|row| &row["code"]).collect();
    assert_eq!(figure, FIG_1_1);
}

#[test]
fn every_code_of_the_thesis_is_a_machine_that_ships() {
    TABLE_1_1.iter().chain(&FIG_1_1).for_each(|code| drop(shipped::machine_of(code)));
}

#[test]
fn shipped_results_are_the_printed_ones() {
    let Some(tables) = tables() else { return };
    let mut count = 0;
    for chapter in CHAPTERS {
        // Tables 4.1 and 6.2 hold conditions, 4.1 for chapter 5 too
        for number in if chapter == 6 { [3, 4] } else { [2, 3] } {
            let table = &tables[format!("table_{chapter}_{number}").as_str()];
            let per = if table["unit"].as_str() == Some("mm") { 1e3 } else { 1.0 };
            for row in table["rows"].as_sequence().unwrap() {
                let found = published(chapter, row["iso"].as_str().unwrap());
                assert!((found.average - row["average"].as_f64().unwrap() * per).abs() < 1e-9, "{row:?}");
                assert!((found.deviation - row["sd"].as_f64().unwrap() * per).abs() < 1e-9, "{row:?}");
                count += 1;
            }
        }
    }
    assert_eq!(count, 24);
}

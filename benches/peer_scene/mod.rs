//! The scene and the draw of poses of the peers' comparison: 58 pairs; table in Y, tilting and turning, spindle in X and
//! Z; ball carried within 150 mm, bar of 150 mm in a random upward direction. Random numbers differ from theirs.

use fiveaxis::bodies::{Bodies, Body, Solid};
use fiveaxis::chain::Pose;
use fiveaxis::collision::{BarEnds, Convex, Part, Scene, World};
use fiveaxis::load::machine_from_yaml;
use fiveaxis::machine::Machine;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A pose of the scene: place of the bar's ball and positions of the axes.
pub type ScenePose = (Vector3<f64>, Vec<f64>);

/// The bar, mm.
const BAR_MM: f64 = 150.0;

pub fn machine() -> Machine {
    let text = "name: scene\ncode: \"[wCAYbXZt]\"\naxes:\n  X: {}\n  Y: {}\n  Z: {}\n  A: {}\n  C: {}\n";
    machine_from_yaml(std::path::Path::new("scene"), text.into()).expect("valid")
}

pub fn bodies() -> Bodies {
    let mut list = Vec::new();
    let mut add = |name: &str, link: &str, solid: Solid, at: [f64; 3]| {
        let at = Pose { rotation: Matrix3::identity(), translation_mm: Vector3::from(at) };
        list.push(Body { name: name.into(), link: link.into(), solids: vec![solid], at });
    };
    let block = |x, y, z| Solid::Box { half_mm: Vector3::new(x, y, z) };
    add("bed", "b", block(700.0, 800.0, 100.0), [0.0, 0.0, -620.0]);
    add("column", "b", block(450.0, 150.0, 600.0), [0.0, 820.0, 300.0]);
    add("guard_l", "b", block(10.0, 700.0, 700.0), [-720.0, 0.0, 100.0]);
    add("guard_r", "b", block(10.0, 700.0, 700.0), [720.0, 0.0, 100.0]);
    let magazine: Vec<Vector3<f64>> = (0..48)
        .map(|k| {
            let i = f64::from(k) + 0.5;
            let (polar, turn) = ((1.0 - 2.0 * i / 48.0).acos(), std::f64::consts::PI * (1.0 + 5f64.sqrt()) * i);
            let unit = Vector3::new(turn.cos() * polar.sin(), turn.sin() * polar.sin(), polar.cos());
            unit.component_mul(&Vector3::new(150.0, 200.0, 200.0)) + Vector3::new(-540.0, 500.0, 350.0)
        })
        .collect();
    add("tool_magazine", "b", Solid::hull_of(&magazine).expect("volume"), [0.0; 3]);
    add("y_saddle", "Y", block(380.0, 260.0, 50.0), [0.0, 0.0, -420.0]);
    add("cradle_l", "A", block(35.0, 110.0, 130.0), [-310.0, 0.0, -40.0]);
    add("cradle_r", "A", block(35.0, 110.0, 130.0), [310.0, 0.0, -40.0]);
    let trough: Vec<Vector3<f64>> = [-265.0, 265.0]
        .iter()
        .flat_map(|&x| {
            (0..24).map(move |k| {
                let u = std::f64::consts::PI * (1.0 + f64::from(k) / 23.0);
                Vector3::new(x, 190.0 * u.cos(), -115.0 + 110.0 * u.sin())
            })
        })
        .collect();
    add("cradle_trough", "A", Solid::hull_of(&trough).expect("volume"), [0.0; 3]);
    add("c_table", "C", Solid::Cylinder { radius_mm: 160.0, half_mm: 18.0 }, [0.0, 0.0, -93.0]);
    let mut head = Vec::new();
    let (sx, sy, sz, k) = (110.0, 120.0, 150.0, 40.0);
    for x in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            for z in [-1.0, 1.0] {
                let middle = Vector3::new(0.0, 40.0, 350.0);
                head.push(middle + Vector3::new(x * sx, y * sy, z * sz));
                head.push(middle + Vector3::new(x * (sx + k), y * sy * 0.7, z * sz * 0.7));
                head.push(middle + Vector3::new(x * sx * 0.7, y * (sy + k), z * sz * 0.7));
            }
        }
    }
    add("spindle_head", "Z", Solid::hull_of(&head).expect("volume"), [0.0; 3]);
    add("spindle_nose", "Z", Solid::Cylinder { radius_mm: 42.0, half_mm: 60.0 }, [0.0, 0.0, 140.0]);
    Bodies { bodies: list, ..Bodies::default() }
}

/// Poses with the pivot at its own place on the table for each: scenes share the world.
pub fn poses(count: usize) -> Vec<ScenePose> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let turn = std::f64::consts::TAU;
    (0..count)
        .map(|_| {
            let a = random.random_range(-20f64.to_radians()..70f64.to_radians());
            let c: f64 = random.random_range(0.0..turn);
            let r = 150.0 * random.random_range(0.0f64..1.0).sqrt();
            let f: f64 = random.random_range(0.0..turn);
            let pivot = Vector3::new(r * f.cos(), r * f.sin(), 0.0);
            let turned = Vector3::new(r * (f + c).cos(), r * (f + c).sin(), 0.0);
            let at = Vector3::new(turned.x, turned.y * a.cos(), turned.y * a.sin());
            let direction = loop {
                let d = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0f64));
                if d.norm() > 0.05 && d.norm() <= 1.0 {
                    let d = d.normalize();
                    break if d.z < -0.2 { -d } else { d };
                }
            };
            let ball = at + direction * BAR_MM;
            // axes in the code's order: C A Y X Z; the table moves so that the spindle ball stands at y = 0
            (pivot, vec![c, a, -ball.y, ball.x, ball.z])
        })
        .collect()
}

pub fn scene<'w>(world: &'w World, pivot: Vector3<f64>) -> Scene<'w> {
    let chain = world.chain();
    let frame = |name: &str| world.frame(chain.link(name).expect("link"));
    let (c, z, bar) = (frame("C"), frame("Z"), world.frame_count());
    let along = |s: f64| Vector3::new(0.0, 0.0, s);
    let stem = |at: Vector3<f64>, up: f64, length: f64, radius| {
        Convex::cylinder(at + along(up), at + along(up + length), radius)
    };
    let parts = vec![
        Part::new("ball_w", c, Convex::ball(pivot, 6.35)),
        Part::new("ball_s", z, Convex::ball(Vector3::zeros(), 6.35)),
        Part::new("bar", bar, Convex::capsule(along(8.0), along(BAR_MM - 8.0), 8.0)),
        Part::new("stem_w", c, stem(pivot, -75.0, 66.0, 10.0)),
        Part::new("stem_s", z, stem(Vector3::zeros(), 6.0, 72.0, 9.0)),
    ];
    let bodies = world.part_count();
    let mut pairs = Vec::new();
    for part in 0..5 {
        for body in 0..bodies {
            // stem on the table, stem in the nose: touch by design
            if (part, body) != (3, 9) && (part, body) != (4, 11) {
                pairs.push((body, bodies + part));
            }
        }
    }
    Scene::with_parts(world, parts, pairs, Some(BarEnds { pivot: (c, pivot), spindle: (z, Vector3::zeros()) }))
}

/// Puts the pivot elsewhere on the table, its ball and stem with it.
pub fn set_pivot(scene: &mut Scene, pivot: &Vector3<f64>) {
    scene.move_pivot(pivot, &[(0, Vector3::zeros()), (3, Vector3::new(0.0, 0.0, -42.0))]);
}

//! Meshes and their convex pieces: the surface is covered, hollows stay open, STL and OBJ say the same.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use fiveaxis::bodies::{Solid, Triangle, convex_pieces};
use fiveaxis::chain::Pose;
use fiveaxis::collision::{Convex, distance};
use fiveaxis::load::load_machine_and_bodies;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Point = Vector3<f64>;

fn point(x: f64, y: f64, z: f64) -> Point {
    Vector3::new(x, y, z)
}

/// Closed surface of the cells of a grid that are filled; planes of the grid by direction.
fn cells(planes: [&[f64]; 3], filled: impl Fn(Point) -> bool) -> Vec<Triangle> {
    let count = planes.map(|p| p.len() as i64 - 1);
    let middle = |cell: [i64; 3]| {
        Point::from_fn(|k, _| {
            let (a, b) = (planes[k][cell[k] as usize], planes[k][cell[k] as usize + 1]);
            0.5 * (a + b)
        })
    };
    let is_filled = |cell: [i64; 3]| (0..3).all(|k| cell[k] >= 0 && cell[k] < count[k]) && filled(middle(cell));
    let mut triangles = Vec::new();
    for i in 0..count[0] {
        for j in 0..count[1] {
            for l in 0..count[2] {
                let cell = [i, j, l];
                if !is_filled(cell) {
                    continue;
                }
                for k in 0..3 {
                    for up in [0, 1] {
                        let mut next = cell;
                        next[k] += 2 * up - 1;
                        if is_filled(next) {
                            continue;
                        }
                        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
                        let corner = |a: i64, b: i64| {
                            let mut p = Point::zeros();
                            p[k] = planes[k][(cell[k] + up) as usize];
                            p[u] = planes[u][(cell[u] + a) as usize];
                            p[v] = planes[v][(cell[v] + b) as usize];
                            p
                        };
                        let square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        triangles.push([square[0], square[1], square[2]]);
                        triangles.push([square[0], square[2], square[3]]);
                    }
                }
            }
        }
    }
    triangles
}

/// A ring about z with a round section.
fn ring(radius: f64, section: f64, around: usize, across: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let (s, c) = (std::f64::consts::TAU * (i % around) as f64 / around as f64).sin_cos();
        let (t, d) = (std::f64::consts::TAU * (j % across) as f64 / across as f64).sin_cos();
        let r = radius + section * d;
        point(r * c, r * s, section * t)
    };
    (0..around)
        .flat_map(|i| (0..across).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

fn turned(triangles: &[Triangle], by: Matrix3<f64>) -> Vec<Triangle> {
    triangles.iter().map(|t| t.map(|p| by * p)).collect()
}

fn convexes(solids: &[Solid]) -> Vec<Convex> {
    solids.iter().map(|solid| Convex::of(solid, Matrix3::identity(), Vector3::zeros())).collect()
}

/// Distance of a ball from the nearest piece, mm.
fn gap(pieces: &[Convex], at: Point, radius_mm: f64) -> f64 {
    let still = Pose::identity();
    let ball = Convex::ball(at, radius_mm);
    pieces.iter().map(|piece| distance(piece, &still, &ball, &still)).fold(f64::MAX, f64::min)
}

/// Largest distance of random points of the triangles from the pieces, mm.
fn uncovered_mm(triangles: &[Triangle], pieces: &[Convex]) -> f64 {
    let seed = 5;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..4000)
        .map(|_| {
            let t = &triangles[random.random_range(0..triangles.len())];
            let (mut a, mut b) = (random.random_range(0.0..1.0), random.random_range(0.0..1.0));
            if a + b > 1.0 {
                (a, b) = (1.0 - a, 1.0 - b);
            }
            gap(pieces, t[0] + (t[1] - t[0]) * a + (t[2] - t[0]) * b, 0.0)
        })
        .fold(0.0, f64::max)
}

/// 100 x 100 x 40 with walls of 10: a channel along y, open above.
fn channel() -> Vec<Triangle> {
    cells([&[-50.0, -40.0, 40.0, 50.0], &[-50.0, 50.0], &[0.0, 10.0, 40.0]], |p| p.z < 10.0 || p.x.abs() > 40.0)
}

/// A window frame of 100 x 100, bars of 10, 20 deep.
fn frame() -> Vec<Triangle> {
    let planes = [-50.0, -40.0, 40.0, 50.0];
    cells([&planes, &planes, &[0.0, 20.0]], |p| p.x.abs() > 40.0 || p.y.abs() > 40.0)
}

#[test]
fn pieces_cover_the_surface_and_leave_hollows_open() {
    // a hollow is given by balls (place, radius) that fit in with 5 mm and more to spare
    let lean = *nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.5).matrix();
    type Case = (&'static str, Vec<Triangle>, Vec<(Point, f64)>);
    let cases: Vec<Case> = vec![
        ("channel", channel(), vec![(point(0.0, 0.0, 26.0), 10.0), (point(28.0, 40.0, 26.0), 6.0)]),
        ("frame", frame(), vec![(point(0.0, 0.0, 10.0), 34.0), (point(31.0, 31.0, 10.0), 3.0)]),
        ("ring", ring(60.0, 8.0, 96, 24), vec![(point(0.0, 0.0, 0.0), 40.0)]),
        ("fine ring", ring(60.0, 8.0, 600, 40), vec![(point(0.0, 0.0, 0.0), 40.0)]),
        ("leaning ring", turned(&ring(60.0, 8.0, 96, 24), lean), vec![(point(0.0, 0.0, 0.0), 30.0)]),
        // two posts on a plate, as of a trunnion
        (
            "trunnion",
            cells([&[-90.0, -60.0, 60.0, 90.0], &[-40.0, 40.0], &[0.0, 20.0, 120.0]], |p| {
                p.z < 20.0 || p.x.abs() > 60.0
            }),
            vec![(point(0.0, 0.0, 80.0), 50.0)],
        ),
        ("block", cells([&[-5.0, 5.0], &[0.0, 3.0], &[0.0, 4.0]], |_| true), vec![]),
    ];
    for (name, triangles, hollows) in cases {
        let start = Instant::now();
        let pieces = convex_pieces(&triangles).expect(name);
        let took = start.elapsed();
        let pieces = convexes(&pieces);
        let far = uncovered_mm(&triangles, &pieces);
        println!("{name}: {} triangles, {} pieces, {took:?}, uncovered {far:.1e} mm", triangles.len(), pieces.len());
        // gjk's own accuracy
        assert!(far < 1e-4, "{name}: a point of the surface is {far} mm outside all pieces");
        for (at, radius) in hollows {
            assert!(gap(&pieces, at, radius) > 0.0, "{name}: the hollow at {at:?} is filled");
        }
        assert!(name != "block" || pieces.len() == 1);
    }
}

#[test]
fn pieces_of_plates_are_the_plates() {
    // volumes of the hulls must be the volume of the thing: nothing filled where cuts can follow the walls
    let volume = |solids: &[Solid]| -> f64 {
        solids
            .iter()
            .map(|solid| match solid {
                Solid::Hull { corners } => {
                    let (low, high) =
                        corners.iter().fold((corners[0], corners[0]), |(low, high), c| (low.inf(c), high.sup(c)));
                    (high - low).product()
                }
                _ => panic!("a mesh becomes hulls"),
            })
            .sum()
    };
    let near = |found: f64, due: f64| (found - due).abs() < 1e-3 * due;
    assert!(near(volume(&convex_pieces(&channel()).unwrap()), 100.0 * 100.0 * 10.0 + 2.0 * 100.0 * 10.0 * 30.0));
    assert!(near(volume(&convex_pieces(&frame()).unwrap()), 20.0 * (100.0 * 100.0 - 80.0 * 80.0)));
}

#[test]
fn the_largest_mesh_is_cut_in_reasonable_time_and_keeps_few_corners() {
    let triangles = ring(60.0, 8.0, 1000, 99);
    assert_eq!(triangles.len(), 198_000);
    let start = Instant::now();
    let pieces = convex_pieces(&triangles).expect("closed");
    println!("{} triangles: {} pieces in {:?}", triangles.len(), pieces.len(), start.elapsed());
    for piece in &pieces {
        let Solid::Hull { corners } = piece else { panic!("a mesh becomes hulls") };
        assert!(corners.len() <= fiveaxis::bodies::MAX_CORNERS);
    }
    let pieces = convexes(&pieces);
    assert!(uncovered_mm(&triangles, &pieces) < 1e-4);
    assert!(gap(&pieces, Vector3::zeros(), 40.0) > 0.0);
}

fn text_stl(triangles: &[Triangle]) -> Vec<u8> {
    let mut text = String::from("solid part\n");
    for t in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for p in t {
            writeln!(text, "vertex {} {} {}", p.x, p.y, p.z).unwrap();
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid part\n");
    text.into_bytes()
}

fn binary_stl(triangles: &[Triangle]) -> Vec<u8> {
    // the head starts as some writers' do, with the word of the other form
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0u8; 12]);
        for value in t.iter().flat_map(|p| p.iter()) {
            bytes.extend((*value as f32).to_le_bytes());
        }
        bytes.extend([0u8; 2]);
    }
    bytes
}

fn obj(triangles: &[Triangle]) -> Vec<u8> {
    let mut text = String::from("# part\no part\n");
    for p in triangles.iter().flatten() {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for k in 0..triangles.len() {
        // places from the front with texture and normal, and from the back
        match k % 2 {
            0 => writeln!(text, "f {}/1/1 {}//1 {}", 3 * k + 1, 3 * k + 2, 3 * k + 3).unwrap(),
            _ => {
                let back = |n: usize| (3 * k + n) as i64 - 3 * triangles.len() as i64;
                writeln!(text, "f {} {} {}", back(0), back(1), back(2)).unwrap();
            }
        }
    }
    text.into_bytes()
}

#[test]
fn stl_of_both_kinds_and_obj_give_the_same_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let triangles = channel();
    let corners_of = |name: &str, bytes: &[u8]| -> BTreeSet<String> {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let machine = format!(
            "name: mill\ncode: \"[wCAbYXZt]\"\naxes: {{X: {{range: [-300, 300]}}}}\nbodies:\n  - {{name: part, link: b, mesh: {{file: {name}, scale: 2, at: [0, 0, 5], turned: [0, 0, 90]}}}}\n"
        );
        let file = folder.path().join("machine.yaml");
        std::fs::write(&file, machine).unwrap();
        let (_, bodies) = load_machine_and_bodies(Path::new(&file)).expect(name);
        assert_eq!(bodies.bodies.len(), 1, "{name}: a mesh is one body");
        let body = &bodies.bodies[0];
        assert_eq!(body.solids.len(), 3, "{name}");
        let corners = body.solids.iter().flat_map(|solid| match solid {
            Solid::Hull { corners } => corners.clone(),
            _ => panic!("a mesh becomes hulls"),
        });
        corners.map(|c| format!("{:.3?}", body.at.point(&c).map(|v| v + 0.0).as_slice())).collect()
    };
    let found = corners_of("a.stl", &text_stl(&triangles));
    // the channel's outer corner (50, 50, 40), doubled, a quarter turn about z, lifted by 5
    assert!(found.contains("[-100.000, 100.000, 85.000]"), "{found:?}");
    assert_eq!(found, corners_of("b.stl", &binary_stl(&triangles)));
    assert_eq!(found, corners_of("c.obj", &obj(&triangles)));
}

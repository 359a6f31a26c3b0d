//! Collision geometry of robot descriptions: the clearances of the read bodies against a kinematics of the test's own.

use std::path::Path;

use fiveaxis::chain::Chain;
use fiveaxis::collision::{Scratch, World};
use fiveaxis::load::{LinkChoice, load_machine_and_bodies, load_machine_and_bodies_with_links};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Everything of the bed on one side, one ball behind two joints on the other: each clearance is ball against one solid.
const ARM: &str = r#"<robot name="arm">
  <link name="floor">
    <collision name="SHAPE"><origin xyz="0.2 -0.1 0.05" rpy="0.3 -0.4 0.5"/><geometry>GEOMETRY</geometry></collision>
  </link>
  <link name="base"/><link name="upper"/><link name="fore"/><link name="tool"/>
  <joint name="feet" type="fixed"><parent link="floor"/><child link="base"/><origin xyz="0.01 0.02 0.03" rpy="0 0 0.2"/></joint>
  <joint name="J1" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0.1 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="0" velocity="1"/></joint>
  <joint name="J2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.05 0 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="1"/></joint>
  <joint name="wrist" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0.25 0 0" rpy="0 0.7 0"/></joint>
  <link name="probe"><collision><origin xyz="0 0.01 0.02"/><geometry><sphere radius="0.015"/></geometry></collision></link>
  <joint name="stylus" type="fixed"><parent link="tool"/><child link="probe"/><origin xyz="0.1 0 0"/></joint>
</robot>"#;

fn frame(xyz: [f64; 3], rpy: [f64; 3]) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rpy[2])
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), rpy[1])
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), rpy[0]);
    Isometry3::from_parts(Translation3::new(xyz[0], xyz[1], xyz[2]), turn)
}

fn turn(axis: Vector3<f64>, angle: f64) -> Isometry3<f64> {
    Isometry3::rotation(axis * angle)
}

/// The ball's centre in the frame of the collision element, m.
fn ball_in_shape(q: [f64; 2]) -> Vector3<f64> {
    let floor_from_base = frame([0.01, 0.02, 0.03], [0.0, 0.0, 0.2]);
    let upper = floor_from_base * frame([0.0, 0.0, 0.3], [0.1, 0.0, 0.0]) * turn(Vector3::z(), q[0]);
    let fore = upper * frame([0.05, 0.0, 0.1], [0.0; 3]) * turn(Vector3::y(), q[1]);
    let tool = fore * frame([0.25, 0.0, 0.0], [0.0, 0.7, 0.0]);
    let ball = tool * frame([0.1, 0.0, 0.0], [0.0; 3]) * Point3::new(0.0, 0.01, 0.02);
    let shape = frame([0.2, -0.1, 0.05], [0.3, -0.4, 0.5]);
    (shape.inverse() * ball).coords
}

fn box_distance(p: Vector3<f64>, low: Vector3<f64>, high: Vector3<f64>) -> f64 {
    (low - p).sup(&(p - high)).sup(&Vector3::zeros()).norm()
}

/// A box from `low` to `high` as a text STL.
fn box_stl(low: [f64; 3], high: [f64; 3]) -> String {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|d| if k >> d & 1 == 0 { low[d] } else { high[d] }) };
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let mut text = String::from("solid box\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text.push_str("facet normal 0 0 0\nouter loop\n");
            for k in triangle {
                let [x, y, z] = corner(k);
                text.push_str(&format!("vertex {x} {y} {z}\n"));
            }
            text.push_str("endloop\nendfacet\n");
        }
    }
    text + "endsolid box\n"
}

fn arm(shape: &str, geometry: &str) -> String {
    ARM.replace("SHAPE", shape).replace("GEOMETRY", geometry)
}

#[test]
fn clearances_are_those_of_the_description() {
    let folder = tempfile::tempdir().unwrap();
    // in mm, off its origin: the scale and the place both count
    std::fs::write(folder.path().join("block.stl"), box_stl([10.0, -20.0, 0.0], [90.0, 40.0, 25.0])).unwrap();
    type Distance = fn(Vector3<f64>) -> f64;
    let cases: [(&str, &str, Distance); 5] = [
        ("box", r#"<box size="0.1 0.2 0.04"/>"#, |p| {
            let half = Vector3::new(0.05, 0.1, 0.02);
            box_distance(p, -half, half)
        }),
        ("cylinder", r#"<cylinder radius="0.06" length="0.18"/>"#, |p| {
            (p.xy().norm() - 0.06).max(0.0).hypot((p.z.abs() - 0.09).max(0.0))
        }),
        ("sphere", r#"<sphere radius="0.07"/>"#, |p| p.norm() - 0.07),
        ("capsule", r#"<capsule radius="0.05" length="0.12"/>"#, |p| {
            Vector3::new(p.x, p.y, (p.z.abs() - 0.06).max(0.0)).norm() - 0.05
        }),
        ("mesh", r#"<mesh filename="block.stl" scale="0.001 0.001 0.002"/>"#, |p| {
            box_distance(p, Vector3::new(0.01, -0.02, 0.0), Vector3::new(0.09, 0.04, 0.05))
        }),
    ];
    let seed = 21;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for root in [None, Some("base")] {
        for (name, geometry, distance) in &cases {
            let file = folder.path().join("arm.urdf");
            std::fs::write(&file, arm(name, geometry)).unwrap();
            let links = LinkChoice { root: root.map(String::from), ..LinkChoice::default() };
            let (machine, bodies) = load_machine_and_bodies_with_links(Path::new(&file), &links).expect(name);
            let carriers: Vec<_> = bodies.bodies.iter().map(|b| (b.name.as_str(), b.link.as_str())).collect();
            assert_eq!(carriers, [(*name, "b"), ("probe", "J2")]);
            let world = World::new(&Chain::of(&machine), &bodies).expect("links");
            let scene = world.scene();
            let mut scratch = Scratch::default();
            let (mut seen, mut worst) = (0, 0.0f64);
            for _ in 0..200 {
                let q = [random.random_range(-3.0..3.0), random.random_range(-2.0..2.0)];
                let due = (distance(ball_in_shape(q)) - 0.015) * 1e3;
                if due < 0.1 {
                    continue;
                }
                seen += 1;
                worst = worst.max((scene.clearance(&q, &mut scratch).mm - due).abs());
            }
            println!("{name}, bed {root:?}: {seen} poses, at most {worst:.1e} mm off");
            assert!(seen > 100 && worst < 1e-4, "{name}: {worst} mm over {seen} poses");
        }
    }
}

#[test]
fn solids_of_a_link_of_neither_branch_hang_on_the_nearest_axis_and_visuals_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("arm.urdf");
    let more = r#"<link name="finger"><visual><geometry><box size="9 9 9"/></geometry></visual>
        <collision><geometry><box size="0.01 0.01 0.05"/></geometry></collision></link>
        <joint name="grip" type="prismatic"><parent link="tool"/><child link="finger"/><origin xyz="0 0 0.03"/>
        <axis xyz="1 0 0"/><limit lower="0" upper="0.02" effort="0" velocity="1"/></joint></robot>"#;
    std::fs::write(&file, arm("box", r#"<box size="0.1 0.2 0.04"/>"#).replace("</robot>", more)).unwrap();
    let (_, bodies) = load_machine_and_bodies(&file).unwrap();
    let finger = bodies.bodies.iter().find(|body| body.name == "finger").expect("finger");
    assert_eq!(finger.link, "J2");
    let floor = frame([0.01, 0.02, 0.03], [0.0, 0.0, 0.2]) * frame([0.0, 0.0, 0.3], [0.1, 0.0, 0.0]);
    let tool = floor * frame([0.05, 0.0, 0.1], [0.0; 3]) * frame([0.25, 0.0, 0.0], [0.0, 0.7, 0.0]);
    let due = (tool * Point3::new(0.0, 0.0, 0.03)).coords * 1e3;
    assert!((finger.at.translation_mm - due).norm() < 1e-6, "{:?}", finger.at);
}

/// What CAD tools export beside the joints: drawings that are not there, masses, package addresses, a gripper that mimics.
const EXPORTED: &str = r#"<robot name="arm">
  <link name="base"><inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="package://arm_description/meshes/base.dae"/></geometry></visual>
    <collision><geometry><mesh filename="package://arm_description/meshes/base.stl"/></geometry></collision></link>
  <link name="upper"/><link name="tool"/><link name="left"/><link name="right"/>
  <joint name="J1" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="0" velocity="1"/></joint>
  <joint name="J2" type="revolute"><parent link="upper"/><child link="tool"/><origin xyz="0.3 0 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="1"/></joint>
  <joint name="grip" type="prismatic"><parent link="tool"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.02" effort="0" velocity="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="tool"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.02" effort="0" velocity="1"/><mimic joint="grip"/></joint>
</robot>"#;

#[test]
fn what_cad_tools_export_is_read() {
    let scratch = tempfile::tempdir().expect("a folder");
    let file = scratch.path().join("arm.urdf");
    std::fs::create_dir(scratch.path().join("meshes")).expect("a folder");
    std::fs::write(scratch.path().join("meshes/base.stl"), box_stl([-0.1; 3], [0.1; 3])).expect("written");
    std::fs::write(&file, EXPORTED).expect("written");
    let (machine, bodies) = load_machine_and_bodies(&file).expect("it is read");
    assert_eq!(machine.code.to_string(), "[w, b, J1, J2, t]");
    assert_eq!(bodies.bodies.len(), 1);
    // between workpiece and tool a joint moves by itself
    let follows = EXPORTED.replace(
        r#"velocity="1"/></joint>
  <joint name="J2""#,
        r#"velocity="1"/><mimic joint="J2"/></joint>
  <joint name="J2""#,
    );
    std::fs::write(&file, follows).expect("written");
    let refusal = load_machine_and_bodies(&file).expect_err("refused").to_string();
    assert!(refusal.contains("joint 'J1' mimics another"), "{refusal}");
}

//! Robot descriptions become machines: the shipped arm's chain against its published table, folding, link names, ends.

use crate::shipped;
use std::path::Path;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::load::{LinkChoice, load_machine, load_machine_and_bodies, machine_from_urdf, machine_from_yaml};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::report::machine_yaml;
use nalgebra::Vector3;

fn read(text: &str, choice: &LinkChoice) -> Machine {
    machine_from_urdf(Path::new("robot.urdf"), text, choice).unwrap_or_else(|why| panic!("{why}"))
}

#[test]
fn irb120_has_the_published_chain() {
    let machine = load_machine(&Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/irb120.urdf")).unwrap();
    // joint, direction, point on the axis (mm), range (deg)
    let due = [
        ("J1", [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-165.0, 165.0]),
        ("J2", [0.0, 1.0, 0.0], [0.0, 0.0, 290.0], [-110.0, 110.0]),
        ("J3", [0.0, 1.0, 0.0], [0.0, 0.0, 560.0], [-110.0, 70.0]),
        ("J4", [1.0, 0.0, 0.0], [0.0, 0.0, 630.0], [-160.0, 160.0]),
        ("J5", [0.0, 1.0, 0.0], [302.0, 0.0, 630.0], [-120.0, 120.0]),
        ("J6", [1.0, 0.0, 0.0], [374.0, 0.0, 630.0], [-400.0, 400.0]),
    ];
    assert_eq!(machine.code.to_string(), "[w, b, J1, J2, J3, J4, J5, J6, t]");
    assert_eq!(machine.axes.len(), due.len());
    for (axis, (name, direction, origin, range)) in machine.axes.iter().zip(due) {
        assert_eq!((axis.name.as_str(), axis.kind), (name, AxisKind::Rotary));
        assert_eq!(axis.direction, Vector3::from(direction), "{name}");
        assert_eq!(axis.origin, Vector3::from(origin), "{name}");
        let (from, to) = axis.range.unwrap();
        assert_eq!([from, to], range.map(f64::to_radians), "{name}");
    }
    let chain = Chain::of(&machine);
    assert_eq!(chain.link("tool0"), chain.link("J6"));
    assert_eq!(chain.link("base_link"), chain.link("b"));
    let read = machine_from_yaml(Path::new("written.yaml"), machine_yaml(&machine)).unwrap();
    assert_eq!(read, machine);
}

/// A trunnion mill: x and a tilting table on the workpiece side, z on the tool side, frames turned along the way.
const MILL: &str = r#"<robot name="mill">
  <link name="world"/><link name="frame"/><link name="slide"/><link name="cradle"/><link name="table"/>
  <link name="column"/><link name="quill"/><link name="spindle"/><link name="lamp"/>
  <joint name="feet" type="fixed"><parent link="world"/><child link="frame"/><origin xyz="1 2 3" rpy="0 0 1.5708"/></joint>
  <joint name="X" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0 0 0.5" rpy="0 0 -1.5708"/>
    <axis xyz="0 2 0"/><limit lower="-0.2" upper="0.3" effort="0" velocity="1"/></joint>
  <joint name="A" type="revolute"><parent link="slide"/><child link="cradle"/><origin xyz="0.1 0 0.05" rpy="0 1.5708 0"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="1"/></joint>
  <joint name="plate" type="fixed"><parent link="cradle"/><child link="table"/><origin xyz="0 0 0.02"/></joint>
  <joint name="post" type="fixed"><parent link="frame"/><child link="column"/><origin xyz="0 0.4 0"/></joint>
  <joint name="Z" type="prismatic"><parent link="column"/><child link="quill"/><axis xyz="0 0 1"/>
    <limit lower="-0.1" upper="0.4" effort="0" velocity="1"/></joint>
  <joint name="C" type="continuous"><parent link="quill"/><child link="spindle"/><axis xyz="0 0 -1"/></joint>
  <joint name="shade" type="revolute"><parent link="frame"/><child link="lamp"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="0" velocity="1"/></joint>
</robot>"#;

#[test]
fn fixed_joints_fold_and_the_code_follows_the_tree() {
    let choice = LinkChoice { root: Some("frame".into()), ..LinkChoice::default() };
    let machine = read(MILL, &choice);
    assert_eq!(machine.code.to_string(), "[wAXbZCt]");
    let axis = |name: &str| &machine.axes[machine.axis_index(name).unwrap()];
    let unit = |x, y, z| Vector3::new(x, y, z);
    // R is the frame's: X's joint frame is turned by -90° about z, its y is R's x
    assert_eq!(axis("X").direction, unit(1.0, 0.0, 0.0));
    assert_eq!(axis("X").range, Some((-200.0, 300.0)));
    // A's frame: x of the slide is R's -y, then +90° about the slide's y brings its z along the slide's x
    assert_eq!(axis("A").direction, unit(0.0, -1.0, 0.0));
    assert_eq!(axis("A").origin, unit(0.0, -100.0, 550.0));
    assert_eq!(axis("C").direction, unit(0.0, 0.0, -1.0));
    assert_eq!(axis("C").origin, unit(0.0, 400.0, 0.0));
    assert_eq!(axis("C").range, None);
    let carriers: Vec<_> = machine.link_names.iter().map(|(name, axis)| (name.as_str(), *axis)).collect();
    let (a, x) = (machine.axis_index("A"), machine.axis_index("X"));
    assert!(
        carriers.contains(&("table", a)) && carriers.contains(&("slide", x)) && carriers.contains(&("world", None))
    );
    assert!(!carriers.iter().any(|(name, _)| *name == "lamp"), "behind a joint of neither branch");
}

#[test]
fn without_a_named_bed_r_is_the_root_links_frame() {
    let machine = read(MILL, &LinkChoice::default());
    let x = &machine.axes[machine.axis_index("X").unwrap()];
    assert_eq!(x.direction, Vector3::new(0.0, 1.0, 0.0));
    assert_eq!(x.origin, Vector3::new(1000.0, 2000.0, 3500.0));
}

#[test]
fn points_move_as_the_tree_says() {
    let machine = read(MILL, &LinkChoice { root: Some("frame".into()), ..LinkChoice::default() });
    let chain = Chain::of(&machine);
    let mut q = vec![0.0; machine.axes.len()];
    q[machine.axis_index("A").unwrap()] = std::f64::consts::FRAC_PI_2;
    q[machine.axis_index("X").unwrap()] = 10.0;
    let at = Vector3::new(50.0, -100.0, 550.0);
    let moved = Geometry::nominal(&chain).point(chain.link("table").unwrap(), &at, &q, None);
    // 50 mm along x from the A line, a quarter turn about -y brings it up, X carries all by 10 mm
    assert!((moved - Vector3::new(10.0, -100.0, 600.0)).norm() < 1e-12 * 600.0, "{moved}");
}

/// Every location error of a machine drawn: up to 50 µm and 100 arcsec.
fn with_errors(mut machine: Machine, random: &mut rand_chacha::ChaCha8Rng) -> Machine {
    use rand::RngExt;
    for axis in &mut machine.axes {
        // the position error of a slide is its zero
        let is_linear = axis.kind == AxisKind::Linear;
        for (k, error) in axis.location_errors.iter_mut().enumerate() {
            let largest = if k < 3 { 50e-3 } else { 100.0 / 206_265.0 };
            *error = if is_linear && k < 3 { 0.0 } else { random.random_range(-largest..largest) };
        }
    }
    machine
}

#[test]
fn a_machine_with_errors_written_as_a_robot_description_moves_alike() {
    use fiveaxis::chain::{Branch, Composition};
    use fiveaxis::report::urdf::machine_urdf;
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(20_261_123);
    let mut worst = 0.0f64;
    for file in shipped::machine_files() {
        let plain = load_machine(&file).unwrap();
        // degrees and directions of any sense, and every error
        let machine = with_errors(plain, &mut random);
        let text = machine_urdf(&machine);
        let choice =
            LinkChoice { root: Some("bed".into()), workpiece: Some("workpiece".into()), tool: Some("tool".into()) };
        let again =
            machine_from_urdf(Path::new("machine.urdf"), &text, &choice).unwrap_or_else(|why| panic!("{text}\n{why}"));
        let (chain, chain_again) = (Chain::of(&machine), Chain::of(&again));
        let geometry = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
        let nominal = Geometry::nominal(&chain_again);
        for _ in 0..50 {
            let at: Vec<f64> = machine
                .axes
                .iter()
                .map(|axis| {
                    let (low, high) = axis.range.unwrap_or((-3.0, 3.0));
                    random.random_range(low..high)
                })
                .collect();
            let named = |name: &String| at[machine.axis_index(name).unwrap()];
            let at_again: Vec<f64> = again.axes.iter().map(|axis| named(&axis.name)).collect();
            for branch in [Branch::Workpiece, Branch::Tool] {
                let zero = geometry.pose(chain.end(branch), &vec![0.0; at.len()], None);
                let there = geometry.pose(chain.end(branch), &at, None);
                // links of the second machine coincide with R at zero: its points are where the errors put them
                let back = nominal.pose(chain_again.end(branch), &at_again, None);
                for point in [Vector3::zeros(), Vector3::new(150.0, -200.0, 300.0)] {
                    let apart = there.point(&point) - back.point(&zero.point(&point));
                    worst = worst.max(apart.norm());
                }
            }
        }
    }
    println!("farthest apart {worst:.1e} mm");
    // origins are read to 1e-9 mm, up to five joints stand one on the other, and turns carry that on
    assert!(worst < 5e-9, "{worst}");
}

/// A tetrahedron of 0.2 m as a text STL, m.
fn wedge() -> String {
    let corners = ["0 0 0", "0.2 0 0", "0 0.2 0", "0 0 0.2"];
    let facets = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|facet| {
        let vertices: String = facet.map(|corner: usize| format!("vertex {}\n", corners[corner])).concat();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    });
    format!("solid wedge\n{}endsolid wedge\n", facets.concat())
}

/// A description whose one mesh has this name.
fn with_mesh(name: &str) -> String {
    let collision =
        format!("<link name=\"table\"><collision><geometry><mesh filename=\"{name}\"/></geometry></collision></link>");
    MILL.replace("<link name=\"table\"/>", &collision)
}

#[test]
fn meshes_of_a_package_are_found_where_exporters_put_them() {
    let cases = [
        ("mill/urdf/mill.urdf", "mill/meshes/a.stl", "package://mill/meshes/a.stl"),
        ("mill/mill.urdf", "mill/meshes/a.stl", "package://mill/meshes/a.stl"),
        ("mill/robots/new/mill.urdf", "mill/a.stl", "package://mill/a.stl"),
        // beside the description's folder, beside a folder above, in its folder
        ("mill/urdf/mill.urdf", "mill/shapes_of_it/a.stl", "package://shapes_of_it/a.stl"),
        ("mill/urdf/mill.urdf", "shapes_of_it/meshes/a.stl", "package://shapes_of_it/meshes/a.stl"),
        ("mill.urdf", "mill/meshes/a.stl", "package://mill/meshes/a.stl"),
        // another name: beside the description
        ("robot/mill.urdf", "robot/meshes/a.stl", "package://mill/meshes/a.stl"),
        ("mill/urdf/mill.urdf", "mill/meshes/a.stl", "../meshes/a.stl"),
    ];
    for (file, mesh, name) in cases {
        let scratch = tempfile::tempdir().unwrap();
        for (path, text) in [(file, with_mesh(name)), (mesh, wedge())] {
            let path = scratch.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let (_, bodies) =
            load_machine_and_bodies(&scratch.path().join(file)).unwrap_or_else(|why| panic!("{file}: {why}"));
        assert_eq!(bodies.bodies.len(), 1, "{file}");
    }
}

#[cfg(unix)]
#[test]
fn meshes_of_a_package_do_not_leave_it() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |path: &str| scratch.path().join(path);
    for folder in ["far/meshes", "ws/mill/urdf", "ws/mill/meshes", "ws/mill/other"] {
        std::fs::create_dir_all(at(folder)).unwrap();
    }
    std::fs::write(at("far/meshes/a.stl"), wedge()).unwrap();
    std::os::unix::fs::symlink(at("far/meshes/a.stl"), at("ws/mill/meshes/a.stl")).unwrap();
    std::os::unix::fs::symlink(at("far"), at("ws/mill/linked")).unwrap();
    for (name, folder, says) in [
        ("package://mill/meshes/a.stl", "urdf", "is a link out of the file's folder"),
        ("package://linked/meshes/a.stl", "urdf", "is a link out of the file's folder"),
        ("../meshes/a.stl", "urdf", "is a link out of the file's folder"),
        ("../meshes/a.stl", "other", "leaves the file's folder"),
        ("../../far/meshes/a.stl", "urdf", "leaves the file's folder"),
        ("package://mill/../far/meshes/a.stl", "urdf", "leaves the file's folder"),
        ("package://../far/meshes/a.stl", "urdf", "is not there"),
    ] {
        let file = at("ws/mill").join(folder).join("mill.urdf");
        std::fs::write(&file, with_mesh(name)).unwrap();
        let why = load_machine_and_bodies(&file).expect_err(name).to_string();
        assert!(why.contains(says), "{name}: {why}");
    }
}

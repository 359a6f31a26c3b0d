//! Robot descriptions become machines: the shipped arm's chain against its published table, folding, link names, ends.

use crate::shipped;
use std::path::Path;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::load::{LinkChoice, load_machine, machine_from_urdf, machine_from_yaml};
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

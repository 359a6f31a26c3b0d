//! `init`: a data sheet becomes a machine file that loads, stands clear and plans; what a sheet cannot say is refused in words.

use std::path::Path;
use std::process::{Command, Output};

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::collision::World;
use fiveaxis::load::{load_kit, load_machine_and_bodies};
use fiveaxis::machine::AxisKind;
use fiveaxis::plan::{Settings, plan};

fn init(folder: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(folder)
        .args(["init", "mill.yaml"])
        .args(options)
        .output()
        .expect("the program runs")
}

/// Table 1.1's codes and those of Fig. 1.1, with the C600U's.
const CODES: [&str; 15] = [
    "[wCAXYbZt]",
    "[wCBXYbZt]",
    "[wCAYXbZt]",
    "[wCBYXbZt]",
    "[wCXYbZAt]",
    "[wCXYbZBt]",
    "[wXYbZCAt]",
    "[wXYbZCBt]",
    "[wXYbZABt]",
    "[wXYbZBAt]",
    "[wXbYZCBt]",
    "[wCXbYZAt]",
    "[wCAYbXZt]",
    "[wCAbYXZt]",
    "[wAbXYZCt]",
];

fn options(code: &str) -> Vec<String> {
    let mut list: Vec<String> = [
        "--travels",
        "650,520,475",
        "--nose-to-table",
        "120..595",
        "--table",
        "400",
        "--directions",
        "iso841",
        "--code",
        code,
    ]
    .map(str::to_string)
    .to_vec();
    let (table, head) = code.split_once('b').expect("a bed");
    if table.contains(['A', 'B']) {
        list.extend(["--tilt-above-table".into(), "-60".into()]);
    }
    if head.contains(['A', 'B']) {
        list.extend(["--pivot-to-nose".into(), "220".into()]);
    }
    list
}

#[test]
fn every_code_gives_a_file_that_loads_and_whose_bodies_stand_clear_at_zero() {
    for code in CODES {
        let scratch = tempfile::tempdir().expect("a folder");
        let given = options(code);
        let words: Vec<&str> = given.iter().map(String::as_str).collect();
        let output = init(scratch.path(), &words);
        assert!(output.status.success(), "{code}: {}", String::from_utf8_lossy(&output.stderr));
        let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect(code);
        assert_eq!(machine.code.to_string(), code);
        let world = World::new(&Chain::of(&machine), &bodies).expect(code);
        assert_eq!(world.meetings_at_zero(&machine), vec![], "{code}");
        // nose to table as the sheet says, at both ends of Z's travel
        let table = bodies.mounts[0].middle.z;
        let z = &machine.axes[machine.axis_index("Z").expect("Z")];
        let (low, high) = z.range.expect("a range");
        let nose = machine.spindle.as_ref().expect("a spindle").nose.z;
        assert!((nose - table + low - 120.0).abs() < 1e-9 && (nose - table + high - 595.0).abs() < 1e-9, "{code}");
        let tilting = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary && axis.name != "C");
        for axis in tilting {
            let is_on_table = machine.code.workpiece_side.contains(&axis.name);
            let height = if is_on_table { axis.origin.z - table } else { axis.origin.z - nose };
            assert!((height - if is_on_table { -60.0 } else { 220.0 }).abs() < 1e-9, "{code}");
        }
    }
}

/// Holds that a plan of the machine of these options determines its eight location errors.
fn all_eight_determined(given: &[String]) {
    let scratch = tempfile::tempdir().expect("a folder");
    let words: Vec<&str> = given.iter().map(String::as_str).collect();
    assert!(init(scratch.path(), &words).status.success());
    let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("the kit");
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("a plan");
    assert_eq!(found.errors.iter().filter(|error| error.determined).count(), 8);
}

#[test]
fn a_trunnion_mill_from_its_sheet_is_planned_with_all_eight_errors() {
    all_eight_determined(&options("[wCAXbYZt]"));
}

#[test]
fn what_a_sheet_cannot_say_is_refused_and_writes_nothing() {
    let good = ["--travels", "650,520,475", "--nose-to-table", "110..585", "--table", "320", "--directions", "iso841"];
    for (extra, says) in [
        (vec!["--code", "[wCAXbYZt]"], "--tilt-above-table is missing"),
        (vec!["--code", "[wXbYZCBt]"], "--pivot-to-nose is missing"),
        (vec!["--code", "[wCAXbYt]", "--tilt-above-table", "0"], "X, Y, Z and two of A, B, C"),
        (vec!["--code", "[wQAXbYt]"], "no axis"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "B=-20..20"], "has no axis 'B'"),
        (
            vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "A=-1.92..1.92"],
            "is 3.840 deg wide; a rotary axis turns by 10 deg at least",
        ),
        (
            vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "A=-90..90", "--range", "A=-20..90"],
            "'A' stands twice",
        ),
        (
            vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--pivot-to-nose", "200"],
            "the head of [wCAXbYZt] has no axis that tilts",
        ),
        (
            vec!["--code", "[wXbYZCBt]", "--pivot-to-nose", "-220"],
            "the tilting axis of the head is -220 mm above the nose",
        ),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--name", "a\u{1b}b"], "a control character"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "A=30..-120"], "runs backwards"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "nan"], "tilting axis above the table"),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "B=0"],
            "--inclined: 0 deg from the vertical is no inclined axis; allowed are 5 to 85 deg to either side",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "B=90"],
            "--inclined: 90 deg from the vertical is no inclined axis",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "B=-0.7854"],
            "were -0.7854 radians, it would be -45.0 deg",
        ),
        (vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "B=nan"], "'nan' is no number"),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "A=45"],
            "--inclined: 'A' cannot be the inclined axis of [wCBYbXZt]; allowed is the axis that tilts, B",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "C=45"],
            "'C' cannot be the inclined axis",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "B=45,XY"],
            "--inclined: the plane is 'XY'; allowed are YZ and ZX",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--tilt-above-table", "90", "--inclined", "45"],
            "--inclined: '45' is not understood; write AXIS=ANGLE or AXIS=ANGLE,PLANE",
        ),
        (
            vec!["--code", "[wCBYbXZt]", "--inclined", "B=-45"],
            "--tilt-above-table is missing: Point where the inclined axis crosses the vertical",
        ),
    ] {
        let scratch = tempfile::tempdir().expect("a folder");
        let output = init(scratch.path(), &[&good[..], &extra].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{extra:?}: {message}");
        assert!(message.contains(says), "{extra:?}: {message}");
        assert!(!scratch.path().join("mill.yaml").exists());
    }
    let scratch = tempfile::tempdir().expect("a folder");
    let wrong = ["--travels", "650,520,600", "--nose-to-table", "110..585", "--table", "320", "--directions", "iso841"];
    let output = init(scratch.path(), &[&wrong[..], &["--code", "[wXbYZCBt]", "--pivot-to-nose", "200"]].concat());
    assert!(String::from_utf8_lossy(&output.stderr).contains("which is a travel of 475 mm"));
}

#[test]
fn a_file_that_someone_wrote_is_kept() {
    let scratch = tempfile::tempdir().expect("a folder");
    std::fs::write(scratch.path().join("mill.yaml"), "mine").expect("written");
    let given = options("[wCAXbYZt]");
    let words: Vec<&str> = given.iter().map(String::as_str).collect();
    assert_eq!(init(scratch.path(), &words).status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(scratch.path().join("mill.yaml")).expect("still there"), "mine");
}

/// A trunnion mill as a CAD tool writes it: joints with names of their own, meshes by package, some only drawn and missing,
/// masses, a mimic joint beside the chain.
const DESCRIPTION: &str = r#"<?xml version="1.0"?>
<robot name="trunnion_mill">
  <link name="base_link">
    <inertial><origin xyz="0 0 0.2"/><mass value="900"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="package://mill_description/meshes/not_exported.stl"/></geometry></visual>
    <collision><geometry><mesh filename="package://mill_description/meshes/base_link.STL"/></geometry></collision>
  </link>
  <link name="y_carriage">
    <collision name="carriage"><origin xyz="0 0 -0.045"/><geometry><box size="0.72 0.5 0.1"/></geometry></collision>
    <collision name="post left"><origin xyz="-0.33 0 0.165"/><geometry><box size="0.06 0.15 0.32"/></geometry></collision>
    <collision name="post right"><origin xyz="0.33 0 0.165"/><geometry><box size="0.06 0.15 0.32"/></geometry></collision>
  </link>
  <link name="cradle"><collision><origin xyz="0 0 -0.02"/><geometry><box size="0.5 0.3 0.05"/></geometry></collision></link>
  <link name="table_link"><collision><origin xyz="0 0 0.03"/><geometry><cylinder radius="0.16" length="0.06"/></geometry></collision></link>
  <link name="x_slide"><collision><geometry><box size="0.3 0.15 0.4"/></geometry></collision></link>
  <link name="ram"><collision><origin xyz="0 0.25 0.1"/><geometry><box size="0.2 0.285 0.5"/></geometry></collision></link>
  <link name="spindle"><collision><origin xyz="0 0 -0.14"/><geometry><cylinder radius="0.06" length="0.28"/></geometry></collision></link>
  <link name="chain_link"/>
  <joint name="Y_axis_joint" type="prismatic"><parent link="base_link"/><child link="y_carriage"/><origin xyz="0 0 0.5"/>
    <axis xyz="0 1 0"/><limit lower="-0.15" upper="0.15" effort="1" velocity="1"/></joint>
  <joint name="tilt_joint" type="revolute"><parent link="y_carriage"/><child link="cradle"/><origin xyz="0 0 0.25"/>
    <axis xyz="1 0 0"/><limit lower="-1.9198621772" upper="0.6108652382" effort="1" velocity="1"/></joint>
  <joint name="rotary_table_joint" type="continuous"><parent link="cradle"/><child link="table_link"/><origin xyz="0 0 0.01"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="X_axis_joint" type="prismatic"><parent link="base_link"/><child link="x_slide"/><origin xyz="0 0.475 1.4"/>
    <axis xyz="1 0 0"/><limit lower="-0.25" upper="0.25" effort="1" velocity="1"/></joint>
  <joint name="Z_axis_joint" type="prismatic"><parent link="x_slide"/><child link="ram"/><origin xyz="0 -0.475 0"/>
    <axis xyz="0 0 1"/><limit lower="-0.2" upper="0.2" effort="1" velocity="1"/></joint>
  <joint name="spindle_mount" type="fixed"><parent link="ram"/><child link="spindle"/><origin xyz="0 0 -0.23" rpy="3.14159265 0 0"/></joint>
  <joint name="drag_chain" type="revolute"><parent link="base_link"/><child link="chain_link"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="Y_axis_joint" multiplier="0.5"/></joint>
</robot>"#;

/// A box from `low` to `high` as a text STL, m.
fn box_stl(low: [f64; 3], high: [f64; 3]) -> String {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|d| if k >> d & 1 == 0 { low[d] } else { high[d] }) };
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let facets: String = triangles
        .map(|triangle| {
            let vertices: String =
                triangle.map(corner).iter().map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).collect();
            format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        })
        .collect();
    format!("solid base\n{facets}endsolid base\n")
}

/// Folder with the description and its one mesh.
fn described() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    std::fs::write(folder.path().join("meshes/base_link.STL"), box_stl([-0.5, -0.5, 0.0], [0.5, 0.5, 0.4])).unwrap();
    std::fs::write(folder.path().join("mill.urdf"), DESCRIPTION).unwrap();
    folder
}

#[test]
fn a_robot_description_becomes_a_file_that_plans() {
    let folder = described();
    let output = init(folder.path(), &["--urdf", "mill.urdf"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (machine, bodies) = load_machine_and_bodies(&folder.path().join("mill.yaml")).unwrap();
    assert_eq!(machine.code.to_string(), "[wCAYbXZt]");
    // seen from the description: table top 820 mm up, tilting axis 750 mm, nose 1170 mm, all over each other
    let mount = &bodies.mounts[0];
    assert_eq!((mount.link.as_str(), mount.middle.as_slice()), ("C", [0.0, 0.0, 820.0].as_slice()));
    let spindle = machine.spindle.as_ref().unwrap();
    assert!((spindle.nose - nalgebra::Vector3::new(0.0, 0.0, 1170.0)).norm() < 1e-3, "{:?}", spindle.nose);
    assert!((spindle.direction - nalgebra::Vector3::z()).norm() < 1e-6, "{:?}", spindle.direction);
    let axis = |name: &str| &machine.axes[machine.axis_index(name).unwrap()];
    assert!((axis("A").origin.z - 750.0).abs() < 1e-9);
    let degrees = axis("A").range.map(|(low, high)| [low.to_degrees(), high.to_degrees()]).unwrap();
    assert!((degrees[0] + 110.0).abs() < 1e-3 && (degrees[1] - 35.0).abs() < 1e-3, "{degrees:?}");
    assert_eq!(axis("Y").range, Some((-150.0, 150.0)));
    // a file that is plain to read, and a plan of it at once
    let planned = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(folder.path())
        .args(["plan", "mill.yaml", "--out", "setups", "--json"])
        .output()
        .unwrap();
    assert!(planned.status.success(), "{}", String::from_utf8_lossy(&planned.stderr));
    let plan: serde_json::Value = serde_json::from_slice(&planned.stdout).unwrap();
    let determined =
        plan["location_errors"].as_object().unwrap().values().filter(|error| error["determined"] == true).count();
    assert!(determined >= 6, "{plan}");
    assert!(folder.path().join("setups/session.yaml").is_file());
}

#[test]
fn descriptions_without_geometry_take_boxes_and_others_are_refused() {
    let folder = described();
    let file = folder.path().join("mill.urdf");
    // what is only a skeleton
    let bare: String = DESCRIPTION
        .split("<collision")
        .enumerate()
        .map(|(k, part)| if k == 0 { part.to_string() } else { part.split_once("</collision>").unwrap().1.to_string() })
        .collect();
    std::fs::write(&file, &bare).unwrap();
    let refused = init(folder.path(), &["--urdf", "mill.urdf"]);
    assert_eq!(refused.status.code(), Some(2));
    let says = String::from_utf8_lossy(&refused.stderr);
    assert!(
        says.contains("has no collision geometry with a surface of 80 mm; say the table's size with --table"),
        "{says}"
    );
    let taken = init(folder.path(), &["--urdf", "mill.urdf", "--table", "320"]);
    assert!(taken.status.success(), "{}", String::from_utf8_lossy(&taken.stderr));
    let (machine, bodies) = load_machine_and_bodies(&folder.path().join("mill.yaml")).unwrap();
    let names: Vec<&str> = bodies.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["work table", "spindle housing"]);
    let found = plan(&machine, &bodies, &fiveaxis::load::standard_kit().unwrap(), &Settings::default()).unwrap();
    assert!(!found.tests.is_empty());
    // two joints of one letter
    std::fs::write(
        &file,
        DESCRIPTION.replace("<axis xyz=\"1 0 0\"/><limit lower=\"-1.9", "<axis xyz=\"0 0 1\"/><limit lower=\"-1.9"),
    )
    .unwrap();
    let refused = init(folder.path(), &["--urdf", "mill.urdf", "--force"]);
    let says = String::from_utf8_lossy(&refused.stderr);
    assert!(
        refused.status.code() == Some(2)
            && says.contains(
                "joints 'rotary_table_joint' and 'tilt_joint' would both be C; call one of them by another of A, B, C"
            ),
        "{says}"
    );
}

/// Options with another table and tilt.
fn trunnion(code: &str, table: &str, tilt: &str) -> Vec<String> {
    let words = "--travels 650,520,475 --nose-to-table 150..625 --directions iso841 --range C=-360..360 --range";
    let letter = if code.contains('A') { "A=-110..35" } else { "B=-35..110" };
    let more = [letter, "--code", code, "--table", table, "--tilt-above-table", tilt];
    words.split_whitespace().chain(more).map(str::to_string).collect()
}

#[test]
fn no_table_reaches_the_arms_of_its_cradle_as_it_turns() {
    for code in ["[wCBYbXZt]", "[wCAYbXZt]", "[wCBXbYZt]"] {
        for table in ["630x500", "500x500", "320x320", "400x700", "500"] {
            for tilt in ["-120", "-60", "0", "50"] {
                let scratch = tempfile::tempdir().expect("a folder");
                let given = trunnion(code, table, tilt);
                let words: Vec<&str> = given.iter().map(String::as_str).collect();
                let output = init(scratch.path(), &words);
                assert!(output.status.success(), "{code}: {}", String::from_utf8_lossy(&output.stderr));
                let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect(code);
                let world = World::new(&Chain::of(&machine), &bodies).expect(code);
                assert_eq!(world.meetings_at_zero(&machine), vec![], "{code} {table} {tilt}");
                assert_eq!(world.meetings_by_one_axis(&machine), vec![], "{code} {table} {tilt}");
            }
        }
    }
}

#[test]
fn a_rectangular_table_on_a_cradle_is_planned_with_all_eight_errors() {
    all_eight_determined(&trunnion("[wCBYbXZt]", "630x500", "0"));
}

/// Options of a machine whose axis is inclined, with the axis that `inclined` names.
fn swivelling(code: &str, inclined: &str) -> Vec<String> {
    let mut list = options(code);
    list.extend(["--inclined".into(), inclined.into()]);
    list
}

/// Codes with an inclined axis at every place where one can be, with both planes and both sides.
const INCLINED: [(&str, &str); 16] = [
    ("[wCBYbXZt]", "B=-45"),
    ("[wCBYbXZt]", "B=45,YZ"),
    ("[wCBYbXZt]", "B=-45,ZX"),
    ("[wCAXbYZt]", "A=-30"),
    ("[wCAbYXZt]", "A=60,YZ"),
    ("[wCBXbYZt]", "B=-8"),
    ("[wCXbYZBt]", "B=45"),
    ("[wCXbYZBt]", "B=-45"),
    ("[wCXbYZAt]", "A=45"),
    ("[wCXYbZBt]", "B=40,ZX"),
    ("[wXbYZCBt]", "B=45"),
    ("[wXYbZCAt]", "A=-50"),
    ("[wXYbZABt]", "B=45"),
    ("[wABXYbZt]", "B=-45"),
    ("[wBCXYbZt]", "B=-45"),
    ("[wBXbYZAt]", "B=-45"),
];

#[test]
fn inclined_axes_stand_as_the_options_say_and_their_bodies_stand_clear() {
    for (code, inclined) in INCLINED {
        let scratch = tempfile::tempdir().expect("a folder");
        let given = swivelling(code, inclined);
        let words: Vec<&str> = given.iter().map(String::as_str).collect();
        let output = init(scratch.path(), &words);
        assert!(output.status.success(), "{code} {inclined}: {}", String::from_utf8_lossy(&output.stderr));
        let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect(code);
        let (name, rest) = inclined.split_once('=').expect("an axis");
        let (angle, plane) = rest.split_once(',').unwrap_or((rest, if name == "A" { "ZX" } else { "YZ" }));
        let level = if plane == "YZ" { nalgebra::Vector3::y() } else { nalgebra::Vector3::x() };
        let axis = &machine.axes[machine.axis_index(name).expect("the axis")];
        // the upper end leans to the side of the sign, by the angle, in the plane
        let upper = axis.direction * axis.direction.z.signum();
        let angle: f64 = angle.parse().expect("degrees");
        assert!((upper.dot(&level).atan2(upper.z).to_degrees() - angle).abs() < 1e-9, "{code} {inclined}: {upper}");
        assert!(upper.cross(&level).dot(&nalgebra::Vector3::z()).abs() < 1e-12, "{code} {inclined}: {upper}");
        assert!((axis.direction.norm() - 1.0).abs() < 1e-12 && axis.direction.dot(&level) > 0.0, "{code} {inclined}");
        assert_eq!(axis.coordinate_direction(), None, "{code} {inclined}");
        let (low, high) = axis.range.expect("a range");
        assert_eq!([low, high].map(|end| end.to_degrees().round()), [-5.0, 185.0], "{code} {inclined}");
        let world = World::new(&Chain::of(&machine), &bodies).expect(code);
        assert_eq!(world.meetings_at_zero(&machine), vec![], "{code} {inclined}");
        assert_eq!(world.meetings_by_one_axis(&machine), vec![], "{code} {inclined}");
    }
}

#[test]
fn half_a_turn_of_a_45_degree_axis_brings_table_and_spindle_level() {
    for (code, inclined) in [("[wCBYbXZt]", "B=-45"), ("[wCXbYZBt]", "B=45")] {
        let scratch = tempfile::tempdir().expect("a folder");
        let given = swivelling(code, inclined);
        let words: Vec<&str> = given.iter().map(String::as_str).collect();
        assert!(init(scratch.path(), &words).status.success());
        let (machine, _) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
        let chain = Chain::of(&machine);
        let mut at = vec![0.0; machine.axes.len()];
        at[machine.axis_index("B").expect("B")] = std::f64::consts::PI;
        let geometry = Geometry::nominal(&chain);
        let turned = geometry.pose(chain.link("B").expect("B"), &at, None).rotation * nalgebra::Vector3::z();
        // the table faces the operator; the spindle's nose points to him, its back away from him
        let due = if code.contains("CB") { -nalgebra::Vector3::y() } else { nalgebra::Vector3::y() };
        assert!((turned - due).norm() < 1e-9, "{code}: {turned}");
        assert!(machine.spindle.is_some());
    }
}

#[test]
fn swivelling_tables_and_heads_from_their_sheets_are_planned() {
    let all = ["EX0C", "EY0C", "EA0C", "EB0C", "EX0B", "EY0B", "EZ0B", "EA0B", "EB0B", "EC0B"];
    all_told_or_in_sums(&swivelling("[wCBYbXZt]", "B=-45"), &all);
    all_told_or_in_sums(&swivelling("[wCXbYZBt]", "B=45"), &["EA0C", "EB0C", "EA0B", "EB0B", "EC0B"]);
}

/// Holds that `check` takes the machine of these options, and that a plan of it tells some errors, or all, and the others in sums only.
fn all_told_or_in_sums(given: &[String], told: &[&str]) {
    let scratch = tempfile::tempdir().expect("a folder");
    let words: Vec<&str> = given.iter().map(String::as_str).collect();
    assert!(init(scratch.path(), &words).status.success());
    let checked = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(scratch.path())
        .args(["check", "mill.yaml"])
        .output()
        .expect("the program runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("the kit");
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("a plan");
    for error in &found.errors {
        assert_eq!(error.determined, told.contains(&error.name.as_str()), "{given:?} {}: {}", error.name, error.reason);
    }
    for error in found.errors.iter().filter(|error| !error.determined) {
        let why = &error.reason;
        assert!(why.contains("only together with") || why.contains("what moves"), "{given:?} {}: {why}", error.name);
    }
}

#[test]
fn ranges_that_nobody_gave_are_called_assumed() {
    let scratch = tempfile::tempdir().expect("a folder");
    let given = options("[wCAXbYZt]");
    let mut words: Vec<&str> = given.iter().map(String::as_str).collect();
    words.extend(["--range", "A=-120..30"]);
    let output = init(scratch.path(), &words);
    let sentence =
        "range of C, -360 to 360 deg, is ASSUMED: no range was given; check it and write the right one into the file";
    let summary = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(summary.contains(sentence) && !summary.contains("range of A"), "{summary}");
    let (machine, _) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    assert!(machine.caveats.iter().any(|caveat| caveat == sentence), "{:?}", machine.caveats);
    words.extend(["--range", "C=-10..350", "--force", "--json"]);
    let output = init(scratch.path(), &words);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["assumed"], serde_json::json!([]));
    let text = std::fs::read_to_string(scratch.path().join("mill.yaml")).expect("written");
    assert!(!text.contains("is ASSUMED"), "{text}");
}

#[test]
fn one_message_names_all_options_that_are_missing() {
    let scratch = tempfile::tempdir().expect("a folder");
    let says = |options: &[&str]| {
        let output = init(scratch.path(), options);
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let all = ["--code", "--travels", "--nose-to-table", "--table", "--directions"];
    let message = says(&[]);
    for option in all.iter().chain(&["--tilt-above-table", "--pivot-to-nose"]) {
        assert!(message.contains(&format!("{option} is missing")), "{option}: {message}");
    }
    let message = says(&["--kind", "table-head", "--travels", "650,520,475"]);
    assert!(message.contains("--pivot-to-nose is missing") && message.contains("--table is missing"), "{message}");
    assert!(!message.contains("--tilt-above-table") && !message.contains("--travels"), "{message}");
}

#[test]
fn a_description_counted_by_iso_841_moves_as_it_did() {
    let folder = described();
    let read = |extra: &[&str]| {
        let output = init(folder.path(), &[&["--urdf", "mill.urdf", "--force"], extra].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        load_machine_and_bodies(&folder.path().join("mill.yaml")).expect("it loads").0
    };
    let (carried, iso) = (read(&[]), read(&["--directions", "iso841"]));
    assert_eq!(iso.directions.map(|directions| directions.name()), Some("iso841"));
    let range = |machine: &fiveaxis::machine::Machine, name: &str| {
        let (low, high) = machine.axes[machine.axis_index(name).expect(name)].range.expect("a range");
        [low, high]
    };
    // the table's axes count the other way, the spindle's as before
    for (name, sign) in [("A", -1.0), ("C", -1.0), ("Y", -1.0), ("X", 1.0), ("Z", 1.0)] {
        let [low, high] = range(&carried, name);
        let due = if sign < 0.0 { [-high, -low] } else { [low, high] };
        assert_eq!(range(&iso, name), due, "{name}");
    }
    // the same command of each machine's own count brings the tool to the same place over the table
    let at = |machine: &fiveaxis::machine::Machine, turned: f64| {
        let chain = Chain::of(machine);
        let mut q = vec![0.0; machine.axes.len()];
        q[machine.axis_index("A").expect("A")] = turned * 0.3;
        q[machine.axis_index("X").expect("X")] = 20.0;
        let point = nalgebra::Vector3::new(50.0, 60.0, 820.0);
        Geometry::nominal(&chain).point(chain.link("C").expect("C"), &point, &q, None)
    };
    assert!((at(&carried, 1.0) - at(&iso, -1.0)).norm() < 1e-9);
}

/// What the dialog says to some answers, and how it ends: a terminal by `rustix`.
#[cfg(target_os = "linux")]
fn dialog(folder: &Path, answers: &str) -> (Option<i32>, String) {
    use std::io::{Read, Write};
    use std::process::Stdio;
    let flags = rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY;
    let master = rustix::pty::openpt(flags).expect("a terminal");
    rustix::pty::grantpt(&master).and_then(|()| rustix::pty::unlockpt(&master)).expect("a terminal");
    let name = rustix::pty::ptsname(&master, Vec::new()).expect("its name").into_string().expect("UTF-8");
    let side = || std::fs::File::options().read(true).write(true).open(&name).expect("the other side");
    let mut child = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(folder)
        .args(["init", "mill.yaml", "--force"])
        .stdin(Stdio::from(side()))
        .stdout(Stdio::null())
        .stderr(Stdio::from(side()))
        .spawn()
        .expect("the program runs");
    let mut terminal = std::fs::File::from(master);
    // 4 is the end of the input
    terminal.write_all(format!("{answers}\u{4}").as_bytes()).expect("typed");
    let status = child.wait().expect("it ends");
    let mut said = Vec::new();
    let mut part = [0; 4096];
    // reading fails where nobody holds the other side
    while let Ok(count @ 1..) = terminal.read(&mut part) {
        said.extend_from_slice(&part[..count]);
    }
    (status.code(), String::from_utf8_lossy(&said).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn the_dialog_asks_for_ranges_and_the_name() {
    let scratch = tempfile::tempdir().expect("a folder");
    let figures = "[wCBXbYZt]\n\n762,508,508\n102..610\n500\n-50\n";
    // C as offered, B as typed
    let (code, said) = dialog(scratch.path(), &format!("{figures}\n-35..110\n\nOur mill\n"));
    assert_eq!(code, Some(0), "{said}");
    let (machine, _) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    assert_eq!(machine.name, "Our mill");
    let degrees = |name: &str| {
        let (low, high) = machine.axes[machine.axis_index(name).expect(name)].range.expect("a range");
        [low.to_degrees().round(), high.to_degrees().round()]
    };
    assert_eq!((degrees("C"), degrees("B")), ([-360.0, 360.0], [-35.0, 110.0]));
    let assumed: Vec<&String> = machine.caveats.iter().filter(|caveat| caveat.contains("is ASSUMED")).collect();
    assert_eq!(assumed.len(), 1, "{assumed:?}");
    assert!(assumed[0].starts_with("range of C,"));
}

#[cfg(target_os = "linux")]
#[test]
fn the_dialog_asks_for_the_inclined_axis() {
    let scratch = tempfile::tempdir().expect("a folder");
    let answers = "[wCBYbXZt]\nC\nb\nXY\n\n0\n-45\n500,450,400\n120..520\n400\n90\n\n\n\nSwivel mill\n";
    let (code, said) = dialog(scratch.path(), answers);
    assert_eq!(code, Some(0), "{said}");
    for says in [
        "'C' is not understood; allowed are none, B",
        "the plane is 'XY'; allowed are YZ and ZX",
        "0 deg from the vertical is no inclined axis",
        "negative towards -y",
        "Point where the inclined axis crosses the vertical",
        "[-5..185]",
    ] {
        assert!(said.contains(says), "'{says}' is not in: {said}");
    }
    let text = std::fs::read_to_string(scratch.path().join("mill.yaml")).expect("written");
    assert!(text.contains("B: {direction: [0, 0.707106781186547"), "{text}");
    assert!(text.contains("is ASSUMED to cross the vertical through R"), "{text}");
}

#[cfg(target_os = "linux")]
#[test]
fn the_dialog_takes_the_words_it_offers_and_asks_again() {
    let scratch = tempfile::tempdir().expect("a folder");
    let answers = "tabel\nhead-head\n\n650,520\n650,520,600\n110..585\n650,520,475\n\n\nround\n500\n20\n220\n\n9..10\n-95..95\nleft\n\n\n";
    let (code, said) = dialog(scratch.path(), answers);
    assert_eq!(code, Some(0), "{said}");
    for says in [
        "or one of the words table-table, table-head, head-head",
        "--travels has 2 numbers",
        "which is a travel of 475 mm",
        "--table: '' is no number",
        "'round' is no number",
        "allowed is at least half the spindle housing",
        "a range holds 0",
        "--directions 'left' is not known",
    ] {
        assert!(said.contains(says), "'{says}' is not in: {said}");
    }
    let (machine, _) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    assert_eq!(machine.code.to_string(), "[wXbYZCAt]");
    // the end of the input ends it
    std::fs::remove_file(scratch.path().join("mill.yaml")).expect("removed");
    let (code, said) = dialog(scratch.path(), "head-head\n\n650,520,475\n");
    assert!(code == Some(2) && said.contains("the input ended at the question"), "{said}");
    assert!(!scratch.path().join("mill.yaml").exists());
}

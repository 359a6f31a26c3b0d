//! Solids, meshes, mounts and kits that are refused, each with its one message.

use super::{MACHINE, URDF, changed, check};

const KIT: &str = include_str!("../../kits/ballbar.yaml");

/// Ends of a tetrahedron, as file units.
const TETRAHEDRON: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];

/// Binary STL of the given number of tetrahedra of a size, all faces or all but the last.
pub fn stl(size: f64, count: usize, faces: usize) -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend(((count * faces) as u32).to_le_bytes());
    for k in 0..count {
        for face in &FACES[..faces] {
            bytes.extend([0u8; 12]);
            for corner in face {
                let [x, y, z] = TETRAHEDRON[*corner].map(|value| value * size);
                bytes.extend([x, y, z + 1e-3 * k as f64].iter().flat_map(|value| (*value as f32).to_le_bytes()));
            }
            bytes.extend([0u8; 2]);
        }
    }
    bytes
}

pub fn text_stl(size: f64) -> String {
    let facet = |face: &[usize; 3]| {
        let corners = face.map(|k| TETRAHEDRON[k].map(|value| value * size));
        let corners = corners.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid part\n{}endsolid part\n", FACES.iter().map(facet).collect::<String>())
}

fn body(shape: &str) -> String {
    format!("{MACHINE}bodies:\n  - {{name: part, link: b, {shape}}}\n")
}

/// A machine whose one body is the mesh of a file.
fn check_mesh(name: &str, file: &str, content: &[u8], message: &str) {
    let machine = body(&format!("mesh: {{file: {file}}}"));
    let files = [("machine.yaml", machine.as_bytes()), (file, content)];
    check(name, &files, &["check", "machine.yaml"], &format!("machine.yaml:10:27: body 'part': mesh {file} {message}"));
}

#[test]
fn meshes() {
    check_mesh(
        "hole",
        "part.stl",
        &stl(50.0, 1, 3),
        "has 3 open edges (holes), the first at (0.000, 50.000, 0.000) mm; close the mesh",
    );
    check_mesh(
        "too many",
        "part.stl",
        &stl(1.0, 60_000, 4),
        "has 240000 triangles; at most 200000 are allowed, simplify the mesh",
    );
    let faces = "f 1 2 3\n".repeat(200_001);
    check_mesh(
        "too many faces",
        "part.obj",
        format!("v 0 0 0\nv 50 0 0\nv 0 50 0\n{faces}").as_bytes(),
        "has 200001 triangles; at most 200000 are allowed, simplify the mesh",
    );
    check_mesh(
        "metres",
        "part.stl",
        &stl(0.4, 1, 4),
        "is 0.693 mm across, the machine some 600 mm; check its unit and write scale: 1000 (scale: 1 where it is meant so)",
    );
    check_mesh(
        "micrometres",
        "part.obj",
        b"v 0 0 0\nv 400000 0 0\nv 0 400000 0\nv 0 0 400000\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n",
        "is 692820 mm across, the machine some 600 mm; check its unit and write scale: 0.001",
    );
    let whole = stl(50.0, 1, 4);
    check_mesh(
        "cut binary",
        "part.stl",
        &whole[..whole.len() - 30],
        "cannot be read: as a binary STL of 4 triangles it has 284 bytes, it is 254 long: the file is cut off or no STL",
    );
    check_mesh(
        "cut head",
        "part.stl",
        &whole[..40],
        "cannot be read: it has 40 bytes; an STL starts with 'solid' or with 84 bytes of head",
    );
    let text = text_stl(50.0);
    let cut_off = "the file is cut off: each facet has three vertices and an endfacet, the end is endsolid";
    check_mesh("cut text", "part.stl", &text.as_bytes()[..text.len() - 60], &format!("line 25: {cut_off}"));
    check_mesh("no end", "part.stl", changed(&text, "endsolid part\n", "").as_bytes(), &format!("line 29: {cut_off}"));
    check_mesh(
        "nan corner",
        "part.stl",
        text.replacen("vertex 50 0 0", "vertex nan 0 0", 1).as_bytes(),
        "line 5: a corner has three finite numbers, as in 0 0 1.5",
    );
    let mut nan = stl(50.0, 1, 4);
    nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    check_mesh("nan in binary", "part.stl", &nan, "has a corner that is not a finite number");
    check_mesh("empty", "part.stl", &stl(50.0, 0, 4), "has no triangle");
    check_mesh(
        "flat",
        "part.obj",
        b"v 0 0 0\nv 50 0 0\nv 0 50 0\nf 1 2 3\nf 1 2 3\n",
        "is flat or degenerate: it encloses no volume",
    );
    check_mesh(
        "cut obj",
        "part.obj",
        b"v 0 0 0\nv 50 0 0\nv 0 50 0\nf 1 2",
        "line 4: a face has at least three corners",
    );
    check_mesh("no corner", "part.obj", b"v 0 0 0\nf 1 2 3\n", "line 2: '2' names no corner; there are 1 so far");
    check_mesh("other", "part.step", b"ISO-10303-21;", "cannot be read: it is neither .stl nor .obj");
    check(
        "outside",
        &[("machine.yaml", body("mesh: {file: ../../part.stl}").as_bytes())],
        &["check", "machine.yaml"],
        "machine.yaml:10:27: body 'part': mesh '../../part.stl' leaves the machine's folder; put it beside the machine file or in ../shapes",
    );
}

#[test]
fn solids() {
    for (shape, place, message) in [
        ("box: {at: [0, 0, 0], size: [10, 0, 10]}", "27", "body 'part': every size of a box is above zero"),
        (
            "cylinder: {from: [0, 0, 0], to: [0, 0, 0], radius: 4}",
            "27",
            "body 'part': the radius is above zero, and from and to differ",
        ),
        (
            "capsule: {from: [0, 0, 0], to: [0, 0, 9], radius: 0}",
            "27",
            "body 'part': the radius is above zero, and from and to differ",
        ),
        (
            "hull: [[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]",
            "27",
            "body 'part': its points lie in a plane; a hull encloses a volume",
        ),
        (
            "box: {at: [0, 0, .nan], size: [10, 10, 10]}",
            "27",
            "'NaN' is not a finite number between -10000000 and 10000000",
        ),
        (
            "cylinder: {from: [0, 0, 0], to: [0, 0, .inf], radius: 4}",
            "27",
            "'inf' is not a finite number between -10000000 and 10000000",
        ),
    ] {
        let files = [("machine.yaml", body(shape))];
        let files = files.each_ref().map(|(name, text)| (*name, text.as_bytes()));
        check(shape, &files, &["check", "machine.yaml"], &format!("machine.yaml:10:{place}: {message}"));
    }
}

#[test]
fn collision_geometry_of_robots() {
    let with = |geometry: &str| {
        let link = format!("<link name=\"tool\"><collision><geometry>\n{geometry}\n</geometry></collision></link>");
        changed(URDF, "<link name=\"tool\"/>", &link)
    };
    for (geometry, message) in [
        (r#"<box size="0.1 0 0.1"/>"#, r#"<box> has size="0.1 0 0.1"; sizes are above zero and at most 50 m"#),
        (
            r#"<cylinder radius="nan" length="1"/>"#,
            r#"<cylinder> has radius="nan"; one number of at most 10000 is due"#,
        ),
        (r#"<sphere radius="60"/>"#, r#"<sphere> has radius="60"; sizes are above zero and at most 50 m"#),
        (r#"<cylinder radius="1"/>"#, "a <cylinder> has no length; write length=\"…\""),
        (r#"<cone radius="1"/>"#, "a <geometry> holds a <cone>; allowed are box, cylinder, sphere, capsule, mesh"),
        // a mesh in mm without the scale that says so
        (
            r#"<mesh filename="part.stl"/>"#,
            "mesh part.stl is 69282 mm across, the machine some 600 mm; check its unit and write scale=\"0.001 0.001 0.001\" (a robot description is in m)",
        ),
        (
            r#"<mesh filename="part.stl" scale="1 0 1"/>"#,
            "a mesh has a scale of zero; write scale=\"1 1 1\" or leave it out",
        ),
        (
            r#"<mesh filename="hole.stl" scale="0.001 0.001 0.001"/>"#,
            "mesh hole.stl has 3 open edges (holes), the first at (0.000, 40.000, 0.000) mm; close the mesh",
        ),
    ] {
        let (text, part, hole) = (with(geometry), stl(40.0, 1, 4), stl(40.0, 1, 3));
        let files = [("arm.urdf", text.as_bytes()), ("part.stl", &part[..]), ("hole.stl", &hole[..])];
        check(geometry, &files, &["check", "arm.urdf"], &format!("arm.urdf:4: {message}"));
    }
    let none = changed(URDF, "<link name=\"tool\"/>", "<link name=\"tool\">\n<collision/></link>");
    check(
        "no geometry",
        &[("arm.urdf", none.as_bytes())],
        &["check", "arm.urdf"],
        "arm.urdf:4: a <collision> has no geometry; write <geometry><box size=\"…\"/></geometry>",
    );
}

/// A machine with a table, a mount and a spindle.
const WITH_MOUNT: &str = "\
bodies:
  - {name: table, link: C, cylinder: {from: [0, 0, -111], to: [0, 0, -75], radius: 140}}
mounts:
  - {name: table top, link: C, at: [0, 0, -75], normal: [0, 0, 1], disc: [20, 140]}
spindle: {nose: [0, 0, 110]}
";

#[test]
fn machines_that_do_not_say_what_could_be_hit() {
    let arm = include_str!("../../machines/irb120.urdf");
    let with = "<link name=\"link_1\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>";
    let with = changed(arm, "<link name=\"link_1\"/>", with);
    let urdf = |either: &str| {
        format!(
            "irb120.urdf: a robot description cannot say where a pivot stands and a ball is clamped{either}; write its chain as a machine file with bodies, mounts and spindle, as in machines/hermle-c600u.yaml"
        )
    };
    let none = urdf(", and this one has no <collision> bodies either");
    let session = "name: run\nmachine: irb120.urdf\ntests:\n  - name: a\n    bar_length: 100\n    pivot: {link: workpiece, at: [300, 0, 300]}\n    spindle_ball: {link: tool0, at: [374, 0, 630]}\n    positions: {J1: 0, J2: 0, J3: 0, J4: 0, J5: 0}\n    sweep: {axis: J6, from: -20, to: 20, step: 1}\n";
    for (text, message) in [(arm, none), (&with, urdf(""))] {
        let files = [("irb120.urdf", text.as_bytes()), ("session.yaml", session.as_bytes())];
        check("arm", &files, &["plan", "irb120.urdf"], &message);
        check("arm", &files, &["clearance", "session.yaml"], &message);
    }
    let machine = format!("{MACHINE}{}", changed(WITH_MOUNT, "spindle: {nose: [0, 0, 110]}\n", ""));
    check(
        "no spindle",
        &[("machine.yaml", machine.as_bytes())],
        &["plan", "machine.yaml"],
        "machine.yaml: has no 'spindle'; add what is missing as in machines/hermle-c600u.yaml",
    );
    check(
        "nothing",
        &[("machine.yaml", MACHINE.as_bytes())],
        &["plan", "machine.yaml", "--json"],
        "machine.yaml: has no 'bodies', no 'mounts', no 'spindle'; add what is missing as in machines/hermle-c600u.yaml",
    );
}

#[test]
fn mounts_and_kits_that_leave_nothing_to_plan() {
    let machine = format!("{MACHINE}{WITH_MOUNT}");
    let plan = |name, machine: &str, kit: &str, message| {
        let files = [("machine.yaml", machine.as_bytes()), ("kit.yaml", kit.as_bytes())];
        check(name, &files, &["plan", "machine.yaml", "--kit", "kit.yaml"], message);
    };
    plan(
        "far mount",
        &changed(&machine, "at: [0, 0, -75], normal", "at: [0, 0, -75000], normal"),
        KIT,
        "mount 'table top' is 66164 mm or more beyond the reach of every bar with the axes anywhere in their ranges; check its 'at', in mm",
    );
    plan(
        "small mount",
        &changed(&machine, "disc: [20, 140]", "disc: [20, 60]"),
        KIT,
        "mount 'table top' has no room for the stand of the kit '100 mm ball bar with extensions', 44 mm across; enlarge its disc or rectangle (mm) or remove it",
    );
    let short = changed(KIT, "length: 100, extensions: [50, 150, 300]", "length: 20, extensions: []");
    let short = changed(&short, "neck_length: 30", "neck_length: 6");
    let short = changed(&short, "radius: 6, rim_below_ball: 5.5", "radius: 1, rim_below_ball: 5");
    // where linear axes follow, a ball may stand at any lever: without them the bar must reach
    let files = [("machine.yaml", machine.as_bytes()), ("kit.yaml", short.as_bytes())];
    // one pivot for all axes is looked for with the other rotary axis at zero, where levers are longer
    for (option, short_mm) in
        [(["--follow", "none"], 15.4), (["--method", "chapter4"], 15.4), (["--method", "chapter5"], 30.1)]
    {
        let arguments = ["plan", "machine.yaml", "--kit", "kit.yaml", option[0], option[1]];
        check(
            "short bar",
            &files,
            &arguments,
            &format!(
                "no bar of the kit '100 mm ball bar with extensions' reaches: the longest, 20 mm, is {short_mm} mm too short; add an extension"
            ),
        );
    }
    plan(
        "wide cup",
        &machine,
        &changed(KIT, "pivot_cup: {radius: 6, rim_below_ball: 5.5", "pivot_cup: {radius: 9, rim_below_ball: 4"),
        "kit.yaml:8:1: cone: 110 lets the bar touch the cup: it meets the rim at 96.2 degrees from the cup's axis (radius 9, rim_below_ball 4, the bar's neck_radius 3)",
    );
    let session = "name: run\nmachine: machine.yaml\ntests:\n  - name: a\n    bar_length: 220\n    pivot: {link: C, at: [0, 100, 0]}\n    spindle_ball: {link: Z, at: [0, 0, 0]}\n    positions: {X: 0, Y: 0, Z: 0, C: 0}\n    sweep: {axis: A, from: -20, to: 20, step: 1}\n";
    let clearance = |name, session: &str, message| {
        let files = [("machine.yaml", machine.as_bytes()), ("session.yaml", session.as_bytes())];
        check(name, &files, &["clearance", "session.yaml"], message);
    };
    clearance(
        "no such bar",
        session,
        "test 'a': bar 220 mm is not made by the kit '100 mm ball bar with extensions', which makes 100 150 250 300 400 450 550 600 mm, ± 1 mm stroke",
    );
    clearance(
        "off the table",
        &changed(&changed(session, "220", "250"), "at: [0, 100, 0]", "at: [0, 250, 0]"),
        "test 'a': the pivot at (0.000, 250.000, 0.000) on link C stands on no mounting surface; surfaces of that link: table top (ball 45 to 220 mm above it)",
    );
}

#[test]
fn pairs_that_touch_by_design() {
    let refused = |name, pairs: &str, message: &str| {
        let bodies = "bodies:\n  - {name: table, link: C, capsule: {from: [0, 0, 0], to: [0, 0, 9], radius: 2}}\n  - {name: vice, link: w, capsule: {from: [0, 0, 50], to: [0, 0, 59], radius: 2}}\n  - {name: arm, link: A, capsule: {from: [90, 0, 0], to: [90, 0, 9], radius: 2}}\n  - {name: pin, link: b, capsule: {from: [200, 0, 0], to: [200, 0, 9], radius: 2}}\n  - {name: pin, link: b, capsule: {from: [300, 0, 0], to: [300, 0, 9], radius: 2}}\n";
        let machine = format!("{MACHINE}{bodies}touching: {pairs}\n");
        check(name, &[("machine.yaml", machine.as_bytes())], &["check", "machine.yaml"], message);
    };
    refused(
        "misspelt",
        "[[table, arms]]",
        "machine.yaml:15:12: no body is called 'arms'; did you mean 'arm'? (bodies: table, vice, arm, pin, pin)",
    );
    refused(
        "one link",
        "[[table, arm], [table, vice]]",
        "machine.yaml:15:26: 'table' and 'vice' are on one link and never compared; list bodies of different links, or take the pair out",
    );
    refused(
        "doubled",
        "[[arm, pin]]",
        "machine.yaml:15:12: several bodies are called 'pin'; give each a name of its own",
    );
}

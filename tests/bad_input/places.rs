//! Where named files may lie and what they may be: no link out of the folder, no pipe, no folder; and the same file read once.

use std::os::unix::fs::symlink;
use std::process::Command;

use super::{MACHINE, RECORDING, SESSION, changed, folder_with, run};

const C600U: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/hermle-c600u.yaml");

/// A closed tetrahedron of 50 mm.
const MESH: &str = "v 0 0 0\nv 50 0 0\nv 0 50 0\nv 0 0 50\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

fn refusal(folder: &std::path::Path, file: &str) -> String {
    let (code, out, error) = run(folder, &["check", file]);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{error}");
    error
}

#[test]
fn recordings_stay_in_the_folder() {
    let outside = folder_with(&[("a.csv", RECORDING.as_bytes())]);
    let folder = folder_with(&[("machine.yaml", MACHINE.as_bytes()), ("session.yaml", SESSION.as_bytes())]);
    symlink(outside.path().join("a.csv"), folder.path().join("a.csv")).unwrap();
    assert_eq!(
        refusal(folder.path(), "session.yaml"),
        "fiveaxis: session.yaml:5:5: recording 'a.csv' is a link out of the session's folder; put a copy beside the session\n"
    );
    // by a folder
    symlink(outside.path(), folder.path().join("runs")).unwrap();
    std::fs::write(folder.path().join("session.yaml"), changed(SESSION, "a.csv", "runs/a.csv")).unwrap();
    assert!(refusal(folder.path(), "session.yaml").contains("recording 'runs/a.csv' is a link out"));
    // a link to a file inside is a name like any other
    std::fs::write(folder.path().join("b.csv"), RECORDING).unwrap();
    symlink("b.csv", folder.path().join("c.csv")).unwrap();
    std::fs::write(folder.path().join("session.yaml"), changed(SESSION, "a.csv", "c.csv")).unwrap();
    assert_eq!(run(folder.path(), &["check", "session.yaml"]).0, Some(0));
}

#[test]
fn meshes_stay_in_the_folder_or_in_shapes() {
    let machine = |file: &str| format!("{MACHINE}bodies:\n  - {{name: part, link: b, mesh: {{file: {file}}}}}\n");
    let outside = folder_with(&[("part.obj", MESH.as_bytes())]);
    let top = tempfile::tempdir().unwrap();
    for name in ["machines", "shapes"] {
        std::fs::create_dir(top.path().join(name)).unwrap();
    }
    let home = top.path().join("machines");
    std::fs::write(top.path().join("shapes/good.obj"), MESH).unwrap();
    symlink(outside.path().join("part.obj"), home.join("part.obj")).unwrap();
    symlink(outside.path().join("part.obj"), top.path().join("shapes/part.obj")).unwrap();
    symlink("../shapes/good.obj", home.join("linked.obj")).unwrap();
    for (file, is_read) in
        [("part.obj", false), ("../shapes/part.obj", false), ("../shapes/good.obj", true), ("linked.obj", true)]
    {
        std::fs::write(home.join("machine.yaml"), machine(file)).unwrap();
        let (code, _, error) = run(&home, &["check", "machine.yaml"]);
        assert_eq!(code, Some(if is_read { 0 } else { 2 }), "{file}: {error}");
        assert_eq!(
            error.contains("is a link out of the machine's folder and of ../shapes; put a copy there"),
            !is_read
        );
    }
}

#[test]
fn pipes_and_devices_are_refused_at_once() {
    let folder = folder_with(&[("machine.yaml", MACHINE.as_bytes()), ("session.yaml", SESSION.as_bytes())]);
    let pipe = |name: &str| {
        let made = Command::new("mkfifo").arg(folder.path().join(name)).status().unwrap();
        assert!(made.success());
    };
    let message = "is a pipe, socket or device; save what it holds to a file and name that\n";
    for name in ["a.csv", "pipe.yaml", "pipe.urdf", "part.stl"] {
        pipe(name);
    }
    for file in ["pipe.yaml", "pipe.urdf"] {
        assert_eq!(refusal(folder.path(), file), format!("fiveaxis: {file}: {message}"));
    }
    assert_eq!(refusal(folder.path(), "session.yaml"), format!("fiveaxis: a.csv: {message}"));
    assert_eq!(refusal(folder.path(), "/dev/zero"), format!("fiveaxis: /dev/zero: {message}"));
    for arguments in [
        ["simulate", "session.yaml", "--out", "out", "--instrument", "pipe.yaml"],
        ["plan", C600U, "--out", "out", "--kit", "pipe.yaml"],
    ] {
        // the pipe of the session is in the way of the first
        let _ = std::fs::remove_file(folder.path().join("a.csv"));
        std::fs::write(folder.path().join("a.csv"), RECORDING).unwrap();
        let (code, _, error) = run(folder.path(), &arguments);
        assert_eq!((code, error), (Some(2), format!("fiveaxis: pipe.yaml: {message}")));
    }
    let body = format!("{MACHINE}bodies:\n  - {{name: part, link: b, mesh: {{file: part.stl}}}}\n");
    std::fs::write(folder.path().join("machine.yaml"), body).unwrap();
    assert!(refusal(folder.path(), "machine.yaml").ends_with(&format!("mesh part.stl cannot be read: it {message}")));
}

#[test]
fn a_pipe_in_the_folder_of_a_plan_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["session.yaml", "setup-sheet.html"] {
        assert!(Command::new("mkfifo").arg(folder.path().join(name)).status().unwrap().success());
        let (code, _, error) = run(folder.path(), &["plan", C600U, "--out", "."]);
        assert_eq!(
            (code, error.contains("was not written by plan and is not overwritten")),
            (Some(2), true),
            "{error}"
        );
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
}

/// Three hundred bodies of one mesh file are read as fast as one.
#[test]
fn a_mesh_of_many_bodies_is_read_once() {
    // a bumpy ball: cutting it up takes time
    let (rings, around) = (16, 32);
    let point = |ring: usize, k: usize| {
        let (polar, turn) =
            (std::f64::consts::PI * ring as f64 / rings as f64, std::f64::consts::TAU * k as f64 / around as f64);
        let radius = 100.0 + 10.0 * (5.0 * turn).sin() * polar.sin();
        format!(
            "v {} {} {}\n",
            radius * polar.sin() * turn.cos(),
            radius * polar.sin() * turn.sin(),
            radius * polar.cos()
        )
    };
    let mut mesh: String =
        (1..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))).map(|(r, k)| point(r, k)).collect();
    mesh += "v 0 0 100\nv 0 0 -100\n";
    let corner = |ring: usize, k: usize| (ring - 1) * around + k % around + 1;
    let (top, bottom) = ((rings - 1) * around + 1, (rings - 1) * around + 2);
    for k in 0..around {
        mesh += &format!("f {top} {} {}\n", corner(1, k), corner(1, k + 1));
        mesh += &format!("f {bottom} {} {}\n", corner(rings - 1, k), corner(rings - 1, k + 1));
        for ring in 1..rings - 1 {
            let (a, b, c, d) = (corner(ring, k), corner(ring, k + 1), corner(ring + 1, k + 1), corner(ring + 1, k));
            mesh += &format!("f {a} {b} {c} {d}\n");
        }
    }
    let time = |count: usize| {
        let bodies: String =
            (0..count).map(|k| format!("  - {{name: p{k}, link: b, mesh: {{file: part.obj}}}}\n")).collect();
        let machine = format!("{MACHINE}bodies:\n{bodies}");
        let folder = folder_with(&[("machine.yaml", machine.as_bytes()), ("part.obj", mesh.as_bytes())]);
        let start = std::time::Instant::now();
        let (_, _, error) = run(folder.path(), &["check", "machine.yaml"]);
        // many pieces may be too many solids, which is found after all were made
        assert!(error.is_empty() || error.contains("solids of a machine"), "{error}");
        start.elapsed().as_secs_f64()
    };
    let (one, many) = (time(1), time(300));
    assert!(many < 4.0 * one + 1.0, "one body {one} s, 300 bodies {many} s");
}

//! Every malformed input gives one message and exit code 2; the built binary is run on files in a folder of their own.

mod bodies;
mod command_line;
mod hidden;
mod limits;
mod machine;
mod mutated;
mod places;
mod recording;
mod session;
mod size;
mod urdf;

use std::path::Path;
use std::process::Command;

const MACHINE: &str = "\
name: mill
code: \"[wCAbYXZt]\"
axes:
\x20 X: {range: [-300, 300]}
\x20 Y: {range: [-225, 225]}
\x20 Z: {range: [-120, 330]}
\x20 A: {range: [-30, 110]}
\x20 C: {range: [-360, 360]}
";

const SESSION: &str = "\
name: run
machine: machine.yaml
tests:
\x20 - name: a
\x20   recording: a.csv
\x20   bar_length: 100.002
\x20   pivot: {link: C, at: [0, 100, 0]}
\x20   spindle_ball: {link: Z, at: [0, 0, 0]}
\x20   positions: {X: 0, Y: 0, Z: 0, C: 0}
";

const RECORDING: &str = "\
time_s,A_deg,length_mm
0.00,-20.00,100.0000
0.10,-19.00,100.0001
0.20,-18.00,100.0002
0.30,-17.00,100.0003
0.40,-16.00,100.0004
0.50,-15.00,100.0005
0.60,-14.00,100.0006
0.70,-13.00,100.0007
0.80,-12.00,100.0008
0.90,-11.00,100.0009
1.00,-10.00,100.0010
1.10,-9.00,100.0011
";

const URDF: &str = "\
<robot name=\"r\">
<link name=\"base\"/>
<link name=\"tool\"/>
<joint name=\"J1\" type=\"revolute\">
<parent link=\"base\"/>
<child link=\"tool\"/>
<axis xyz=\"0 0 1\"/>
<limit lower=\"-1\" upper=\"1\" effort=\"0\" velocity=\"1\"/>
</joint>
</robot>
";

/// A text with one part replaced; the part must be there.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "'{from}' is not in the text");
    text.replace(from, to)
}

/// Exit code, standard output and standard error of `fiveaxis` run in a folder.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Files in a folder of their own.
fn folder_with(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

fn check(name: &str, files: &[(&str, &[u8])], arguments: &[&str], message: &str) {
    let folder = folder_with(files);
    let (code, out, error) = run(folder.path(), arguments);
    // under --json the same message stands on standard output as an object
    let out = if arguments.contains(&"--json") && out.contains("\"error\"") { String::new() } else { out };
    assert_eq!((code, out, error), (Some(2), String::new(), format!("fiveaxis: {message}\n")), "{name}");
}

fn accept(name: &str, files: &[(&str, &[u8])], arguments: &[&str]) {
    let folder = folder_with(files);
    let (code, out, error) = run(folder.path(), arguments);
    assert_eq!((code, error.as_str()), (Some(0), ""), "{name}");
    assert!(!out.is_empty(), "{name}");
}

fn check_machine(name: &str, text: &str, message: &str) {
    check(name, &[("machine.yaml", text.as_bytes())], &["check", "machine.yaml"], message);
}

fn check_session(name: &str, text: &str, message: &str) {
    let files = [("machine.yaml", MACHINE), ("a.csv", RECORDING), ("session.yaml", text)];
    check(name, &files.map(|(name, text)| (name, text.as_bytes())), &["check", "session.yaml"], message);
}

fn check_recording(name: &str, text: &str, message: &str) {
    let files = [("machine.yaml", MACHINE), ("a.csv", text), ("session.yaml", SESSION)];
    check(name, &files.map(|(name, text)| (name, text.as_bytes())), &["check", "session.yaml"], message);
}

fn accept_recording(name: &str, text: &str) {
    let files = [("machine.yaml", MACHINE), ("a.csv", text), ("session.yaml", SESSION)];
    accept(name, &files.map(|(name, text)| (name, text.as_bytes())), &["check", "session.yaml"]);
}

fn check_urdf(name: &str, text: &str, message: &str) {
    check(name, &[("arm.urdf", text.as_bytes())], &["check", "arm.urdf"], message);
}

fn accept_urdf(name: &str, text: &str) {
    accept(name, &[("arm.urdf", text.as_bytes())], &["check", "arm.urdf"]);
}

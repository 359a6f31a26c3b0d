//! What is typed wrong on the command line, and files that are not there.

use super::{MACHINE, RECORDING, SESSION, URDF, changed, check};

#[test]
fn one_message_each() {
    let machine: &[(&str, &[u8])] = &[("machine.yaml", MACHINE.as_bytes())];
    let arm: &[(&str, &[u8])] = &[("arm.urdf", URDF.as_bytes())];
    check("missing", &[], &["check", "machine.yaml"], "machine.yaml: is not there; check its name and folder");
    check("folder", &[], &["check", "."], ".: is a folder; name a file in it");
    check(
        "no such axis",
        machine,
        &["check", "machine.yaml", "--at", "Q=3"],
        "positions 'Q=3': the machine has no axis 'Q'; did you mean 'C'? (its axes are C A Y X Z)",
    );
    check(
        "outside",
        machine,
        &["check", "machine.yaml", "--at", "A=300"],
        "positions 'A=300': A = 300 deg is outside the axis's range -30 … 110 deg",
    );
    check(
        "not understood",
        machine,
        &["check", "machine.yaml", "--at", "A30"],
        "positions 'A30': 'A30' is not understood; write AXIS=VALUE, for example A=30,C=-45 (mm, deg)",
    );
    check(
        "no such link",
        arm,
        &["check", "arm.urdf", "--tool-link", "tol"],
        "arm.urdf: no link is called 'tol' (--tool-link); did you mean 'tool'? (links: base tool)",
    );
    check(
        "links of a machine file",
        machine,
        &["check", "machine.yaml", "--tool-link", "t"],
        "machine.yaml: is no URDF; root, workpiece and tool links are named for URDF only, a machine file has them in its code",
    );
}

#[test]
fn lists_of_errors_that_name_none() {
    let files = [("machine.yaml", MACHINE), ("a.csv", RECORDING), ("session.yaml", SESSION)];
    for (verb, free) in [("identify", ","), ("identify", ""), ("diagnose", " , ,")] {
        check(
            verb,
            &files.map(|(name, text)| (name, text.as_bytes())),
            &[verb, "session.yaml", "--free", free],
            &format!(
                "'{free}' names no error; write names such as EX0C,EY0C or a group: rotary, squareness, linear, zero, all, none"
            ),
        );
    }
}

#[test]
fn absolute_lengths_in_metres() {
    let session = changed(SESSION, "    bar_length: 100.002\n", "");
    let recording = changed(RECORDING, ",100.", ",0.1");
    let files = [("machine.yaml", MACHINE), ("a.csv", &recording), ("session.yaml", &session)];
    check(
        "metres",
        &files.map(|(name, text)| (name, text.as_bytes())),
        &["check", "session.yaml"],
        "a.csv: readings are about 0.10006 mm, shorter than two balls can be apart (5 mm); length_mm is the absolute ball-to-ball length in mm, convert metres or deviations",
    );
}

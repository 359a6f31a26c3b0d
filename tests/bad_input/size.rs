//! Files too large or not text: refused before they are read.

use super::{MACHINE, SESSION, check, folder_with, run};

const GIGABYTE: u64 = 1 << 30;

/// A sparse file of a gigabyte in place of `name`, `arguments` run beside it.
fn check_gigabyte(name: &str, files: &[(&str, &[u8])], arguments: &[&str], message: &str) {
    let folder = folder_with(files);
    std::fs::File::create(folder.path().join(name)).unwrap().set_len(GIGABYTE).unwrap();
    let start = std::time::Instant::now();
    let found = run(folder.path(), arguments);
    assert_eq!(found, (Some(2), String::new(), format!("fiveaxis: {message}\n")), "{name}");
    // reading a gigabyte of zeros takes longer than refusing it
    assert!(start.elapsed().as_secs_f64() < 2.0, "{name}: {:?}", start.elapsed());
}

#[test]
fn gigabytes_are_refused_unread() {
    let yaml = "is 1024 MB large; a file of this kind has at most 4 MB, is it the right one?";
    let csv = "is 1024 MB large; a file of this kind has at most 128 MB, is it the right one?";
    let session: [(&str, &[u8]); 2] = [("machine.yaml", MACHINE.as_bytes()), ("session.yaml", SESSION.as_bytes())];
    check_gigabyte("machine.yaml", &[], &["check", "machine.yaml"], &format!("machine.yaml: {yaml}"));
    check_gigabyte(
        "session.yaml",
        &[],
        &["simulate", "session.yaml", "--out", "out"],
        &format!("session.yaml: {yaml}"),
    );
    check_gigabyte("arm.urdf", &[], &["check", "arm.urdf"], &format!("arm.urdf: {yaml}"));
    check_gigabyte("a.csv", &session, &["check", "session.yaml"], &format!("a.csv: {csv}"));
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    let bytes = b"name: m\xffll\n";
    let message = "machine.yaml:1: is not UTF-8 text; save it as UTF-8";
    check("not utf8", &[("machine.yaml", bytes)], &["check", "machine.yaml"], message);
    let utf16: Vec<u8> = "time_s,A_deg,length_mm\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let files: [(&str, &[u8]); 3] = [
        ("machine.yaml", MACHINE.as_bytes()),
        ("session.yaml", SESSION.as_bytes()),
        ("a.csv", &[&[0xff, 0xfe], &utf16[..5]].concat()),
    ];
    let cut = "a.csv: is UTF-16 text that ends within a character; the file is cut off, fetch it again";
    check("utf16", &files, &["check", "session.yaml"], cut);
}

//! Recordings that are refused, each with its one message, and odd ones that are accepted.

use super::{RECORDING, accept_recording, changed, check_recording};

#[test]
fn one_message_each() {
    let cases: Vec<(&str, String, &str)> = vec![
        (
            "decimal comma in comma file",
            RECORDING.replace('.', ","),
            "a.csv:2: has 6 fields where the header (line 1) has 3; decimal commas need ; between the fields",
        ),
        (
            "swapped header",
            changed(RECORDING, "A_deg,length_mm", "length_mm,A_deg"),
            "a.csv:1: the columns A_deg and length_mm seem swapped: A_deg holds about 100.0006, the bar's length is 100.002 mm, length_mm holds about -14.0000; correct the header",
        ),
        (
            "missing length",
            changed(RECORDING, "length_mm", "len"),
            "a.csv:1: no column length_mm (columns found: time_s A_deg len); a header is time_s,A_deg,length_mm",
        ),
        (
            "missing time",
            changed(RECORDING, "time_s", "t"),
            "a.csv:1: no column time_s, or pose for static poses (columns found: t A_deg length_mm); a header is time_s,A_deg,length_mm",
        ),
        (
            "missing position",
            RECORDING
                .lines()
                .map(|line| {
                    let (time, rest) = line.split_once(',').unwrap();
                    format!("{time},{}\n", rest.split_once(',').unwrap().1)
                })
                .collect(),
            "session.yaml:5:5: test 'a': the recording has no column of positions such as A_deg; add it, or say the arc of samples uniform in angle with 'sweep: {axis: C, from: 0, to: 360}'",
        ),
        (
            "foreign axis",
            changed(RECORDING, "A_deg", "B_deg"),
            "a.csv:1: column 'B_deg': the machine has no axis 'B'; its axes are C A Y X Z",
        ),
        (
            "wrong position unit",
            changed(RECORDING, "A_deg", "A_mm"),
            "a.csv:1: column 'A_mm': positions of axis A are A_deg; rename or convert the column",
        ),
        (
            "length in m header",
            changed(RECORDING, "length_mm", "length_m"),
            "a.csv:1: column 'length_m': lengths are length_mm, times time_s, static poses pose; convert the column",
        ),
        (
            "column twice",
            changed(RECORDING, "A_deg", "length_mm"),
            "a.csv:1: column 'length_mm' stands twice; each column stands once",
        ),
        (
            "text",
            changed(RECORDING, "100.0003", "1OO.0003"),
            "a.csv:5: column length_mm: '1OO.0003' is not a number; correct it or leave a missing length_mm empty",
        ),
        (
            "nan",
            changed(RECORDING, "100.0003", "NaN"),
            "a.csv:5: column length_mm: NaN is not a finite number; only a missing length_mm or channel may be empty",
        ),
        (
            "inf",
            changed(RECORDING, "-17.00", "inf"),
            "a.csv:5: column A_deg: inf is not a finite number; only a missing length_mm or channel may be empty",
        ),
        (
            "missing position value",
            changed(RECORDING, "-17.00", ""),
            "a.csv:5: column A_deg: an empty field is not a finite number; only a missing length_mm or channel may be empty",
        ),
        (
            "times back",
            changed(RECORDING, "0.30,", "0.10,"),
            "a.csv:5: time_s goes from 0.2 to 0.1; times rise from row to row, sort or split the file",
        ),
        (
            "empty",
            "".into(),
            "a.csv: is empty; a recording has a header such as time_s,A_deg,length_mm and a row per sample",
        ),
        (
            "header only",
            "time_s,A_deg,length_mm\n".into(),
            "a.csv: has a header but no row; a recording has a row per sample",
        ),
        (
            "cut line",
            format!("{RECORDING}{}", "1.20,-8.0"),
            "a.csv:14: has 2 fields where the header (line 1) has 3; the line may be cut off",
        ),
        (
            "cut number",
            format!("{RECORDING}{}", "1.20,-8.00,100.0"),
            "a.csv:14: the last line ends after '100.0' without a line end, where all rows before have at least 4 decimals; the file is cut off, fetch it again or remove the line",
        ),
        (
            "metres",
            RECORDING.replace(",100.", ",0.100"),
            "a.csv: readings are about 0.1000006 mm but bar_length is 100.002 mm and a reading lies within ±5 mm of it; the column seems to be in metres, length_mm is in mm",
        ),
        (
            "wrong bar",
            changed(RECORDING, ",100.", ",150."),
            "a.csv: readings are about 150.0006 mm but bar_length is 100.002 mm and a reading lies within ±5 mm of it; check bar_length and which recording belongs to the test",
        ),
        (
            "partly",
            changed(&changed(RECORDING, "100.0003", "130.0003"), "100.0005", "70.0003"),
            "a.csv:5: length_mm 130.0003 is the first of 2 readings out of 12 outside the bar's stroke: bar_length is 100.002 mm and a reading lies within ±5 mm of it; one in 10 may be wrong, check the recording",
        ),
        (
            "outside range",
            changed(RECORDING, "-17.00", "-37.00"),
            "a.csv:5: A = -37 deg is outside the axis's range -30 … 110 deg",
        ),
        (
            "all empty",
            "time_s,A_deg,length_mm\n0.1,1.0,\n0.2,2.0,\n".into(),
            "a.csv: has no reading: every length_mm is empty",
        ),
    ];
    for (name, text, message) in cases {
        check_recording(name, &text, message);
    }
}

#[test]
fn odd_but_sound_files_are_accepted() {
    let cases: Vec<(&str, String)> = vec![
        ("BOM", format!("\u{feff}{RECORDING}")),
        ("CRLF", changed(RECORDING, "\n", "\r\n")),
        ("semicolon comma", changed(&changed(RECORDING, ",", ";"), ".", ",")),
        ("missing reading", changed(RECORDING, "100.0003", "")),
        ("static", changed(RECORDING, "time_s", "pose")),
        ("one outlier", changed(RECORDING, "100.0003", "130.0003")),
    ];
    for (name, text) in cases {
        accept_recording(name, &text);
    }
}

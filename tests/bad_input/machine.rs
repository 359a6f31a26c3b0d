//! Machine files that are refused, each with its one message.

use super::{MACHINE, changed, check_machine};

#[test]
fn one_message_each() {
    let cases: Vec<(&str, String, &str)> = vec![
        (
            "deep brackets",
            format!("name: {}", "[".repeat(100_000)),
            "machine.yaml:1: is nested deeper than 40 levels; no such file needs that",
        ),
        (
            "deep maps",
            (0..300).map(|depth| format!("{}a:\n", " ".repeat(depth))).collect(),
            "machine.yaml:162: is nested deeper than 40 levels; no such file needs that",
        ),
        ("deep list", "- ".repeat(5000), "machine.yaml:1: is nested deeper than 40 levels; no such file needs that"),
        (
            "bomb",
            alias_bomb(),
            "machine.yaml:5:45: repeats its anchors (&name, *name) too many times; write the values out (alias expansion exceeded the maximum node budget (possible billion-laughs attack))",
        ),
        (
            "unknown key",
            changed(MACHINE, "range: [-225", "rnage: [-225"),
            "machine.yaml:5:7: unknown key 'rnage' under axes.Y; did you mean 'range'? (allowed: type, direction, origin, range, reversed, errors, component_errors)",
        ),
        (
            "unknown top key",
            format!("{MACHINE}{}", "gravty: [0, 0, -1]\n"),
            "machine.yaml:9:1: unknown key 'gravty'; did you mean 'gravity'? (allowed: name, code, chain, directions, axes, gravity, machine_zero, gauge_length, links, carried, effects, linear_axes, caveats, bodies, mounts, spindle, touching)",
        ),
        (
            "a caveat of two lines",
            format!("{MACHINE}caveats: [fine, \"two\\nlines\"]\n"),
            "machine.yaml:9:17: caveats[1]: the text holds the hidden character U+000A; line breaks, control characters and invisible ones are not allowed, remove it",
        ),
        (
            "unknown sense",
            format!("{MACHINE}directions: ISO\n"),
            "machine.yaml:9:1: directions 'ISO' are not known; allowed are iso841 (a positive command moves the tool in the positive sense relative to the workpiece) or carried (it moves the carried part right-handed)",
        ),
        (
            "sense of another type",
            format!("{MACHINE}directions: [iso841]\n"),
            "machine.yaml:9:13: directions: found a list, due is a string",
        ),
        (
            "class of linear axes",
            format!("{MACHINE}linear_axes: wron\n"),
            "machine.yaml:9:1: linear_axes has no 'wron'; did you mean 'worn'? (allowed: new, used, worn)",
        ),
        (
            "budget in part",
            format!("{MACHINE}linear_axes: {{positioning: 5 um/m, straightness: 5 um/m}}\n"),
            "machine.yaml:9:1: linear_axes lacks squareness; write all three, e.g. {positioning: 5 um/m, straightness: 5 um/m, squareness: 10 urad}, or a class: new, used, worn",
        ),
        (
            "budget without unit",
            format!("{MACHINE}linear_axes: {{positioning: 5, straightness: 5 um/m, squareness: 10 urad}}\n"),
            "machine.yaml:9:15: '5' has no unit; write for example '5 um/m' (allowed: um/m, µm/m, μm/m, ppm, mm/mm)",
        ),
        (
            "negative budget",
            format!("{MACHINE}linear_axes: {{positioning: 5 um/m, straightness: 5 um/m, squareness: -10 urad}}\n"),
            "machine.yaml:9:58: squareness is a standard deviation from 0 to 1000 um/m (positioning, straightness) or 1000 urad (squareness)",
        ),
        (
            "no budget at all",
            format!("{MACHINE}linear_axes: 5\n"),
            "machine.yaml:9:1: linear_axes is no budget; write a class (new, used, worn) or {positioning: 5 um/m, straightness: 5 um/m, squareness: 10 urad}",
        ),
        ("missing key", changed(MACHINE, "name: mill\n", ""), "machine.yaml:1:1: the key 'name' is missing; add it"),
        (
            "wrong type",
            changed(MACHINE, "[-225, 225]", "wide"),
            "machine.yaml:5:14: axes.Y.range: found the text \"wide\", due is a list of two numbers",
        ),
        (
            "wrong type 2",
            changed(MACHINE, "[-225, 225]", "[-225, 225, 3]"),
            "machine.yaml:5:14: axes.Y.range: has 3 entries, due are 2",
        ),
        (
            "dup key",
            format!("{MACHINE}{}", "  C: {range: [-1, 1]}\n"),
            "machine.yaml:9:3: the key 'C' stands twice; each key stands once",
        ),
        (
            "bad yaml",
            format!("{MACHINE}{}", "  : : [\n"),
            "machine.yaml:10:1: is not valid YAML here: while parsing a node, did not find expected node content",
        ),
        (
            "bare number",
            changed(MACHINE, "range: [-360, 360]", "errors: {EX0C: 34.2}"),
            "machine.yaml:8:16: '34.2' has no unit; write for example '34.2 um' (allowed: um, µm, μm, mm, nm, m)",
        ),
        (
            "wrong unit",
            changed(MACHINE, "range: [-360, 360]", "errors: {EX0C: 34.2 arcsec}"),
            "machine.yaml:8:16: unit 'arcsec' in '34.2 arcsec' does not fit here; allowed: um, µm, μm, mm, nm, m",
        ),
        (
            "no number",
            changed(MACHINE, "range: [-360, 360]", "errors: {EX0C: big um}"),
            "machine.yaml:8:16: 'big um' is not a finite number with a unit; write for example '12.5 um'",
        ),
        (
            "nan quantity",
            changed(MACHINE, "range: [-360, 360]", "errors: {EX0C: .nan}"),
            "machine.yaml:8:16: '.nan' is not a finite number with a unit; write for example '12.5 um'",
        ),
        (
            "huge quantity",
            changed(MACHINE, "range: [-360, 360]", "errors: {EX0C: 34.2 m}"),
            "machine.yaml:8:16: '34.2 m' is larger than any geometric error (at most 1000 mm or half a turn); check its unit",
        ),
        (
            "bare in table",
            changed(MACHINE, "range: [-360, 360]", "component_errors: {EZC: {table: [[0, 1.5]]}}"),
            "machine.yaml:8:26: '1.5' has no unit; write for example '1.5 um' (allowed: um, µm, μm, mm, nm, m)",
        ),
        (
            "empty table",
            changed(MACHINE, "range: [-360, 360]", "component_errors: {EZC: {table: []}}"),
            "machine.yaml:8:26: the table is empty; write rows such as [-30, 1.5 um]",
        ),
        (
            "comp in errors",
            changed(MACHINE, "range: [-360, 360]", "errors: {EZC: 3 um}"),
            "machine.yaml:8:16: EZC is a component error, a function of position; write it under component_errors, or EZ0C for the location error",
        ),
        (
            "foreign error",
            changed(MACHINE, "range: [-360, 360]", "errors: {EZ0A: 3 um}"),
            "machine.yaml:8:16: EZ0A belongs to axis A but stands under axis C; move it",
        ),
        (
            "thesis name θya",
            changed(MACHINE, "A: {range", "A: {errors: {θya: 3 arcsec}, range"),
            "machine.yaml:7:16: 'θya' is no error name: the thesis's chapter 5 prints θya for θy0a, its Table 2.1 for a component error; write EB0A for the location error or EBA for the component error",
        ),
        (
            "thesis θx0x",
            changed(MACHINE, "X: {range", "X: {errors: {θx0x: 3 arcsec}, range"),
            "machine.yaml:4:16: 'θx0x' is no error name: the thesis's Table 2.1 pairs θx0x with EX0X, a length; write EX0X for the zero point or EA0X for the rotation",
        ),
        (
            "no error name",
            changed(MACHINE, "X: {range", "X: {errors: {QX0X: 3 arcsec}, range"),
            "machine.yaml:4:16: 'QX0X' is no error name: it names X Y Z A B or C after the E, as in EX0C or EZX",
        ),
        (
            "axis twice",
            changed(MACHINE, "[wCAbYXZt]", "[wCAbYXAt]"),
            "machine.yaml:2:1: axis 'A' stands twice; each axis stands once\n    [wCAbYXAt]\n           ^",
        ),
        (
            "no b",
            changed(MACHINE, "[wCAbYXZt]", "[wCAYXZt]"),
            "machine.yaml:2:1: the bed 'b' is missing; write it between workpiece and tool axes, as in [wCAYbXZt] or [w, b, J1, J2, t]\n    [wCAYXZt]\n           ^",
        ),
        (
            "no axis",
            changed(MACHINE, "[wCAbYXZt]", "[wbt]"),
            "machine.yaml:2:1: no axis stands between workpiece and tool; write at least one, as in [wCAYbXZt] or [w, b, J1, J2, t]\n    [wbt]\n       ^",
        ),
        (
            "unknown axis letter",
            changed(MACHINE, "[wCAbYXZt]", "[wCAbYXQt]"),
            "machine.yaml:2:1: 'Q' is no axis; allowed are X Y Z A B C U V W and one b for the bed\n    [wCAbYXQt]\n           ^",
        ),
        (
            "axis not in code",
            format!("{MACHINE}{}", "  B: {}\n"),
            "machine.yaml:9:3: axis 'B' does not stand in the code [wCAbYXZt]; its axes are C A Y X Z",
        ),
        (
            "zero direction",
            changed(MACHINE, "C: {range", "C: {direction: [0, 0, 0], range"),
            "machine.yaml:8:7: direction [0, 0, 0] has no length; give a vector such as [0, 0, 1]",
        ),
        (
            "nan direction",
            changed(MACHINE, "C: {range", "C: {direction: [0, .nan, 0], range"),
            "machine.yaml:8:7: 'NaN' is not a finite number between -10000000 and 10000000",
        ),
        (
            "inf origin",
            changed(MACHINE, "C: {range", "C: {origin: [0, .inf, 0], range"),
            "machine.yaml:8:7: 'inf' is not a finite number between -10000000 and 10000000",
        ),
        (
            "range upside down",
            changed(MACHINE, "[-225, 225]", "[225, -225]"),
            "machine.yaml:5:7: range [225, -225] is upside down or empty; write the lower end first, as in [-120, 30]",
        ),
        ("empty file", "".into(), "machine.yaml: is empty or no list of keys; it starts with 'name:' and further keys"),
        (
            "only list",
            "- a\n- b\n".into(),
            "machine.yaml: is empty or no list of keys; it starts with 'name:' and further keys",
        ),
        (
            "no type",
            "name: r\nchain: [w, b, J1, t]\naxes: {}\n".into(),
            "machine.yaml:3:1: axis 'J1' is no letter X Y Z A B C U V W, so it needs a type: linear or rotary",
        ),
        (
            "letter of the other type",
            "name: r\nchain: [w, b, W, t]\naxes:\n  W: {type: rotary}\n".into(),
            "machine.yaml:4:7: axis W is linear by its letter (ISO 841); a rotary one is A, B or C, or has a longer name, as in R1",
        ),
        (
            "spindle on the table",
            "name: r\nchain: [w, C, b, Z, t]\naxes: {}\nspindle: {link: C, nose: [0, 0, 100]}\n".into(),
            "machine.yaml:4:11: link 'C' carries the workpiece; the spindle is on the tool side (links: t b Z)",
        ),
    ];
    for (name, text, message) in cases {
        check_machine(name, &text, message);
    }
}

/// Ten levels of ten references each: ten thousand million values.
fn alias_bomb() -> String {
    let level = |depth: usize| format!("a{depth}: &a{depth} [{}]\n", vec![format!("*a{}", depth - 1); 10].join(", "));
    let first = format!("a0: &a0 [{}]\n", ["x"; 10].join(", "));
    first + &(1..10).map(level).collect::<String>()
}

//! The figures of a data sheet: options first, questions for the rest on a terminal. What the figures make is `template`'s.

use fiveaxis::machine::{Directions, StructuralCode};
use fiveaxis::template::{Inclined, Plane, Sizes, TableSize, allowed, is_rotary, usual_range};

use super::arguments::{Arguments, Kind, inclined, named_range, number, plane, range, range_of, table_size, three};
use super::ask::{Question, ask, ask_or_leave, at_terminal};
use crate::verbs::Refusal;
use crate::verbs::output::complain;

const CODE: Question = Question {
    option: "--code",
    asks: "What carries what, from workpiece w over bed b to tool t (table-table [wCAYbXZt], table-head [wCXbYZBt], head-head [wXbYZCAt])",
};
const INCLINED: Question = Question {
    option: "--inclined",
    asks: "Axis that is inclined against the vertical, as in 45 deg heads and tables (Enter: none)",
};
const TRAVELS: Question = Question { option: "--travels", asks: "Travels of X, Y, Z in mm, e.g. 650,520,475" };
const DISTANCES: Question =
    Question { option: "--nose-to-table", asks: "Distance from spindle nose to table top in mm, smallest..largest" };
const TABLE: Question = Question { option: "--table", asks: "Table in mm: diameter, or width x depth" };
const TILT: Question =
    Question { option: "--tilt-above-table", asks: "Tilting axis above the table top in mm (below: negative)" };
const CROSSING_TABLE: Question = Question {
    option: TILT.option,
    asks: "Point where the inclined axis crosses the vertical through the middle of the table, above the table top in mm (below: negative)",
};
const CROSSING_HEAD: Question = Question {
    option: PIVOT.option,
    asks: "From the spindle nose up to the point where the inclined axis crosses the spindle's line in mm",
};
const PIVOT: Question =
    Question { option: "--pivot-to-nose", asks: "From the spindle nose up to the tilting axis of the head in mm" };
const DIRECTIONS: Question = Question {
    option: "--directions",
    asks: "What does + do: iso841 (tool moves in + relative to the workpiece) or carried (carried part moves right-handed)",
};

/// Figures that the options give.
struct Given {
    code: Option<StructuralCode>,
    inclined: Option<Inclined>,
    travels: Option<[f64; 3]>,
    distances: Option<(f64, f64)>,
    table: Option<TableSize>,
    tilt: Option<f64>,
    pivot: Option<f64>,
    ranges: Vec<(String, (f64, f64))>,
    directions: Option<Directions>,
}

/// The data sheet.
pub(super) fn sizes(arguments: &Arguments) -> Result<Sizes, Refusal> {
    let given = given(arguments)?;
    let missing = missing(&given);
    let asks = !missing.is_empty() && at_terminal() && !arguments.json;
    if !missing.is_empty() && !asks {
        return Err(refusal(&given, &missing).into());
    }
    let code = given.code.map_or_else(|| ask(CODE.asks, Some(Kind::TableTable.code()), read_code), Ok)?;
    let inclined = match given.inclined {
        None if asks => ask_inclined(&code)?,
        inclined => inclined,
    };
    if let Some(inclined) = &inclined {
        allowed::inclined(inclined, &code).map_err(|why| format!("{}: {why}", INCLINED.option))?;
    }
    let [of_tilt, of_pivot] = heights(&code, inclined.as_ref());
    let (travels, nose_to_table) = lengths(given.travels, given.distances)?;
    let table = given.table.map_or_else(|| ask(TABLE.asks, None, read_table), Ok)?;
    let tilt_above_table = match given.tilt {
        None if tilts(&code.workpiece_side) => ask(of_tilt.asks, None, read_tilt)?,
        height => height.unwrap_or_default(),
    };
    let pivot_above_nose = match given.pivot {
        None if tilts(&code.tool_side) => ask(of_pivot.asks, None, |text| read_pivot(text, arguments.housing))?,
        height => height.unwrap_or_default(),
    };
    let mut ranges = given.ranges;
    refuse_foreign(&ranges, &code)?;
    refuse_pointless(&code, [given.tilt, given.pivot])?;
    if asks {
        ask_ranges(&code, inclined.as_ref(), &mut ranges)?;
    }
    let directions =
        given.directions.map_or_else(|| ask(DIRECTIONS.asks, Some(Directions::Iso841.name()), read_directions), Ok)?;
    let usual = format!("Machine {code}");
    let name = match &arguments.name {
        None if asks => ask("Name of the machine", Some(&usual), |text| Ok(text.to_string()))?,
        name => name.clone().unwrap_or(usual),
    };
    if name.chars().any(char::is_control) {
        return Err(
            "--name holds a control character; write the name of the machine in letters, digits and signs".into()
        );
    }
    Ok(Sizes {
        name,
        nose_to_table,
        table,
        travels,
        inclined,
        ranges,
        tilt_above_table,
        pivot_above_nose,
        housing: arguments.housing,
        has_angle_plate: arguments.angle_plate,
        directions,
        code,
    })
}

/// Reads the options that are there.
fn given(arguments: &Arguments) -> Result<Given, Refusal> {
    let code = arguments.code.as_deref().or(arguments.kind.map(Kind::code));
    Ok(Given {
        code: code.map(read_code).transpose()?,
        inclined: arguments.inclined.as_deref().map(inclined).transpose()?,
        travels: arguments.travels.as_deref().map(read_travels).transpose()?,
        distances: arguments.nose_to_table.as_deref().map(read_distances).transpose()?,
        table: arguments.table.as_deref().map(read_table).transpose()?,
        tilt: arguments.tilt_above_table,
        pivot: arguments.pivot_to_nose,
        ranges: arguments.range.iter().map(|text| named_range(text)).collect::<Result<_, _>>()?,
        directions: arguments.directions.map(|said| said.directions()),
    })
}

/// What no option gives and the machine needs.
fn missing(given: &Given) -> Vec<Question> {
    let code = given.code.as_ref();
    let needs_tilt = given.tilt.is_none() && code.is_some_and(|code| tilts(&code.workpiece_side));
    let needs_pivot = given.pivot.is_none() && code.is_some_and(|code| tilts(&code.tool_side));
    let [of_tilt, of_pivot] = match code {
        Some(code) => heights(code, given.inclined.as_ref()),
        None => [TILT, PIVOT],
    };
    let open = [
        (CODE, code.is_none()),
        (TRAVELS, given.travels.is_none()),
        (DISTANCES, given.distances.is_none()),
        (TABLE, given.table.is_none()),
        (of_tilt, needs_tilt),
        (of_pivot, needs_pivot),
        (DIRECTIONS, given.directions.is_none()),
    ];
    open.into_iter().filter(|(_, is_open)| *is_open).map(|(question, _)| question).collect()
}

/// All that is missing in one message.
fn refusal(given: &Given, missing: &[Question]) -> String {
    let mut lines: Vec<String> = missing.iter().map(|question| question.missing()).collect();
    if given.code.is_none() {
        let by_code = [(TILT, given.tilt, "table"), (PIVOT, given.pivot, "head")];
        let open = by_code.iter().filter(|(_, height, _)| height.is_none());
        lines.extend(open.map(|(question, _, side)| format!("{}, where the {side} tilts", question.missing())));
    }
    lines.join("\n")
}

fn tilts(side: &[String]) -> bool {
    side.iter().any(|name| matches!(name.as_str(), "A" | "B"))
}

/// Travels, and distances from nose to table, which hold the travel of Z: where answers do not agree, they are asked for again.
fn lengths(travels: Option<[f64; 3]>, distances: Option<(f64, f64)>) -> Result<([f64; 3], (f64, f64)), Refusal> {
    let mut offers: [Option<String>; 2] = [None, None];
    loop {
        let now = travels.map_or_else(|| ask(TRAVELS.asks, offers[0].as_deref(), read_travels), Ok)?;
        let apart = distances.map_or_else(|| ask(DISTANCES.asks, offers[1].as_deref(), read_distances), Ok)?;
        match allowed::distances(apart, now[2]) {
            Ok(()) => return Ok((now, apart)),
            // nothing is left to ask
            Err(why) if travels.is_some() && distances.is_some() => return Err(why.into()),
            Err(why) => complain(&why.into()),
        }
        offers = [Some(now.map(|travel| travel.to_string()).join(",")), Some(range_text(apart))];
    }
}

/// Which axis is inclined, in which plane and how far.
fn ask_inclined(code: &StructuralCode) -> Result<Option<Inclined>, Refusal> {
    let axis = ask_or_leave(INCLINED.asks, "none", |text| {
        let axis = text.to_uppercase();
        let names = code.axis_names().map(String::as_str).filter(|name| matches!(*name, "A" | "B"));
        let names: Vec<&str> = names.collect();
        match (names.contains(&axis.as_str()), axis.as_str()) {
            (true, _) => Ok(Some(axis)),
            (false, "NONE") => Ok(None),
            _ => Err(format!("'{text}' is not understood; allowed are none, {}", names.join(", ")).into()),
        }
    })?;
    let Some(axis) = axis.flatten() else { return Ok(None) };
    let question = format!("Upright plane in which {axis} is inclined, YZ or ZX");
    let plane = ask(&question, Some(Plane::of_letter(&axis).name()), plane)?;
    let level = plane.level_letter();
    let question = format!(
        "Degrees from the vertical to {axis}, positive with its upper end towards +{level}, negative towards -{level}"
    );
    let angle_deg = ask(&question, None, |text| {
        let angle = number(text, INCLINED.option)?;
        allowed::inclination(angle)?;
        Ok(angle)
    })?;
    Ok(Some(Inclined { axis, angle_deg, plane }))
}

/// The questions for the heights of the tilting axes of table and head.
fn heights(code: &StructuralCode, inclined: Option<&Inclined>) -> [Question; 2] {
    let is_on = |side: &[String]| inclined.is_some_and(|inclined| side.contains(&inclined.axis));
    [
        if is_on(&code.workpiece_side) { CROSSING_TABLE } else { TILT },
        if is_on(&code.tool_side) { CROSSING_HEAD } else { PIVOT },
    ]
}

fn ask_ranges(
    code: &StructuralCode,
    inclined: Option<&Inclined>,
    ranges: &mut Vec<(String, (f64, f64))>,
) -> Result<(), Refusal> {
    let turning = code.axis_names().filter(|name| is_rotary(name));
    for name in turning {
        if ranges.iter().any(|(given, _)| given == name) {
            continue;
        }
        let question = format!("Range of {name} in deg, from..to (Enter: assumed, and the file says so)");
        let answer = ask_or_leave(&question, &range_text(usual_range(name, inclined)), |text| range_of(name, text))?;
        ranges.extend(answer.map(|range| (name.clone(), range)));
    }
    Ok(())
}

fn range_text((from, to): (f64, f64)) -> String {
    format!("{from}..{to}")
}

/// Heights of tilting axes that the machine does not have.
fn refuse_pointless(code: &StructuralCode, [tilt, pivot]: [Option<f64>; 2]) -> Result<(), Refusal> {
    let stated = [(TILT.option, tilt, &code.workpiece_side, "table"), (PIVOT.option, pivot, &code.tool_side, "head")];
    match stated.iter().find(|(_, height, side, _)| height.is_some() && !tilts(side)) {
        None => Ok(()),
        Some((option, .., side)) => Err(format!(
            "{option}: the {side} of {code} has no axis that tilts (A or B); leave the option out, or correct the code"
        )
        .into()),
    }
}

fn refuse_foreign(ranges: &[(String, (f64, f64))], code: &StructuralCode) -> Result<(), Refusal> {
    let is_twice =
        |(k, (name, _)): &(usize, &(String, (f64, f64)))| ranges[..*k].iter().any(|(other, _)| other == name);
    if let Some((_, (name, _))) = ranges.iter().enumerate().find(is_twice) {
        return Err(format!("--range: '{name}' stands twice; keep one range").into());
    }
    let is_turning = |name: &str| is_rotary(name) && code.axis_names().any(|axis| axis == name);
    match ranges.iter().find(|(name, _)| !is_turning(name)) {
        None => Ok(()),
        Some((name, _)) if code.axis_names().any(|axis| axis == name) => Err(format!(
            "--range: '{name}' is a linear axis, whose range follows from --travels; allowed are rotary axes"
        )
        .into()),
        Some((name, _)) => Err(format!("--range: {code} has no axis '{name}'").into()),
    }
}

/// A code, or the word for a common one.
fn read_code(text: &str) -> Result<StructuralCode, Refusal> {
    let words = Kind::words();
    let text = words.iter().find(|(word, _)| word.eq_ignore_ascii_case(text)).map_or(text, |(_, kind)| kind.code());
    let code = StructuralCode::parse(text).map_err(|why| {
        let words: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
        format!("--code: {why}\n    or one of the words {}", words.join(", "))
    })?;
    allowed::code(&code)?;
    Ok(code)
}

fn read_travels(text: &str) -> Result<[f64; 3], Refusal> {
    let travels = three(text, TRAVELS.option)?;
    allowed::travels(travels)?;
    Ok(travels)
}

fn read_distances(text: &str) -> Result<(f64, f64), Refusal> {
    range(text, DISTANCES.option)
}

fn read_table(text: &str) -> Result<TableSize, Refusal> {
    let table = table_size(text)?;
    allowed::table(table)?;
    Ok(table)
}

fn read_tilt(text: &str) -> Result<f64, Refusal> {
    let height = number(text, TILT.option)?;
    allowed::tilt_above_table(height)?;
    Ok(height)
}

fn read_pivot(text: &str, housing: f64) -> Result<f64, Refusal> {
    let height = number(text, PIVOT.option)?;
    allowed::pivot_above_nose(height, housing)?;
    Ok(height)
}

fn read_directions(text: &str) -> Result<Directions, Refusal> {
    Directions::named(text)
        .ok_or_else(|| format!("--directions '{text}' is not known; allowed are iso841 and carried").into())
}

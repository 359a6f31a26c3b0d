//! Random machines: mills with heads and tables in any order, inclined axes, chains of three to seven axes, robots.

use std::path::Path;

use fiveaxis::effects::{DefaultValue as Standard, KINDS, Kind, ParameterUnit};
use fiveaxis::load::machine_from_yaml;
use fiveaxis::machine::Machine;

use super::draws::Draws;

/// Text of a machine file that loads, and its machine.
pub fn machine(draws: &mut Draws) -> (String, Machine) {
    let (chain, names) = chain(draws);
    let axes: String = names.iter().map(|name| axis(draws, name)).collect();
    let mut text = format!("name: random\n{chain}axes:\n{axes}");
    if draws.percent(60) {
        let solids = solids(draws, &names);
        text.push_str(&solids);
    }
    let machine = load(&text).unwrap_or_else(|why| panic!("{why}\n{text}"));
    if draws.percent(60) {
        return (text, machine);
    }
    let list: String = (0..draws.count(1, 4)).filter_map(|_| effect(draws, &machine)).collect();
    let disturbed = format!("{text}effects:\n{list}");
    // parameters that make no sense together are refused
    match load(&disturbed) {
        Ok(machine) if !list.is_empty() => (disturbed, machine),
        _ => (text, machine),
    }
}

fn load(text: &str) -> Result<Machine, String> {
    machine_from_yaml(Path::new("machine.yaml"), text.to_string()).map_err(|why| why.to_string())
}

/// The line of the file that says the order of the axes, and their names.
fn chain(draws: &mut Draws) -> (String, Vec<String>) {
    let robot = draws.percent(15);
    let names: Vec<String> = if robot {
        (1..=draws.count(3, 7)).map(|k| format!("J{k}")).collect()
    } else if draws.percent(75) {
        let rotary = draws.shuffled(&["A", "B", "C"]);
        draws.shuffled(&["X", "Y", "Z", rotary[0], rotary[1]]).into_iter().map(String::from).collect()
    } else {
        let all = draws.shuffled(&["X", "Y", "Z", "A", "B", "C", "U", "turn", "slide"]);
        let count = draws.count(3, 7);
        all.into_iter().take(count).map(String::from).collect()
    };
    let bed = if robot { 0 } else { draws.count(0, names.len()) };
    let mut words = vec!["w".to_string()];
    words.extend(names[..bed].iter().cloned());
    words.push("b".into());
    words.extend(names[bed..].iter().cloned());
    words.push("t".into());
    (format!("chain: [{}]\n", words.join(", ")), names)
}

fn axis(draws: &mut Draws, name: &str) -> String {
    let is_joint = name.starts_with('J');
    let is_rotary = ["A", "B", "C", "turn"].contains(&name) || is_joint && draws.percent(90);
    let mut keys = Vec::new();
    if is_joint || name.len() > 1 {
        keys.push(format!("type: {}", if is_rotary { "rotary" } else { "linear" }));
    }
    if is_joint || name.len() > 1 || draws.percent(8) {
        let along = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, -1.0], [0.3, -0.2, 0.9]];
        keys.push(format!("direction: {:?}", draws.one(&along)));
    }
    if draws.percent(50) {
        let reach = *draws.one(&[0.01, 50.0, 500.0, 3000.0]);
        keys.push(format!("origin: {:?}", draws.vector(reach)));
    }
    if draws.percent(70) {
        keys.push((if is_rotary { "range: [-370, 370]" } else { "range: [-2000, 2000]" }).into());
    }
    if draws.percent(15) {
        keys.push("reversed: true".into());
    }
    if draws.percent(30) {
        let component = *draws.one(&["A", "B", "C"]);
        keys.push(format!("errors: {{E{component}0{name}: {} arcsec}}", draws.magnitude(1e-3, 300.0)));
    }
    if draws.percent(20) {
        let component = *draws.one(&["X", "Y", "Z"]);
        let per = if is_rotary { "per_turn: 2" } else { "period: 37" };
        let form = match draws.count(0, 2) {
            0 => format!("fourier: [{{{per}, cos: {} um}}]", draws.magnitude(1e-2, 50.0)),
            1 => format!("polynomial: [{} um]", draws.magnitude(1e-4, 0.3)),
            _ => format!("table: [[-10, 0 um], [0, {} um], [20, 0 um]]", draws.magnitude(1e-2, 50.0)),
        };
        keys.push(format!("component_errors: {{E{component}{name}: {{{form}}}}}"));
    }
    format!("  {name}: {{{}}}\n", keys.join(", "))
}

/// A table, a housing, a mounting surface and a spindle somewhere.
fn solids(draws: &mut Draws, names: &[String]) -> String {
    let link = draws.one(names).clone();
    let mut nose = draws.vector(300.0);
    // the spindle ball, at the origin, hangs below the nose
    nose[2] = nose[2].abs() + 1.0;
    let height = draws.between(-300.0, 0.0);
    format!(
        "bodies:\n  - {{name: table, link: w, cylinder: {{from: [0, 0, {}], to: [0, 0, {height}], radius: 140}}}}\n  - {{name: housing, link: {link}, box: {{at: {:?}, size: [80, 60, 40]}}}}\nmounts:\n  - {{name: top, link: w, at: [0, 0, {height}], normal: [0, 0, 1], disc: [20, 140]}}\nspindle: {{nose: {nose:?}}}\n",
        height - 40.0,
        draws.vector(900.0),
    )
}

/// One entry of the list of effects, of any kind that can sit on the machine.
fn effect(draws: &mut Draws, machine: &Machine) -> Option<String> {
    let kind: &Kind = KINDS[draws.count(0, KINDS.len() - 1)];
    let places = kind.places(machine);
    let place = *places.get(draws.count(0, places.len().max(1) - 1))?;
    let mut made = fiveaxis::machine::Effect::new(kind.name, place);
    let mut keys = vec![format!("effect: {}", kind.name), format!("place: {}", place.name(machine))];
    for parameter in kind.parameters {
        if parameter.default != Standard::Required && !draws.percent(30) {
            continue;
        }
        let (from, to) = (parameter.bounds.0.max(-50.0), parameter.bounds.1.min(50.0));
        let mut number = || if from < to { draws.between(from, to) } else { parameter.bounds.0 };
        let value = match (parameter.unit, parameter.count) {
            (ParameterUnit::Word(words), _) => {
                words.first().map_or_else(|| "temperature_degC".into(), |word| word.to_string())
            }
            (_, 1) => number().to_string(),
            (_, 0) => format!("{:?}", [number(), number()]),
            (_, count) => format!("{:?}", (0..count).map(|_| number()).collect::<Vec<f64>>()),
        };
        if let Ok(list) = serde_json::from_str::<Vec<f64>>(&value) {
            made.set(parameter.name, fiveaxis::machine::ParameterValue::List(list));
        } else if let Ok(number) = value.parse() {
            made.set(parameter.name, fiveaxis::machine::ParameterValue::Number(number));
        }
        keys.push(format!("{}: {value}", parameter.name));
    }
    let outlet = *draws.one(&(kind.outlets)(machine, place));
    let functions = (kind.functions)(&made);
    let function = functions.first()?;
    let unit = (kind.measure)(machine, &outlet, function).output_unit();
    let value = format!("{} {unit}", draws.magnitude(0.1, 100.0));
    let value = if function.is_empty() { value } else { format!("{{{function}: {value}}}") };
    keys.push(format!("sizes: {{{}: {value}}}", outlet.name(machine)));
    Some(format!("  - {{{}}}\n", keys.join(", ")))
}

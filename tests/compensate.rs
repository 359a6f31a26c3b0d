//! Corrected programs: read by a reader of the test's own and driven through kinematics of the test's own, the erring
//! machine's tool is on the ideal path.

use crate::plain_machine;
use crate::plain_program;
use crate::shipped;
use crate::skipped;
use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::chain::Chain;
use fiveaxis::compensate::{Compensator, Coordinates, NotCorrected, Settings};
use fiveaxis::disturbances::take_remembered;
use fiveaxis::inverse::Tool;
use fiveaxis::load::{load_machine, load_machine_and_bodies, standard_kit};
use fiveaxis::machine::{
    AxisKind, Component, ComponentError, ComponentForm, Effect, Harmonic, Machine, Outlet, ParameterValue,
    Place as EffectPlace,
};
use plain_machine::{Plain, distance};
use plain_program::{LETTERS, Move, moves};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Tip and direction of the tool beside the ideal path, mm and rad: 0.1 µm and 0.01 arcsec.
const TIP_MM: f64 = 1e-4;
const DIRECTION_RAD: f64 = 0.01 / 206_264.806;
/// Samples along the path, mm: of the first machine, and of all in the long form.
const SAMPLE_MM: f64 = 0.01;
/// Of the others.
const COARSE_MM: f64 = 0.2;
/// Of a move's time, how late a block may be: the last digits of times, and the time in which lost motion is taken up.
const LATE: f64 = 2e-5;
const LATE_BY_REVERSALS: f64 = 4e-3;
/// Blocks shorter than this take up what a reversal costs, mm: twice the largest size and a little.
const TURNS_BACK_MM: f64 = 0.015;
/// Rounds of a search for the nearest point of the ideal path, each over half the width.
const ROUNDS: usize = 20;
/// Length of the tool, mm.
const LENGTH: f64 = 95.0;
const G54: [f64; 6] = [5.0, -3.0, -40.0, 0.0, 0.0, 0.0];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name)
}

/// A machine with some ten micrometres and arc seconds of everything.
fn erring(name: &str, seed: u64) -> Machine {
    let mut machine = load_machine(&file(name)).expect("machine");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for index in 0..machine.axes.len() {
        let slots: Vec<Component> = machine.axes[index].slots();
        let axis = &mut machine.axes[index];
        for component in slots {
            let size = if component.is_angle() { 1e-4 } else { 0.05 };
            axis.location_errors[component.index()] = size * random.random_range(-1.0..1.0);
        }
        let component = axis.own_component();
        let form = match axis.kind {
            AxisKind::Rotary => ComponentForm::Fourier(vec![Harmonic { frequency: 3.0, cosine: 1e-5, sine: -2e-5 }]),
            AxisKind::Linear => ComponentForm::Fourier(vec![Harmonic {
                frequency: std::f64::consts::TAU / 60.0,
                cosine: 0.002,
                sine: 0.003,
            }]),
        };
        axis.component_errors.push(ComponentError { component, form });
        if axis.kind == AxisKind::Linear {
            let across = Component::ALL[(component.index() + 1) % 3];
            let form = ComponentForm::Polynomial(vec![0.0, 4e-8]);
            axis.component_errors.push(ComponentError { component: across, form });
        }
    }
    machine
}

fn settings(coordinates: Coordinates) -> Settings {
    let mut offsets = [None; 9];
    let whole = |six: [f64; 6]| std::array::from_fn(|k| six.get(k).copied().unwrap_or(0.0));
    offsets[0] = Some(whole(G54));
    Settings {
        coordinates,
        tolerance_mm: 8e-5,
        tolerance_rad: 0.008 / 206_264.806,
        offsets,
        tools: vec![(1, LENGTH)],
        tool_length_mm: None,
        initial: String::new(),
        mark: false,
        decimals: [6, 6],
        keeps_arcs: true,
    }
}

fn corrected(machine: &Machine, text: &str, settings: Settings) -> Result<String, NotCorrected> {
    let chain = Chain::of(machine);
    let mut compensator = Compensator::new(machine, &chain, settings).expect("a machine of programs");
    let mut out = Vec::new();
    for line in text.split_inclusive('\n') {
        compensator.line(line.as_bytes(), &mut out)?;
    }
    Ok(String::from_utf8(out).expect("text"))
}

/// Axis positions for coordinates of a program, as the nominal machine of a control has them.
fn positions(nominal: &Plain, coordinates: Coordinates, place: [f64; 6]) -> Vec<f64> {
    let machine = nominal.machine;
    let mut q: Vec<f64> = machine
        .axes
        .iter()
        .map(|axis| {
            let letter = LETTERS.find(&axis.name).expect("letter");
            if letter > 2 { place[letter].to_radians() } else { place[letter] }
        })
        .collect();
    if coordinates == Coordinates::Axes {
        return q;
    }
    // the tip that a tool without length has there with the rotary axes at zero
    let mut level = q.clone();
    let sliding: Vec<usize> = (0..q.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear).collect();
    (0..q.len()).filter(|k| !sliding.contains(k)).for_each(|k| level[k] = 0.0);
    let nose: [f64; 3] = std::array::from_fn(|k| nominal.tip[k] + LENGTH * nominal.axis[k]);
    let wanted = Plain { tip: nose, ..*nominal }.tool(&level).0;
    // the tip is linear in the slides: three differences and Cramer's rule
    let here = nominal.tool(&q).0;
    let columns: Vec<[f64; 3]> = sliding
        .iter()
        .map(|&k| {
            let mut moved = q.clone();
            moved[k] += 100.0;
            let there = nominal.tool(&moved).0;
            std::array::from_fn(|i| (there[i] - here[i]) / 100.0)
        })
        .collect();
    let det = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) + c[0] * (a[1] * b[2] - a[2] * b[1])
    };
    let by: [f64; 3] = std::array::from_fn(|i| wanted[i] - here[i]);
    let [a, b, c] = [columns[0], columns[1], columns[2]];
    let whole = det(a, b, c);
    for (k, step) in [det(by, b, c), det(a, by, c), det(a, b, by)].into_iter().enumerate() {
        q[sliding[k]] += step / whole;
    }
    q
}

struct Found {
    tip_mm: f64,
    direction_rad: f64,
    feed: f64,
    samples: usize,
}

/// Drives the corrected program on the erring machine and compares with the ideal path, block by block of the N numbers.
fn compare(machine: &Machine, coordinates: Coordinates, before: &str, after: &str, sample_mm: f64) -> Found {
    let tool = Tool::of(machine, Some(LENGTH)).expect("tool");
    let actual = Plain { machine, errs: true, tip: tool.tip_mm.into(), axis: tool.axis.into() };
    compare_driven(machine, coordinates, [before, after], (sample_mm, LATE), &mut |q| actual.tool(q))
}

/// Tip and direction of a tool at positions, asked in the order of a program.
type Driven<'d> = dyn FnMut(&[f64]) -> ([f64; 3], [f64; 3]) + 'd;

/// The same for a machine that knows the way by which it came: its tool at positions, asked in the order of the program.
fn compare_driven(
    machine: &Machine,
    coordinates: Coordinates,
    texts: [&str; 2],
    (sample_mm, late): (f64, f64),
    actual: &mut Driven,
) -> Found {
    let tool = Tool::of(machine, Some(LENGTH)).expect("tool");
    let nominal = Plain { machine, errs: false, tip: tool.tip_mm.into(), axis: tool.axis.into() };
    let tables = [G54, [0.0; 6]];
    // coordinates of the tip hold no tool length
    let length = if coordinates == Coordinates::Axes { LENGTH } else { 0.0 };
    let [ideal, driven] = texts.map(|text| moves(text, [0.0; 6], tables, length));
    let mut found = Found { tip_mm: 0.0, direction_rad: 0.0, feed: 0.0, samples: 0 };
    let at = |mv: &Move, s: f64| positions(&nominal, coordinates, mv.at(s));
    let blocks: Vec<&Move> = ideal.iter().filter(|mv| !mv.is_rapid).collect();
    assert!(blocks.len() > 5);
    let total = |number: u32| -> f64 {
        driven.iter().filter(|mv| mv.number == number && !mv.is_rapid).map(|mv| mv.minutes).sum()
    };
    for block in &blocks {
        found.feed = found.feed.max((total(block.number) / block.minutes - 1.0).abs());
    }
    let (mut number, mut gone, mut minutes) = (u32::MAX, 0.0, 0.0);
    for piece in &driven {
        if piece.is_rapid {
            actual(&at(piece, 1.0));
            continue;
        }
        let block = blocks.iter().find(|mv| mv.number == piece.number).expect("a block of that number");
        if piece.number != number {
            (number, gone, minutes) = (piece.number, 0.0, total(piece.number));
        }
        let (a, b) = (nominal.tool(&at(piece, 0.0)).0, nominal.tool(&at(piece, 1.0)).0);
        let samples = (distance(a, b) / sample_mm).ceil().clamp(4.0, 20_000.0) as usize;
        // a block of some micrometres turns an axis back: what friction throws it off at once is there for that block's time
        let turns_back = late > LATE && distance(a, b) < TURNS_BACK_MM;
        for k in 0..=samples {
            let s = k as f64 / samples as f64;
            let (tip, way) = actual(&at(piece, s));
            // the ideal place of that moment; the last digits of times are shifted to the nearest point
            let mut share = ((gone + s * piece.minutes) / minutes).min(1.0);
            let offs = |share: f64| {
                let (place, wanted) = nominal.tool(&at(block, share));
                (distance(place, tip), distance(wanted, way))
            };
            // a point of the ideal path where both are near
            let both = |share: f64| {
                let (tip, direction) = offs(share);
                (tip / TIP_MM).hypot(direction / DIRECTION_RAD)
            };
            let mut width = late;
            let rounds = if both(share) < 0.7 { 0 } else { ROUNDS };
            for _ in 0..rounds {
                let best = [share - width, share, share + width]
                    .map(|x| x.clamp(0.0, 1.0))
                    .into_iter()
                    .min_by(|x, y| both(*x).total_cmp(&both(*y)));
                share = best.expect("three");
                width *= 0.5;
            }
            let (tip_off, direction_off) = offs(share);
            found.samples += 1;
            if turns_back && k < samples {
                continue;
            }
            found.tip_mm = found.tip_mm.max(tip_off);
            found.direction_rad = found.direction_rad.max(direction_off);
        }
        gone += piece.minutes;
    }
    assert!(blocks.iter().all(|block| driven.iter().any(|mv| mv.number == block.number)), "a block is gone");
    found
}

/// Lines, arcs in three planes, helices, R, inverse time, inches, steps, offsets, tool length, turns.
fn program(first: char, second: char, tilt: f64) -> String {
    format!(
        "%\n(a part; with a comment)\nG21 G90 G17 G94 G40 G49 G54\nT1 M6\nG0 G43 H1 Z60\nG0 X0 Y0 {first}{tilt} {second}20\n\
         N10 G1 X8 Y3 Z45 F900 (first cut) M8\nN20 {second}50 F400\nN30 X-6 Z40 {first}{t2} {second}35 F700\n\
         N40 G2 X2 Y9 I7 J-1\nN50 G3 X2 Y9 I-3 J0 Z38 (turn)\nN60 G18 G2 X6 Z42 R8\nN70 G19 G3 Y12 Z44 R-6\n\
         N80 G17 G91 G1 X-3 Y-4 Z1 ; steps\nN90 {second}-12 X1\nN100 G90 G93 X4 Y4 {second}25 F12\nN110 G94 X0 F600\n\
         N120 G20 X0.2 Y0.1 F30\nN130 G3 X0.4 Y0.1 I0.1 J0. P2\nN140 G21\nN150 G10 L2 P2 X3 Y-1 Z-35 {first}1\n\
         N160 G55 G1 X1 Y1 Z40 {first}{tilt} {second}22 F800\nG4 P0.5\nN170 G54 X0 Y0 Z40 M9\nM30\n%\n",
        t2 = tilt + 6.0,
    )
}

#[test]
fn the_tool_of_an_erring_machine_is_on_the_ideal_path() {
    for (seed, (name, first, second, tilt)) in [
        ("hermle-c600u.yaml", 'A', 'C', -25.0),
        ("table-table-cb-moving-table.yaml", 'B', 'C', 30.0),
        ("head-head-ca-overhead-gantry.yaml", 'A', 'C', 20.0),
        ("table-head-cb-moving-table-y.yaml", 'B', 'C', 25.0),
        ("nutating-head-45.yaml", 'B', 'C', 60.0),
        ("nutating-table-45.yaml", 'B', 'C', 50.0),
    ]
    .into_iter()
    .enumerate()
    {
        let machine = erring(name, 100 + seed as u64);
        let text = program(first, second, tilt);
        for coordinates in [Coordinates::Axes, Coordinates::Workpiece] {
            let after = corrected(&machine, &text, settings(coordinates))
                .unwrap_or_else(|why| panic!("{name} {coordinates:?}: {why}"));
            let is_fine = seed == 0 || shipped::is_thorough();
            let sample_mm = if is_fine { SAMPLE_MM } else { COARSE_MM };
            let found = compare(&machine, coordinates, &text, &after, sample_mm);
            let uncorrected = compare(&machine, coordinates, &text, &text, 1.0);
            println!(
                "{name} {coordinates:?}: {:.3} µm, {:.4} arcsec, feed {:.1e}, {} samples; before {:.1} µm",
                1e3 * found.tip_mm,
                206_264.806 * found.direction_rad,
                found.feed,
                found.samples,
                1e3 * uncorrected.tip_mm
            );
            assert!(found.tip_mm < TIP_MM, "{name} {coordinates:?}: tip {} µm", 1e3 * found.tip_mm);
            assert!(found.direction_rad < DIRECTION_RAD, "{name} {coordinates:?}: {} rad", found.direction_rad);
            assert!(found.feed < 1e-3, "{name} {coordinates:?}: feed off by {}", found.feed);
            // the test sees the errors where nothing is corrected
            assert!(uncorrected.tip_mm > 100.0 * TIP_MM);
        }
    }
}

/// Laws of the test's own: value after a way, per unit of size.
enum Law {
    /// Free gap, mm or rad.
    Play(f64),
    /// Wind-up that relaxes over a travel.
    Windup(f64),
    /// Friction that turns round over a travel.
    Spike(f64),
    /// The part stands after each reversal until it is behind by the size; that dies away over a travel.
    Standing(f64),
}

/// An axis that remembers its way: what it adds to which component, mm or rad.
struct Remembers {
    axis: usize,
    component: Component,
    size: f64,
    law: Law,
    state: f64,
    stands: bool,
    sense: f64,
    last: Option<f64>,
}

impl Remembers {
    fn new(machine: &Machine, axis: &str, component: Component, size: f64, law: Law) -> Remembers {
        let axis = machine.axis_index(axis).expect("axis");
        Remembers { axis, component, size, law, state: 0.0, stands: false, sense: 0.0, last: None }
    }

    fn effect(&self, machine: &Machine) -> Effect {
        let own = self.component == machine.axes[self.axis].own_component();
        let (parameter, value) = match self.law {
            Law::Play(gap) => ("gap", gap),
            Law::Windup(travel) => ("take_up", travel),
            Law::Spike(travel) | Law::Standing(travel) => ("travel", travel),
        };
        let kind = match (&self.law, own, machine.axes[self.axis].kind) {
            (Law::Spike(_) | Law::Standing(_), ..) => "reversal-spike",
            (_, true, AxisKind::Linear) => "linear-backlash",
            (_, true, AxisKind::Rotary) => "rotary-backlash",
            _ => "lateral-play",
        };
        let outlet = Outlet::Motion { axis: self.axis, component: self.component };
        let effect = Effect::new(kind, EffectPlace::Axis(self.axis)).size(outlet, "", self.size);
        let effect = effect.with(parameter, ParameterValue::Number(value));
        match self.law {
            Law::Windup(_) => effect.with("windup_share", ParameterValue::Number(1.0)),
            Law::Standing(_) => effect
                .with("in_full", ParameterValue::Number(1.0))
                .with("onset", ParameterValue::Number(0.5 * self.size)),
            _ => effect,
        }
    }

    fn go(&mut self, sign: f64, q: f64) -> f64 {
        let mut way = sign * (q - *self.last.get_or_insert(q));
        // less is rounding, and waits until it is more
        if way.abs() < 1e-7 {
            way = 0.0;
        } else {
            self.last = Some(q);
        }
        let relax = |state: f64, travel: f64| way.signum() + (state - way.signum()) * (-way.abs() / travel).exp();
        if way != 0.0 {
            self.stands |= self.sense * way < 0.0;
            self.sense = way.signum();
            self.state = match self.law {
                Law::Standing(travel) => {
                    // how far the command goes on until the part is behind by the size
                    let until = if self.stands { self.size * (1.0 + self.sense * self.state) } else { 0.0 };
                    self.stands = way.abs() < until;
                    match self.stands {
                        true => self.state - way / self.size,
                        false if until > 0.0 => -self.sense * (-(way.abs() - until) / travel).exp(),
                        false => self.state * (-way.abs() / travel).exp(),
                    }
                }
                Law::Play(gap) => (self.state + 2.0 * way / gap).clamp(-1.0, 1.0),
                Law::Windup(travel) | Law::Spike(travel) => relax(self.state, travel),
            };
        }
        match self.law {
            Law::Spike(_) => 0.5 * (self.state - self.sense) * self.size,
            Law::Standing(_) => self.state * self.size,
            _ => -self.state * self.size,
        }
    }
}

fn remembering(name: &str, list: fn(&Machine) -> Vec<Remembers>, text: &str, coordinates: Coordinates) -> [Found; 2] {
    let machine = erring(name, 100);
    let remembered = |machine: &Machine| {
        let mut machine = machine.clone();
        machine.effects = list(&machine).iter().map(|one| one.effect(&machine)).collect();
        let list = take_remembered(&mut machine, &[]);
        assert!(machine.effects.is_empty());
        list
    };
    let drive = |after: &str, sample_mm: f64| {
        let tool = Tool::of(&machine, Some(LENGTH)).expect("tool");
        let mut list = list(&machine);
        let mut actual = |q: &[f64]| {
            let mut now = machine.clone();
            for one in &mut list {
                let value = one.go(machine.motion_sign(one.axis), q[one.axis]);
                let form = ComponentForm::Table {
                    position: vec![q[one.axis] - 1.0, q[one.axis] + 1.0],
                    value: vec![value; 2],
                };
                now.axes[one.axis].component_errors.push(ComponentError { component: one.component, form });
            }
            Plain { machine: &now, errs: true, tip: tool.tip_mm.into(), axis: tool.axis.into() }.tool(q)
        };
        compare_driven(&machine, coordinates, [text, after], (sample_mm, LATE_BY_REVERSALS), &mut actual)
    };
    let chain = Chain::of(&machine);
    let corrected = |list| {
        let mut compensator =
            Compensator::new(&machine, &chain, settings(coordinates)).expect("machine").with_remembered(list);
        let mut out = Vec::new();
        text.split_inclusive('\n').for_each(|line| compensator.line(line.as_bytes(), &mut out).expect("corrected"));
        String::from_utf8(out).expect("text")
    };
    let after = corrected(remembered(&machine));
    println!("{name} {coordinates:?}: {} lines of {}", after.lines().count(), text.lines().count());
    [drive(&corrected(Vec::new()), 0.2), drive(&after, 0.02)]
}

/// Axes that turn back within arcs, at corners and between moves. The rapids at its beginning make their flanks known.
const TURNING_BACK: &str = "G21 G90 G17 G94 G40 G49 G54\nT1 M6\nG0 G43 H1 Z60\nG0 X5 Y10 A-28 C60\nG0 X-3 Y0 A-20 C20\n\
    N10 G1 X8 Y3 Z45 F900\nN20 X-4 Y5\nN30 G2 X-4 Y5 I6 J0\nN40 G3 X2 Y9 Z47 R8 F700\nG0 X0 Y20 Z50\n\
    N50 G1 X5 Y12 A-26 C24\nN60 X1 Y14 Z48 A-22 C20\nN70 Z50\nN80 Z49.999 X1.5\nN90 G18 G2 X6 Z42 R8\nM30\n";

#[test]
fn lost_motion_play_and_spikes_are_taken_out_along_the_program() {
    let lists: [fn(&Machine) -> Vec<Remembers>; 4] = [
        // a dead zone: the slide stands while its drive turns round
        |machine| vec![Remembers::new(machine, "X", Component::EX, 0.002, Law::Play(0.004))],
        |machine| {
            vec![
                Remembers::new(machine, "X", Component::EX, 0.002, Law::Play(0.2)),
                Remembers::new(machine, "A", Component::EX, 0.003, Law::Play(0.2f64.to_radians())),
                Remembers::new(machine, "C", Component::EC, 2e-5, Law::Windup(0.5f64.to_radians())),
            ]
        },
        |machine| vec![Remembers::new(machine, "Y", Component::EY, 0.006, Law::Spike(0.4))],
        // a rise that is told shorter than the spike counts as long as it
        |machine| vec![Remembers::new(machine, "Y", Component::EY, 0.006, Law::Standing(0.4))],
    ];
    for (k, list) in lists.into_iter().enumerate() {
        // words of the tip leave a slide that stands trembling by a nanometre, and each time the spike's law turns back
        let both = [Coordinates::Axes, Coordinates::Workpiece];
        for &coordinates in if k >= 2 { &both[..1] } else { &both[..] } {
            let [without, found] = remembering("hermle-c600u.yaml", list, TURNING_BACK, coordinates);
            println!(
                "{coordinates:?}: {:.3} µm, {:.4} arcsec, feed {:.1e}; as the position alone {:.3} µm",
                1e3 * found.tip_mm,
                206_264.806 * found.direction_rad,
                found.feed,
                1e3 * without.tip_mm
            );
            assert!(without.tip_mm > 10.0 * TIP_MM, "{coordinates:?}: {} µm", 1e3 * without.tip_mm);
            assert!(found.tip_mm < TIP_MM, "{coordinates:?}: tip {} µm", 1e3 * found.tip_mm);
            assert!(found.direction_rad < DIRECTION_RAD, "{coordinates:?}: {} rad", found.direction_rad);
            assert!(found.feed < 0.02, "{coordinates:?}: feed off by {}", found.feed);
        }
    }
}

#[test]
fn a_move_for_which_no_command_is_right_is_refused() {
    let mut machine = erring("hermle-c600u.yaml", 100);
    // after a reversal the slide goes back by more than its command goes on
    let spike = Remembers::new(&machine, "Y", Component::EY, 0.06, Law::Spike(0.004)).effect(&machine);
    machine.effects = vec![spike];
    let list = take_remembered(&mut machine, &[]);
    let chain = Chain::of(&machine);
    let compensator = Compensator::new(&machine, &chain, settings(Coordinates::Axes)).expect("machine");
    let mut compensator = compensator.with_remembered(list);
    let mut corrected = |line: &str| compensator.line(line.as_bytes(), &mut Vec::new());
    let refused = TURNING_BACK.split_inclusive('\n').find_map(|line| corrected(line).err()).expect("a refusal");
    println!("{}: {}", refused.line, refused.reason);
    let reasons = ["turn back again and again", "an error of the machine jumps there"];
    assert!(reasons.iter().any(|reason| refused.reason.contains(reason)), "{}", refused.reason);
}

#[test]
fn an_axis_that_cuts_before_it_has_moved_is_named() {
    let mut machine = erring("hermle-c600u.yaml", 100);
    let play = |axis: &str| Remembers::new(&machine, axis, Component::EX, 0.003, Law::Play(0.2));
    let effects = [play("X").effect(&machine), play("A").effect(&machine)];
    machine.effects = effects.to_vec();
    let list = take_remembered(&mut machine, &[]);
    let chain = Chain::of(&machine);
    let unknown = |moves: &str| {
        let compensator = Compensator::new(&machine, &chain, settings(Coordinates::Axes)).expect("machine");
        let mut compensator = compensator.with_remembered(list.clone());
        let head = "G21 G90 G17 G94 G40 G49 G54\nT1 M6\nG0 G43 H1 Z60\nG0 X5 Y10 A-20 C60\n";
        for line in format!("{head}{moves}").split_inclusive('\n') {
            compensator.line(line.as_bytes(), &mut Vec::new()).expect("corrected");
        }
        compensator.summary().unknown_flanks.clone()
    };
    let found = unknown("G1 X8 Y3 F900\nX9\n");
    let a = machine.axis_index("A").unwrap();
    assert_eq!(found.iter().map(|flank| (flank.axis, flank.line)).collect::<Vec<_>>(), [(a, 5)]);
    assert!((found[0].off_mm - 0.003).abs() < 1e-9 && found[0].off_rad == 0.0, "{found:?}");
    assert!(unknown("G0 A-25\nG0 A-20\nG1 X8 Y3 F900\n").is_empty());
}

/// Ends whose rounding lies along the radius: LinuxCNC drives the whole circle.
#[test]
fn a_circle_whose_end_is_rounded_is_a_whole_circle() {
    let machine = erring("hermle-c600u.yaml", 100);
    let text = "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-25 C0\nN10 G2 X0.001 Y0 I50 F1000\nN20 G3 X0 Y0 I50\nN30 G3 X0 Y-0.00004 I50\n";
    let plain = Settings { tool_length_mm: Some(LENGTH), ..settings(Coordinates::Axes) };
    let after = corrected(&machine, text, plain).expect("corrected");
    for block in ["N10", "N20", "N30"] {
        let from = after.lines().position(|line| line.starts_with(block)).expect("block");
        let pieces = after.lines().skip(from + 1).take_while(|line| !line.starts_with('N')).count();
        assert!(pieces >= 3, "{block} is cut into {} pieces:\n{after}", pieces + 1);
    }
}

#[test]
fn arcs_stay_arcs_unless_straight_blocks_are_asked_for() {
    let machine = erring("hermle-c600u.yaml", 100);
    let text = "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-25 C0\nN10 G1 X20 F500\nN20 G3 X-20 I-20 J0 F600\nN30 G2 X20 R20\n\
                N40 G18 G91 G2 X-30 Z0 I-15 K4 C40\nN50 G90 G19 G3 Y5 Z8 R7 F300\nN60 G1 X0\n";
    let [arcs, straight] = [true, false].map(|keeps_arcs| {
        let plain = Settings { keeps_arcs, tool_length_mm: Some(LENGTH), ..settings(Coordinates::Axes) };
        corrected(&machine, text, plain).expect("corrected")
    });
    for after in [&arcs, &straight] {
        let found = compare(&machine, Coordinates::Axes, text, after, SAMPLE_MM);
        assert!(found.tip_mm < TIP_MM, "tip {} µm", 1e3 * found.tip_mm);
        assert!(found.direction_rad < DIRECTION_RAD, "{} rad", found.direction_rad);
        assert!(found.feed < 1e-3, "feed off by {}", found.feed);
    }
    let count = |after: &str| moves(after, [0.0; 6], [G54, [0.0; 6]], LENGTH).len();
    let is_arc = |after: &str| after.contains("G2") || after.contains("G3");
    assert!(is_arc(&arcs) && !is_arc(&straight.replace("G21", "")));
    println!("{} blocks with arcs, {} without", count(&arcs), count(&straight));
    assert!(10 * count(&arcs) < count(&straight));
    // the last block is straight again
    let last = arcs.lines().find(|line| line.starts_with("N60")).expect("N60");
    assert!(last.contains("G1"), "{last}");
}

/// A gauge's bar along corrected programs of a plan: marks, run-ins and arcs.
#[test]
fn a_corrected_plan_keeps_its_bar() {
    for (seed, name) in ["hermle-c600u.yaml", "table-head-cb-moving-table-y.yaml", "head-head-ca-overhead-gantry.yaml"]
        .iter()
        .enumerate()
    {
        let machine = erring(name, 300 + seed as u64);
        let mut wanted = fiveaxis::plan::Settings { feed_mm_per_min: 1500.0, ..Default::default() };
        wanted.coupled.circles = true;
        let (drawn, bodies) = load_machine_and_bodies(&file(name)).expect("machine");
        let plan = fiveaxis::plan::plan(&drawn, &bodies, &standard_kit().expect("kit"), &wanted).expect("plan");
        let plain = |errs| Plain { machine: &machine, errs, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
        let (nominal, actual) = (plain(false), plain(true));
        let mut before = 0.0f64;
        for planned in &plan.tests {
            let test = &planned.both_ways()[0];
            let bar = |machine: &Plain, place: [f64; 6]| {
                let q = positions(&nominal, Coordinates::Axes, place);
                let of = |ball: &fiveaxis::session::Ball| machine.ball(&ball.link, ball.at.into(), &q);
                distance(of(&test.pivot), of(&test.spindle_ball))
            };
            let text = fiveaxis::nc::program(&drawn, planned, &[], fiveaxis::nc::Dialect::LinuxCnc);
            let numbered: String = text
                .lines()
                .enumerate()
                .map(
                    |(k, line)| {
                        if line.starts_with('G') { format!("N{} {line}\n", k + 1) } else { format!("{line}\n") }
                    },
                )
                .collect();
            // the spindle ball is the tool's tip
            let nose = Tool::of(&machine, Some(0.0)).expect("tool").tip_mm;
            let mut plain = settings(Coordinates::Axes);
            plain.offsets[0] = Some([0.0; 9]);
            plain.initial = "G54".into();
            plain.tool_length_mm = Some((test.spindle_ball.at - nose).norm());
            let after = corrected(&machine, &numbered, plain).unwrap_or_else(|why| panic!("{name}: {why}"));
            let [planned, pieces] = [&numbered, &after].map(|text| moves(text, [0.0; 6], [[0.0; 6]; 2], 0.0));
            let mut most = 0.0f64;
            for block in planned.iter().filter(|mv| !mv.is_rapid) {
                let own: Vec<&Move> = pieces.iter().filter(|mv| mv.number == block.number).collect();
                let minutes: f64 = own.iter().map(|mv| mv.minutes).sum();
                let mut gone = 0.0;
                for piece in own {
                    for look in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
                        let share = if minutes > 0.0 { (gone + look * piece.minutes) / minutes } else { look };
                        let wanted = bar(&nominal, block.at(share));
                        // the bar is off on the way there
                        if (wanted - test.bar_length_mm.expect("bar")).abs() > 1.0 {
                            continue;
                        }
                        // feeds have six digits, by which the moment of a place is a little another
                        let driven = bar(&actual, piece.at(look));
                        let near =
                            [-3e-5, 0.0, 3e-5].map(|late| bar(&nominal, block.at((share + late).clamp(0.0, 1.0))));
                        let (low, high) =
                            (near.iter().fold(wanted, |a, b| a.min(*b)), near.iter().fold(wanted, |a, b| a.max(*b)));
                        most = most.max(driven - high).max(low - driven);
                        before = before.max((bar(&actual, block.at(share)) - wanted).abs());
                    }
                    gone += piece.minutes;
                }
            }
            println!("{name} {}: {:.3} µm", test.name, 1e3 * most);
            assert!(most < TIP_MM, "{name} {}: {} µm", test.name, 1e3 * most);
        }
        assert!(before > 100.0 * TIP_MM, "{name}: {} µm", 1e3 * before);
    }
}

#[test]
fn everything_else_stays_byte_for_byte() {
    let machine = erring("hermle-c600u.yaml", 7);
    let text = "%\r\nO7001 \r\n( keep  THIS )\r\nn5 g21g90 g17 G94 G54 G49\r\nM3 S12000\r\n\r\nG0 Z10 ; up\r\nG0 X1 Y2 A-20 C3\r\n\
                N10 g1 x5.5 F300 M8 (cut) \r\nG4 P1\r\nM9 M5\r\nG28\r\nM30\r\n%";
    let after = corrected(&machine, text, settings(Coordinates::Axes)).expect("corrected");
    let is_move = |line: &str| line.contains(['x', 'X']);
    let kept: Vec<&str> = text.split_inclusive("\r\n").filter(|line| !is_move(line)).collect();
    let found: Vec<&str> = after.split_inclusive("\r\n").filter(|line| !is_move(line)).collect();
    assert_eq!(kept, found);
    let cut = after.lines().find(|line| line.starts_with("N10")).expect("N10");
    assert!(cut.contains("F300") && cut.contains("M8") && cut.ends_with("(cut) "), "{cut:?}");
    assert!(cut.contains("G1") && !cut.contains("X5.5 "), "{cut:?}");
}

#[test]
fn modes_and_text_that_belong_to_no_move_stay_as_they_are() {
    let machine = erring("hermle-c600u.yaml", 100);
    let text = "%\nG21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-25 C0\nG1 X5 A-24 F500\nG93\nG94\nG1 X6 F500\nM30\n%\nX[#1] not of it\n\
                G1 X9\n%\n";
    let plain = Settings { tool_length_mm: Some(LENGTH), ..settings(Coordinates::Axes) };
    let after = corrected(&machine, text, plain).expect("corrected");
    let own = |word: &str| after.lines().filter(|line| *line == word).count();
    assert_eq!((own("G93"), own("G94")), (1, 1), "{after}");
    assert!(after.ends_with("%\nX[#1] not of it\nG1 X9\n%\n"), "{after}");
}

#[test]
fn a_feed_move_that_starts_uncorrected_is_told_with_its_line() {
    let machine = erring("hermle-c600u.yaml", 100);
    let chain = Chain::of(&machine);
    let plain = Settings { tool_length_mm: Some(LENGTH), ..settings(Coordinates::Axes) };
    let mut compensator = Compensator::new(&machine, &chain, plain).expect("machine");
    let text = "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-25 C0\nG1 X5 F500\nG53 G0 Z20\nG1 X6\nG1 X7\n";
    let mut out = Vec::new();
    text.split_inclusive('\n').for_each(|line| compensator.line(line.as_bytes(), &mut out).expect("corrected"));
    let starts = compensator.summary().starts_off;
    assert!(starts.line == 5 && starts.amount > 5e-3, "{starts:?}");
}

#[test]
fn what_is_not_understood_is_refused_with_its_line() {
    let machine = erring("hermle-c600u.yaml", 8);
    let head = "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-20 C0\n";
    for (line, expected) in [
        ("G81 X1 Y1 Z-3 R2 F100", "canned cycle"),
        ("G1 X#100 F100", "variable"),
        ("G1 X[1+2] F100", "variable"),
        ("G1 X F100", "X without a number"),
        ("G1 XY5 F100", "X without a number"),
        ("o100 sub", "variable"),
        ("O100 G1", "subprogram"),
        ("M98 P100", "subprogram"),
        ("G1 X1e3 F100", "letter E"),
        ("G1 X10 X20 F100", "X twice"),
        ("G1 G0 X10 F100", "G1 and G0"),
        ("G20 G21 G1 X1 F100", "G20 and G21"),
        ("G93 G1 X10", "an F of its own"),
        ("G4 P1 X10", "dwell and axis words"),
        ("G41 D1", "radius"),
        ("G68 X0 Y0 R10", "turns, scales"),
        ("G92 X0", "shifts the coordinates"),
        ("G5 X1 Y1 I1 J1", "curve"),
        ("G43.1 X5 Z20", "across its axis"),
        ("G91 G53 G0 Z50", "G53 in G91"),
        ("G91 G10 L2 P1 X5", "G90 is not in force"),
        ("G38.2 Z-5 F10", "probe"),
        ("/G1 X1 F100", "switch"),
        ("G1 B5 F100", "no such axis"),
        ("G1 X9000 F100", "outside its travel"),
        ("G1 X1", "before an F"),
        ("G2 X5 Y0 R1 F100", "too small"),
        ("G2 X5 Y0 I1 J7 F100", "from its centre"),
        ("G123 X1", "not known here"),
        ("G1 X1 F-5", "above zero"),
        ("G55 X1", "G55, whose offsets"),
        ("G43 H7 Z5", "tool 7"),
        ("G95 G1 C40 F0.1", "per revolution"),
        ("G91 G43 H1 Z5", "G91"),
        ("(open", "closing bracket"),
        ("G1 X1.2.3 F100", "no number"),
        ("G1 X1 F100 \u{1}", "code 1"),
    ] {
        let refused = corrected(&machine, &format!("{head}{line}\n"), settings(Coordinates::Axes))
            .expect_err(&format!("{line} is refused"));
        assert_eq!(refused.line, 3, "{line}");
        assert!(refused.reason.contains(expected), "{line}: {}", refused.reason);
        // with marks it stays, with a comment of one line that ends where it should
        let marked = Settings { mark: true, ..settings(Coordinates::Axes) };
        let after = corrected(&machine, &format!("{head}{line}\nM30\n"), marked).expect("marked");
        let lines: Vec<&str> = after.lines().collect();
        let at = lines.iter().position(|other| *other == line).unwrap_or_else(|| panic!("{line} is gone: {after}"));
        assert!(lines[at - 1].starts_with("(NOT CORRECTED, line 3 ") && lines[at - 1].ends_with(')'), "{after}");
        assert_eq!(lines[at - 1].matches([')', '(']).count(), 2);
    }
    for (text, expected) in [
        ("G0 X1\n", "G20 or G21; G90 or G91; G54 to G59.3; G43 or G49"),
        ("G21 G90 G54 G49\nX5\n", "no motion"),
        ("G21 G90 G94 G54 G49\nG1 X5 F100\n", "feed move while it is not known"),
        ("G21 G91 G94 G54 G49\nG0 X5\n", "absolute place first"),
    ] {
        let refused = corrected(&machine, text, settings(Coordinates::Axes)).expect_err(text);
        assert!(refused.reason.contains(expected), "{text}: {}", refused.reason);
    }
}

#[test]
fn what_ends_with_its_block_stands_in_the_last_piece_and_look_ahead_passes() {
    let machine = erring("hermle-c600u.yaml", 8);
    let text = "G21 G90 G17 G94 G54 G49\nG5.1 Q1\nG5 P10000\nG0 X0 Y0 Z0 A-20 C0\nG1 X60 C90 F500 M9\nM5\n";
    let after = corrected(&machine, text, settings(Coordinates::Axes)).expect("corrected");
    let lines: Vec<&str> = after.lines().collect();
    assert!(lines.contains(&"G5.1 Q1") && lines.contains(&"G5 P10000"), "{after}");
    let off = lines.iter().position(|line| line.contains("M9")).expect("coolant goes off");
    let moves = lines[..off].iter().filter(|line| line.contains('X')).count();
    assert!(moves > 1 && lines[off].starts_with('X') && lines.last() == Some(&"M5"), "{after}");
}

#[test]
fn increments_as_written_add_up_to_the_place() {
    let machine = erring("hermle-c600u.yaml", 100);
    let coarse = Settings { decimals: [5, 5], ..settings(Coordinates::Axes) };
    let moves = "G1 X0.500004 C0.500004 F500\n".repeat(200);
    let text = format!("G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A-20 C0\nG91\n{moves}");
    let written = corrected(&machine, &text, coarse).expect("corrected");
    let exact = corrected(&machine, &text, settings(Coordinates::Axes)).expect("corrected");
    let reaches = |text: &str, letter: char| -> f64 {
        let increments = text.lines().skip_while(|line| !line.contains("G91")).skip(1);
        let words = increments.flat_map(|line| line.split_whitespace());
        words.filter_map(|word| word.strip_prefix(letter)).map(|number| number.parse::<f64>().expect("a number")).sum()
    };
    for letter in ['X', 'C'] {
        let off = reaches(&written, letter) - reaches(&exact, letter);
        assert!(off.abs() <= 0.0000051, "{letter} ends {off} beside its place");
    }
}

#[test]
fn at_a_singular_direction_the_rotary_axes_stay_and_the_tip_is_met() {
    let machine = erring("hermle-c600u.yaml", 9);
    let text = "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 A0 C0\nN10 G1 X20 F500\nN20 C180 F2000\nN30 A-5 F300\nN40 A0\nN50 G3 X20 Y0 I-10 J0\nN60 G1 X0\n";
    let mut plain = settings(Coordinates::Axes);
    plain.tool_length_mm = Some(LENGTH);
    let after = corrected(&machine, text, plain).expect("corrected");
    let found = compare(&machine, Coordinates::Axes, text, &after, SAMPLE_MM);
    assert!(found.tip_mm < TIP_MM, "tip {} µm", 1e3 * found.tip_mm);
    // the direction keeps what no small turn takes away, less than the errors themselves
    assert!(found.direction_rad > DIRECTION_RAD && found.direction_rad < 3e-4, "{}", found.direction_rad);
    let widest = moves(&after, [0.0; 6], [G54, [0.0; 6]], LENGTH);
    let most = widest
        .iter()
        .filter(|mv| [10, 50, 60].contains(&mv.number))
        .map(|mv| mv.to[5].rem_euclid(180.0))
        .fold(0.0, f64::max);
    assert!(!(0.5..=179.5).contains(&most), "C swings by {most} deg");
}

/// Ends of moves in machine coordinates, mm and deg, as LinuxCNC's interpreter has them.
fn interpreted(text: &str) -> Option<Vec<[f64; 6]>> {
    let named = std::env::var_os("FIVEAXIS_RS274").map(PathBuf::from);
    let on_path = || {
        std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join("rs274")).find(|file| file.is_file())
    };
    let Some(rs274) = named.or_else(on_path) else {
        skipped::skipped("LinuxCNC's rs274 is neither named by FIVEAXIS_RS274 nor on the PATH");
        return None;
    };
    let folder = tempfile::tempdir().expect("folder");
    let file = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).expect("written");
        file
    };
    let parameters: String = G54
        .iter()
        .enumerate()
        .map(|(k, offset)| {
            // alone, without a machine's file, the interpreter keeps its own tables in inches
            let inches = if k < 3 { offset / 25.4 } else { *offset };
            format!("{}\t{inches:.9}\n", 5221 + k)
        })
        .collect();
    let output = Command::new(rs274)
        .current_dir(folder.path())
        .env("HOME", folder.path())
        .args(["-g", "-t"])
        .arg(file("tool.tbl", &format!("T1 P1 Z{:.9}\n", LENGTH / 25.4)))
        .arg("-v")
        .arg(file("rs274.var", &parameters))
        .arg(file("program.ngc", text))
        .stdin(std::process::Stdio::null())
        .output()
        .expect("it runs");
    let listing = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{listing}");
    let (mut unit, mut offset, mut tool, mut plane) = (1.0, [0.0; 6], 0.0, [0, 1, 2]);
    let mut ends = Vec::new();
    for line in listing.lines() {
        let Some((head, rest)) = line.split_once('(') else { continue };
        let name = head.split_whitespace().last().unwrap_or_default();
        let numbers: Vec<f64> = rest.split([',', ' ', ')']).filter_map(|word| word.trim().parse().ok()).collect();
        let length = |k: usize| if k < 3 { unit } else { 1.0 };
        match name {
            "USE_LENGTH_UNITS" => unit = if rest.contains("INCHES") { 25.4 } else { 1.0 },
            "SET_G5X_OFFSET" => offset = std::array::from_fn(|k| numbers[k + 1] * length(k)),
            "USE_TOOL_LENGTH_OFFSET" => tool = numbers.get(2).copied().unwrap_or(0.0) * unit,
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" => {
                ends.push(std::array::from_fn(|k| numbers[k] * length(k) + offset[k] + if k == 2 { tool } else { 0.0 }))
            }
            "SELECT_PLANE" => {
                plane = match rest {
                    rest if rest.contains("XZ") => [2, 0, 1],
                    rest if rest.contains("YZ") => [1, 2, 0],
                    _ => [0, 1, 2],
                }
            }
            // both ends in the plane, centre, turns, the end across, rotary axes
            "ARC_FEED" => {
                let mut end = [0.0, 0.0, 0.0, numbers[6], numbers[7], numbers[8]];
                [0, 1, 5].into_iter().zip(plane).for_each(|(number, axis)| end[axis] = numbers[number]);
                ends.push(std::array::from_fn(|k| end[k] * length(k) + offset[k] + if k == 2 { tool } else { 0.0 }));
            }
            _ => {}
        }
    }
    Some(ends)
}

#[test]
fn linuxcnc_reads_corrected_programs_as_the_reader_of_this_test_does() {
    let machine = erring("hermle-c600u.yaml", 100);
    for (keeps_arcs, least) in [(true, 90), (false, 500)] {
        let settings = Settings { keeps_arcs, ..settings(Coordinates::Axes) };
        let after = corrected(&machine, &program('A', 'C', -25.0), settings).expect("corrected");
        let Some(ends) = interpreted(&after) else { return };
        let own = moves(&after, [0.0; 6], [G54, [0.0; 6]], LENGTH);
        // the interpreter may tell a move twice where only its feed mode changes
        let mut at = 0;
        for mv in &own {
            let is_it = |end: &[f64; 6]| (0..6).all(|k| (end[k] - mv.to[k]).abs() < 3e-3);
            let found = ends[at..].iter().position(is_it);
            let found =
                found.unwrap_or_else(|| panic!("line {}: {:?} is not among the interpreter's moves", mv.line, mv.to));
            assert!(found < 3, "line {}: {found} moves between", mv.line);
            // four decimals are printed, of inches too
            let off = (0..6).map(|k| (ends[at + found][k] - mv.to[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1.5e-3, "line {}: {off}", mv.line);
            at += found + 1;
        }
        assert!(own.len() > least, "{}", own.len());
    }
}

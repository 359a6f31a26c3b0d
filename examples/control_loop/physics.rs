//! Hidden physics: location errors and one effect, as a machine file with the component error of the moment. It shares no law
//! with the library.

use std::f64::consts::TAU;

use fiveaxis::machine::{
    self, AxisKind, Component, ComponentError, ComponentForm, Harmonic, Machine, Outlet, ParameterValue, Place,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Location errors are drawn up to these, mm and rad: 50 µm and 20 arcsec.
const LARGEST: [f64; 2] = [0.05, 1e-4];

/// What a component error follows.
#[derive(Clone, Copy)]
pub enum Law {
    /// Sine over the turn of a rotary axis.
    Wave { per_turn: f64 },
    /// Sine over the travel of a slide.
    Screw { lead_mm: f64 },
    /// Square of the position; the size is reached at this distance from zero.
    Bend { over_mm: f64 },
    /// Proportional to the position.
    PerMetre,
    /// To either side by the sense of motion, taken up over this way, mm or rad.
    Play { take_up: f64 },
    /// After a reversal the slide stands while its command goes on, until it is behind by the size; that dies away over this way.
    Spike { gone_mm: f64 },
    /// With time since the first program: 1 − exp(−t/τ).
    Growth { minutes: f64 },
}

/// One component error that location errors do not know.
#[derive(Clone, Copy)]
pub struct Effect {
    pub axis: &'static str,
    pub component: Component,
    /// mm or rad.
    pub size: f64,
    pub law: Law,
}

/// The machine as it really is.
#[derive(Clone)]
pub struct Hidden {
    pub machine: Machine,
    pub effect: Option<Effect>,
    /// What slides err by along and across their ways.
    pub slides: Vec<SlideWave>,
}

/// An error of a slide: its position times a wave, so that its standard deviation grows with the way from zero.
#[derive(Clone)]
pub struct SlideWave {
    axis: usize,
    component: Component,
    /// Of cosine and sine, per mm of position.
    sizes: [f64; 2],
    /// rad per mm.
    frequency: f64,
}

/// Standard deviations of the slides' errors, those of new machines (docs/formats.md): mm per mm, and rad out of square.
const PER_MM: f64 = 5e-6;
const OUT_OF_SQUARE: f64 = 10e-6;
/// Lengths of their waves, mm.
const WAVES_MM: [f64; 2] = [800.0, 3000.0];

/// What the past of a trace has left: sense of motion and way since it turned.
pub struct State {
    flank: f64,
    /// Behind its command, as a share of the size, to either side.
    behind: f64,
    stands: bool,
    sense: f64,
    last: Option<f64>,
}

/// The machine with location errors of its rotary axes.
pub fn truth(machine: &Machine, random: &mut ChaCha8Rng) -> Machine {
    let mut truth = machine.clone();
    for axis in truth.axes.iter_mut().filter(|axis| axis.kind == AxisKind::Rotary) {
        for component in axis.slots() {
            let size = LARGEST[usize::from(component.is_angle())];
            axis.location_errors[component.index()] = size * random.random_range(-1.0..1.0);
        }
    }
    truth
}

/// Puts slides out of square, and gives what they err by beside.
pub fn erring_slides(truth: &mut Machine, random: &mut ChaCha8Rng) -> Vec<SlideWave> {
    let mut slides = Vec::new();
    for (index, axis) in truth.axes.iter_mut().enumerate().filter(|(_, axis)| axis.kind == AxisKind::Linear) {
        let along = (0..3).find(|&k| axis.direction[k].abs() > 0.999).expect("an axis along a coordinate");
        // EC0Y, EB0Z and EA0Z; the others are zero by the choice of coordinates
        for &slot in [&[][..], &[5], &[3, 4]][along] {
            axis.location_errors[slot] = OUT_OF_SQUARE * normal(random);
        }
        for component in [Component::EX, Component::EY, Component::EZ] {
            let frequency = TAU / random.random_range(WAVES_MM[0]..WAVES_MM[1]);
            let sizes = [PER_MM * normal(random), PER_MM * normal(random)];
            slides.push(SlideWave { axis: index, component, sizes, frequency });
        }
    }
    slides
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

impl SlideWave {
    /// mm at a position, mm.
    fn at(&self, q: f64) -> f64 {
        let (sine, cosine) = (self.frequency * q).sin_cos();
        q * (self.sizes[0] * cosine + self.sizes[1] * sine)
    }
}

/// A value that holds about a position.
fn held(component: Component, here: f64, value: f64) -> ComponentError {
    let form = ComponentForm::Table { position: vec![here - 1.0, here + 1.0], value: vec![value; 2] };
    ComponentError { component, form }
}

impl Hidden {
    /// What a machine file can say of it: location errors, and the effect unless it depends on time.
    pub fn as_machine_file(&self) -> Machine {
        let mut machine = self.machine.clone();
        let Some(effect) = &self.effect else { return machine };
        let wave = |frequency| ComponentForm::Fourier(vec![Harmonic { frequency, cosine: 0.0, sine: effect.size }]);
        let form = match effect.law {
            Law::Wave { per_turn } => wave(per_turn),
            Law::Screw { lead_mm } => wave(TAU / lead_mm),
            Law::Bend { over_mm } => ComponentForm::Polynomial(vec![0.0, effect.size / (over_mm * over_mm)]),
            Law::PerMetre => ComponentForm::Polynomial(vec![effect.size / 1000.0]),
            Law::Play { take_up } => return self.told(machine, play_name(effect), ("gap", take_up)),
            Law::Spike { gone_mm } => return self.told(machine, "reversal-spike", ("travel", gone_mm)),
            Law::Growth { .. } => return machine,
        };
        let index = machine.axis_index(effect.axis).expect("an axis of the machine");
        machine.axes[index].component_errors.push(ComponentError { component: effect.component, form });
        machine
    }

    /// The machine with the effect under its name in the catalogue.
    fn told(&self, mut machine: Machine, name: &str, (parameter, value): (&str, f64)) -> Machine {
        let Some(effect) = &self.effect else { return machine };
        let axis = machine.axis_index(effect.axis).expect("an axis of the machine");
        let outlet = Outlet::Motion { axis, component: effect.component };
        let told = machine::Effect::new(name, Place::Axis(axis)).size(outlet, "", effect.size);
        let mut told = told.with(parameter, ParameterValue::Number(value));
        if matches!(effect.law, Law::Spike { .. }) {
            told = told.with("in_full", ParameterValue::Number(1.0));
        }
        machine.effects.push(told);
        machine
    }
}

/// Name of a play: along or about its axis, or across it.
fn play_name(effect: &Effect) -> &'static str {
    let is_own = format!("{:?}", effect.component) == format!("E{}", effect.axis);
    match (is_own, matches!(effect.axis, "X" | "Y" | "Z")) {
        (false, _) => "lateral-play",
        (true, true) => "linear-backlash",
        (true, false) => "rotary-backlash",
    }
}

impl State {
    pub fn new() -> State {
        State { flank: 0.0, behind: 0.0, stands: false, sense: 0.0, last: None }
    }
}

impl Hidden {
    /// Takes the next positions of a trace, mm and rad by axis index, and gives the machine's errors at them.
    pub fn at(&self, state: &mut State, q: &[f64], minutes: f64) -> Machine {
        let mut machine = self.machine.clone();
        for slide in &self.slides {
            let here = q[slide.axis];
            machine.axes[slide.axis].component_errors.push(held(slide.component, here, slide.at(here)));
        }
        let Some(effect) = &self.effect else { return machine };
        let index = machine.axis_index(effect.axis).expect("an axis of the machine");
        let here = q[index];
        let way = here - state.last.replace(here).unwrap_or(here);
        let share = match effect.law {
            Law::Wave { per_turn } => (per_turn * here).sin(),
            Law::Screw { lead_mm } => (TAU * here / lead_mm).sin(),
            Law::Bend { over_mm } => (here / over_mm).powi(2),
            Law::PerMetre => here / 1000.0,
            Law::Play { take_up } => {
                state.flank = (state.flank + 2.0 * way / take_up).clamp(-1.0, 1.0);
                -state.flank
            }
            Law::Spike { gone_mm } => {
                if way != 0.0 && way.signum() != state.sense {
                    (state.sense, state.stands) = (way.signum(), true);
                }
                // how far the command goes on until the slide is behind by the size
                let until = if state.stands { effect.size * (1.0 + state.sense * state.behind) } else { 0.0 };
                let decay = |over: f64| (-over / gone_mm).exp();
                if way.abs() < until {
                    state.behind -= way / effect.size;
                } else {
                    let from = if state.stands { -state.sense } else { state.behind };
                    (state.behind, state.stands) = (from * decay(way.abs() - until), false);
                }
                state.behind
            }
            Law::Growth { minutes: constant } => 1.0 - (-minutes / constant).exp(),
        };
        // what is lost is lost in the sense in which the axis carries its part
        let sense = match effect.law {
            Law::Play { .. } | Law::Spike { .. } => machine.motion_sign(index),
            _ => 1.0,
        };
        let value = effect.size * share * sense;
        machine.axes[index].component_errors.push(held(effect.component, here, value));
        machine
    }
}

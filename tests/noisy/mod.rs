//! Sessions of the gallery with other effects and another noise: what the library's own simulation makes of them. It diagnoses
//! nothing.

use std::path::Path;

use fiveaxis::chain::Composition;
use fiveaxis::load::load_session;
use fiveaxis::machine::Effect;
use fiveaxis::session::Session;
use fiveaxis::simulate::simulate;

/// Numbers that look random and are the same everywhere (Lehmer's generator).
pub struct Draws(pub u64);

impl Draws {
    pub fn normal(&mut self) -> f64 {
        let mut even = || {
            self.0 = self.0 * 48_271 % 2_147_483_647;
            self.0 as f64 / 2_147_483_647.0
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    }
}

/// A session of the gallery.
pub fn gallery(name: &str) -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery").join(name).join("session.yaml");
    load_session(&file).expect("session")
}

/// A session with what `effects` and a gauge of 0.25 µm noise make of it.
pub fn recorded(mut session: Session, effects: Vec<Effect>) -> Session {
    session.machine.effects = effects;
    let traces = simulate(&session, Composition::Exact).expect("lengths");
    let mut draws = Draws(20_241);
    for (test, trace) in session.tests.iter_mut().zip(traces) {
        let recording = test.recording.as_mut().expect("recording");
        recording.length_mm = trace.length_mm.iter().map(|length| length + 0.25e-3 * draws.normal()).collect();
    }
    session.machine.effects.clear();
    session
}

/// The tests of a gallery session with other effects.
pub fn noisy(name: &str, effects: Vec<Effect>) -> Session {
    recorded(gallery(name), effects)
}

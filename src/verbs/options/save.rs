//! `--save DIR`: machine and session as fitted with their recordings, a folder that stands alone.

use std::fs;
use std::path::{Path, PathBuf};

use fiveaxis::chain::Chain;
use fiveaxis::readings::Part;
use fiveaxis::report::recording::path_csv;
use fiveaxis::report::urdf::machine_urdf;
use fiveaxis::report::{machine_yaml, session_yaml};
use fiveaxis::session::{Clock, Follow, Motion, Path as TestPath, Session, Test};

use crate::verbs::Refusal;
use crate::verbs::output::OutputFolder;

/// machine.yaml, the same as machine.urdf, session.yaml and the recordings. `fitted` is `session` with its errors, effects and balls as a fit found
/// them.
pub fn saved(file: &Path, session: &Session, mut fitted: Session) -> Result<OutputFolder, Refusal> {
    let mut output = OutputFolder::default();
    fitted.machine_file = "machine.yaml".into();
    output.add("machine.yaml", machine_yaml(&fitted.machine));
    output.add("machine.urdf", machine_urdf(&fitted.machine));
    output.add("session.yaml", session_yaml(&fitted));
    let beside = file.parent().map(PathBuf::from).unwrap_or_default();
    let chain = Chain::of(&session.machine);
    for test in session.tests.iter().filter(|test| test.reading.part().is_none_or(Part::leads)) {
        let (Some(name), Some(recording)) = (&test.recording_file, &test.recording) else { continue };
        if ["machine.yaml", "machine.urdf", "session.yaml"].contains(&name.as_str()) {
            return Err(format!(
                "test '{}': a recording called {name} cannot be saved beside the fit; rename it",
                test.name
            )
            .into());
        }
        if moves_with_the_balls(test) {
            // the file has no positions, and the path of the fitted places would not be the one that was run
            let motion = Motion::of(session, &chain, test)?;
            output.add(name, path_csv(&session.machine, test, &motion, &recording.length_mm, recording.column));
        } else {
            let source = beside.join(name);
            output.add(name, fs::read(&source).map_err(|why| format!("{} cannot be read: {why}", source.display()))?);
        }
    }
    Ok(output)
}

/// True when the commanded positions are worked out from the places of the balls.
fn moves_with_the_balls(test: &Test) -> bool {
    let has_no_positions = test.recording.as_ref().is_some_and(|recording| matches!(recording.clock, Clock::Absent));
    has_no_positions && !matches!(test.path, None | Some(TestPath::Sweep { follow: Follow::None, .. }))
}

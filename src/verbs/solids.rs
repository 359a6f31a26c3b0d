//! Whether a machine says what could be hit and where an instrument is mounted: without it there is nothing to plan or check.

use std::path::Path;

use fiveaxis::bodies::Bodies;
use fiveaxis::chain::Chain;
use fiveaxis::collision::World;
use fiveaxis::load::LoadError;
use fiveaxis::machine::Machine;

use super::Refusal;

/// Refuses a machine without bodies, mounts or spindle: a clearance from nothing would be no clearance.
pub fn require(file: &Path, machine: &Machine, bodies: &Bodies) -> Result<(), Refusal> {
    let parts = [
        ("'bodies'", bodies.bodies.is_empty()),
        ("'mounts'", bodies.mounts.is_empty()),
        ("'spindle'", machine.spindle.is_none()),
    ];
    let missing: Vec<&str> = parts.iter().filter(|(_, is_missing)| *is_missing).map(|(name, _)| *name).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let message = match is_urdf(file) {
        true => format!(
            "a robot description cannot say where a pivot stands and a ball is clamped{}; write its chain as a machine file with bodies, mounts and spindle, as in machines/hermle-c600u.yaml",
            if bodies.bodies.is_empty() { ", and this one has no <collision> bodies either" } else { "" }
        ),
        false => {
            format!("has no {}; add what is missing as in machines/hermle-c600u.yaml", missing.join(", no "))
        }
    };
    Err(LoadError::file(file, message).into())
}

/// True for a robot description, by its name.
pub fn is_urdf(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"))
}

/// The machine's solids; refused where some overlap with all axes at zero and are not listed as touching.
pub fn world(file: &Path, machine: &Machine, bodies: &Bodies) -> Result<World, Refusal> {
    let world = World::new(&Chain::of(machine), bodies)?;
    world.refuse_overlaps(machine).map_err(|why| LoadError::file(file, why.to_string()))?;
    Ok(world)
}

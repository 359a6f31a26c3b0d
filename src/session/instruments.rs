//! Where the instruments, targets and sockets of a session stand that its file does not place: found from the readings before any fit.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::ball::Ball;
use super::motion::Motion;
use super::second_socket::{scatter_mm, second_socket};
use super::setups::LOOKED_FOR_MM;
use super::test::{Session, Test};
use crate::chain::{Chain, Composition, Geometry, Pose};
use crate::readings::{Kind, Located, Scalar, Sighting, Target, locate};
use crate::statistics::median;

/// A link with the tag of what is mounted there.
type Mounting = (String, Option<String>);

fn mounting(ball: &Ball) -> Mounting {
    (ball.link.clone(), ball.setup.clone())
}

/// True for a place that a file left open.
fn is_open(ball: &Ball) -> bool {
    ball.at.x.is_nan()
}

/// Places instruments, targets and sockets; on refusal the test in the file and what is wrong.
pub fn locate_instruments(session: &mut Session, chain: &Chain) -> Result<(), (String, String)> {
    let firsts: Vec<usize> = (0..session.tests.len())
        .filter(|&index| session.tests[index].reading.part().is_some_and(|part| part.scalar == Scalar::Coordinate(0)))
        .collect();
    let mut done: Vec<(Mounting, Mounting)> = Vec::new();
    for &index in &firsts {
        let test = &session.tests[index];
        let key = (mounting(&test.pivot), mounting(&test.spindle_ball));
        let Some(part) = test.reading.part() else { continue };
        let (kind, of) = (part.kind, part.of.clone());
        // a second target is sought from where the instrument was found with the first one
        let is_placed = !is_open(&test.pivot) && !is_open(&test.spindle_ball);
        if done.contains(&key) || test.recording.is_none() || is_placed {
            continue;
        }
        let refuse = |message: &str| (of.clone(), message.to_string());
        match kind {
            Kind::Point | Kind::Pose => {
                let with: Vec<usize> = firsts
                    .iter()
                    .copied()
                    .filter(|&other| {
                        let test = &session.tests[other];
                        (mounting(&test.pivot), mounting(&test.spindle_ball)) == key
                    })
                    .collect();
                let sightings: Vec<Sighting> =
                    with.iter().flat_map(|&first| sightings(session, chain, first)).collect();
                let ball = &session.tests[index].spindle_ball;
                let target = if is_open(ball) { Target::Sought(Vector3::zeros()) } else { Target::Known(ball.at) };
                let found = locate(&sightings, target).ok_or_else(|| {
                    refuse("fewer than three rows have a reading; an instrument is not placed by them")
                })?;
                place(session, &key, &found);
            }
            Kind::SamePoint => place_sockets(session, chain, &firsts, &key.1)?,
            Kind::Displacement => place_sensors(session, chain, &firsts, &key.1),
            Kind::Length => {}
        }
        done.push(key);
    }
    match session.tests.iter().find(|test| is_open(&test.pivot) || is_open(&test.spindle_ball)) {
        None => Ok(()),
        Some(test) => {
            let of = test.stated_name().to_string();
            let what = if is_open(&test.pivot) { "the instrument" } else { "the target" };
            Err((of, format!("no reading tells where {what} stands; add its place, e.g. at: [100, 0, 0]")))
        }
    }
}

/// Whether the place of a ball, instrument or target is looked for by the readings.
pub fn is_looked_for(ball: &Ball) -> bool {
    ball.spread_mm.is_some_and(|spread_mm| spread_mm > LOOKED_FOR_MM)
}

/// The session with every place that was found from readings found once more, as with another machine; `None` where that cannot be.
pub fn located_anew(mut session: Session, chain: &Chain) -> Option<Session> {
    for test in &mut session.tests {
        let (is_instrument, is_target) = (is_looked_for(&test.pivot), is_looked_for(&test.spindle_ball));
        let Some(part) = test.reading.part_mut() else { continue };
        if is_instrument {
            test.pivot.at = Vector3::repeat(f64::NAN);
            // the direction of a displacement is stated
            if part.kind != Kind::Displacement {
                part.instrument_axes = Matrix3::identity();
            }
        }
        if is_target {
            (test.spindle_ball.at, part.target_axes) = (Vector3::repeat(f64::NAN), Matrix3::identity());
        }
    }
    locate_instruments(&mut session, chain).ok()?;
    Some(session)
}

/// How far the readings of a test of points or poses lie from the nominal chain with instrument and target where they fit best: medians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightedMisfit {
    /// Number of its first test in the session.
    pub first: usize,
    pub point_mm: f64,
    /// Of rotations, rad; `None` where none was read.
    pub turn_rad: Option<f64>,
}

/// The misfits of points and poses by the nominal chain.
pub fn sighted_misfits(session: &Session, chain: &Chain) -> Vec<SightedMisfit> {
    let firsts = (0..session.tests.len()).filter(|&test| session.tests[test].is_first_of_sighting());
    let of = |first: usize| {
        let found = locate(&sightings(session, chain, first), Target::Sought(Vector3::zeros()))?;
        Some(SightedMisfit { first, point_mm: found.misfit_mm, turn_rad: found.turn_misfit_rad })
    };
    firsts.filter_map(of).collect()
}

/// What was found goes to every test with this instrument or this target.
fn place(session: &mut Session, (instrument, target): &(Mounting, Mounting), found: &Located) {
    for test in &mut session.tests {
        let (is_instrument, is_target) =
            (mounting(&test.pivot) == *instrument, mounting(&test.spindle_ball) == *target);
        let Some(part) = test.reading.part_mut() else { continue };
        if is_instrument && is_open(&test.pivot) {
            test.pivot.at = found.instrument_mm;
            part.instrument_axes = found.instrument_axes;
        }
        if is_target {
            if part.target_axes == Matrix3::identity() {
                part.target_axes = found.target_axes;
            }
            if is_open(&test.spindle_ball) {
                test.spindle_ball.at = found.target_mm;
            }
        }
    }
}

/// Readings of a test, given by its first number, beside where the nominal chain puts the target.
fn sightings(session: &Session, chain: &Chain, first: usize) -> Vec<Sighting> {
    let Some(part) = session.tests[first].reading.part() else { return Vec::new() };
    let number = |k: usize, row: usize| {
        let test = session.tests.get(first + k)?;
        test.recording.as_ref().map(|recording| recording.length_mm[row])
    };
    let turn_read = session.tests.get(first + 3).filter(|_| part.kind == Kind::Pose);
    let is_turn_read =
        |row: usize| turn_read.and_then(|test| test.recording.as_ref()).is_some_and(|r| r.length_mm[row].is_finite());
    target_poses(session, chain, first)
        .into_iter()
        .enumerate()
        .filter_map(|(row, pose)| {
            let point_mm = Vector3::new(number(0, row)?, number(1, row)?, number(2, row)?);
            if point_mm.iter().any(|value| !value.is_finite()) {
                return None;
            }
            let turned = is_turn_read(row).then(|| part.measured[row]);
            Some(Sighting { rotation: pose.rotation, translation_mm: pose.translation_mm, point_mm, turned })
        })
        .collect()
}

/// The target's link as the instrument's link sees it, by row: of the machine as its file states it. None where the positions are not known.
fn target_poses(session: &Session, chain: &Chain, index: usize) -> Vec<Pose> {
    let test = &session.tests[index];
    let (Ok(motion), Ok((pivot, spindle))) = (Motion::of(session, chain, test), test.links(chain)) else {
        return Vec::new();
    };
    let errors = session.machine.location_errors();
    let geometry = Geometry::new(chain, &errors, Composition::Exact);
    let of_row = |row: usize| {
        let frame = geometry.pose(pivot, motion.row(row), None);
        let carried = geometry.pose(spindle, motion.row(row), None);
        let back = frame.rotation.transpose();
        Pose {
            rotation: back * carried.rotation,
            translation_mm: back * (carried.translation_mm - frame.translation_mm),
        }
    };
    (0..motion.rows()).map(of_row).collect()
}

/// A target and the zeros of all sensors that look at it at once: `n·(Rᵀ(C·s + c − c_i)) − o = reading`, linear in the target's place s and in
/// the zeros o along the sensors' directions n.
fn place_sensors(session: &mut Session, chain: &Chain, firsts: &[usize], target: &Mounting) {
    let looks_at = |test: &Test| {
        let is_sensor = test.reading.part().is_some_and(|part| part.kind == Kind::Displacement);
        is_sensor && mounting(&test.spindle_ball) == *target
    };
    let with: Vec<usize> = firsts.iter().copied().filter(|&index| looks_at(&session.tests[index])).collect();
    let sensor =
        |test: &Test| Some((mounting(&test.pivot), test.reading.part()?.instrument_axes.column(0).into_owned()));
    let mut sensors: Vec<(Mounting, Vector3<f64>)> = Vec::new();
    for of in with.iter().filter_map(|&index| sensor(&session.tests[index])) {
        if !sensors.contains(&of) {
            sensors.push(of);
        }
    }
    let own = |test: &Test| sensor(test).and_then(|of| sensors.iter().position(|other| *other == of));
    let columns = 3 + sensors.len();
    let (mut normal, mut right) = (DMatrix::<f64>::identity(columns, columns) * 1e-9, DVector::<f64>::zeros(columns));
    for &index in &with {
        let test = &session.tests[index];
        let (Some(own), Some(part), Some(recording)) = (own(test), test.reading.part(), &test.recording) else {
            continue;
        };
        let along = part.instrument_axes.column(0).into_owned();
        let stated = (!is_open(&test.spindle_ball)).then_some(test.spindle_ball.at);
        for (pose, reading) in target_poses(session, chain, index).iter().zip(&recording.length_mm) {
            if !reading.is_finite() {
                continue;
            }
            let mut column = DVector::<f64>::zeros(columns);
            let mut known_mm = along.dot(&pose.point(&stated.unwrap_or_default()));
            match is_open(&test.pivot) {
                true => column[3 + own] = -1.0,
                false => known_mm -= along.dot(&test.pivot.at),
            }
            if stated.is_none() {
                column.fixed_rows_mut::<3>(0).copy_from(&pose.rotation.tr_mul(&along));
            }
            normal += &column * column.transpose();
            right += column * (reading - known_mm);
        }
    }
    let Some(found) = normal.cholesky().map(|factor| factor.solve(&right)) else { return };
    for test in session.tests.iter_mut().filter(|test| looks_at(test)) {
        if is_open(&test.spindle_ball) {
            test.spindle_ball.at = Vector3::new(found[0], found[1], found[2]);
        }
        if let (Some(own), true) = (own(test), is_open(&test.pivot))
            && let Some(part) = test.reading.part()
        {
            test.pivot.at = part.instrument_axes.column(0) * found[3 + own];
        }
    }
}

/// Refuses a test whose rows put the ball, which is at `ball_mm` on its link, into two sockets.
fn refuse_second_sockets(
    session: &Session,
    chain: &Chain,
    tests: &[usize],
    ball_mm: Vector3<f64>,
) -> Result<(), (String, String)> {
    let places_in = |&index: &usize| -> Vec<Vector3<f64>> {
        sightings(session, chain, index).iter().map(|s| s.rotation * ball_mm + s.translation_mm).collect()
    };
    let places: Vec<Vec<Vector3<f64>>> = tests.iter().map(places_in).collect();
    let scatters_mm: Vec<f64> = places.iter().map(|places| scatter_mm(places)).collect();
    for (own, (&index, places)) in tests.iter().zip(&places).enumerate() {
        let others = scatters_mm.iter().enumerate().filter(|(other, _)| *other != own).map(|(_, scatter)| *scatter);
        if let Some(message) = second_socket(places, median(others).unwrap_or(0.0)) {
            let test = &session.tests[index];
            return Err((test.stated_name().to_string(), message));
        }
    }
    Ok(())
}

/// Ball and all its sockets at once: `C·s + c = o` for every row, linear in the ball's place s and the sockets' o.
fn place_sockets(
    session: &mut Session,
    chain: &Chain,
    firsts: &[usize],
    ball: &Mounting,
) -> Result<(), (String, String)> {
    let with: Vec<usize> = firsts
        .iter()
        .copied()
        .filter(|&index| {
            let test = &session.tests[index];
            test.reading.part().is_some_and(|part| part.kind == Kind::SamePoint)
                && mounting(&test.spindle_ball) == *ball
        })
        .collect();
    let mut sockets: Vec<Mounting> = Vec::new();
    for &index in &with {
        let socket = mounting(&session.tests[index].pivot);
        if !sockets.contains(&socket) {
            sockets.push(socket);
        }
    }
    let columns = 3 + 3 * sockets.len();
    let (mut normal, mut right) = (DMatrix::<f64>::identity(columns, columns) * 1e-9, DVector::<f64>::zeros(columns));
    for &index in &with {
        let socket = mounting(&session.tests[index].pivot);
        let Some(own) = sockets.iter().position(|other| *other == socket).map(|place| 3 + 3 * place) else { continue };
        for s in sightings(session, chain, index) {
            // the identity on the socket's place cancels for a ball that does not move against it
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                normal[(i, j)] += if i == j { 1.0 } else { 0.0 };
                normal[(own + i, own + j)] += if i == j { 1.0 } else { 0.0 };
                normal[(i, own + j)] -= s.rotation[(j, i)];
                normal[(own + i, j)] -= s.rotation[(i, j)];
            }
            let seen = s.rotation.transpose() * s.translation_mm;
            for k in 0..3 {
                right[k] -= seen[k];
                right[own + k] += s.translation_mm[k];
            }
        }
    }
    let Some(found) = normal.cholesky().map(|factor| factor.solve(&right)) else { return Ok(()) };
    let part = |from: usize| Vector3::new(found[from], found[from + 1], found[from + 2]);
    refuse_second_sockets(session, chain, &with, part(0))?;
    for test in &mut session.tests {
        let is_ball = mounting(&test.spindle_ball) == *ball
            && test.reading.part().is_some_and(|part| part.kind == Kind::SamePoint);
        if !is_ball {
            continue;
        }
        if is_open(&test.spindle_ball) {
            test.spindle_ball.at = part(0);
        }
        let socket = mounting(&test.pivot);
        if let Some(place) = sockets.iter().position(|other| *other == socket).filter(|_| is_open(&test.pivot)) {
            test.pivot.at = part(3 + 3 * place);
        }
    }
    Ok(())
}

//! Where the two balls may be mounted: pivots on the mounts, the spindle ball on stem and fixture. Whether a bar fits between them is not asked here.

use nalgebra::Vector3;

use super::candidate::{PivotSite, SpindlePlace};
use crate::bodies::{Bodies, Kit, Mount, Outline};
use crate::chain::Chain;
use crate::machine::{Axis, AxisKind, Machine};

/// |cos| between an axis and the normal of a surface below which the axis lies along the surface.
const ALONG_SURFACE: f64 = 0.1;
/// |cos| between them from which the axis stands upright on the surface.
const UPRIGHT: f64 = 0.99;
/// sin² of the angle between a way and an axis below which the way does not lead nearer to the axis or away from it.
const PARALLEL: f64 = 1e-4;
/// Square of what a point may lie off a cylinder that a way touches, as a share of its radius'.
const TOUCHING: f64 = 1e-14;
/// Nearest setups of the stem that are tried for a fixture's arm, or without one.
const MOST_REACHES: usize = 4;

/// Lines nearer to each other than this meet, mm.
const MEETING_MM: f64 = 1e-3;
/// Points of a circle about an axis that are tried.
const AROUND: i32 = 24;

/// Which places are offered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Offer {
    /// Spread over what the kit allows: a free choice finds what tells most among them.
    Spread,
    /// Those, every arm a bar's length from each axis at any inclination and the lowest stand beside heads too: methods of the
    /// thesis ask for the shortest bar across the axis, and for the next longer one from there.
    Level,
    /// The same, and every pivot with every spindle ball: one pivot and one ball are to serve all axes.
    Common,
    /// One pivot near one that was chosen, with every spindle ball of a free choice.
    Near,
}

impl Offer {
    /// The places that methods of the thesis ask for are among them.
    fn is_for_methods(self) -> bool {
        matches!(self, Offer::Level | Offer::Common)
    }
}

/// Pivot ball places on all mounts.
pub(crate) fn pivot_sites(
    machine: &Machine,
    chain: &Chain,
    bodies: &Bodies,
    kit: &Kit,
    offer: Offer,
) -> Vec<PivotSite> {
    let all_rotary: Vec<&Axis> = rotary(machine).map(|k| &machine.axes[k]).collect();
    let mut all = Vec::new();
    for (index, mount) in distinct_mounts(bodies) {
        if let Some(link) = chain.link(&mount.link) {
            let carrying: Vec<&Axis> =
                rotary(machine).filter(|&k| chain.carries(k, link)).map(|k| &machine.axes[k]).collect();
            all.extend(on_mount(kit, mount, (&all_rotary, &carrying), offer).into_iter().map(|[u, v, height_mm]| {
                let at = (mount.point(u, v) + mount.normal * height_mm).map(|x| tidy(x, NANOMETRE));
                PivotSite { mount: index, link, at, height_mm }
            }));
        }
    }
    all
}

/// The place on the same mount that lies some way along, across and above from another, to the millimetre; `None` where the stand
/// has no room.
pub(crate) fn moved_site(bodies: &Bodies, kit: &Kit, site: &PivotSite, way_mm: [f64; 3]) -> Option<PivotSite> {
    let mount = &bodies.mounts[site.mount];
    let from = site.at - mount.middle;
    let beside = [from.dot(&mount.along), from.dot(&mount.across()), from.dot(&mount.normal)];
    // what does not move keeps its place to the nanometre
    let [u, mut v, height_mm] =
        [0, 1, 2].map(|k| if way_mm[k] == 0.0 { beside[k] } else { (beside[k] + way_mm[k]).round() + 0.0 });
    if let Some(pitch) = mount.slot_pitch_mm {
        v = (v / pitch).round() * pitch;
    }
    let [lowest, highest] = kit.pivot_stand.height_mm;
    let stands = mount.holds(u, v, kit.pivot_stand.base_radius_mm) && (lowest..=highest).contains(&height_mm);
    let at = (mount.point(u, v) + mount.normal * height_mm).map(|x| tidy(x, NANOMETRE));
    stands.then_some(PivotSite { at, height_mm, ..*site })
}

/// Mounts with their indices; a surface listed twice, under whatever name, offers nothing new and counts once.
pub(crate) fn distinct_mounts(bodies: &Bodies) -> impl Iterator<Item = (usize, &Mount)> {
    let is_new = |(index, mount): &(usize, &Mount)| {
        let is_same = |other: &Mount| Mount { name: mount.name.clone(), ..other.clone() } == **mount;
        !bodies.mounts[..*index].iter().any(is_same)
    };
    bodies.mounts.iter().enumerate().filter(is_new)
}

fn rotary(machine: &Machine) -> impl Iterator<Item = usize> {
    machine.axes_of(AxisKind::Rotary)
}

/// Balls on a mount, given all rotary axes and those that carry it: along, across and above the surface, mm.
fn on_mount(kit: &Kit, mount: &Mount, (all, carrying): (&[&Axis], &[&Axis]), offer: Offer) -> Vec<[f64; 3]> {
    let [lowest, highest] = kit.pivot_stand.height_mm;
    let edge = kit.pivot_stand.base_radius_mm;
    let upright = |axis: &Axis| axis.direction.dot(&mount.normal).abs();
    // level with an axis line that runs along the surface and carries it: h = 0 becomes possible for several axes at once
    let mut heights: Vec<f64> = carrying
        .iter()
        .filter(|axis| upright(axis) < ALONG_SURFACE)
        .map(|axis| (axis.origin - mount.middle).dot(&mount.normal))
        .filter(|height| *height >= lowest && *height <= highest)
        .collect();
    heights.extend([lowest.max(60.0).min(highest), (lowest + highest) * 0.5, highest]);
    if carrying.is_empty() && offer.is_for_methods() {
        // beside a head every millimetre of its slides counts
        heights.push(lowest);
    }
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    let mut points = spread_over(kit, mount);
    for axis in carrying.iter().filter(|axis| upright(axis) < ALONG_SURFACE) {
        points.extend(beside_axis_along(kit, mount, axis));
    }
    // where an axis line meets the surface: a ball that stands still there needs no slide to bring it onto the line
    for axis in all.iter().filter(|axis| upright(axis) > UPRIGHT) {
        let from = axis.origin - mount.middle;
        points.push([from.dot(&mount.along), from.dot(&mount.across())].map(|x| tidy(x, MICROMETRE)));
    }
    let mut balls: Vec<[f64; 3]> =
        points.iter().flat_map(|&[u, v]| heights.iter().map(move |&height| [u, v, height])).collect();
    for axis in carrying.iter().filter(|axis| (ALONG_SURFACE..=UPRIGHT).contains(&upright(axis))) {
        balls.extend(heights.iter().flat_map(|&height| beside_inclined_axis(kit, mount, axis, height)));
    }
    if offer == Offer::Common {
        for axis in carrying.iter().filter(|axis| upright(axis) > UPRIGHT) {
            // beside lines that cross along the surface a level place serves both
            let is_served = |other: &&&Axis| upright(other) < ALONG_SURFACE && apart_mm(axis, other) < MEETING_MM;
            for other in carrying.iter().filter(|other| upright(other) <= UPRIGHT).filter(|other| !is_served(other)) {
                balls.extend(beside_both(kit, mount, (axis, other), (lowest, highest)));
            }
        }
    }
    if let Some(pitch) = mount.slot_pitch_mm {
        for [_, v, _] in &mut balls {
            *v = (*v / pitch).round() * pitch;
        }
    }
    balls.retain(|&[u, v, _]| mount.holds(u, v, edge));
    balls.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2])));
    balls.dedup();
    balls
}

/// Points all over a surface: bar lengths from its middle on a disc, a grid on a rectangle, mm.
fn spread_over(kit: &Kit, mount: &Mount) -> Vec<[f64; 2]> {
    match mount.outline {
        Outline::Disc { inner_radius_mm, .. } => {
            let mut radii: Vec<f64> = kit.lengths_mm();
            let most = mount.extent_mm() - kit.pivot_stand.base_radius_mm;
            let least = inner_radius_mm + kit.pivot_stand.base_radius_mm;
            // on a narrow ring the usual place is in the hole
            radii.push(if inner_radius_mm > 0.0 && 0.6 * most < least { 0.5 * (least + most) } else { 0.6 * most });
            let around = |radius: f64| {
                (0..8).map(move |eighth| {
                    let (s, c) = (f64::from(eighth) * std::f64::consts::FRAC_PI_4).sin_cos();
                    [radius * c, radius * s].map(|x| tidy(x, MICROMETRE))
                })
            };
            radii.into_iter().flat_map(around).collect()
        }
        Outline::Rectangle { size_mm } => {
            let steps = |size: f64| [-0.4, -0.2, 0.0, 0.2, 0.4].map(|part| (part * size).clamp(-400.0, 400.0));
            let [us, vs] = size_mm.map(steps);
            us.iter().flat_map(|&u| vs.iter().map(move |&v| [u, v].map(|x| tidy(x, MICROMETRE)))).collect()
        }
    }
}

/// A bar's length from an axis that lies along the surface, at either end of what the surface allows (chapter 6), mm.
fn beside_axis_along(kit: &Kit, mount: &Mount, axis: &Axis) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    let Some(way) = in_surface(mount, axis) else { return points };
    let (a, b) = (way.dot(&mount.along), way.dot(&mount.across()));
    let from = axis.origin - mount.middle;
    let offset = from.dot(&mount.along) * -b + from.dot(&mount.across()) * a;
    for length in kit.lengths_mm() {
        for across in [offset - length, offset + length] {
            for t in ends_of(kit, mount, across) {
                points.push([a * t - b * across, b * t + a * across].map(|x| tidy(x, MICROMETRE)));
            }
        }
    }
    points
}

/// A bar's length from an axis that meets the surface at an angle, balls at one height: the cylinder about the axis cuts their
/// plane in an ellipse, of which the ends along the axis and, beside the middle and either end of the surface, its flanks are taken.
fn beside_inclined_axis(kit: &Kit, mount: &Mount, axis: &Axis, height_mm: f64) -> Vec<[f64; 3]> {
    let mut balls = Vec::new();
    let Some(way) = in_surface(mount, axis) else { return balls };
    let flank = mount.normal.cross(&way);
    let plane = mount.middle + mount.normal * height_mm;
    let mut push = |from_middle: Vector3<f64>| {
        let [u, v] = [from_middle.dot(&mount.along), from_middle.dot(&mount.across())].map(|x| tidy(x, NANOMETRE));
        balls.push([u, v, height_mm]);
    };
    for length in kit.lengths_mm() {
        at_distance(axis, &plane, &way, length).into_iter().for_each(|t| push(way * t));
        for t in ends_of(kit, mount, 0.0) {
            at_distance(axis, &(plane + way * t), &flank, length).into_iter().for_each(|s| push(way * t + flank * s));
        }
    }
    balls
}

/// A bar's length from an upright axis and from another one alike: points of the circle about the first, each at the heights
/// at which the second is as far away, mm.
fn beside_both(
    kit: &Kit,
    mount: &Mount,
    (upright, other): (&Axis, &Axis),
    (lowest, highest): (f64, f64),
) -> Vec<[f64; 3]> {
    let from = upright.origin - mount.middle;
    let centre = mount.along * from.dot(&mount.along) + mount.across() * from.dot(&mount.across());
    let mut balls = Vec::new();
    for length in kit.lengths_mm() {
        for step in 0..AROUND {
            let (s, c) = (std::f64::consts::TAU * f64::from(step) / f64::from(AROUND)).sin_cos();
            let foot = centre + (mount.along * c + mount.across() * s) * length;
            for height in at_distance(other, &(mount.middle + foot), &mount.normal, length) {
                if (lowest..=highest).contains(&height) {
                    let [u, v] = [foot.dot(&mount.along), foot.dot(&mount.across())].map(|x| tidy(x, NANOMETRE));
                    balls.push([u, v, tidy(height, NANOMETRE)]);
                }
            }
        }
    }
    balls
}

/// Distance of two axis lines that are not parallel, mm.
fn apart_mm(one: &Axis, other: &Axis) -> f64 {
    let across = one.direction.cross(&other.direction);
    across.try_normalize(PARALLEL).map_or(f64::MAX, |across| (other.origin - one.origin).dot(&across).abs())
}

/// Direction of an axis within a surface, unless it is nearly upright on it.
fn in_surface(mount: &Mount, axis: &Axis) -> Option<Vector3<f64>> {
    (axis.direction - mount.normal * mount.normal.dot(&axis.direction)).try_normalize(0.1)
}

/// Middle and ends of what a surface has room for, `across_mm` beside its middle, mm.
fn ends_of(kit: &Kit, mount: &Mount, across_mm: f64) -> [f64; 3] {
    let room = (mount.extent_mm() - kit.pivot_stand.base_radius_mm).powi(2) - across_mm * across_mm;
    [-1.0, 0.0, 1.0].map(|end| end * (0.98 * room.max(0.0).sqrt()).min(300.0))
}

/// How far to go from a point along a way to stand `length_mm` from an axis line: `|w + t·d| = L` with w and d the parts of
/// point and way across the line, all axes at zero. At most two places.
fn at_distance(axis: &Axis, from: &Vector3<f64>, way: &Vector3<f64>, length_mm: f64) -> Vec<f64> {
    let (w, d) = (across(axis, &(from - axis.origin)), across(axis, way));
    let (a, b, c) = (d.norm_squared(), w.dot(&d), w.norm_squared() - length_mm * length_mm);
    let under = b * b - a * c;
    // rounding must not lose the one point at which a way touches the cylinder
    let touches = under.abs() < TOUCHING * a * length_mm * length_mm;
    if a < PARALLEL || under < 0.0 && !touches {
        return Vec::new();
    }
    if touches {
        return vec![-b / a];
    }
    [-under.sqrt(), under.sqrt()].map(|root| (root - b) / a).to_vec()
}

/// The part of a vector across an axis.
fn across(axis: &Axis, vector: &Vector3<f64>) -> Vector3<f64> {
    vector - axis.direction * vector.dot(&axis.direction)
}

/// Places are stated to the micrometre where anything near will do, finer where a bar's length is to be met.
const MICROMETRE: f64 = 1e3;
const NANOMETRE: f64 = 1e6;

/// Rounded to `1/per_mm`, zero without a sign.
fn tidy(value_mm: f64, per_mm: f64) -> f64 {
    (value_mm * per_mm).round() / per_mm + 0.0
}

/// Spindle ball on the tool axis and on fixtures, nearest the nose first.
pub(crate) fn spindle_places(machine: &Machine, chain: &Chain, kit: &Kit, offer: Offer) -> Vec<SpindlePlace> {
    let Some(spindle) = &machine.spindle else { return Vec::new() };
    let Some(link) = chain.link(&spindle.link) else { return Vec::new() };
    let base = spindle.ball();
    let heads: Vec<&Axis> = rotary(machine).filter(|&k| chain.carries(k, link)).map(|k| &machine.axes[k]).collect();
    let side = [Vector3::x(), Vector3::y(), Vector3::z()]
        .iter()
        .find_map(|axis| (axis - spindle.direction * spindle.direction.dot(axis)).try_normalize(0.5))
        .unwrap_or_else(Vector3::x);
    let across = spindle.direction.cross(&side);
    let mut asides = vec![(0.0, Vector3::zeros())];
    let arms = kit.fixture.as_ref().map(|fixture| fixture.arms_mm.as_slice()).unwrap_or_default();
    for &arm in arms.iter().filter(|_| !heads.is_empty()) {
        asides.extend([side, -side, across, -across].map(|direction| (arm, direction * arm)));
    }
    let down = -spindle.direction;
    let on_tool = reaches(kit, &heads, &base, &down);
    let mut places = Vec::new();
    for (order, (aside_mm, aside)) in asides.into_iter().enumerate() {
        // an arm along the axis is level where the straight stem is, one aside of it elsewhere
        let mut lengths = on_tool.clone();
        if offer.is_for_methods() {
            lengths.extend(reaches(kit, &heads, &(base + aside), &down));
            sort_apart(&mut lengths);
        }
        places.extend(lengths.into_iter().map(|reach| {
            let at = base + aside + down * reach;
            (reach, order, SpindlePlace { link, at, aside_mm })
        }));
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    places.into_iter().map(|(.., place)| place).collect()
}

/// How far the stem may bring a ball down the tool, mm: not at all, to a bar's length from a rotary axis that carries it, all of it.
fn reaches(kit: &Kit, heads: &[&Axis], ball: &Vector3<f64>, down: &Vector3<f64>) -> Vec<f64> {
    let mut reaches = vec![0.0, kit.spindle_reach_mm];
    for axis in heads {
        let beside_mm = across(axis, &(ball - axis.origin)).norm();
        let is_along = across(axis, down).norm_squared() < PARALLEL;
        let level = kit.lengths_mm().into_iter().flat_map(|length| match is_along {
            // an axis along the tool is as far whatever the stem: other heights
            true => vec![length - beside_mm],
            false => at_distance(axis, ball, down, length),
        });
        reaches.extend(level.map(|reach| tidy(reach, NANOMETRE)).filter(|&r| r > 1.0 && r <= kit.spindle_reach_mm));
    }
    sort_apart(&mut reaches);
    reaches.truncate(MOST_REACHES);
    reaches
}

/// In order, without what is less than a millimetre from the one before.
fn sort_apart(lengths_mm: &mut Vec<f64>) {
    lengths_mm.sort_by(f64::total_cmp);
    lengths_mm.dedup_by(|a, b| (*a - *b).abs() < 1.0);
}

//! The scene of the collision bench against brute force: parry over all pairs, with link poses from the chain's own kinematics.

#[path = "../benches/peer_scene/mod.rs"]
mod scene_of_peers;

use fiveaxis::bodies::frame_along;
use fiveaxis::chain::{Branch, Chain, Geometry, LinkId, Pose};
use fiveaxis::collision::{Scratch, World, parry_shape};
use nalgebra::Vector3;
use scene_of_peers::{bodies, machine, poses, scene, set_pivot};

#[test]
fn least_distance_and_verdict_agree_with_parry_over_all_pairs() {
    let machine = machine();
    let chain = Chain::of(&machine);
    let geometry = Geometry::nominal(&chain);
    let mut world = World::new(&chain, &bodies()).expect("links");
    world.forget_machine_pairs();
    let mut scene = scene(&world, Vector3::zeros());
    assert_eq!(scene.pairs().len(), 58);
    let mut scratch = Scratch::default();
    let (mut worst, mut clear, mut close) = (0.0f64, 0, 0);
    for (pivot, q) in &poses(3_000) {
        set_pivot(&mut scene, pivot);
        let (ours, _) = scene.least(q, &mut scratch);
        let link = |branch, depth| geometry.pose(LinkId { branch, depth }, q, None);
        // frames: bed, then the workpiece side from the bed out, then the tool side, then the bar
        let mut frames: Vec<Pose> = (0..=3).map(|depth| link(Branch::Workpiece, depth)).collect();
        frames.extend((1..=2).map(|depth| link(Branch::Tool, depth)));
        let from = frames[3].point(pivot);
        let way = frames[5].point(&Vector3::zeros()) - from;
        frames.push(Pose { rotation: frame_along(&way.normalize()), translation_mm: from });
        let brute = scene
            .pairs()
            .iter()
            .map(|&(one, other)| {
                let placed = |part: usize| {
                    let part = &scene.parts()[part];
                    parry_shape(&part.convex, &frames[part.frame]).expect("parry takes every solid")
                };
                let ((a, at_a), (b, at_b)) = (placed(one), placed(other));
                parry3d::query::distance(&at_a, &*a.0, &at_b, &*b.0).expect("supported").distance
            })
            .fold(f64::MAX, f64::min);
        if brute > 1e-6 {
            worst = worst.max((ours - brute).abs());
            clear += 1;
        } else {
            assert!(ours < 1e-5, "parry says touching, we say {ours}");
        }
        // parry's accuracy decides nothing here
        if (brute - 5.0).abs() > 1e-4 {
            assert_eq!(scene.closer_than(q, 5.0, &mut scratch), brute < 5.0, "{brute}");
        }
        close += usize::from(brute < 5.0);
    }
    println!("{clear} clear poses of 3000, {close} closer than 5 mm, largest difference {worst:.1e} mm");
    assert!(clear > 2_000 && close > 100);
    assert!(worst < 1e-4);
}

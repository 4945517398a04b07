//! Tests that moving objects never meet others, and that frames are reproducible.

use std::collections::BTreeMap;

use cull::Aabb;

use super::*;
use crate::{city, field};

fn scenes() -> Vec<Scene> {
    vec![city(1_500, 3).unwrap().scene, field(400, 3).unwrap().scene, city(1, 1).unwrap().scene]
}

#[test]
fn as_many_move_as_were_asked_for_and_never_the_ground() {
    for scene in scenes() {
        for percent in [0, 1, 10, 50] {
            let motion = Motion::new(&scene, percent, 1).unwrap();
            let ground = scene.objects.iter().filter(|o| is_ground(&scene, o)).count();
            let wanted = (scene.objects.len() * percent as usize).div_ceil(100);
            assert_eq!(motion.movers(), wanted.min(scene.objects.len() - ground));
            assert!(motion.movers.iter().all(|mover| !is_ground(&scene, &mover.object)));
        }
    }
    let error = Motion::new(&city(10, 1).unwrap().scene, 101, 1).unwrap_err().to_string();
    assert!(error.contains("101") && error.contains("0 to 100"), "{error}");
}

fn is_ground(scene: &Scene, object: &Object) -> bool {
    scene.mesh_of(object).unwrap().name.starts_with(GROUND)
}

#[test]
fn most_have_room_and_some_big_ones_move() {
    let scene = city(4_000, 3).unwrap().scene;
    let motion = Motion::new(&scene, 10, 1).unwrap();
    let staying = motion.movers.iter().filter(|mover| mover.act == Act::Stay).count();
    assert!(staying * 10 < motion.movers(), "{staying} of {} stay", motion.movers());
    let height = |mover: &Mover| {
        let bounds = scene.bounds_of(&mover.object).unwrap();
        bounds.max.y - bounds.min.y
    };
    let big = motion.movers.iter().filter(|m| m.act != Act::Stay && height(m) > BIG_M).count();
    assert!(big * 30 > motion.movers(), "{big} big ones");
    let guests = motion.movers.iter().filter(|mover| mover.presence.is_some()).count();
    assert!(guests * 10 > motion.movers(), "{guests} come and go");
}

#[test]
fn nobody_leaves_its_sweep_and_no_sweep_meets_another() {
    for scene in scenes() {
        let motion = Motion::new(&scene, 100, 5).unwrap();
        let mut spaces: BTreeMap<u32, Aabb> = (0..)
            .zip(&scene.objects)
            .filter(|(_, object)| !is_ground(&scene, object))
            .map(|(index, object)| (index, scene.bounds_of(object).unwrap()))
            .collect();
        let crowded = |act: &Act| *act == Act::Stay;
        for mover in &motion.movers {
            let bounds = scene.bounds_of(&mover.object).unwrap();
            let sweep = mover.act.sweep(&bounds);
            for frame in (0..700).step_by(7) {
                if let Some(object) = mover.at(frame) {
                    let now = scene.bounds_of(&object).unwrap();
                    // The box of a turned box is larger than its contents.
                    if !matches!(mover.act, Act::Turn { .. }) {
                        assert!(
                            sweep.enlarged(1.0e-3).contains(&now),
                            "{:?} at {frame}",
                            mover.act
                        );
                    }
                }
            }
            spaces.insert(mover.index, sweep);
        }
        for mover in motion.movers.iter().filter(|mover| !crowded(&mover.act)) {
            let space = spaces[&mover.index].enlarged(0.005);
            let met = spaces.iter().find(|(index, other)| {
                **index != mover.index
                    && other.min.cmple(space.max).all()
                    && space.min.cmple(other.max).all()
            });
            assert_eq!(met, None, "{} is met", mover.index);
        }
    }
}

#[test]
fn a_cast_follows_in_any_order_and_gives_every_id_to_one() {
    let scene = city(800, 3).unwrap().scene;
    let motion = Motion::new(&scene, 100, 5).unwrap();
    let mut cast = Cast::new(&motion);
    // The used ids, as a renderer would assign them.
    let mut shown: BTreeMap<ObjectId, Object> =
        (0..).map(ObjectId).zip(scene.objects.iter().copied()).collect();
    let all: Vec<ObjectId> = shown.keys().copied().collect();
    for frame in [0, 1, 2, 3, 40, 41, 7, 8, 1_000, 0, 0] {
        let mut added = Vec::new();
        for change in cast.changes(&motion, frame).to_vec() {
            match change {
                ObjectChange::Move { object, transform } => {
                    shown.get_mut(&object).expect("someone is there").transform = transform;
                }
                ObjectChange::Remove { object } => {
                    assert!(shown.remove(&object).is_some());
                }
                ObjectChange::Add { object } => {
                    let free = all.iter().rev().find(|id| !shown.contains_key(id)).unwrap();
                    shown.insert(*free, object);
                    added.push(*free);
                }
            }
        }
        cast.came(&added);
        let key = |object: &Object| format!("{object:?}");
        let mut found: Vec<String> = shown.values().map(key).collect();
        let mut wanted: Vec<String> =
            motion.scene_at(&scene, frame).objects.iter().map(key).collect();
        found.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(found, wanted, "frame {frame}");
        assert!(wanted.len() < scene.objects.len(), "some are away");
    }
}

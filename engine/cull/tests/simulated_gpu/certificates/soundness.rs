//! Tests that nothing certified ever shows a sample: in random scenes, from random eyes within the
//! radius, with any direction of sight, jitter, and snapping of vertices.

use antumbra_cull::{Aabb, Camera, ClipY, CullView, DepthConvention, Projection};
use glam::{Vec2, Vec3};

use super::Certificate;
use super::occluders::{Setting, eroded_surfaces, shrunk_solids};
use crate::image::{Image, Shift};
use crate::optics::Optics;
use crate::random::Random;
use crate::scene::{Path, Scene};

const SIZE: [u32; 2] = [96, 64];
const SUB_PIXEL_BITS: u32 = 8;
const SEEDS: u64 = 60;
const EYES: usize = 12;
const PROBES: usize = 60;

type Construction = fn(&Setting, &Camera, &[Aabb]) -> Certificate;

/// The counts of the checked boxes.
#[derive(Debug, Default)]
struct Checked {
    boxes: usize,
    certified: usize,
    /// Certified boxes in the frustum of a later eye.
    seen: usize,
    /// Boxes that a later eye saw.
    shown: usize,
}

/// Returns a random direction of unit length.
fn direction(random: &mut Random) -> Vec3 {
    loop {
        let point = random.point(-1.0, 1.0);
        if (0.01..1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}

/// Returns a view from an eye within the radius, mostly at its edge and beside the line from the
/// camera to a box, in the direction of the box or any other.
fn later_view(camera: &Camera, radius_m: f32, aim: &Aabb, random: &mut Random) -> CullView {
    let way = direction(random);
    let line = (aim.centre() - camera.eye).normalize_or(Vec3::Z);
    let aside = (way - line * way.dot(line)).normalize_or(Vec3::Y);
    let way = if random.chance(0.8) { aside } else { way };
    let eye = camera.eye + way * radius_m * 0.9999;
    let towards = aim.min + (aim.max - aim.min) * random.point(0.0, 1.0) - eye;
    let turned = towards + random.point(-0.3, 0.3) * towards.length();
    let forward = if random.chance(0.3) { camera.forward } else { turned };
    let camera = Camera { eye, forward, ..*camera };
    let optics = Optics {
        depth: DepthConvention::Reversed,
        y: ClipY::Down,
        far: None,
        off_centre: Vec2::ZERO,
        jitter: 0.5,
        scale: 1.0,
    };
    optics.view(&camera, random.below(64) as u64, SIZE, SUB_PIXEL_BITS)
}

/// Returns a small box behind a random solid, mostly near the outline of the solid.
fn probe(camera: &Camera, solids: &[Aabb], random: &mut Random) -> Aabb {
    let solid = solids[random.below(solids.len())];
    let corner = random.point(0.0, 1.0).round();
    let share = corner.lerp(Vec3::splat(0.5), random.between(0.0, 0.3));
    let point = solid.min + (solid.max - solid.min) * share;
    let times = random.between(1.0, 3.0).powi(3);
    let way = (point - camera.eye) * times;
    let centre = camera.eye + way;
    let half = random.point(0.002, 0.02) * way.length();
    Aabb::new(centre - half, centre + half)
}

/// Returns random shifts by the sub-pixel grid.
fn shifts(count: usize, random: &mut Random) -> Vec<Shift> {
    let step = 0.5_f32.powi(SUB_PIXEL_BITS as i32);
    (0..count).map(|_| [0, 1].map(|_| f64::from(random.between(-step, step)))).collect()
}

/// Checks the boxes of one random scene.
fn check(seed: u64, construct: Construction, checked: &mut Checked) {
    let mut random = Random::new(seed);
    let mut scene = Scene::random(&mut random, SUB_PIXEL_BITS);
    // Enough to hide something in every scene.
    for _ in 0..3 {
        let centre = random.point(-12.0, 12.0);
        let half = random.point(0.5, 7.0);
        scene.bounds.push(Aabb::new(centre - half, centre + half));
        scene.solids.push(Aabb::new(centre - half, centre + half));
    }
    let camera = Camera {
        projection: Projection::perspective(random.between(0.5, 1.6)),
        near: 0.1,
        ..Path::start(&mut random)
    };
    let frame = CullView::new(&camera, SIZE, SUB_PIXEL_BITS);
    let setting = Setting {
        radius_m: [0.01, 0.05, 0.2, 0.8][random.below(4)],
        size: [[24, 16], [96, 64], [300, 200]][random.below(3)],
        guard: [0.0, 0.3][random.below(2)],
        margin_m: frame.margin.metres()[0],
    };
    let certificate = construct(&setting, &camera, &scene.solids);
    let whole = |bounds: &&Aabb| certificate.covers(bounds) == Some([false; 4]);
    let probes: Vec<Aabb> =
        (0..PROBES).map(|_| probe(&camera, &scene.solids, &mut random)).collect();
    let certified = probes.iter().chain(&scene.bounds).filter(whole);
    let certified: Vec<Aabb> = certified.copied().collect();
    checked.boxes += probes.len() + scene.bounds.len();
    checked.certified += certified.len();
    for number in 0..EYES {
        let aims = if certified.is_empty() { &scene.bounds } else { &certified };
        let aim = aims[number % aims.len()];
        let view = later_view(&camera, setting.radius_m, &aim, &mut random);
        let mut image = Image::new(SIZE);
        for (solid, shift) in scene.solids.iter().zip(shifts(scene.solids.len(), &mut random)) {
            image.draw(&view, solid, shift);
        }
        for bounds in &scene.bounds {
            checked.shown += usize::from(image.test(&view, bounds, [0.0; 2]) > 0);
        }
        // Not the solids, which are drawn already: the boxes, which certificates are about.
        for (bounds, shift) in certified.iter().zip(shifts(certified.len(), &mut random)) {
            let mut with = image.clone();
            with.draw(&view, bounds, shift);
            let message = format!("seed {seed}, {setting:?}, eye {number}, {bounds:?} shows");
            assert!(with.depths == image.depths, "{message}");
            let alone = Image::new(SIZE).test(&view, bounds, shift);
            checked.seen += usize::from(alone > 0);
        }
    }
}

#[test]
fn nothing_that_solids_certify_ever_shows() {
    let mut checked = Checked::default();
    for seed in 0..SEEDS {
        check(seed, shrunk_solids, &mut checked);
    }
    println!("{checked:?}");
    assert!(checked.certified > 300 && checked.seen > 3_000, "{checked:?}");
    assert!(checked.shown > 1_000, "{checked:?}");
}

#[test]
fn nothing_that_surfaces_certify_ever_shows() {
    let mut checked = Checked::default();
    for seed in 0..SEEDS {
        check(seed, eroded_surfaces, &mut checked);
    }
    println!("{checked:?}");
    assert!(checked.certified > 100 && checked.seen > 1_000, "{checked:?}");
}

/// Returns true if the test notices a construction for a smaller radius.
fn is_noticed(construct: Construction) -> bool {
    let check_all = || {
        for seed in 0..SEEDS {
            check(seed, construct, &mut Checked::default());
        }
    };
    std::panic::catch_unwind(check_all).is_err()
}

/// Checks that the test of soundness can fail.
#[test]
fn occluders_that_are_shrunk_too_little_are_noticed() {
    assert!(is_noticed(|setting, camera, solids| {
        shrunk_solids(&Setting { radius_m: setting.radius_m * 0.25, ..*setting }, camera, solids)
    }));
    assert!(is_noticed(|setting, camera, solids| {
        eroded_surfaces(&Setting { radius_m: 0.0, ..*setting }, camera, solids)
    }));
}

//! The shadows of real scenes against ray casting, at sampled pixels. Volumes are compared one
//! pixel away from edges, maps where no edge lies within their texels. `ANTUMBRA_ASSETS` names the
//! folder of the scenes.

use std::io::Write;
use std::ops::ControlFlow;

use cull::{Aabb, Camera, Projection, Strategy};
use glam::{DVec3, Vec3, vec3};
use gpu::Device;
use import::{LoadOptions, load};
use scene::{Alpha, LightKind, PunctualLight, Scene};
use shadows::{ShadowFilter, ShadowMethod, ShadowOptions};
use tests::run_on_all;
use tests::scene_rays::{Met, SceneRays};

use crate::shadows::shadow_maps::{SIZE, image, renderer, shadows};

const FILES: [&str; 3] = ["kaykit_city.glb", "kaykit_dungeon.glb", "rooms.glb"];

/// The step between sampled pixels, counted in rows from the top.
const STEP: u32 = 23;

/// The difference of a channel that shows that a light reaches a pixel.
const BRIGHT: u8 = 24;

/// The width in metres around a place that must be lit, or dark, as a whole for maps.
const APART_M: f64 = 0.3;

/// The largest distance from the eye (metres) at which maps are compared, since their texels grow.
const FAR_M: f64 = 30.0;

/// A light, and the triangles that may block it.
struct Lit<'a> {
    rays: &'a SceneRays,
    light: PunctualLight,
}

impl Lit<'_> {
    /// Returns true if nothing is between a place and the light; `None` if the result depends on a
    /// centimetre, as between touching surfaces.
    fn is_lit(&self, met: &Met) -> Option<bool> {
        let [near, far] = [1e-3, 1e-2].map(|off| {
            let from = met.place + met.normal * off;
            let (along, end) = self.towards(from);
            !self.rays.is_blocked(from, along, end)
        });
        (near == far).then_some(near)
    }

    fn towards(&self, place: DVec3) -> (DVec3, f64) {
        match self.light.kind {
            LightKind::Directional => (-self.light.direction.as_dvec3(), f64::INFINITY),
            _ => (self.light.position.as_dvec3() - place, 1.0),
        }
    }

    /// Returns the point at a pixel and true if it is lit; `None` if this changes within one pixel
    /// around it.
    fn seen(&self, camera: &Camera, place: [u32; 2]) -> Option<(Met, bool)> {
        let [x, y] = place;
        let at = |right: f64, down: f64| {
            let middle = [f64::from(x) + 0.5 + right, f64::from(y) + 0.5 + down];
            self.rays.shown_at(camera, SIZE, middle)
        };
        let here = at(0.0, 0.0)?;
        let (along, _) = self.towards(here.place);
        if along.normalize().dot(here.normal) < 0.1 {
            return None; // grazing, or from behind
        }
        let is_lit = self.is_lit(&here)?;
        let steps = [-1.0, 0.0, 1.0];
        let mut around = steps.into_iter().flat_map(|y| steps.map(|x| at(x, y)));
        let is_even = around.all(|neighbour| {
            neighbour.is_some_and(|neighbour| {
                let is_face = neighbour.normal.dot(here.normal) > 0.9999
                    && (neighbour.place - here.place).dot(here.normal).abs() < 2e-3;
                is_face && self.is_lit(&neighbour) == Some(is_lit)
            })
        });
        is_even.then_some((here, is_lit))
    }

    /// Returns true if all places around a place are equally lit.
    fn is_even(&self, met: &Met, is_lit: bool) -> bool {
        let (a, b) = met.normal.any_orthonormal_pair();
        let mut around = (-2..=2).flat_map(|x| (-2..=2).map(move |y| [x, y].map(f64::from)));
        around.all(|[x, y]| {
            let place = met.place + (a * x + b * y) * 0.5 * APART_M;
            self.is_lit(&Met { place, ..*met }) == Some(is_lit)
        })
    }
}

/// Loads a scene with all objects opaque and at rest.
fn solid(path: &std::path::Path) -> Scene {
    let loaded = load(path, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()));
    let mut scene = loaded.unwrap().scene;
    let surfaces = scene.surfaces.as_mut().unwrap();
    assert!(surfaces.skinned_meshes.is_empty(), "nothing moves");
    surfaces.transparent.clear();
    surfaces.levels.clear();
    surfaces.materials.iter_mut().for_each(|material| material.alpha = Alpha::Opaque);
    scene
}

/// Returns a sun, and a point light in front of the second camera.
fn lights(bounds: &Aabb) -> [PunctualLight; 2] {
    let [_, Camera { eye, forward, .. }, _] = cameras(bounds);
    let sun = PunctualLight {
        kind: LightKind::Directional,
        colour: [1.0; 3],
        intensity: 3.0,
        range_m: None,
        position: Vec3::ZERO,
        direction: vec3(-0.5, -0.8, -0.35).normalize(),
        cookie: None,
    };
    let point = PunctualLight {
        kind: LightKind::Point,
        intensity: 60.0,
        range_m: Some(40.0),
        position: eye + 5.0 * forward,
        ..sun
    };
    [sun, point]
}

/// Returns cameras that look at the middle: from above, and from near it.
fn cameras(bounds: &Aabb) -> [Camera; 3] {
    let centre = bounds.centre();
    let half = bounds.half_extent();
    [vec3(0.7, 1.6, 0.8), vec3(-0.25, 0.5, 0.2), vec3(0.15, 0.9, -0.3)].map(|place| {
        let eye = centre + place * half;
        let forward = (centre - 0.5 * half * Vec3::Y - eye).normalize();
        Camera { eye, forward, up: Vec3::Y, projection: Projection::perspective(1.0), near: 0.1 }
    })
}

/// Compares the images of a scene under a light with rays. Returns the numbers of compared and of
/// dark pixels, for volumes and for maps.
fn judge(device: &Device, scene: &Scene, rays: &SceneRays, light: PunctualLight) -> [[u32; 2]; 2] {
    let cameras = cameras(&bounds_of(scene));
    let with = |lights: &[PunctualLight]| {
        let mut scene = scene.clone();
        scene.surfaces.as_mut().unwrap().lights = lights.to_vec();
        scene
    };
    let maps = ShadowOptions {
        filter: ShadowFilter::Single,
        distance_m: Some(60.0),
        sun_side: 2048,
        point_side: 1024,
        ..shadows()
    };
    let volumes = ShadowOptions { method: ShadowMethod::Volumes, ..ShadowOptions::default() };
    let none = ShadowOptions::default();
    let mut unlit = renderer(device, &with(&[]), none);
    let mut drawn = renderer(device, &with(&[light]), none);
    let draw = |renderer: &mut render::Renderer, camera| {
        let mut view = renderer.new_view().unwrap();
        image(renderer, &mut view, Strategy::ANTUMBRA, camera)
    };
    let lit = Lit { rays, light };
    let mut judged = [[0; 2]; 2];
    for camera in cameras {
        let dark = draw(&mut unlit, camera);
        let [bright, by_volumes, by_maps] = [none, volumes, maps].map(|options| {
            drawn.set_shadows(options).unwrap();
            draw(&mut drawn, camera)
        });
        let mut wrong = Vec::new();
        for pixel in (0..SIZE[0] * SIZE[1]).step_by(STEP as usize) {
            let place = pixel as usize * 4..pixel as usize * 4 + 3;
            let [dark, bright] = [&dark, &bright].map(|image| &image[place.clone()]);
            if !dark.iter().zip(bright).any(|(dark, bright)| dark.saturating_add(BRIGHT) < *bright)
            {
                continue;
            }
            let at = [pixel % SIZE[0], pixel / SIZE[0]];
            let Some((met, is_lit)) = lit.seen(&camera, at) else { continue };
            let expected = if is_lit { bright } else { dark };
            let is_near = (met.place - camera.eye.as_dvec3()).length() < FAR_M;
            let judges = [true, is_near && lit.is_even(&met, is_lit)];
            for (way, found) in [&by_volumes, &by_maps].into_iter().enumerate() {
                if !judges[way] {
                    continue;
                }
                judged[way][0] += 1;
                judged[way][1] += u32::from(!is_lit);
                // The passes are compiled separately, so the last bit may be rounded differently.
                let found = &found[place.clone()];
                if expected.iter().zip(found).any(|(expected, found)| expected.abs_diff(*found) > 1)
                {
                    let way = ["volumes", "maps"][way];
                    wrong.push(format!(
                        "{way}: {at:?} at {}: {found:?} not {expected:?}",
                        met.place
                    ));
                }
            }
        }
        assert!(wrong.is_empty(), "{}, {:?}: {wrong:#?}", scene.name, light.kind);
    }
    judged
}

fn bounds_of(scene: &Scene) -> Aabb {
    let bounds = scene.objects.iter().map(|object| scene.bounds_of(object).unwrap());
    bounds.fold(Aabb::EMPTY, |all, bounds| all.union(&bounds))
}

#[test]
fn the_shadows_of_real_scenes_agree_with_rays() {
    let Some(folder) = std::env::var_os("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder of scenes");
        return;
    };
    let scenes = FILES.map(|file| solid(&std::path::Path::new(&folder).join(file)));
    let rays = scenes.each_ref().map(SceneRays::new);
    run_on_all(|device| {
        let mut all = [[0; 2]; 2];
        for (scene, rays) in scenes.iter().zip(&rays) {
            for light in lights(&bounds_of(scene)) {
                let judged = judge(device, scene, rays, light);
                for (all, judged) in all.iter_mut().zip(judged) {
                    *all = [all[0] + judged[0], all[1] + judged[1]];
                }
            }
        }
        let [volumes, maps] = all;
        assert!(volumes[0] > 300 && volumes[1] > 60, "{volumes:?}");
        assert!(maps[0] > 100 && maps[1] > 20, "{maps:?}");
    });
}

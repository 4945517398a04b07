//! Plans the shadow maps of a walk through a field of boxes, one of which moves.

use antumbra_shadows::{
    Casters, LightShape, ShadowCache, ShadowLight, ShadowLightId, ShadowMethod, ShadowOptions,
    ShadowPlan, ShadowViews,
};
use cull::{Aabb, BoxChange, Hierarchy, HierarchyError, ObjectId};
use glam::{Vec3, vec3};

fn main() -> Result<(), HierarchyError> {
    let places = (0..900).map(|box_| vec3((box_ % 30) as f32 * 4.0, 0.0, (box_ / 30) as f32 * 4.0));
    let boxes: Vec<Aabb> = places.map(|place| Aabb::new(place, place + Vec3::splat(1.5))).collect();
    let mut hierarchy = Hierarchy::build(&boxes)?;
    let towards = vec3(0.3, 0.8, 0.4).normalize();
    let position = vec3(40.0, 6.0, 40.0);
    let light = |id, shape| ShadowLight { id: ShadowLightId(id), shape, penumbra_m: 0.2 };
    let lights = [
        light(0, LightShape::Sun { towards }),
        light(1, LightShape::Point { position, reach_m: 25.0 }),
    ];
    let options = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
    let mut cache = ShadowCache::new(options);
    let mut plan = ShadowPlan::default();
    let mut before = boxes[455];
    for frame in 0..10 {
        let eye = vec3(50.0, 1.7, 30.0 + frame as f32 * 0.1);
        let after = before.enlarged(0.01);
        hierarchy.refit([(ObjectId(455), after)])?;
        let changes = [BoxChange { object: ObjectId(455), before, after }];
        before = after;
        let casters = Casters { hierarchy: &hierarchy, changes: Some(&changes) };
        cache.plan(
            &lights,
            &casters,
            &ShadowViews { eyes: &[eye], sub_pixel_bits: 8, drawn_share: None },
            &mut plan,
        );
        cache.submitted();
        let stats = plan.stats();
        println!(
            "frame {frame}: {} of {} maps drawn, {} draws of casters",
            stats.drawn_faces, stats.faces, stats.casters
        );
    }
    Ok(())
}

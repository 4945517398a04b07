//! Shadow maps in the renderer: images are compared with ray casting, with freshly drawn maps, and
//! between strategies.

pub mod bad_options;
pub mod cache;
mod cascades;
pub mod casters;
pub mod culling;
mod midpoints;
mod one_sided;
pub mod raycast;
mod reach;

use cull::Strategy;
use gpu::{Device, PredicationMode};
use render::{CostModel, Renderer, RendererOptions, SpareCapacity};
use scene::Scene;
use shadows::{ShadowFilter, ShadowMethod, ShadowOptions};
pub use tests::single_frame::image;
use tests::{run_on_all, shadow_scene};

pub const SIZE: [u32; 2] = [128, 96];

/// Returns options for a small image.
pub fn shadows() -> ShadowOptions {
    ShadowOptions {
        method: ShadowMethod::Maps,
        distance_m: Some(60.0),
        sun_side: 256,
        spot_side: 256,
        point_side: 128,
        layers_max: 16,
        ..ShadowOptions::default()
    }
}

pub fn renderer(device: &Device, scene: &Scene, shadows: ShadowOptions) -> Renderer {
    renderer_that_skips(device, scene, shadows, None)
}

/// Creates a renderer of a scene with these shadows and this way to skip draws of objects.
pub fn renderer_that_skips(
    device: &Device,
    scene: &Scene,
    shadows: ShadowOptions,
    predication: Option<PredicationMode>,
) -> Renderer {
    let options = RendererOptions {
        predication,
        size: SIZE,
        cost_model: CostModel::Off,
        spare_objects: 8,
        spare: SpareCapacity { lights: 4, ..SpareCapacity::default() },
        methods: methods::all(),
        shadows,
        ..RendererOptions::default()
    };
    Renderer::new(device, scene, &options).expect("a renderer")
}

#[test]
fn every_filter_darkens_the_same_places() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let draw = |shadows| {
            let mut renderer = renderer(device, &scene, shadows);
            let mut view = renderer.new_view().unwrap();
            image(&mut renderer, &mut view, Strategy::FRUSTUM, shadow_scene::camera())
        };
        let lit = draw(ShadowOptions::default());
        let fixed = draw(ShadowOptions { filter: ShadowFilter::Fixed64, ..shadows() });
        for filter in ShadowFilter::ALL {
            let shadowed = draw(ShadowOptions { filter, ..shadows() });
            let darker = lit.iter().zip(&shadowed).filter(|(lit, shadowed)| lit > shadowed).count();
            // The two are compiled separately, so the last bit may be rounded differently.
            let is_brighter =
                |(lit, shadowed): &(&u8, &u8)| u16::from(**lit) + 1 < u16::from(**shadowed);
            let brighter = lit.iter().zip(&shadowed).filter(is_brighter).count();
            assert!(darker * 8 > lit.len() && brighter == 0, "{filter:?}: {darker}, {brighter}");
            let differences = fixed.iter().zip(&shadowed).map(|(a, b)| u64::from(a.abs_diff(*b)));
            let mean = differences.sum::<u64>() as f64 / fixed.len() as f64;
            assert!(mean < 6.0, "{filter:?} differs by {mean} from the full disk");
            if filter == ShadowFilter::Adaptive {
                assert!(mean < 1.0, "{mean}");
            }
        }
    });
}

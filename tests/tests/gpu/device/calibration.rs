//! Costs measured on a device: they are plausible, the validation layer stays silent, and images
//! are right with any costs.

use cull::{CostTable, Strategy};
use gpu::{Device, OptionalFeature, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];

/// Walks with a renderer of these costs, and compares every image with frustum culling. Returns the
/// costs, and the number of leaves that were not tested because of their cost.
fn walk(device: &Device, options: &RendererOptions) -> (Option<CostTable>, u32) {
    let GeneratedScene { scene, routes } = city(400, 5).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let mut renderer = Renderer::new(device, &scene, options).unwrap();
    let images = [0, 1].map(|_| Readback::new(device, SIZE).unwrap());
    let mut histories = [0, 1].map(|_| renderer.new_view().unwrap());
    let mut untested = 0;
    for frame in 0..24 {
        for (which, strategy) in [Strategy::FRUSTUM, Strategy::ANTUMBRA].into_iter().enumerate() {
            let request = FrameRequest {
                image: Some(&images[which]),
                ..FrameRequest::new(strategy, path.camera(frame))
            };
            let report = renderer.render(&mut histories[which], request).unwrap();
            untested += report.plan.untested_by_cost;
        }
        device.wait_idle().unwrap();
        let [expected, found] = &images;
        assert!(*expected.rgba8().unwrap() == *found.rgba8().unwrap(), "frame {frame}");
    }
    (renderer.costs(), untested)
}

fn options(cost_model: CostModel) -> RendererOptions {
    RendererOptions { size: SIZE, cost_model, ..RendererOptions::default() }
}

#[test]
fn measured_costs_can_be_and_images_are_right() {
    run_on_all(|device| {
        let (cost_model, _) = walk(device, &options(CostModel::Measured));
        let cost_model = cost_model.expect("a table").checked().expect("cost_model that can be");
        println!("{cost_model:?}");
        // A single cost may drown in the noise of a busy machine, but not all costs.
        assert_ne!(cost_model, CostTable::default(), "nothing was measured");
        assert_ne!(cost_model, CostTable::uniform(0.0), "everything is free");
    });
}

#[test]
fn every_way_to_skip_draws_can_be_measured() {
    run(Driver::Lavapipe, |device| {
        for predication in
            [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted]
        {
            let options =
                RendererOptions { predication: Some(predication), ..options(CostModel::Measured) };
            walk(device, &options);
        }
    });
}

#[test]
fn the_executor_is_one_of_those_that_were_measured() {
    run_on_all(|device| {
        let scene = city(400, 5).unwrap().scene;
        let renderer = Renderer::new(device, &scene, &options(CostModel::Measured)).unwrap();
        let choice = renderer.culling_setup();
        let has =
            PredicationMode::ALL.into_iter().filter(|predication| predication.is_supported(device));
        let measured: Vec<PredicationMode> =
            choice.skip_ns.iter().map(|(predication, _)| *predication).collect();
        assert_eq!(measured.len(), has.clone().count());
        assert!(has.clone().all(|name| measured.contains(&name)), "{measured:?}");
        assert_eq!(measured.first(), Some(&PredicationMode::best(device.capabilities())));
        // Which one is chosen depends on noise too: `MeasuredSkip::cheapest` is tested in `cull`.
        assert!(choice.skip_ns.iter().all(|(_, ns)| ns.is_finite() && *ns >= 0.0), "{choice:?}");
        assert!(measured.contains(&choice.predication), "{choice:?}");
        assert_eq!(renderer.predication(), choice.predication);
        assert!(choice.reset_ns.command_ns.is_finite());
        assert_eq!(
            choice.reset_ns.cpu_ns.is_finite(),
            device.capabilities().has(OptionalFeature::HostQueryReset)
        );
        let wanted = Some(PredicationMode::Instances);
        let fixed = RendererOptions { predication: wanted, ..options(CostModel::Measured) };
        let renderer = Renderer::new(device, &scene, &fixed).unwrap();
        assert_eq!(renderer.culling_setup().skip_ns.len(), 1);
        assert_eq!(renderer.predication(), PredicationMode::Instances);
    });
}

#[test]
fn images_are_right_at_any_cost() {
    run(Driver::Lavapipe, |device| {
        // Hidden pixels are a part of draws, too.
        let draws = CostTable { hidden_pixel_ns: 0.0, ..CostTable::uniform(1.0e30) };
        let dear = CostTable { draw_ns: 1.0, triangle_ns: 1.0, ..draws };
        let (cost_model, untested) = walk(device, &options(CostModel::Table(dear)));
        assert_eq!(cost_model, Some(dear));
        assert!(untested > 0, "nothing pays for such tests");
        let free = CostTable { draw_ns: 1_000.0, ..CostTable::uniform(0.0) };
        assert_eq!(walk(device, &options(CostModel::Table(free))).1, 0, "such tests cost nothing");
        let by_compute = CostTable { draw_ns: 1.0e6, flag_box_ns: 1.0e5, query_ns: 1.0e5, ..free };
        walk(device, &options(CostModel::Table(by_compute)));
        let nonsense = CostTable { draw_ns: f32::NAN, ..dear };
        let refused = Renderer::new(
            device,
            &city(400, 5).unwrap().scene,
            &options(CostModel::Table(nonsense)),
        );
        assert!(refused.err().expect("no item_cost").to_string().contains("draw_ns"));
        assert_eq!(walk(device, &options(CostModel::Off)), (None, 0));
    });
}

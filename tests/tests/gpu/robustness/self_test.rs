//! The self-test: it trusts correct drivers and finds each lie of a faulty driver. The renderer
//! then uses the safest remaining tester.

use std::time::Instant;

use cull::Strategy;
use gpu::{Device, DeviceOptions, PredicationMode};
use render::{
    CheckResult, CostModel, DriverAssumption, FrameRequest, Renderer, RendererOptions, SelfTest,
    self_test,
};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use shadows::{CasterCulling, ShadowCaching, ShadowMethod, ShadowOptions};
use tests::fault_injection::{CONDITIONAL_BLOCKS, FaultInjection, Lie, calls};
use tests::{Driver, instance_with, run, run_on_all, shadow_scene, single_frame};

fn examined(device: &Device) -> SelfTest {
    self_test(device, &RendererOptions::default()).unwrap()
}

#[test]
fn both_drivers_are_trusted() {
    run_on_all(|device| {
        let began = Instant::now();
        let found = examined(device);
        println!("{:?}: {found:#?}", began.elapsed());
        assert_eq!(found.broken(), []);
        assert_eq!(found.safest, Some(Strategy::ANTUMBRA));
        let tested = found.findings.iter().map(|(assumption, _)| *assumption);
        assert!(tested.eq(DriverAssumption::ALL), "each once, in their order");
        let lacks_some = device.adapter().name.contains(Driver::SwiftShader.device_name());
        let is_untested =
            |(_, verdict): &&(_, CheckResult)| matches!(verdict, CheckResult::Skipped(_));
        let untested = found.findings.iter().filter(is_untested).count();
        assert_eq!(untested, if lacks_some { 3 } else { 0 }, "conditional rendering and counts");
    });
}

/// Returns the broken assumptions of a driver with this lie, and the safest strategy.
fn broken_by(driver: Driver, lie: Lie) -> (Vec<DriverAssumption>, Option<Strategy>) {
    let instance =
        instance_with(FaultInjection { lie: Some(lie), ..FaultInjection::default() }.entry());
    let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let found = examined(&device);
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
    (found.broken(), found.safest)
}

#[test]
fn a_lie_of_the_driver_is_found() {
    use DriverAssumption::*;
    let ours = Some(Strategy::ANTUMBRA);
    let flags = Some(Strategy::ANTUMBRA_FLAGS);
    let without_compute =
        vec![ComputedDepths, DrawCounts, InstanceCounts, CompactedLists, ComputedWalk];
    let lavapipe = [
        (Lie::FirstResultForAll, vec![QueryCounts, LateResults, QueriedWalk], flags),
        (Lie::NoConditions, vec![ConditionalRendering], ours),
        (Lie::NoCounts, vec![DrawCounts, CompactedLists], ours),
        (Lie::NoDispatches, without_compute, ours),
        (Lie::LastDrawFirst, vec![DrawOrder], ours),
    ];
    for (lie, expected, safest) in lavapipe {
        assert_eq!(broken_by(Driver::Lavapipe, lie), (expected, safest), "{lie:?}");
    }
    let swift_shader = [
        (Lie::FirstResultForAll, vec![QueryCounts, LateResults, QueriedWalk], flags),
        // The only way to skip draws.
        (Lie::NoDispatches, vec![ComputedDepths, InstanceCounts], None),
    ];
    for (lie, expected, safest) in swift_shader {
        assert_eq!(broken_by(Driver::SwiftShader, lie), (expected, safest), "{lie:?}");
    }
}

/// Draws the first frames of a walk with a strategy, on a renderer with these disabled assumptions.
/// Checks that images equal frustum culling, and returns the number of tests.
fn walk(
    device: &Device,
    disabled: &[DriverAssumption],
    strategy: Strategy,
) -> (Renderer, [u32; 2]) {
    let GeneratedScene { scene, routes } = city(300, 3).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options = RendererOptions {
        size: [96, 54],
        cost_model: CostModel::Off,
        disabled: disabled.to_vec(),
        ..RendererOptions::default()
    };
    let mut renderer = Renderer::new(device, &scene, &options).unwrap();
    let [mut view, mut reference] = [0, 1].map(|_| renderer.new_view().unwrap());
    let mut counts = [0; 2];
    for frame in 0..6 {
        let camera = path.camera(frame);
        let report = renderer.render(&mut view, FrameRequest::new(strategy, camera)).unwrap();
        counts[0] += report.tests;
        counts[1] += report.predicated_draws;
        let found = single_frame::image(&mut renderer, &mut view, strategy, camera);
        let expected =
            single_frame::image(&mut renderer, &mut reference, Strategy::FRUSTUM, camera);
        assert!(found == expected, "frame {frame}");
    }
    (renderer, counts)
}

#[test]
fn the_safest_tester_is_used_and_said() {
    use DriverAssumption::*;
    run(Driver::Lavapipe, |device| {
        for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_FLAGS] {
            let (renderer, trusted) = walk(device, &[], strategy);
            assert!(trusted[0] > 0 && renderer.driver_quirks().is_empty());
            let (renderer, [tests, _]) = walk(device, &[EarlyTests], strategy);
            assert!(tests > 0);
            let said = renderer.driver_quirks().concat();
            assert!(said.contains("early tests") && said.contains("another tester"), "{said}");
            let (_, counts) = walk(device, &[ProxyDepth, ComputedDepths], strategy);
            assert_eq!(counts, [0, 0], "frustum culling");
        }
        let (renderer, counts) = walk(device, &[ConditionalRendering], Strategy::ANTUMBRA);
        assert_eq!(renderer.predication(), PredicationMode::Counts);
        assert!(counts[1] > 0);
        let none = [ConditionalRendering, DrawCounts, InstanceCounts];
        assert_eq!(walk(device, &none, Strategy::ANTUMBRA).1, [0, 0], "nothing can be skipped");
    });
}

#[test]
fn casters_stay_unculled_where_flags_are_distrusted() {
    run(Driver::Lavapipe, |device| {
        let culled = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
        assert_eq!(culled.culling, CasterCulling::Culled);
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        for (disabled, expected) in [
            (vec![], CasterCulling::Culled),
            (vec![DriverAssumption::EarlyTests], CasterCulling::Unculled),
        ] {
            let options = RendererOptions {
                size: [96, 54],
                disabled,
                shadows: culled,
                ..RendererOptions::default()
            };
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            assert_eq!(renderer.shadows().culling, expected);
            renderer.set_shadows(ShadowOptions { sun_side: 512, ..culled }).unwrap();
            assert_eq!(renderer.shadows().culling, expected, "other options");
        }
    });
}

#[test]
fn casters_are_skipped_in_no_way_that_is_distrusted() {
    let blocks = [vec![], vec![DriverAssumption::ConditionalRendering]].map(|disabled| {
        let instance = instance_with(FaultInjection::default().entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let shadows = ShadowOptions {
            method: ShadowMethod::Maps,
            caching: ShadowCaching::Uncached,
            ..ShadowOptions::default()
        };
        let size = [96, 54];
        let cost_model = CostModel::Off;
        let options = RendererOptions { size, cost_model, disabled, shadows, ..Default::default() };
        let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        for _ in 0..4 {
            // Only casters are tested.
            let request = FrameRequest::new(Strategy::FRUSTUM, shadow_scene::camera());
            renderer.render(&mut view, request).unwrap();
        }
        assert!(renderer.shadow_stats().tests > 0);
        renderer.wait_idle(&mut view).unwrap();
        calls(CONDITIONAL_BLOCKS)
    });
    assert!(blocks[0] > 0 && blocks[1] == 0, "{blocks:?}");
}

#[test]
fn images_are_right_on_a_driver_that_lies_and_is_not_trusted() {
    let faults = FaultInjection { lie: Some(Lie::FirstResultForAll), ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let broken = examined(&device).broken();
    for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES] {
        let (_, [tests, _]) = walk(&device, &broken, strategy);
        assert!(tests > 0, "by flags");
    }
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
}

/// Wrong shaders behave like a driver that miscompiles shaders.
#[cfg(feature = "shader-compiler")]
mod shaders {
    use std::fs;
    use std::path::Path;

    use render::ShaderSet;

    use super::*;

    /// Returns the shaders with a change in one of them.
    fn changed(name: &str, from: &str, to: &str) -> ShaderSet {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let folder =
            std::env::temp_dir().join(format!("antumbra-self-test-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for file in fs::read_dir(source).unwrap().map(Result::unwrap) {
            if file.path().is_file() {
                fs::copy(file.path(), folder.join(file.file_name())).unwrap();
            }
        }
        let text = fs::read_to_string(folder.join(name)).unwrap();
        assert!(text.contains(from), "{name} has no longer `{from}`");
        fs::write(folder.join(name), text.replace(from, to)).unwrap();
        let shaders = ShaderSet::compiled_from(&folder).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        shaders
    }

    /// A change in a shader, and the assumption that it breaks.
    struct WrongShader {
        name: &'static str,
        from: &'static str,
        to: String,
        breaks: DriverAssumption,
    }

    /// Checks that the self-test finds the assumption that a changed shader breaks.
    fn check(wrong: &WrongShader) {
        let WrongShader { name, from, to, breaks } = wrong;
        let shaders = Some(changed(name, from, to));
        run_on_all(|device| {
            let options = RendererOptions { shaders: shaders.clone(), ..Default::default() };
            let found = self_test(device, &options).unwrap();
            println!("{name}, {to}: {:?}", found.broken());
            assert!(found.broken().contains(breaks), "{name}: {:?}", found.broken());
        });
    }

    const POSITION: &str = "gl_Position = box_vertex(box.low.xyz, box.high.xyz, eye, view_proj, \
                            gl_VertexIndex);";

    #[test]
    fn a_wrong_depth_of_proxies_is_found() {
        check(&WrongShader {
            name: "proxy.vert",
            from: POSITION,
            to: format!("{POSITION} gl_Position.z *= 0.9;"),
            breaks: DriverAssumption::ProxyDepth,
        });
    }

    #[test]
    #[ignore = "long walk"]
    fn every_wrong_result_of_a_shader_is_found() {
        let shaded = "gl_Position = snapped(clip, vec2(ambient_above.w, ambient_below.w));";
        for wrong in [
            WrongShader {
                name: "proxy.frag",
                from: "layout(early_fragment_tests) in;",
                to: String::new(),
                breaks: DriverAssumption::EarlyTests,
            },
            WrongShader {
                name: "proxy.frag",
                from: "flags[test], 1u,",
                to: "flags[test], 0u,".to_owned(),
                breaks: DriverAssumption::FlagWrites,
            },
            WrongShader {
                name: "proxy.vert",
                from: POSITION,
                to: format!("{POSITION} gl_Position.x += 0.02 * gl_Position.w;"),
                breaks: DriverAssumption::ProxyCoverage,
            },
            WrongShader {
                name: "surface_vertex.glsl",
                from: shaded,
                to: format!("{shaded} gl_Position.z *= 1.00001;"),
                breaks: DriverAssumption::RepeatedDepth,
            },
        ] {
            check(&wrong);
        }
    }
}

//! Scenes of hosts on drivers for which a self-test found broken assumptions, and with measured
//! costs. Broken testers and broken ways to skip draws are not used, and images stay exact.

use std::sync::{Arc, Mutex};

use cull::{DrawPhases, Strategy, VisibilityTest};
use gpu::{Device, Features, FrameRing, PredicationMode, Purpose};
use occlusion::{CullingSetup, DeviceCosts, DriverAssumption};
use render::RendererOptions;
use tests::fault_injection::{CONDITIONAL_BLOCKS, FaultInjection, Lie, calls};
use tests::host_commands::{HostCommands, Runs, record_frame};
use tests::host_device::Host;
use tests::host_scene::{BoxOptions, ComparedScene, IN_FLIGHT};
use tests::host_walk::{boxes, camera};
use tests::{Driver, drivers};

/// The outcome of a walk whose images equal brute force.
struct Walked {
    choice: CullingSetup,
    /// The testers in its plans.
    testers: Vec<VisibilityTest>,
    /// The queries in its plans.
    queries: usize,
    /// True if lists had counts.
    has_counts: bool,
    /// True if tests were weighed by costs.
    has_costs: bool,
    /// True if boxes of leaves can enable draws, of transparent objects too.
    has_leaf_boxes: bool,
}

/// Walks with a scene of a host on its device, adopted without a queue.
fn walk(host: &Host, options: &BoxOptions<'_>, strategy: Strategy) -> Walked {
    let device = host.adopt(None);
    let mut scene = ComparedScene::new(host, &device, options);
    let mut commands = HostCommands::new(host, IN_FLIGHT);
    let mut ring = FrameRing::new(&device, IN_FLIGHT).unwrap();
    scene.add(&boxes()[..200]).unwrap();
    let mut walked = Walked {
        choice: scene.scene.culling_setup().clone(),
        testers: Vec::new(),
        queries: 0,
        has_counts: false,
        has_costs: scene.states().all(|state| state.has_cost_model()),
        has_leaf_boxes: scene.scene.passes().leaf_boxes.is_some(),
    };
    for frame in 0..8 {
        let (buffer, numbers) = commands.begin();
        let cameras = [camera(frame)];
        let (tick, slot) = record_frame(&mut ring, buffer, numbers, |recorded| {
            scene.compare(recorded.slot().0, &format!("a frame before {frame}"));
            let recorded = scene.record(recorded, &cameras, strategy).unwrap();
            scene.record_all(&recorded, &cameras);
            let slot = recorded.slot();
            (recorded, slot)
        });
        for state in scene.states() {
            walked.testers.extend(state.plan().tests.iter().map(|test| test.tester));
            walked.queries += state.plan().query_count();
            let mut lists = state.visible_lists().iter().chain(state.revealed_lists());
            walked.has_counts |= lists.any(|list| list.count.is_some());
        }
        scene.ended(tick, slot, Runs::Once);
        commands.end(Runs::Once).unwrap();
    }
    host.say_all_is_over(&device);
    (0..IN_FLIGHT).for_each(|slot| {
        scene.compare(slot, "the last frames");
    });
    scene.destroy();
    commands.destroy();
    drop((ring, device));
    walked
}

/// Creates the device of a host through a faulty machine of the test.
fn host_on(driver: Driver, faults: FaultInjection) -> Host {
    Host::through(faults.entry(), driver, Purpose::Renderer, &[], Features::default())
}

/// Adopts the device with its queue temporarily, as a host does at start before it adopts the
/// device for its scenes.
fn at_start<R>(host: &Host, measure: impl FnOnce(&Device) -> R) -> R {
    let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
    measure(&device)
}

#[test]
fn a_lie_that_is_found_at_start_spoils_no_image_of_a_hosts_scene() {
    for (lie, strategy) in [
        (Lie::FirstResultForAll, Strategy::ANTUMBRA_QUERIES),
        (Lie::FirstResultForAll, Strategy::ANTUMBRA),
        (Lie::NoConditions, Strategy::ANTUMBRA),
        (Lie::NoCounts, Strategy::ANTUMBRA),
    ] {
        let host = host_on(
            Driver::Lavapipe,
            FaultInjection { lie: Some(lie), ..FaultInjection::default() },
        );
        let broken = at_start(&host, |device| {
            render::self_test(device, &RendererOptions::default()).unwrap().broken()
        });
        let phases = [DrawPhases::PerRound, DrawPhases::Two];
        for draw_phases in phases {
            let disabled = &broken[..];
            let options = BoxOptions { draw_phases, disabled, ..BoxOptions::default() };
            let walked = walk(&host, &options, strategy);
            let has_lists = draw_phases == DrawPhases::Two;
            assert_eq!(walked.testers.is_empty(), has_lists && lie == Lie::NoCounts, "{lie:?}");
            assert_eq!(walked.has_counts, has_lists && lie != Lie::NoCounts, "{lie:?}");
            let has_queries = !has_lists && lie != Lie::FirstResultForAll;
            assert_eq!(walked.queries > 0, has_queries, "{lie:?}");
        }
        host.finish();
    }
}

#[test]
fn lists_and_boxes_of_leaves_rest_on_numbers_of_instances() {
    for driver in drivers() {
        let host = host_on(driver, FaultInjection::default());
        let walk = |draw_phases, disabled: &[DriverAssumption]| {
            let options = BoxOptions { draw_phases, disabled, ..BoxOptions::default() };
            walk(&host, &options, Strategy::ANTUMBRA)
        };
        let counts = [DriverAssumption::InstanceCounts];
        let [sound, listed] = [&[][..], &counts].map(|disabled| walk(DrawPhases::Two, disabled));
        assert!(!sound.testers.is_empty() && sound.has_leaf_boxes, "{driver:?}");
        assert!(listed.testers.is_empty() && !listed.has_leaf_boxes, "{driver:?}");
        // Without lists another way skips draws, if there is one.
        let in_rounds = walk(DrawPhases::PerRound, &counts);
        assert_eq!(in_rounds.testers.is_empty(), driver == Driver::SwiftShader, "{driver:?}");
        assert!(!in_rounds.has_leaf_boxes, "{driver:?}");
        host.finish();
    }
}

#[test]
fn hosts_use_no_tester_and_no_executor_that_is_distrusted() {
    use DriverAssumption::*;
    for driver in drivers() {
        let host = host_on(driver, FaultInjection::default());
        let walk = |disabled: &[DriverAssumption], wanted, strategy| {
            let options = BoxOptions { predication: wanted, disabled, ..BoxOptions::default() };
            walk(&host, &options, strategy)
        };
        let ours = Strategy::ANTUMBRA;
        let sound = walk(&[], None, ours);
        assert!(sound.testers.contains(&VisibilityTest::Flag) && sound.has_leaf_boxes);
        assert!(sound.queries > 0 && !sound.has_costs);
        let best = sound.choice.predication;

        let unflagged = walk(&[EarlyTests], None, Strategy::ANTUMBRA_FLAGS);
        assert!(
            unflagged.testers.iter().all(|tester| *tester == VisibilityTest::Query),
            "{driver:?}"
        );
        assert!(!unflagged.testers.is_empty() && !unflagged.has_leaf_boxes);
        let computed = walk(&[ProxyDepth], None, ours);
        assert!(
            computed.testers.iter().all(|tester| *tester == VisibilityTest::Compute)
                && computed.queries == 0
        );
        assert!(!computed.testers.is_empty());
        let nothing = walk(&[ProxyDepth, ComputedDepths], None, ours);
        assert!(nothing.testers.is_empty() && nothing.queries == 0);

        let blocks = calls(CONDITIONAL_BLOCKS);
        for wanted in [None, Some(best)] {
            let other = walk(&[ConditionalRendering], wanted, ours);
            assert!(!other.testers.is_empty());
            let expected = match driver {
                Driver::Lavapipe => PredicationMode::Counts,
                Driver::SwiftShader => PredicationMode::Instances,
            };
            assert_eq!(other.choice.predication, expected);
        }
        let none = [ConditionalRendering, DrawCounts, InstanceCounts];
        assert!(walk(&none, None, ours).testers.is_empty(), "nothing can be skipped");
        assert_eq!(calls(CONDITIONAL_BLOCKS), blocks, "{driver:?}");
        assert_eq!(blocks > 0, driver == Driver::Lavapipe);
        host.finish();
    }
}

#[test]
fn hosts_take_the_cheapest_executor_that_is_trusted_and_weigh_tests_by_costs() {
    for driver in drivers() {
        let host = host_on(driver, FaultInjection::default());
        let options = RendererOptions { size: [96, 54], ..RendererOptions::default() };
        let measured = at_start(&host, |device| render::measure_costs(device, &options).unwrap());
        let has = |predication: PredicationMode| {
            measured.executors.iter().any(|(other, _)| *other == predication)
        };
        assert!(has(PredicationMode::Instances) && !measured.executors.is_empty());
        let walked = |costs: &DeviceCosts, disabled: &[DriverAssumption], predication| {
            let costs = Some(costs);
            let options = BoxOptions { costs, disabled, predication, ..BoxOptions::default() };
            walk(&host, &options, Strategy::ANTUMBRA)
        };
        let by_measured = walked(&measured, &[], None);
        assert!(by_measured.has_costs && by_measured.choice.table.is_some());
        assert_eq!(by_measured.choice.skip_ns.len(), measured.executors.len());

        // Pretends that one of them costs nothing.
        let cheap = PredicationMode::Instances;
        let mut measured = measured.clone();
        for (executor, skip) in &mut measured.executors {
            let range_ns = if *executor == cheap { 1.0 } else { 1.0e6 };
            skip.costs = cull::PredicationCosts { round_ns: 0.0, range_ns, draw_ns: 0.0 };
            skip.rounds.fill(skip.costs);
        }
        assert_eq!(walked(&measured, &[], None).choice.predication, cheap);
        if driver == Driver::Lavapipe {
            let disabled = walked(&measured, &[DriverAssumption::InstanceCounts], None);
            assert_eq!(disabled.choice.predication, PredicationMode::Conditional);
            let wanted = walked(&measured, &[], Some(PredicationMode::Counts));
            assert_eq!(wanted.choice.predication, PredicationMode::Counts);
        }
        host.finish();
    }
}

//! The effect of predicates with every predication mode: none, all, and more than fit one dispatch.

use glam::Vec3;
use gpu::{
    Access, Buffer, Device, DrawRange, FlagRing, FrameRing, IndirectDraw, MemoryBarrier,
    MemoryKind, PredicatedRange, Predicates, PredicationMode, QueryIndex, QueryRing, ResultSource,
    Reveal, Target, vk,
};
use occlusion::{ProxyBox, ProxyIo};
use tests::run_on_all;
use tests::shapes::{box_at, proxy_pass, square_view};

const SOURCE: ResultSource = ResultSource::Fragments;

fn executors(device: &Device) -> Vec<PredicationMode> {
    let all = PredicationMode::ALL;
    all.into_iter().filter(|p| Predicates::new(device, Some(*p), &[], 1).is_ok()).collect()
}

/// Returns the results of two decisions per frame, one as a whole and one per box. Each is true if
/// the frame has predicates (which hide everything), true for decisions per box, and true if
/// something is drawn.
fn drawn(device: &Device, predication: PredicationMode) -> Vec<(bool, bool, bool)> {
    let proxies = proxy_pass(device);
    let view = square_view(device, 64);
    let mut target = Target::new(device, [64, 64], "target").unwrap();
    let mut ring = FrameRing::new(device, 1).unwrap();
    let mut queries = QueryRing::<(bool, bool)>::new(device, 1, "test").unwrap();
    let mut flags = FlagRing::<()>::new(device, 1, SOURCE, "flags");
    let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::VERTEX_BUFFER;
    let indices: Vec<u32> = (0..gpu::BOX_VERTICES).collect();
    let indices = device.upload("indices", &indices, usage).unwrap();
    let draw = |first_instance| IndirectDraw {
        index_count: gpu::BOX_VERTICES,
        instance_count: 1,
        first_instance,
        ..Default::default()
    };
    let mut predicates =
        Predicates::new(device, Some(predication), &[draw(0), draw(1)], 1).unwrap();
    let boxes = [-2.0, 2.0].map(|x| box_at(Vec3::new(x, 0.0, -5.0), Vec3::ONE)).map(ProxyBox::from);
    let mut drawn = Vec::new();
    for has_results in [true, false, true, false] {
        let mut frame = ring.begin().unwrap();
        queries.begin(&mut frame, &[(has_results, false), (has_results, true)]).unwrap();
        flags.begin(&frame, std::iter::repeat_n((), 8)).unwrap();
        let whole = PredicatedRange {
            result: 5,
            range: DrawRange { first: 0, count: 1 },
            reveal: Reveal::Draws,
        };
        let per_leaf = PredicatedRange {
            result: 7,
            range: DrawRange { first: 1, count: 1 },
            reveal: Reveal::Boxes,
        };
        let results = flags.results().filter(|_| has_results);
        predicates.begin(&mut frame, SOURCE, results, [whole, per_leaf].into_iter()).unwrap();
        let boxes = frame.uploads().push(&boxes).unwrap();
        let commands = frame.commands();
        let cleared = MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]);
        commands.barrier(cleared);
        predicates.resolve(commands, &[(SOURCE, 0..2)], 0);
        target.prepare(commands);
        commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
            proxies.bind(commands, &ProxyIo { boxes, flags: None }, &view);
            commands.bind_geometry(indices.whole(), Some(indices.whole()));
            queries.scope(commands, QueryIndex(0), |commands| {
                predicates.draw(commands, SOURCE, 0);
            });
            queries.scope(commands, QueryIndex(1), |commands| {
                predicates.draw_boxes(commands, SOURCE, 1);
            });
        });
        queries.resolve(commands, 0..2);
        queries.read_back(commands);
        queries.submitted(frame.submit(None).unwrap());
        device.wait_idle().unwrap();
        queries.collect(device.completed().unwrap(), |(has_results, is_boxes), samples| {
            drawn.push((has_results, is_boxes, samples > 0));
        });
    }
    drawn
}

#[test]
fn what_nobody_answers_is_drawn() {
    run_on_all(|device| {
        for predication in executors(device) {
            let drawn = drawn(device, predication);
            assert_eq!(drawn.len(), 8);
            for (has_results, is_boxes, is_drawn) in drawn {
                let what = format!("{}, boxes: {is_boxes}", predication.name());
                assert_eq!(is_drawn, !has_results, "{what}, results: {has_results}");
            }
        }
    });
}

#[test]
fn a_threshold_is_refused_where_the_results_are_not_compared() {
    run_on_all(|device| {
        for predication in executors(device) {
            let mut ring = FrameRing::new(device, 1).unwrap();
            let predicates = Predicates::new(device, Some(predication), &[], 1).unwrap();
            let frame = ring.begin().unwrap();
            predicates.resolve(frame.commands(), &[], 3);
            let refused = frame.submit(None).err().map(|error| error.to_string());
            let says = refused.as_ref().is_some_and(|text| text.contains("cannot compare"));
            let compares = predication != PredicationMode::Conditional;
            assert_eq!((refused.is_none(), says), (compares, !compares), "{refused:?}");
        }
    });
}

#[test]
fn more_decisions_than_a_dispatch_has_workgroups() {
    const COUNT: u32 = 70_000;
    run_on_all(|device| {
        let most = device.adapter().limits.max_compute_work_group_count[0];
        if COUNT <= most {
            let name = &device.adapter().name;
            assert!(!device.adapter().is_software(), "nothing to split: {most}");
            eprintln!("not tested on {name}: a dispatch has {most} workgroups");
            return;
        }
        let mut ring = FrameRing::new(device, 1).unwrap();
        let draws = vec![IndirectDraw { instance_count: 7, ..Default::default() }; COUNT as usize];
        let mut predicates =
            Predicates::new(device, Some(PredicationMode::Instances), &draws, 1).unwrap();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let results: Vec<u32> = (0..COUNT).map(|result| result % 3).collect();
        let results = device.upload("results", &results, usage).unwrap();
        let bytes = predicates.draws().size_bytes;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let readback = Buffer::new(device, "readback", bytes, usage, MemoryKind::ReadBack).unwrap();
        let decided = (0..COUNT).map(|number| PredicatedRange {
            result: number,
            range: DrawRange { first: number, count: 1 },
            reveal: Reveal::Draws,
        });
        let mut frame = ring.begin().unwrap();
        let decided: Vec<_> = decided.collect();
        let results = Some(results.whole());
        predicates.begin(&mut frame, SOURCE, results, decided.iter().copied()).unwrap();
        let commands = frame.commands();
        // Decisions that do not exist have no effect.
        predicates.resolve(commands, &[(SOURCE, 1..COUNT + 9)], 0);
        commands.copy_buffer(predicates.draws(), readback.whole());
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
        frame.submit(None).unwrap();
        device.wait_idle().unwrap();
        let found = readback.read::<IndirectDraw>(0..COUNT as usize);
        assert_eq!(found.len(), COUNT as usize);
        for (number, draw) in (0..).zip(found) {
            let expected = if number == 0 { 7 } else { u32::from(number % 3 != 0) };
            assert_eq!(draw.instance_count, expected, "{number}");
        }
    });
}

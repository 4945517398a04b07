//! Queries of a frame that is submitted in pieces: every result is read back when its piece is
//! over.

use glam::Vec3;
use gpu::{BlockingQueryPool, Counting, FrameRing, OptionalFeature, QueryIndex, Target};
use occlusion::{ProxyBox, ProxyIo};
use tests::run_on_all;
use tests::shapes::{DepthBoxes, box_at, proxy_pass, square_view};

/// Returns a wall, a box in front of it and a box behind it.
fn boxes() -> [ProxyBox; 3] {
    [
        box_at(Vec3::new(0.0, 0.0, -10.0), Vec3::new(4.0, 4.0, 1.0)),
        box_at(Vec3::new(0.0, 0.0, -5.0), Vec3::splat(0.5)),
        box_at(Vec3::new(0.0, 0.0, -15.0), Vec3::splat(0.5)),
    ]
    .map(ProxyBox::from)
}

#[test]
fn every_answer_is_home_when_its_piece_is_over() {
    run_on_all(|device| {
        let wall_pass = DepthBoxes::new(device);
        let proxies = proxy_pass(device);
        let view = square_view(device, 64);
        let mut target = Target::new(device, [64, 64], "target").unwrap();
        let mut ring = FrameRing::new(device, 2).unwrap();
        let mut queries = BlockingQueryPool::new(device, 2, "test");
        let counts_samples = device.capabilities().has(OptionalFeature::PreciseQueries);
        for round in 0..5_u32 {
            let mut frame = ring.begin().unwrap();
            queries.begin(frame.slot());
            let boxes = frame.uploads().push(&boxes()).unwrap();
            let shows = |query: u32| (query + round).is_multiple_of(3);
            let mut first = 0;
            // Pieces of all sizes, including empty ones, across the pages.
            for count in [1, 100, 0, 255, 256, 1, 300, 600] {
                let commands = frame.commands();
                let taken = queries.take(commands, count).unwrap();
                assert_eq!(taken, first..first + count);
                target.prepare(commands);
                let from = (first == 0).then_some([0.0; 4]);
                commands.rendering(target.render_target(from), |commands| {
                    if from.is_some() {
                        wall_pass.draw(commands, boxes, &view, 0);
                    }
                    proxies.bind(commands, &ProxyIo { boxes, flags: None }, &view);
                    for query in taken.clone() {
                        let counting = [Counting::Some, Counting::Samples][query as usize % 2];
                        queries.scope(commands, QueryIndex(query), counting, |commands| {
                            proxies.draw(commands, if shows(query) { 1 } else { 2 });
                        });
                    }
                });
                queries.read_back(commands, taken.clone());
                let tick = frame.flush(None).unwrap();
                frame.wait(tick).unwrap();
                assert!(device.completed().unwrap() >= tick);
                for query in taken.clone() {
                    let samples = queries.samples(QueryIndex(query));
                    assert_eq!(samples > 0, shows(query), "round {round}, query {query}");
                    // The front of the box is 0.5 / 4.5 of the image wide.
                    let is_counted = counts_samples && query % 2 == 1 && shows(query);
                    assert!(!is_counted || (36..=81).contains(&samples), "{samples} samples");
                }
                first = taken.end;
            }
            assert_eq!(queries.samples(QueryIndex(first)), 0, "never taken");
            frame.submit(None).unwrap();
        }
        device.wait_idle().unwrap();
    });
}

//! The buffers of instance numbers, which grow while frames in flight use smaller ones.

use glam::Vec3;
use gpu::{FrameRing, QueryIndex, QueryRing, Target};
use occlusion::{ProxyBox, ProxyIo};
use tests::run_on_all;
use tests::shapes::{box_at, proxy_pass, square_view};

#[test]
fn numbers_come_while_fewer_are_in_use() {
    run_on_all(|device| {
        let proxies = proxy_pass(device);
        let view = square_view(device, 64);
        let mut target = Target::new(device, [64, 64], "target").unwrap();
        let mut ring = FrameRing::new(device, 2).unwrap();
        let mut queries = QueryRing::<u32>::new(device, 2, "numbered boxes").unwrap();
        let [seen, unseen] =
            [-5.0, 5.0].map(|z| ProxyBox::from(box_at(Vec3::new(0.0, 0.0, z), Vec3::ONE)));
        let mut found = Vec::new();
        for frame_number in 0..4 {
            // The buffers do not contain the last numbers yet.
            let lasts = [1, 5_000 << frame_number, 1].map(|count: u32| count - 1);
            let mut frame = ring.begin().unwrap();
            queries.collect(device.completed().unwrap(), |last, count| found.push((last, count)));
            queries.begin(&mut frame, &[lasts[0], lasts[1], lasts[2]]).unwrap();
            // Only the last box of each list is in front of the eye.
            let boxes = lasts.map(|last| {
                let others = (0..last).map(|_| unseen);
                let boxes: Vec<ProxyBox> = others.chain([seen]).collect();
                frame.uploads().push(&boxes).unwrap()
            });
            let commands = frame.commands();
            target.prepare(commands);
            commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
                for (query, (boxes, last)) in (0..).zip(boxes.into_iter().zip(lasts)) {
                    proxies.bind(commands, &ProxyIo { boxes, flags: None }, &view);
                    queries.scope(commands, QueryIndex(query), |commands| {
                        proxies.draw(commands, last);
                    });
                }
            });
            queries.resolve(commands, 0..3);
            queries.read_back(commands);
            queries.submitted(frame.submit(None).unwrap());
        }
        device.wait_idle().unwrap();
        queries.collect(device.completed().unwrap(), |last, count| found.push((last, count)));
        assert_eq!(found.len(), 12);
        for (last, count) in found {
            assert!(count > 0, "box {last} is not found by its number");
        }
    });
}

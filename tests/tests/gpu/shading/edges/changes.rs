//! Edges of changing objects: of poses, of meshes that are added later, and of objects that move or
//! are removed.

use cull::{ObjectId, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::SampleCount;
use render::{CostModel, EdgeMode, FrameRequest, Renderer, RendererOptions, SpareCapacity};
use scene::{MeshId, Object, ObjectChange, PreparedMesh};
use tests::run_on_all;
use tests::shapes::{box_at, box_scene};
use tests::walk::pixels_that_differ;

use super::{Area, BLACK, RED, SIZE, cylinder, options, renderer_of, settled, straight};
use crate::shading::skinning;

#[test]
fn edges_follow_poses_under_every_strategy() {
    run_on_all(|device| {
        let scene = skinning::scene();
        let film = |strategy| {
            let options = RendererOptions { size: SIZE, ..skinning::options(2) };
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            renderer.set_edges(super::options(EdgeMode::HiddenDashed)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let frame = |frame| {
                skinning::take(&mut renderer, skinning::turns(frame));
                super::draw(&mut renderer, &mut view, strategy, skinning::camera())
            };
            (0..6).map(frame).collect::<Vec<_>>()
        };
        let expected = film(Strategy::FRUSTUM);
        assert!(pixels_that_differ(&expected[0].0, &expected[5].0) > 300, "the slabs bend");
        assert!(expected.iter().all(|image| image.count(BLACK) > 100 && image.count(RED) > 20));
        for strategy in [Strategy::ANTUMBRA, methods::HZB, methods::CHC] {
            for (frame, (a, b)) in expected.iter().zip(film(strategy)).enumerate() {
                assert_eq!(pixels_that_differ(&a.0, &b.0), 0, "{strategy}, frame {frame}");
            }
        }
    });
}

#[test]
fn meshes_that_come_later_have_their_edges() {
    let wall = box_at(vec3(0.0, 0.0, -5.0), vec3(2.0, 1.0, 0.1));
    let behind = Affine3A::from_translation(vec3(1.5, 0.5, -12.0));
    let added = Object { mesh: MeshId(1), transform: behind, tint: u32::MAX };
    let mut whole = box_scene(&[wall]);
    whole.meshes.push(cylinder(24));
    whole.objects.push(added);
    run_on_all(|device| {
        let mut expected = renderer_of(device, &whole, SampleCount::One);
        expected.set_edges(options(EdgeMode::HiddenDashed)).unwrap();
        let expected = settled(&mut expected, Strategy::FRUSTUM, straight());
        let spare =
            SpareCapacity { meshes: 2, vertices: 2000, indices: 2000, ..Default::default() };
        let room = RendererOptions {
            size: SIZE,
            cost_model: CostModel::Off,
            spare_objects: 4,
            spare,
            upload_bytes_per_frame: 1000,
            ..Default::default()
        };
        let mut renderer = Renderer::new(device, &box_scene(&[wall]), &room).unwrap();
        renderer.set_edges(options(EdgeMode::HiddenDashed)).unwrap();
        let mut view = renderer.new_view().unwrap();
        for round in 0..3 {
            let mesh = PreparedMesh::new(cylinder(24)).unwrap();
            let mesh = renderer.add_meshes(vec![mesh]).unwrap()[0];
            let object = Object { mesh, ..added };
            let report = renderer.update(&[ObjectChange::Add { object }]).unwrap();
            let mut frames = 0;
            while renderer.is_uploading() {
                let request = FrameRequest::new(Strategy::ANTUMBRA, straight());
                renderer.render(&mut view, request).unwrap();
                frames += 1;
            }
            assert!(frames > 3, "it comes in pieces: {frames}");
            let found = settled(&mut renderer, Strategy::ANTUMBRA, straight());
            assert_eq!(pixels_that_differ(&expected.0, &found.0), 0, "round {round}");
            let object = report.added[0];
            renderer.update(&[ObjectChange::Remove { object }]).unwrap();
            renderer.remove_meshes(&[mesh]).unwrap();
        }
        let alone = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(alone.count(RED), 0);
    });
}

#[test]
fn edges_move_with_their_objects() {
    let boxes = [-2.0, 0.0, 2.0].map(|x| box_at(vec3(x, 0.0, -10.0), Vec3::splat(0.5)));
    run_on_all(|device| {
        let mut renderer = renderer_of(device, &box_scene(&boxes), SampleCount::One);
        renderer.set_edges(options(EdgeMode::Visible)).unwrap();
        let three = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(three.count(BLACK), 3 * (22 * 22 - 18 * 18));
        let transform = Affine3A::from_scale_rotation_translation(
            Vec3::ONE,
            glam::Quat::IDENTITY,
            vec3(-0.5, 1.5, -10.0),
        );
        let moved = ObjectChange::Move { object: ObjectId(0), transform };
        renderer.update(&[moved, ObjectChange::Remove { object: ObjectId(2) }]).unwrap();
        let two = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(two.count(BLACK), 2 * (22 * 22 - 18 * 18));
        let there = Area { left: 70, top: 10, right: 90, bottom: 30 };
        assert_eq!(two.count_near(&there, BLACK), 22 * 22 - 18 * 18);
    });
}

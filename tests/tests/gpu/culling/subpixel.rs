//! Boxes that show by less than a pixel beside their occluder. Rounding of proxies and snapping of
//! vertices must not lose them: if an object covers a sample, its proxy must cover a sample, too.

use cull::{Aabb, Camera, CullView};
use glam::Vec3;
use gpu::{
    Attachments, BufferSlice, Device, FrameRing, IndirectDraw, QueryIndex, QueryRing, Target,
    Uploads, vk,
};
use occlusion::{ProxyBox, ProxyIo, ShaderSet};
use render::passes::{OpaqueIo, OpaquePass};
use scene::{Mesh, Object, Scene};
use tests::shapes::{box_at, box_scene, proxy_pass, square_camera};
use tests::window_fixture::Random;
use tests::{Driver, drivers, run};

const SIDE: u32 = 512;
/// The number of pairs in a row and in a column. Each pair has its own part of the image.
const CELLS: u32 = 24;

/// Returns screens, then the boxes behind them, which reach past the screens by -0.1 to 0.4 pixels.
fn pairs(numbers: &mut Random) -> Vec<Aabb> {
    let pixel = 2.0 / SIDE as f32;
    let cell = 2.0 / CELLS as f32;
    let mut screens = Vec::new();
    let mut behind = Vec::new();
    for index in 0..CELLS * CELLS {
        let place = |index: u32| (index as f32 + 0.5) * cell - 1.0;
        let centre = Vec3::new(place(index % CELLS), place(index / CELLS), -1.0);
        let half = cell * numbers.between(0.1, 0.4);
        let near = numbers.between(4.0, 9.0);
        let far = numbers.between(10.0, 40.0);
        let past = numbers.between(-0.1, 0.4) * pixel;
        let flat = |half: f32| Vec3::new(half, half, 0.001);
        screens.push(box_at(centre * near, flat(half * near)));
        behind.push(box_at(centre * far, flat((half + past) * far)));
    }
    screens.extend(behind);
    screens
}

/// The instances of a mesh as the opaque pass reads them.
struct Copies {
    io: OpaqueIo,
    indices: u32,
}

impl Copies {
    fn new(uploads: &mut Uploads, geometry: [BufferSlice; 2], mesh: &Mesh, all: &[Object]) -> Self {
        let instance = |object: &Object| {
            let m = object.transform.matrix3;
            let t = object.transform.translation;
            let row = |r: usize| [m.row(r).x, m.row(r).y, m.row(r).z, t[r]];
            [row(0), row(1), row(2), [1.0; 4]]
        };
        let instances = uploads.push_iter(all.iter().map(instance)).unwrap();
        let [vertices, indices] = geometry;
        let io = OpaqueIo { vertices, indices, instances, section: None };
        Self { io, indices: mesh.indices.len() as u32 }
    }

    fn draw(&self, uploads: &mut Uploads, count: u32) -> BufferSlice {
        let draw = |first_instance| IndirectDraw {
            index_count: self.indices,
            instance_count: 1,
            first_instance,
            ..Default::default()
        };
        uploads.push_iter((0..count).map(draw)).unwrap()
    }
}

/// Returns the number of boxes that cover a sample, and the number of these whose proxy covers
/// none.
fn lost(
    device: &Device,
    seeds: u64,
    proxy_of: impl Fn(&CullView, &Aabb) -> Aabb,
) -> (usize, usize) {
    let opaque =
        OpaquePass::new(device, &ShaderSet::embedded().unwrap(), Attachments::default()).unwrap();
    let proxies = proxy_pass(device);
    // Rolled to slant the edges, since all vertices along an upright edge snap alike.
    let camera = Camera { up: Vec3::new(0.3, 1.0, 0.0), ..square_camera() };
    let view =
        CullView::new(&camera, [SIDE, SIDE], device.adapter().limits.sub_pixel_precision_bits);
    let mut target = Target::new(device, [SIDE, SIDE], "target").unwrap();
    let mut ring = FrameRing::new(device, 2).unwrap();
    let mut queries = QueryRing::<(usize, bool)>::new(device, 2, "slivers").unwrap();
    let scene: Scene = box_scene(&[]);
    let mesh = &scene.meshes[0];
    let vertices = device.upload("v", &mesh.vertices, vk::BufferUsageFlags::VERTEX_BUFFER).unwrap();
    let indices = device.upload("i", &mesh.indices, vk::BufferUsageFlags::INDEX_BUFFER).unwrap();
    let mut shown = 0;
    let mut without = 0;
    for seed in 0..seeds {
        let boxes = pairs(&mut Random::new(seed));
        let objects = box_scene(&boxes).objects;
        let screens = boxes.len() / 2;
        let behind = &boxes[screens..];
        let mut frame = ring.begin().unwrap();
        let asked = [true, false].into_iter();
        let tags: Vec<_> =
            asked.flat_map(|proxy| (0..screens).map(move |pair| (pair, proxy))).collect();
        queries.begin(&mut frame, &tags).unwrap();
        let uploads = frame.uploads();
        let copies = Copies::new(uploads, [vertices.whole(), indices.whole()], mesh, &objects);
        let draws = copies.draw(uploads, boxes.len() as u32);
        let enlarged = behind.iter().map(|bounds| ProxyBox::from(proxy_of(&view, bounds)));
        let io = ProxyIo { boxes: uploads.push_iter(enlarged).unwrap(), flags: None };
        let commands = frame.commands();
        let draw_bytes = size_of::<IndirectDraw>() as u64;
        target.prepare(commands);
        commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
            opaque.bind(commands, &copies.io, &view, &scene.light);
            commands.draw_indirect(draws.part(0, screens as u64 * draw_bytes));
            proxies.bind(commands, &io, &view);
            for pair in 0..screens as u32 {
                queries.scope(commands, QueryIndex(pair), |c| proxies.draw(c, pair));
            }
            opaque.bind(commands, &copies.io, &view, &scene.light);
            for pair in screens as u32..2 * screens as u32 {
                let own = draws.part(u64::from(pair) * draw_bytes, draw_bytes);
                queries.scope(commands, QueryIndex(pair), |c| c.draw_indirect(own));
            }
        });
        queries.resolve(commands, 0..tags.len() as u32);
        queries.read_back(commands);
        let tick = frame.submit(None).unwrap();
        queries.submitted(tick);
        device.wait_idle().unwrap();
        let mut samples = vec![[0; 2]; screens];
        let answer = |(pair, proxy): (usize, bool), n| samples[pair][usize::from(proxy)] = n;
        queries.collect(device.completed().unwrap(), answer);
        shown += samples.iter().filter(|[own, _]| *own > 0).count();
        without += samples.iter().filter(|[own, proxy]| *own > 0 && *proxy == 0).count();
    }
    (shown, without)
}

fn with_margin(view: &CullView, bounds: &Aabb) -> Aabb {
    view.margin.proxy(bounds).expect("a box before the near plane")
}

#[test]
fn no_sliver_is_lost() {
    for driver in drivers() {
        run(driver, |device| {
            let (shown, lost) = lost(device, 8, with_margin);
            assert!(shown > 1000, "the search looks at slivers: {shown}");
            assert_eq!(lost, 0, "of {shown} slivers on {driver:?}");
        });
    }
}

#[test]
fn without_the_margin_slivers_are_lost() {
    // Checks that the search above can fail: without a margin, boxes lose slivers on a coarse grid.
    run(Driver::SwiftShader, |device| {
        let (shown, lost) = lost(device, 4, |_, bounds| *bounds);
        assert!(lost > 0, "none of {shown} slivers");
    });
}

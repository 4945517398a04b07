//! A fixture that draws a scene with surfaces, pass by pass and without culling.

use bytemuck::{Pod, Zeroable};
use cull::{Camera, CullView, Hierarchy};
use glam::{Affine3A, Vec3};
use gpu::{Attachments, Device, Readback, Target, vk};
use render::passes::{OpaqueIo, OpaquePass, SkyPass, SurfaceIo, SurfaceKind, SurfacePass};
use render::surfaces::{SurfaceOptions, SurfaceResources};
use render::{ShaderSet, object_bounds};
use scene::{
    Light, Mesh, MeshId, Object, Scene, SurfaceMesh, SurfaceVertex, Surfaces, Vertex,
    bounds_of_vertices,
};

/// An instance as the shaders of scenes with surfaces read it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Instance {
    rows: [[f32; 4]; 3],
    tail: [u32; 4],
}

/// Returns an image of `scene`, four bytes per pixel: depth first, then the colour of the visible
/// surfaces, the sky, and transparent objects in their order.
pub fn image(
    device: &Device,
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    options: &SurfaceOptions,
) -> Vec<u8> {
    let shaders = ShaderSet::embedded().expect("shaders");
    let hierarchy = Hierarchy::build(&object_bounds(scene).expect("a scene")).expect("a hierarchy");
    let surfaces = SurfaceResources::upload(device, scene, &hierarchy, options);
    let surfaces = surfaces.expect("surfaces").expect("a scene with surfaces");
    let transparent = &scene.surfaces.as_ref().expect("surfaces").transparent;
    let first_transparent = surfaces.first_transparent_slot();
    let slots = (0..scene.objects.len() as u32).chain(first_transparent..);
    let instance = |(slot, object): (u32, &Object)| Instance {
        rows: rows_of(&object.transform),
        tail: surfaces.instance_tail(object, slot),
    };
    let instances: Vec<Instance> =
        slots.zip(scene.objects.iter().chain(transparent)).map(instance).collect();
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    let mut meshes = Vec::new();
    for mesh in &scene.meshes {
        meshes.push((indices.len() as u32, mesh.indices.len() as u32, vertices.len() as i32));
        vertices.extend_from_slice(&mesh.vertices);
        indices.extend_from_slice(&mesh.indices);
    }
    let draw = |(first_instance, object): (u32, &Object)| {
        let (first_index, index_count, vertex_offset) = meshes[object.mesh.0 as usize];
        gpu::IndirectDraw {
            index_count,
            instance_count: 1,
            first_index,
            vertex_offset,
            first_instance,
        }
    };
    let draws: Vec<_> = (0..).zip(scene.objects.iter().chain(transparent)).map(draw).collect();
    let (draws, over) = draws.split_at(scene.objects.len());
    let upload = |name, bytes: &[u8], usage| device.upload(name, bytes, usage).expect("memory");
    let usage = vk::BufferUsageFlags::VERTEX_BUFFER;
    let vertices = upload("vertices", bytemuck::cast_slice(&vertices), usage);
    let indices =
        upload("indices", bytemuck::cast_slice(&indices), vk::BufferUsageFlags::INDEX_BUFFER);
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let instances = upload("instances", bytemuck::cast_slice(&instances), usage);
    let usage = vk::BufferUsageFlags::INDIRECT_BUFFER;
    let draws = upload("draws", bytemuck::cast_slice(draws), usage);
    let over = upload("transparent draws", bytemuck::cast_slice(over), usage);

    let plain = OpaquePass::depth_only(device, &shaders, Attachments::default()).expect("a pass");
    let pass = |kind| {
        SurfacePass::new(device, &shaders, Attachments::default(), kind, &surfaces, None)
            .expect("a pass")
    };
    let [masked, colour, transparent_pass] =
        [SurfaceKind::Depth, SurfaceKind::Colour, SurfaceKind::Transparent].map(pass);
    let sky = SkyPass::new(device, &shaders, Attachments::default()).expect("a pass");
    let view = CullView::new(camera, size, device.adapter().limits.sub_pixel_precision_bits);
    let io = SurfaceIo {
        section: None,
        fragments: None,
        vertices: vertices.whole(),
        indices: indices.whole(),
        instances: instances.whole(),
        surfaces: &surfaces,
        shadows: None,
    };
    let mut target = Target::new(device, size, "studio").expect("a target");
    let readback = Readback::new(device, size).expect("an image");
    let record = |commands: &gpu::Commands| {
        target.prepare(commands);
        commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
            if surfaces.is_masked() {
                masked.bind(commands, &io, &view, &scene.light);
            } else {
                let SurfaceIo { vertices, indices, instances, .. } = io;
                let io = OpaqueIo { vertices, indices, instances, section: None };
                plain.bind(commands, &io, &view, &scene.light);
            }
            commands.draw_indirect(draws.whole());
            colour.bind(commands, &io, &view, &scene.light);
            commands.draw_indirect(draws.whole());
            sky.draw(commands, scene.light.sky);
            if !transparent.is_empty() {
                transparent_pass.bind(commands, &io, &view, &scene.light);
                commands.draw_indirect(over.whole());
            }
        });
        target.copy_to(commands, &readback);
    };
    device.run_once("studio", record).expect("an image");
    readback.rgba8().expect("an image").to_vec()
}

/// Returns a scene with one object per mesh, at its place, and without lights.
pub fn scene(
    meshes: Vec<(Mesh, SurfaceMesh)>,
    transforms: &[Affine3A],
    surfaces: Surfaces,
) -> Scene {
    let (meshes, surface_meshes): (Vec<_>, Vec<_>) = meshes.into_iter().unzip();
    let object = |(mesh, transform): (u32, &Affine3A)| Object {
        mesh: MeshId(mesh),
        transform: *transform,
        tint: u32::MAX,
    };
    Scene {
        name: "studio".to_owned(),
        meshes,
        objects: (0..).zip(transforms).map(object).collect(),
        light: Light {
            towards_sun: Vec3::Y,
            sun: [0.0; 3],
            ambient_above: [0.0; 3],
            ambient_below: [0.0; 3],
            sky: [0.0; 3],
        },
        surfaces: Some(Surfaces { meshes: surface_meshes, ..surfaces }),
    }
}

/// Returns a mesh from its corners, with its surface vertices.
pub fn mesh(
    positions: &[Vec3],
    vertices: Vec<SurfaceVertex>,
    indices: Vec<u32>,
    material: u32,
) -> (Mesh, SurfaceMesh) {
    let corner = |position: &Vec3| Vertex { position: position.to_array(), normal: 0, colour: 0 };
    let corners: Vec<Vertex> = positions.iter().map(corner).collect();
    let bounds = bounds_of_vertices(&corners);
    let material = scene::MaterialId(material);
    (
        Mesh { name: "mesh".to_owned(), vertices: corners, indices, bounds, has_backs: false },
        SurfaceMesh { vertices, material },
    )
}

/// Returns a rectangle between two corners of pixels, `distance_m` away and facing the camera. The
/// image is taken by [`square_camera`](crate::shapes::square_camera) and has a side of `side`
/// pixels. Texture coordinates go from the upper left (`uv[0]`) to the lower right (`uv[1]`), in
/// both sets; `change` may change the vertices.
pub fn quad(
    side: u32,
    from: [u32; 2],
    to: [u32; 2],
    distance_m: f32,
    uv: [[f32; 2]; 2],
    material: u32,
    change: impl Fn(&mut SurfaceVertex),
) -> (Mesh, SurfaceMesh) {
    let middle = side as f32 / 2.0;
    let corners = [[0, 0], [0, 1], [1, 0], [1, 1]];
    let place = |[x, y]: [usize; 2]| {
        let part = |pixel: u32| pixel as f32 / middle - 1.0;
        let x = part([from, to][x][0]);
        let y = -part([from, to][y][1]);
        Vec3::new(x, y, -1.0) * distance_m
    };
    let vertex = |[x, y]: [usize; 2]| {
        let mut vertex = SurfaceVertex {
            normal: snorm16(Vec3::Z, 0),
            tangent: snorm16(Vec3::X, 1),
            uv: [[uv[x][0], uv[y][1]]; 2],
            colour: [u16::MAX; 4],
        };
        change(&mut vertex);
        vertex
    };
    let indices = vec![0, 1, 2, 2, 1, 3];
    mesh(&corners.map(place), corners.map(vertex).to_vec(), indices, material)
}

/// Returns a unit vector as snorm16, with a fourth number of -1, 0 or 1.
pub fn snorm16(v: Vec3, w: i16) -> [i16; 4] {
    let part = |value: f32| (value.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    [part(v.x), part(v.y), part(v.z), w * 32767]
}

fn rows_of(transform: &Affine3A) -> [[f32; 4]; 3] {
    std::array::from_fn(|r| {
        let row = transform.matrix3.row(r);
        [row.x, row.y, row.z, transform.translation[r]]
    })
}

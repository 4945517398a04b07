//! The scene of a renderer as a host describes it.

use glam::{Affine3A, Vec3};
use gpu::SampleCount;
use render::{CostModel, RendererOptions, SpareCapacity};
use scene::{
    Light, Mesh, MeshId, Object, Scene, SurfaceMesh, Vertex, bounds_of_vertices, pack_normal,
    pack_unorm,
};

use shadows::ShadowOptions;

use crate::decisions::culler::queries;
use crate::error::Failure;
use crate::executor::device::AntumbraDevice;
use crate::executor::quirks::assumptions;
use crate::layout::{layout, versioned};
use crate::pointers::{read, slice};
use crate::renderer::scene_file::AntumbraSceneFile;
use crate::renderer::shadows::AntumbraShadowDesc;

/// A vertex of a mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraVertex {
    /// Position in the space of the mesh (metres); y is up.
    pub position: [f32; 3],
    /// Unit normal.
    pub normal: [f32; 3],
    /// Linear red, green and blue, 0 to 1; then the share of the object's tint, 0 to 1.
    pub colour: [f32; 4],
}
layout!(AntumbraVertex: position, normal, colour);

/// A mesh that any number of objects may use. The library copies it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraMeshDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// Required: the vertices.
    pub vertices: *const AntumbraVertex,
    /// Required: the number of vertices.
    pub vertex_count: usize,
    /// Required: three indices of vertices for each triangle, counter-clockwise seen from outside.
    pub indices: *const u32,
    /// Required: the number of indices.
    pub index_count: usize,
}
layout!(AntumbraMeshDesc: struct_size, reserved, vertices, vertex_count, indices, index_count);

versioned!(AntumbraMeshDesc: 6, required: [vertices, vertex_count, indices, index_count], defaults: {});

/// A transform from the space of a mesh to the world.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraTransform {
    /// The vectors that the x, y and z axis of the mesh become, then the position of its origin
    /// (metres).
    pub columns: [f32; 12],
}
layout!(AntumbraTransform: columns);

impl From<&AntumbraTransform> for Affine3A {
    fn from(transform: &AntumbraTransform) -> Self {
        Self::from_cols_array(&transform.columns)
    }
}

/// An object: a mesh with a transform.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraMeshObject {
    /// The mesh: its index in `AntumbraRendererDesc::meshes`, or the id that
    /// `antumbra_renderer_add_meshes` wrote.
    pub mesh: u32,
    /// Linear red, green and blue of 8 bits each, red in the lowest byte. Multiplies the colours of
    /// vertices, according to the share of each vertex.
    pub tint: u32,
    /// The transform.
    pub transform: AntumbraTransform,
}
layout!(AntumbraMeshObject: mesh, tint, transform);

impl From<&AntumbraMeshObject> for Object {
    fn from(object: &AntumbraMeshObject) -> Self {
        Self { mesh: MeshId(object.mesh), transform: (&object.transform).into(), tint: object.tint }
    }
}

/// A sun, the light of the sky, and the background. Colours are linear.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AntumbraSunlight {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Vector to the sun, of any length. Default: (0, 1, 0), straight up.
    pub towards_sun: [f32; 3],
    /// Light on surfaces that face the sun; finite, as all colours here. Default: 0, black.
    pub sun: [f32; 3],
    /// Light on surfaces that face up. Default: 0, black.
    pub ambient_above: [f32; 3],
    /// Light on surfaces that face down. Default: 0, black.
    pub ambient_below: [f32; 3],
    /// The colour of the background. Default: 0, black.
    pub sky: [f32; 3],
}
layout!(AntumbraSunlight: struct_size, towards_sun, sun, ambient_above, ambient_below, sky);

versioned!(AntumbraSunlight: 6, required: [], defaults: { towards_sun: [0.0, 1.0, 0.0] });

impl AntumbraSunlight {
    fn light(&self) -> Result<Light, Failure> {
        let Self { sun, ambient_above, ambient_below, sky, .. } = *self;
        let towards_sun = Vec3::from(self.towards_sun).try_normalize();
        let are_finite = [sun, ambient_above, ambient_below, sky]
            .iter()
            .flatten()
            .all(|number| number.is_finite());
        match towards_sun.filter(|_| are_finite) {
            Some(towards_sun) => Ok(Light { towards_sun, sun, ambient_above, ambient_below, sky }),
            None => Err(Failure::argument("desc.light has a number that is not finite")),
        }
    }
}

/// Tests that cost more than they are expected to save are left out, by a built-in table of costs
/// that the times of frames correct.
pub const ANTUMBRA_COST_MODEL_BUILT_IN: u32 = 0;
/// Everything that may be hidden is tested.
pub const ANTUMBRA_COST_MODEL_OFF: u32 = 1;
/// Tests that cost more than they are expected to save are left out, by costs that are measured
/// when the renderer is made; they also choose the predication mode.
pub const ANTUMBRA_COST_MODEL_MEASURED: u32 = 2;

/// The fate of the scene once it is on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SceneKeeping {
    /// It is dropped.
    Dropped,
    /// It is kept for another device.
    Kept,
}

/// The options of a renderer, and the scene that it begins with.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraRendererDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Frames that may be in flight at once, up to 16. Default: 2.
    pub frames_in_flight: u32,
    /// Required: the device, which was adopted with a queue or opened by the library.
    pub device: AntumbraDevice,
    /// Required: width of the image (pixels).
    pub width: u32,
    /// Required: height of the image (pixels).
    pub height: u32,
    /// The meshes. Default: null, with a `mesh_count` of 0.
    pub meshes: *const *const AntumbraMeshDesc,
    /// The number of meshes. Default: 0.
    pub mesh_count: usize,
    /// The objects. Their ids are their indices. Neighbours in the array should be near each other.
    /// Default: null, with an `object_count` of 0.
    pub objects: *const AntumbraMeshObject,
    /// The number of objects. Default: 0.
    pub object_count: usize,
    /// The light. Default: null, for a clear afternoon.
    pub light: *const AntumbraSunlight,
    /// The most occlusion queries of a frame, any number, or `ANTUMBRA_NO_QUERIES`. Objects for
    /// which no query is left are drawn. Default: 8192.
    pub query_budget: usize,
    /// An `ANTUMBRA_COST_MODEL_..`. Default: `ANTUMBRA_COST_MODEL_BUILT_IN`.
    pub cost_model: u32,
    /// Room for objects that are added later. Default: 0.
    pub spare_objects: u32,
    /// Room for meshes that are added later. Default: 0.
    pub spare_meshes: u32,
    /// Room for the vertices of meshes that are added later. Default: 0.
    pub spare_vertices: u32,
    /// Room for the indices of meshes that are added later. Default: 0.
    pub spare_indices: u32,
    /// The most bytes of added meshes that a frame copies to the GPU, any number. Default: 1048576.
    pub upload_bytes_per_frame: u32,
    /// Samples per pixel, 1 or 4. With 4, edges are smooth. A device that evaluates depth and
    /// coverage of a sample at different positions then supports only `ANTUMBRA_STRATEGY_FRUSTUM`.
    /// Default: 1.
    pub samples: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The shadows of the sun, or of the lights of the file. With `ANTUMBRA_SHADOWS_OFF` they can
    /// be turned on later: `antumbra_renderer_set_shadows`. Default: null, for a renderer of meshes
    /// that never has shadows.
    pub shadows: *const AntumbraShadowDesc,
    /// A set of `ANTUMBRA_ASSUMPTION_..` that a self-test found broken: what rests on them is not
    /// used. Default: 0, none.
    pub disabled: u32,
    /// 1 for a renderer that keeps its scene, so that `antumbra_renderer_recover` can draw it on
    /// another device: its meshes stay in memory, and frames cost nothing more. Default: 0.
    pub keeps_scene: u32,
    /// The file whose scene is drawn, in place of `meshes`, `objects` and `light`, which must be
    /// null then. Several renderers may have the same file, and it may be destroyed afterwards.
    /// Default: 0, for a scene of meshes.
    pub scene_file: AntumbraSceneFile,
}
layout!(AntumbraRendererDesc: struct_size, frames_in_flight, device, width, height, meshes,
    mesh_count, objects, object_count, light, query_budget, cost_model, spare_objects, spare_meshes,
    spare_vertices, spare_indices, upload_bytes_per_frame, samples, reserved, shadows, disabled,
    keeps_scene, scene_file);

versioned!(AntumbraRendererDesc: 9,
    required: [width, height],
    defaults: {
        frames_in_flight: 2,
        query_budget: 8192,
        upload_bytes_per_frame: 1 << 20,
        samples: 1
    }
);

impl AntumbraRendererDesc {
    /// Returns the options.
    ///
    /// # Safety
    /// As the rules of the interface.
    pub(crate) unsafe fn options(&self) -> Result<RendererOptions, Failure> {
        let cost_model = match self.cost_model {
            ANTUMBRA_COST_MODEL_BUILT_IN => CostModel::default(),
            ANTUMBRA_COST_MODEL_MEASURED => CostModel::Measured,
            ANTUMBRA_COST_MODEL_OFF => CostModel::Off,
            other => {
                return Err(Failure::argument(format_args!(
                    "there is no ANTUMBRA_COST_MODEL_.. {other}"
                )));
            }
        };
        let samples = sample_count(self.samples)?;
        let shadows = if self.shadows.is_null() {
            ShadowOptions::default()
        } else {
            // SAFETY: the caller's promise.
            unsafe { read("desc.shadows", self.shadows) }?.options()?
        };
        let default = RendererOptions::default();
        Ok(RendererOptions {
            size: [self.width, self.height],
            frames_in_flight: self.frames_in_flight as usize,
            query_budget: queries(self.query_budget),
            cost_model,
            samples,
            shadows,
            spare_objects: self.spare_objects as usize,
            spare: SpareCapacity {
                meshes: self.spare_meshes,
                vertices: self.spare_vertices,
                indices: self.spare_indices,
                ..default.spare
            },
            upload_bytes_per_frame: self.upload_bytes_per_frame as usize,
            disabled: assumptions(self.disabled)?,
            ..default
        })
    }

    /// Returns whether the renderer keeps its scene.
    pub(crate) fn keeping(&self) -> Result<SceneKeeping, Failure> {
        match self.keeps_scene {
            0 => Ok(SceneKeeping::Dropped),
            1 => Ok(SceneKeeping::Kept),
            other => {
                Err(Failure::argument(format_args!("desc.keeps_scene is {other}, not 0 or 1")))
            }
        }
    }

    /// Refuses meshes, objects and a light beside a file.
    pub(crate) fn check_nothing_but_a_file(&self) -> Result<(), Failure> {
        let beside = [
            ("meshes", self.mesh_count > 0),
            ("objects", self.object_count > 0),
            ("light", !self.light.is_null()),
        ];
        match beside.iter().find(|(_, is_there)| *is_there) {
            None => Ok(()),
            Some((name, _)) => Err(Failure::argument(format_args!(
                "desc.{name} is set beside desc.scene_file, which has a scene of its own: leave it \
                 out, and add meshes and objects later"
            ))),
        }
    }

    /// Returns the scene of its meshes, without a check that it can be drawn.
    ///
    /// # Safety
    /// As the rules of the interface.
    pub(crate) unsafe fn scene(&self) -> Result<Scene, Failure> {
        // SAFETY: the caller's promise, here and below.
        let (meshes, objects) = unsafe {
            let objects = slice("desc.objects", self.objects, self.object_count)?;
            (meshes_of("desc.meshes", self.meshes, self.mesh_count)?, objects)
        };
        let light = if self.light.is_null() {
            Light::afternoon()
        } else {
            // SAFETY: as above.
            unsafe { read("desc.light", self.light) }?.light()?
        };
        Ok(Scene {
            name: "scene".to_owned(),
            meshes,
            objects: objects.iter().map(Object::from).collect(),
            light,
            surfaces: None,
        })
    }
}

/// Returns the number of samples per pixel.
pub(crate) fn sample_count(samples: u32) -> Result<SampleCount, Failure> {
    match samples {
        1 => Ok(SampleCount::One),
        4 => Ok(SampleCount::Four),
        other => Err(Failure::argument(format_args!(
            "desc.samples is {other}, and there are 1 or 4 samples per pixel"
        ))),
    }
}

/// Copies meshes.
///
/// # Safety
/// As the rules of the interface.
unsafe fn meshes_of(
    name: &str,
    meshes: *const *const AntumbraMeshDesc,
    count: usize,
) -> Result<Vec<Mesh>, Failure> {
    // SAFETY: the caller's promise, here and below.
    let meshes = unsafe { slice(name, meshes, count) }?;
    let copy = |(number, mesh): (usize, &*const AntumbraMeshDesc)| {
        let name = format!("{name}[{number}]");
        // SAFETY: as above.
        unsafe {
            let desc = read(&name, *mesh)?;
            let of = |field: &str| format!("{name}.{field}");
            let vertices = slice(of("vertices"), desc.vertices, desc.vertex_count)?;
            let indices = slice(of("indices"), desc.indices, desc.index_count)?;
            Ok(mesh_of(name, vertices, indices))
        }
    };
    meshes.iter().enumerate().map(copy).collect()
}

/// Copies meshes that are added to a renderer.
///
/// # Safety
/// As the rules of the interface.
pub(crate) unsafe fn added(
    meshes: *const *const AntumbraMeshDesc,
    count: usize,
) -> Result<Vec<Mesh>, Failure> {
    // SAFETY: the caller's promise.
    unsafe { meshes_of("meshes", meshes, count) }
}

/// Returns the surface that [`Scene::with_surfaces`] gives a mesh.
pub(crate) fn surface_of(mesh: &Mesh) -> Option<SurfaceMesh> {
    let lit = Scene::single(mesh.clone()).with_surfaces();
    lit.surfaces?.meshes.into_iter().next()
}

fn mesh_of(name: String, vertices: &[AntumbraVertex], indices: &[u32]) -> Mesh {
    let packed = vertices.iter().map(|vertex| Vertex {
        position: vertex.position,
        normal: pack_normal(Vec3::from(vertex.normal)),
        colour: pack_unorm(vertex.colour),
    });
    let vertices: Vec<Vertex> = packed.collect();
    let bounds = bounds_of_vertices(&vertices);
    Mesh { name, vertices, indices: indices.to_vec(), bounds, has_backs: false }
}

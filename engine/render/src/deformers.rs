//! Meshes that change their form: what they are made of lies on the GPU since loading; what changes is
//! a pose, which the next frame brings before anything reads the vertices.

use cull::Hierarchy;
use glam::Affine3A;
use gpu::{Buffer, BufferSlice, Device, Frame, vk};
use occlusion::{PlanExecutor, ShaderSet};
use scene::{Deformer, DeformerId, Mesh, MorphTarget, Scene, SurfaceVertex};

use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::limits::check_storage;
use crate::passes::{DeformIo, DeformPass, Deformation, REST_WORDS};
use crate::renderer::Renderer;

/// All deformers of a scene and their newest poses.
pub(crate) struct Deformers {
    pub(crate) pass: DeformPass,
    forms: Buffer,
    all: Vec<State>,
    /// Whose pose the next frame brings.
    stale: Vec<usize>,
    /// The poses of a frame, kept to allocate nothing.
    words: Vec<u32>,
}

/// A deformer as the CPU knows it.
struct State {
    /// Without what its pose says.
    form: Deformation,
    joint_count: usize,
    targets: Vec<TargetPlaces>,
    joints: Vec<Affine3A>,
    weights: Vec<f32>,
    is_stale: bool,
    /// Where this frame's poses have it.
    pose: Deformation,
}

/// Where the lists of a target begin among the forms, in words, or [`NOTHING`].
#[derive(Clone, Copy)]
struct TargetPlaces([u32; 3]);

/// Mirrors `deform.comp`.
const NOTHING: u32 = u32::MAX;

/// The vertices that the pass writes, from the first on.
#[derive(Clone, Copy)]
pub(crate) struct DeformedVertices {
    pub(crate) vertices: BufferSlice,
    pub(crate) surfaces: BufferSlice,
}

impl Deformers {
    /// Uploads what the deformers of a scene that was validated are made of. `first_vertices` says where
    /// the vertices of each mesh begin.
    ///
    /// # Errors
    /// More than the device's storage buffers hold, no memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        scene: &Scene,
        first_vertices: impl Fn(usize) -> u32,
    ) -> Result<Option<Self>, Error> {
        let Some(surfaces) = scene.surfaces.as_ref().filter(|it| !it.deformers.is_empty()) else {
            return Ok(None);
        };
        const FEWER: &str = "leave out joints or morph targets, or make those meshes simpler";
        let [forms, poses] = words_of(scene);
        let what = "words of joints, weights and morph targets";
        check_storage(device, what, (forms, 4), FEWER)?;
        check_storage(device, "words of poses", (poses, 4), FEWER)?;
        let (mut words, mut all) = (Vec::new(), Vec::with_capacity(surfaces.deformers.len()));
        for deformer in &surfaces.deformers {
            let mesh = deformer.mesh.0 as usize;
            let (Some(at_rest), Some(surface)) =
                (scene.meshes.get(mesh), surfaces.meshes.get(mesh))
            else {
                continue;
            };
            all.push(State::new(
                deformer,
                (at_rest, &surface.vertices),
                first_vertices(mesh),
                &mut words,
            ));
        }
        debug_assert_eq!(words.len() as u64, forms);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Some(Self {
            pass: DeformPass::new(device, shaders)?,
            forms: device.upload("forms", &words, storage)?,
            all,
            stale: Vec::new(),
            words: Vec::new(),
        }))
    }

    /// Takes a pose. True if it is another than before.
    fn pose(
        &mut self,
        deformer: DeformerId,
        joints: &[Affine3A],
        weights: &[f32],
    ) -> Result<bool, Error> {
        let refuse = |reason: String| Err(Error::Deform { deformer, reason });
        let number = deformer.0 as usize;
        let Some(state) = self.all.get_mut(number) else {
            return refuse("the scene has no such deformer".to_owned());
        };
        let (joint_count, target_count) = (state.joint_count, state.targets.len());
        if joints.len() != joint_count {
            return refuse(format!("it has {joint_count} joints, not {}", joints.len()));
        }
        if weights.len() != target_count {
            return refuse(format!("it has {target_count} morph targets, not {}", weights.len()));
        }
        if let Some(joint) = joints.iter().position(|joint| !joint.is_finite()) {
            return refuse(format!("its joint {joint} has a number that is not finite"));
        }
        if let Some(target) = weights.iter().position(|weight| !weight.is_finite()) {
            return refuse(format!("the weight of its target {target} is not finite"));
        }
        if state.joints == joints && state.weights == weights {
            return Ok(false);
        }
        joints.clone_into(&mut state.joints);
        weights.clone_into(&mut state.weights);
        if !std::mem::replace(&mut state.is_stale, true) {
            self.stale.push(number);
        }
        Ok(true)
    }

    /// Records what brings the newest poses, before anything of `frame` reads vertices. They stay stale
    /// until the frame was [submitted](Deformers::submitted): it may never be.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn bring(
        &mut self,
        frame: &mut Frame<'_>,
        deformed: DeformedVertices,
    ) -> Result<(), Error> {
        if self.stale.is_empty() {
            return Ok(());
        }
        self.words.clear();
        for number in &self.stale {
            if let Some(state) = self.all.get_mut(*number) {
                state.write(&mut self.words);
            }
        }
        let poses = frame.uploads().push(&self.words)?;
        let DeformedVertices { vertices, surfaces } = deformed;
        let io = DeformIo { vertices, surfaces, forms: self.forms.whole(), poses };
        let poses = self.stale.iter().filter_map(|number| Some(self.all.get(*number)?.pose));
        self.pass.record(frame.commands(), &io, poses);
        Ok(())
    }

    /// The frame that [`Deformers::bring`] recorded for is on its way.
    pub(crate) fn submitted(&mut self) {
        for number in self.stale.drain(..) {
            if let Some(state) = self.all.get_mut(number) {
                state.is_stale = false;
            }
        }
    }
}

impl State {
    /// Appends what a deformer is made of to the words of all.
    fn new(
        deformer: &Deformer,
        (mesh, surface): (&Mesh, &[SurfaceVertex]),
        first_vertex: u32,
        words: &mut Vec<u32>,
    ) -> Self {
        let place = |words: &Vec<u32>| words.len() as u32;
        let mut form = Deformation {
            vertex_count: mesh.vertices.len() as u32,
            first_vertex,
            rest: place(words),
            ..Deformation::default()
        };
        for (vertex, surface) in mesh.vertices.iter().zip(surface) {
            words.extend(vertex.position.map(f32::to_bits));
            let [x, y, z, sides] = surface.normal;
            let [tangent_x, tangent_y, tangent_z, sign] = surface.tangent;
            let pairs = [[x, y], [z, sides], [tangent_x, tangent_y], [tangent_z, sign]];
            words.extend(
                pairs.map(|[low, high]| u32::from(low as u16) | u32::from(high as u16) << 16),
            );
        }
        debug_assert_eq!(place(words), form.rest + REST_WORDS * form.vertex_count);
        form.skin = place(words);
        if let Some(skin) = &deformer.skin {
            form.joint_sets = skin.sets;
            for (joints, weights) in skin.joints.iter().zip(&skin.weights) {
                let pair =
                    |first: usize| u32::from(joints[first]) | u32::from(joints[first + 1]) << 16;
                words.extend([pair(0), pair(2)]);
                words.extend(weights.map(f32::to_bits));
            }
        }
        let targets = deformer.targets.iter().map(|target| {
            TargetPlaces([&target.positions, &target.normals, &target.tangents].map(|list| {
                if list.is_empty() {
                    return NOTHING;
                }
                let begins = place(words);
                words.extend(list.as_flattened().iter().map(|part| part.to_bits()));
                begins
            }))
        });
        Self {
            form,
            targets: targets.collect(),
            joint_count: deformer.skin.as_ref().map_or(0, |skin| skin.joint_count as usize),
            // At rest, as the vertices are: no pose was told yet.
            joints: Vec::new(),
            weights: Vec::new(),
            is_stale: false,
            pose: form,
        }
    }

    /// Appends its pose to those of a frame.
    fn write(&mut self, words: &mut Vec<u32>) {
        let joints = words.len() as u32;
        for joint in &self.joints {
            for row in 0..3 {
                let part = joint.matrix3.row(row);
                let row = [part.x, part.y, part.z, joint.translation[row]];
                words.extend(row.map(f32::to_bits));
            }
        }
        let targets = words.len() as u32;
        let mut target_count = 0;
        for (weight, TargetPlaces(places)) in self.weights.iter().zip(&self.targets) {
            if *weight != 0.0 {
                words.push(weight.to_bits());
                words.extend(places);
                target_count += 1;
            }
        }
        self.pose = Deformation { joints, targets, target_count, ..self.form };
    }
}

/// How many words the deformers of a scene take, and the poses of all.
fn words_of(scene: &Scene) -> [u64; 2] {
    let mut sums = [0, 0];
    for deformer in scene.surfaces.iter().flat_map(|surfaces| &surfaces.deformers) {
        let mesh = scene.meshes.get(deformer.mesh.0 as usize);
        let skin = deformer.skin.as_ref();
        let influences = skin.map_or(0, |skin| skin.joints.len() as u64);
        let lists = |target: &MorphTarget| {
            (target.positions.len() + target.normals.len() + target.tangents.len()) as u64
        };
        sums[0] += mesh.map_or(0, |mesh| mesh.vertices.len() as u64) * u64::from(REST_WORDS)
            + influences * 6
            + deformer.targets.iter().map(lists).sum::<u64>() * 3;
        sums[1] += skin.map_or(0, |skin| u64::from(skin.joint_count)) * 12
            + deformer.targets.len() as u64 * 4;
    }
    sums
}

impl FramePasses {
    /// Records the upload of what changed since the last frame, before anything of `frame` reads it.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn upload_changes(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        executor: &mut PlanExecutor,
    ) -> Result<(), Error> {
        self.geometry.relight(hierarchy, &mut executor.leaves);
        self.geometry.upload_changes(frame, hierarchy, executor)?;
        if let (Some(deformers), Some(deformed)) = (&mut self.deformers, self.geometry.deformed()) {
            deformers.bring(frame, deformed)?;
        }
        Ok(())
    }

    /// Notes that the frame that [`FramePasses::upload_changes`] recorded for is on its way.
    pub(crate) fn submitted(&mut self) {
        self.target.submitted();
        self.geometry.submitted();
        if let Some(deformers) = &mut self.deformers {
            deformers.submitted();
        }
    }
}

impl Renderer {
    /// Gives a mesh that changes its form a pose: the next frame shows it, frames on their way do not.
    /// Each joint takes points of the mesh at rest to the object's own space; `weights` says how much of each morph
    /// target is added, whatever the sum. The same pose again costs nothing, and neither do
    /// targets of weight 0.
    ///
    /// The object's box must hold it: tell it with
    /// [`ObjectChange::Reshape`](scene::ObjectChange::Reshape) before the next frame, or what is
    /// outside of the box may be missing in the picture.
    ///
    /// # Errors
    /// [`Error::Deform`]: no such deformer, another number of joints or targets than it has, numbers that
    /// are not finite. Nothing has changed then.
    pub fn deform(
        &mut self,
        deformer: DeformerId,
        joints: &[Affine3A],
        weights: &[f32],
    ) -> Result<(), Error> {
        let Some(deformers) = &mut self.passes.deformers else {
            let reason = "the scene has nothing that changes its form".to_owned();
            return Err(Error::Deform { deformer, reason });
        };
        if deformers.pose(deformer, joints, weights)? {
            self.edition.advance();
        }
        Ok(())
    }
}

/// The meshes of a scene in the order of their vertices: those that change their form first, so that
/// these are one part of the buffers that a storage buffer can be.
pub(crate) fn mesh_order(scene: &Scene) -> Vec<usize> {
    let is_deformed = are_deformed(scene);
    let mut order: Vec<usize> = (0..scene.meshes.len()).collect();
    order.sort_by_key(|mesh| !is_deformed[*mesh]);
    order
}

/// How many vertices the meshes have together that change their form.
pub(crate) fn deformed_vertices(scene: &Scene) -> u64 {
    let deformers = scene.surfaces.iter().flat_map(|surfaces| &surfaces.deformers);
    let meshes = deformers.filter_map(|deformer| scene.meshes.get(deformer.mesh.0 as usize));
    meshes.map(|mesh| mesh.vertices.len() as u64).sum()
}

/// Which meshes of a scene change their form.
pub(crate) fn are_deformed(scene: &Scene) -> Vec<bool> {
    let mut are_deformed = vec![false; scene.meshes.len()];
    for deformer in scene.surfaces.iter().flat_map(|surfaces| &surfaces.deformers) {
        if let Some(is_deformed) = are_deformed.get_mut(deformer.mesh.0 as usize) {
            *is_deformed = true;
        }
    }
    are_deformed
}

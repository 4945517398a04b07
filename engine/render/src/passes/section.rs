//! Section planes in the form that passes of objects read, and the variants of passes that are cut.

use bytemuck::{Pod, Zeroable};
use cull::{CullView, SectionMode, SectionPlanes};
use glam::{DMat4, DVec4};
use gpu::Spirv;
use gpu::{BufferSlice, vk};
use occlusion::{Error, SectionShaders, ShaderSet};

/// The last buffers of passes that are [cut](SectionShaders::Cut).
#[derive(Clone, Copy)]
pub struct SectionIo {
    /// The planes of the view.
    pub(crate) planes: BufferSlice,
    /// The effects of the planes on each instance, 16 bits per instance.
    pub(crate) states: BufferSlice,
}

impl SectionIo {
    /// Returns these planes with the states of other instances.
    pub(crate) fn of_states(self, states: BufferSlice) -> Self {
        Self { states, ..self }
    }
}

/// The planes of a view; mirrors `section.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct SectionRow {
    planes: [[f32; 4]; SectionPlanes::MAX],
    middle: [f32; 2],
    count: u32,
    mode: u32,
}

const _: () = assert!(size_of::<SectionRow>() == 112);

impl SectionRow {
    /// Returns the planes of a view.
    pub(crate) fn of(view: &CullView) -> Self {
        let image = ImageRows::of(view);
        let mut planes = [[0.0; 4]; SectionPlanes::MAX];
        for (row, plane) in planes.iter_mut().zip(view.section.planes()) {
            *row = image.row(plane.from_anchor(view.anchor.as_dvec3())).as_vec4().to_array();
        }
        Self {
            planes,
            middle: image.middle,
            count: view.section.planes().len() as u32,
            mode: match view.section.mode() {
                SectionMode::Intersection => 0,
                SectionMode::Union => 1,
            },
        }
    }
}

/// The image of a view as section shaders use it: positions in pixels from its middle, and depths.
pub(crate) struct ImageRows {
    /// Maps (pixels, depth, 1) to homogeneous coordinates of the world, relative to the anchor.
    to_place: DMat4,
    middle: [f32; 2],
}

impl ImageRows {
    pub(crate) fn of(view: &CullView) -> Self {
        let [width, height] = view.size.map(|side| f64::from(side.max(1)));
        let to_ndc = DMat4::from_diagonal(DVec4::new(2.0 / width, 2.0 / height, 1.0, 1.0));
        let middle =
            [0, 1].map(|axis: usize| view.origin[axis] as f32 + view.size[axis] as f32 * 0.5);
        Self { to_place: view.from_anchor.as_dmat4().inverse() * to_ndc, middle }
    }

    /// Returns the row that applies to positions in the image, from the row that applies to
    /// homogeneous coordinates of the world relative to the anchor.
    pub(crate) fn row(&self, row: DVec4) -> DVec4 {
        self.to_place.transpose() * row
    }
}

/// Returns the number of additional storage buffers of a pass of objects.
pub(super) fn section_buffers(section: SectionShaders) -> u32 {
    match section {
        SectionShaders::Whole => 0,
        SectionShaders::Cut => 2,
    }
}

/// Returns the faces that a pass of objects culls. A pass that is cut draws both sides, since an
/// open shell shows its inside; its shaders leave out the backs of objects that are not cut.
pub(super) fn culled_faces(section: SectionShaders, faces: vk::CullModeFlags) -> vk::CullModeFlags {
    match section {
        SectionShaders::Whole => faces,
        SectionShaders::Cut => vk::CullModeFlags::NONE,
    }
}

/// Calls `bind` with the buffers of a pass, followed by the buffers of section planes.
pub(super) fn with_section(
    own: &[BufferSlice],
    section: Option<SectionIo>,
    bind: impl FnOnce(&[BufferSlice]),
) {
    match section {
        None => bind(own),
        Some(SectionIo { planes, states }) => bind(&[own, &[planes, states]].concat()),
    }
}

/// Returns the vertex shader of passes that draw only the depth of objects, and the fragment shader
/// if they are cut.
pub(super) fn cut_depth_stages(shaders: &ShaderSet) -> Result<(&Spirv, Option<&Spirv>), Error> {
    Ok(match shaders.section() {
        SectionShaders::Whole => (shaders.find("seen.vert")?, None),
        SectionShaders::Cut => {
            (shaders.find("counted_section.vert")?, Some(shaders.find("section_depth.frag")?))
        }
    })
}

//! The engine's shaders: SPIR-V that is committed beside its GLSL, embedded.
//!
//! A file is named after its pass and stage. The feature `sources` compares GLSL and SPIR-V on
//! disk.
//!
//! ```
//! # use antumbra_shaders as shaders;
//! let sky = shaders::find("sky.frag").expect("a pass");
//! assert_eq!(sky.spirv[..4], 0x0723_0203_u32.to_le_bytes());
//! ```
#![forbid(unsafe_code)]

#[cfg(feature = "sources")]
pub mod sources;

/// One stage of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shader {
    /// The GLSL file's name: the pass and the stage.
    pub name: &'static str,
    /// The SPIR-V committed beside it.
    pub spirv: &'static [u8],
}

macro_rules! shader {
    ($name:literal) => {
        Shader { name: $name, spirv: include_bytes!(concat!("../", $name, ".spv")) }
    };
}

/// The compute stage that writes query results into the draw counts of groups
/// (`gpu::PredicationMode::Counts`).
pub const PREDICATE_COUNTS: Shader = shader!("predicate_counts.comp");

/// The compute stage that writes query results into instance counts of draws
/// (`gpu::PredicationMode::Instances`).
pub const PREDICATE_INSTANCES: Shader = shader!("predicate_instances.comp");

/// The compute stage that adds the results of a query in the views of a rendering.
pub const SUM_QUERIES: Shader = shader!("sum_queries.comp");

/// The compute stage that copies the farthest depth of each pixel with several samples.
pub const FARTHEST_DEPTHS: Shader = shader!("farthest_depths.comp");

/// Every shader of the renderer's passes.
pub const PASSES: [Shader; 108] = [
    shader!("opaque.vert"),
    shader!("opaque.frag"),
    shader!("proxy.vert"),
    shader!("proxy.frag"),
    shader!("proxy_multiview.vert"),
    shader!("box_volume.vert"),
    shader!("leaf_box.vert"),
    shader!("leaf_box.frag"),
    shader!("leaf_box_multiview.vert"),
    shader!("overlay.vert"),
    shader!("overlay.frag"),
    shader!("wireframe.frag"),
    shader!("seen.vert"),
    shader!("seen.frag"),
    shader!("pointer.frag"),
    shader!("layers.vert"),
    shader!("layers_section.vert"),
    shader!("layers.frag"),
    shader!("layers_section.frag"),
    shader!("depth_complexity.frag"),
    shader!("flare.vert"),
    shader!("flare.frag"),
    shader!("flare_block.vert"),
    shader!("flare_block.frag"),
    shader!("flare_transmittance.frag"),
    shader!("flare_transmittance_bindless.frag"),
    shader!("sky.vert"),
    shader!("sky.frag"),
    shader!("sky_around.frag"),
    shader!("sky_panorama.frag"),
    shader!("depth_grid.comp"),
    shader!("compute_test.comp"),
    shader!("pyramid_build.comp"),
    shader!("pyramid_first.comp"),
    shader!("pyramid_second.comp"),
    shader!("scatter.comp"),
    shader!("list_sizes.comp"),
    shader!("list_draws.comp"),
    shader!("list_places.comp"),
    shader!("skinning.comp"),
    shader!("patch_points.comp"),
    shader!("patch_capture.vert"),
    shader!("patch_capture.tesc"),
    shader!("patch_capture.tese"),
    shader!("surface.vert"),
    shader!("surface.frag"),
    shader!("surface_shadowed.frag"),
    shader!("surface_volumes.frag"),
    shader!("surface_depth.vert"),
    shader!("surface_depth.frag"),
    shader!("surface_bindless.frag"),
    shader!("surface_shadowed_bindless.frag"),
    shader!("surface_volumes_bindless.frag"),
    shader!("surface_depth_bindless.frag"),
    shader!("surface_sorted.frag"),
    shader!("surface_sorted_section.frag"),
    shader!("surface_sorted_bindless.frag"),
    shader!("surface_sorted_bindless_section.frag"),
    shader!("surface_shadowed_sorted.frag"),
    shader!("surface_shadowed_sorted_section.frag"),
    shader!("surface_shadowed_sorted_bindless.frag"),
    shader!("surface_shadowed_sorted_bindless_section.frag"),
    shader!("surface_sorted_section.vert"),
    shader!("sorted_fragments.frag"),
    shader!("midpoint.frag"),
    shader!("volume.vert"),
    shader!("volume.geom"),
    shader!("volume_extrude.comp"),
    shader!("volume_extruded.vert"),
    shader!("volume_mask.frag"),
    shader!("edge.vert"),
    shader!("edge.geom"),
    shader!("edge_quads.vert"),
    shader!("edge.frag"),
    shader!("edge_section.vert"),
    shader!("edge_section.geom"),
    shader!("edge_quads_section.vert"),
    shader!("edge_section.frag"),
    shader!("opaque_section.vert"),
    shader!("opaque_section.frag"),
    shader!("opaque_depth_section.vert"),
    shader!("section_depth.frag"),
    shader!("counted_section.vert"),
    shader!("wireframe_section.frag"),
    shader!("seen_section.vert"),
    shader!("seen_section.frag"),
    shader!("surface_section.vert"),
    shader!("surface_shadowed_section.vert"),
    shader!("surface_depth_section.vert"),
    shader!("surface_section.frag"),
    shader!("surface_bindless_section.frag"),
    shader!("surface_shadowed_section.frag"),
    shader!("surface_shadowed_bindless_section.frag"),
    shader!("surface_volumes_section.frag"),
    shader!("surface_volumes_bindless_section.frag"),
    shader!("surface_depth_section.frag"),
    shader!("surface_depth_bindless_section.frag"),
    shader!("flare_transmittance_section.frag"),
    shader!("flare_transmittance_bindless_section.frag"),
    shader!("cap_count.vert"),
    shader!("cap_count.frag"),
    shader!("cap.vert"),
    shader!("cap.frag"),
    shader!("cap_depth.frag"),
    shader!("cap_seen.frag"),
    shader!("cap_pointed.frag"),
    shader!("section_mark.frag"),
    shader!("pointer_section.frag"),
];

/// Returns the stage of that name among [`PASSES`].
pub fn find(name: &str) -> Option<Shader> {
    PASSES.into_iter().find(|shader| shader.name == name)
}

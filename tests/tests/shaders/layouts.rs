//! The buffers and constants of the committed SPIR-V are compared with the structures in Rust.

use std::mem::offset_of;

use gpu::{DrawLink, IndirectDraw, LISTED_LEAVES, OptionalFeature, RequiredFeature, Reveal};
use spirq::prelude::*;
use spirq::ty::Type;
use spirq::var::Variable;

use crate::{OF_GPU, committed_spirv};

/// The stride of each storage buffer's array and the offsets of its elements' members, by binding.
type Buffers = Vec<(u32, usize, Vec<usize>)>;

/// Returns the inputs of one stage: its storage buffers, without textures, and the size of its push
/// constants in bytes.
fn interface(name: &str) -> (Buffers, usize) {
    let spirv = committed_spirv(name);
    let entries = ReflectConfig::new().spv(spirv).ref_all_rscs(true).reflect().expect("SPIR-V");
    let [entry] = &entries[..] else { panic!("{name} has {} entry points", entries.len()) };
    assert_eq!(entry.name, "main");
    let mut buffers = Vec::new();
    let mut push_bytes = 0;
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { desc_bind, ty, nbind, .. } => {
                if name.contains("_bindless") && desc_bind.set() == 1 {
                    // The table of textures, which has no fixed length.
                    assert_eq!((desc_bind.bind(), *nbind), (0, 0), "{name}");
                    continue;
                }
                assert_eq!(desc_bind.set(), 0, "{name}");
                if let Type::CombinedImageSampler(_) = ty {
                    // Pages are the last of all bindings.
                    let first_array = match name {
                        "surface_shadowed_section.frag" => 13,
                        "surface_volumes_section.frag" => 10,
                        "surface_section.frag" => 8,
                        "surface_shadowed.frag" => 11,
                        "surface_volumes.frag" => 8,
                        "surface.frag" => 6,
                        "surface_sorted.frag" => 7,
                        "surface_sorted_section.frag" => 8,
                        "surface_shadowed_sorted.frag" => 12,
                        "surface_shadowed_sorted_section.frag" => 13,
                        _ => 0,
                    };
                    let is_surface =
                        name.starts_with("surface") || name.starts_with("flare_transmittance");
                    let is_surface = is_surface && !name.contains("_bindless");
                    let is_array = is_surface && desc_bind.bind() >= first_array;
                    assert_eq!(
                        *nbind,
                        if is_array { scene::limits::MAX_PAGES as u32 } else { 1 },
                        "{name}"
                    );
                    continue;
                }
                assert_eq!(*nbind, 1, "{name}");
                let (stride, offsets) = array_in(name, ty);
                buffers.push((desc_bind.bind(), stride, offsets));
            }
            Variable::PushConstant { ty, .. } => push_bytes = ty.nbyte().expect("a size"),
            _ => {}
        }
    }
    buffers.sort_unstable();
    (buffers, push_bytes)
}

/// Returns the stride and the offsets of a storage buffer: a structure with a single unsized array.
fn array_in(name: &str, ty: &Type) -> (usize, Vec<usize>) {
    let Type::Struct(block) = ty else { panic!("{name}: no block but {ty}") };
    let [member] = &block.members[..] else { panic!("{name}: more than an array in {ty}") };
    let Type::Array(array) = &member.ty else { panic!("{name}: no array in {ty}") };
    assert_eq!((member.offset, array.nelement), (Some(0), None), "{name}");
    let offsets = match array.element_ty.as_ref() {
        Type::Struct(element) => {
            element.members.iter().filter_map(|member| member.offset).collect()
        }
        _ => vec![0],
    };
    (array.stride.expect("a stride"), offsets)
}

const INDIRECT_DRAW_OFFSETS: [usize; 5] = [
    offset_of!(IndirectDraw, index_count),
    offset_of!(IndirectDraw, instance_count),
    offset_of!(IndirectDraw, first_index),
    offset_of!(IndirectDraw, vertex_offset),
    offset_of!(IndirectDraw, first_instance),
];

/// Returns the lists of draws.
fn links(binding: u32) -> (u32, usize, Vec<usize>) {
    let offsets = vec![offset_of!(DrawLink, next), offset_of!(DrawLink, instance_count)];
    (binding, size_of::<DrawLink>(), offsets)
}

#[test]
fn instances_are_three_rows_and_a_tint() {
    // The rows are an array of three, so the tint is the second member.
    assert_eq!(interface("opaque.vert"), (vec![(0, 64, vec![0, 48])], 128));
    assert_eq!(interface("opaque.frag"), (vec![], 128));
}

#[test]
fn proxies_are_two_corners() {
    assert_eq!(size_of::<occlusion::ProxyBox>(), 32);
    assert_eq!(interface("proxy.vert"), (vec![(0, 32, vec![0, 16])], 80));
}

#[test]
fn the_seen_pass_reads_instances_and_writes_a_value_per_leaf() {
    for name in ["seen.vert", "layers.vert"] {
        assert_eq!(interface(name), (vec![(0, 64, vec![0, 48])], 88));
    }
    assert_eq!(interface("seen.frag"), (vec![(1, 4, vec![0])], 0));
}

#[test]
fn flags_are_values_and_leaf_boxes_enable_draws() {
    assert_eq!(interface("proxy.frag"), (vec![(1, 4, vec![0])], 0));
    assert_eq!(interface("leaf_box.vert"), (vec![(0, 32, vec![0, 16])], 104));
    let draws = (1, size_of::<IndirectDraw>(), INDIRECT_DRAW_OFFSETS.to_vec());
    let values = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("leaf_box.frag"), (vec![draws, values(2), values(3), links(4)], 0));
    let source = |name| std::fs::read_to_string(crate::folder().join(name)).unwrap();
    let says = |name, text: String| assert!(source(name).contains(&text), "{name}: {text}");
    says("leaf_box.frag", format!("LISTED_LEAVES = {LISTED_LEAVES};"));
    says("draw_link.glsl", format!("NO_DRAW = {};", DrawLink::NO_DRAW));
    says("draw_link.glsl", format!("constant_id = {}) const bool LINKED", gpu::LINKED));
}

#[test]
fn the_overlay_has_a_matrix_and_no_buffers() {
    assert_eq!(interface("overlay.vert"), (vec![], 80));
    assert_eq!(interface("overlay.frag"), (vec![], 0));
    assert_eq!(offset_of!(render::passes::OverlayVertex, colour), 12);
}

#[test]
fn flares_have_blocks_and_sprites() {
    use render::passes::{FlareBlockRow, FlareSprite};
    let offsets = vec![
        offset_of!(FlareBlockRow, low),
        offset_of!(FlareBlockRow, target_low),
        offset_of!(FlareBlockRow, side),
        offset_of!(FlareBlockRow, depth),
        offset_of!(FlareBlockRow, first_cell),
        offset_of!(FlareBlockRow, unused),
    ];
    let blocks = |binding| (binding, size_of::<FlareBlockRow>(), offsets.clone());
    let transmittance = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("flare_block.vert"), (vec![blocks(0)], 12));
    assert_eq!(interface("flare_block.frag"), (vec![blocks(0), transmittance(1)], 0));
    let found = interface("flare_transmittance.frag").0;
    assert!(found.ends_with(&[blocks(3), transmittance(4)]), "{found:?}");
    let offsets = vec![
        offset_of!(FlareSprite, middle),
        offset_of!(FlareSprite, radius),
        offset_of!(FlareSprite, colour),
        offset_of!(FlareSprite, shape),
    ];
    assert_eq!(interface("flare.vert"), (vec![(0, size_of::<FlareSprite>(), offsets)], 0));
    assert_eq!(interface("flare.frag"), (vec![], 0));
}

#[test]
fn predicates_read_results_and_ranges() {
    let values = (0, 4, vec![0]);
    let ranges = (1, 16, vec![0, 4, 8, 12]);
    let boxes = (3, size_of::<gpu::vk::DrawIndirectCommand>(), vec![0, 4, 8, 12]);
    let draws = (2, size_of::<IndirectDraw>(), INDIRECT_DRAW_OFFSETS.to_vec());
    let counts = (2, 4, vec![0]);
    let [of_counts, of_instances, ..] = OF_GPU.map(|shader| interface(shader.name));
    assert_eq!(of_counts, (vec![values.clone(), ranges.clone(), counts], 12));
    assert_eq!(of_instances, (vec![values, ranges, draws, boxes, links(4)], 12));
    let source = std::fs::read_to_string(crate::folder().join("predicate.glsl")).unwrap();
    for (name, reveal) in
        [("DRAWS", Reveal::Draws), ("BOXES", Reveal::Boxes), ("ENABLED", Reveal::EnabledDraws)]
    {
        assert!(source.contains(&format!("REVEAL_{name} = {};", reveal as u32)), "{name}");
    }
    // The layout that vkCmdDrawIndexedIndirect reads.
    assert_eq!(size_of::<IndirectDraw>(), size_of::<gpu::vk::DrawIndexedIndirectCommand>());
    assert_eq!(INDIRECT_DRAW_OFFSETS, [0, 4, 8, 12, 16]);
}

#[test]
fn the_pyramid_reads_boxes_and_draws_and_counts_them() {
    assert_eq!(interface("pyramid_build.comp"), (vec![(0, 4, vec![0])], 16));
    let draw = (size_of::<IndirectDraw>(), INDIRECT_DRAW_OFFSETS.to_vec());
    // The value after the lower corner of a box holds the number of shown triangles.
    let first = vec![
        (0, 32, vec![0, 12, 16, 28]),
        (1, draw.0, draw.1.clone()),
        (2, 4, vec![0]),
        (3, draw.0, draw.1),
        (4, 16, vec![0, 4, 8, 12]),
    ];
    assert_eq!(interface("pyramid_first.comp"), (first.clone(), 108));
    let second = [first, vec![(5, 4, vec![0])]].concat();
    assert_eq!(interface("pyramid_second.comp"), (second, 108));
}

#[test]
fn the_compute_tester_reads_boxes_and_depths_and_writes_results() {
    let floats = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("depth_grid.comp"), (vec![floats(0), floats(1)], 12));
    let buffers = vec![(0, 32, vec![0, 16]), floats(1), floats(2), floats(3)];
    assert_eq!(interface("compute_test.comp"), (buffers, 88));
}

#[test]
fn scattering_knows_only_values() {
    let values = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("scatter.comp"), (vec![values(0), values(1), values(2)], 8));
}

#[test]
fn points_of_patches_are_four_words_each() {
    assert_eq!((size_of::<scene::SurfacePoint>(), size_of::<scene::EvaluatedPoint>()), (16, 16));
    let words = |binding| (binding, 4, vec![0]);
    let points = |binding| (binding, 16, vec![0]);
    let buffers = vec![points(0), words(1), words(2), points(3)];
    assert_eq!(interface("patch_points.comp"), (buffers, 4));
    assert_eq!(interface("patch_capture.vert"), (vec![words(0), words(1)], 0));
    assert_eq!(size_of::<scene::PatchSides>(), 16);
    assert_eq!(interface("patch_capture.tesc"), (vec![points(2)], 0));
    assert_eq!(interface("patch_capture.tese"), (vec![], 0));
}

#[test]
fn surfaces_have_materials_transforms_lights_and_lists() {
    // Rows and tail; then four vectors of a material.
    let objects = vec![(0, 64, vec![0, 48]), (1, 64, vec![0, 16, 32, 48])];
    assert_eq!(interface("surface.vert"), (objects.clone(), 128));
    assert_eq!(interface("surface_depth.vert"), (objects, 128));
    let transforms = (2, 32, vec![0, 16]);
    let lights = (3, 64, vec![0, 16, 32, 48, 60]);
    assert_eq!(interface("surface.frag"), (vec![transforms.clone(), lights, (4, 4, vec![0])], 128));
    let shadows = [(5, 16, vec![0, 4, 8, 12]), (6, 160, vec![0, 64, 80, 96, 112, 128, 144])];
    let shadowed = interface("surface_shadowed.frag").0;
    assert_eq!(shadowed[..3], interface("surface.frag").0);
    assert_eq!(shadowed[3..], shadows);
    let by_volumes = interface("surface_volumes.frag").0;
    assert_eq!(by_volumes[..3], interface("surface.frag").0);
    assert_eq!(by_volumes[3..], [(5, 4, vec![0]), (6, 4, vec![0])]);
    assert_eq!(interface("surface_depth.frag").0, vec![transforms]);
    for (sorted, drawn) in [
        ("surface_sorted.frag", "surface.frag"),
        ("surface_shadowed_sorted.frag", "surface_shadowed.frag"),
    ] {
        let mut buffers = interface(drawn).0;
        let lists = buffers.last().unwrap().0 + 1;
        buffers.push((lists, 4, vec![0]));
        assert_eq!(interface(sorted), (buffers, 128), "one buffer more holds the fragments");
    }
    assert_eq!(interface("sorted_fragments.frag"), (vec![(0, 4, vec![0]), (1, 4, vec![0])], 0));
    let source = std::fs::read_to_string(crate::folder().join("lights.glsl")).unwrap();
    let list_values = scene::limits::MAX_LIGHTS_PER_OBJECT / 2;
    assert!(source.contains(&format!("LIST_VALUES = {list_values};")));
}

#[test]
fn textures_with_an_image_each_change_no_other_input() {
    let passes = [
        "surface",
        "surface_shadowed",
        "surface_volumes",
        "surface_depth",
        "surface_sorted",
        "surface_shadowed_sorted",
        "flare_transmittance",
    ];
    for pass in passes {
        let [on_pages, indexed] =
            ["", "_bindless"].map(|end| interface(&format!("{pass}{end}.frag")));
        assert_eq!(on_pages, indexed, "{pass}");
    }
    let source = std::fs::read_to_string(crate::folder().join("texels.glsl")).unwrap();
    let bits = scene::limits::MAX_OWN_IMAGES;
    let packed = bits & 15 | (bits & !15) << 1;
    assert!(source.contains(&format!("NO_TEXTURE = 0x{packed:04X}u;")), "{packed:X}");
}

#[test]
fn volumes_are_extruded_alike_by_both_ways() {
    let instances = (0, 64, vec![0, 48]);
    assert_eq!(interface("volume.vert"), (vec![instances.clone()], 128));
    assert_eq!(interface("volume.geom"), (vec![], 128));
    let values = |binding| (binding, 4, vec![0]);
    let jobs = (3, 16, vec![0, 4, 8, 12]);
    let buffers = vec![instances, values(1), values(2), jobs, (4, 16, vec![0]), values(5)];
    assert_eq!(interface("volume_extrude.comp"), (buffers, 128));
    assert_eq!(interface("volume_extruded.vert"), (vec![], 0));
    assert_eq!(interface("volume_mask.frag"), (vec![values(0)], 12));
}

#[test]
fn midpoints_know_their_reach_and_layer() {
    assert_eq!(interface("midpoint.frag"), (vec![], 12));
}

#[test]
fn the_sky_is_a_colour_or_what_is_around() {
    assert_eq!(interface("sky.vert"), (vec![], 0));
    assert_eq!(interface("sky.frag"), (vec![], 16));
    let vectors: Vec<usize> = (0..7).map(|vector| vector * 16).collect();
    let row = (0, size_of::<render::passes::SkyRow>(), vectors);
    assert_eq!(interface("sky_around.frag"), (vec![row.clone()], 56));
    assert_eq!(interface("sky_panorama.frag"), (vec![row], 56));
}

#[test]
fn push_constants_fit_every_device() {
    // Vulkan promises 128 bytes (specification, "Required Limits").
    let folder = crate::folder();
    for name in crate::sources::stages(&folder).unwrap() {
        assert!(interface(&name).1 <= 128, "{name}");
    }
}

#[test]
fn layers_are_counted_per_pixel_and_shown_in_the_colours_of_the_legend() {
    let values = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("layers.frag"), (vec![values(1)], 100));
    assert_eq!(interface("depth_complexity.frag"), (vec![values(0)], 12));
    let source = std::fs::read_to_string(crate::folder().join("depth_complexity.frag")).unwrap();
    let [red, green, blue] = render::palette::layer_colour(1);
    assert!(source.contains(&format!("LAYER = uvec3({red}, {green}, {blue});")));
}

#[test]
fn the_skinning_pass_reads_and_writes_values() {
    let values = |binding| (binding, 4, vec![0]);
    assert_eq!(interface("skinning.comp"), ([0, 1, 2, 3, 4, 5].map(values).to_vec(), 44));
    // The values of a vertex: five, and ten for a surface vertex.
    assert_eq!(size_of::<scene::Vertex>(), 5 * 4);
    assert_eq!(size_of::<scene::SurfaceVertex>(), 10 * 4);
    assert_eq!(offset_of!(scene::Vertex, normal), 3 * 4);
    assert_eq!(offset_of!(scene::SurfaceVertex, tangent), 2 * 4);
}

#[test]
fn the_required_storage_buffers_are_the_most_that_a_stage_binds() {
    // The layout of a pipeline includes all buffers up to the last one of each stage.
    let bound = |name: &str| interface(name).0.last().map_or(0, |(binding, ..)| binding + 1);
    let names = || shaders::PASSES.into_iter().chain(OF_GPU).map(|shader| shader.name);
    let is_cut =
        |name: &&str| ["_section", "cap_", "_sorted"].iter().any(|part| name.contains(part));
    let most = names().filter(|name| !is_cut(name)).map(bound).max().unwrap();
    let asked = include_str!("../../../engine/gpu/src/core/capabilities.rs");
    assert!(asked.contains(&format!("STAGE_STORAGE_BUFFERS: u32 = {most};")), "{most} are bound");
    let told = RequiredFeature::StorageBuffers.name();
    assert!(told.ends_with(&format!("of at least {most}")), "{told}, but {most} are bound");
    let most_cut = names().filter(is_cut).map(bound).max().unwrap();
    let asked_cut = format!("SECTION_STORAGE_BUFFERS: u32 = {most_cut};");
    assert!(asked.contains(&asked_cut), "{most_cut} are bound");
    let told = OptionalFeature::SectionBuffers.name();
    assert!(told.ends_with(&format!("of at least {most_cut}")), "{told}, but {most_cut} are bound");
}

//! The walks detect the faults of other engines: with a shader that has the same fault, images
//! differ.

use std::fs;
use std::path::Path;

use cull::Strategy;
use gpu::Device;
use render::{Renderer, RendererOptions, ShaderSet};
use tests::regressions::Reported;
use tests::walk::frame_loop;
use tests::{Driver, run};

use super::{first_wrong, options, takes};

/// A fault of another engine in our shaders.
struct Fault {
    kind: Reported,
    /// The strategy that the shader serves.
    strategy: Strategy,
    /// The file in the folder of shaders.
    file: &'static str,
    /// Parts of the file, and their faulty replacements.
    changes: &'static [[&'static str; 2]],
}

/// Faults in groups. No shader of a group serves two of its strategies, so one set of shaders has
/// all faults of the group: it takes long to compile a set.
const FAULTS: [&[Fault]; 3] = [
    &[
        // The occlusion buffer has an eighth of the image's size.
        Fault {
            kind: Reported::Gap,
            strategy: Strategy::ANTUMBRA_FLAGS,
            file: "proxy.frag",
            changes: &[[
                "atomicStore(flags[test],",
                "if (ivec2(gl_FragCoord.xy) % 8 == ivec2(4)) atomicStore(flags[test],",
            ]],
        },
        // A coarser level keeps the nearest depth and closes gaps.
        Fault {
            kind: Reported::Gap,
            strategy: Strategy::ANTUMBRA_COMPUTE,
            file: "depth_grid.comp",
            changes: &[
                ["float farthest = 1.0;", "float farthest = 0.0;"],
                ["farthest = min(farthest,", "farthest = max(farthest,"],
            ],
        },
        // A box that contains the eye is compared like any other box.
        Fault {
            kind: Reported::Inside,
            strategy: methods::HZB,
            file: "pyramid_second.comp",
            changes: &[["(covers.too_near || !is_hidden(covers))", "!is_hidden(covers)"]],
        },
    ],
    &[
        // A box whose middle is off screen is not tested.
        Fault {
            kind: Reported::Edge,
            strategy: Strategy::ANTUMBRA_QUERIES,
            file: "box.glsl",
            changes: &[[
                "return shows_low || shows_high ?",
                "vec4 middle = view_proj * vec4(0.5 * (low + high), 1.0);
                 bool is_on_screen = all(lessThan(abs(middle.xy), middle.ww));
                 return is_on_screen && (shows_low || shows_high) ?",
            ]],
        },
        // Levels of a pyramid of an odd size leave out the last row and column.
        Fault {
            kind: Reported::Sky,
            strategy: methods::HZB,
            file: "pyramid_levels.glsl",
            changes: &[["return (size + 1) / 2;", "return max(size / 2, uvec2(1));"]],
        },
    ],
    &[
        // Boxes are compared at a depth behind the objects that they touch.
        Fault {
            kind: Reported::Tiles,
            strategy: Strategy::ANTUMBRA_QUERIES,
            file: "proxy.vert",
            changes: &[["gl_VertexIndex);", "gl_VertexIndex); gl_Position.z *= 0.998;"]],
        },
        // A buffer of cells ends before the edge of an image whose size is not a multiple of the
        // cells.
        Fault {
            kind: Reported::Opening,
            strategy: Strategy::ANTUMBRA_COMPUTE,
            file: "compute_test.comp",
            changes: &[[
                "min(ivec2(floor(last)), ivec2(size) - 1)",
                "min(ivec2(floor(last)), ivec2(size / CELL * CELL) - 1)",
            ]],
        },
    ],
];

/// Returns the project's shaders, including the faults.
fn shaders_with(faults: &[Fault]) -> ShaderSet {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("other_engines");
    fs::create_dir_all(&folder).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
    for fault in faults {
        let path = folder.join(fault.file);
        let mut source = fs::read_to_string(&path).unwrap();
        for [right, wrong] in fault.changes {
            assert!(source.contains(right), "{} does not say `{right}` any more", fault.file);
            source = source.replace(right, wrong);
        }
        fs::write(&path, source).unwrap();
    }
    ShaderSet::compiled_from(&folder).unwrap()
}

/// Returns true if a frame of the strategy differs from a frame in which everything is drawn.
fn is_caught(device: &Device, fault: &Fault, shaders: &ShaderSet) -> bool {
    let provocation = fault.kind.build();
    let options = options(None);
    let mut whole = Renderer::new(device, &provocation.drawn_whole(), &options).unwrap();
    let faulty = RendererOptions { shaders: Some(shaders.clone()), ..options };
    let mut renderer = Renderer::new(device, &provocation.scene, &faulty).unwrap();
    let mut views = [whole.new_view().unwrap(), renderer.new_view().unwrap()];
    takes(&provocation).into_iter().any(|(size, cameras)| {
        whole.resize(size).unwrap();
        renderer.resize(size).unwrap();
        let [all, view] = &mut views;
        let expected = frame_loop(&mut whole, all, Strategy::FRUSTUM, cameras);
        let found = frame_loop(&mut renderer, view, fault.strategy, cameras);
        first_wrong(&expected, &found).is_some()
    })
}

#[test]
#[ignore = "long walk"]
fn the_faults_of_other_engines_are_caught() {
    run(Driver::Lavapipe, |device| {
        for faults in FAULTS {
            let shaders = shaders_with(faults);
            for fault in faults {
                let Fault { kind, strategy, file, .. } = fault;
                assert!(is_caught(device, fault, &shaders), "{kind:?}, {strategy}, {file}");
            }
        }
    });
}

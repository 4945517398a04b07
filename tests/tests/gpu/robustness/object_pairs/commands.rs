//! Calls that record commands: the recording fails, and therefore the submit.

use gpu::{Counting, QueryIndex, SampledArrays, TextureRows};

use super::Row;
use super::side::{SOURCE, Side, recorded};

const BUFFER: &str = "a buffer (`BufferSlice`)";
const PIPELINE: &str = "a pipeline";
const TARGET: &str = "a target (`Target`)";
const TEXTURE: &str = "a texture (`DynamicTexture`)";
const SAMPLED: &str = "a texture (`SampledTexture`)";
const QUERIES: &str = "a query ring (`QueryRing`)";
const PAGES: &str = "blocking queries (`BlockingQueryPool`)";

fn row(
    call: &'static str,
    given: &'static str,
    mistake: fn(&mut Side, &mut Side) -> String,
) -> Row {
    Row { call, given, owner: "Device", mistake }
}

pub fn rows() -> Vec<Row> {
    [binds(), buffers(), images(), rings(), predicates()].into_iter().flatten().collect()
}

const ROW: TextureRows = TextureRows { layer: 0, level: 0, first: 0, count: 1 };

fn binds() -> Vec<Row> {
    vec![
        row("Commands::bind", PIPELINE, |ours, theirs| {
            recorded(&ours.device(), |commands| commands.bind(&theirs.graphics, &[]))
        }),
        row("Commands::bind", BUFFER, |ours, theirs| {
            let slices = [theirs.slice()];
            recorded(&ours.device(), |commands| commands.bind(&ours.graphics, &slices))
        }),
        row("Commands::bind_sampled", SAMPLED, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                commands.bind_sampled(
                    &ours.graphics,
                    &[],
                    &[theirs.texture.sampled()],
                    SampledArrays::NONE,
                );
            })
        }),
        row("Commands::bind_sampled", "a texture array (`TextureArray`)", |ours, theirs| {
            recorded(&ours.device(), |commands| {
                commands.bind_sampled(
                    &ours.graphics,
                    &[],
                    &[],
                    SampledArrays::Few(&[&theirs.array]),
                );
            })
        }),
        row("Commands::write_texture", "a texture array (`TextureArray`)", |ours, theirs| {
            let slice = ours.slice();
            recorded(&ours.device(), |commands| commands.write_texture(&theirs.array, ROW, slice))
        }),
        row("Commands::write_texture", BUFFER, |ours, theirs| {
            let slice = theirs.slice();
            recorded(&ours.device(), |commands| commands.write_texture(&ours.array, ROW, slice))
        }),
        row("Commands::open_texture", "a texture array (`TextureArray`)", |ours, theirs| {
            recorded(&ours.device(), |commands| commands.open_texture(&theirs.array))
        }),
        row("Commands::make_texture_levels", "a texture array (`TextureArray`)", |ours, theirs| {
            recorded(&ours.device(), |commands| commands.make_texture_levels(&theirs.array, 0))
        }),
        row("Commands::bind_compute", PIPELINE, |ours, theirs| {
            let slices = [ours.slice(); 3];
            recorded(&ours.device(), |commands| commands.bind_compute(&theirs.compute, &slices))
        }),
        row("Commands::bind_compute", BUFFER, |ours, theirs| {
            let slices = [ours.slice(), ours.slice(), theirs.slice()];
            recorded(&ours.device(), |commands| commands.bind_compute(&ours.compute, &slices))
        }),
        row("Commands::push_constants", PIPELINE, |ours, theirs| {
            recorded(&ours.device(), |commands| commands.push_constants(&theirs.graphics, &[0; 4]))
        }),
        row("Commands::push_compute_constants", PIPELINE, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                commands.push_compute_constants(&theirs.compute, &[0; 3]);
            })
        }),
        row("Commands::capture", PIPELINE, |ours, theirs| {
            let slice = ours.slice();
            recorded(&ours.device(), |commands| {
                commands.capture(&theirs.capture, &[slice; 3], 1, slice);
            })
        }),
        row("Commands::capture", BUFFER, |ours, theirs| {
            let slice = ours.slice();
            let foreign = theirs.slice();
            recorded(&ours.device(), |commands| {
                commands.capture(&ours.capture, &[slice; 3], 1, foreign);
            });
            recorded(&ours.device(), |commands| {
                commands.capture(&ours.capture, &[foreign; 3], 1, slice);
            })
        }),
        row("Commands::rendering", "a target (`RenderTarget`)", |ours, theirs| {
            let target = theirs.target.render_target(Some([0.0; 4]));
            recorded(&ours.device(), |commands| {
                commands.rendering(target, |commands| commands.draw(3, 0));
            })
        }),
    ]
}

fn buffers() -> Vec<Row> {
    vec![
        row("Commands::bind_geometry", BUFFER, |ours, theirs| {
            let device = ours.device();
            let ours = ours.slice();
            let theirs = theirs.slice();
            recorded(&device, |commands| commands.bind_geometry(theirs, None));
            recorded(&device, |commands| commands.bind_geometry(ours, Some(theirs)))
        }),
        row("Commands::bind_geometry_beside", BUFFER, |ours, theirs| {
            let device = ours.device();
            let ours = ours.slice();
            let theirs = theirs.slice();
            recorded(&device, |commands| commands.bind_geometry_beside([ours, theirs], ours));
            recorded(&device, |commands| commands.bind_geometry_beside([ours; 2], theirs))
        }),
        row("Commands::fill", BUFFER, |ours, theirs| {
            let slice = theirs.slice();
            recorded(&ours.device(), |commands| commands.fill(slice, 0))
        }),
        row("Commands::copy_buffer", BUFFER, |ours, theirs| {
            let device = ours.device();
            let ours = ours.slice();
            let theirs = theirs.slice();
            recorded(&device, |commands| commands.copy_buffer(theirs, ours));
            recorded(&device, |commands| commands.copy_buffer(ours, theirs))
        }),
        row("Commands::draw_indirect", BUFFER, |ours, theirs| {
            let slice = theirs.slice();
            recorded(&ours.device(), |commands| commands.draw_indirect(slice))
        }),
        row("Commands::draw_indirect_count", BUFFER, |ours, theirs| {
            let device = ours.device();
            let ours = ours.slice();
            let theirs = theirs.slice();
            recorded(&device, |commands| commands.draw_indirect_count(theirs, ours.part(0, 4)));
            recorded(&device, |commands| commands.draw_indirect_count(ours, theirs.part(0, 4)))
        }),
    ]
}

fn images() -> Vec<Row> {
    vec![
        row("Target::prepare", TARGET, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.target.prepare(commands))
        }),
        row("Target::copy_depth_to", TARGET, |ours, theirs| {
            let slice = ours.slice();
            recorded(&ours.device(), |commands| {
                theirs.target.copy_depth_to(commands, [0, 0], [8, 8], slice);
            })
        }),
        row("Target::copy_depth_to", BUFFER, |ours, theirs| {
            let slice = theirs.slice();
            recorded(&ours.device(), |commands| {
                ours.target.prepare(commands);
                ours.target.copy_depth_to(commands, [0, 0], [8, 8], slice);
            })
        }),
        row("Target::begin_overlay", TARGET, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                theirs.target.begin_overlay(commands).unwrap_err();
            })
        }),
        row("Target::copy_to", TARGET, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.target.copy_to(commands, &ours.image))
        }),
        row("Target::copy_to", "an image (`Readback`)", |ours, theirs| {
            recorded(&ours.device(), |commands| {
                ours.target.prepare(commands);
                ours.target.copy_to(commands, &theirs.image);
            })
        }),
        row("DynamicTexture::write", TEXTURE, |ours, theirs| {
            let pixels = ours.slice().part(0, 64);
            recorded(&ours.device(), |commands| {
                theirs.texture.write(commands, [0, 0], [4, 4], pixels);
            })
        }),
        row("DynamicTexture::write", BUFFER, |ours, theirs| {
            let pixels = theirs.slice().part(0, 64);
            recorded(&ours.device(), |commands| {
                ours.texture.write(commands, [0, 0], [4, 4], pixels);
            })
        }),
        row("DynamicTexture::prepare", TEXTURE, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.texture.prepare(commands))
        }),
    ]
}

fn rings() -> Vec<Row> {
    vec![
        row("QueryRing::scope", QUERIES, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                theirs.queries.scope(commands, QueryIndex(0), |_| {});
            })
        }),
        row("QueryRing::resolve", QUERIES, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.queries.resolve(commands, 0..1))
        }),
        row("QueryRing::read_back", QUERIES, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.queries.read_back(commands))
        }),
        row("BlockingQueryPool::scope", PAGES, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                theirs.pages.scope(commands, QueryIndex(0), Counting::Some, |_| {});
            })
        }),
        row("BlockingQueryPool::read_back", PAGES, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.pages.read_back(commands, 0..1))
        }),
        row("FlagRing::read_back", "a flag ring (`FlagRing`)", |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.flags.read_back(commands))
        }),
        row("LeafDrawRing::read_back", "leaf draws (`LeafDrawRing`)", |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.leaf_draws.read_back(commands))
        }),
    ]
}

fn predicates() -> Vec<Row> {
    const PREDICATES: &str = "predicates (`Predicates`)";
    vec![
        row("Predicates::resolve", PREDICATES, |ours, theirs| {
            recorded(&ours.device(), |commands| {
                theirs.predicates.resolve(commands, &[(SOURCE, 0..1)], 0);
            })
        }),
        row("Predicates::draw", PREDICATES, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.predicates.draw(commands, SOURCE, 0))
        }),
        row("Predicates::draw_enabled", PREDICATES, |ours, theirs| {
            let draws = ours.slice();
            recorded(&ours.device(), |commands| {
                theirs.predicates.draw_enabled(commands, SOURCE, 0, draws);
            })
        }),
        row("Predicates::draw_boxes", PREDICATES, |ours, theirs| {
            recorded(&ours.device(), |commands| theirs.predicates.draw_boxes(commands, SOURCE, 0))
        }),
        row("Predicates::draw_always", PREDICATES, |ours, theirs| {
            let draws = ours.slice().part(0, 20);
            recorded(&ours.device(), |commands| theirs.predicates.draw_always(commands, draws))
        }),
        row("Predicates::draw_after_counted", PREDICATES, |ours, theirs| {
            let draws = ours.slice().part(0, 20);
            recorded(&ours.device(), |commands| {
                theirs.predicates.draw_after_counted(commands, draws);
            })
        }),
        row("Predicates::draw_enabled", BUFFER, |ours, theirs| {
            let draws = theirs.slice();
            let mut ring = gpu::FrameRing::new(&ours.device(), 1).unwrap();
            let mut frame = ring.begin().unwrap();
            ours.begin_predicates(&mut frame);
            ours.target.prepare(frame.commands());
            let target = ours.target.render_target(Some([0.0; 4]));
            frame.commands().rendering(target, |commands| {
                ours.predicates.draw_enabled(commands, SOURCE, 0, draws);
            });
            frame.submit(None).expect_err("an error").to_string()
        }),
    ]
}

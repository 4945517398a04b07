//! Calls that record commands: the recording fails, and therefore the submit.

use gpu::{Commands, Counting, QueryIndex, SampledArrays, TextureRows};

use super::side::{SOURCE, Side};
use super::{Mistake, Row};

const BUFFER: &str = "a buffer (`BufferSlice`)";
const PIPELINE: &str = "a pipeline";
const TARGET: &str = "a target (`Target`)";
const ARRAY: &str = "a texture array (`TextureArray`)";
const TEXTURE: &str = "a texture (`DynamicTexture`)";
const SAMPLED: &str = "a texture (`SampledTexture`)";
const QUERIES: &str = "a query ring (`QueryRing`)";
const PAGES: &str = "blocking queries (`BlockingQueryPool`)";

type Recording = fn(&Commands, &mut Side, &mut Side);

fn row(call: &'static str, given: &'static str, recording: Recording) -> Row {
    Row { call, given, owner: "Device", mistake: Mistake::Recorded(recording) }
}

pub fn rows() -> Vec<Row> {
    [binds(), buffers(), images(), rings(), predicates()].into_iter().flatten().collect()
}

const ROW: TextureRows = TextureRows { layer: 0, level: 0, first: 0, count: 1 };

fn binds() -> Vec<Row> {
    vec![
        row("Commands::bind", PIPELINE, |commands, _, theirs| commands.bind(&theirs.graphics, &[])),
        row("Commands::bind", BUFFER, |commands, ours, theirs| {
            commands.bind(&ours.graphics, &[theirs.slice()])
        }),
        row("Commands::bind_sampled", SAMPLED, |commands, ours, theirs| {
            commands.bind_sampled(
                &ours.graphics,
                &[],
                &[theirs.texture.sampled()],
                SampledArrays::NONE,
            )
        }),
        row("Commands::bind_sampled", ARRAY, |commands, ours, theirs| {
            commands.bind_sampled(&ours.graphics, &[], &[], SampledArrays::Few(&[&theirs.array]))
        }),
        row("Commands::write_texture", ARRAY, |commands, ours, theirs| {
            commands.write_texture(&theirs.array, ROW, ours.slice())
        }),
        row("Commands::write_texture", BUFFER, |commands, ours, theirs| {
            commands.write_texture(&ours.array, ROW, theirs.slice())
        }),
        row("Commands::open_texture", ARRAY, |commands, _, theirs| {
            commands.open_texture(&theirs.array)
        }),
        row("Commands::make_texture_levels", ARRAY, |commands, _, theirs| {
            commands.make_texture_levels(&theirs.array, 0)
        }),
        row("Commands::bind_compute", PIPELINE, |commands, ours, theirs| {
            commands.bind_compute(&theirs.compute, &[ours.slice(); 3])
        }),
        row("Commands::bind_compute", BUFFER, |commands, ours, theirs| {
            commands.bind_compute(&ours.compute, &[ours.slice(), ours.slice(), theirs.slice()])
        }),
        row("Commands::push_constants", PIPELINE, |commands, _, theirs| {
            commands.push_constants(&theirs.graphics, &[0; 4])
        }),
        row("Commands::push_compute_constants", PIPELINE, |commands, _, theirs| {
            commands.push_compute_constants(&theirs.compute, &[0; 3]);
        }),
        row("Commands::capture", PIPELINE, |commands, ours, theirs| {
            commands.capture(&theirs.capture, &[ours.slice(); 3], 1, ours.slice());
        }),
        row("Commands::capture", BUFFER, |commands, ours, theirs| {
            commands.capture(&ours.capture, &[ours.slice(); 3], 1, theirs.slice());
        }),
        row("Commands::capture", BUFFER, |commands, ours, theirs| {
            commands.capture(&ours.capture, &[theirs.slice(); 3], 1, ours.slice());
        }),
        row("Commands::rendering", "a target (`RenderTarget`)", |commands, _, theirs| {
            commands.rendering(theirs.target.render_target(Some([0.0; 4])), |commands| {
                commands.draw(3, 0)
            })
        }),
    ]
}

fn buffers() -> Vec<Row> {
    vec![
        row("Commands::bind_geometry", BUFFER, |commands, _, theirs| {
            commands.bind_geometry(theirs.slice(), None)
        }),
        row("Commands::bind_geometry", BUFFER, |commands, ours, theirs| {
            commands.bind_geometry(ours.slice(), Some(theirs.slice()))
        }),
        row("Commands::bind_geometry_beside", BUFFER, |commands, ours, theirs| {
            commands.bind_geometry_beside([ours.slice(), theirs.slice()], ours.slice())
        }),
        row("Commands::bind_geometry_beside", BUFFER, |commands, ours, theirs| {
            commands.bind_geometry_beside([ours.slice(); 2], theirs.slice())
        }),
        row("Commands::fill", BUFFER, |commands, _, theirs| commands.fill(theirs.slice(), 0)),
        row("Commands::copy_buffer", BUFFER, |commands, ours, theirs| {
            commands.copy_buffer(theirs.slice(), ours.slice())
        }),
        row("Commands::copy_buffer", BUFFER, |commands, ours, theirs| {
            commands.copy_buffer(ours.slice(), theirs.slice())
        }),
        row("Commands::draw_indirect", BUFFER, |commands, _, theirs| {
            commands.draw_indirect(theirs.slice())
        }),
        row("Commands::draw_indirect_count", BUFFER, |commands, ours, theirs| {
            commands.draw_indirect_count(theirs.slice(), ours.slice().part(0, 4))
        }),
        row("Commands::draw_indirect_count", BUFFER, |commands, ours, theirs| {
            commands.draw_indirect_count(ours.slice(), theirs.slice().part(0, 4))
        }),
    ]
}

fn images() -> Vec<Row> {
    vec![
        row("Target::prepare", TARGET, |commands, _, theirs| theirs.target.prepare(commands)),
        row("Target::copy_depth_to", TARGET, |commands, ours, theirs| {
            theirs.target.copy_depth_to(commands, [0, 0], [8, 8], ours.slice())
        }),
        row("Target::copy_depth_to", BUFFER, |commands, ours, theirs| {
            ours.target.prepare(commands);
            ours.target.copy_depth_to(commands, [0, 0], [8, 8], theirs.slice());
        }),
        row("Target::begin_overlay", TARGET, |commands, _, theirs| {
            theirs.target.begin_overlay(commands).unwrap_err();
        }),
        row("Target::copy_to", TARGET, |commands, ours, theirs| {
            theirs.target.copy_to(commands, &ours.image)
        }),
        row("Target::copy_to", "an image (`Readback`)", |commands, ours, theirs| {
            ours.target.prepare(commands);
            ours.target.copy_to(commands, &theirs.image);
        }),
        row("DynamicTexture::write", TEXTURE, |commands, ours, theirs| {
            theirs.texture.write(commands, [0, 0], [4, 4], ours.slice().part(0, 64))
        }),
        row("DynamicTexture::write", BUFFER, |commands, ours, theirs| {
            ours.texture.write(commands, [0, 0], [4, 4], theirs.slice().part(0, 64))
        }),
        row("DynamicTexture::prepare", TEXTURE, |commands, _, theirs| {
            theirs.texture.prepare(commands)
        }),
    ]
}

fn rings() -> Vec<Row> {
    vec![
        row("QueryRing::scope", QUERIES, |commands, _, theirs| {
            theirs.queries.scope(commands, QueryIndex(0), |_| {})
        }),
        row("QueryRing::resolve", QUERIES, |commands, _, theirs| {
            theirs.queries.resolve(commands, 0..1)
        }),
        row("QueryRing::read_back", QUERIES, |commands, _, theirs| {
            theirs.queries.read_back(commands)
        }),
        row("BlockingQueryPool::scope", PAGES, |commands, _, theirs| {
            theirs.pages.scope(commands, QueryIndex(0), Counting::Some, |_| {})
        }),
        row("BlockingQueryPool::read_back", PAGES, |commands, _, theirs| {
            theirs.pages.read_back(commands, 0..1)
        }),
        row("FlagRing::read_back", "a flag ring (`FlagRing`)", |commands, _, theirs| {
            theirs.flags.read_back(commands)
        }),
        row("LeafDrawRing::read_back", "leaf draws (`LeafDrawRing`)", |commands, _, theirs| {
            theirs.leaf_draws.read_back(commands)
        }),
    ]
}

fn predicates() -> Vec<Row> {
    const PREDICATES: &str = "predicates (`Predicates`)";
    vec![
        row("Predicates::resolve", PREDICATES, |commands, _, theirs| {
            theirs.predicates.resolve(commands, &[(SOURCE, 0..1)], 0)
        }),
        row("Predicates::draw", PREDICATES, |commands, _, theirs| {
            theirs.predicates.draw(commands, SOURCE, 0)
        }),
        row("Predicates::draw_enabled", PREDICATES, |commands, ours, theirs| {
            theirs.predicates.draw_enabled(commands, SOURCE, 0, ours.slice())
        }),
        row("Predicates::draw_boxes", PREDICATES, |commands, _, theirs| {
            theirs.predicates.draw_boxes(commands, SOURCE, 0)
        }),
        row("Predicates::draw_always", PREDICATES, |commands, ours, theirs| {
            theirs.predicates.draw_always(commands, ours.slice().part(0, 20))
        }),
        row("Predicates::draw_after_counted", PREDICATES, |commands, ours, theirs| {
            theirs.predicates.draw_after_counted(commands, ours.slice().part(0, 20))
        }),
        Row {
            call: "Predicates::draw_enabled",
            given: BUFFER,
            owner: "Device",
            mistake: Mistake::Returned(|ours, theirs| {
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
        },
    ]
}

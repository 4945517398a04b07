//! Draws a triangle over the left half of an image without a window, under an occlusion query, and
//! reads the image and the result back.

use std::error::Error;

use antumbra_gpu::{
    Blend, Counting, FrameRing, GraphicsPipeline, GraphicsPipelineInfo, QueryIndex, QueryRing,
    Readback, Spirv, StorageLayout, Target, open,
};

const SIZE: [u32; 2] = [64, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let device = open()?;
    println!("{}", device.adapter().name);
    let shader = |name: &str| {
        let found = shaders::find(name).ok_or("no such shader")?;
        Ok::<_, Box<dyn Error>>(Spirv::from_bytes(name, found.spirv)?)
    };
    // A triangle that covers everything, in the colour of its constants.
    let vertex = shader("sky.vert")?;
    let fragment = shader("sky.frag")?;
    let pipeline = GraphicsPipelineInfo {
        fragment: Some(&fragment),
        storage: StorageLayout { push_bytes: 16, ..Default::default() },
        blend: Blend::Opaque,
        ..GraphicsPipelineInfo::of("triangle", &vertex)
    };
    let pipeline = GraphicsPipeline::new(&device, &pipeline)?;
    let mut target = Target::new(&device, SIZE, "example")?;
    let image = Readback::new(&device, SIZE)?;
    let mut frames = FrameRing::new(&device, 2)?;
    let mut queries = QueryRing::new(&device, 2, "example")?;
    queries.set_counting(Counting::Samples);

    let mut frame = frames.begin()?;
    queries.begin(&mut frame, &["left half"])?;
    let commands = frame.commands();
    target.prepare(commands);
    commands.rendering(target.render_target(Some([0.0, 0.0, 0.0, 1.0])), |commands| {
        commands.bind(&pipeline, &[]);
        commands.push_constants(&pipeline, &[1.0_f32, 0.0, 0.0, 1.0]);
        commands.clip([0, 0], [SIZE[0] / 2, SIZE[1]]);
        queries.scope(commands, QueryIndex(0), |commands| commands.draw(3, 0));
    });
    queries.resolve(commands, 0..1);
    queries.read_back(commands);
    target.copy_to(commands, &image);
    queries.submitted(frame.submit(None)?);

    // A frame loop would read them once they are available; this example waits.
    device.wait_idle()?;
    queries.collect(device.completed()?, |tag, samples| println!("{tag}: {samples} samples"));
    let red = image.rgba8()?.chunks_exact(4).filter(|pixel| pixel[0] > 0).count();
    println!("{red} of {} pixels are red", SIZE[0] * SIZE[1]);
    Ok(())
}

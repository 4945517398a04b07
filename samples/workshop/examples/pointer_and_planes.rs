//! Measures what hovering and dragging a section plane cost. An assembly that a plane cuts is
//! walked through, and each frame is drawn four times: with the pointer and the plane at rest, with
//! each of them moving, and with both.
//!
//! ```sh
//! cargo run --release -p workshop --example pointer_and_planes -- 10000 96 640x360
//! ```

use std::error::Error;
use std::time::Instant;

use antumbra::cull::{SectionMode, SectionPlane, SectionPlanes, Strategy};
use antumbra::glam::DVec3;
use antumbra::gpu::{Device, DeviceOptions};
use antumbra::{FrameRequest, RenderView, Renderer, RendererOptions};
use bench::choices::{DeviceChoice, ValidationChoice};
use bench::options::FrameSize;
use bench::run::{open_instance, pick_adapter};
use bench::statistics::{TimeSummary, paired_ratio};
use scenes::{CameraPath, PathKind, assembly};

/// Frames before the first that is timed.
const WARM_UP_FRAMES: u32 = 12;

/// The height of the plane at rest, above what it keeps, in metres.
const HEIGHT_M: f64 = 2.5;

/// A way to use a frame.
struct Variant {
    name: &'static str,
    hovers: bool,
    drags: bool,
    view: RenderView,
    frame_ms: Vec<Option<f64>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [parts, frames, size] = given.as_slice() else {
        return Err("usage: pointer_and_planes PARTS FRAMES WxH".into());
    };
    let parts: u32 = parts.parse()?;
    let frames: u32 = frames.parse()?;
    let FrameSize { width, height } = size.parse()?;
    let instance = open_instance(ValidationChoice::Off, None)?;
    let adapter = pick_adapter(&instance, &DeviceChoice::Best)?;
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let made = assembly(parts, 1)?.generated;
    let path = CameraPath::new(PathKind::Street, &made.routes)?;
    let options = RendererOptions { size: [width, height], ..RendererOptions::default() };
    let mut renderer = Renderer::new(&device, &made.scene, &options)?;
    let variant = |name, hovers, drags| {
        let frame_ms = Vec::new();
        Ok::<_, antumbra::render::Error>(Variant {
            name,
            hovers,
            drags,
            view: renderer.new_view()?,
            frame_ms,
        })
    };
    let mut variants = [
        variant("neither", false, false)?,
        variant("pointer", true, false)?,
        variant("plane", false, true)?,
        variant("both", true, true)?,
    ];
    for frame in 0..WARM_UP_FRAMES + frames {
        // None of them is always the first after another's.
        variants.rotate_left(1);
        for variant in &mut variants {
            let pixel = [width / 4 + frame * 3 % (width / 2), height / 2];
            variant.view.point_at(variant.hovers.then_some(pixel))?;
            let lift_m = if variant.drags { 0.3 * (f64::from(frame) * 0.2).sin() } else { 0.0 };
            let plane = SectionPlane::new(DVec3::NEG_Y, HEIGHT_M + lift_m)?;
            let began = Instant::now();
            renderer.set_section(SectionPlanes::new(&[plane], SectionMode::Intersection)?)?;
            let request = FrameRequest::new(Strategy::ANTUMBRA, path.camera(frame));
            renderer.render(&mut variant.view, request)?;
            renderer.wait_idle(&mut variant.view)?;
            let frame_ms = began.elapsed().as_secs_f64() * 1000.0;
            if frame >= WARM_UP_FRAMES {
                variant.frame_ms.push(Some(frame_ms));
            }
        }
    }
    variants.sort_by_key(|variant| (variant.drags, variant.hovers));
    println!("{}, {parts} parts, {frames} frames of {size}", adapter.name);
    println!("moves    ms per frame  times neither");
    for variant in &variants {
        let median = TimeSummary::of(variant.frame_ms.iter().copied().flatten()).median;
        let ratio = paired_ratio(&variant.frame_ms, &variants[0].frame_ms);
        println!(
            "{:<8} {:>12.2} {:>14.2}",
            variant.name,
            median.unwrap_or(f64::NAN),
            ratio.unwrap_or(f64::NAN)
        );
    }
    Ok(())
}

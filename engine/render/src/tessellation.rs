//! Curved surfaces that the GPU computes. They are read back as meshes some frames later without a
//! wait.

use std::iter::repeat_n;

use bytemuck::{Pod, Zeroable};
use gpu::{
    Access, CapturePipeline, CapturePipelineInfo, Commands, ComputePipeline, Device, FlagRing,
    FrameRing, MemoryBarrier, OptionalFeature, ResultSource, StorageLayout, Tick,
};
use occlusion::ShaderSet;
use scene::limits::STORAGE_BYTES_ANYWHERE;
use scene::{
    EvaluatedPoint, Mesh, PatchSides, PatchSurface, SurfaceGrid, TessellationLevels, captured_mesh,
    captured_triangle_count,
};

use crate::error::Error;

/// The number of words in a computed point.
const POINT_WORDS: usize = size_of::<EvaluatedPoint>() / size_of::<u32>();

/// The highest number of points in a request, which fit into a buffer of any device.
const MAX_POINTS: u64 = STORAGE_BYTES_ANYWHERE / size_of::<EvaluatedPoint>() as u64;

const GROUP_THREADS: u32 = 64;

/// The highest number of workgroups. More are not faster, and every device allows 65535.
const GROUPS_MAX: u32 = 4096;

/// The way in which a device computes the points of surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TessellationPath {
    /// Tessellation shaders with transform feedback, which captures their triangles. For devices
    /// with [`OptionalFeature::TessellationCapture`].
    Hardware,
    /// A compute pass, on every device.
    Compute,
}

impl TessellationPath {
    /// Returns the path for a device.
    pub fn of(device: &Device) -> Self {
        if device.capabilities().has(OptionalFeature::TessellationCapture) {
            Self::Hardware
        } else {
            Self::Compute
        }
    }

    /// Returns the name of the path for users.
    pub fn name(self) -> &'static str {
        match self {
            TessellationPath::Hardware => "tessellation shaders",
            TessellationPath::Compute => "compute",
        }
    }
}

/// Mirrors `patch_points.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    point_count: u32,
}

/// The pass of a path.
enum TessellationPass {
    Hardware(CapturePipeline),
    Compute(ComputePipeline),
}

/// The order of the points of a request.
enum AskedPoints {
    /// The points of a grid.
    OfGrid(SurfaceGrid),
    /// The points of triangles, three each.
    OfTriangles,
}

/// A request in flight.
struct Asked {
    points: AskedPoints,
    name: String,
    colour: u32,
    tick: Tick,
}

/// The pass that computes surfaces on the GPU, one at a time, by its own commands besides those of
/// renderers on the same device. Its results are ordinary meshes: pass them to
/// [`Renderer::add_meshes`](crate::Renderer::add_meshes) and remove the meshes that they replace.
pub struct Tessellator {
    device: Device,
    pass: TessellationPass,
    frames: FrameRing,
    results: FlagRing<()>,
    asked: Option<Asked>,
}

impl Tessellator {
    /// Compiles the pass of the device's [path](TessellationPath::of).
    ///
    /// # Errors
    /// No memory, or a failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        Self::by_path(device, shaders, TessellationPath::of(device))
    }

    /// Compiles the pass of a path.
    ///
    /// # Errors
    /// A path that the device lacks; no memory, or a failed call.
    pub fn by_path(
        device: &Device,
        shaders: &ShaderSet,
        path: TessellationPath,
    ) -> Result<Self, Error> {
        let pass = match path {
            TessellationPath::Hardware => {
                let info = CapturePipelineInfo {
                    name: "patch_capture",
                    vertex: shaders.find("patch_capture.vert")?,
                    control: shaders.find("patch_capture.tesc")?,
                    evaluation: shaders.find("patch_capture.tese")?,
                    storage: StorageLayout { buffers: 3, ..StorageLayout::default() },
                };
                TessellationPass::Hardware(CapturePipeline::new(device, &info)?)
            }
            TessellationPath::Compute => {
                let name = "patch_points.comp";
                let storage = StorageLayout::new::<Constants>(4);
                let pipeline = ComputePipeline::new(device, name, shaders.find(name)?, storage)?;
                TessellationPass::Compute(pipeline)
            }
        };
        Ok(Self {
            pass,
            frames: FrameRing::new(device, 1)?,
            results: FlagRing::new(device, 1, ResultSource::Compute, "surface points"),
            device: device.clone(),
            asked: None,
        })
    }

    /// Returns the way in which points are computed.
    pub fn path(&self) -> TessellationPath {
        match self.pass {
            TessellationPass::Hardware(_) => TessellationPath::Hardware,
            TessellationPass::Compute(_) => TessellationPath::Compute,
        }
    }

    /// Returns true while a request is in flight or its mesh has not been taken.
    pub fn is_busy(&self) -> bool {
        self.asked.is_some()
    }

    /// Requests a surface at these levels as a mesh with a name and one colour
    /// ([`Vertex::colour`](scene::Vertex::colour)). Nothing waits. Returns true if the request was
    /// begun. It is not begun while another [is in flight](Tessellator::is_busy): request again in
    /// the next frame, with the newest levels.
    ///
    /// # Errors
    /// [`Error::SceneTooLarge`] for more points than fit into a buffer of any device; no memory, or
    /// a failed call.
    pub fn request(
        &mut self,
        surface: &PatchSurface,
        levels: &TessellationLevels,
        name: &str,
        colour: u32,
    ) -> Result<bool, Error> {
        if self.is_busy() {
            return Ok(false);
        }
        let wanted = match self.pass {
            TessellationPass::Hardware(_) => 3 * captured_triangle_count(surface, levels),
            TessellationPass::Compute(_) => SurfaceGrid::point_count(surface, levels),
        };
        if wanted > MAX_POINTS {
            return Err(Error::SceneTooLarge {
                what: "points of a curved surface",
                wanted,
                limit: MAX_POINTS,
                instead: "use lower levels, or several surfaces",
            });
        }
        let points = match self.pass {
            TessellationPass::Hardware(_) => AskedPoints::OfTriangles,
            TessellationPass::Compute(_) => AskedPoints::OfGrid(SurfaceGrid::new(surface, levels)),
        };
        let tick = self.submit(surface, levels, &points, wanted as u32)?;
        self.asked = Some(Asked { points, name: name.to_owned(), colour, tick });
        Ok(true)
    }

    /// Returns the requested mesh once, as soon as it is available. Returns `None` before that, and
    /// for a request that never ran because the device was lost. Never waits.
    ///
    /// # Errors
    /// A lost device.
    pub fn finished(&mut self) -> Result<Option<Mesh>, Error> {
        let completed = self.device.completed()?;
        let Some(asked) = self.asked.take_if(|asked| asked.tick <= completed) else {
            return Ok(None);
        };
        let mut mesh = None;
        self.results.collect(completed, |_, words| {
            // The words have the alignment of whole numbers, like points.
            let points: &[EvaluatedPoint] = bytemuck::cast_slice(words);
            mesh = Some(match &asked.points {
                AskedPoints::OfGrid(grid) => grid.mesh(points, &asked.name, asked.colour),
                AskedPoints::OfTriangles => captured_mesh(points, &asked.name, asked.colour),
            });
        });
        Ok(mesh)
    }

    /// Submits the pass for `point_count` points, and the copy of its results.
    fn submit(
        &mut self,
        surface: &PatchSurface,
        levels: &TessellationLevels,
        points: &AskedPoints,
        point_count: u32,
    ) -> Result<Tick, Error> {
        let mut frame = self.frames.begin()?;
        let places = surface.control_points().iter().map(|point| point.to_array());
        let patches = surface.patches().iter().map(|patch| patch.control_points);
        let patch_count = surface.patches().len() as u32;
        let of_points = match points {
            AskedPoints::OfGrid(grid) => frame.uploads().push(grid.points())?,
            AskedPoints::OfTriangles => {
                frame.uploads().push_iter(PatchSides::of_surface(surface, levels))?
            }
        };
        let patches = frame.uploads().push_iter(patches)?;
        let places = frame.uploads().push_iter(places)?;
        self.results.begin(&frame, repeat_n((), point_count as usize * POINT_WORDS))?;
        if let Some(results) = self.results.results() {
            frame.commands().pass("compute surface", |commands| {
                match &self.pass {
                    TessellationPass::Hardware(pipeline) => {
                        cleared_before(commands, Access::CaptureWrite);
                        let buffers = [patches, places, of_points];
                        commands.capture(pipeline, &buffers, patch_count, results);
                        let captured = [Access::CaptureWrite];
                        commands.barrier(MemoryBarrier::between(&captured, &[Access::CopyRead]));
                    }
                    TessellationPass::Compute(pipeline) => {
                        cleared_before(commands, Access::ComputeWrite);
                        let buffers = [of_points, patches, places, results];
                        commands.bind_compute(pipeline, &buffers);
                        commands.push_compute_constants(pipeline, &Constants { point_count });
                        let groups = point_count.div_ceil(GROUP_THREADS);
                        commands.dispatch([groups.clamp(1, GROUPS_MAX), 1, 1]);
                    }
                }
                self.results.read_back(commands);
            });
        }
        let tick = frame.submit(None)?;
        self.results.submitted(tick);
        Ok(tick)
    }
}

/// Waits until results have been cleared, before they are written.
fn cleared_before(commands: &Commands, written: Access) {
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[written]));
}

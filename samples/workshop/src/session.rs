//! A session of the viewer: commands change the document, the viewport follows.

use std::path::Path;

use antumbra::glam::DVec3;
use antumbra::gpu::{Device, SampleCount};
use antumbra::{Camera, ObjectId};
use bench::options::FrameSize;
use bench::outputs::write_file;
use bench::png_file::write_png;
use bench::run_error::RunError;
use bench::terminal::shown;

use crate::document::{CommandError, Display, Document};
use crate::explode::least_gap;
use crate::export::glb;
use crate::hinge::Turn;
use crate::hit::{Ray, hit_mesh};
use crate::measure::edge_length;
use crate::orbit::OrbitCamera;
use crate::report::{CommandOutcome, LidTurn, PickedPoint};
use crate::retessellate::{CurvedParts, Tessellated};
use crate::script::{Command, Pixel};
use crate::viewport::{MOST_GHOSTED_OBJECTS, ModelViewport};

/// Millimetres in a metre.
const MM: f64 = 1000.0;

/// A document that is shown.
pub struct WorkshopSession {
    /// The document.
    pub document: Document,
    viewport: ModelViewport,
    curved: CurvedParts,
    camera: OrbitCamera,
    /// The cameras of the model's path.
    path: Vec<Camera>,
    size: FrameSize,
}

impl WorkshopSession {
    /// Shows a document as it is at rest, from a corner.
    ///
    /// # Errors
    /// A scene or size beyond the device's limits, no memory, a failed call.
    pub fn new(
        device: &Device,
        document: Document,
        path: Vec<Camera>,
        size: FrameSize,
        samples: SampleCount,
    ) -> Result<Self, RunError> {
        let pixels = [size.width, size.height];
        let viewport = ModelViewport::new(device, &document, pixels, samples)?;
        let mut session = Self {
            camera: fitted(&document, size),
            document,
            viewport,
            curved: CurvedParts::default(),
            path,
            size,
        };
        session.follow()?;
        Ok(session)
    }

    /// Carries out a command. A command that is refused changes nothing.
    ///
    /// # Errors
    /// A failure of the device, or of writing a file.
    pub fn act(&mut self, command: &Command) -> Result<CommandOutcome, RunError> {
        let outcome = match command {
            Command::Pick(at) => self.pick(*at)?,
            Command::Distance { from, to } => self.distance(*from, *to)?,
            Command::Edge(at) => self.edge(*at)?,
            Command::Edges(mode) => {
                self.viewport.set_edges(*mode)?;
                CommandOutcome::Done
            }
            Command::Section(planes) => {
                self.viewport.set_section(*planes)?;
                CommandOutcome::Done
            }
            Command::View(view) => {
                self.camera = self.camera.turned_to(*view, 1.0);
                CommandOutcome::Done
            }
            Command::Flatness(flatness) => {
                self.camera.flatness = *flatness;
                CommandOutcome::Done
            }
            Command::Fit => {
                let OrbitCamera { target, height_m, .. } = fitted(&self.document, self.size);
                self.camera = OrbitCamera { target, height_m, ..self.camera };
                CommandOutcome::Done
            }
            Command::Tessellate { piece_px } => self.tessellate(*piece_px)?,
            Command::Play { frames } => self.play(*frames)?,
            Command::Image(file) => self.image(file)?,
            Command::Export(file) => self.export(file)?,
            _ => self
                .change(command)
                .unwrap_or_else(|error| CommandOutcome::Refused(error.to_string())),
        };
        self.follow()?;
        Ok(outcome)
    }

    /// Carries out a command about the document alone.
    fn change(&mut self, command: &Command) -> Result<CommandOutcome, CommandError> {
        let document = &mut self.document;
        match command {
            Command::Select(name) => {
                let found = document.find(name)?;
                document.select(found);
                return Ok(self.selected());
            }
            Command::Deselect => document.select([]),
            Command::Hide(name) => self.display(name.as_deref(), Display::Hidden)?,
            Command::Ghost(name) => {
                if !self.viewport.has_ghosts() {
                    return Err(CommandError::TooManyToGhost(MOST_GHOSTED_OBJECTS));
                }
                self.display(name.as_deref(), Display::Ghosted)?;
            }
            Command::Show(None) => {
                let all: Vec<ObjectId> = document.objects().collect();
                document.set_display(&all, Display::Shown);
            }
            Command::Show(name) => self.display(name.as_deref(), Display::Shown)?,
            Command::Isolate => document.isolate()?,
            Command::Member { member, name } => {
                let objects = document.named_or_selected(name.as_deref())?;
                document.set_member(&objects, *member);
            }
            Command::Lid { degrees } => return self.turn_lid(*degrees),
            Command::Explode { gap_mm } => {
                document.explode(*gap_mm / MM as f32);
                let is_shown = |object: &ObjectId| document.display(*object) != Display::Hidden;
                let boxes = document.objects().filter(is_shown);
                let boxes: Vec<_> = boxes.map(|object| document.bounds(object)).collect();
                return Ok(CommandOutcome::Exploded {
                    least_gap_mm: least_gap(&boxes).map(|gap| gap * MM),
                });
            }
            Command::Assemble => document.assemble(),
            _ => {}
        }
        Ok(CommandOutcome::Done)
    }

    fn display(&mut self, name: Option<&str>, display: Display) -> Result<(), CommandError> {
        let objects = self.document.named_or_selected(name)?;
        self.document.set_display(&objects, display);
        Ok(())
    }

    fn turn_lid(&mut self, degrees: f32) -> Result<CommandOutcome, CommandError> {
        let lid = self.document.lid.ok_or(CommandError::NoLid)?;
        let closed_rad = lid.hinge.closed_rad;
        let Turn { angle_rad, contact } =
            self.document.turn_lid(closed_rad + degrees.to_radians())?;
        let name = |part: usize| self.document.name(ObjectId(part as u32)).to_owned();
        let contact = contact.map(|contact| [name(contact.moving), name(contact.fixed)]);
        let degrees = (angle_rad - closed_rad).to_degrees();
        Ok(CommandOutcome::Lid(LidTurn { degrees, contact }))
    }

    fn selected(&self) -> CommandOutcome {
        let names = self.document.selected().map(|object| self.document.name(object).to_owned());
        CommandOutcome::Selected(names.collect())
    }

    /// Selects the part under a pixel.
    fn pick(&mut self, at: Pixel) -> Result<CommandOutcome, RunError> {
        if at.x >= self.size.width || at.y >= self.size.height {
            let reason =
                format!("the image has {} pixels, and none at {}, {}", self.size, at.x, at.y);
            return Ok(CommandOutcome::Refused(reason));
        }
        let Some((object, point)) = self.hit(at)? else {
            self.document.select([]);
            return Ok(CommandOutcome::Picked(None));
        };
        self.document.select([object]);
        let part = self.document.name(object).to_owned();
        let point_mm = (point * MM).to_array();
        Ok(CommandOutcome::Picked(Some(PickedPoint { part, point_mm })))
    }

    fn distance(&mut self, from: Pixel, to: Pixel) -> Result<CommandOutcome, RunError> {
        let from = self.hit(from)?.map(|(_, point)| point);
        let to = self.hit(to)?.map(|(_, point)| point);
        let distance_mm = from.zip(to).map(|(from, to): (DVec3, DVec3)| from.distance(to) * MM);
        Ok(CommandOutcome::Distance { distance_mm })
    }

    fn edge(&mut self, at: Pixel) -> Result<CommandOutcome, RunError> {
        let Some((object, point)) = self.hit(at)? else {
            return Ok(CommandOutcome::Edge { length_mm: None });
        };
        let view = self.viewport.view_of(&self.camera());
        let transform = self.document.transform(object);
        let mesh = self.document.mesh(object);
        let length_m = mesh.and_then(|mesh| edge_length(mesh, &transform, &view, point));
        Ok(CommandOutcome::Edge { length_mm: length_m.map(|length_m| length_m * MM) })
    }

    /// Returns the part that owns a pixel, as the GPU drew it, and the point of it there.
    fn hit(&mut self, at: Pixel) -> Result<Option<(ObjectId, DVec3)>, RunError> {
        if at.x >= self.size.width || at.y >= self.size.height {
            return Ok(None);
        }
        let camera = self.camera();
        let Some(seen) = self.viewport.pick(&camera, at)? else { return Ok(None) };
        let ray = Ray::of_pixel(&self.viewport.view_of(&camera), at.x, at.y);
        let transform = self.document.transform(seen.object);
        let mesh = self.document.mesh(seen.object);
        let exact = mesh.and_then(|mesh| hit_mesh(mesh, &transform, &ray, seen.point));
        Ok(Some((seen.object, exact.map_or(seen.point, |hit| hit.point))))
    }

    fn play(&mut self, frames: u32) -> Result<CommandOutcome, RunError> {
        if self.path.is_empty() {
            return Ok(CommandOutcome::Refused("this model has no path of the camera".to_owned()));
        }
        for frame in 0..frames {
            let share = frame as f32 / frames as f32;
            let camera = along(&self.path, share * self.path.len() as f32);
            self.viewport.draw(&camera)?;
        }
        Ok(CommandOutcome::Played { frames })
    }

    /// Makes the curved parts anew for the image.
    fn tessellate(&mut self, piece_px: f32) -> Result<CommandOutcome, RunError> {
        let camera = self.camera();
        let made =
            self.curved.tessellate(&mut self.viewport, &mut self.document, &camera, piece_px)?;
        self.follow()?;
        self.viewport.await_uploads(&camera)?;
        let outcome = made.map(|Tessellated { triangles, path }| CommandOutcome::Tessellated {
            triangles,
            path: path.name().to_owned(),
        });
        let refused = || CommandOutcome::Refused("this model has no curved part".to_owned());
        Ok(outcome.unwrap_or_else(refused))
    }

    fn image(&mut self, file: &Path) -> Result<CommandOutcome, RunError> {
        let camera = self.camera();
        let pixels = self.viewport.image(&camera)?;
        let visible = self.viewport.visible(&camera)?;
        let written = write_png(file, self.size, &pixels).map_err(RunError::machine)?;
        let visible = visible.into_iter().map(|object| self.document.name(object).to_owned());
        Ok(CommandOutcome::Image { file: shown(&written).to_string(), visible: visible.collect() })
    }

    fn export(&self, file: &Path) -> Result<CommandOutcome, RunError> {
        let bytes = match glb(&self.document) {
            Ok(bytes) => bytes,
            Err(error) => return Ok(CommandOutcome::Refused(error.to_string())),
        };
        write_file(file, &bytes).map_err(RunError::machine)?;
        Ok(CommandOutcome::Exported { file: shown(file).to_string(), bytes: bytes.len() as u64 })
    }

    /// Returns the camera of the image.
    fn camera(&self) -> Camera {
        let bounds = self.document.shown_bounds();
        let reach =
            (bounds.max - self.camera.target).abs().max((bounds.min - self.camera.target).abs());
        // A little more, so that nothing lies on a plane of the frustum.
        self.camera.camera(reach.length().max(1.0e-3) * 1.01)
    }

    /// Brings the viewport up to the document.
    fn follow(&mut self) -> Result<(), RunError> {
        self.viewport.follow(&self.document)?;
        self.viewport.outline(self.document.selected())?;
        Ok(())
    }
}

/// Returns a camera that sees all that is shown, from a corner.
fn fitted(document: &Document, size: FrameSize) -> OrbitCamera {
    let bounds = document.shown_bounds();
    let middle = (bounds.min + bounds.max) * 0.5;
    let camera = OrbitCamera::around(middle, (bounds.max - bounds.min).length() * 0.5);
    // In images that are higher than wide, the width decides.
    let narrow = (size.height as f32 / size.width as f32).max(1.0);
    OrbitCamera { height_m: camera.height_m * narrow, ..camera }
}

/// Returns the camera at a place of a closed path: between two of its cameras.
fn along(path: &[Camera], place: f32) -> Camera {
    let index = place as usize % path.len();
    let from = path[index];
    let to = path[(index + 1) % path.len()];
    let share = place.fract();
    Camera {
        eye: from.eye.lerp(to.eye, share),
        forward: from.forward.lerp(to.forward, share),
        up: from.up.lerp(to.up, share),
        ..from
    }
}

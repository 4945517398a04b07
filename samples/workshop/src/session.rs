//! A session of the viewer: commands change the document, and the viewport shows it.

use std::path::Path;

use antumbra::cull::{Aabb, CullView, FrameId, SectionMember, SectionPlanes};
use antumbra::glam::{DVec2, DVec3};
use antumbra::gpu::Device;
use antumbra::render::{EdgeMode, EdgePath, HostOverlay};
use antumbra::{Camera, ObjectId, Renderer};
use bench::legend;
use bench::options::FrameSize;
use bench::outputs::write_file;
use bench::png_file::write_png;
use bench::run_error::RunError;
use bench::terminal::shown;
use bench::transparency::TransparencyReport;

use crate::document::{CommandError, Display, Document};
use crate::explode::least_gap;
use crate::export::{glb, left_out};
use crate::hinge::Turn;
use crate::hit::{Ray, hit_part};
use crate::measure::{NearEdge, in_image, near_edge};
use crate::orbit::OrbitCamera;
use crate::report::{CommandOutcome, LidTurn, PickedPoint, not_blended};
use crate::retessellate::{CurvedParts, Tessellated};
use crate::script::{Command, Pixel};
use crate::viewport::{ModelViewport, PointedPixel, SeenObject, ViewportOptions};

/// Millimetres per metre.
const MM: f64 = 1000.0;

/// A shown document.
pub struct WorkshopSession {
    /// The document.
    pub document: Document,
    viewport: ModelViewport,
    curved: CurvedParts,
    camera: OrbitCamera,
    /// The cameras of the model's path.
    path: Vec<Camera>,
    size: FrameSize,
    /// The box around everything that is shown.
    bounds: Aabb,
    hovered: Option<ObjectId>,
}

/// The results of completed frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LateResults {
    /// The answer for the pixel of the pointer.
    pub pointed: Option<PointedPixel>,
    /// The visibility of the watched objects.
    pub seen: Vec<SeenObject>,
    /// The number of drawn objects, if it is new.
    pub drawn: Option<u64>,
}

/// The questions that a frame of a window answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameQuestions {
    /// The pixel of the pointer.
    pub pointer: Option<Pixel>,
    /// The object that is outlined as hovered.
    pub hovered: Option<ObjectId>,
    /// The objects whose visibility is requested.
    pub watched: Vec<ObjectId>,
}

impl WorkshopSession {
    /// Creates a session that shows a document at rest, seen from a corner.
    ///
    /// # Errors
    /// A scene or size beyond the device's limits, no memory, a failed call.
    pub fn new(
        device: &Device,
        document: Document,
        path: Vec<Camera>,
        options: &ViewportOptions,
    ) -> Result<Self, RunError> {
        let viewport = ModelViewport::new(device, &document, options)?;
        let size = options.size;
        let bounds = document.shown_bounds();
        let camera = OrbitCamera::fitted(&bounds, size);
        let hovered = None;
        let curved = CurvedParts::default();
        let mut session = Self { camera, document, viewport, curved, path, size, bounds, hovered };
        session.follow()?;
        Ok(session)
    }

    /// Carries out a command. A refused command changes nothing.
    ///
    /// # Errors
    /// A failure of the device, or of writing a file.
    pub fn act(&mut self, command: &Command) -> Result<CommandOutcome, RunError> {
        let is_outside = |at: &Pixel| at.x >= self.size.width || at.y >= self.size.height;
        if let Some(Pixel { x, y }) = command.pixels().into_iter().find(is_outside) {
            let reason = format!("the image has {} pixels, and none at {x}, {y}", self.size);
            return Ok(CommandOutcome::Refused(reason));
        }
        let outcome = match command {
            Command::Pick(at) => self.pick(*at)?,
            Command::Distance { from, to } => self.distance(*from, *to)?,
            Command::Edge(at) => self.edge(*at)?,
            Command::Edges(mode) => {
                self.viewport.set_edges(*mode)?;
                let path = (*mode != EdgeMode::Off).then(|| EdgePath::of(self.viewport.device()));
                CommandOutcome::Edges { path: path.map(|path| path.name().to_owned()) }
            }
            Command::Overlay(overlay) => {
                self.viewport.set_overlay(*overlay)?;
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
            Command::Camera(camera) => {
                self.camera = *camera;
                CommandOutcome::Done
            }
            Command::DistanceOfPoints { from, to } => {
                CommandOutcome::Distance { distance_mm: Some(from.distance(*to) * MM) }
            }
            Command::EdgeOfObject { object, point } => self.edge_of(*object, *point),
            Command::Flatness(flatness) => {
                self.camera.flatness = *flatness;
                CommandOutcome::Done
            }
            Command::Fit => {
                let fitted = OrbitCamera::fitted(&self.bounds, self.size);
                let OrbitCamera { target, height_m, .. } = fitted;
                self.camera = OrbitCamera { target, height_m, ..self.camera };
                CommandOutcome::Done
            }
            Command::Tessellate { piece_px } => self.tessellate(*piece_px)?,
            Command::Play { frames } => self.play(*frames)?,
            Command::Image(file) => self.image(file)?,
            Command::Export(file) => self.export(file)?,
            _ => {
                let changed = self.change(command);
                match command {
                    Command::Select(_) | Command::SelectObjects(_) | Command::Deselect => {
                        self.outline()?;
                    }
                    _ => self.follow()?,
                }
                changed.unwrap_or_else(|error| CommandOutcome::Refused(error.to_string()))
            }
        };
        Ok(outcome)
    }

    /// Carries out a command that only affects the document.
    fn change(&mut self, command: &Command) -> Result<CommandOutcome, CommandError> {
        let document = &mut self.document;
        match command {
            Command::Select(name) => {
                let found = document.find(name)?;
                document.select(found);
                return Ok(self.selected());
            }
            Command::SelectObjects(objects) => {
                document.select(objects.iter().copied());
                return Ok(self.selected());
            }
            Command::DisplayObjects { objects, display } => {
                if *display == Display::Ghosted {
                    self.viewport.check_ghosts()?;
                }
                document.set_display(objects, *display);
            }
            Command::Deselect => document.select([]),
            Command::Hide(name) => self.display(name.as_deref(), Display::Hidden)?,
            Command::Ghost(name) => {
                self.viewport.check_ghosts()?;
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
                let bodies = document.shown_bodies();
                let boxes: Vec<Aabb> = bodies.iter().map(|body| body.bounds).collect();
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
        let hit = self.hit(at)?;
        self.document.select(hit.map(|(object, _)| object));
        self.outline()?;
        let Some((object, point)) = hit else { return Ok(CommandOutcome::Picked(None)) };
        let part = self.document.name(object).to_owned();
        let point_mm = ((point + self.document.origin_m) * MM).to_array();
        Ok(CommandOutcome::Picked(Some(PickedPoint { part, point_mm })))
    }

    fn distance(&mut self, from: Pixel, to: Pixel) -> Result<CommandOutcome, RunError> {
        let from = self.hit(from)?.map(|(_, point)| point);
        let to = self.hit(to)?.map(|(_, point)| point);
        let distance_mm = from.zip(to).map(|(from, to): (DVec3, DVec3)| from.distance(to) * MM);
        Ok(CommandOutcome::Distance { distance_mm })
    }

    /// Measures the edge nearest to a pixel, on the parts at the pixel and its neighbours: half of
    /// a line is drawn outside of its part.
    fn edge(&mut self, at: Pixel) -> Result<CommandOutcome, RunError> {
        let mut nearest: Option<NearEdge> = None;
        let place = DVec2::new(f64::from(at.x), f64::from(at.y)) + 0.5;
        for [right, down] in [[0, 0], [-2, 0], [2, 0], [0, -2], [0, 2]] {
            let beside = at.x.checked_add_signed(right).zip(at.y.checked_add_signed(down));
            let Some((x, y)) =
                beside.filter(|(x, y)| *x < self.size.width && *y < self.size.height)
            else {
                continue;
            };
            let Some((object, point)) = self.hit(Pixel { x, y })? else { continue };
            let near = self.near_edge(object, point, place);
            nearest = nearest.into_iter().chain(near).min_by(|a, b| {
                // If an edge is found twice, the first result is kept.
                a.apart_pixels.total_cmp(&b.apart_pixels)
            });
        }
        Ok(CommandOutcome::Edge { length_mm: nearest.map(|edge| edge.length_m * MM) })
    }

    /// Measures the edge of an object near a point of it.
    fn edge_of(&self, object: ObjectId, point: DVec3) -> CommandOutcome {
        let near = self.near_edge(object, point, in_image(&self.view(), point));
        CommandOutcome::Edge { length_mm: near.map(|edge| edge.length_m * MM) }
    }

    fn near_edge(&self, object: ObjectId, point: DVec3, place: DVec2) -> Option<NearEdge> {
        let transform = self.document.transform(object);
        near_edge(self.document.mesh(object)?, &transform, &self.view(), point, place)
    }

    /// Returns the part that owns a pixel in the GPU's image, and its point there.
    fn hit(&mut self, at: Pixel) -> Result<Option<(ObjectId, DVec3)>, RunError> {
        let camera = self.camera();
        let Some(seen) = self.viewport.pick(&camera, at)? else { return Ok(None) };
        let ray = Ray::of_pixel(&self.viewport.view_of(&camera), at.x, at.y);
        let transform = self.document.transform(seen.object);
        let mesh = self.document.mesh(seen.object);
        let section = match self.document.member(seen.object) {
            SectionMember::Cut => self.viewport.section(),
            SectionMember::Whole => SectionPlanes::default(),
        };
        let exact = mesh.and_then(|mesh| hit_part(mesh, &transform, &ray, &section, seen.point));
        Ok(Some((seen.object, exact.unwrap_or(seen.point))))
    }

    fn play(&mut self, frames: u32) -> Result<CommandOutcome, RunError> {
        if self.path.is_empty() {
            return Ok(CommandOutcome::Refused("this model has no path of the camera".to_owned()));
        }
        for frame in 0..frames {
            let share = frame as f32 / frames as f32;
            let camera = along(&self.path, share * self.path.len() as f32);
            self.viewport.draw(&camera, None)?;
        }
        Ok(CommandOutcome::Played { frames })
    }

    /// Tessellates the curved parts for the image.
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
        // Images do not include the pointer. The next frame of a window restores its outline.
        self.hovered = None;
        self.outline()?;
        let camera = self.camera();
        let mut pixels = self.viewport.image(&camera)?;
        if self.viewport.overlay().has_depth_complexity {
            let width = self.size.width as usize;
            legend::draw(&mut pixels, width, legend::TITLE_OF_LAYERS, &legend::layers());
        }
        let fragments = self.viewport.fragments();
        let visible = self.viewport.visible(&camera)?;
        let written = write_png(file, self.size, &pixels).map_err(RunError::machine)?;
        let visible = visible.into_iter().map(|object| self.document.name(object).to_owned());
        Ok(CommandOutcome::Image {
            file: shown(&written).to_string(),
            visible: visible.collect(),
            inexact: fragments.as_ref().and_then(not_blended),
            fragments,
        })
    }

    /// Returns a sentence about transparent parts that are not shown as requested.
    pub fn transparency_notice(&self) -> Option<String> {
        let is_ghosted = |object| self.document.display(object) == Display::Ghosted;
        let fallback = self.transparency().and_then(|report| report.fallback).filter(|_| {
            !self.document.transparent().is_empty() || self.document.objects().any(is_ghosted)
        });
        let fallback = fallback.map(|reason| format!("ghosts are sorted part by part: {reason}"));
        fallback.or_else(|| not_blended(&self.viewport.fragments()?))
    }

    /// Returns the method of transparency, if fragments were requested.
    pub fn transparency(&self) -> Option<TransparencyReport> {
        self.viewport.transparency()
    }

    fn export(&self, file: &Path) -> Result<CommandOutcome, RunError> {
        let bytes = match glb(&self.document) {
            Ok(bytes) => bytes,
            Err(error) => return Ok(CommandOutcome::Refused(error.to_string())),
        };
        write_file(file, &bytes).map_err(RunError::machine)?;
        let left_out = left_out(&self.document);
        let bytes = bytes.len() as u64;
        Ok(CommandOutcome::Exported { file: shown(file).to_string(), bytes, left_out })
    }

    /// Returns the camera of the image.
    fn camera(&self) -> Camera {
        let bounds = &self.bounds;
        let reach =
            (bounds.max - self.camera.target).abs().max((bounds.min - self.camera.target).abs());
        // Slightly more, so that nothing lies on a plane of the frustum.
        self.camera.camera(reach.length().max(1.0e-3) * 1.01)
    }

    /// Updates the viewport from the document.
    fn follow(&mut self) -> Result<(), RunError> {
        self.bounds = self.document.shown_bounds();
        self.viewport.follow(&self.document)?;
        self.outline()
    }

    fn outline(&mut self) -> Result<(), RunError> {
        let is_selected = |hovered: &ObjectId| self.document.is_selected(*hovered);
        let hovered = self.hovered.filter(|hovered| !is_selected(hovered));
        Ok(self.viewport.outline(self.document.selected(), hovered)?)
    }
}

/// The methods for windows.
impl WorkshopSession {
    /// Returns the camera, as the user moves it.
    pub fn orbit(&self) -> OrbitCamera {
        self.camera
    }

    /// Returns the view of the next frame.
    pub fn view(&self) -> CullView {
        self.viewport.view_of(&self.camera())
    }

    /// Returns the box around everything that is shown.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the newest frame.
    pub fn frame(&self) -> FrameId {
        self.viewport.frame()
    }

    /// Checks that frames can report the object below the pointer.
    ///
    /// # Errors
    /// A device that does not support this.
    pub fn check_pointer(&mut self) -> Result<(), RunError> {
        self.viewport.point_at(Some(Pixel { x: 0, y: 0 }))?;
        Ok(self.viewport.point_at(None)?)
    }

    /// Returns the cameras of the model's path.
    pub fn path(&self) -> &[Camera] {
        &self.path
    }

    /// Returns the renderer, to present its image.
    pub fn renderer(&self) -> &Renderer {
        self.viewport.renderer()
    }

    /// Continues on another device after the loss of the present one. Commands that the lost
    /// device did not carry out are carried out.
    ///
    /// # Errors
    /// A session that does not keep its scene; a device that does not take it, or fails. The call
    /// can be repeated.
    pub fn recover(&mut self, device: &Device) -> Result<(), RunError> {
        self.viewport.recover(device)?;
        self.follow()
    }

    /// Changes the size of images.
    ///
    /// # Errors
    /// A size that the device does not support; no memory.
    pub fn resize(&mut self, size: FrameSize) -> Result<(), RunError> {
        self.viewport.resize([size.width, size.height])?;
        self.size = size;
        Ok(())
    }

    /// Draws a frame with the host's overlay on top.
    ///
    /// # Errors
    /// No memory, a lost device, a frame that takes too long.
    pub fn draw(
        &mut self,
        questions: &FrameQuestions,
        overlay: Option<&dyn HostOverlay>,
    ) -> Result<(), RunError> {
        // Without support of the device, there is no answer.
        let _is_asked = self.viewport.point_at(questions.pointer).is_ok();
        self.viewport.watch(&questions.watched);
        if self.hovered != questions.hovered {
            self.hovered = questions.hovered;
            self.outline()?;
        }
        let camera = self.camera();
        Ok(self.viewport.draw(&camera, overlay)?)
    }

    /// Returns the results of completed frames. Never waits.
    pub fn late_results(&mut self) -> LateResults {
        LateResults {
            pointed: self.viewport.pointed(),
            drawn: self.viewport.take_drawn(),
            seen: self.viewport.seen().collect(),
        }
    }
}

/// Returns the camera at a place of a closed path, interpolated between its cameras.
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

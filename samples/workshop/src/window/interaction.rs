//! The interaction with the viewer: turns events and late results into commands. A pure value.

use std::f32::consts::PI;

use antumbra::ObjectId;
use antumbra::cull::Aabb;
use antumbra::glam::Vec2;
use antumbra::render::PointedSurface;
use winit::event::MouseButton;
use winit::keyboard::{KeyCode, ModifiersState};

use super::camera_path::OrbitPath;
use super::context::InteractionContext;
use super::drag::{Drag, PlaneGrab, place_of};
use super::gesture::{Click, CubeTurn, Held, is_shown_at};
use super::input::InputEvent;
use super::keys::{KeyEffect, effect_of};
use super::tools::{MeasuredLine, Measuring, Tools, handle_of};
use super::view_cube::ViewCube;
use crate::orbit::{CubeView, OrbitCamera};
use crate::report::CommandOutcome;
use crate::script::{Command, Pixel};
use crate::viewport::PointedPixel;

/// The movement from which on a press is a drag, in pixels.
const DRAG_PIXELS: f32 = 4.0;

/// The radius of a plane's handle, in half edges of the cube.
pub const HANDLE_SHARE: f32 = 0.33;

/// The time after which a press or click continues without an answer, in seconds.
const LONGEST_WAIT_S: f32 = 0.5;

/// The duration of a turn to a view, and of a change of the projection, in seconds.
const TURN_S: f32 = 0.4;

/// The factor of the image's height per notch of the wheel.
const NOTCH: f32 = 0.85;

/// The state of interaction.
#[derive(Clone, Debug, PartialEq)]
pub struct Interaction {
    tools: Tools,
    /// The settings before the newest change.
    before: Tools,
    cube: ViewCube,
    path: OrbitPath,
    cursor: Option<Vec2>,
    hovered: Option<PointedSurface>,
    held: Option<Held>,
    click: Option<Click>,
    turn: Option<CubeTurn>,
    measured: Option<MeasuredLine>,
    modifiers: ModifiersState,
    message: Option<String>,
}

impl Interaction {
    /// Creates the state at rest, for a model with this box and path.
    pub fn new(bounds: &Aabb, path: OrbitPath) -> Self {
        Self {
            tools: Tools::at_rest(bounds),
            before: Tools::at_rest(bounds),
            cube: ViewCube::default(),
            path,
            cursor: None,
            hovered: None,
            held: None,
            click: None,
            turn: None,
            measured: None,
            modifiers: ModifiersState::empty(),
            message: None,
        }
    }

    /// Returns the settings of the tools.
    pub fn tools(&self) -> &Tools {
        &self.tools
    }

    /// Returns the cube.
    pub fn cube(&self) -> &ViewCube {
        &self.cube
    }

    /// Returns the camera's path.
    pub fn path(&self) -> &OrbitPath {
        &self.path
    }

    /// Returns the surface below the pointer, as a frame showed it.
    pub fn hovered(&self) -> Option<&PointedSurface> {
        self.hovered.as_ref().filter(|_| self.held.is_none())
    }

    /// Returns the place of the pointer over the model.
    pub fn cursor(&self) -> Option<Vec2> {
        self.cursor
    }

    /// Returns the newest measurement.
    pub fn measured(&self) -> Option<&MeasuredLine> {
        self.measured.as_ref()
    }

    /// Returns the newest message.
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Shows a message.
    pub fn tell(&mut self, message: &str) {
        self.message = Some(message.to_owned());
    }

    /// Places the cube in an image.
    pub fn lay_out(&mut self, size: Vec2, pixels_per_point: f32) {
        self.cube = ViewCube::in_corner(size, pixels_per_point);
    }

    /// Returns true while frames change without events.
    pub fn is_moving(&self, camera: &OrbitCamera) -> bool {
        let is_awaiting = self.click.is_some() || self.held.is_some_and(|held| held.is_dragging);
        let is_on_path = self.path.is_playing() || self.path.is_recording();
        self.turn.is_some() || is_on_path || is_awaiting || camera.flatness != self.tools.flatness()
    }

    /// Returns the pixel for which frames must answer.
    pub fn pointer(&self, seen: &InteractionContext<'_>) -> Option<Pixel> {
        if let Some(click) = &self.click {
            return Some(click.pixel);
        }
        if let Some(held) = &self.held {
            return seen.pixel_at(held.pressed_at).filter(|_| held.drag.is_none());
        }
        let cursor = self.cursor.filter(|cursor| !self.is_on_sign(*cursor, seen));
        cursor.and_then(|cursor| seen.pixel_at(cursor))
    }

    fn is_on_sign(&self, place: Vec2, seen: &InteractionContext<'_>) -> bool {
        self.cube.view_at(&seen.camera, place).is_some() || self.handle_at(place, seen).is_some()
    }

    /// Returns the index of the section plane whose handle is at a place.
    pub fn handle_at(&self, place: Vec2, seen: &InteractionContext<'_>) -> Option<usize> {
        let radius = self.cube.half_edge * HANDLE_SHARE;
        self.tools.planes.iter().enumerate().position(|(axis, plane)| {
            let handle = place_of(&seen.view, handle_of(&seen.bounds, axis, plane));
            plane.is_on && handle.is_some_and(|handle| handle.distance(place) <= radius)
        })
    }

    /// Handles an event.
    pub fn handle(&mut self, input: InputEvent, seen: &InteractionContext<'_>) -> Vec<Command> {
        match input {
            InputEvent::Moved(place) => {
                self.cursor = Some(place);
                if let Some(held) = &mut self.held {
                    held.is_dragging |= held.pressed_at.distance(place) >= DRAG_PIXELS;
                }
                Vec::new()
            }
            InputEvent::Left => {
                if self.held.is_none() {
                    self.cursor = None;
                    self.hovered = None;
                }
                Vec::new()
            }
            InputEvent::Pressed(button) => {
                self.press(button, seen);
                Vec::new()
            }
            InputEvent::Released(button) => self.release(button, seen),
            InputEvent::Wheel(notches) => self.wheel(notches, seen),
            InputEvent::Key(key) => self.key(key, seen),
            InputEvent::Modifiers(modifiers) => {
                self.modifiers = modifiers;
                Vec::new()
            }
        }
    }

    fn press(&mut self, button: MouseButton, seen: &InteractionContext<'_>) {
        let Some(place) = self.cursor.filter(|_| self.held.is_none()) else { return };
        self.end_motion();
        self.click = None;
        let is_left = button == MouseButton::Left;
        let on_cube = self.cube.view_at(&seen.camera, place).filter(|_| is_left);
        let plane = self.handle_at(place, seen).filter(|_| is_left);
        let plane = plane.and_then(|axis| {
            let plane = &self.tools.planes[axis];
            PlaneGrab::new(&seen.view, &seen.bounds, axis, plane, place).map(Drag::Plane)
        });
        let drag = match button {
            MouseButton::Left if on_cube.is_some() => Some(Drag::Turn),
            MouseButton::Left => plane,
            _ => Some(Drag::Move),
        };
        self.held = Some(Held {
            button,
            pressed_at: place,
            followed_to: place,
            is_dragging: false,
            drag,
            on_cube,
            frame: seen.frame,
            waited_s: 0.0,
        });
    }

    fn release(&mut self, button: MouseButton, seen: &InteractionContext<'_>) -> Vec<Command> {
        let Some(held) = self.held.filter(|held| held.button == button) else { return Vec::new() };
        let commands = self.follow(seen);
        self.held = None;
        if held.is_dragging || button != MouseButton::Left {
            return commands;
        }
        if let Some(view) = held.on_cube {
            self.turn_to(view, seen);
        } else if !matches!(held.drag, Some(Drag::Plane(_))) {
            let click = |pixel| Click { pixel, frame: seen.frame, waited_s: 0.0 };
            self.click = seen.pixel_at(held.pressed_at).map(click);
        }
        commands
    }

    /// Ends automatic movements of the camera.
    fn end_motion(&mut self) {
        self.turn = None;
        self.path.stop_playing();
    }

    fn turn_to(&mut self, view: CubeView, seen: &InteractionContext<'_>) {
        self.end_motion();
        self.turn = Some(CubeTurn { view, from: seen.camera, seconds: 0.0 });
    }

    fn wheel(&mut self, notches: f32, seen: &InteractionContext<'_>) -> Vec<Command> {
        let Some(cursor) = self.cursor.filter(|_| notches.is_finite()) else { return Vec::new() };
        self.end_motion();
        let camera = self.at_hovered(&seen.camera);
        let [width, height] = seen.view.size.map(|side| side.max(1) as f32);
        let offset = (cursor - Vec2::new(width, height) * 0.5) / height;
        let factor = NOTCH.powf(notches.clamp(-20.0, 20.0));
        vec![Command::Camera(camera.zoomed(factor, offset.x, offset.y))]
    }

    /// Returns the camera with its target at the depth of the surface below the pointer.
    fn at_hovered(&self, camera: &OrbitCamera) -> OrbitCamera {
        let point = self.hovered.map(|hovered| hovered.point.as_vec3());
        point.map_or(*camera, |point| camera.at_depth_of(point))
    }

    /// Handles the answer of a frame for the requested pixel.
    pub fn learn_pointed(
        &mut self,
        pointed: &PointedPixel,
        seen: &InteractionContext<'_>,
    ) -> Vec<Command> {
        let surface = pointed.surface;
        if let Some(held) = &mut self.held
            && held.drag.is_none()
            && seen.pixel_at(held.pressed_at) == Some(pointed.pixel)
            && is_shown_at(pointed, held.frame)
        {
            self.hovered = surface;
            held.drag = Some(Drag::on(&surface, &self.tools, seen));
            return Vec::new();
        }
        let is_answer =
            |click: &mut Click| click.pixel == pointed.pixel && is_shown_at(pointed, click.frame);
        if self.click.take_if(is_answer).is_some() {
            self.hovered = surface;
            return self.clicked(&surface, seen);
        }
        if self.held.is_none() {
            let is_on_model = self.cursor.is_some_and(|cursor| !self.is_on_sign(cursor, seen));
            self.hovered = surface.filter(|_| is_on_model);
        }
        Vec::new()
    }

    /// Selects or measures at the click.
    fn clicked(
        &mut self,
        surface: &Option<PointedSurface>,
        seen: &InteractionContext<'_>,
    ) -> Vec<Command> {
        match (self.tools.measuring, surface) {
            (Measuring::Off, None) if !self.modifiers.control_key() => vec![Command::Deselect],
            (_, None) => Vec::new(),
            (Measuring::Off, Some(surface)) => {
                let mut objects: Vec<ObjectId> = Vec::new();
                if self.modifiers.control_key() {
                    objects.extend(seen.document.selected());
                }
                match objects.iter().position(|object| *object == surface.object) {
                    Some(place) => _ = objects.remove(place),
                    None => objects.push(surface.object),
                }
                vec![Command::SelectObjects(objects)]
            }
            (Measuring::Edge, Some(PointedSurface { object, point, .. })) => {
                vec![Command::EdgeOfObject { object: *object, point: *point }]
            }
            (Measuring::Distance, Some(PointedSurface { point, .. })) => {
                let begun = self.measured.filter(|line| line.to.is_none());
                let Some(MeasuredLine { from, .. }) = begun else {
                    self.measured = Some(MeasuredLine { from: *point, to: None });
                    self.tell("click the other point");
                    return Vec::new();
                };
                self.measured = Some(MeasuredLine { from, to: Some(*point) });
                vec![Command::DistanceOfPoints { from, to: *point }]
            }
        }
    }

    /// Handles the outcome of a command, and shows it.
    pub fn learn_outcome(&mut self, command: &Command, outcome: &CommandOutcome) {
        let tools = &mut self.tools;
        match (outcome, command) {
            (CommandOutcome::Lid(turn), _) => tools.lid_degrees = turn.degrees,
            // A refused setting is reverted.
            (CommandOutcome::Refused(_), Command::Lid { .. }) => {
                tools.lid_degrees = self.before.lid_degrees;
            }
            (CommandOutcome::Refused(_), Command::Explode { .. }) => {
                tools.gap_mm = self.before.gap_mm;
            }
            (CommandOutcome::Refused(_), Command::Edges(_)) => tools.edges = self.before.edges,
            (CommandOutcome::Refused(_), Command::Section(_)) => {
                tools.planes = self.before.planes;
            }
            _ => {}
        }
        if matches!(command, Command::Fit) {
            self.end_motion();
        }
        if command.changes_surfaces() && !matches!(outcome, CommandOutcome::Refused(_)) {
            // The measured points may have moved.
            self.measured = None;
        }
        if !matches!(command, Command::Camera(_)) {
            self.message = outcome.sentence();
        }
    }

    /// Changes the settings of the tools.
    pub fn use_tools(&mut self, tools: Tools) -> Vec<Command> {
        if tools.measuring != self.tools.measuring {
            self.measured = None;
            match tools.measuring {
                Measuring::Off => self.message = None,
                Measuring::Distance => self.tell("click two points"),
                Measuring::Edge => self.tell("click near an edge"),
            }
        }
        let commands = self.tools.commands_to(&tools);
        self.before = std::mem::replace(&mut self.tools, tools);
        commands
    }

    /// Advances the time before the next frame: animations continue, and dragged objects follow.
    pub fn advance(&mut self, seconds: f32, seen: &InteractionContext<'_>) -> Vec<Command> {
        let mut commands = self.follow(seen);
        let before = match commands[..] {
            [Command::Camera(camera)] => camera,
            _ => seen.camera,
        };
        let mut camera = before;
        if let Some(turn) = &mut self.turn {
            turn.seconds += seconds;
            let turned = turn.from.turned_to(turn.view, turn.seconds / TURN_S);
            camera = OrbitCamera { flatness: camera.flatness, ..turned };
        }
        self.turn = self.turn.filter(|turn| turn.seconds < TURN_S);
        let flatness = self.tools.flatness();
        let step = seconds / TURN_S;
        camera.flatness += (flatness - camera.flatness).clamp(-step, step);
        if let Some(played) = self.path.advance(seconds, &camera) {
            camera = OrbitCamera { flatness: camera.flatness, ..played };
        }
        if camera != before {
            commands.retain(|command| !matches!(command, Command::Camera(_)));
            commands.push(Command::Camera(camera));
        }
        self.wait(seconds);
        commands
    }

    /// Stops waiting for late answers; some devices never give any.
    fn wait(&mut self, seconds: f32) {
        if let Some(held) = &mut self.held
            && held.drag.is_none()
        {
            held.waited_s += seconds;
            if held.waited_s > LONGEST_WAIT_S {
                held.drag = Some(Drag::Turn);
            }
        }
        self.click = self.click.take().and_then(|mut click| {
            click.waited_s += seconds;
            (click.waited_s < LONGEST_WAIT_S * 4.0).then_some(click)
        });
    }

    /// Makes dragged objects follow the pointer.
    fn follow(&mut self, seen: &InteractionContext<'_>) -> Vec<Command> {
        let hovered = self.hovered;
        let (Some(held), Some(cursor)) = (&mut self.held, self.cursor) else { return Vec::new() };
        let Some(drag) = held.drag.filter(|_| held.is_dragging) else { return Vec::new() };
        let by = cursor - held.followed_to;
        if by == Vec2::ZERO {
            return Vec::new();
        }
        let is_first = held.followed_to == held.pressed_at;
        held.followed_to = cursor;
        let height = seen.view.size[1].max(1) as f32;
        let mut camera = seen.camera;
        if let Some(surface) = hovered.filter(|_| is_first) {
            camera = camera.at_depth_of(surface.point.as_vec3());
        }
        match drag {
            Drag::Turn => {
                let turned = camera.turned_by(by.x / height * PI, by.y / height * PI);
                vec![Command::Camera(turned)]
            }
            Drag::Move => vec![Command::Camera(camera.panned(by.x / height, by.y / height))],
            Drag::Lid(grab) => {
                let angle_rad = grab.angle_at(&seen.view, seen.document.lid_rad(), cursor);
                vec![Command::Lid { degrees: grab.degrees(angle_rad) }]
            }
            Drag::Plane(grab) => {
                let mut tools = self.tools;
                tools.planes[grab.axis].place_mm = grab.place_mm(&seen.bounds, cursor);
                self.use_tools(tools)
            }
        }
    }

    /// Returns true if keys have the effects on the page of keys: with modifiers other than Shift
    /// they are shortcuts of other programs.
    pub fn takes_keys(&self) -> bool {
        let others = ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER;
        !self.modifiers.intersects(others)
    }

    /// Handles a key.
    fn key(&mut self, key: KeyCode, seen: &InteractionContext<'_>) -> Vec<Command> {
        if !self.takes_keys() {
            return Vec::new();
        }
        match effect_of(key, &self.tools, seen) {
            KeyEffect::Nothing => {}
            KeyEffect::Escape => return self.escape(),
            KeyEffect::Command(command) => {
                if matches!(command, Command::Camera(_)) {
                    self.end_motion();
                }
                return vec![command];
            }
            KeyEffect::Tools(tools) => return self.use_tools(tools),
            KeyEffect::CullView(view) => self.turn_to(view, seen),
            KeyEffect::Record => self.path.toggle_recording(),
            KeyEffect::Play => {
                if !self.path.toggle_playing() {
                    self.tell("there is no path yet: record one (R)");
                }
            }
        }
        Vec::new()
    }

    /// Closes the page of keys, or else ends measuring, or else the path, or else clears the
    /// selection.
    fn escape(&mut self) -> Vec<Command> {
        self.message = None;
        if self.tools.has_help {
            self.tools.has_help = false;
        } else if self.tools.measuring != Measuring::Off {
            return self.use_tools(Tools { measuring: Measuring::Off, ..self.tools });
        } else if self.path.is_playing() || self.path.is_recording() {
            self.path.stop();
        } else {
            return vec![Command::Deselect];
        }
        Vec::new()
    }
}

#[cfg(test)]
mod tests;

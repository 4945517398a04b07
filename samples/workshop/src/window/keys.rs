//! The effects of keys.

use std::f32::consts::PI;
use std::path::PathBuf;

use winit::keyboard::KeyCode;

use super::context::InteractionContext;
use super::tools::{Measuring, Tools};
use crate::orbit::{CubeView, OrbitCamera};
use crate::script::Command;

/// The angle per press of an arrow key, in radians.
const ARROW_RAD: f32 = PI / 12.0;

/// The factor of the image's height per press of a zoom key.
const ZOOM: f32 = 0.8;

/// The effect of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyEffect {
    /// None.
    Nothing,
    /// Closes or ends what is open.
    Escape,
    /// Carries out a command.
    Command(Command),
    /// Changes the settings of the tools.
    Tools(Tools),
    /// Turns to a view of the cube.
    CullView(CubeView),
    /// Begins or ends recording the path.
    Record,
    /// Begins or ends playing the path.
    Play,
}

/// Returns the effect of a key.
pub fn effect_of(key: KeyCode, tools: &Tools, seen: &InteractionContext<'_>) -> KeyEffect {
    let command = match key {
        KeyCode::Escape => return KeyEffect::Escape,
        KeyCode::KeyR => return KeyEffect::Record,
        KeyCode::KeyP => return KeyEffect::Play,
        KeyCode::KeyF => Command::Fit,
        KeyCode::KeyH => Command::Hide(None),
        KeyCode::KeyG => Command::Ghost(None),
        KeyCode::KeyI => Command::Isolate,
        KeyCode::KeyS => Command::Show(None),
        KeyCode::KeyK => Command::Image(PathBuf::from("workshop.png")),
        KeyCode::KeyJ => Command::Export(PathBuf::from("workshop.glb")),
        _ => {
            if let Some(view) = view_of(key) {
                return KeyEffect::CullView(view);
            }
            if let Some(camera) = camera_of(key, &seen.camera) {
                return KeyEffect::Command(Command::Camera(camera));
            }
            return tools_of(key, *tools, seen).map_or(KeyEffect::Nothing, KeyEffect::Tools);
        }
    };
    KeyEffect::Command(command)
}

/// Returns the settings of the tools after a key.
fn tools_of(key: KeyCode, mut tools: Tools, seen: &InteractionContext<'_>) -> Option<Tools> {
    let toggle = |measuring: Measuring| {
        if tools.measuring == measuring { Measuring::Off } else { measuring }
    };
    match key {
        KeyCode::KeyO => tools.is_orthographic = !tools.is_orthographic,
        KeyCode::KeyE => return Some(tools.with_next_edges()),
        KeyCode::KeyT => tools.has_panel = !tools.has_panel,
        KeyCode::F1 => tools.has_help = !tools.has_help,
        KeyCode::KeyX => tools.planes[0].is_on = !tools.planes[0].is_on,
        KeyCode::KeyY => tools.planes[1].is_on = !tools.planes[1].is_on,
        KeyCode::KeyZ => tools.planes[2].is_on = !tools.planes[2].is_on,
        KeyCode::KeyD => tools.measuring = toggle(Measuring::Distance),
        KeyCode::KeyL => tools.measuring = toggle(Measuring::Edge),
        KeyCode::KeyB => {
            let lid = seen.document.lid?;
            let whole_rad = lid.hinge.open_rad - lid.hinge.closed_rad;
            let is_open = tools.lid_degrees > 1.0;
            tools.lid_degrees = if is_open { 0.0 } else { whole_rad.to_degrees() };
        }
        _ => return None,
    }
    Some(tools)
}

fn view_of(key: KeyCode) -> Option<CubeView> {
    CubeView::named(match key {
        KeyCode::Digit1 => "front",
        KeyCode::Digit2 => "back",
        KeyCode::Digit3 => "left",
        KeyCode::Digit4 => "right",
        KeyCode::Digit5 => "top",
        KeyCode::Digit6 => "bottom",
        KeyCode::Digit7 | KeyCode::Home => "iso",
        _ => return None,
    })
}

/// Returns the camera after a key moves it.
fn camera_of(key: KeyCode, camera: &OrbitCamera) -> Option<OrbitCamera> {
    Some(match key {
        KeyCode::ArrowLeft => camera.turned_by(-ARROW_RAD, 0.0),
        KeyCode::ArrowRight => camera.turned_by(ARROW_RAD, 0.0),
        KeyCode::ArrowUp => camera.turned_by(0.0, -ARROW_RAD),
        KeyCode::ArrowDown => camera.turned_by(0.0, ARROW_RAD),
        KeyCode::Equal | KeyCode::NumpadAdd => camera.zoomed(ZOOM, 0.0, 0.0),
        KeyCode::Minus | KeyCode::NumpadSubtract => camera.zoomed(1.0 / ZOOM, 0.0, 0.0),
        _ => return None,
    })
}

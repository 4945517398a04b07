//! The effects of the mouse and of some keys on an open window, and the choices from its lists.

use std::path::PathBuf;

use antumbra::pacing::Time;
use winit::window::{CursorGrabMode, Fullscreen};

use crate::window::actions::Action;
use crate::window::clipboard;
use crate::window::leaving::Escape;
use crate::window::menu::{self, Choice, Menu, MenuKey};
use crate::window::opened::Opened;
use crate::window::pointer::PointerAction;
use crate::window::scene_files;
use crate::window::show::ShowOptions;
use crate::window::source::SceneSource;
use bench::options::MadeScene;
use bench::run_error::RunError;

/// The approximate number of objects of a scene chosen from the list.
const MADE_OBJECTS: u32 = 10_000;

impl Opened {
    /// Handles Esc; returns true if the program should end.
    pub(crate) fn escape(&mut self) -> Result<bool, RunError> {
        let closes = self.session.topmost_panel().map(|_| Escape::Close);
        let frees = self.pointer.is_looking().then_some(Escape::Free);
        match self.leaving.escape(self.clock_now(), closes.or(frees)) {
            Escape::Close => self.session.close_panel()?,
            Escape::Free => {
                let action = self.pointer.free();
                self.point(action);
            }
            Escape::Ask => self.session.refuse("press Esc again to quit".to_owned()),
            Escape::Quit => return Ok(true),
        }
        self.next_layout = Time::ZERO;
        Ok(false)
    }

    pub(crate) fn toggle_full_screen(&self) {
        let wanted = match self.window.fullscreen() {
            Some(_) => None,
            None => Some(Fullscreen::Borderless(None)),
        };
        self.window.set_fullscreen(wanted);
    }

    /// Carries out an action of the mouse.
    pub(crate) fn point(&mut self, action: Option<PointerAction>) {
        match action {
            Some(PointerAction::Grab) => self.grab(),
            Some(PointerAction::Release) => self.release(),
            Some(PointerAction::Identify) => {
                let at = self.cursor.map(|side| side.clamp(0.0, f64::from(u32::MAX)) as u32);
                self.session.identify((!self.pointer.is_captured()).then_some(at));
            }
            None => {}
        }
        if self.pointer.is_captured() && action == Some(PointerAction::Grab) {
            self.session.tell("the mouse is captured; Esc frees it".to_owned());
            self.next_layout = Time::ZERO;
        }
    }

    /// Keeps the mouse in the window. Some window systems do not support this; looking around then
    /// works up to the edge of the screen.
    fn grab(&self) {
        let locked = self.window.set_cursor_grab(CursorGrabMode::Locked);
        let _free = locked.or_else(|_| self.window.set_cursor_grab(CursorGrabMode::Confined));
        self.window.set_cursor_visible(false);
    }

    fn release(&self) {
        let _never_grabbed = self.window.set_cursor_grab(CursorGrabMode::None);
        self.window.set_cursor_visible(true);
    }

    /// Notes whether other windows hide this window.
    pub(crate) fn set_occluded(&mut self, is_occluded: bool) {
        self.is_occluded = is_occluded;
        self.not_before = Time::ZERO;
    }

    /// Changes the camera's speed by notches of the mouse wheel.
    pub(crate) fn hasten(&mut self, notches: f32) {
        self.session.hasten(notches);
        self.next_layout = Time::ZERO;
    }

    /// Begins to load or generate another scene.
    pub(crate) fn load(&mut self, source: &SceneSource, options: &ShowOptions) {
        let size = self.session.renderer().size();
        let device = self.session.renderer().device().clone();
        let begun = self.arrivals.load(&device, source, options, size);
        if let Err(error) = begun {
            self.session.refuse_source(source, &error);
        }
        if let SceneSource::File { file, .. } = source {
            self.files.retain(|opened| opened != file);
            self.files.push(file.clone());
        }
    }

    /// Begins to generate the scene with lights, if the last action requires them.
    pub(crate) fn load_lit(&mut self, options: &ShowOptions) {
        let Some(request) = self.session.take_lighting_request() else { return };
        let size = self.session.renderer().size();
        let device = self.session.renderer().device().clone();
        if let Err(error) = self.arrivals.load_lit(&device, &request, options, size) {
            self.session.refuse_source(&request.source, &error);
        }
    }

    /// Returns the list of scenes, with the current scene selected.
    pub(crate) fn scenes(&self) -> Menu {
        let shown = self.session.title_words().scene;
        menu::scenes(scene_files::to_choose(&self.files), shown)
    }

    /// Handles a key while a list or field is open.
    pub(crate) fn choose(
        &mut self,
        key: MenuKey,
        another: impl Fn(PathBuf) -> SceneSource,
        options: &ShowOptions,
    ) -> Result<(), RunError> {
        self.next_layout = Time::ZERO;
        let key = match key {
            MenuKey::Paste => match clipboard::text() {
                Ok(text) => MenuKey::Text(text),
                Err(reason) => {
                    self.session.refuse(reason);
                    return Ok(());
                }
            },
            key => key,
        };
        let Some(choice) = self.session.menu.as_mut().and_then(|menu| menu.key(&key)) else {
            return Ok(());
        };
        self.session.menu = None;
        match choice {
            Choice::Strategy(strategy) => self.session.act(Action::Strategy(strategy))?,
            Choice::Made(scene) => {
                let made = MadeScene { scene, objects: MADE_OBJECTS, seed: 1 };
                self.load(
                    &SceneSource::Made { made, path: None, hour: self.session.hour() },
                    options,
                );
            }
            Choice::File(file) => self.load(&another(file), options),
            Choice::TypePath => self.session.menu = Some(Menu::path()),
        }
        Ok(())
    }
}

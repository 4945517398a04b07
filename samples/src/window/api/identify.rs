//! A session while an object is selected: it is outlined, and a card explains why it is drawn or
//! not.

use antumbra::cull::ObjectId;

use crate::window::object_text::ObjectCard;
use crate::window::page_text::Facts;
use crate::window::selection::Selection;
use crate::window::session::Session;
use bench::run_error::RunError;

impl Session {
    /// Begins to find out which object is at a pixel of the image, or in its middle.
    pub fn identify(&mut self, pixel: Option<[u32; 2]>) {
        let [width, height] = self.renderer.size();
        let [x, y] = pixel.unwrap_or([width / 2, height / 2]);
        self.selection.pixel = Some([x.min(width - 1), y.min(height - 1)]);
    }

    /// Handles the answer that is there by now, then points at the pixel that was clicked last;
    /// never waits.
    pub(crate) fn follow_selection(&mut self) -> Result<(), RunError> {
        if let Some(before) = self.selection.asked_after {
            // A newer click waits, so that many of them cannot keep all from being answered.
            let newer = self.history.pointed().filter(|pointed| pointed.frame > before);
            let Some(surface) = newer.map(|pointed| pointed.surface) else { return Ok(()) };
            self.history.point_at(None)?;
            self.select(surface.map(|surface| surface.object))?;
        }
        if let Some(pixel) = self.selection.pixel.take_if(|_| self.frame > 0) {
            self.selection.asked_after = Some(self.history.plan().frame);
            self.history.point_at(Some(pixel))?;
        }
        Ok(())
    }

    fn select(&mut self, object: Option<ObjectId>) -> Result<(), RunError> {
        self.renderer.outline(object)?;
        let pixel = self.selection.pixel;
        self.selection = Selection { pixel, object, is_new: object.is_some(), asked_after: None };
        self.is_page_stale = true;
        if object.is_none() {
            self.tell("there is no object".to_owned());
        }
        Ok(())
    }

    /// Closes the card of the selected object, and removes its outline.
    pub(crate) fn deselect(&mut self) -> Result<(), RunError> {
        self.renderer.outline(None)?;
        self.selection = Selection::default();
        self.is_page_stale = true;
        Ok(())
    }

    /// Logs the card of an object, once after it was selected.
    pub(crate) fn log_selection(&mut self) {
        if std::mem::take(&mut self.selection.is_new) {
            let rows = self.card().into_iter().map(|(name, value)| format!("{name}: {value}"));
            tracing::info!("{}", rows.collect::<Vec<_>>().join("; "));
        }
    }

    /// Returns the facts about the selected object; none if it is gone.
    pub(crate) fn card(&self) -> Facts {
        let view = match &self.frozen {
            Some(snapshot) => snapshot.view,
            None => self.renderer.view_of(&self.seen_from),
        };
        let explained = self
            .selection
            .object
            .and_then(|object| self.renderer.explain_object(&self.history, &view, object));
        let Some((explained, outcome)) = explained else { return Facts::new() };
        let card = ObjectCard {
            explained: &explained,
            outcome,
            mesh: self.scene_view.mesh_name(explained.object),
            triangles: self.renderer.triangles_of(explained.object),
            rays: view.rays,
            strategy: self.strategy,
        };
        card.facts()
    }
}

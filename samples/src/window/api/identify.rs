//! A session with a selected object: it is outlined, and a card explains why it is drawn or not.

use antumbra::{FrameRequest, ObjectId, RenderView, Strategy};

use crate::window::object_text::ObjectCard;
use crate::window::page_text::Facts;
use crate::window::selection::{Search, Selection};
use crate::window::session::Session;
use bench::run_error::RunError;

impl Session {
    /// Begins to identify the object at a pixel of the image, or in its middle.
    pub fn identify(&mut self, pixel: Option<[u32; 2]>) {
        let [width, height] = self.renderer.size();
        let [x, y] = pixel.unwrap_or([width / 2, height / 2]);
        self.selection.pixel = Some([x.min(width - 1), y.min(height - 1)]);
    }

    /// Handles the newest answer, then points at the pixel of the last click; never waits.
    pub(crate) fn follow_selection(&mut self) -> Result<(), RunError> {
        if let Some(Search { after, .. }) = self.selection.search {
            // A newer click waits for this answer; otherwise many clicks could keep all from being
            // answered.
            let newer = self.searching()?.pointed().filter(|pointed| pointed.frame > after);
            let surface = newer.map(|pointed| pointed.surface);
            let Some(surface) = surface else { return self.draw_search() };
            self.searching()?.point_at(None)?;
            self.select(surface.map(|surface| surface.object))?;
        }
        if let Some(pixel) = self.selection.pixel.take_if(|_| self.frame > 0) {
            let view = self.searching()?;
            let after = view.plan().frame;
            view.point_at(Some(pixel))?;
            self.selection.search = Some(Search { pixel, after });
            self.draw_search()?;
        }
        Ok(())
    }

    /// Restarts a pending search, before frames are drawn in another view.
    pub(crate) fn search_again(&mut self) -> Result<(), RunError> {
        self.history.point_at(None)?;
        self.search_view = None;
        if let Some(Search { pixel, .. }) = self.selection.search.take() {
            self.selection.pixel.get_or_insert(pixel);
        }
        Ok(())
    }

    /// Returns the view whose frames find objects. It is the shown view, except while the culling
    /// is frozen: frozen frames lack the objects that were left out, so a separate view is used.
    fn searching(&mut self) -> Result<&mut RenderView, RunError> {
        if self.frozen.is_none() {
            return Ok(&mut self.history);
        }
        let view = match self.search_view.take() {
            Some(view) => view,
            None => self.renderer.new_view()?,
        };
        Ok(self.search_view.insert(view))
    }

    /// Draws a frame of the separate view while the culling is frozen. It is not shown.
    fn draw_search(&mut self) -> Result<(), RunError> {
        if let Some(view) = &mut self.search_view {
            let request = FrameRequest::new(Strategy::FRUSTUM, self.seen_from);
            self.renderer.render(view, request)?;
        }
        Ok(())
    }

    fn select(&mut self, object: Option<ObjectId>) -> Result<(), RunError> {
        self.renderer.outline(object)?;
        let pixel = self.selection.pixel;
        self.selection = Selection { pixel, object, is_new: object.is_some(), search: None };
        self.is_page_stale = true;
        if object.is_none() {
            self.tell("there is no object".to_owned());
        }
        Ok(())
    }

    /// Closes the card of the selected object and removes its outline.
    pub(crate) fn deselect(&mut self) -> Result<(), RunError> {
        self.renderer.outline(None)?;
        self.selection = Selection::default();
        self.is_page_stale = true;
        Ok(())
    }

    /// Logs the card of an object, once per selection.
    pub(crate) fn log_selection(&mut self) {
        if std::mem::take(&mut self.selection.is_new) {
            let rows = self.card().into_iter().map(|(name, value)| format!("{name}: {value}"));
            tracing::info!("{}", rows.collect::<Vec<_>>().join("; "));
        }
    }

    /// Returns the facts about the selected object; empty if it does not exist any more.
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

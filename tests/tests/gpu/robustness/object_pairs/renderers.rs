//! Calls of a renderer with objects of another renderer, or of another device.

use cull::Strategy;
use gpu::Tick;
use render::{Error, FrameRequest, Rect, ViewRequest, ViewsRequest};

use super::side::{SIZE, Side};
use super::{Mistake, Row};

const IMAGE: &str = "an image (`Readback`)";
const TIMELINE: &str = "a timeline (`Timeline`)";
const VIEW: &str = "a view (`RenderView`)";
const MOMENT: &str = "a snapshot (`VisibilitySnapshot`)";
const VISIBLE_SET: &str = "a visible set (`VisibleSet`)";

type Call = fn(&mut Side, &mut Side) -> String;

fn text<T>(result: Result<T, Error>) -> String {
    result.err().expect("an error").to_string()
}

/// Renders with a request that `request` changes, and returns the error.
fn rendered<'a>(ours: &mut Side, change: impl FnOnce(&mut FrameRequest<'a>)) -> String {
    let mut request = FrameRequest::new(Strategy::ANTUMBRA, ours.camera);
    change(&mut request);
    text(ours.renderer.render(&mut ours.view, request))
}

/// Returns the error of `render_views` with a view of the renderer and a foreign view.
fn views_rendered(ours: &mut Side, theirs: &mut Side, what: &'static str) -> String {
    let camera = ours.camera;
    let area = Rect::whole(SIZE);
    let history = if what == VIEW { &mut theirs.view } else { &mut ours.view };
    let visible = (what == VISIBLE_SET).then_some(&theirs.visible);
    let eye = ViewRequest { state: history, viewpoint: camera.into(), visible, rect: area };
    let request = ViewsRequest {
        strategy: methods::IDEAL,
        image: (what == IMAGE).then_some(&theirs.image),
        overlay: None,
        after: (what == TIMELINE).then_some(theirs.timeline.at(Tick(1))),
    };
    let request = match what {
        VISIBLE_SET => request,
        _ => ViewsRequest { strategy: Strategy::FRUSTUM, ..request },
    };
    text(ours.renderer.render_views(&mut [eye], &request))
}

pub fn rows() -> Vec<Row> {
    let row: MakeRow =
        |call, given, owner, made| Row { call, given, owner, mistake: Mistake::Returned(made) };
    let mut rows = vec![
        row("Renderer::render", IMAGE, "Device", |ours, theirs| {
            rendered(ours, |request| request.image = Some(&theirs.image))
        }),
        row("FrameRequest::scene_image", IMAGE, "Device", |ours, theirs| {
            rendered(ours, |request| request.scene_image = Some(&theirs.image))
        }),
        row("Renderer::render", TIMELINE, "Device", |ours, theirs| {
            rendered(ours, |request| request.after = Some(theirs.timeline.at(Tick(1))))
        }),
        row("Renderer::render", VIEW, "Renderer", |ours, theirs| {
            let request = FrameRequest::new(Strategy::ANTUMBRA, ours.camera);
            text(ours.renderer.render(&mut theirs.view, request))
        }),
        row("Renderer::render", VISIBLE_SET, "Renderer", |ours, theirs| {
            rendered(ours, |request| request.visible = Some(&theirs.visible))
        }),
        row("Renderer::render_views", IMAGE, "Device", |ours, theirs| {
            views_rendered(ours, theirs, IMAGE)
        }),
        row("Renderer::render_views", TIMELINE, "Device", |ours, theirs| {
            views_rendered(ours, theirs, TIMELINE)
        }),
        row("Renderer::render_views", VIEW, "Renderer", |ours, theirs| {
            views_rendered(ours, theirs, VIEW)
        }),
        row("Renderer::render_views", VISIBLE_SET, "Renderer", |ours, theirs| {
            views_rendered(ours, theirs, VISIBLE_SET)
        }),
        row("Renderer::present", "a target (`Target`)", "Device", |ours, theirs| {
            text(theirs.renderer.present(&mut ours.swapchain, SIZE))
        }),
    ];
    rows.extend(histories(row));
    rows.extend(moments(row));
    rows
}

type MakeRow = fn(&'static str, &'static str, &'static str, Call) -> Row;

fn histories(row: MakeRow) -> Vec<Row> {
    vec![
        row("Renderer::wait_idle", VIEW, "Renderer", |ours, theirs| {
            text(ours.renderer.wait_idle(&mut theirs.view))
        }),
        row("Renderer::snapshot", VIEW, "Renderer", |ours, theirs| {
            let view = ours.renderer.view_of(&ours.camera);
            text(ours.renderer.snapshot(&mut theirs.view, view))
        }),
        row("Renderer::visible_set", VIEW, "Renderer", |ours, theirs| {
            let camera = ours.camera;
            let area = Rect::whole(SIZE);
            text(ours.renderer.visible_set(&mut theirs.view, camera, area))
        }),
        row("Renderer::visible_again", VISIBLE_SET, "Renderer", |ours, theirs| {
            text(ours.renderer.visible_again(&mut theirs.visible))
        }),
    ]
}

fn moments(row: MakeRow) -> Vec<Row> {
    vec![
        row("Renderer::top_down", MOMENT, "Renderer", |ours, theirs| {
            text(ours.renderer.top_down(&theirs.snapshot, &ours.image))
        }),
        row("Renderer::top_down", IMAGE, "Device", |ours, theirs| {
            text(ours.renderer.top_down(&ours.snapshot, &theirs.image))
        }),
        row("Renderer::render_snapshot", MOMENT, "Renderer", |ours, theirs| {
            text(ours.renderer.render_snapshot(&theirs.snapshot, ours.camera, None, None))
        }),
        row("Renderer::render_snapshot", IMAGE, "Device", |ours, theirs| {
            let image = Some(&theirs.image);
            text(ours.renderer.render_snapshot(&ours.snapshot, ours.camera, image, None))
        }),
    ]
}

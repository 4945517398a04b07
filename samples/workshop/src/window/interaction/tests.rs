//! Tests of the interaction with a session without a GPU.

use antumbra::cull::FrameId;
use antumbra::glam::{DVec3, Vec2};
use antumbra::render::EdgeMode;

use super::*;
use crate::document::{Document, Lid};
use crate::report::LidTurn;

const SIZE: [u32; 2] = [800, 600];

/// A session without a GPU: the camera is updated, and the test provides the answers of frames.
struct Bench {
    document: Document,
    camera: OrbitCamera,
    frame: u64,
    interaction: Interaction,
}

impl Bench {
    fn new() -> Self {
        let made = scenes::waffle_maker();
        let lid = Lid { group: made.lid, hinge: made.hinge };
        let document = Document::new(made.scene, made.parts, Some(lid));
        let bounds = document.shown_bounds();
        let mut interaction = Interaction::new(&bounds, OrbitPath::default());
        interaction.lay_out(Vec2::new(800.0, 600.0), 1.0);
        let camera = OrbitCamera::around((bounds.min + bounds.max) * 0.5, 0.3);
        Self { document, camera, frame: 10, interaction }
    }

    /// Calls the interaction, and carries out its commands that affect the camera.
    fn with(
        &mut self,
        give: impl FnOnce(&mut Interaction, &InteractionContext<'_>) -> Vec<Command>,
    ) -> Vec<Command> {
        let camera = self.camera.camera(0.5);
        let seen = InteractionContext {
            document: &self.document,
            camera: self.camera,
            view: antumbra::cull::CullView::new(&camera, SIZE, 8),
            bounds: self.document.shown_bounds(),
            frame: FrameId(self.frame),
        };
        let commands = give(&mut self.interaction, &seen);
        for command in &commands {
            if let Command::Camera(camera) = command {
                self.camera = *camera;
            }
        }
        commands
    }

    fn input(&mut self, input: InputEvent) -> Vec<Command> {
        self.with(|interaction, seen| interaction.handle(input, seen))
    }

    fn advance(&mut self, seconds: f32) -> Vec<Command> {
        self.frame += 1;
        self.with(|interaction, seen| interaction.advance(seconds, seen))
    }

    /// Gives the answer of a frame for the requested pixel.
    fn answer(&mut self, surface: Option<PointedSurface>) -> Vec<Command> {
        let frame = FrameId(self.frame);
        self.with(|interaction, seen| {
            let Some(pixel) = interaction.pointer(seen) else { return Vec::new() };
            interaction.learn_pointed(&PointedPixel { frame, pixel, surface }, seen)
        })
    }

    fn click_at(&mut self, x: f32, y: f32) {
        self.input(InputEvent::Moved(Vec2::new(x, y)));
        self.input(InputEvent::Pressed(MouseButton::Left));
        assert_eq!(self.input(InputEvent::Released(MouseButton::Left)), []);
    }

    /// Returns the middle of a part, as a frame would show it.
    fn part(&self, name: &str) -> PointedSurface {
        let object = self.document.find(name).unwrap()[0];
        let bounds = self.document.bounds(object);
        let point = ((bounds.min + bounds.max) * 0.5).as_dvec3();
        PointedSurface { object, depth: 0.5, point }
    }
}

#[test]
fn a_click_selects_what_its_own_pixel_showed() {
    let mut bench = Bench::new();
    let body = bench.part("body");
    bench.click_at(300.0, 300.0);
    // An answer for another pixel and an old answer are ignored.
    let old = |frame, x| PointedPixel {
        frame: FrameId(frame),
        pixel: Pixel { x, y: 300 },
        surface: Some(body),
    };
    assert_eq!(bench.with(|interaction, seen| interaction.learn_pointed(&old(11, 299), seen)), []);
    assert_eq!(bench.with(|interaction, seen| interaction.learn_pointed(&old(2, 300), seen)), []);
    // The pointer may have moved: the click still waits for its answer.
    bench.input(InputEvent::Moved(Vec2::new(10.0, 10.0)));
    assert_eq!(bench.advance(0.01), []);
    assert_eq!(bench.answer(Some(body)), [Command::SelectObjects(vec![body.object])]);
    assert_eq!(bench.answer(Some(body)), [], "once");
    // A slow click, which is answered while the button is held.
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.answer(Some(body));
    bench.input(InputEvent::Released(MouseButton::Left));
    assert_eq!(bench.answer(None), [Command::Deselect]);
    assert_eq!(bench.input(InputEvent::Key(KeyCode::Escape)), [Command::Deselect]);
}

#[test]
fn with_control_a_click_adds_or_takes_away() {
    let mut bench = Bench::new();
    let body = bench.part("body");
    let plate = bench.part("lower plate");
    bench.document.select([body.object]);
    bench.input(InputEvent::Modifiers(ModifiersState::CONTROL));
    for (clicked, selected) in [(plate, vec![body.object, plate.object]), (body, vec![])] {
        bench.click_at(300.0, 300.0);
        assert_eq!(bench.answer(Some(clicked)), [Command::SelectObjects(selected)]);
    }
    bench.click_at(300.0, 300.0);
    assert_eq!(bench.answer(None), [], "a miss takes nothing away");
}

#[test]
fn a_drag_turns_the_model_and_selects_nothing() {
    let mut bench = Bench::new();
    let before = bench.camera;
    bench.input(InputEvent::Moved(Vec2::new(300.0, 300.0)));
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.input(InputEvent::Moved(Vec2::new(360.0, 300.0)));
    assert_eq!(bench.advance(0.01), [], "not before it is known what is held");
    let old = PointedPixel {
        frame: FrameId(2),
        pixel: Pixel { x: 300, y: 300 },
        surface: Some(bench.part("lid shell")),
    };
    assert_eq!(bench.with(|interaction, seen| interaction.learn_pointed(&old, seen)), []);
    assert_eq!(bench.advance(0.01), [], "not by what was there long ago");
    let body = bench.part("body");
    bench.answer(Some(body));
    assert_eq!(bench.advance(0.01).len(), 1);
    // The whole movement counts, including the wait.
    let turned_rad = before.yaw_rad - bench.camera.yaw_rad;
    assert!((turned_rad - 60.0 / 600.0 * PI).abs() < 1e-5, "{turned_rad}");
    assert_eq!(bench.advance(0.01), [], "a pointer that rests");
    assert_eq!(bench.input(InputEvent::Released(MouseButton::Left)), []);
    assert_eq!(bench.answer(Some(body)), []);
    // The other button moves the model in the image plane, without waiting.
    let before = bench.camera;
    bench.input(InputEvent::Pressed(MouseButton::Right));
    bench.input(InputEvent::Moved(Vec2::new(360.0, 360.0)));
    bench.advance(0.01);
    assert!(bench.camera.target.y > before.target.y && bench.camera.yaw_rad == before.yaw_rad);
}

#[test]
fn devices_that_cannot_tell_still_turn() {
    let mut bench = Bench::new();
    bench.input(InputEvent::Moved(Vec2::new(300.0, 300.0)));
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.input(InputEvent::Moved(Vec2::new(360.0, 300.0)));
    bench.advance(LONGEST_WAIT_S * 1.1);
    assert!(matches!(bench.advance(0.01)[..], [Command::Camera(_)]));
    bench.input(InputEvent::Released(MouseButton::Left));
    bench.click_at(300.0, 300.0);
    bench.advance(9.0);
    assert!(!bench.interaction.is_moving(&bench.camera), "nothing is awaited for ever");
}

#[test]
fn the_lid_is_dragged_where_it_is_held_and_stays_where_it_stopped() {
    let mut bench = Bench::new();
    let shell = bench.part("lid shell");
    bench.input(InputEvent::Moved(Vec2::new(300.0, 300.0)));
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.answer(Some(shell));
    bench.input(InputEvent::Moved(Vec2::new(300.0, 200.0)));
    let commands = bench.advance(0.01);
    let [Command::Lid { degrees }] = commands[..] else { panic!("{commands:?}") };
    assert!(degrees > 5.0, "upwards it opens: {degrees}");
    let contact = Some(["lid shell".to_owned(), "cable".to_owned()]);
    let stopped = CommandOutcome::Lid(LidTurn { degrees: 3.0, contact });
    bench.interaction.learn_outcome(&commands[0], &stopped);
    assert_eq!(bench.interaction.tools().lid_degrees, 3.0);
    assert_eq!(
        bench.interaction.message(),
        Some("lid at 3.0\u{b0}: the lid shell touches the cable")
    );
    bench.input(InputEvent::Released(MouseButton::Left));
    // The lid does not turn while parts are apart.
    let apart = Tools { gap_mm: 5.0, ..*bench.interaction.tools() };
    bench.interaction.use_tools(apart);
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.answer(Some(shell));
    bench.input(InputEvent::Moved(Vec2::new(300.0, 300.0)));
    assert!(matches!(bench.advance(0.01)[..], [Command::Camera(_)]));
}

#[test]
fn a_plane_is_dragged_by_its_handle() {
    let mut bench = Bench::new();
    let [Command::Section(_)] = bench.input(InputEvent::Key(KeyCode::KeyX))[..] else { panic!() };
    let bounds = bench.document.shown_bounds();
    let view = antumbra::cull::CullView::new(&bench.camera.camera(0.5), SIZE, 8);
    let handle =
        place_of(&view, handle_of(&bounds, 0, &bench.interaction.tools().planes[0])).unwrap();
    bench.input(InputEvent::Moved(handle));
    let body = bench.part("body");
    assert_eq!(
        bench.with(|interaction, seen| {
            assert_eq!(interaction.pointer(seen), None, "a handle hides the model");
            let surface = Some(body);
            let old = PointedPixel { frame: seen.frame, pixel: Pixel { x: 1, y: 1 }, surface };
            interaction.learn_pointed(&old, seen);
            assert_eq!(interaction.hovered(), None);
            Vec::new()
        }),
        []
    );
    bench.input(InputEvent::Pressed(MouseButton::Left));
    bench.input(InputEvent::Moved(handle + Vec2::new(60.0, 0.0)));
    assert!(matches!(bench.advance(0.01)[..], [Command::Section(_)]));
    assert!(bench.interaction.tools().planes[0].place_mm > 5.0);
}

#[test]
fn the_cube_and_the_projection_change_smoothly() {
    let mut bench = Bench::new();
    let cube = *bench.interaction.cube();
    bench.click_at(cube.middle.x, cube.middle.y);
    // The middle of the cube's image is its nearest corner, so turn first.
    bench.input(InputEvent::Key(KeyCode::Digit1));
    let mut frames = 0;
    while bench.interaction.is_moving(&bench.camera) {
        assert!(bench.advance(0.05).len() <= 1);
        frames += 1;
    }
    assert!((7..12).contains(&frames), "{frames}");
    assert!(bench.camera.forward().distance(antumbra::glam::Vec3::NEG_Z) < 1e-6);
    bench.input(InputEvent::Key(KeyCode::KeyO));
    let mut last = 0.0;
    while bench.interaction.is_moving(&bench.camera) {
        bench.advance(0.05);
        assert!(bench.camera.flatness - last < 0.2, "{last}");
        last = bench.camera.flatness;
    }
    assert_eq!(last, 1.0);
    assert_eq!(bench.advance(1.0), [], "at rest nothing is done");
}

#[test]
fn two_clicks_measure_a_distance_and_escape_ends_it() {
    let mut bench = Bench::new();
    bench.input(InputEvent::Key(KeyCode::KeyD));
    let from = PointedSurface { point: DVec3::ZERO, ..bench.part("body") };
    let to = PointedSurface { point: DVec3::X * 0.03, ..from };
    bench.click_at(300.0, 300.0);
    assert_eq!(bench.answer(Some(from)), []);
    bench.click_at(310.0, 300.0);
    let measured = Command::DistanceOfPoints { from: from.point, to: to.point };
    assert_eq!(bench.answer(Some(to)), [measured]);
    bench.input(InputEvent::Key(KeyCode::KeyL));
    bench.click_at(310.0, 300.0);
    let edge = Command::EdgeOfObject { object: to.object, point: to.point };
    assert_eq!(bench.answer(Some(to)), [edge]);
    assert_eq!(bench.input(InputEvent::Key(KeyCode::Escape)), []);
    assert_eq!(bench.interaction.tools().measuring, Measuring::Off);
}

#[test]
fn the_wheel_keeps_the_point_below_the_pointer() {
    let mut bench = Bench::new();
    let body = bench.part("body");
    bench.input(InputEvent::Moved(Vec2::new(300.0, 300.0)));
    bench.answer(Some(body));
    let place = |bench: &Bench| {
        let view = antumbra::cull::CullView::new(&bench.camera.camera(0.5), SIZE, 8);
        place_of(&view, body.point.as_vec3()).unwrap()
    };
    let at = place(&bench);
    bench.input(InputEvent::Moved(at));
    for _ in 0..20 {
        bench.input(InputEvent::Wheel(1.0));
        assert!(place(&bench).distance(at) < 0.1, "{}", place(&bench));
    }
    assert!(bench.camera.height_m < 0.05);
}

#[test]
fn what_is_refused_is_said_and_not_set() {
    let mut bench = Bench::new();
    let edges = Tools { edges: EdgeMode::Visible, ..*bench.interaction.tools() };
    let commands = bench.interaction.use_tools(edges);
    bench.interaction.learn_outcome(&commands[0], &CommandOutcome::Refused("no memory".to_owned()));
    assert_eq!(bench.interaction.tools().edges, EdgeMode::Off);
    assert_eq!(bench.interaction.message(), Some("no memory"));
    assert!(matches!(bench.input(InputEvent::Key(KeyCode::KeyH))[..], [Command::Hide(None)]));
    assert_eq!(bench.input(InputEvent::Key(KeyCode::KeyP)), []);
    assert!(bench.interaction.message().unwrap().contains("no path"));
}

#[test]
fn with_other_modifiers_keys_do_nothing() {
    let mut bench = Bench::new();
    for held in [ModifiersState::CONTROL, ModifiersState::ALT, ModifiersState::SUPER] {
        bench.input(InputEvent::Modifiers(held | ModifiersState::SHIFT));
        for key in [KeyCode::KeyS, KeyCode::KeyH, KeyCode::KeyX, KeyCode::ArrowLeft] {
            assert_eq!(bench.input(InputEvent::Key(key)), [], "{held:?} {key:?}");
        }
    }
    bench.input(InputEvent::Modifiers(ModifiersState::SHIFT));
    assert_eq!(bench.input(InputEvent::Key(KeyCode::KeyS)), [Command::Show(None)]);
}

#[test]
fn what_moves_the_camera_ends_a_turn_and_the_path() {
    let mut bench = Bench::new();
    for key in [KeyCode::ArrowLeft, KeyCode::Equal, KeyCode::KeyF] {
        bench.input(InputEvent::Key(KeyCode::KeyR));
        for _ in 0..3 {
            bench.input(InputEvent::Key(KeyCode::ArrowUp));
            bench.advance(0.2);
        }
        for motion in [KeyCode::Digit1, KeyCode::KeyP] {
            bench.input(InputEvent::Key(motion));
            bench.advance(0.01);
            assert!(bench.interaction.is_moving(&bench.camera), "{motion:?}");
            let commands = bench.input(InputEvent::Key(key));
            bench.interaction.learn_outcome(&commands[0], &CommandOutcome::Done);
            assert_eq!(bench.advance(0.1), [], "{key:?} is undone by {motion:?}");
        }
    }
}

#[test]
fn a_measured_line_ends_where_the_model_changes() {
    let mut bench = Bench::new();
    let body = bench.part("body");
    for (command, is_kept) in [
        (Command::Lid { degrees: 9.0 }, false),
        (Command::Explode { gap_mm: 5.0 }, false),
        (Command::Hide(None), false),
        (Command::Section(bench.interaction.tools().section()), false),
        (Command::Deselect, true),
        (Command::Edges(EdgeMode::Visible), true),
    ] {
        let measuring = Tools { measuring: Measuring::Distance, ..*bench.interaction.tools() };
        bench.interaction.use_tools(measuring);
        for _ in 0..2 {
            bench.click_at(300.0, 300.0);
            bench.answer(Some(body));
        }
        let refused = CommandOutcome::Refused(String::new());
        bench.interaction.learn_outcome(&command, &refused);
        assert!(bench.interaction.measured().is_some(), "{command:?} was refused");
        bench.interaction.learn_outcome(&command, &CommandOutcome::Done);
        assert_eq!(bench.interaction.measured().is_some(), is_kept, "{command:?}");
        let off = Tools { measuring: Measuring::Off, ..*bench.interaction.tools() };
        bench.interaction.use_tools(off);
    }
}

//! The calls of a long run.

use cull::{ObjectId, SectionMember, SectionMode, SectionPlane, SectionPlanes, Strategy};
use glam::{Affine3A, DVec3, Quat};
use render::{EdgeMode, EdgeOptions, ShaderSet};
use scene::{LightId, Object, ObjectChange, SkinnedMeshId, TransparentId};
use shadows::{ShadowMethod, ShadowOptions};

use super::content::{
    Came, PANES, SHADOWS, SPARE_LIGHTS, SPARE_MESHES, SPARE_OBJECTS, some_camera, some_light,
    some_material, some_transform,
};
use super::{LongRun, SIZES};
use crate::window_fixture::Random;

/// The greatest weight of a call that takes as long as tens of frames.
const COSTLY: u32 = 10;

/// A kind of call between two frames; what it is about is random.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Some objects move.
    Move,
    /// Copies of objects come.
    Add,
    /// Objects go.
    Remove,
    /// The camera jumps.
    Look,
    /// The camera turns a little.
    Turn,
    /// A mesh morphs.
    Pose,
    /// A transparent object moves.
    MovePane,
    /// A mesh, a material and a texture come, with an object.
    Stream,
    /// A mesh that came goes, with all that came with it.
    Unstream,
    /// A material that came changes.
    SetMaterial,
    /// A light comes.
    AddLight,
    /// A light goes.
    RemoveLight,
    /// A light moves.
    SetLight,
    /// Another strategy culls.
    UseStrategy,
    /// The image has another size.
    Resize,
    /// Another number of frames is in flight.
    FramesInFlight,
    /// Section planes come, move or go.
    Section,
    /// Section planes leave an object whole, or cut it.
    SectionMember,
    /// Shadows by another method.
    Shadows,
    /// Edges are drawn, or not.
    Edges,
    /// All shaders are compiled again.
    Reload,
    /// The hierarchy is built again.
    Rebuild,
    /// The device is lost.
    LoseDevice,
}

impl Call {
    /// All calls.
    pub const ALL: [Self; 23] = [
        Self::Move,
        Self::Add,
        Self::Remove,
        Self::Look,
        Self::Turn,
        Self::Pose,
        Self::MovePane,
        Self::Stream,
        Self::Unstream,
        Self::SetMaterial,
        Self::AddLight,
        Self::RemoveLight,
        Self::SetLight,
        Self::UseStrategy,
        Self::Resize,
        Self::FramesInFlight,
        Self::Section,
        Self::SectionMember,
        Self::Shadows,
        Self::Edges,
        Self::Reload,
        Self::Rebuild,
        Self::LoseDevice,
    ];

    /// Returns how often the call is made in a long run, of ten thousand frames.
    fn weight(self) -> u32 {
        match self {
            Self::Move => 4_000,
            Self::Turn => 1_400,
            Self::SetLight => 800,
            Self::Add | Self::Remove => 600,
            Self::Pose | Self::MovePane => 500,
            Self::SetMaterial | Self::UseStrategy => 300,
            Self::Stream | Self::Unstream => 250,
            Self::Look | Self::AddLight | Self::RemoveLight => 140,
            Self::SectionMember => 50,
            Self::Resize => 30,
            Self::FramesInFlight | Self::Rebuild => 20,
            Self::Section => 8,
            Self::Shadows | Self::Edges => 4,
            Self::Reload => 2,
            Self::LoseDevice => 2,
        }
    }

    /// Returns a random call of a short sequence: each is as likely as the others, but for those
    /// that take long.
    pub(super) fn of_all(random: &mut Random) -> Self {
        loop {
            let call = Self::ALL[random.below(Self::ALL.len() as u32) as usize];
            if call.weight() > COSTLY || random.below(4) == 0 {
                return call;
            }
        }
    }

    /// Returns a random call of a long run.
    pub(super) fn by_weight(random: &mut Random) -> Self {
        let sum: u32 = Self::ALL.iter().map(|call| call.weight()).sum();
        let mut place = random.below(sum);
        for call in Self::ALL {
            match place.checked_sub(call.weight()) {
                Some(rest) => place = rest,
                None => return call,
            }
        }
        Self::Move
    }
}

impl LongRun {
    /// Makes a call.
    pub(super) fn make(&mut self, call: Call) {
        if self.calls.len() == 1_000 {
            self.calls.drain(..900);
        }
        self.calls.push(call);
        match call {
            Call::Move => self.move_objects(),
            Call::Add => self.add_objects(),
            Call::Remove => self.remove_objects(),
            Call::Look => self.camera = some_camera(&mut self.random),
            Call::Turn => {
                let turn = Quat::from_rotation_y(self.random.between(-0.1, 0.1));
                self.camera.forward = turn * self.camera.forward;
            }
            Call::Pose => {
                let weight = self.random.part();
                self.renderer.set_pose(SkinnedMeshId(0), &[], &[weight]).expect("a pose");
            }
            Call::MovePane => {
                let pane = TransparentId(self.random.below(PANES));
                let transform = some_transform(&mut self.random);
                self.renderer.move_transparent(pane, transform).expect("a pane");
            }
            Call::Stream => self.stream(),
            Call::Unstream => self.unstream(),
            Call::SetMaterial => {
                if let Some(place) = some_place(&mut self.random, self.came.len()) {
                    let material = some_material(&mut self.random, self.came[place].texture);
                    let id = self.came[place].material;
                    self.renderer.set_material(id, &material).expect("a material");
                }
            }
            Call::AddLight | Call::RemoveLight | Call::SetLight => self.change_lights(call),
            Call::UseStrategy => {
                // Those that wait take longer.
                let place = self.random.below(2 * self.strategies.len() as u32) as usize;
                let strategy = self.strategies.get(place).copied().unwrap_or(Strategy::ANTUMBRA);
                if self.renderer.supports(strategy).is_ok() {
                    self.strategy = strategy;
                }
            }
            Call::Resize => {
                let size = SIZES[self.random.below(SIZES.len() as u32) as usize];
                self.resize(size);
            }
            Call::FramesInFlight => {
                let count = 1 + self.random.below(4) as usize;
                self.renderer.set_frames_in_flight(count).expect("few frames");
            }
            Call::Section | Call::SectionMember => self.cut(call),
            Call::Shadows => {
                let method = ShadowMethod::ALL[self.random.below(3) as usize];
                let options = ShadowOptions { method, ..SHADOWS };
                self.renderer.set_shadows(options).expect("shadows");
            }
            Call::Edges => {
                let mode = match self.renderer.edges().mode {
                    EdgeMode::Off => EdgeMode::ShadedWithHiddenDashed,
                    _ => EdgeMode::Off,
                };
                let options = EdgeOptions { mode, ..EdgeOptions::default() };
                self.renderer.set_edges(options).expect("edges");
            }
            Call::Reload => {
                let shaders = ShaderSet::embedded().expect("shaders");
                self.renderer.reload(shaders).expect("the same shaders");
            }
            Call::Rebuild => self.renderer.rebuild_hierarchy().expect("a hierarchy"),
            Call::LoseDevice => self.lose_device(),
        }
    }

    fn some_object(&mut self) -> Option<ObjectId> {
        let place = some_place(&mut self.random, self.objects.len())?;
        self.objects.keys().nth(place).copied()
    }

    fn move_objects(&mut self) {
        let mut changes = Vec::new();
        for _ in 0..1 + self.random.below(4) {
            let Some(object) = self.some_object() else { return };
            let there = self.objects.get_mut(&object).expect("it is there");
            let random = &mut self.random;
            there.transform = match random.below(3) {
                0 => some_transform(random),
                _ => {
                    let [x, z] = [0; 2].map(|_| random.between(-0.4, 0.4));
                    Affine3A::from_translation(glam::vec3(x, 0.0, z)) * there.transform
                }
            };
            changes.push(ObjectChange::Move { object, transform: there.transform });
        }
        self.renderer.update(&changes).expect("they are there");
    }

    fn add_objects(&mut self) {
        let room = self.first.objects.len() + SPARE_OBJECTS - self.objects.len();
        let count = (1 + self.random.below(6) as usize).min(room);
        let mut new = Vec::new();
        for _ in 0..count {
            // A skinned mesh has one object, which is the last.
            let place = self.random.below(self.first.objects.len() as u32 - 1) as usize;
            let transform = some_transform(&mut self.random);
            new.push(Object { transform, ..self.first.objects[place] });
        }
        let changes: Vec<_> =
            new.iter().map(|object| ObjectChange::Add { object: *object }).collect();
        let added = self.renderer.update(&changes).expect("there is room").added;
        self.objects.extend(added.into_iter().zip(new));
    }

    fn remove_objects(&mut self) {
        for _ in 0..1 + self.random.below(6) {
            if self.objects.len() > SPARE_OBJECTS
                && let Some(object) = self.some_object()
            {
                self.remove_object(object);
            }
        }
    }

    fn remove_object(&mut self, object: ObjectId) {
        self.renderer.update(&[ObjectChange::Remove { object }]).expect("it is there");
        self.objects.remove(&object);
        let of = self.came.iter_mut().find(|came| came.object == Some(object));
        of.into_iter().for_each(|came| came.object = None);
    }

    fn stream(&mut self) {
        if self.came.len() == SPARE_MESHES {
            return self.unstream();
        }
        let mut came = Came::add(&mut self.renderer, &mut self.random);
        if self.objects.len() < self.first.objects.len() + SPARE_OBJECTS {
            let transform = some_transform(&mut self.random);
            let object = Object { mesh: came.mesh, transform, tint: u32::MAX };
            let added = self.renderer.update(&[ObjectChange::Add { object }]);
            let added = added.expect("there is room").added[0];
            self.objects.insert(added, object);
            came.object = Some(added);
        }
        self.came.push(came);
    }

    fn unstream(&mut self) {
        if let Some(place) = some_place(&mut self.random, self.came.len()) {
            let came = self.came.swap_remove(place);
            if let Some(object) = came.object {
                self.remove_object(object);
            }
            came.remove(&mut self.renderer);
        }
    }

    fn change_lights(&mut self, call: Call) {
        let place = some_place(&mut self.random, self.lights.len());
        match (call, place) {
            (Call::AddLight, _) if self.lights.len() < SPARE_LIGHTS => {
                let light = some_light(&mut self.random, None);
                self.lights.extend(self.renderer.add_lights(&[light]).expect("room for a light"));
            }
            (Call::RemoveLight, Some(place)) => {
                let light = self.lights.swap_remove(place);
                self.renderer.remove_lights(&[light]).expect("it is there");
            }
            _ => {
                // The first spot stays.
                let surfaces = self.first.surfaces.as_ref().expect("surfaces");
                let light = some_light(&mut self.random, Some(surfaces.lights[1].kind));
                self.renderer.set_light(LightId(1), light).expect("it is there");
            }
        }
    }

    fn cut(&mut self, call: Call) {
        if call == Call::SectionMember {
            let members = [SectionMember::Cut, SectionMember::Whole];
            let member = members[self.random.below(2) as usize];
            if let Some(object) = self.some_object() {
                self.renderer.set_section_member(object, member);
            }
            return;
        }
        let random = &mut self.random;
        let normals = [DVec3::X, DVec3::NEG_Z, DVec3::Y, DVec3::new(0.3, 0.8, -0.4)];
        let count = if self.renderer.section().is_empty() { 1 + random.below(2) } else { 0 };
        let plane = |_| {
            let normal = normals[random.below(4) as usize];
            SectionPlane::new(normal, f64::from(random.between(-1.0, 2.0))).expect("a plane")
        };
        let planes: Vec<SectionPlane> = (0..count).map(plane).collect();
        let planes = SectionPlanes::new(&planes, SectionMode::Intersection).expect("few planes");
        self.renderer.set_section(planes).expect("section planes");
    }
}

/// Returns a place in a list of this length.
fn some_place(random: &mut Random, length: usize) -> Option<usize> {
    (length > 0).then(|| random.below(length as u32) as usize)
}

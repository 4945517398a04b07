//! Objects that move, appear and vanish, as a pure function of the frame: frames can be shown in
//! any order.
//!
//! Objects never meet: the sweep of each motion is free of the boxes of all other objects and of
//! their sweeps. So moving objects neither touch nor share planes, as [the scenes](super) promise,
//! and images do not depend on the order of draws. If there is no room for any motion, an object
//! can still appear and vanish.

mod act;
mod room;

use cull::ObjectId;
use scene::{Object, ObjectChange, Scene};

use self::act::Act;
use self::room::Room;
use super::error::{GeneratorError, MotionError};
use super::random::Random;

/// The number of moving objects per big one: a building or a gate house, which hides many objects.
const MOVERS_PER_BIG: usize = 20;

/// The height above which an object counts as big, in metres.
const BIG_M: f32 = 5.0;

/// The number of moving objects per object that also appears and vanishes.
const MOVERS_PER_GUEST: u32 = 6;

/// The prefix of the names of ground objects, which never move.
const GROUND: &str = "ground";

/// The moving objects of a scene, and their motions.
#[derive(Clone, Debug)]
pub struct Motion {
    movers: Vec<Mover>,
}

/// An object that moves.
#[derive(Clone, Debug)]
struct Mover {
    /// The index in the scene.
    index: u32,
    /// The object in the original scene.
    object: Object,
    act: Act,
    presence: Option<Presence>,
}

/// The times at which an object is present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Presence {
    period_frames: u32,
    away_frames: u32,
    phase_frames: u32,
}

impl Presence {
    fn new(random: &mut Random) -> Self {
        let period_frames = 40 + random.below(120);
        Self {
            period_frames,
            away_frames: 6 + random.below(period_frames / 4),
            phase_frames: random.below(period_frames),
        }
    }

    fn is_there(self, frame: u32) -> bool {
        let phase =
            (u64::from(frame) + u64::from(self.phase_frames)) % u64::from(self.period_frames);
        phase >= self.away_frames.into()
    }
}

impl Motion {
    /// Creates motions for `percent` of the objects of a scene, or for as many as can move without
    /// meeting others; the ground never moves. The same seed gives the same motion.
    ///
    /// # Errors
    /// [`MotionError::Percent`]; a scene that cannot be drawn.
    pub fn new(scene: &Scene, percent: u32, seed: u64) -> Result<Self, GeneratorError> {
        if percent > 100 {
            return Err(MotionError::Percent { percent }.into());
        }
        scene.validate()?;
        let wanted = (scene.objects.len() as u64 * u64::from(percent)).div_ceil(100) as usize;
        let mut motion = Self { movers: Vec::with_capacity(wanted) };
        if wanted == 0 {
            return Ok(motion);
        }
        let mut random = Random::keyed(seed, &[0x6d_6f74]);
        let mut room = Room::new(scene);
        let mut crowded = Vec::new();
        for index in order(scene, wanted, &mut random) {
            if motion.movers.len() == wanted {
                break;
            }
            let Some(object) = scene.objects.get(index as usize) else { continue };
            match room.act_for(scene, index, &mut random) {
                Some(act) => {
                    let comes_and_goes = random.below(MOVERS_PER_GUEST) == 0;
                    let presence = comes_and_goes.then(|| Presence::new(&mut random));
                    motion.movers.push(Mover { index, object: *object, act, presence });
                }
                None => crowded.push((index, *object)),
            }
        }
        let left = wanted - motion.movers.len();
        motion.movers.extend(crowded.into_iter().take(left).map(|(index, object)| Mover {
            index,
            object,
            act: Act::Stay,
            presence: Some(Presence::new(&mut random)),
        }));
        Ok(motion)
    }

    /// Returns the number of objects that move, or appear and vanish.
    pub fn movers(&self) -> usize {
        self.movers.len()
    }

    /// Returns the scene in a frame. Its objects are in the original order, without the absent
    /// ones.
    pub fn scene_at(&self, scene: &Scene, frame: u32) -> Scene {
        let mut objects: Vec<Option<Object>> = scene.objects.iter().copied().map(Some).collect();
        for mover in &self.movers {
            if let Some(place) = objects.get_mut(mover.index as usize) {
                *place = mover.at(frame);
            }
        }
        Scene { objects: objects.into_iter().flatten().collect(), ..scene.clone() }
    }
}

impl Mover {
    /// Returns the object in a frame; `None` while it is absent.
    fn at(&self, frame: u32) -> Option<Object> {
        let is_there = self.presence.is_none_or(|presence| presence.is_there(frame));
        is_there.then(|| Object {
            transform: self.act.transform(&self.object.transform, frame),
            ..self.object
        })
    }
}

/// Returns the objects in the order in which motions are searched for them: some big objects, then
/// all others.
fn order(scene: &Scene, wanted: usize, random: &mut Random) -> Vec<u32> {
    let is_ground =
        |object: &Object| scene.mesh_of(object).is_none_or(|mesh| mesh.name.starts_with(GROUND));
    let height = |index: &u32| {
        let object = scene.objects.get(*index as usize);
        let bounds = object.and_then(|object| scene.bounds_of(object));
        bounds.map_or(0.0, |bounds| bounds.max.y - bounds.min.y)
    };
    let numbered = (0_u32..).zip(&scene.objects);
    let mut all: Vec<u32> =
        numbered.filter(|(_, object)| !is_ground(object)).map(|(index, _)| index).collect();
    random.shuffle(&mut all);
    let big: Vec<u32> = all.iter().copied().filter(|index| height(index) > BIG_M).collect();
    let first = big.len().min(wanted.div_ceil(MOVERS_PER_BIG));
    let mut order = big[..first].to_vec();
    let mut is_first = vec![false; scene.objects.len()];
    for index in &order {
        is_first[*index as usize] = true;
    }
    order.extend(all.into_iter().filter(|index| !is_first[*index as usize]));
    order
}

/// The moving objects in the current state of a renderer: the present ones, with their ids.
#[derive(Clone, Debug)]
pub struct Cast {
    ids: Vec<Option<ObjectId>>,
    /// The objects that appear and the objects that vanish with the newest changes.
    coming: Vec<usize>,
    going: Vec<usize>,
    changes: Vec<ObjectChange>,
}

impl Cast {
    /// Creates the moving objects of `motion` for a renderer that shows the original scene.
    pub fn new(motion: &Motion) -> Self {
        let ids = motion.movers.iter().map(|mover| Some(ObjectId(mover.index)));
        Self { ids: ids.collect(), coming: Vec::new(), going: Vec::new(), changes: Vec::new() }
    }

    /// Returns the changes that make the renderer show `frame`. Then [`Cast::came`] must be called
    /// with the ids that the update returned for added objects.
    pub fn changes(&mut self, motion: &Motion, frame: u32) -> &[ObjectChange] {
        self.coming.clear();
        self.going.clear();
        self.changes.clear();
        let Self { ids, coming, going, changes } = self;
        let mut arrivals = Vec::new();
        let mut moves = Vec::new();
        for (place, (mover, id)) in motion.movers.iter().zip(&*ids).enumerate() {
            match (mover.at(frame), *id) {
                (None, Some(object)) => {
                    going.push(place);
                    changes.push(ObjectChange::Remove { object });
                }
                (Some(object), None) => {
                    coming.push(place);
                    arrivals.push(ObjectChange::Add { object });
                }
                (Some(there), Some(object)) if mover.act != Act::Stay => {
                    moves.push(ObjectChange::Move { object, transform: there.transform });
                }
                _ => {}
            }
        }
        // Removed objects make room for added ones.
        changes.append(&mut arrivals);
        changes.append(&mut moves);
        &self.changes
    }

    /// Records that the newest changes were applied, with the ids of the added objects.
    pub fn came(&mut self, added: &[ObjectId]) {
        for place in self.going.drain(..) {
            if let Some(id) = self.ids.get_mut(place) {
                *id = None;
            }
        }
        for (place, object) in self.coming.drain(..).zip(added) {
            if let Some(id) = self.ids.get_mut(place) {
                *id = Some(*object);
            }
        }
    }
}

#[cfg(test)]
mod tests;

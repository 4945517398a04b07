//! Places parts until the wanted number is reached.

use cull::ObjectId;
use glam::Affine3A;
use scene::{Mesh, MeshId, Object, pack_unorm};

use super::super::parts::{PartId, PartNode, PartTree};
use super::super::random::Random;

/// The meshes of a scene that is being generated.
#[derive(Default)]
pub(super) struct MeshList {
    pub(super) meshes: Vec<Mesh>,
}

impl MeshList {
    pub(super) fn add(&mut self, mesh: Mesh) -> MeshId {
        self.meshes.push(mesh);
        MeshId(self.meshes.len() as u32 - 1)
    }
}

/// The number of parts that may still be placed, and the placed parts.
pub(super) struct Placer {
    pub(super) objects: Vec<Object>,
    pub(super) parts: PartTree,
    pub(super) left: u32,
    pub(super) random: Random,
}

impl Placer {
    /// Places a part, unless no parts are left; its name is its kind and a number.
    pub(super) fn part(&mut self, group: PartId, what: &str, mesh: MeshId, place: Affine3A) {
        if self.left == 0 {
            return;
        }
        self.left -= 1;
        let object = ObjectId(self.objects.len() as u32);
        let name = format!("{what} {}", object.0);
        self.parts.add(PartNode { name, parent: Some(group), object: Some(object) });
        let shade = self.random.between(0.82, 1.0);
        let tint = pack_unorm([shade, shade, shade, 1.0]);
        self.objects.push(Object { mesh, transform: place, tint });
    }

    /// Returns a new group of parts, or the parent if no parts are left for it.
    pub(super) fn group(&mut self, name: String, parent: PartId) -> PartId {
        if self.left == 0 { parent } else { self.parts.group(name, parent) }
    }

    /// Calls `place`, but limits it to this number of parts.
    pub(super) fn at_most(&mut self, parts: u32, place: impl FnOnce(&mut Self)) {
        let kept = self.left.saturating_sub(parts);
        self.left -= kept;
        place(self);
        self.left += kept;
    }
}

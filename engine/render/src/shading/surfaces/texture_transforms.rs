//! The transforms of texture coordinates. Equal transforms share an entry.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::Affine2;
use scene::limits::MAX_TEXTURE_TRANSFORMS;

use crate::error::Error;
use crate::resources::limits;
use crate::shading::surfaces::marked::Marked;

/// The transform from texture coordinates to the coordinates of one texture, as `texels.glsl`
/// declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct TransformEntry {
    axes: [f32; 4],
    origin: [f32; 4],
}

const _: () = assert!(size_of::<TransformEntry>() == 32);

/// The numbers of texture transforms, with the count of the uses of each.
pub(crate) struct TextureTransforms {
    entries: Vec<TransformEntry>,
    users: Vec<u32>,
    numbers: HashMap<[u32; 6], u32>,
    /// The unused numbers, once the scene's transforms are [known](Self::keep_room).
    free: Vec<u32>,
    dirty: Marked,
}

impl TextureTransforms {
    /// Creates the permanent identity transform.
    pub(crate) fn new() -> Self {
        let mut transforms = Self {
            entries: Vec::new(),
            users: Vec::new(),
            numbers: HashMap::new(),
            free: Vec::new(),
            dirty: Marked::default(),
        };
        transforms.take(Affine2::IDENTITY);
        transforms
    }

    /// Refuses more transforms than there are numbers. Keeps room for up to `spare` more.
    pub(crate) fn keep_room(&mut self, spare: usize) -> Result<(), Error> {
        let used = self.entries.len();
        limits::check(
            "different texture transforms",
            used as u64 - 1,
            MAX_TEXTURE_TRANSFORMS as u64,
            "let materials share transforms, or bake them into texture coordinates",
        )?;
        let all = used.saturating_add(spare).min(MAX_TEXTURE_TRANSFORMS + 1);
        self.entries.resize(all, TransformEntry::zeroed());
        self.users.resize(all, 0);
        self.free = (used as u32..all as u32).rev().collect();
        self.dirty = Marked::none_of(all);
        Ok(())
    }

    /// Returns the transforms, followed by room for more.
    pub(crate) fn entries(&self) -> &[TransformEntry] {
        &self.entries
    }

    /// Refuses transforms for which there are no numbers left.
    pub(crate) fn check_room(
        &self,
        transforms: impl Iterator<Item = Affine2>,
    ) -> Result<(), Error> {
        let mut unknown: Vec<_> = transforms.map(key_of).collect();
        unknown.retain(|key| !self.numbers.contains_key(key));
        unknown.sort_unstable();
        unknown.dedup();
        if unknown.len() <= self.free.len() {
            return Ok(());
        }
        let [wanted, left] = [unknown.len(), self.free.len()].map(|count| count as u64);
        Err(Error::CapacityExceeded {
            what: "texture transforms that no material has",
            wanted,
            left,
        })
    }

    /// Returns the number of a transform for one more texture. There must be
    /// [room](Self::check_room).
    pub(crate) fn take(&mut self, transform: Affine2) -> u32 {
        let key = key_of(transform);
        let number = self.numbers.get(&key).copied().unwrap_or_else(|| self.number(key));
        if let Some(users) = self.users.get_mut(number as usize) {
            *users += 1;
        }
        number
    }

    /// Gives a new transform a number.
    fn number(&mut self, key: [u32; 6]) -> u32 {
        let [a, b, c, d, x, y] = key.map(f32::from_bits);
        let entry = TransformEntry { axes: [a, b, c, d], origin: [x, y, 0.0, 0.0] };
        let number = self.free.pop().unwrap_or(self.entries.len() as u32);
        match self.entries.get_mut(number as usize) {
            Some(there) => *there = entry,
            None => {
                self.entries.push(entry);
                self.users.push(0);
            }
        }
        self.numbers.insert(key, number);
        self.dirty.mark_dirty(number);
        number
    }

    /// Releases a transform that a texture used.
    pub(crate) fn free(&mut self, transform: Affine2) {
        let key = key_of(transform);
        let Some(number) = self.numbers.get(&key).copied() else { return };
        let Some(users) = self.users.get_mut(number as usize) else { return };
        *users = users.saturating_sub(1);
        if *users == 0 {
            self.numbers.remove(&key);
            self.free.push(number);
        }
    }

    /// Returns the transforms that the GPU does not have, with their numbers.
    pub(crate) fn dirty(&self) -> (&[u32], impl ExactSizeIterator<Item = TransformEntry> + '_) {
        let entry = |number: &u32| self.entries.get(*number as usize).copied();
        let entries = self.dirty.list().iter();
        (
            self.dirty.list(),
            entries.map(move |transform| entry(transform).unwrap_or_else(TransformEntry::zeroed)),
        )
    }

    /// Notes that the changed transforms are on the GPU.
    pub(crate) fn submitted(&mut self) {
        self.dirty.drain().for_each(drop);
    }
}

fn key_of(transform: Affine2) -> [u32; 6] {
    // An invalid transform would give texel coordinates that are not numbers.
    let transform = if transform.is_finite() { transform } else { Affine2::IDENTITY };
    transform.to_cols_array().map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, vec2};

    use super::*;

    #[test]
    fn equal_transforms_share_a_number_until_nobody_uses_it() {
        let scaled = |by: f32| Affine2::from_scale(Vec2::splat(by));
        let mut transforms = TextureTransforms::new();
        assert_eq!([2.0, 3.0, 2.0].map(|by| transforms.take(scaled(by))), [1, 2, 1]);
        transforms.keep_room(1).unwrap();
        assert_eq!(transforms.take(Affine2::IDENTITY), 0);
        assert!(transforms.dirty().0.is_empty(), "the GPU has those of the scene");
        let two = || [scaled(4.0), scaled(5.0)].into_iter();
        assert!(matches!(
            transforms.check_room(two()),
            Err(Error::CapacityExceeded { left: 1, .. })
        ));
        transforms.check_room([scaled(2.0), scaled(4.0), scaled(4.0)].into_iter()).unwrap();
        transforms.free(scaled(2.0));
        assert!(transforms.check_room(two()).is_err(), "another texture uses it");
        transforms.free(scaled(2.0));
        transforms.check_room(two()).unwrap();
        let mut taken = two().map(|key| transforms.take(key)).collect::<Vec<_>>();
        taken.sort_unstable();
        assert_eq!(taken, [1, 3]);
        assert_eq!(transforms.entries().len(), 4);
        assert_eq!(transforms.dirty().1.count(), 2);
        transforms.submitted();
        assert!(transforms.dirty().0.is_empty());
        transforms.free(Affine2::IDENTITY);
        transforms.free(Affine2::from_translation(vec2(9.0, 9.0)));
        assert_eq!(transforms.take(Affine2::IDENTITY), 0, "nothing is free that was not taken");
    }
}

//! The instances of a node's mesh, one or many (`EXT_mesh_gpu_instancing`).

use std::borrow::Cow;

use glam::{Affine3A, Quat, Vec3};

use super::numbers::rotation;
use crate::notes::Notes;
use crate::{Instancing, Source};

/// Returns the transform from each instance's space to its node's.
pub(super) fn locals(
    source: &Source,
    instancing: Option<Instancing>,
    notes: &mut Notes,
    place: impl Fn() -> String,
) -> Cow<'static, [Affine3A]> {
    let Some(given) = instancing else {
        return Cow::Borrowed(&[Affine3A::IDENTITY]);
    };
    let vectors =
        |accessor: Option<usize>| accessor.and_then(|accessor| source.floats::<3>(accessor));
    let translations = vectors(given.translation);
    let scales = vectors(given.scale);
    let rotations = given.rotation.and_then(|rotation| source.floats::<4>(rotation));
    let mut broken = 0;
    let mut local = |instance: usize| {
        let translation = translations.as_ref().and_then(|translations| translations.get(instance));
        let scale = scales.as_ref().and_then(|scales| scales.get(instance));
        let turn = rotations.as_ref().and_then(|rotations| rotations.get(instance));
        let turn = turn.map_or(Some(Quat::IDENTITY), |turn| rotation(*turn));
        if turn.is_none() {
            broken += 1;
        }
        Affine3A::from_scale_rotation_translation(
            scale.copied().map_or(Vec3::ONE, Vec3::from_array),
            turn.unwrap_or(Quat::IDENTITY),
            translation.copied().map_or(Vec3::ZERO, Vec3::from_array),
        )
    };
    let locals = (0..given.count).map(&mut local).collect();
    notes.count("an instance has a rotation of length 0, and is not turned", broken, place);
    Cow::Owned(locals)
}

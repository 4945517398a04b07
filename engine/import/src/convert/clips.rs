//! Clips: the animations of the file, as tracks that need no further checks.

use animation::{Channel, Clip, Interpolation, RigNodeId, Track, TrackError, Values};
use glam::{Quat, Vec3};
use gltf::animation::Property;
use gltf::json;
use gltf::json::validation::Checked;

use super::nodes::Tree;
use super::numbers::rotation;
use crate::error::{Reason, quoted};
use crate::losses::Losses;
use crate::notes::Notes;
use crate::{ImportError, Source};

/// Returns all animations of the file that change the scene. Animations are left out and noted if
/// times or values are not finite, or times are not strictly ascending.
///
/// # Errors
/// The first such animation, if broken parts are refused.
pub(super) fn clips(
    source: &Source,
    tree: &Tree,
    losses: &mut Losses,
    notes: &mut Notes,
) -> Result<Vec<Clip>, ImportError> {
    let mut clips = Vec::new();
    for (number, animation) in source.document.as_json().animations.iter().enumerate() {
        // Empty animations were noted before.
        if animation.samplers.is_empty() {
            continue;
        }
        let name = animation.name.clone().unwrap_or_default();
        let name = if name.is_empty() { format!("animation {number}") } else { name };
        let place = || format!("animation {number} ({})", quoted(&name));
        let reader = Reader { source, animation, tree, place: &place };
        match reader.channels(notes) {
            Ok(channels) if channels.is_empty() => {
                let what = "it moves nothing in the scene, and is left out";
                notes.count(what, 1, || quoted(&name));
            }
            Ok(channels) => clips.push(Clip { name, channels }),
            Err((sampler, error)) => {
                let object = format!("{}, sampler {sampler}", place());
                let fault = Reason::malformed(error.to_string()).of(object);
                let noted = losses.repair(fault, "the animation is not played", notes);
                noted.map_err(|fault| fault.in_file(&source.file))?;
            }
        }
    }
    Ok(clips)
}

struct Reader<'a> {
    source: &'a Source,
    animation: &'a json::Animation,
    tree: &'a Tree,
    place: &'a dyn Fn() -> String,
}

impl Reader<'_> {
    /// Reads all channels.
    fn channels(&self, notes: &mut Notes) -> Result<Vec<Channel>, (usize, TrackError)> {
        let mut channels = Vec::with_capacity(self.animation.channels.len());
        let mut known = std::collections::HashSet::new();
        for given in &self.animation.channels {
            let Some(node) = self.tree.id_of(given.target.node.value()) else { continue };
            let Checked::Valid(property) = given.target.path else { continue };
            if !known.insert((node, property as u8)) {
                let what = "a channel moves what another one moves, and is left out";
                notes.count(what, 1, self.place);
                continue;
            }
            let sampler = given.sampler.value();
            let track = self.track(sampler, property, node, notes);
            if let Some(track) = track.map_err(|error| (sampler, error))? {
                channels.push(Channel { node, track });
            }
        }
        Ok(channels)
    }

    fn track(
        &self,
        sampler: usize,
        property: Property,
        node: RigNodeId,
        notes: &mut Notes,
    ) -> Result<Option<Track>, TrackError> {
        let Some(sampler) = self.animation.samplers.get(sampler) else {
            return Ok(None);
        };
        let interpolation = match sampler.interpolation {
            Checked::Valid(gltf::animation::Interpolation::Step) => Interpolation::Step,
            Checked::Valid(gltf::animation::Interpolation::CubicSpline) => Interpolation::Cubic,
            Checked::Valid(gltf::animation::Interpolation::Linear) | Checked::Invalid => {
                Interpolation::Linear
            }
        };
        let targets = self.tree.node(node).map_or(0, |node| node.weights.len());
        let output = sampler.output.value();
        let values = match property {
            Property::Translation => Values::Translation(self.vectors(output)),
            Property::Scale => Values::Scale(self.vectors(output)),
            Property::Rotation => Values::Rotation(self.rotations(output, interpolation, notes)),
            Property::MorphTargetWeights if targets == 0 => {
                notes.count(
                    "a channel moves weights of a node without morph targets, and is left out",
                    1,
                    self.place,
                );
                return Ok(None);
            }
            Property::MorphTargetWeights => Values::Weights(
                self.source.floats::<1>(output).unwrap_or_default().into_flattened(),
            ),
        };
        let times_s = self.source.floats::<1>(sampler.input.value()).unwrap_or_default();
        let times_s = times_s.into_flattened();
        let early = times_s.iter().filter(|time_s| **time_s < 0.0).count();
        notes.count("a key is before 0 s, which is where playing begins", early, self.place);
        match Track::new(interpolation, times_s, values, targets) {
            Ok(track) => Ok(Some(track)),
            // glTF allows such numbers.
            Err(TrackError::TooLarge { .. } | TrackError::TooLate { .. }) => {
                let what = "a channel has times or values beyond 1e9, and is left out";
                notes.count(what, 1, self.place);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    fn vectors(&self, accessor: usize) -> Vec<Vec3> {
        let values = self.source.floats::<3>(accessor).unwrap_or_default();
        values.into_iter().map(Vec3::from_array).collect()
    }

    /// Returns keys as rotations of any length; [`Track::new`] finds keys that are not finite.
    fn rotations(
        &self,
        accessor: usize,
        interpolation: Interpolation,
        notes: &mut Notes,
    ) -> Vec<Quat> {
        let values = self.source.floats::<4>(accessor).unwrap_or_default();
        let mut broken = 0;
        let turned = values.into_iter().enumerate().map(|(place, parts)| {
            // In cubic tracks, only the second of three values is a rotation; tangents have any
            // length.
            let is_tangent = interpolation == Interpolation::Cubic && place % 3 != 1;
            if is_tangent || parts.iter().any(|part| !part.is_finite()) {
                return Quat::from_array(parts);
            }
            rotation(parts).unwrap_or_else(|| {
                broken += 1;
                Quat::IDENTITY
            })
        });
        let turned = turned.collect();
        notes.count("a key is a rotation of length 0, taken as none", broken, self.place);
        turned
    }
}

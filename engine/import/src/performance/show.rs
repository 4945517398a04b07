//! A moment shown by the renderer.

use std::time::{Duration, Instant};

use render::scene::ObjectChange;
use render::{Error, Renderer};

use super::{BlendedMove, Changes, Deformation, LightMove, ObjectMove, Performance};

/// Lists in the making, kept to allocate nothing.
#[derive(Default)]
pub(super) struct Scratch {
    objects: Vec<ObjectChange>,
}

impl Performance {
    /// Shows everything in `renderer`, which shows the file's scene, as it is at a time; answers what time
    /// that took the CPU. The next frame shows it.
    ///
    /// # Errors
    /// When the renderer refuses a change, for instance because someone else removed an object.
    pub fn show(&mut self, renderer: &mut Renderer, seconds: f64) -> Result<Duration, Error> {
        let began = Instant::now();
        let mut scratch = std::mem::take(&mut self.show);
        let brought = scratch.bring(self.changes(seconds), renderer);
        self.show = scratch;
        brought.map(|()| began.elapsed())
    }
}

impl Scratch {
    fn bring(&mut self, changes: &Changes, renderer: &mut Renderer) -> Result<(), Error> {
        self.objects.clear();
        let change = |moved: &ObjectMove| {
            let ObjectMove { object, transform, bounds } = *moved;
            match bounds {
                Some(bounds) => ObjectChange::Reshape { object, transform, bounds },
                None => ObjectChange::Move { object, transform },
            }
        };
        self.objects.extend(changes.objects.iter().map(change));
        if !self.objects.is_empty() {
            renderer.update(&self.objects)?;
        }
        for Deformation { deformer, joints, weights } in &changes.deformations {
            let joints = changes.joints.get(joints.clone()).unwrap_or_default();
            let weights = changes.weights.get(weights.clone()).unwrap_or_default();
            renderer.deform(*deformer, joints, weights)?;
        }
        for BlendedMove { blended, transform, bounds } in &changes.blended {
            renderer.move_blended(*blended, *transform, *bounds)?;
        }
        for LightMove { light, to } in &changes.lights {
            renderer.set_light(*light, *to)?;
        }
        Ok(())
    }
}

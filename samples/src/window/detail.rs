//! The choice of levels of detail, by distance and on request by visible samples.

use antumbra::cull::{Camera, DetailBySamples, DetailPolicy, ObjectId};
use antumbra::render::{DetailView, RenderView, Renderer};
use antumbra::scene::Scene;
use bench::run_error::RunError;

/// The most objects whose visible samples are counted: the objects with the most triangles. Each
/// costs two or three small draws.
const MOST_COUNTED: usize = 128;

/// The rule by which objects of a scene use coarser levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    policy: DetailPolicy,
    /// The objects whose samples are counted.
    heavy: Vec<ObjectId>,
}

impl Detail {
    /// Creates the rule by distance for a scene with levels. Surfaces may be misplaced by
    /// `error_pixels`.
    pub fn new(scene: &Scene, error_pixels: f32) -> Self {
        let levels = scene.surfaces.as_ref().map_or(&[][..], |surfaces| &surfaces.levels);
        let has_levels =
            |mesh: u32| levels.get(mesh as usize).is_some_and(|level| !level.is_empty());
        let objects = (0..).map(ObjectId).zip(&scene.objects);
        let objects = objects.filter(|(_, object)| has_levels(object.mesh.0));
        let triangles = |object| scene.mesh_of(object).map_or(0, |mesh| mesh.indices.len() / 3);
        let mut heavy: Vec<(usize, ObjectId)> =
            objects.map(|(id, object)| (triangles(object), id)).collect();
        heavy.sort_by_key(|(triangles, id)| (usize::MAX - triangles, id.0));
        heavy.truncate(MOST_COUNTED);
        Self {
            policy: DetailPolicy { error_pixels, ..DetailPolicy::default() },
            heavy: heavy.into_iter().map(|(_, id)| id).collect(),
        }
    }

    /// Returns the rule with visible samples taken into account.
    pub fn by_samples(mut self) -> Self {
        self.policy.by_samples = Some(DetailBySamples::default());
        self
    }

    /// Switches whether visible samples are taken into account. Returns a message about it.
    pub fn toggle(&mut self) -> String {
        match self.policy.by_samples.take() {
            Some(_) => "detail by distance alone".to_owned(),
            None => {
                self.policy.by_samples = Some(DetailBySamples::default());
                format!("detail by visible samples of {} objects, too", self.heavy.len())
            }
        }
    }

    /// Makes a view count the samples that the rule needs.
    ///
    /// # Errors
    /// A device that cannot count samples; then none are counted.
    pub fn watch(&self, view: &mut RenderView) -> Result<(), RunError> {
        let counted = self.policy.by_samples.map_or(&[][..], |_| &self.heavy);
        Ok(view.watch(counted)?)
    }

    /// Selects the levels that are fine enough for `camera` in `view`.
    ///
    /// # Errors
    /// A view of another renderer.
    pub fn choose(
        &self,
        renderer: &mut Renderer,
        camera: Camera,
        view: &RenderView,
    ) -> Result<(), RunError> {
        renderer.choose_detail_seen(&[DetailView { camera, state: view }], &self.policy)?;
        Ok(())
    }

    /// Returns a description of the rule.
    pub fn text(&self) -> String {
        let by = if self.policy.by_samples.is_some() { "samples" } else { "distance" };
        format!("{} px, by {by}", self.policy.error_pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::glam::Vec3;
    use antumbra::scene::{LodLevel, Mesh, MeshId, Object};

    #[test]
    fn the_objects_with_the_most_triangles_are_counted() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner.to_array());
        let mesh = |triangles: usize| {
            let mut mesh = Mesh::of_triangles("mesh", &corners.map(|corner| (corner, [1.0; 3])));
            mesh.indices = mesh.indices.repeat(triangles);
            mesh
        };
        let mut scene = Scene::single(mesh(1));
        scene.meshes = vec![mesh(2), mesh(9), mesh(5)];
        let object = scene.objects[0];
        let objects = [0, 1, 2, 0, 2].map(|mesh| Object { mesh: MeshId(mesh), ..object });
        scene.objects = objects.repeat(60);
        let mut scene = scene.with_surfaces();
        let level = || vec![LodLevel { indices: vec![0, 1, 2], error_m: 0.1 }];
        scene.surfaces.as_mut().unwrap().levels = vec![level(), vec![], level()];
        let mut detail = Detail::new(&scene, 2.0);
        assert_eq!(detail.heavy.len(), MOST_COUNTED);
        assert_eq!(detail.heavy[..4], [2, 4, 7, 9].map(ObjectId));
        assert_eq!(detail.heavy[120..123], [0, 3, 5].map(ObjectId), "the lighter ones follow");
        assert_eq!(detail.text(), "2 px, by distance");
        assert!(detail.toggle().contains("samples of 128 objects"));
        assert_eq!(detail, Detail::new(&scene, 2.0).by_samples());
        assert_eq!(detail.text(), "2 px, by samples");
        assert!(detail.toggle().contains("distance alone"));
    }
}

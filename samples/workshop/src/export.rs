//! Exports everything that is shown as a binary glTF 2.0 file: the tree of parts with their
//! transforms, the colours of vertices, and the materials without textures.

use std::borrow::Cow;
use std::collections::BTreeMap;

use antumbra::ObjectId;
use antumbra::cull::Aabb;
use antumbra::glam::{Affine3A, Mat4, Vec3};
use antumbra::scene::{Mesh, MeshId, pack_normal, unpack_normal};
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::Target;
use gltf::json::extensions::material::{EmissiveStrength, EmissiveStrengthFactor};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked::Valid;
use gltf::json::validation::USize64;
use gltf::json::{self, Accessor, Buffer, Index, Material, Node, Root, buffer};
use scenes::PartNode;
use thiserror::Error;

use crate::document::{Display, Document};

/// The reason why a model cannot be exported.
#[derive(Debug, Error)]
pub enum ExportError {
    /// No opaque part is shown.
    #[error("no opaque part is shown, so there is nothing to export: show one first")]
    Nothing,
    /// A failure of the writer, for example a file of more than 4 GiB.
    #[error("cannot write the model as glTF: {0}")]
    Writing(String),
}

/// Returns the file of all parts that are not hidden.
///
/// # Errors
/// [`ExportError::Nothing`]; a file of more than 4 GiB.
pub fn glb(document: &Document) -> Result<Vec<u8>, ExportError> {
    let is_shown = |object: &ObjectId| document.display(*object) != Display::Hidden;
    let shown: Vec<ObjectId> = document.objects().filter(is_shown).collect();
    if shown.is_empty() {
        return Err(ExportError::Nothing);
    }
    let mut writer = Writer::default();
    let mut meshes: BTreeMap<(MeshId, Winding), Index<json::Mesh>> = BTreeMap::new();
    let mut nodes: Vec<Option<Index<Node>>> = vec![None; document.parts.nodes.len()];
    for (place, part) in document.parts.nodes.iter().enumerate() {
        let Some(object) = part.object.filter(is_shown) else { continue };
        let Some(mesh) = document.mesh(object) else { continue };
        let id = document.scene.objects[object.0 as usize].mesh;
        let mut transform = document.transform(object);
        let mesh = if is_sheared(&transform) {
            // A node cannot have such a matrix, so the vertices are transformed.
            let placed = placed(mesh, &std::mem::take(&mut transform));
            writer.mesh(document, id, &placed, Winding::Kept)
        } else {
            let winding = Winding::under(&transform);
            let known = meshes.entry((id, winding));
            *known.or_insert_with(|| writer.mesh(document, id, mesh, winding))
        };
        let matrix = Mat4::from(transform);
        // A node without a matrix is at the origin.
        let matrix = (matrix != Mat4::IDENTITY).then(|| matrix.to_cols_array());
        let node = Node { matrix, mesh: Some(mesh), ..named(part) };
        nodes[place] = Some(writer.root.push(node));
    }
    let roots = writer.groups(&document.parts.nodes, nodes);
    writer.place(&roots, document.origin_m.as_vec3());
    let scene = json::Scene { name: None, nodes: roots, extensions: None, extras: None };
    writer.root.scene = Some(writer.root.push(scene));
    writer.finish()
}

/// The winding of a mesh's triangles in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Winding {
    /// The winding in the engine.
    Kept,
    /// Reversed: in glTF, the front faces of nodes that mirror are clockwise (glTF 2.0, 3.7.4). The
    /// engine does not reverse them.
    Reversed,
}

impl Winding {
    /// Returns the winding for nodes with a transform.
    fn under(transform: &Affine3A) -> Self {
        if transform.matrix3.determinant() < 0.0 { Self::Reversed } else { Self::Kept }
    }
}

/// Returns true unless a transform is a scale, followed by a rotation and a translation, as nodes
/// require.
fn is_sheared(transform: &Affine3A) -> bool {
    let (scale, rotation, translation) = transform.to_scale_rotation_translation();
    let again = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
    // Somewhat less than the tolerance of the glTF validator.
    !again.abs_diff_eq(*transform, 1.0e-5)
}

/// Returns a mesh whose vertices are transformed to the world.
fn placed(mesh: &Mesh, transform: &Affine3A) -> Mesh {
    let of_normals = transform.matrix3.inverse().transpose();
    let mut placed = mesh.clone();
    placed.bounds = Aabb::EMPTY;
    for vertex in &mut placed.vertices {
        let position = transform.transform_point3(vertex.position.into());
        vertex.position = position.to_array();
        vertex.normal =
            pack_normal((of_normals * unpack_normal(vertex.normal)).normalize_or_zero());
        placed.bounds = placed.bounds.union(&Aabb::new(position, position));
    }
    placed
}

/// Returns a sentence about shown parts that are missing in the [file](glb), if there are any.
pub fn left_out(document: &Document) -> Option<String> {
    let objects = match document.transparent().len() {
        0 => None,
        1 => Some("a transparent object is left out: it is not a part".to_owned()),
        count => Some(format!("{count} transparent objects are left out: they are not parts")),
    };
    let is_textured = |object: ObjectId| {
        let surfaces = document.scene.surfaces.as_ref()?;
        let mesh = document.scene.objects[object.0 as usize].mesh;
        let surface = surfaces.meshes.get(mesh.0 as usize)?;
        let material = surfaces.materials.get(surface.material.0 as usize)?;
        Some(material.textures().next().is_some())
    };
    let shown = document.objects().filter(|object| document.display(*object) != Display::Hidden);
    let textured = shown.filter(|object| is_textured(*object) == Some(true)).count();
    let textures = (textured > 0).then(|| format!("the textures of {textured} parts are left out"));
    let sentences: Vec<String> = objects.into_iter().chain(textures).collect();
    (!sentences.is_empty()).then(|| sentences.join("; "))
}

fn named(part: &PartNode) -> Node {
    Node { name: Some(part.name.clone()), ..Node::default() }
}

/// A file that is being written.
#[derive(Default)]
struct Writer {
    root: Root,
    bytes: Vec<u8>,
}

impl Writer {
    /// Adds a node per group that is not empty. Returns the nodes without a parent.
    fn groups(
        &mut self,
        parts: &[PartNode],
        mut nodes: Vec<Option<Index<Node>>>,
    ) -> Vec<Index<Node>> {
        let mut children: Vec<Vec<Index<Node>>> = vec![Vec::new(); parts.len()];
        let mut roots = Vec::new();
        // Parents precede their children.
        for (place, part) in parts.iter().enumerate().rev() {
            let inside = std::mem::take(&mut children[place]);
            if nodes[place].is_none() && !inside.is_empty() {
                let children = Some(inside.into_iter().rev().collect());
                nodes[place] = Some(self.root.push(Node { children, ..named(part) }));
            }
            let Some(node) = nodes[place] else { continue };
            match part.parent {
                Some(parent) => children[parent.0 as usize].push(node),
                None => roots.push(node),
            }
        }
        roots
    }

    /// Moves nodes. The coordinates of their descendants stay small.
    fn place(&mut self, nodes: &[Index<Node>], by_m: Vec3) {
        if by_m == Vec3::ZERO {
            return;
        }
        for node in nodes {
            let Some(node) = self.root.nodes.get_mut(node.value()) else { continue };
            match &mut node.matrix {
                Some([.., x, y, z, _]) => {
                    *x += by_m.x;
                    *y += by_m.y;
                    *z += by_m.z;
                }
                None => node.translation = Some(by_m.to_array()),
            }
        }
    }

    /// Adds a mesh of the document's scene.
    fn mesh(
        &mut self,
        document: &Document,
        id: MeshId,
        mesh: &Mesh,
        winding: Winding,
    ) -> Index<json::Mesh> {
        let positions = mesh.vertices.iter().flat_map(|vertex| vertex.position);
        let positions = self.floats(positions, mesh.vertices.len());
        if let Some(accessor) = self.root.accessors.get_mut(positions.value()) {
            accessor.min = Some(json::Value::from(mesh.bounds.min.to_array().to_vec()));
            accessor.max = Some(json::Value::from(mesh.bounds.max.to_array().to_vec()));
        }
        let normal = |packed: u32| unpack_normal(packed).normalize_or(antumbra::glam::Vec3::Y);
        let normals = mesh.vertices.iter().flat_map(|vertex| normal(vertex.normal).to_array());
        let normals = self.floats(normals, mesh.vertices.len());
        let colours = mesh.vertices.iter().flat_map(|vertex| {
            let [red, green, blue, _] = vertex.colour.to_le_bytes();
            [red, green, blue, u8::MAX]
        });
        let view = self.view(colours, Target::ArrayBuffer);
        let colours = self.root.push(Accessor {
            normalized: true,
            ..accessor(view, ComponentType::U8, Type::Vec4, mesh.vertices.len())
        });
        let corners = mesh.indices.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| match winding {
            Winding::Kept => [*a, *b, *c],
            Winding::Reversed => [*a, *c, *b],
        });
        let view = self.view(corners.flat_map(u32::to_le_bytes), Target::ElementArrayBuffer);
        let indices = accessor(view, ComponentType::U32, Type::Scalar, mesh.indices.len());
        let primitive = Primitive {
            attributes: BTreeMap::from([
                (Valid(Semantic::Positions), positions),
                (Valid(Semantic::Normals), normals),
                (Valid(Semantic::Colors(0)), colours),
            ]),
            indices: Some(self.root.push(indices)),
            material: Some(self.material(document, id)),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        };
        let name = Some(mesh.name.clone());
        let primitives = vec![primitive];
        self.root.push(json::Mesh {
            name,
            primitives,
            weights: None,
            extensions: None,
            extras: None,
        })
    }

    fn material(&mut self, document: &Document, id: MeshId) -> Index<Material> {
        let surfaces = document.scene.surfaces.as_ref();
        let of = surfaces.and_then(|surfaces| {
            let material = surfaces.meshes.get(id.0 as usize)?.material;
            surfaces.materials.get(material.0 as usize)
        });
        let mut material = Material::default();
        material.pbr_metallic_roughness.metallic_factor.0 = of.map_or(0.0, |of| of.metallic);
        material.pbr_metallic_roughness.roughness_factor.0 = of.map_or(1.0, |of| of.roughness);
        if let Some(of) = of {
            material.name = Some(of.name.clone());
            // Vertex colours already include the material's colour, except its opacity.
            let [.., alpha] = of.base_colour;
            material.pbr_metallic_roughness.base_color_factor.0 = [1.0, 1.0, 1.0, alpha];
            let strength = of.emission.into_iter().fold(1.0, f32::max);
            material.emissive_factor.0 = of.emission.map(|part| (part / strength).max(0.0));
            if strength > 1.0 {
                material.extensions = Some(json::extensions::material::Material {
                    emissive_strength: Some(EmissiveStrength {
                        emissive_strength: EmissiveStrengthFactor(strength),
                    }),
                    ..json::extensions::material::Material::default()
                });
                let used = &mut self.root.extensions_used;
                let name = "KHR_materials_emissive_strength".to_owned();
                if !used.contains(&name) {
                    used.push(name);
                }
            }
        }
        self.root.push(material)
    }

    /// Adds vectors of three floats.
    fn floats(&mut self, of: impl Iterator<Item = f32>, count: usize) -> Index<Accessor> {
        let view = self.view(of.flat_map(f32::to_le_bytes), Target::ArrayBuffer);
        self.root.push(accessor(view, ComponentType::F32, Type::Vec3, count))
    }

    /// Adds bytes at an offset that is a multiple of four.
    fn view(&mut self, of: impl Iterator<Item = u8>, target: Target) -> Index<buffer::View> {
        let first = self.bytes.len();
        self.bytes.extend(of);
        let length = self.bytes.len() - first;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(buffer::View {
            name: None,
            buffer: Index::new(0),
            byte_length: USize64::from(length),
            byte_offset: Some(USize64::from(first)),
            byte_stride: None,
            target: Some(Valid(target)),
            extensions: None,
            extras: None,
        })
    }

    fn finish(mut self) -> Result<Vec<u8>, ExportError> {
        let writing = |error: &dyn std::fmt::Display| ExportError::Writing(error.to_string());
        self.root.push(Buffer {
            name: None,
            byte_length: USize64::from(self.bytes.len()),
            uri: None,
            extensions: None,
            extras: None,
        });
        self.root.asset.generator = Some("Antumbra workshop".to_owned());
        let json = self.root.to_vec().map_err(|error| writing(&error))?;
        let glb = Glb {
            // The writer computes the length.
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: Cow::Owned(json),
            bin: Some(Cow::Owned(self.bytes)),
        };
        glb.to_vec().map_err(|error| writing(&error))
    }
}

fn accessor(
    view: Index<buffer::View>,
    component: ComponentType,
    shape: Type,
    count: usize,
) -> Accessor {
    Accessor {
        name: None,
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Valid(GenericComponentType(component)),
        type_: Valid(shape),
        min: None,
        max: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: None,
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use antumbra::import::{LoadOptions, load_bytes};

    use super::*;

    #[test]
    fn what_was_exported_is_read_back_by_other_readers() {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let hidden = document.find("lid").unwrap();
        document.set_display(&hidden, Display::Hidden);
        let bytes = glb(&document).unwrap();

        let read = gltf::Gltf::from_slice(&bytes).unwrap();
        let nodes = read.nodes().filter(|node| node.mesh().is_some()).count();
        assert_eq!(nodes, document.scene.objects.len() - hidden.len());
        let names: Vec<&str> = read.nodes().filter_map(|node| node.name()).collect();
        assert!(names.contains(&"lower plate") && !names.contains(&"upper plate"), "{names:?}");

        let mut progress = |_| ControlFlow::Continue(());
        let loaded = load_bytes(bytes, None, &LoadOptions::default(), &mut progress).unwrap();
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        assert_eq!(loaded.scene.objects.len(), nodes);
        let found = loaded.bounds();
        let expected = document.shown_bounds();
        assert!((found.min - expected.min).length() < 1e-4, "{found:?} {expected:?}");
        assert!((found.max - expected.max).length() < 1e-4, "{found:?} {expected:?}");
    }

    /// Returns six times the volume that each object of a scene encloses, negative if its triangles
    /// face inwards.
    fn volumes(scene: &antumbra::scene::Scene) -> Vec<f32> {
        let volume = |object: &antumbra::scene::Object| {
            let mesh = scene.mesh_of(object).unwrap();
            let corner = |index: u32| {
                let position = mesh.vertices[index as usize].position;
                object.transform.transform_point3(position.into())
            };
            let corners = mesh.indices.as_chunks::<3>().0.iter();
            corners.map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c)))).sum()
        };
        scene.objects.iter().map(volume).collect()
    }

    #[test]
    fn mirrored_parts_are_not_turned_inside_out() {
        let grey = [0.5; 3];
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|at| (at, grey));
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let corners: Vec<([f32; 3], [f32; 3])> =
            faces.as_flattened().iter().map(|index: &usize| corners[*index]).collect();
        let mut scene = antumbra::scene::Scene::single(Mesh::of_triangles("part", &corners));
        let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let mut sheared = mirror;
        sheared.matrix3.x_axis.y = 0.5;
        let rest = scene.objects[0];
        for transform in [mirror, sheared] {
            scene.objects.push(antumbra::scene::Object { transform, ..rest });
        }
        let nodes = (0..3).map(|index: u32| PartNode {
            name: format!("part {index}"),
            parent: None,
            object: Some(ObjectId(index)),
        });
        let parts = scenes::PartTree { nodes: nodes.collect() };
        let shown = volumes(&scene);
        assert!(shown[0] > 0.0 && shown[1] < 0.0 && shown[2] < 0.0, "{shown:?}");
        let bytes = glb(&Document::new(scene, parts, None)).unwrap();
        let mut progress = |_| ControlFlow::Continue(());
        let loaded = load_bytes(bytes, None, &LoadOptions::default(), &mut progress).unwrap();
        let mut found = volumes(&loaded.scene);
        found.reverse();
        assert_eq!(found, shown, "the last part comes first");
    }

    #[test]
    fn colours_light_and_sheared_parts_are_what_they_were_after_a_round_trip() {
        let colour = [0.5, 0.25, 0.75];
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::of_triangles("part", &corners.map(|corner| (corner, colour)));
        let mut scene = antumbra::scene::Scene::single(mesh).with_surfaces();
        // In the way that the engine stores what a node mirrors.
        scene.meshes[0].indices.swap(1, 2);
        let material = &mut scene.surfaces.as_mut().unwrap().materials[0];
        material.base_colour = [0.5, 0.25, 0.75, 1.0];
        material.emission = [0.1, 0.2, 0.3];
        let turned = Affine3A::from_rotation_z(0.5);
        // A scale after a rotation, with a mirror: no node can have such a matrix.
        scene.objects[0].transform =
            Affine3A::from_scale(antumbra::glam::Vec3::new(-2.0, 1.0, 1.0)) * turned;
        let before = scene.clone();
        let parts = scenes::PartTree {
            nodes: vec![PartNode {
                name: "part".to_owned(),
                parent: None,
                object: Some(ObjectId(0)),
            }],
        };
        let document = Document::new(scene, parts, None);
        let bytes = glb(&document).unwrap();
        let read = gltf::Gltf::from_slice(&bytes).unwrap();
        let node = read.nodes().next().unwrap();
        assert_eq!(node.transform().matrix(), Mat4::IDENTITY.to_cols_array_2d());
        let mut progress = |_| ControlFlow::Continue(());
        let loaded = load_bytes(bytes, None, &LoadOptions::default(), &mut progress).unwrap();
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        let found = &loaded.scene.meshes[0].vertices;
        assert_eq!(found.len(), 3);
        for (found, vertex) in found.iter().zip(&before.meshes[0].vertices) {
            assert_eq!(found.colour & 0xff_ffff, vertex.colour & 0xff_ffff);
            let place = before.objects[0].transform.transform_point3(vertex.position.into());
            assert!(place.distance(found.position.into()) < 1e-5);
        }
        let [a, b, c] = loaded.scene.meshes[0].indices[..3] else { panic!() };
        let corner = |index: u32| antumbra::glam::Vec3::from(found[index as usize].position);
        let facing = (corner(b) - corner(a)).cross(corner(c) - corner(a));
        assert!(facing.dot(unpack_normal(found[0].normal)) > 0.0, "it faces where it faced");
        let material = &loaded.scene.surfaces.as_ref().unwrap().materials[0];
        assert!((material.emission[1] - 0.2).abs() < 1e-6);
    }

    #[test]
    fn nothing_shown_is_nothing_exported() {
        let made = scenes::waffle_maker();
        let mut document = Document::new(made.scene, made.parts, None);
        let all: Vec<ObjectId> = document.objects().collect();
        document.set_display(&all, Display::Hidden);
        assert!(matches!(glb(&document), Err(ExportError::Nothing)));
    }
}

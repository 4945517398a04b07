//! The tree of parts of a file: its nodes that contain shown objects.

use std::collections::HashMap;

use antumbra::ObjectId;
use antumbra::animation::{RigNode, RigNodeId};
use antumbra::import::GltfScene;
use antumbra::scene::{MeshId, Object};
use scenes::{PartId, PartNode, PartTree};

/// Returns the parts of a file, grouped by nodes. A node with exactly one object and no descendants
/// with objects is a part; other nodes are groups. Parts without a name get the name of their mesh.
pub fn file_parts(file: &GltfScene) -> PartTree {
    let nodes = file.rig.nodes();
    let mut objects: Vec<Vec<ObjectId>> = vec![Vec::new(); nodes.len()];
    let mut homeless = Vec::new();
    for object in (0..file.scene.objects.len() as u32).map(ObjectId) {
        let node = file.object_nodes.get(object.0 as usize);
        match node.and_then(|node| objects.get_mut(node.0 as usize)) {
            Some(of_node) => of_node.push(object),
            None => homeless.push(object),
        }
    }
    let mut tree = vec![PartNode { name: file.scene.name.clone(), parent: None, object: None }];
    let within = within(file, &objects);
    let mut part_of_node: Vec<Option<PartId>> = vec![None; nodes.len()];
    for id in file.rig.order() {
        let place = id.0 as usize;
        let Some(node) = nodes.get(place).filter(|_| within[place] > 0) else { continue };
        let parent = node.parent.and_then(|parent| part_of_node[parent.0 as usize]);
        let parent = parent.unwrap_or(PartId(0));
        part_of_node[place] = Some(PartId(tree.len() as u32));
        let own = &objects[place];
        if let ([object], 1) = (own.as_slice(), within[place]) {
            tree.push(PartNode { parent: Some(parent), ..part(file, *object, Some(node)) });
            continue;
        }
        let name = if node.name.is_empty() { format!("node {place}") } else { node.name.clone() };
        let group = PartId(tree.len() as u32);
        tree.push(PartNode { name, parent: Some(parent), object: None });
        // The primitives of a mesh have the name of their node and a number.
        tree.extend((1..).zip(own).map(|(number, object): (u32, _)| {
            let part = part(file, *object, Some(node));
            let name = if own.len() > 1 { format!("{}, {number}", part.name) } else { part.name };
            PartNode { name, parent: Some(group), object: Some(*object) }
        }));
    }
    let parts = homeless.into_iter().map(|object| part(file, object, None));
    tree.extend(parts.map(|part| PartNode { parent: Some(PartId(0)), ..part }));
    PartTree { nodes: tree }
}

/// Returns the body of each object of a file. The primitives of one mesh at one place are a body;
/// each further instance of the mesh is another body.
pub fn file_bodies(file: &GltfScene) -> Vec<u32> {
    let mut count_of_mesh: HashMap<(RigNodeId, [u32; 12], MeshId), u32> = HashMap::new();
    let mut body_at: HashMap<(RigNodeId, [u32; 12], u32), u32> = HashMap::new();
    let objects = (0..).zip(file.scene.objects.iter().zip(&file.object_nodes));
    let body_of = |(number, (object, node)): (u32, (&Object, &RigNodeId))| {
        let place = object.transform.to_cols_array().map(f32::to_bits);
        // Two objects with the same mesh at the same place are two instances.
        let count = count_of_mesh.entry((*node, place, object.mesh)).or_default();
        let instance = std::mem::replace(count, *count + 1);
        *body_at.entry((*node, place, instance)).or_insert(number)
    };
    objects.map(body_of).collect()
}

/// Returns the part of an object, with the name of its node, or of its mesh if the node has none.
fn part(file: &GltfScene, object: ObjectId, node: Option<&RigNode>) -> PartNode {
    let of_node = node.map(|node| node.name.clone()).filter(|name| !name.is_empty());
    let of_mesh = || {
        let object = file.scene.objects.get(object.0 as usize);
        let mesh = object.and_then(|object| file.scene.mesh_of(object));
        mesh.map_or_else(String::new, |mesh| mesh.name.clone())
    };
    PartNode { name: of_node.unwrap_or_else(of_mesh), parent: None, object: Some(object) }
}

/// Returns the number of objects that each node and its descendants have.
fn within(file: &GltfScene, objects: &[Vec<ObjectId>]) -> Vec<usize> {
    let mut within: Vec<usize> = objects.iter().map(Vec::len).collect();
    for id in file.rig.order().iter().rev() {
        let node = file.rig.nodes().get(id.0 as usize);
        if let Some(parent) = node.and_then(|node| node.parent) {
            within[parent.0 as usize] += within[id.0 as usize];
        }
    }
    within
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use antumbra::import::{LoadOptions, load_bytes};

    use super::*;
    use crate::document::Document;
    use crate::export::glb;

    #[test]
    fn primitives_of_a_mesh_stay_together_and_its_instances_do_not() {
        let made = scenes::waffle_maker();
        let bytes = glb(&Document::new(made.scene, made.parts, None)).unwrap();
        let mut progress = |_| ControlFlow::Continue(());
        let mut file = load_bytes(bytes, None, &LoadOptions::default(), &mut progress).unwrap();
        let mut first = file.scene.objects[0];
        let second = Object { mesh: MeshId(1), ..first };
        let aside = antumbra::glam::Affine3A::from_translation(antumbra::glam::Vec3::X);
        let there = Object { transform: aside, ..first };
        first.mesh = MeshId(0);
        // A mesh of two primitives, twice at the same place, and its first primitive at another
        // place.
        file.scene.objects =
            vec![first, second, first, second, Object { mesh: MeshId(0), ..there }];
        file.object_nodes = vec![RigNodeId(0); 5];
        assert_ne!(first.transform, there.transform);
        let bodies = file_bodies(&file);
        assert_eq!(bodies, [0, 0, 2, 2, 4]);
        let tree = file_parts(&file);
        let mut document = Document::new(file.scene, tree, None);
        document.bodies = bodies;
        document.explode(0.01);
        let bodies = document.shown_bodies();
        assert_eq!(bodies.iter().map(|body| body.objects.len()).collect::<Vec<_>>(), [2, 2, 1]);
        let by = |object: u32| {
            document.transform(ObjectId(object)).translation
                - document.scene.objects[object as usize].transform.translation
        };
        assert_eq!(by(0), by(1));
        assert_eq!(by(2), by(3));
        assert!(by(0) != by(2), "instances at one place part");
    }

    #[test]
    fn a_model_that_was_exported_has_the_same_tree() {
        let made = scenes::waffle_maker();
        let document = Document::new(made.scene, made.parts, None);
        let bytes = glb(&document).unwrap();
        let mut progress = |_| ControlFlow::Continue(());
        let file = load_bytes(bytes, None, &LoadOptions::default(), &mut progress).unwrap();
        let tree = file_parts(&file);
        let read = Document::new(file.scene, tree, None);
        let paths = |document: &Document| {
            let mut paths: Vec<Vec<String>> = Vec::new();
            for node in document.parts.nodes.iter().filter(|node| node.object.is_some()) {
                let mut path = vec![node.name.clone()];
                let mut above = node.parent;
                while let Some(node) = above.and_then(|part| document.parts.node(part)) {
                    path.push(node.name.clone());
                    above = node.parent;
                }
                paths.push(path);
            }
            paths.sort();
            paths
        };
        // The file adds a level: its root is the root of the model.
        let mut expected = paths(&document);
        expected.iter_mut().for_each(|path| path.push(read.scene.name.clone()));
        expected.sort();
        assert_eq!(paths(&read), expected);
        let find = |document: &Document| document.find("lid").unwrap().len();
        assert_eq!(find(&read), find(&document));
        assert!(find(&read) > 3);
    }
}

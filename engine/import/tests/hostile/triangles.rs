//! Tests of STL and OBJ files: their scenes, and that their contents are not trusted.

use std::ops::ControlFlow;

use antumbra_import::{
    Cause, GltfScene, ImportError, LoadOptions, MeshFormat, load, load_mesh_bytes,
};

use super::strict;
use gltf_files::mutations::SplitMix;

/// The corners of a cube of side 20, and its faces, counter-clockwise from outside.
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [20.0, 0.0, 0.0],
    [20.0, 20.0, 0.0],
    [0.0, 20.0, 0.0],
    [0.0, 0.0, 20.0],
    [20.0, 0.0, 20.0],
    [20.0, 20.0, 20.0],
    [0.0, 20.0, 20.0],
];
const FACES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn read(bytes: &[u8], format: MeshFormat, options: &LoadOptions) -> Result<GltfScene, ImportError> {
    load_mesh_bytes(bytes, format, None, options, &mut |_| ControlFlow::Continue(()))
}

fn stl(bytes: &[u8]) -> Result<GltfScene, ImportError> {
    read(bytes, MeshFormat::Stl, &LoadOptions::default())
}

fn obj(text: &str) -> Result<GltfScene, ImportError> {
    read(text.as_bytes(), MeshFormat::Obj, &LoadOptions::default())
}

fn cube_triangles() -> Vec<[[f32; 3]; 3]> {
    let halves = FACES.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    halves.map(|corners| corners.map(|corner| CORNERS[corner])).collect()
}

fn binary(comment: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = comment.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text(name: &str, triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = format!("solid {name}\n");
    for corners in triangles {
        text.push_str("  facet normal 0 0 0\n    outer loop\n");
        for [x, y, z] in corners {
            text.push_str(&format!("      vertex {x} {y} {z}\n"));
        }
        text.push_str("    endloop\n  endfacet\n");
    }
    text + &format!("endsolid {name}\n")
}

fn cube_obj() -> String {
    let mut text = String::new();
    for [x, y, z] in CORNERS {
        text.push_str(&format!("v {x} {y} {z}\n"));
    }
    for [a, b, c, d] in FACES.map(|face| face.map(|corner| corner + 1)) {
        text.push_str(&format!("f {a} {b} {c} {d}\n"));
    }
    text
}

/// Fails unless the scene is the cube with a side of `side_m` metres.
fn assert_cube(scene: &GltfScene, side_m: f32) {
    assert_eq!(scene.scene.validate(), Ok(()));
    assert_eq!(scene.scene.objects.len(), 1);
    let mesh = &scene.scene.meshes[0];
    assert_eq!((mesh.triangles(), mesh.vertices.len()), (12, 24), "sharp edges, shared planes");
    assert!(!mesh.has_backs, "it is closed");
    assert_eq!(mesh.bounds.min.to_array(), [0.0; 3]);
    assert!((mesh.bounds.max - side_m).abs().max_element() < 1e-6 * side_m);
}

#[test]
fn a_cube_is_the_same_in_each_format() {
    assert_cube(&stl(&binary(b"made by hand", &cube_triangles())).unwrap(), 0.02);
    assert_cube(&stl(text("cube", &cube_triangles()).as_bytes()).unwrap(), 0.02);
    assert_cube(&obj(&cube_obj()).unwrap(), 20.0);
    let inches = LoadOptions { unit_m: Some(0.0254), ..LoadOptions::default() };
    let cube = read(cube_obj().as_bytes(), MeshFormat::Obj, &inches).unwrap();
    assert_cube(&cube, 0.508);
    // An open surface is visible from both sides.
    let open = stl(&binary(b"", &cube_triangles()[1..])).unwrap();
    assert!(open.scene.meshes[0].has_backs);
}

#[test]
fn binary_files_may_begin_like_a_text() {
    let scene = stl(&binary(b"solid by a program that writes that", &cube_triangles())).unwrap();
    assert_cube(&scene, 0.02);
}

#[test]
fn solids_of_a_text_are_objects_by_name() {
    let both = text("left part", &cube_triangles()) + "\n" + &text("", &cube_triangles());
    let scene = stl(both.as_bytes()).unwrap().scene;
    let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["left part", "part 2"]);
}

#[test]
fn a_number_of_triangles_that_is_a_lie_is_told_at_once() {
    let mut bytes = binary(b"", &cube_triangles());
    bytes[80..84].copy_from_slice(&42_949_672_u32.to_le_bytes());
    let error = stl(&bytes).unwrap_err();
    assert_eq!(error.cause, Cause::Damaged);
    assert_eq!(
        error.to_string(),
        "memory: the header: it says that 42949672 triangles follow, but only 12 fit the file (the \
         file is damaged or its exporter is wrong: copy or export it again)"
    );
    bytes[80..84].copy_from_slice(&11_u32.to_le_bytes());
    let scene = stl(&bytes).unwrap();
    assert!(scene.notes.iter().any(|note| note.reason.contains("after the last triangle")));
}

#[test]
fn positions_that_are_no_numbers_are_left_out_or_refuse_the_file() {
    let mut triangles = cube_triangles();
    triangles[3][1][2] = f32::NAN;
    triangles[4][0][0] = f32::INFINITY;
    let bytes = binary(b"", &triangles);
    let scene = stl(&bytes).unwrap();
    assert_eq!(scene.scene.triangles(), 10);
    assert!(scene.notes.iter().any(|note| note.count == 2), "{:?}", scene.notes);
    let error = read(&bytes, MeshFormat::Stl, &strict()).unwrap_err();
    assert!(error.to_string().contains("triangle 3: "), "{error}");
    let huge = [[[0.0; 3], [3e38, 0.0, 0.0], [0.0, 3e38, 0.0]]];
    assert_eq!(stl(&binary(b"", &huge)).unwrap_err().cause, Cause::TooLarge);
}

#[test]
fn broken_texts_are_refused_with_a_place() {
    let whole = text("cube", &cube_triangles());
    for (bytes, said) in [
        (whole.replacen("vertex 20", "vertex 2o", 1), "triangle 0: "),
        (whole.replace("endsolid", ""), "solid \"cube\": it has no end"),
        (whole.replacen("endloop", "", 1), "triangle 0: "),
        (format!("solid a\n{}\nendsolid", "a ".repeat(1 << 16)), "line 2: it is longer than"),
        ("solid a\nendsolid a\n".to_owned(), "it has no triangles"),
        (whole.replacen("vertex 20", "vertex inf", 1), "triangle 0: "),
        ("soli".to_owned(), "too short"),
        (String::new(), "too short"),
    ] {
        let error = stl(bytes.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(said), "{error} without {said}");
    }
}

#[test]
fn faces_of_any_corners_count_from_both_ends() {
    let scene = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv .5 2 0\nv 0 1 0\no pentagon\nf -5 -4 -3 -2 -1\n");
    let scene = scene.unwrap().scene;
    assert_eq!((scene.triangles(), scene.meshes[0].name.as_str()), (3, "pentagon"));
    let scene = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1/7/1 2//1 \\\n 3/99999999999/1\n");
    let mesh = &scene.unwrap().scene.meshes[0];
    assert_eq!(mesh.vertices.len(), 6, "three, and three of its back");
}

#[test]
fn indices_that_are_not_there_leave_their_face_out() {
    let wrong = ["4", "0", "-4", "99999999999999999999", "-9223372036854775808", "x", "1.5", ""];
    for wrong in wrong {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {wrong}\nf 1 2 3\n");
        let scene = obj(&text).unwrap();
        assert_eq!(scene.scene.triangles(), 1, "{wrong}");
        let error = read(text.as_bytes(), MeshFormat::Obj, &strict()).unwrap_err();
        assert!(error.to_string().contains("line 4: a face has "), "{error}");
        let alone = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {wrong}\n");
        assert!(obj(&alone).unwrap_err().to_string().contains("it has no triangles"));
    }
    let error = obj("v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap_err();
    assert!(error.to_string().contains("it has no triangles"), "{error}");
}

#[test]
fn materials_give_colours_and_may_be_missing() {
    let folder = std::env::temp_dir().join(format!("antumbra-obj-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("two parts.obj");
    let mtl = "newmtl red paint\nKd 1 0 0\nnewmtl short\nKd 1\nnewmtl odd\nKd nan 0 0\n";
    std::fs::write(folder.join("the colours.mtl"), mtl).unwrap();
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nmtllib the colours.mtl\nmtllib no.mtl\nmtllib ../x.mtl\n\
                 g a\nusemtl red paint\nf 1 2 3\ng b\nusemtl blue\nf 1 3 2\nusemtl short\nf 1 2 3\n";
    std::fs::write(&path, faces).unwrap();
    let loaded = load(&path, &LoadOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!((loaded.scene.name.as_str(), loaded.scene.objects.len()), ("two parts", 3));
    let surfaces = loaded.scene.surfaces.as_ref().unwrap();
    let colour =
        |part: usize| surfaces.materials[surfaces.meshes[part].material.0 as usize].base_colour;
    assert_eq!(colour(0), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(colour(1), [0.5, 0.5, 0.5, 1.0], "its material is not there");
    assert_eq!(colour(2), [0.5, 0.5, 0.5, 1.0], "it has no whole colour");
    let notes: String = loaded.notes.iter().map(|note| format!("{note}\n")).collect();
    for said in ["no.mtl", "leads out", "material \"blue\""] {
        assert!(notes.contains(said), "{notes} without {said}");
    }
}

#[test]
fn reading_ends_when_it_is_told_to_and_within_the_limits() {
    let bytes = binary(b"", &cube_triangles().repeat(10_000));
    let mut reports = 0;
    let stopped =
        load_mesh_bytes(&bytes, MeshFormat::Stl, None, &LoadOptions::default(), &mut |_| {
            reports += 1;
            if reports > 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
    assert_eq!(stopped.unwrap_err().cause, Cause::GivenUp);
    let mut options = LoadOptions::default();
    options.limits.corners = 35;
    let cube = binary(b"", &cube_triangles());
    assert_eq!(read(&cube, MeshFormat::Stl, &options).unwrap_err().cause, Cause::TooLarge);
    options.limits.corners = 36;
    assert!(read(&cube, MeshFormat::Stl, &options).is_ok());
    options.limits.vertices = 7;
    for (bytes, format) in [(cube, MeshFormat::Stl), (cube_obj().into(), MeshFormat::Obj)] {
        assert_eq!(read(&bytes, format, &options).unwrap_err().cause, Cause::TooLarge);
    }
}

#[test]
fn no_change_of_a_file_makes_it_panic() {
    let materials =
        "usemtl a\nvn 0 0 1\nvt 0 1\no next\nf 1/1/1 2//1 3\nl 1 2\nf -1 -2 -3 -4 1 2\n";
    let seeds = [
        (binary(b"solid", &cube_triangles()), MeshFormat::Stl),
        (text("cube", &cube_triangles()).into_bytes(), MeshFormat::Stl),
        ((cube_obj() + materials).into_bytes(), MeshFormat::Obj),
    ];
    let mut random = SplitMix(5);
    let mut accepted = 0;
    const TRIES: usize = 20_000;
    for turn in 0..TRIES {
        let (seed, format) = &seeds[turn % seeds.len()];
        let mut bytes = seed.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            let to = at + random.below(12).min(bytes.len() - at);
            match random.below(4) {
                0 => bytes[at] = random.below(256) as u8,
                1 => drop(bytes.drain(at..to)),
                2 => bytes.extend_from_within(at..to),
                _ => bytes[at] = b"0123456789-/ .ef\n"[random.below(17)],
            }
            if bytes.is_empty() {
                bytes.push(b'f');
            }
        }
        if let Ok(loaded) = read(&bytes, *format, &LoadOptions::default()) {
            accepted += 1;
            assert_eq!(loaded.scene.validate(), Ok(()), "try {turn}");
        }
    }
    assert!((TRIES / 20..TRIES * 19 / 20).contains(&accepted), "{accepted} of {TRIES} accepted");
}

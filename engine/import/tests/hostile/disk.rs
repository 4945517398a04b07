//! Tests of files beside the scene: only regular files in the scene's folder are read.

use std::fs;
use std::path::{Path, PathBuf};

use antumbra_import::{Cause, ImportError, LoadOptions, open};
use serde_json::json;

use gltf_files::files::{GltfFile, encoded};

/// A folder with a scene in it, and a secret file beside it; removed on drop.
struct Folder {
    outer: PathBuf,
}

impl Folder {
    fn new(name: &str) -> Self {
        let outer =
            std::env::temp_dir().join(format!("antumbra-import-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&outer);
        fs::create_dir_all(outer.join("scene/sub")).expect("a folder to write into");
        fs::write(outer.join("secret.bin"), [1; 4096]).expect("it can be written");
        Self { outer }
    }

    fn scene(&self) -> PathBuf {
        self.outer.join("scene")
    }

    /// Opens a triangle whose buffer has this URI.
    fn open(&self, uri: &str) -> Result<(), ImportError> {
        self.open_with(&json!([{ "byteLength": 42, "uri": uri }]))
    }

    fn open_with(&self, buffers: &serde_json::Value) -> Result<(), ImportError> {
        let mut scene = GltfFile::triangle();
        scene.set("/buffers", buffers.clone());
        let path = self.scene().join("scene.gltf");
        fs::write(&path, scene.gltf()).expect("it can be written");
        open(&path, &LoadOptions::default()).map(drop)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.scene().join(name), bytes).expect("it can be written");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.outer);
    }
}

#[test]
fn pointers_of_git_lfs_are_named() {
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
    let folder = Folder::new("pointers");
    folder.write("a.bin", pointer);
    for length in [42, 100_000] {
        let error = folder
            .open_with(&json!([{ "byteLength": length, "uri": "a.bin" }]))
            .expect_err("it is not there")
            .to_string();
        assert!(error.contains("\"a.bin\" is a Git LFS pointer"), "{error}");
        assert!(error.contains("git lfs pull"), "{error}");
    }
    folder.write("scene.glb", pointer);
    let path = folder.scene().join("scene.glb");
    let error = open(&path, &LoadOptions::default()).map(drop).expect_err("no scene").to_string();
    assert!(error.contains("it is a Git LFS pointer"), "{error}");
}

#[test]
fn files_below_the_scene_are_read() {
    let folder = Folder::new("below");
    let bytes = GltfFile::triangle().binary;
    for (name, uri) in [
        ("a.bin", "a.bin"),
        ("a b ü%.bin", "a%20b%20%C3%BC%25.bin"),
        ("with space é.bin", "with space é.bin"),
        ("sub/c.bin", "./sub//c.bin"),
        ("sub/d.bin", "sub/../sub/d.bin"),
        ("100%.bin", "100%.bin"),
        ("..hidden", "..hidden"),
        ("longer.bin", "longer.bin"),
    ] {
        folder.write(name, &if name == "longer.bin" { vec![0; 100_000] } else { bytes.clone() });
        folder.open(uri).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
}

#[test]
fn nothing_outside_of_the_folder_is_read() {
    let folder = Folder::new("outside");
    let absolute = folder.outer.join("secret.bin").display().to_string();
    let drive = "C:\\secret.bin";
    for (uri, said) in [
        ("../secret.bin", "leads out"),
        ("sub/../../secret.bin", "leads out"),
        ("..", "leads out"),
        ("%2e%2e/secret.bin", "leads out"),
        ("%2E%2E%2Fsecret.bin", "leads out"),
        ("..\\secret.bin", "backslash"),
        ("..%5Csecret.bin", "backslash"),
        ("a.bin%00.png", "control character"),
        (absolute.as_str(), "is absolute"),
        (&format!("file://{absolute}"), "scheme \"file\""),
        (&format!("FILE:{absolute}"), "scheme \"FILE\""),
        ("http://example.com/a.bin", "scheme \"http\""),
        ("//example.com/a.bin", "is absolute"),
        ("%2Fetc%2Fpasswd", "is absolute"),
        (drive, "scheme \"C\""),
        ("C:secret.bin", "scheme \"C\""),
    ] {
        let error = folder.open(uri).expect_err(uri);
        assert_eq!(error.cause, Cause::Forbidden, "{uri}: {error}");
        assert!(error.to_string().contains(said), "{uri}: {error}");
        assert_eq!(error.object, "buffer 0", "{uri}");
    }
    for (uri, cause) in [
        ("", Cause::Malformed),
        ("gone.bin", Cause::Unreadable),
        ("sub", Cause::Unreadable),
        (".", Cause::Unreadable),
        ("%FF.bin", Cause::Malformed),
        ("scene.gltf/a", Cause::Unreadable),
    ] {
        let error = folder.open(uri).expect_err(uri);
        assert_eq!((error.cause, error.object.as_str()), (cause, "buffer 0"), "{uri}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn links_and_pipes_lead_nowhere() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    let inside = folder.scene();
    folder.write("a.bin", &GltfFile::triangle().binary);
    let link = |to: &Path, name: &str| symlink(to, inside.join(name)).expect("a link can be made");
    link(Path::new("a.bin"), "good");
    link(Path::new("../secret.bin"), "bad");
    link(Path::new(".."), "up");
    link(Path::new("/dev/zero"), "device");
    link(Path::new("circle"), "circle");
    folder.open("good").unwrap_or_else(|error| panic!("{error}"));
    for uri in ["bad", "up/secret.bin", "device"] {
        let error = folder.open(uri).expect_err(uri);
        assert!(error.to_string().contains("link that leads out"), "{error}");
    }
    assert_eq!(folder.open("circle").expect_err("a circle").cause, Cause::Unreadable);

    let pipe = inside.join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there");
    assert!(made.success());
    let error = folder.open("pipe").expect_err("a pipe");
    assert!(error.to_string().contains("is not a file"), "{error}");
    let error = open(&pipe, &LoadOptions::default()).map(drop).expect_err("a pipe");
    assert!(error.to_string().contains("is not a file"), "{error}");
    assert!(open(Path::new("/dev/zero"), &LoadOptions::default()).is_err());
    assert!(open(&inside, &LoadOptions::default()).is_err());
}

#[test]
fn sizes_are_looked_at_before_files_are_read() {
    let folder = Folder::new("sizes");
    let sparse = fs::File::create(folder.scene().join("huge.bin")).expect("it can be written");
    sparse.set_len(1 << 40).expect("a file with a hole");
    folder.write("short.bin", &[0; 41]);
    let error = folder.open("short.bin").expect_err("too short");
    assert!(error.to_string().contains("byteLength is 42, but only 41 bytes"), "{error}");
    folder.open("huge.bin").unwrap_or_else(|error| panic!("only its beginning is wanted: {error}"));
    let whole = json!([{ "byteLength": 1u64 << 40, "uri": "huge.bin" }]);
    let error = folder.open_with(&whole).expect_err("too large");
    assert_eq!((error.cause, error.object.as_str()), (Cause::TooLarge, "buffer 0"), "{error}");
    let unused = json!([{ "byteLength": 42, "uri": "huge.bin" }, { "byteLength": 1u64 << 40, "uri": "huge.bin" }]);
    folder.open_with(&unused).unwrap_or_else(|error| panic!("nobody uses the other: {error}"));
    let error = open(&folder.scene().join("huge.bin"), &LoadOptions::default())
        .map(drop)
        .expect_err("too large");
    assert_eq!(error.cause, Cause::TooLarge, "{error}");
}

#[test]
fn images_are_read_from_files_too() {
    let folder = Folder::new("images");
    folder.write("a.png", &encoded(image::ImageFormat::Png));
    let mut scene = GltfFile::triangle();
    scene.set("/images", json!([{ "uri": "a.png" }, { "uri": "../a.png" }]));
    scene.show_images(1);
    let path = folder.scene().join("scene.gltf");
    fs::write(&path, scene.gltf()).expect("it can be written");
    let source = open(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(source.images[0].as_ref().map(|image| image.size), Some([16, 8]));
    scene.set("/textures/0/source", json!(1));
    fs::write(&path, scene.gltf()).expect("it can be written");
    let source = open(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(source.placeholders.contains(&1) && source.images[0].is_none());
    let note = source.notes[0].to_string();
    assert!(note.starts_with("image 1: its URI \"../a.png\" leads out of"), "{note}");
    scene.set("/materials/0", json!({}));
    fs::write(&path, scene.gltf()).expect("it can be written");
    let source = open(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(source.images.iter().all(Option::is_none), "nobody looks at what nobody shows");
}

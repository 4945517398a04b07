//! Tests of destinations: files, links, pipes, folders.

#[cfg(unix)]
use std::process::Command;

use super::*;
use crate::outputs::tests::Scratch;

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    Destination::of(path)?.write(bytes)
}

#[test]
fn what_is_not_there_becomes_a_file() {
    let scratch = Scratch::new("destination-new");
    let file = scratch.0.join("file");
    assert!(matches!(Destination::of(&file), Ok(Destination::File(path)) if path == file));
    assert!(!file.exists(), "to look is not to write");
    write(&file, b"new").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(scratch.names(), ["file"]);
}

#[test]
fn folders_and_names_that_are_none_are_refused() {
    let scratch = Scratch::new("destination-folder");
    for path in [scratch.0.clone(), scratch.0.join(".."), scratch.0.join("new/")] {
        let refused = Destination::of(&path).unwrap_err().to_string();
        assert_eq!(refused, "it is not the name of a file", "{}", path.display());
    }
}

#[cfg(unix)]
#[test]
fn links_stay_and_what_they_lead_to_is_replaced() {
    let scratch = Scratch::new("destination-link");
    let folder = scratch.0.join("folder");
    fs::create_dir(&folder).unwrap();
    let file = folder.join("file");
    let link = scratch.0.join("link");
    let chain = scratch.0.join("chain");
    std::os::unix::fs::symlink("folder/file", &link).unwrap();
    std::os::unix::fs::symlink("link", &chain).unwrap();
    // First where the link leads to nothing, then where it leads to a file.
    for text in ["made", "replaced"] {
        write(&chain, text.as_bytes()).unwrap();
        assert_eq!(fs::read(&file).unwrap(), text.as_bytes());
        assert!(fs::symlink_metadata(&file).unwrap().is_file());
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(fs::symlink_metadata(&chain).unwrap().is_symlink());
    }
    let mut names = scratch.names();
    names.sort();
    assert_eq!(names, ["chain", "folder", "link"]);

    let circle = scratch.0.join("circle");
    std::os::unix::fs::symlink("circle", &circle).unwrap();
    assert!(write(&circle, b"x").is_err());
    assert!(fs::symlink_metadata(&circle).unwrap().is_symlink());
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_into_and_stays_one() {
    use std::os::unix::fs::FileTypeExt;

    let scratch = Scratch::new("destination-pipe");
    let pipe = scratch.0.join("pipe");
    let link = scratch.0.join("link");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::os::unix::fs::symlink(&pipe, &link).unwrap();
    for path in [&pipe, &link] {
        assert!(matches!(Destination::of(path), Ok(Destination::Stream(_))));
        // Held open, so that a writer that opens something else cannot leave the reader waiting.
        let mut held = OpenOptions::new().read(true).write(true).open(&pipe).unwrap();
        write(path, b"through").unwrap();
        let mut read = [0; 7];
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        io::Read::read_exact(&mut held, &mut read).unwrap();
        assert_eq!(&read, b"through");
    }
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(scratch.names().len(), 2);
}

#[cfg(unix)]
#[test]
fn devices_are_streams_and_sockets_too() {
    let scratch = Scratch::new("destination-device");
    let socket = scratch.0.join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    // Only looked at, never written.
    for path in [Path::new("/dev/zero"), &socket] {
        assert!(matches!(Destination::of(path), Ok(Destination::Stream(_))), "{}", path.display());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_longest_name_is_a_name() {
    let scratch = Scratch::new("destination-long");
    let file = scratch.0.join("x".repeat(NAME_BYTES_MAX));
    for text in ["made", "replaced"] {
        write(&file, text.as_bytes()).unwrap();
        assert_eq!(fs::read(&file).unwrap(), text.as_bytes());
    }
    // A new file beside it gets a shorter stem and the same ending.
    let named = scratch.0.join("\u{e4}".repeat(126) + ".png");
    let [first, second] = [0, 1].map(|_| create(&named, b"x").unwrap());
    assert_eq!(first, scratch.0.join("\u{e4}".repeat(125) + ".png"));
    assert_eq!(second, scratch.0.join("\u{e4}".repeat(124) + "-2.png"));
    assert_eq!(scratch.names().len(), 3, "nothing partial is left");
}

#[test]
fn a_new_file_takes_no_name_that_is_taken() {
    let scratch = Scratch::new("destination-free");
    let wanted = scratch.0.join("a.png");
    fs::create_dir(&wanted).unwrap();
    fs::write(scratch.0.join("a-2.png"), b"kept").unwrap();
    assert_eq!(create(&wanted, b"new").unwrap(), scratch.0.join("a-3.png"));
    assert_eq!(create(&scratch.0.join("b"), b"new").unwrap(), scratch.0.join("b"));
    assert_eq!(create(&scratch.0.join("b"), b"new").unwrap(), scratch.0.join("b-2"));
    assert_eq!(fs::read(scratch.0.join("a-2.png")).unwrap(), b"kept");
}

#[test]
fn many_who_want_the_same_name_get_one_each() {
    let scratch = Scratch::new("destination-race");
    let wanted = scratch.0.join("deep/er/a.txt");
    let mut names: Vec<PathBuf> = std::thread::scope(|scope| {
        let write = |writer: usize| {
            let wanted = &wanted;
            scope.spawn(move || (0..8).map(|_| create(wanted, &[writer as u8]).unwrap()).collect())
        };
        let writers: Vec<_> = (0..8).map(write).collect();
        writers.into_iter().flat_map(|writer| -> Vec<PathBuf> { writer.join().unwrap() }).collect()
    });
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 64, "each writer has a file of its own");
    assert_eq!(fs::read_dir(folder_of(&wanted)).unwrap().count(), 64);
}

//! Small pictures of the scenes and paths that were walked, within the page.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ImageFormat, ImageReader};

use super::cases::{Case, Cases, Place};
use crate::input_file;

/// The most pixels of a thumbnail, horizontally and vertically.
const SIZE_MAX: [u32; 2] = [240, 135];
/// The largest file that is read: a larger one is not a picture of a walk.
const MOST_BYTES: u64 = 256 << 20;

/// A picture of a scene on a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thumbnail {
    /// The scene and the path in it.
    pub caption: String,
    /// Its size in pixels.
    pub size: [u32; 2],
    /// A PNG as `data:` URI.
    pub uri: String,
}

/// Returns a picture for each scene and path that stands still before one eye, and sentences about
/// pictures that could not be shown. The pictures of the report `NAME.json` lie in the folder
/// `NAME` in `folder`; the first one by its name is taken.
pub fn thumbnails(folder: &Path, cases: &Cases<'_>) -> (Vec<Thumbnail>, Vec<String>) {
    let mut found = Vec::<((&str, &str), Thumbnail)>::new();
    let mut missing = Vec::new();
    for (place, case) in cases.iter().filter(|(place, _)| place.moving == 0 && place.views == 1) {
        let Some(file) = picture_of(folder, case) else { continue };
        match shrunk(&file) {
            Ok((size, uri)) => {
                let Place { scene, path, .. } = place;
                // Cases with more objects come later, and their pictures show more.
                found.retain(|(of, _)| *of != (scene, path));
                let caption = place.name();
                found.push(((scene, path), Thumbnail { caption, size, uri }));
            }
            Err(error) => missing.push(format!("{}: {error}", crate::terminal::shown(&file))),
        }
    }
    (found.into_iter().map(|(_, thumbnail)| thumbnail).collect(), missing)
}

/// Returns the first picture of any of a case's walks.
fn picture_of(folder: &Path, case: &Case<'_>) -> Option<PathBuf> {
    case.reports().iter().find_map(|report| {
        let entries = fs::read_dir(folder.join(report.file.strip_suffix(".json")?)).ok()?;
        let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
        files.filter(|file| file.extension().is_some_and(|extension| extension == "png")).min()
    })
}

/// Returns a picture made small, with its size.
fn shrunk(file: &Path) -> Result<([u32; 2], String), String> {
    let bytes = input_file::read(file, MOST_BYTES).map_err(|error| error.to_string())?;
    let reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let picture = reader.decode().map_err(|error| error.to_string())?;
    let small = picture.thumbnail(SIZE_MAX[0], SIZE_MAX[1]).into_rgb8();
    let mut png = Cursor::new(Vec::new());
    small.write_to(&mut png, ImageFormat::Png).map_err(|error| error.to_string())?;
    let uri = format!("data:image/png;base64,{}", STANDARD.encode(png.into_inner()));
    Ok(([small.width(), small.height()], uri))
}

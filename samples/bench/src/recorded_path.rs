//! Camera paths in files: recorded by one program, walked again by another, bit for bit.
//!
//! ```text
//! antumbra path 1
//! # seconds, eye, forward, up, field of view or (if a far plane follows) height, near plane
//! 0 1.5 1.7 -20 0 0 1 0 1 0 1.0471976 0.2
//! ```
//!
//! A header with the format's version, then a line for each frame. Empty lines and lines that begin
//! with `#` are ignored. Numbers are the shortest that read back to the same bits.

use std::fmt::Write;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use antumbra::cull::{Camera, Projection};
use antumbra::glam::Vec3;

use crate::input_file;
use crate::options::UsageError;
use crate::outputs::{WriteError, write_new};
use crate::terminal::shown;

const HEADER: &str = "antumbra path 1";
const COLUMNS: &str =
    "# seconds, eye, forward, up, field of view or (if a far plane follows) height, near plane";
/// The numbers of a frame in perspective. An orthographic frame has its far plane in addition.
const NUMBERS: usize = 12;
/// The most frames of a path: ten hours at 60 per second. A file with more was not recorded by us.
const MOST_FRAMES: usize = 2_000_000;
/// The largest file: the most frames with numbers at full length. A larger file was not recorded by
/// us.
const MOST_BYTES: u64 = 512 << 20;
/// The longest line in bytes.
const MOST_LINE_BYTES: u64 = 4096;

/// One recorded frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFrame {
    /// The time when it was drawn, in seconds after the first one.
    pub seconds: f64,
    /// The camera that the frame was drawn from.
    pub camera: Camera,
}

/// The frames of a path, at least one after reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedPath {
    frames: Vec<PathFrame>,
    is_full: bool,
}

impl RecordedPath {
    /// Adds the next frame. Frames beyond two million are not recorded, which the log reports.
    pub fn push(&mut self, seconds: f64, camera: Camera) {
        if self.frames.len() < MOST_FRAMES {
            self.frames.push(PathFrame { seconds, camera });
        } else if !std::mem::replace(&mut self.is_full, true) {
            tracing::warn!("the path has {MOST_FRAMES} frames, and takes no more");
        }
    }

    /// Returns the frames, in their order.
    pub fn frames(&self) -> &[PathFrame] {
        &self.frames
    }

    /// Returns the camera of a frame; after the last one the path repeats.
    pub fn camera(&self, frame: u32) -> Option<Camera> {
        let frame = (frame as usize).checked_rem(self.frames.len())?;
        self.frames.get(frame).map(|frame| frame.camera)
    }

    /// Writes a file that did not exist, whole or not at all. Returns the path that was
    /// [free](write_new).
    ///
    /// # Errors
    /// When the folder or the disk refuses.
    pub fn write(&self, path: &Path) -> Result<PathBuf, WriteError> {
        let mut text = format!("{HEADER}\n{COLUMNS}\n");
        for frame in &self.frames {
            let PathFrame { seconds, camera: Camera { eye, forward, up, projection, near } } =
                frame;
            let (height, far) = match *projection {
                Projection::Perspective { fov_y } => (fov_y, None),
                Projection::Orthographic { height, far } => (height, Some(far)),
            };
            let numbers = [eye, forward, up].into_iter().flat_map(|vector| vector.to_array());
            let _text_takes_all = write!(text, "{seconds}");
            for number in numbers.chain([height, *near]).chain(far) {
                let _text_takes_all = write!(text, " {number}");
            }
            text.push('\n');
        }
        write_new(path, text.as_bytes())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// An unreadable file, or the first invalid line, with its number.
    pub fn read(path: &Path) -> Result<Self, UsageError> {
        let shown = shown(path);
        let refuse = |reason: &dyn std::fmt::Display| {
            UsageError(format!("cannot read the path file '{shown}': {reason}"))
        };
        let file = input_file::open(path, MOST_BYTES).map_err(|error| refuse(&error))?;
        Self::parse(BufReader::new(file))
            .map_err(|(line, reason)| UsageError(format!("{shown}:{line}: {reason}")))
    }

    /// Returns the path in a text, or the number of the wrong line and the reason.
    fn parse(mut text: impl BufRead) -> Result<Self, (usize, String)> {
        let mut recorded = Self::default();
        let mut has_header = false;
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            let wrong = |reason: &str| (number, reason.to_owned());
            let read = text.by_ref().take(MOST_LINE_BYTES).read_until(b'\n', &mut line);
            if read.map_err(|error| (number, error.to_string()))? == 0 {
                break;
            }
            let line = str::from_utf8(&line).map_err(|_| wrong("this is not text"))?.trim();
            if !has_header {
                has_header = check_header(line).map_err(|reason| (number, reason))?;
            } else if !line.is_empty() && !line.starts_with('#') {
                let frame = parse_frame(line).map_err(|reason| (number, reason))?;
                if recorded.frames.last().is_some_and(|last| last.seconds > frame.seconds) {
                    return Err(wrong("time goes back here"));
                }
                if recorded.frames.len() == MOST_FRAMES {
                    return Err(wrong("a path has at most two million frames"));
                }
                recorded.frames.push(frame);
            }
        }
        if !recorded.frames.is_empty() {
            Ok(recorded)
        } else if has_header {
            Err((1, "there is no frame in it".to_owned()))
        } else {
            Err((1, format!("the file is empty; a path begins with '{HEADER}'")))
        }
    }
}

fn check_header(line: &str) -> Result<bool, String> {
    if line == HEADER {
        return Ok(true);
    }
    Err(match line.strip_prefix("antumbra path ") {
        Some(version) => format!("this is version '{version}' of the format; this program reads 1"),
        None => format!("a path file begins with '{HEADER}'"),
    })
}

fn parse_frame(line: &str) -> Result<PathFrame, String> {
    let mut numbers = [0.0_f64; NUMBERS + 1];
    let words = line.split_ascii_whitespace();
    let count = words.clone().count();
    let is_orthographic = count == NUMBERS + 1;
    if count != NUMBERS && !is_orthographic {
        return Err(format!("a frame has {NUMBERS} or {} numbers, not {count}", NUMBERS + 1));
    }
    for (number, word) in numbers.iter_mut().zip(words) {
        // Parsed as `f32` at once, since rounding twice could change a bit.
        let read = word.parse::<f32>().ok().filter(|number| number.is_finite());
        *number = read.ok_or_else(|| format!("'{word}' is not a number"))?.into();
    }
    let seconds = line.split_ascii_whitespace().next().and_then(|word| word.parse().ok());
    let vector = |at: usize| Vec3::from_array([0, 1, 2].map(|side| numbers[at + side] as f32));
    let camera = Camera {
        eye: vector(1),
        forward: vector(4),
        up: vector(7),
        projection: if is_orthographic {
            Projection::Orthographic { height: numbers[10] as f32, far: numbers[12] as f32 }
        } else {
            Projection::perspective(numbers[10] as f32)
        },
        near: numbers[11] as f32,
    };
    if camera.forward.cross(camera.up).length_squared() < 1e-12 {
        return Err("forward and up are parallel, or one is zero".to_owned());
    }
    match camera.projection {
        Projection::Perspective { fov_y } if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) => {
            Err(format!("a field of view is between 0 and pi, not {fov_y}"))
        }
        Projection::Perspective { .. } if camera.near <= 0.0 => {
            Err(format!("the near plane is before the eye, not at {}", camera.near))
        }
        Projection::Orthographic { height, .. } if height <= 0.0 => {
            Err(format!("an image is higher than {height} m"))
        }
        Projection::Orthographic { far, .. } if far <= camera.near => {
            Err(format!("the far plane is beyond the near plane, not at {far}"))
        }
        _ => Ok(()),
    }?;
    Ok(PathFrame { seconds: seconds.unwrap_or(numbers[0]), camera })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns a camera in perspective, or, to the left of the origin, an orthographic one.
    fn camera(numbers: [f32; 3]) -> Camera {
        let [x, y, z] = numbers;
        let projection = if x < 0.0 {
            Projection::Orthographic { height: z.abs() + 0.5, far: 900.0 + z.abs() }
        } else {
            Projection::perspective(1.1)
        };
        Camera {
            eye: Vec3::new(x, y, z),
            forward: Vec3::new(1.0, 0.1 * y.signum(), 0.3),
            up: Vec3::Y,
            projection,
            near: 0.2,
        }
    }

    proptest! {
        #[test]
        fn what_was_written_is_read_bit_for_bit(
            places in prop::collection::vec(prop::array::uniform3(-1e6_f32..1e6), 1..20)
        ) {
            let mut recorded = RecordedPath::default();
            for (frame, place) in places.iter().enumerate() {
                recorded.push(frame as f64 / 60.0, camera(*place));
            }
            let name = format!("antumbra-path-{}-{:?}", std::process::id(), std::thread::current().id());
            let path = std::env::temp_dir().join(name);
            recorded.write(&path).unwrap();
            let read = RecordedPath::read(&path);
            std::fs::remove_file(&path).unwrap();
            prop_assert_eq!(read.unwrap(), recorded);
        }

        #[test]
        fn no_text_makes_it_panic(text in "\\PC*") {
            let _refused = RecordedPath::parse(text.as_bytes());
            let _refused = RecordedPath::parse(format!("{HEADER}\n{text}").as_bytes());
        }
    }

    #[test]
    fn after_the_last_frame_it_begins_again() {
        let mut recorded = RecordedPath::default();
        assert_eq!(recorded.camera(3), None);
        for frame in 0..3_u8 {
            recorded.push(frame.into(), camera([frame.into(), 1.0, 0.0]));
        }
        assert_eq!(recorded.camera(4).unwrap().eye.x, 1.0);
    }

    #[test]
    fn a_broken_file_is_named_with_its_line_and_reason() {
        let frame = "0 1 2 3 0 0 1 0 1 0 1 0.2";
        for (text, line, reason) in [
            (String::new(), 1, "empty"),
            ("hello\n".to_owned(), 1, "begins with 'antumbra path 1'"),
            ("antumbra path 2\n".to_owned(), 1, "version '2'"),
            (format!("{HEADER}\n"), 1, "no frame"),
            (format!("{HEADER}\n{frame}\n1 2 3\n"), 3, "12 or 13 numbers, not 3"),
            (
                format!("{HEADER}\n\n{}\n", frame.replace("0.2", "near")),
                3,
                "'near' is not a number",
            ),
            (format!("{HEADER}\n{}\n", frame.replace("0.2", "NaN")), 2, "'NaN' is not a number"),
            (format!("{HEADER}\n{}\n", frame.replace("0.2", "-1")), 2, "near plane"),
            (format!("{HEADER}\n0 1 2 3 0 1 0 0 1 0 1 0.2\n"), 2, "are parallel"),
            (format!("{HEADER}\n0 1 2 3 0 0 1 0 1 0 4 0.2\n"), 2, "between 0 and pi"),
            (format!("{HEADER}\n{frame} 0.1\n"), 2, "far plane"),
            (format!("{HEADER}\n0 1 2 3 0 0 1 0 1 0 -4 0.2 9\n"), 2, "higher than"),
            (format!("{HEADER}\n1{frame}\n{frame}\n"), 3, "time goes back"),
        ] {
            let (at, why) = RecordedPath::parse(text.as_bytes()).unwrap_err();
            assert!(at == line && why.contains(reason), "{text:?}: {at}: {why}");
        }
        let (at, _) = RecordedPath::parse(&b"antumbra path 1\n\xff\xfe\n"[..]).unwrap_err();
        assert_eq!(at, 2);
        let message = RecordedPath::read(Path::new("/nowhere/path")).unwrap_err().to_string();
        assert!(message.contains("/nowhere/path"), "{message}");
    }
}

//! Reads the images that programs leave.

use std::fs;
use std::path::Path;

/// Returns the pixels of an image: rows from the top, red, green, blue.
pub fn pixels(path: &Path) -> Vec<[u8; 3]> {
    let file = fs::File::open(path).expect("an image");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut bytes).expect("a frame");
    bytes.as_chunks::<3>().0.to_vec()
}

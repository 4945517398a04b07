//! Small KTX2 files, made here.

use ktx2::dfd::{Basic, Block};
use ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

/// A KTX2 file of one image.
#[derive(Clone)]
pub struct Ktx2File {
    /// The head, but for the places of what follows.
    pub header: Header,
    /// The description of the format.
    pub description: Basic,
    /// Keys and values, without the zero byte after the key.
    pub values: Vec<(&'static str, &'static [u8])>,
    /// The mip maps as they lie in the file, the whole image first, and their bytes unpacked.
    pub levels: Vec<(Vec<u8>, u64)>,
}

impl Ktx2File {
    /// Returns an image with these mip maps, the whole image first.
    pub fn new(format: Format, size: [u32; 2], levels: &[Vec<u8>]) -> Self {
        let (description, type_size) = Basic::from_format(format).expect("a format");
        let nowhere = Index {
            dfd_byte_offset: 0,
            dfd_byte_length: 0,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        };
        let header = Header {
            format: Some(format),
            type_size,
            pixel_width: size[0],
            pixel_height: size[1],
            pixel_depth: 0,
            layer_count: 0,
            face_count: 1,
            level_count: levels.len() as u32,
            supercompression_scheme: None,
            index: nowhere,
        };
        let levels = levels.iter().map(|level| (level.clone(), level.len() as u64)).collect();
        Self { header, description, values: Vec::new(), levels }
    }

    /// Packs the mip maps by Zstandard.
    #[must_use]
    pub fn packed(mut self) -> Self {
        self.header.supercompression_scheme = Some(SupercompressionScheme::Zstandard);
        for (level, _) in &mut self.levels {
            *level = compress_to_vec(level.as_slice(), CompressionLevel::Fastest);
        }
        self
    }

    /// Returns the bytes of the file, the smallest mip map first as the format demands.
    pub fn bytes(&self) -> Vec<u8> {
        let description = Block::Basic(self.description.clone()).to_vec();
        let mut values = Vec::new();
        for (key, value) in &self.values {
            let pair = [key.as_bytes(), b"\0", value].concat();
            values.extend((pair.len() as u32).to_le_bytes());
            values.extend(pair);
            values.resize(values.len().next_multiple_of(4), 0);
        }
        let mut header = self.header;
        let begin = Header::LENGTH + self.levels.len() * LevelIndex::LENGTH;
        header.index.dfd_byte_offset = begin as u32;
        header.index.dfd_byte_length = description.len() as u32 + 4;
        if !values.is_empty() {
            header.index.kvd_byte_offset = (begin + description.len() + 4) as u32;
            header.index.kvd_byte_length = values.len() as u32;
        }
        let mut contents = header.index.dfd_byte_length.to_le_bytes().to_vec();
        contents.extend([description, values].concat());
        let mut places = Vec::new();
        for (level, unpacked) in self.levels.iter().rev() {
            contents.resize((begin + contents.len()).next_multiple_of(16) - begin, 0);
            let place = LevelIndex {
                byte_offset: (begin + contents.len()) as u64,
                byte_length: level.len() as u64,
                uncompressed_byte_length: *unpacked,
            };
            places.push(place);
            contents.extend(level);
        }
        let places = places.iter().rev().flat_map(LevelIndex::as_bytes).collect();
        [header.as_bytes().to_vec(), places, contents].concat()
    }
}

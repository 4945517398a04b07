//! Mode `TRIANGLES`: triangles that mostly share an edge with one shortly before
//! (`EXT_meshopt_compression`, appendix A, mode 1).

use super::stream::{self, Stream, unzigzag};
use crate::error::Reason;

const HEADER: u8 = 0xE1;
const TABLE_BYTES: usize = 16;

/// The sixteen values that came last.
struct Recent<T> {
    values: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { values: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.values[self.next] = value;
        self.next = (self.next + 1) % 16;
    }

    /// The last is 0.
    fn get(&self, back: u8) -> T {
        self.values[(self.next + 15 - usize::from(back & 15)) % 16]
    }
}

struct Decoder<'a> {
    stream: Stream<'a>,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    next: u32,
    last: u32,
}

/// Decompresses `count` indices, a multiple of three, of two or four bytes.
pub(super) fn decode(encoded: &[u8], count: usize, index_bytes: usize) -> Result<Vec<u8>, Reason> {
    let (mut stream, table) = Stream::open(encoded, HEADER, TABLE_BYTES)?;
    let codes = stream.take(count / 3)?;
    let mut decoder =
        Decoder { stream, edges: Recent::new(), vertices: Recent::new(), next: 0, last: 0 };
    let mut indices = Vec::with_capacity(count * index_bytes);
    for &code in codes {
        let triangle = match code {
            0xFE | 0xFF => {
                let pair = decoder.stream.byte()?;
                if pair == 0 {
                    decoder.next = 0;
                }
                let first = if code == 0xFE { 0 } else { 15 };
                decoder.corners([first, pair >> 4, pair & 15])?
            }
            0xF0.. => {
                let pair = table.get(usize::from(code & 15)).copied().unwrap_or(0);
                if pair >> 4 == 15 || pair & 15 == 15 {
                    return Err(Reason::malformed("its table has an entry that may not be there"));
                }
                decoder.corners([0, pair >> 4, pair & 15])?
            }
            _ => decoder.at_edge(code >> 4, code & 15)?,
        };
        triangle
            .into_iter()
            .for_each(|index| stream::write_index(&mut indices, index, index_bytes));
    }
    decoder.stream.close()?;
    Ok(indices)
}

impl Decoder<'_> {
    fn fresh(&mut self) -> u32 {
        let fresh = self.next;
        self.next = self.next.wrapping_add(1);
        fresh
    }

    fn explicit(&mut self) -> Result<u32, Reason> {
        self.last = self.last.wrapping_add(unzigzag(self.stream.varint()?));
        Ok(self.last)
    }

    /// A triangle at a recent edge.
    fn at_edge(&mut self, edge: u8, vertex: u8) -> Result<[u32; 3], Reason> {
        let [a, b] = self.edges.get(edge);
        let c = match vertex {
            0 => self.fresh(),
            1..=12 => self.vertices.get(vertex),
            13 => self.neighbour(u32::MAX),
            14 => self.neighbour(1),
            _ => self.explicit()?,
        };
        if !(1..=12).contains(&vertex) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    fn neighbour(&mut self, step: u32) -> u32 {
        self.last = self.last.wrapping_add(step);
        self.last
    }

    /// A triangle of which each corner is new (0), recent (1 to 14) or explicit (15).
    fn corners(&mut self, kinds: [u8; 3]) -> Result<[u32; 3], Reason> {
        // New ones are counted before explicit ones are read.
        let mut corners = kinds.map(|kind| match kind {
            0 => self.fresh(),
            15 => 0,
            recent => self.vertices.get(recent - 1),
        });
        for (corner, kind) in corners.iter_mut().zip(kinds) {
            if kind == 15 {
                *corner = self.explicit()?;
            }
        }
        for (corner, kind) in corners.into_iter().zip(kinds) {
            if kind == 0 || kind == 15 {
                self.vertices.push(corner);
            }
        }
        let [a, b, c] = corners;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        Ok(corners)
    }
}

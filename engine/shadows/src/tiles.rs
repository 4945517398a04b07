//! The places of maps: squares in the layers of an image. All squares of a layer have the same
//! size.

/// A square of texels in a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// The layer.
    pub layer: u32,
    /// The upper left corner in texels.
    pub origin: [u32; 2],
    /// The side in texels.
    pub side: u32,
}

/// The tiles of an image with a limited number of layers.
#[derive(Clone, Debug)]
pub struct TilePool {
    layer_side: u32,
    layers_max: u32,
    layers: Vec<Layer>,
}

/// A layer: the side of its tiles, 0 if it has none, and the free places.
#[derive(Clone, Debug, Default)]
struct Layer {
    side: u32,
    free: Vec<u32>,
}

impl TilePool {
    /// Creates a pool of layers with a side in texels, a power of two.
    #[must_use]
    pub fn new(layer_side: u32, layers_max: u32) -> Self {
        Self { layer_side, layers_max, layers: Vec::new() }
    }

    /// Returns the largest number of layers that was ever needed.
    #[must_use]
    pub fn layers(&self) -> u32 {
        self.layers.len() as u32
    }

    /// Returns the number of tiles of a side that are still free.
    #[must_use]
    pub fn room(&self, side: u32) -> usize {
        if side == 0 || side > self.layer_side {
            return 0;
        }
        let across = (self.layer_side / side) as usize;
        let of_layer = |layer: &Layer| match layer.side {
            0 => across * across,
            used if used == side => layer.free.len(),
            _ => 0,
        };
        let to_come = (self.layers_max as usize).saturating_sub(self.layers.len());
        self.layers.iter().map(of_layer).sum::<usize>() + to_come * across * across
    }

    /// Takes a tile whose side is a power of two, at most a layer's side; `None` if there is no
    /// room.
    pub fn take(&mut self, side: u32) -> Option<Tile> {
        let has_room = |layer: &Layer| layer.side == side && !layer.free.is_empty();
        let number = match self.layers.iter().position(has_room) {
            Some(number) => number,
            None => self.open(side)?,
        };
        let layer = self.layers.get_mut(number)?;
        let place = layer.free.pop()?;
        let across = self.layer_side / side;
        let origin = [place % across, place / across].map(|place| place * side);
        Some(Tile { layer: number as u32, origin, side })
    }

    /// Returns a tile to the pool.
    pub fn give_back(&mut self, tile: Tile) {
        let across = self.layer_side / tile.side;
        let Some(layer) = self.layers.get_mut(tile.layer as usize) else { return };
        let [x, y] = tile.origin.map(|texel| texel / tile.side);
        layer.free.push(y * across + x);
        if layer.free.len() as u32 == across * across {
            *layer = Layer::default();
        }
    }

    /// Opens an unused layer for tiles of a size. Returns its number.
    fn open(&mut self, side: u32) -> Option<usize> {
        if side == 0 || side > self.layer_side {
            return None;
        }
        let number = match self.layers.iter().position(|layer| layer.side == 0) {
            Some(number) => number,
            None if self.layers.len() < self.layers_max as usize => {
                self.layers.push(Layer::default());
                self.layers.len() - 1
            }
            None => return None,
        };
        let across = self.layer_side / side;
        *self.layers.get_mut(number)? = Layer { side, free: (0..across * across).rev().collect() };
        Some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlap(a: &Tile, b: &Tile) -> bool {
        let apart = |axis: usize| {
            a.origin[axis] + a.side <= b.origin[axis] || b.origin[axis] + b.side <= a.origin[axis]
        };
        a.layer == b.layer && !apart(0) && !apart(1)
    }

    #[test]
    fn tiles_never_overlap_and_come_back() {
        let mut pool = TilePool::new(256, 6);
        let mut tiles: Vec<Tile> = Vec::new();
        let mut random = 5_u32;
        for _ in 0..2000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let choice = random >> 16;
            if choice.is_multiple_of(3) && !tiles.is_empty() {
                let tile = tiles.swap_remove(choice as usize % tiles.len());
                pool.give_back(tile);
                continue;
            }
            let side = 64 << (choice % 3);
            let before = pool.room(64 << (choice % 3));
            if let Some(tile) = pool.take(side) {
                assert_eq!(pool.room(side) + 1, before);
                assert!(tile.origin.iter().all(|texel| texel + tile.side <= 256));
                assert!(tiles.iter().all(|other| !overlap(other, &tile)), "{tile:?}");
                tiles.push(tile);
            }
        }
        tiles.drain(..).for_each(|tile| pool.give_back(tile));
        assert!((0..6).all(|_| pool.take(256).is_some()), "all layers are free again");
        assert_eq!(pool.take(16), None);
    }

    #[test]
    fn sizes_that_no_layer_has_are_refused() {
        let mut pool = TilePool::new(256, 1);
        assert_eq!(pool.take(512), None);
        assert_eq!(pool.take(0), None);
        assert_eq!(pool.take(256), Some(Tile { layer: 0, origin: [0, 0], side: 256 }));
    }
}

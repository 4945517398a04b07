//! The budget: the number of vertices and corners of triangles that the scene may still have. Flat
//! normals, backs and solid lines create more than the file has, so they are counted when created.

use std::fmt;

use crate::Limits;

/// The remaining amounts of the limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    most: [u64; 2],
    used: [u64; 2],
    most_skinned: u64,
    skinned: u64,
}

/// The limit that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Over {
    what: &'static str,
    most: u64,
}

impl fmt::Display for Over {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, most } = self;
        write!(formatter, "with it the scene would have more than {most} {what}")
    }
}

impl Budget {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            most: [limits.vertices, limits.corners],
            used: [0; 2],
            most_skinned: limits.skinned_vertices,
            skinned: 0,
        }
    }

    /// Checks that these additional amounts are within the budget.
    pub(super) fn check(&self, vertices: u64, corners: u64) -> Result<(), Over> {
        let names = ["vertices", "corners of triangles"];
        for (place, more) in [vertices, corners].into_iter().enumerate() {
            // Indices have 32 bits, whatever the limits are.
            let is_over = self.used[place].saturating_add(more) > self.most[place];
            if is_over || more > u64::from(u32::MAX) {
                return Err(Over { what: names[place], most: self.most[place] });
            }
        }
        Ok(())
    }

    /// Takes these amounts out of the budget.
    pub(super) fn take(&mut self, vertices: u64, corners: u64) -> Result<(), Over> {
        self.check(vertices, corners)?;
        self.used[0] += vertices;
        self.used[1] += corners;
        Ok(())
    }

    /// Takes vertices for a skinned mesh, which were counted before.
    pub(super) fn take_skinned(&mut self, vertices: u64) -> Result<(), Over> {
        self.skinned = self.skinned.saturating_add(vertices);
        if self.skinned > self.most_skinned {
            let what = "vertices of meshes that change their form";
            return Err(Over { what, most: self.most_skinned });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_taken_is_gone() {
        let limits = Limits { vertices: 10, corners: 30, ..Limits::default() };
        let mut budget = Budget::new(&limits);
        assert_eq!(budget.take(10, 20), Ok(()));
        assert_eq!(budget.check(0, 10), Ok(()));
        let over = budget.take(1, 0).expect_err("there is none left");
        assert_eq!(over.to_string(), "with it the scene would have more than 10 vertices");
        assert_eq!(budget.take(0, 11).map_err(|over| over.what), Err("corners of triangles"));
        assert!(budget.check(u64::MAX, 0).is_err());
    }
}

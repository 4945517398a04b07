//! Seeded meshes: closed ones and faulty ones.

use antumbra_shadows::VolumeKind;
use glam::{Vec3, vec3};

use super::random::Random;

/// The fault of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No fault: a closed two-manifold that does not intersect itself.
    None,
    /// Triangles are missing.
    Open,
    /// Vertices lie anywhere, so the mesh intersects itself.
    SelfIntersecting,
    /// More than two triangles meet at edges.
    NonManifold,
    /// Triangles have no area, or hardly any.
    Degenerate,
    /// Some triangles are turned around.
    Turned,
    /// All triangles are turned around.
    InsideOut,
}

impl Fault {
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Open,
        Self::SelfIntersecting,
        Self::NonManifold,
        Self::Degenerate,
        Self::Turned,
        Self::InsideOut,
    ];

    /// Returns true if a mesh with this fault may be of a kind.
    pub fn allows(self, kind: VolumeKind) -> bool {
        match self {
            Self::None => kind == VolumeKind::Plain,
            Self::Degenerate | Self::SelfIntersecting => true,
            _ => kind == VolumeKind::Robust,
        }
    }
}

/// A mesh within about a metre of the origin.
pub struct SeededMesh {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<u32>,
}

impl SeededMesh {
    pub fn new(random: &mut Random, fault: Fault) -> Self {
        let mut mesh = Self::sphere(random);
        match fault {
            Fault::None => {}
            Fault::Open => mesh.drop_triangles(random),
            Fault::SelfIntersecting => {
                for position in &mut mesh.positions {
                    *position = random.direction() * (0.3 + random.unit());
                }
            }
            Fault::NonManifold => {
                for _ in 0..6 {
                    let corners: [u32; 3] = mesh.triangle(random);
                    let far = mesh.positions.len() as u32;
                    mesh.positions.push(random.direction() * (0.3 + random.unit()));
                    mesh.triangles.extend([corners[1], corners[0], far]);
                    mesh.triangles.extend([corners[1], corners[2], far]);
                }
            }
            Fault::Degenerate => mesh.flatten(random),
            Fault::Turned => {
                for at in mesh.triangles.chunks_mut(3).skip(1) {
                    if random.below(3) == 0 {
                        at.swap(1, 2);
                    }
                }
                mesh.triangles.swap(1, 2);
            }
            Fault::InsideOut => mesh.triangles.chunks_mut(3).for_each(|at| at.swap(1, 2)),
        }
        mesh
    }

    /// Creates a sphere of rings, with bumps that do not cross the surface.
    fn sphere(random: &mut Random) -> Self {
        let rings = 3 + random.below(3);
        let sectors = 4 + random.below(4);
        let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
        for ring in 1..rings {
            for sector in 0..sectors {
                let polar = ring as f32 / rings as f32 * std::f32::consts::PI;
                let around = sector as f32 / sectors as f32 * std::f32::consts::TAU;
                let flat = polar.sin();
                positions.push(vec3(flat * around.cos(), polar.cos(), flat * around.sin()));
            }
        }
        for position in &mut positions {
            *position *= 0.5 + 0.7 * random.unit();
        }
        let at = |ring: u32, sector: u32| 2 + (ring - 1) * sectors + sector % sectors;
        let mut triangles = Vec::new();
        for sector in 0..sectors {
            triangles.extend([0, at(1, sector + 1), at(1, sector)]);
            triangles.extend([1, at(rings - 1, sector), at(rings - 1, sector + 1)]);
            for ring in 1..rings - 1 {
                let a = at(ring, sector);
                let b = at(ring, sector + 1);
                let c = at(ring + 1, sector);
                let d = at(ring + 1, sector + 1);
                triangles.extend([a, b, c, b, d, c]);
            }
        }
        Self { positions, triangles }
    }

    fn triangle(&self, random: &mut Random) -> [u32; 3] {
        let first = 3 * random.below(self.triangles.len() as u32 / 3) as usize;
        [0, 1, 2].map(|corner| self.triangles[first + corner])
    }

    fn drop_triangles(&mut self, random: &mut Random) {
        let mut kept = Vec::new();
        for at in self.triangles.chunks(3).skip(1) {
            if random.below(3) > 0 {
                kept.extend(at);
            }
        }
        self.triangles = kept;
    }

    /// Moves vertices onto or close to other vertices and lines between them.
    fn flatten(&mut self, random: &mut Random) {
        for _ in 0..4 {
            let [a, b, c] = self.triangle(random).map(|vertex| vertex as usize);
            let middle = 0.5 * (self.positions[a] + self.positions[b]);
            self.positions[c] = match random.below(3) {
                0 => self.positions[a],
                1 => middle,
                _ => middle + 1e-7 * random.direction(),
            };
        }
    }
}

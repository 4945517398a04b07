//! Good and bad meshes of triangles, which do not share corners.

use glam::{Vec3, vec3};

/// Triangles, counter-clockwise seen from outside.
pub type Triangles = Vec<[Vec3; 3]>;

struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((mixed >> 33) % u64::from(end)) as u32
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

/// Returns a square of quads that is visible from above, `half` metres to each side.
pub fn sheet(half: f32, quads: u32) -> Triangles {
    let at = |x: u32, z: u32| {
        let along = |place: u32| half * (2.0 * place as f32 / quads as f32 - 1.0);
        vec3(along(x), 0.0, along(z))
    };
    let quad = |place: u32| {
        let x = place % quads;
        let z = place / quads;
        let a = at(x, z);
        let b = at(x, z + 1);
        let c = at(x + 1, z + 1);
        let d = at(x + 1, z);
        [[a, b, c], [a, c, d]]
    };
    (0..quads * quads).flat_map(quad).collect()
}

/// Returns a ball of about a metre, whose corners are moved by up to a part of the radius.
pub fn bumpy_sphere(seed: u64, bumps: f32) -> Triangles {
    const RINGS: u32 = 6;
    const SECTORS: u32 = 9;
    let mut random = Random(seed);
    let corners = (0..=RINGS * SECTORS).map(|_| 1.0 - bumps * random.unit());
    let sizes: Vec<f32> = corners.collect();
    let at = |ring: u32, sector: u32| {
        let around = (sector % SECTORS) as f32 / SECTORS as f32 * std::f32::consts::TAU;
        let polar = ring as f32 / RINGS as f32 * std::f32::consts::PI;
        let pole = if ring == 0 { Some(Vec3::Y) } else { None };
        let pole = pole.or((ring == RINGS).then_some(Vec3::NEG_Y));
        let direction = vec3(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin());
        let number = if pole.is_some() { 0 } else { ring * SECTORS + sector % SECTORS };
        pole.unwrap_or(direction) * sizes[number as usize]
    };
    let mut triangles = Vec::new();
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let a = at(ring, sector);
            let b = at(ring, sector + 1);
            let c = at(ring + 1, sector);
            let d = at(ring + 1, sector + 1);
            if ring > 0 {
                triangles.push([a, b, c]);
            }
            if ring + 1 < RINGS {
                triangles.push([b, d, c]);
            }
        }
    }
    triangles
}

/// Returns a mesh with a fault: open, turned in places, inside out, self-intersecting, with surplus
/// triangles at its edges, or with triangles without area.
pub fn bad_mesh(seed: u64) -> Triangles {
    let mut random = Random(seed ^ 0xBAD);
    let mut mesh = bumpy_sphere(seed, 0.4);
    match seed % 6 {
        0 => mesh.retain(|_| random.below(3) > 0),
        1 => mesh.iter_mut().for_each(|triangle| {
            if random.below(3) == 0 {
                triangle.swap(1, 2);
            }
        }),
        2 => mesh.iter_mut().for_each(|triangle| triangle.swap(1, 2)),
        3 => {
            let moved: Triangles = bumpy_sphere(seed + 1, 0.5);
            mesh.extend(moved.iter().map(|corners| corners.map(|at| at + vec3(0.5, 0.3, 0.2))));
        }
        4 => {
            for place in 0..8 {
                let [a, b, _] = mesh[place * 5];
                mesh.push([b, a, 1.6 * (a + b) * 0.5 + vec3(0.1, 0.2, 0.0)]);
            }
        }
        _ => {
            for place in 0..mesh.len() / 4 {
                let [a, b, c] = mesh[4 * place];
                let middle = 0.5 * (a + b);
                mesh.push([a, middle, b]);
                mesh.push([b, c, c]);
            }
        }
    }
    mesh
}

//! Compares the shadow volumes of seeded meshes, good and bad, with rays: the signed count of a
//! volume's boundary is not zero exactly where something lies between a point and its light.
#![allow(clippy::expect_used, reason = "a test fails by panicking")]

use antumbra_shadows::{
    Caps, Extrusion, NearSpan, VolumeCounting, VolumeEnd, VolumeKind, VolumeMesh, VolumeSource,
    VolumeTriangle,
};
use cull::{Aabb, Camera, CullView, Projection};
use glam::{DMat3, DMat4, DVec3, DVec4, Vec3, Vec4};

mod meshes;
mod random;

use meshes::{Fault, SeededMesh};
use random::Random;

/// A determinant relative to the product of its columns' lengths, below which a ray passes an edge
/// too closely for the test to judge.
const CLOSE: f64 = 1e-7;

fn determinant(columns: [DVec4; 4]) -> f64 {
    let size: f64 = columns.iter().map(|column| column.length()).product();
    let value = DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]).determinant();
    if size > 0.0 { value / size } else { 0.0 }
}

/// Returns the direction in which a segment crosses a triangle: 1 from outside in, -1 from inside
/// out, 0 not at all; `None` if it is too close to call.
fn crossing(from: DVec4, to: DVec4, triangle: VolumeTriangle) -> Option<i32> {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec4());
    if to.w == 0.0 && a.w == 0.0 && b.w == 0.0 && c.w == 0.0 {
        return crossing_at_infinity(from, to, [a, b, c]);
    }
    let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| determinant([from, to, p, q]));
    let ends = [from, to].map(|end| determinant([end, a, b, c]));
    let is_all = |sign: f64| sides.iter().all(|side| side * sign > CLOSE);
    // Two edges that are clearly passed on opposite sides suffice for a miss.
    let is_outside =
        sides.iter().any(|side| *side > CLOSE) && sides.iter().any(|side| *side < -CLOSE);
    if is_outside || (ends[0] > CLOSE && ends[1] > CLOSE) || (ends[0] < -CLOSE && ends[1] < -CLOSE)
    {
        return Some(0);
    }
    if !(is_all(1.0) || is_all(-1.0)) || ends.iter().any(|end| end.abs() <= CLOSE) {
        // A sliver without area is never crossed.
        let area = (b.truncate() - a.truncate()).cross(c.truncate() - a.truncate()).length();
        let is_flat = a.w > 0.0 && b.w > 0.0 && c.w > 0.0 && area < 1e-12;
        return is_flat.then_some(0);
    }
    Some(if ends[0] > 0.0 { 1 } else { -1 })
}

/// Returns the crossing of a ray with a triangle at infinity, which lies in the ray's direction.
fn crossing_at_infinity(from: DVec4, to: DVec4, cornerss: [DVec4; 3]) -> Option<i32> {
    let [a, b, c] = cornerss;
    let towards = to.truncate();
    let corners = [a, b, c].map(|corner| corner.truncate());
    let of = |p: DVec3, q: DVec3, r: DVec3| {
        DMat3::from_cols(p, q, r).determinant() / (p.length() * q.length() * r.length())
    };
    let [a3, b3, c3] = corners;
    let sides = [[a3, b3], [b3, c3], [c3, a3]].map(|[p, q]| of(towards, p, q));
    if sides.iter().any(|side| *side > CLOSE) && sides.iter().any(|side| *side < -CLOSE) {
        return Some(0);
    }
    let turn = of(a3, b3, c3);
    if turn.abs() <= CLOSE || sides.iter().any(|side| side.abs() <= CLOSE) {
        return (turn.abs() <= 1e-12).then_some(0);
    }
    if sides[0].signum() != turn.signum() {
        return Some(0);
    }
    Some(if determinant([from, a, b, c]) > 0.0 { 1 } else { -1 })
}

/// Returns the number of times a segment enters volumes minus the number of times it leaves them.
fn entered(from: DVec4, to: DVec4, boundary: &[VolumeTriangle]) -> Option<i32> {
    boundary.iter().map(|triangle| crossing(from, to, *triangle)).sum()
}

/// Returns the numbers of triangles between a point and a light: those that face the light, and
/// all.
fn blockers(mesh: &SeededMesh, point: Vec3, light: Vec4) -> Option<(i32, i32)> {
    let from = point.as_dvec3().extend(1.0);
    let to = light.as_dvec4();
    let mut facing = 0;
    let mut all = 0;
    for corners in mesh.triangles.chunks(3) {
        let triangle = [0, 1, 2].map(|corner| mesh.positions[corners[corner] as usize].extend(1.0));
        let crossed = crossing(from, to, triangle)?;
        // On the way to the light, a triangle that faces the light is crossed from back to front.
        facing += i32::from(crossed == -1);
        all += i32::from(crossed != 0);
    }
    Some((facing, all))
}

#[derive(Default)]
struct Seen {
    lit: u32,
    shaded: u32,
    plain: u32,
    robust: u32,
    z_pass: u32,
    /// Volumes that end at a plane, of suns and of lamps.
    ended: [u32; 2],
    unclear: u32,
}

fn check_seed(seed: u64, seen: &mut Seen) {
    let mut random = Random(seed);
    let fault = Fault::ALL[seed as usize % Fault::ALL.len()];
    let mesh = SeededMesh::new(&mut random, fault);
    let SeededMesh { positions, triangles } = &mesh;
    let volumes =
        VolumeMesh::new(&VolumeSource { positions, triangles, motions: &[] }).expect("a mesh");
    assert!(fault.allows(volumes.kind()), "seed {seed}: {fault:?} is {:?}", volumes.kind());
    let bounds = Aabb::new(
        positions.iter().copied().fold(Vec3::INFINITY, Vec3::min),
        positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max),
    );
    for _ in 0..4 {
        let light = match random.below(2) {
            0 => random.direction().extend(0.0),
            _ => (random.direction() * (0.2 + 4.0 * random.unit())).extend(1.0),
        };
        let kind = volumes.kind().towards(&bounds, light);
        let end = match random.below(2) {
            0 => VolumeEnd::INFINITY,
            _ => {
                let ends = VolumeEnd::of(&view(), light, &AROUND);
                ends[VolumeEnd::nearest(&ends, &bounds)]
            }
        };
        let is_local = usize::from(light.w > 0.0);
        seen.ended[is_local] += u32::from(end != VolumeEnd::INFINITY);
        let extrude =
            |kind, caps| Extrusion { light, kind, caps, end }.volumes(&volumes, positions);
        let closed = extrude(kind, Caps::Both);
        assert!(is_closed(&closed), "seed {seed}: the volumes are open");
        for _ in 0..12 {
            let eye = random.direction() * (0.5 + 4.0 * random.unit());
            let point = random.direction() * (3.0 * random.unit());
            let Some((facing, all)) = blockers(&mesh, point, light) else {
                seen.unclear += 1;
                continue;
            };
            if kind == VolumeKind::Plain && all > 2 * facing {
                continue; // in an inside-out fold of a mesh that meets itself
            }
            let from = eye.as_dvec3().extend(1.0);
            let to = point.as_dvec3().extend(1.0);
            let behind = (to - from).truncate().extend(0.0);
            let Some(left) = entered(to, behind, &closed).map(|entered| -entered) else {
                seen.unclear += 1;
                continue;
            };
            let in_shadow = all > 0;
            let told = format!("seed {seed}, {fault:?}, {kind:?}: {left} of {all} at {point}");
            assert_eq!(left != 0, in_shadow, "z-fail: {told}");
            let wanted = if kind == VolumeKind::Plain { facing } else { all };
            assert_eq!(left, wanted, "z-fail counts: {told}");
            seen.lit += u32::from(!in_shadow);
            seen.shaded += u32::from(in_shadow);
            seen.plain += u32::from(kind == VolumeKind::Plain);
            seen.robust += u32::from(kind == VolumeKind::Robust);
            let span = [eye, eye + 0.01 * random.direction(), eye + 0.01 * random.direction()];
            if NearSpan(&span).counting(&bounds, light) == VolumeCounting::ZFail {
                continue;
            }
            // In a real frame, drawn surfaces hide the near cap of a closed mesh. Here nothing is
            // drawn, so the near cap is needed, but the far cap is not.
            let open = extrude(kind, Caps::Near);
            let Some(crossed) = entered(from, to, &open) else { continue };
            assert_eq!(crossed, left, "z-pass: {told}");
            seen.z_pass += 1;
        }
    }
}

/// The box around all eyes and points.
const AROUND: Aabb = Aabb::new(Vec3::splat(-5.0), Vec3::splat(5.0));

/// Returns a view from the middle of the box.
fn view() -> CullView {
    let projection = Projection::perspective(1.0);
    let camera = Camera { eye: Vec3::ZERO, forward: Vec3::X, up: Vec3::Y, projection, near: 0.1 };
    CullView::new(&camera, [64, 48], 8)
}

/// Returns true if the edges of triangles cancel in pairs of opposite directions. An edge at
/// infinity whose ends are one point does not count.
fn is_closed(boundary: &[VolumeTriangle]) -> bool {
    let name = |corner: Vec4| corner.to_array().map(|number| (number + 0.0).to_bits());
    let mut edges = std::collections::HashMap::new();
    for &[a, b, c] in boundary {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((name(from), name(to))).or_insert(0) += 1;
            *edges.entry((name(to), name(from))).or_insert(0) -= 1;
        }
    }
    edges.values().all(|sum| *sum == 0)
}

#[test]
fn counts_agree_with_rays_over_many_meshes() {
    let mut seen = Seen::default();
    for seed in 0..420 {
        check_seed(seed, &mut seen);
    }
    let Seen { lit, shaded, plain, robust, z_pass, ended, unclear } = seen;
    let told = format!(
        "{lit} lit, {shaded} shaded, {plain} plain, {robust} robust, {z_pass} z-pass, {unclear} unclear"
    );
    assert!(lit > 2000 && shaded > 2000 && plain > 1000 && robust > 5000, "{told}");
    assert!(z_pass > 2000 && unclear < 2000, "{told}");
    assert!(ended[0] > 300 && ended[1] > 100, "{ended:?} of 1680 lights' volumes end");
}

#[test]
fn skinned_meshes_stay_closed_in_any_pose() {
    let mut random = Random(11);
    for _ in 0..60 {
        let mesh = SeededMesh::new(&mut random, Fault::None);
        let SeededMesh { positions, triangles } = &mesh;
        let motions: Vec<u32> = positions.iter().map(|at| u32::from(at.y > 0.0)).collect();
        let source = VolumeSource { positions, triangles, motions: &motions };
        let volumes = VolumeMesh::new(&source).expect("a mesh");
        assert_eq!(volumes.kind(), VolumeKind::Plain);
        let posed: Vec<Vec3> =
            positions.iter().map(|at| *at + if at.y > 0.0 { Vec3::ONE } else { Vec3::X }).collect();
        let light = random.direction().extend(1.0) * Vec4::new(9.0, 9.0, 9.0, 1.0);
        let end = VolumeEnd::INFINITY;
        for kind in [VolumeKind::Plain, VolumeKind::Robust] {
            let extrusion = Extrusion { light, kind, caps: Caps::Both, end };
            assert!(is_closed(&extrusion.volumes(&volumes, &posed)));
        }
    }
}

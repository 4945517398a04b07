//! Exact counts of edges and chains.

use std::f32::consts::TAU;

use glam::vec3;

use super::*;

/// The corners of quads and triangles, each with vertices of its own.
#[derive(Default)]
struct Soup {
    positions: Vec<Vec3>,
    triangles: Vec<u32>,
}

impl Soup {
    fn triangle(&mut self, a: Vec3, b: Vec3, c: Vec3) {
        let first = self.positions.len() as u32;
        self.positions.extend([a, b, c]);
        self.triangles.extend([first, first + 1, first + 2]);
    }

    fn quad(&mut self, a: Vec3, b: Vec3, c: Vec3, d: Vec3) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    fn cube() -> Self {
        let corner = |id: u32| vec3((id & 1) as f32, (id >> 1 & 1) as f32, (id >> 2) as f32);
        let mut soup = Self::default();
        let sides =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        for [a, b, c, d] in sides {
            soup.quad(corner(a), corner(b), corner(c), corner(d));
        }
        soup
    }

    fn cylinder(sides: u32) -> Self {
        let at = |side: u32, y: f32| {
            let angle = TAU * (side % sides) as f32 / sides as f32;
            vec3(angle.cos(), y, angle.sin())
        };
        let mut soup = Self::default();
        for side in 0..sides {
            soup.quad(at(side, 0.0), at(side, 2.0), at(side + 1, 2.0), at(side + 1, 0.0));
            soup.triangle(at(side, 2.0), Vec3::Y * 2.0, at(side + 1, 2.0));
            soup.triangle(at(side + 1, 0.0), Vec3::ZERO, at(side, 0.0));
        }
        soup
    }

    fn edges(&self) -> FeatureEdges {
        self.edges_of(&[])
    }

    fn edges_of(&self, faces: &[u32]) -> FeatureEdges {
        let Self { positions, triangles } = self;
        let source = EdgeSource { positions, triangles, faces };
        FeatureEdges::new(&source, &EdgeRules::default())
    }

    fn length(&self, edges: &FeatureEdges, chain: u32) -> f64 {
        edges.chain_length(chain, &self.positions, &Affine3A::IDENTITY)
    }
}

fn count(edges: &FeatureEdges, kind: EdgeKind) -> usize {
    edges.segments().iter().filter(|segment| segment.kind == kind).count()
}

#[test]
fn a_cube_has_twelve_edges() {
    let mut cube = Soup::cube();
    let edges = cube.edges();
    assert_eq!((edges.segments().len(), edges.chains().len()), (12, 12));
    assert_eq!(count(&edges, EdgeKind::Crease), 12);
    assert!((0..12).all(|chain| cube.length(&edges, chain) == 1.0));
    // Mixed winding, backs of triangles, and corners on one point change nothing.
    for triangle in cube.triangles.as_chunks_mut::<3>().0.iter_mut().step_by(3) {
        triangle.swap(0, 1);
    }
    let backs: Vec<u32> = cube.triangles.iter().rev().copied().collect();
    cube.triangles.extend(backs);
    cube.triangles.extend([0, 0, 1, 2, 2, 2]);
    assert_eq!(cube.edges(), edges);
}

#[test]
fn a_cylinder_has_two_rims_and_no_edges_on_its_side() {
    let cylinder = Soup::cylinder(32);
    let edges = cylinder.edges();
    assert_eq!((edges.features().len(), count(&edges, EdgeKind::Crease)), (64, 64));
    let chains: Vec<_> =
        edges.chains().iter().map(|chain| (chain.is_closed, chain.segments.len())).collect();
    assert_eq!(chains, [(true, 32), (true, 32)]);
    // The sides fold a little; diagonals and the spokes of the caps are flat.
    assert_eq!(edges.smooth().len(), 32);
    let is_along = |segment: &EdgeSegment| {
        let [from, to] = [segment.from, segment.to].map(|end| cylinder.positions[end as usize]);
        from.x == to.x && from.z == to.z && segment.right.is_some()
    };
    assert!(edges.smooth().iter().all(is_along));
    let around = 64.0 * f64::from(TAU / 64.0).sin();
    assert!([0, 1].iter().all(|chain| (cylinder.length(&edges, *chain) - around).abs() < 1.0e-5));
    let rules = EdgeRules { keeps_flat: true, ..EdgeRules::default() };
    let Soup { positions, triangles } = &cylinder;
    let all = FeatureEdges::new(&EdgeSource { positions, triangles, faces: &[] }, &rules);
    assert_eq!(all.segments().len(), 64 + 32 + 32 + 64);
}

#[test]
fn the_length_of_an_edge_is_that_of_all_its_triangles() {
    // A bar whose upper edge is cut into five parts on one side only, into seven on the other.
    let mut bar = Soup::default();
    let near = vec3(0.0, 0.0, 0.0);
    let far = vec3(0.0, 0.0, 1.0);
    let height = vec3(0.0, 1.0, 0.0);
    for part in 0..5 {
        let [a, b] = [part, part + 1].map(|end| vec3(end as f32 * 2.0, 0.0, 0.0));
        bar.quad(near + a, near + b, near + b + height, near + a + height);
        bar.quad(near + a + height, near + b + height, far + b + height, far + a + height);
    }
    let edges = bar.edges();
    let of = |kind| {
        let chains = (0..).zip(edges.chains());
        let is_of =
            |chain: &EdgeChain| edges.segments()[chain.segments.start as usize].kind == kind;
        chains.filter(|(_, chain)| is_of(chain)).map(|(id, _)| id).collect::<Vec<u32>>()
    };
    let creases = of(EdgeKind::Crease);
    assert_eq!((creases.len(), bar.length(&edges, creases[0])), (1, 10.0));
    let chain = &edges.chains()[creases[0] as usize];
    assert_eq!((chain.segments.len(), chain.is_closed), (5, false));
    assert!(chain.segments.clone().all(|id| edges.chain_of(id) == Some(creases[0])));
    // The border goes around two sheets: two long edges, two short ones on either side.
    let mut borders: Vec<_> =
        of(EdgeKind::Border).iter().map(|id| bar.length(&edges, *id)).collect();
    borders.sort_by(f64::total_cmp);
    assert_eq!(borders, [1.0, 1.0, 1.0, 1.0, 10.0, 10.0]);
    let stretched = Affine3A::from_scale(vec3(3.0, 1.0, 1.0));
    assert_eq!(edges.chain_length(creases[0], &bar.positions, &stretched), 30.0);
    assert_eq!(edges.chain_length(99, &bar.positions, &stretched), 0.0);
}

#[test]
fn three_faces_at_an_edge_and_labels_are_features() {
    let mut sheets = Soup::default();
    for wing in [vec3(1.0, 0.1, 0.0), vec3(-1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)] {
        sheets.triangle(Vec3::ZERO, Vec3::Y, wing);
    }
    let edges = sheets.edges();
    assert_eq!(count(&edges, EdgeKind::NonManifold), 1);
    assert_eq!(count(&edges, EdgeKind::Border), 6);
    let mut flat = Soup::default();
    flat.quad(Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y);
    assert_eq!(flat.edges().segments().len(), 4, "the diagonal is flat");
    let parted = flat.edges_of(&[4, 7]);
    assert_eq!(count(&parted, EdgeKind::FaceBorder), 1);
    assert_eq!(flat.edges_of(&[4, 4]), flat.edges());
}

#[test]
fn slivers_have_no_edges_of_their_own() {
    // Two coplanar halves whose border is cut in the middle on one side: the gap has no area.
    let mut plate = Soup::default();
    let middle = vec3(0.5, 0.0, 0.0);
    plate.triangle(Vec3::ZERO, Vec3::X, Vec3::Y);
    plate.triangle(Vec3::ZERO, middle, Vec3::NEG_Y);
    plate.triangle(middle, Vec3::X, Vec3::NEG_Y);
    assert_eq!(plate.edges().features().len(), 3 + 4, "three borders meet where it is cut");
    plate.triangle(Vec3::ZERO, middle, Vec3::X);
    assert_eq!(plate.edges().features().len(), 4);
    assert!(plate.edges().smooth().is_empty());
}

#[test]
fn nothing_has_no_edges() {
    assert_eq!(Soup::default().edges(), FeatureEdges::default());
    let source = EdgeSource { positions: &[Vec3::ZERO], triangles: &[0, 1, 2], faces: &[] };
    assert_eq!(FeatureEdges::new(&source, &EdgeRules::default()), FeatureEdges::default());
}

//! A hierarchy over point and spot lights, which finds the strongest lights that reach a box
//! without testing all lights.

use std::ops::Range;

use cull::Aabb;
use glam::Vec3;
use scene::limits::MAX_LIGHTS_PER_OBJECT;
use scene::{LightKind, PunctualLight};

use crate::shading::surfaces::lights::{is_bright, reach_m, strongest_part};

/// The data that decides if a light reaches a box, and how strongly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// The place of the light in the light table.
    pub(crate) entry: u32,
    pub(crate) position: Vec3,
    pub(crate) reach_m: f32,
    candela: f32,
}

/// The bound of the lights below a node.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// The box around their positions.
    bounds: Aabb,
    /// The largest squared reach; negative if all lights are dark.
    reach_squared: f32,
    candela: f32,
    first_entry: u32,
}

/// Lights in a binary tree that is split at medians. Nodes are stored depth first, so a subtree of
/// `n` lights has `2 n - 1` nodes, and a node does not need to store its children.
#[derive(Debug, Default)]
pub(crate) struct LightTree {
    /// The reach of each light: `None` for directional lights and for lights that give no light.
    reaches: Vec<Option<Reach>>,
    /// The lights in the order of the leaves.
    order: Vec<u32>,
    /// The leaf of each light.
    leaves: Vec<u32>,
    nodes: Vec<Node>,
    /// The number of lights replaced since the tree was split.
    replaced: usize,
}

/// The strongest lights that reach a box.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Strongest {
    /// The lights from the strongest on. Equal lights are in the order of the table.
    lights: [RankedLight; MAX_LIGHTS_PER_OBJECT],
    /// The number of lights.
    count: usize,
    /// True if other lights may reach the box as well.
    pub(crate) leaves_out: bool,
    /// The number of visited nodes.
    pub(crate) visits: usize,
}

/// A light in the order of strength, or a bound on the strongest of several lights.
#[derive(Clone, Copy, Debug, Default)]
struct RankedLight {
    /// The light that arrives at the nearest point of the box.
    lux: f32,
    /// The place in the light table; of several lights, the first.
    entry: u32,
}

/// A node and the range of its leaves.
#[derive(Clone, Debug)]
struct Subtree {
    node: usize,
    leaves: Range<usize>,
}

/// A subtree to visit.
#[derive(Clone, Debug)]
struct Open {
    subtree: Subtree,
    /// A bound on its strongest light.
    at_most: RankedLight,
}

impl LightTree {
    /// Builds the tree of lights, which are in the order of the scene.
    pub(crate) fn new(reaches: Vec<Option<Reach>>) -> Self {
        let count = reaches.len();
        let nodes = vec![Node::DARK; (2 * count).saturating_sub(1)];
        let order = (0..count as u32).collect();
        let mut tree = Self { reaches, order, leaves: vec![0; count], nodes, replaced: 0 };
        tree.rebuild();
        tree
    }

    fn rebuild(&mut self) {
        let position = |light: u32| {
            let reach = self.reaches.get(light as usize).copied().flatten();
            reach.map_or(Vec3::ZERO, |reach| reach.position)
        };
        split(&mut self.order, &position);
        for (leaf, light) in (0..).zip(&self.order) {
            if let Some(place) = self.leaves.get_mut(*light as usize) {
                *place = leaf;
            }
        }
        self.replaced = 0;
        self.refit(0, 0..self.order.len(), &(0..self.order.len()));
    }

    /// Recomputes the nodes above the `changed` leaves, beginning with `node` over `leaves`. The
    /// depth is the logarithm of the number of lights.
    fn refit(&mut self, node: usize, leaves: Range<usize>, changed: &Range<usize>) {
        if leaves.is_empty() || leaves.start >= changed.end || changed.start >= leaves.end {
            return;
        }
        let now = if leaves.len() == 1 {
            let light = self.order.get(leaves.start).copied().unwrap_or_default();
            Node::of(self.reaches.get(light as usize).copied().flatten())
        } else {
            let [left, right] = Subtree { node, leaves }.children().map(|child| {
                let Subtree { node, leaves } = child;
                self.refit(node, leaves, changed);
                self.node(node)
            });
            left.and(right)
        };
        if let Some(node) = self.nodes.get_mut(node) {
            *node = now;
        }
    }

    fn node(&self, node: usize) -> Node {
        self.nodes.get(node).copied().unwrap_or(Node::DARK)
    }

    /// Replaces a light and returns the former one. The tree is built again once there were more
    /// replacements than lights.
    pub(crate) fn replace(&mut self, light: usize, now: Option<Reach>) -> Option<Reach> {
        let (Some(reach), Some(leaf)) = (self.reaches.get_mut(light), self.leaves.get(light))
        else {
            return None;
        };
        let before = std::mem::replace(reach, now);
        let leaf = *leaf as usize;
        self.replaced += 1;
        if self.replaced > self.order.len() {
            self.rebuild();
        } else {
            self.refit(0, 0..self.order.len(), &(leaf..leaf + 1));
        }
        before
    }

    /// Finds the strongest lights that reach a box. Stops after `most_visits` nodes with the lights
    /// found so far. The most promising nodes are visited first, so these are likely the strongest.
    pub(crate) fn strongest(&self, bounds: &Aabb, most_visits: usize) -> Strongest {
        let mut found = Strongest::default();
        if bounds.is_empty() || self.order.is_empty() {
            return found;
        }
        let mut open: Vec<Open> = Vec::with_capacity(32);
        open.extend(self.open(Subtree { node: 0, leaves: 0..self.order.len() }, bounds));
        while let Some(Open { subtree, at_most }) = open.pop() {
            if found.is_hopeless(at_most) {
                continue;
            }
            if found.visits >= most_visits {
                found.leaves_out = true;
                break;
            }
            found.visits += 1;
            if subtree.leaves.len() == 1 {
                found.take(at_most);
                continue;
            }
            let [left, right] = subtree.children().map(|child| self.open(child, bounds));
            match (left, right) {
                (Some(left), Some(right)) if left.at_most.is_stronger_than(&right.at_most) => {
                    open.extend([right, left]);
                }
                (left, right) => open.extend(left.into_iter().chain(right)),
            }
        }
        found
    }

    /// Returns the bound of a node to visit; `None` if none of its lights reaches the box. At a
    /// leaf, whose node is a point, rounding is the same as for the light itself. A node above is
    /// never weaker, since rounding keeps the order of differences, squares, sums and quotients.
    fn open(&self, subtree: Subtree, bounds: &Aabb) -> Option<Open> {
        let own = self.node(subtree.node);
        let gap = (bounds.min - own.bounds.max).max(own.bounds.min - bounds.max).max(Vec3::ZERO);
        let distance_squared = gap.length_squared();
        let lux = own.candela / distance_squared.max(1.0e-4);
        let at_most = RankedLight { lux, entry: own.first_entry };
        (distance_squared <= own.reach_squared).then_some(Open { subtree, at_most })
    }
}

impl Subtree {
    /// Returns the subtrees of the children of an inner node.
    fn children(self) -> [Self; 2] {
        let Self { node, leaves } = self;
        let middle = leaves.start + leaves.len() / 2;
        let right = node + 2 * (leaves.len() / 2);
        let left = Self { node: node + 1, leaves: leaves.start..middle };
        [left, Self { node: right, leaves: middle..leaves.end }]
    }
}

impl RankedLight {
    /// Returns true if this light comes before another: it is stronger, or as strong and earlier in
    /// the table.
    fn is_stronger_than(&self, other: &Self) -> bool {
        other.lux.total_cmp(&self.lux).then(self.entry.cmp(&other.entry)).is_lt()
    }
}

/// Orders lights such that halves, recursively, lie apart from each other where possible.
fn split(lights: &mut [u32], position: &impl Fn(u32) -> Vec3) {
    if lights.len() < 2 {
        return;
    }
    let bounds = lights.iter().fold(Aabb::EMPTY, |bounds, light| {
        let position = position(*light);
        bounds.union(&Aabb::new(position, position))
    });
    let axis = (bounds.max - bounds.min).max_position();
    let middle = lights.len() / 2;
    lights.select_nth_unstable_by(middle, |a, b| {
        let order = position(*a)[axis].total_cmp(&position(*b)[axis]);
        order.then(a.cmp(b))
    });
    let (left, right) = lights.split_at_mut(middle);
    split(left, position);
    split(right, position);
}

impl Reach {
    /// Returns the reach of a light; `None` for a light that is directional, dark, or not in the
    /// table.
    pub(crate) fn of(light: &PunctualLight, entry: Option<u32>) -> Option<Self> {
        let is_local = light.kind != LightKind::Directional && is_bright(light);
        let entry = entry.filter(|_| is_local)?;
        let position = light.position;
        let candela = strongest_part(light);
        Some(Self { entry, position, reach_m: reach_m(light), candela })
    }
}

impl Node {
    const DARK: Self =
        Self { bounds: Aabb::EMPTY, reach_squared: -1.0, candela: 0.0, first_entry: u32::MAX };

    fn of(reach: Option<Reach>) -> Self {
        reach.map_or(Self::DARK, |reach| Self {
            bounds: Aabb::new(reach.position, reach.position),
            reach_squared: reach.reach_m * reach.reach_m,
            candela: reach.candela,
            first_entry: reach.entry,
        })
    }

    fn and(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(&other.bounds),
            reach_squared: self.reach_squared.max(other.reach_squared),
            candela: self.candela.max(other.candela),
            first_entry: self.first_entry.min(other.first_entry),
        }
    }
}

impl Strongest {
    /// Returns the places of the lights in the table.
    pub(crate) fn entries(&self) -> impl Iterator<Item = u32> + '_ {
        self.lights.iter().take(self.count).map(|light| light.entry)
    }

    /// Returns true if a light that is at most as strong as `at_most` would be left out. Some light
    /// must already be left out.
    fn is_hopeless(&self, at_most: RankedLight) -> bool {
        let weakest = self.lights.last().filter(|_| self.leaves_out);
        weakest.is_some_and(|weakest| weakest.is_stronger_than(&at_most))
    }

    fn take(&mut self, light: RankedLight) {
        self.leaves_out |= self.count == self.lights.len();
        let stronger = |other: &&RankedLight| other.is_stronger_than(&light);
        let place = self.lights.iter().take(self.count).take_while(stronger).count();
        self.count = (self.count + 1).min(self.lights.len());
        if let Some(behind @ [_, ..]) = self.lights.get_mut(place..self.count) {
            behind.rotate_right(1);
            behind[0] = light;
        }
    }
}

//! Groups of images that share texture pages. Groups are joined until they are few enough, within a
//! memory limit that follows from the size of the images.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use scene::{Encoding, ImageId, Sampler, Wrap};

/// The bytes that pages may always take, even if their images are smaller.
pub(crate) const SMALL_PAGES_BYTES: u64 = 256 << 20;

/// The highest number of groups that are joined in pairs. More groups are first joined by classes.
const MOST_PAIRED: usize = 96;

/// Images of one size, encoding and sampler.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) size: [u32; 2],
    pub(super) encoding: Encoding,
    pub(super) sampler: Sampler,
    pub(super) images: Vec<ImageId>,
    /// The numbers of the groups that were joined into this one.
    pub(super) members: Vec<usize>,
}

impl Group {
    fn pages(&self, max_layers: u32) -> usize {
        self.images.len().div_ceil(max_layers as usize)
    }

    fn texels(&self) -> u64 {
        texels(self.size) * self.images.len() as u64
    }

    fn pixels(&self) -> u64 {
        pixels(self.size) * self.images.len() as u64
    }

    /// Adds the images of another group, without duplicates.
    fn absorb(&mut self, other: Self) {
        let mut known: HashSet<ImageId> = self.images.iter().copied().collect();
        self.images.extend(other.images.into_iter().filter(|image| known.insert(*image)));
        self.members.extend(other.members);
    }
}

/// Returns the number of texels of an image with all its mip maps.
fn texels(size: [u32; 2]) -> u64 {
    let levels = size[0].max(size[1]).max(1).ilog2();
    (0..=levels).map(|level| pixels(size.map(|side| (side >> level).max(1)))).sum()
}

fn pixels(size: [u32; 2]) -> u64 {
    let [width, height] = size;
    u64::from(width) * u64::from(height)
}

/// Returns the highest number of texels that pages may have, with all mip maps: twice the texels of
/// the images, or [`SMALL_PAGES_BYTES`] if that is more. An image that is sampled both as colours
/// and as numbers counts twice.
pub(super) fn most_texels(groups: &[Group]) -> u64 {
    let mut known = HashSet::new();
    let own: u64 = groups
        .iter()
        .flat_map(|group| group.images.iter().map(move |image| (group, *image)))
        .filter(|(group, image)| known.insert((*image, group.encoding)))
        .map(|(group, _)| texels(group.size))
        .sum();
    (2 * own).max(SMALL_PAGES_BYTES / 4)
}

/// Joins groups until their pages are few enough and take at most `most_texels`. The number of
/// pages stays too high only if an encoding has more images than all pages hold.
pub(super) fn joined(
    groups: Vec<Group>,
    max_layers: u32,
    max_pages: usize,
    most_texels: u64,
) -> Vec<Group> {
    let mut groups = without_copies(groups, most_texels);
    let pages =
        |groups: &[Group]| groups.iter().map(|group| group.pages(max_layers)).sum::<usize>();
    if groups.len() > MOST_PAIRED && pages(&groups) > max_pages {
        groups = by_classes(groups, most_texels);
    }
    debug_assert!(groups.len() <= MOST_PAIRED || pages(&groups) <= max_pages);
    let mut total = groups.iter().map(Group::texels).sum::<u64>();
    while pages(&groups) > max_pages {
        let pairs = (0..groups.len()).flat_map(|from| (0..groups.len()).map(move |to| (from, to)));
        let possible = pairs.filter(|(from, to)| from != to).flat_map(|(from, to)| {
            let room = most_texels.saturating_sub(total);
            let joinings = groups.get(from).zip(groups.get(to));
            let joinings = joinings.map(|(a, b)| joinings_of(a, b, max_layers, room));
            joinings
                .into_iter()
                .flatten()
                .flatten()
                .map(move |(found, size)| (found, from, to, size))
        });
        // Nothing can be joined any more if a scene has more images of one kind than all pages
        // hold.
        let Some((_, from, to, size)) = possible.min() else { break };
        let moved = groups.swap_remove(from);
        // The last group has moved to the place of the removed one.
        let target = if to == groups.len() { from } else { to };
        if let Some(group) = groups.get_mut(target) {
            total -= group.texels() + moved.texels();
            group.absorb(moved);
            group.size = size;
            total += group.texels();
        }
    }
    groups
}

/// The cost of moving the images of one group to another, ordered by the loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Joining {
    /// True if the number of pages stays the same.
    wins_nothing: bool,
    /// The kind of change: images are enlarged before any is shrunk. Then samplers with the same
    /// wrapping are given up, and other samplers last.
    look: u8,
    /// The highest number of mip levels that an image loses.
    lost_levels: u32,
    /// The difference in the pixels of images.
    changed: u64,
}

/// Returns the ways to move the images of one group to another, within `room` for more texels. The
/// new size is the size of the other group, or a size between both that takes no more texels than
/// before.
fn joinings_of(
    from: &Group,
    to: &Group,
    max_layers: u32,
    room: u64,
) -> [Option<(Joining, [u32; 2])>; 2] {
    if from.encoding != to.encoding {
        return [None; 2];
    }
    let count = (from.images.len() + to.images.len()) as u64;
    let before = from.texels() + to.texels();
    let joined = (count as usize).div_ceil(max_layers as usize);
    let wins_nothing = joined >= from.pages(max_layers) + to.pages(max_layers);
    let sampler_lost = match (from.sampler == to.sampler, from.sampler.wrap == to.sampler.wrap) {
        (true, _) => 0,
        (false, true) => 2,
        (false, false) => 4,
    };
    let joining = |size: [u32; 2]| {
        let lost = |group: &Group| {
            let lost = |side: usize| (group.size[side].div_ceil(size[side].max(1))).max(1);
            lost(0).max(lost(1)).next_power_of_two().ilog2()
        };
        let lost_levels = lost(from).max(lost(to));
        let changed =
            |group: &Group| (pixels(size) * group.images.len() as u64).abs_diff(group.pixels());
        let look = sampler_lost + u8::from(lost_levels > 0);
        let changed = changed(from) + changed(to);
        (Joining { wins_nothing, look, lost_levels, changed }, size)
    };
    let whole = texels(to.size) * count <= before + room;
    // With a size between both, the direction of the move matters only for the sampler.
    let between = between(from.size, to.size);
    [whole.then(|| joining(to.size)), Some(joining(within(between, count, before)))]
}

/// Returns a size between two, in the middle of their ratio.
fn between(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    std::array::from_fn(|side| (u64::from(a[side]) * u64::from(b[side])).isqrt() as u32)
}

/// Halves the longer side of a size until `count` images of it take at most `most_texels`, or a
/// texel each.
fn within(mut size: [u32; 2], count: u64, most_texels: u64) -> [u32; 2] {
    while texels(size) * count > most_texels && size != [1, 1] {
        let larger = usize::from(size[1] > size[0]);
        size[larger] = (size[larger] / 2).max(1);
    }
    size
}

/// Returns the groups with fewer samplers if the layers of images, one per sampler, take too much
/// memory. Samplers with the same wrapping are given up first.
fn without_copies(mut groups: Vec<Group>, most_texels: u64) -> Vec<Group> {
    for kept in [Kept::Wrap, Kept::Nothing] {
        if groups.iter().map(Group::texels).sum::<u64>() > most_texels {
            let classes = classes(groups, |group| (group.size, kept.of(group)));
            groups = classes.into_iter().filter_map(|class| united(class, |a, _| a)).collect();
        }
    }
    groups
}

/// Joins groups of similar sizes by classes, which are made coarser until there are few enough.
fn by_classes(groups: Vec<Group>, most_texels: u64) -> Vec<Group> {
    let class = |group: &Group, (step, kept): (u32, Kept)| {
        (group.size.map(|side| side.max(1).ilog2() / step), kept.of(group))
    };
    let coarsest = (u32::BITS, Kept::Wrap);
    let steps = [(1, Kept::All), (1, Kept::Wrap), (2, Kept::Wrap), (4, Kept::Wrap), coarsest];
    let is_enough = |step: &(u32, Kept)| {
        let classes: HashSet<_> = groups.iter().map(|group| class(group, *step)).collect();
        classes.len() <= MOST_PAIRED
    };
    let step = steps.into_iter().find(is_enough).unwrap_or(coarsest);
    let classes = classes(groups, |group| class(group, step));
    let united_by = |size: fn([u32; 2], [u32; 2]) -> [u32; 2]| -> Vec<Group> {
        classes.iter().filter_map(|class| united(class.clone(), size)).collect()
    };
    // Nothing is lost if all groups can have the largest size of their class.
    let largest = united_by(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    let is_within = largest.iter().map(Group::texels).sum::<u64>() <= most_texels;
    if is_within { largest } else { united_by(between) }
}

/// Collects groups by equal keys, in the order of the first group of each key.
fn classes<Key: Eq + Hash>(groups: Vec<Group>, key: impl Fn(&Group) -> Key) -> Vec<Vec<Group>> {
    let mut classes: Vec<Vec<Group>> = Vec::new();
    let mut of_key: HashMap<Key, usize> = HashMap::new();
    for group in groups {
        let class = *of_key.entry(key(&group)).or_insert(classes.len());
        match classes.get_mut(class) {
            Some(class) => class.push(group),
            None => classes.push(vec![group]),
        }
    }
    classes
}

/// Joins all groups into one, with the sampler that most pixels have. `size` computes its size from
/// the smallest and the largest sides. If the result is not the largest size, it takes no more
/// texels than before.
fn united(class: Vec<Group>, size: impl Fn([u32; 2], [u32; 2]) -> [u32; 2]) -> Option<Group> {
    let before: u64 = class.iter().map(Group::texels).sum();
    let extreme = |choose: fn(u32, u32) -> u32| {
        let sizes = class.iter().map(|group| group.size);
        sizes.reduce(|a, b| [choose(a[0], b[0]), choose(a[1], b[1])])
    };
    let least = extreme(u32::min)?;
    let most = extreme(u32::max)?;
    let mut pixels: HashMap<Sampler, u64> = HashMap::new();
    for group in &class {
        *pixels.entry(group.sampler).or_default() += group.pixels();
    }
    let weight = |group: &&Group| pixels.get(&group.sampler).copied().unwrap_or_default();
    // The first of the samplers with the most pixels.
    let sampler = class.iter().rev().max_by_key(weight)?.sampler;
    let mut groups = class.into_iter();
    let mut united = groups.next()?;
    let mut known: HashSet<ImageId> = united.images.iter().copied().collect();
    for group in groups {
        united.images.extend(group.images.into_iter().filter(|image| known.insert(*image)));
        united.members.extend(group.members);
    }
    let wanted = size(least, most);
    let is_largest = wanted == most;
    let count = united.images.len() as u64;
    united.size = if is_largest { most } else { within(wanted, count, before) };
    united.sampler = sampler;
    Some(united)
}

/// The part of samplers that separates classes. Encodings always separate them.
#[derive(Clone, Copy)]
enum Kept {
    All,
    Wrap,
    Nothing,
}

impl Kept {
    fn of(self, group: &Group) -> (Encoding, Option<[Wrap; 2]>, Option<Sampler>) {
        let sampler = group.sampler;
        match self {
            Self::All => (group.encoding, Some(sampler.wrap), Some(sampler)),
            Self::Wrap => (group.encoding, Some(sampler.wrap), None),
            Self::Nothing => (group.encoding, None, None),
        }
    }
}

//! Which channels of which clips move a node: found once, so that nobody looks through all clips for it.

use crate::clip::{Channel, Clip, Excerpt};
use crate::rig::{NodeId, Rig};

/// The channels of all clips by the node that they move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipIndex {
    /// Where the entries of each node begin, and where those of the last one end.
    first: Vec<usize>,
    /// Of each node its channels, by clips.
    entries: Vec<Entry>,
}

/// A channel: which clip's, which of its channels, and whether it moves the node rather than its weights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    clip: u32,
    channel: u32,
    is_transform: bool,
}

impl ClipIndex {
    /// The index of these clips of a rig, in time and memory that go with their channels.
    pub fn new(rig: &Rig, clips: &[Clip]) -> Self {
        let mut first = vec![0; rig.nodes().len() + 1];
        let channels = || clips.iter().flat_map(|clip| &clip.channels);
        for channel in channels() {
            if let Some(count) = first.get_mut(channel.node.0 as usize + 1) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for entry in &mut first {
            sum += *entry;
            *entry = sum;
        }
        let mut next = first.clone();
        let nothing = Entry { clip: 0, channel: 0, is_transform: false };
        let mut entries = vec![nothing; sum];
        for (clip, channels) in (0..).zip(clips.iter().map(|clip| &clip.channels)) {
            for (place, channel) in (0..).zip(channels) {
                let Some(next) = next.get_mut(channel.node.0 as usize) else { continue };
                if let Some(entry) = entries.get_mut(*next) {
                    *entry = Entry { clip, channel: place, is_transform: channel.is_transform() };
                }
                *next += 1;
            }
        }
        Self { first, entries }
    }

    fn of(&self, node: NodeId) -> &[Entry] {
        let place = node.0 as usize;
        let range = self.first.get(place).zip(self.first.get(place + 1));
        range.and_then(|(first, end)| self.entries.get(*first..*end)).unwrap_or_default()
    }

    /// How many channels move a node or its weights.
    pub fn channels(&self, node: NodeId) -> usize {
        self.of(node).len()
    }

    /// The clips that move any of these nodes, ascending and each once. Takes as long as they have channels.
    pub fn moving(&self, nodes: impl Iterator<Item = NodeId>) -> Vec<usize> {
        let entries = nodes.flat_map(|node| self.of(node)).filter(|entry| entry.is_transform);
        ascending(entries)
    }

    /// The clips that change a node's morph targets' weights, ascending and each once.
    pub fn weighing(&self, node: NodeId) -> Vec<usize> {
        ascending(self.of(node).iter().filter(|entry| !entry.is_transform))
    }

    /// What the clips that move any of these nodes, or the weights of `weighed`, do to them: each with the
    /// number of its clip, ascending.
    pub fn excerpts<'a>(
        &self,
        clips: &'a [Clip],
        nodes: impl Iterator<Item = NodeId>,
        weighed: NodeId,
    ) -> Vec<(usize, Excerpt<'a>)> {
        let moving = nodes.flat_map(|node| self.of(node)).filter(|entry| entry.is_transform);
        let weighing = self.of(weighed).iter().filter(|entry| !entry.is_transform);
        let mut entries: Vec<&Entry> = moving.chain(weighing).collect();
        entries.sort_by_key(|entry| entry.clip);
        let mut excerpts: Vec<(usize, Excerpt<'a>)> = Vec::new();
        for entry in entries {
            let clip = entry.clip as usize;
            let Some(channel) = channel_of(clips, entry) else { continue };
            match excerpts.last_mut() {
                Some((last, excerpt)) if *last == clip => excerpt.channels.push(channel),
                _ => excerpts.push((clip, Excerpt { channels: vec![channel] })),
            }
        }
        excerpts
    }
}

fn channel_of<'a>(clips: &'a [Clip], entry: &Entry) -> Option<&'a Channel> {
    clips.get(entry.clip as usize)?.channels.get(entry.channel as usize)
}

fn ascending<'a>(entries: impl Iterator<Item = &'a Entry>) -> Vec<usize> {
    let mut clips: Vec<usize> = entries.map(|entry| entry.clip as usize).collect();
    clips.sort_unstable();
    clips.dedup();
    clips
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::{Interpolation, Track, Values};
    use crate::rig::{Node, Rest, Trs};
    use glam::Vec3;

    fn channel(node: u32, values: Values) -> Channel {
        let track = Track { interpolation: Interpolation::Step, times_s: vec![0.0], values };
        Channel { node: NodeId(node), track }
    }

    #[test]
    fn channels_are_found_by_their_node() {
        let node = || Node {
            name: String::new(),
            parent: None,
            rest: Rest::Parts(Trs::IDENTITY),
            weights: vec![0.0],
        };
        let rig = Rig::new(vec![node(), node(), node()]).unwrap_or_else(|_| unreachable!());
        let moves = |node| channel(node, Values::Translation(vec![Vec3::ONE]));
        let scales = |node| channel(node, Values::Scale(vec![Vec3::ONE]));
        let weighs = |node| channel(node, Values::Weights(vec![1.0]));
        let clip = |channels| Clip { name: String::new(), channels };
        let clips = [clip(vec![moves(2), weighs(0), scales(2)]), clip(vec![weighs(2), moves(0)])];
        let index = ClipIndex::new(&rig, &clips);
        assert_eq!([0, 1, 2, 9].map(|node| index.channels(NodeId(node))), [2, 0, 3, 0]);
        assert_eq!(index.moving([NodeId(2), NodeId(1)].into_iter()), [0]);
        assert_eq!(index.moving([NodeId(2), NodeId(0)].into_iter()), [0, 1]);
        assert_eq!(index.weighing(NodeId(2)), [1]);
        let excerpts = index.excerpts(&clips, [NodeId(2)].into_iter(), NodeId(0));
        let found: Vec<_> = excerpts.iter().map(|(clip, it)| (*clip, it.channels.len())).collect();
        assert_eq!(found, [(0, 3)], "the weights of node 2 are not asked for");
    }
}

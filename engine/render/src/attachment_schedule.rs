//! The renderings at the end of a view's frame, and the images that each of them loads and stores.
//! A tile-based GPU reads an image from memory at the begin of a rendering and writes it back at
//! the end, unless the rendering says that it need not. Pure: tests need no device.

use gpu::{AttachmentStore, Load, RenderTarget};

/// A rendering of a view's frame. The variants are in the order in which they are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AttachmentSchedule {
    /// The last rendering that decides what is visible. The renderings before it keep all that they
    /// draw.
    LastRound,
    /// The last rendering that decides what is visible, with the colours of surfaces after it, over
    /// the contents.
    ShadedRound,
    /// The tests of casters against the finished depth.
    CasterTests,
    /// The colours of surfaces, over the contents.
    Shade,
    /// The fragments of transparent objects, which are stored.
    Fragments,
    /// The transparent objects.
    Transparent,
    /// The counts of the samples of watched objects.
    SampleCounts,
    /// The search for the object under the pointer.
    Pointer,
    /// The light that transparent objects in front of flares take.
    FlareTransmittance,
    /// The counts of the samples of flares.
    FlareCounts,
    /// The flares.
    Flares,
    /// The edges of objects over their surfaces.
    Edges,
    /// The edges of objects on paper.
    EdgesOnPaper,
    /// The outlines of objects, with a stencil of their own.
    StencilOutlines,
    /// The counts for the depth complexity.
    Layers,
    /// The depth complexity, which replaces the colours.
    DepthComplexity,
    /// The lines and boxes of the debug overlay.
    DebugLines,
    /// The view from above, in a corner of the image.
    ViewFromAbove,
    /// The outline of an object.
    Outline,
}

/// The use of an image by a rendering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AttachmentUse {
    /// Neither reads nor writes the image.
    Nothing,
    /// Tests against the image.
    Reads,
    /// Reads and writes the image.
    Writes,
    /// Overwrites the whole image.
    Replaces,
}

/// An image of a rendering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Image {
    Colour,
    Depth,
}

/// The use of the samples of the colour image after the last rendering that writes them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ColourEnd {
    /// A later command reads the image.
    #[default]
    Read,
    /// The last rendering that writes them averages them into another image. They are not read
    /// afterwards.
    Averaged,
}

/// The renderings that a view's frame has, as far as they are known when it begins. Some of them
/// may turn out empty and be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ViewScopes {
    present: u32,
    colour: ColourEnd,
}

impl AttachmentSchedule {
    /// All renderings, in their order.
    pub(crate) const ALL: [Self; 19] = [
        Self::LastRound,
        Self::ShadedRound,
        Self::CasterTests,
        Self::Shade,
        Self::Fragments,
        Self::Transparent,
        Self::SampleCounts,
        Self::Pointer,
        Self::FlareTransmittance,
        Self::FlareCounts,
        Self::Flares,
        Self::Edges,
        Self::EdgesOnPaper,
        Self::StencilOutlines,
        Self::Layers,
        Self::DepthComplexity,
        Self::DebugLines,
        Self::ViewFromAbove,
        Self::Outline,
    ];

    const fn bit(self) -> u32 {
        1 << self as u16
    }
}

impl ViewScopes {
    /// Creates a frame without renderings, with this end of its colours.
    pub(crate) fn ending(colour: ColourEnd) -> Self {
        Self { present: 0, colour }
    }

    /// Adds the renderings of `scopes` that are present.
    pub(crate) fn and(self, scopes: impl IntoIterator<Item = (AttachmentSchedule, bool)>) -> Self {
        let there = scopes.into_iter().filter(|(_, is_there)| *is_there);
        let present = there.fold(self.present, |present, (scope, _)| present | scope.bit());
        Self { present, ..self }
    }

    /// Moves the colours into the last round.
    pub(crate) fn shaded_within(self) -> Self {
        let apart = [
            AttachmentSchedule::LastRound,
            AttachmentSchedule::CasterTests,
            AttachmentSchedule::Shade,
        ];
        let apart = apart.into_iter().fold(0, |bits, scope| bits | scope.bit());
        Self { present: self.present & !apart | AttachmentSchedule::ShadedRound.bit(), ..self }
    }

    /// Returns true if the frame has this rendering.
    pub(crate) fn has(self, scope: AttachmentSchedule) -> bool {
        self.present & scope.bit() != 0
    }

    /// Returns the uses of the colours and of the depth by a rendering.
    fn uses(self, scope: AttachmentSchedule) -> [AttachmentUse; 2] {
        use AttachmentUse::{Nothing, Reads, Replaces, Writes};
        match scope {
            // Scenes that are shaded later draw only depth.
            AttachmentSchedule::LastRound if self.has(AttachmentSchedule::Shade) => {
                [Nothing, Writes]
            }
            AttachmentSchedule::LastRound | AttachmentSchedule::ViewFromAbove => [Writes, Writes],
            AttachmentSchedule::ShadedRound => [Replaces, Writes],
            AttachmentSchedule::Shade | AttachmentSchedule::EdgesOnPaper => [Replaces, Reads],
            AttachmentSchedule::Layers => [Nothing, Nothing],
            AttachmentSchedule::DepthComplexity => [Replaces, Nothing],
            AttachmentSchedule::CasterTests
            | AttachmentSchedule::Fragments
            | AttachmentSchedule::SampleCounts
            | AttachmentSchedule::Pointer
            | AttachmentSchedule::FlareTransmittance
            | AttachmentSchedule::FlareCounts => [Nothing, Reads],
            AttachmentSchedule::Transparent
            | AttachmentSchedule::Edges
            | AttachmentSchedule::DebugLines
            | AttachmentSchedule::Outline => [Writes, Reads],
            AttachmentSchedule::Flares | AttachmentSchedule::StencilOutlines => [Writes, Nothing],
        }
    }

    /// Returns the uses of an image by a rendering and by all renderings after it.
    fn uses_from(
        self,
        scope: AttachmentSchedule,
        image: Image,
    ) -> impl Iterator<Item = AttachmentUse> {
        let here = std::iter::once(scope);
        let later = AttachmentSchedule::ALL
            .into_iter()
            .filter(move |other| *other > scope && self.has(*other));
        let end = match (image, self.colour) {
            (Image::Colour, ColourEnd::Read) => Some(AttachmentUse::Reads),
            _ => None,
        };
        let uses = here.chain(later).map(move |scope| {
            let [colour, depth] = self.uses(scope);
            if image == Image::Colour { colour } else { depth }
        });
        uses.chain(end)
    }

    /// Returns true if the colours of a rendering are to be averaged at its end: no later rendering
    /// writes colours.
    pub(crate) fn averages(self, scope: AttachmentSchedule) -> bool {
        let writes = |attachment_use: &AttachmentUse| {
            matches!(attachment_use, AttachmentUse::Writes | AttachmentUse::Replaces)
        };
        let mut uses = self.uses_from(scope, Image::Colour);
        let is_writer = uses.next().is_some_and(|usage| writes(&usage));
        self.colour == ColourEnd::Averaged && is_writer && !uses.any(|usage| writes(&usage))
    }

    /// Returns the target of a rendering with as few loads and stores as possible.
    pub(crate) fn limit(self, scope: AttachmentSchedule, mut target: RenderTarget) -> RenderTarget {
        let uses = |image| self.uses_from(scope, image);
        (target.colour_load, target.colour_store) =
            limited(uses(Image::Colour), target.colour_load);
        (target.depth_load, target.depth_store) = limited(uses(Image::Depth), target.depth_load);
        target
    }
}

/// Returns the load and store of an image in a rendering, from its use there and the later uses.
fn limited<T>(
    mut uses: impl Iterator<Item = AttachmentUse>,
    load: Load<T>,
) -> (Load<T>, AttachmentStore) {
    let here = uses.next().unwrap_or(AttachmentUse::Nothing);
    let is_needed = match uses.find(|usage| *usage != AttachmentUse::Nothing) {
        Some(AttachmentUse::Replaces) | None => false,
        Some(_) => true,
    };
    let store = match here {
        _ if !is_needed => AttachmentStore::Forget,
        AttachmentUse::Nothing | AttachmentUse::Reads => AttachmentStore::Unchanged,
        AttachmentUse::Writes | AttachmentUse::Replaces => AttachmentStore::Keep,
    };
    let load = match here {
        AttachmentUse::Nothing if !is_needed => Load::Forget,
        _ => load,
    };
    (load, store)
}

#[cfg(test)]
mod tests {
    use AttachmentStore::{Forget, Keep, Unchanged};

    use super::AttachmentSchedule::*;
    use super::*;

    fn frame(scopes: &[AttachmentSchedule], colour: ColourEnd) -> ViewScopes {
        ViewScopes::ending(colour).and(scopes.iter().map(|scope| (*scope, true)))
    }

    /// Returns for each rendering, for colour and depth, if it loads contents, and how it stores
    /// them.
    fn ends(scopes: &[AttachmentSchedule], colour: ColourEnd) -> Vec<[(bool, AttachmentStore); 2]> {
        let frame = frame(scopes, colour);
        let end = |scope: &AttachmentSchedule| {
            [Image::Colour, Image::Depth].map(|image| {
                let (load, store) = limited(frame.uses_from(*scope, image), Load::<f32>::Keep);
                (load == Load::Keep, store)
            })
        };
        scopes.iter().map(end).collect()
    }

    #[test]
    fn depth_is_not_stored_unless_it_is_read() {
        let read = ColourEnd::Read;
        assert_eq!(ends(&[LastRound], read), [[(true, Keep), (true, Forget)]]);
        assert_eq!(
            ends(&[LastRound, Flares], read),
            [[(true, Keep), (true, Forget)], [(true, Keep), (false, Forget)]],
        );
        assert_eq!(
            ends(&[LastRound, FlareCounts, Flares, Outline], read),
            [
                [(true, Keep), (true, Keep)],
                [(true, Unchanged), (true, Unchanged)],
                [(true, Keep), (true, Unchanged)],
                [(true, Keep), (true, Forget)],
            ],
        );
    }

    #[test]
    fn colours_of_depth_first_scenes_begin_where_they_are_shaded() {
        assert_eq!(
            ends(&[LastRound, CasterTests, Shade, Transparent], ColourEnd::Read),
            [
                [(false, Forget), (true, Keep)],
                [(false, Forget), (true, Unchanged)],
                [(true, Keep), (true, Unchanged)],
                [(true, Keep), (true, Forget)],
            ],
        );
    }

    #[test]
    fn nobody_stores_the_colours_that_paper_covers() {
        assert_eq!(
            ends(&[LastRound, EdgesOnPaper, StencilOutlines], ColourEnd::Read),
            [
                [(true, Forget), (true, Keep)],
                [(true, Keep), (true, Forget)],
                [(true, Keep), (false, Forget)],
            ],
        );
    }

    #[test]
    fn colours_within_the_last_round_break_nothing() {
        let apart = frame(&[LastRound, CasterTests, Shade, Transparent], ColourEnd::Read);
        let within = frame(&[ShadedRound, Transparent], ColourEnd::Read);
        assert_eq!(apart.shaded_within(), within);
        assert_eq!(ends(&[ShadedRound], ColourEnd::Read), [[(true, Keep), (true, Forget)]]);
        assert!(frame(&[ShadedRound], ColourEnd::Averaged).averages(ShadedRound));
    }

    #[test]
    fn samples_are_averaged_by_the_last_that_draws_colours() {
        let averaged = |scopes: &[AttachmentSchedule]| -> Vec<AttachmentSchedule> {
            let frame = frame(scopes, ColourEnd::Averaged);
            scopes.iter().copied().filter(|scope| frame.averages(*scope)).collect()
        };
        assert_eq!(averaged(&[LastRound]), [LastRound]);
        assert_eq!(averaged(&[LastRound, Shade]), [Shade]);
        assert_eq!(averaged(&[LastRound, Shade, Transparent, FlareCounts]), [Transparent]);
        assert_eq!(averaged(&[LastRound, Flares, Outline]), [Outline]);
        assert!(!frame(&[LastRound], ColourEnd::Read).averages(LastRound));
        assert_eq!(ends(&[LastRound], ColourEnd::Averaged), [[(true, Forget), (true, Forget)]]);
        assert_eq!(
            ends(&[LastRound, FlareCounts], ColourEnd::Averaged),
            [[(true, Forget), (true, Keep)], [(false, Forget), (true, Forget)]],
        );
    }

    /// Checks all possible frames: contents that are read were kept since they were written, and
    /// contents that are kept are read.
    #[test]
    fn what_is_read_is_there_and_what_is_kept_is_read() {
        for present in 0..1_u32 << AttachmentSchedule::ALL.len() {
            let frame = ViewScopes { present, colour: ColourEnd::Read };
            let is_half = frame.has(Layers) != frame.has(DepthComplexity)
                || frame.has(Fragments) && !frame.has(Transparent);
            if is_half {
                continue;
            }
            let apart = !frame.has(ShadedRound) && frame.has(LastRound);
            let within = frame.has(ShadedRound) && frame == frame.shaded_within();
            if apart || within {
                let scopes: Vec<AttachmentSchedule> =
                    AttachmentSchedule::ALL.into_iter().filter(|scope| frame.has(*scope)).collect();
                check(&scopes, ColourEnd::Read);
                check(&scopes, ColourEnd::Averaged);
            }
        }
    }

    fn check(scopes: &[AttachmentSchedule], colour: ColourEnd) {
        let frame = frame(scopes, colour);
        let ends = ends(scopes, colour);
        for image in [0, 1] {
            // The first rendering finds the contents that earlier rounds kept.
            let mut is_there = true;
            let mut is_due = false;
            for (scope, end) in scopes.iter().zip(&ends) {
                let uses = frame.uses(*scope)[image];
                let (loads, store) = end[image];
                let reads = matches!(uses, AttachmentUse::Reads | AttachmentUse::Writes);
                assert!(!reads || (is_there && loads), "{scopes:?}: {scope:?} of {image}");
                is_due &= !(reads || uses == AttachmentUse::Nothing && store == Unchanged);
                assert!(!is_due || uses == AttachmentUse::Nothing, "{scopes:?}: before {scope:?}");
                let writes = uses == AttachmentUse::Writes || uses == AttachmentUse::Replaces;
                assert!(!(writes && store == Unchanged), "{scopes:?}: {scope:?} draws");
                is_there = match store {
                    Keep => true,
                    Unchanged => is_there,
                    Forget => false,
                };
                is_due |= store == Keep;
            }
            let is_read = image == 0 && colour == ColourEnd::Read;
            assert!(!is_read || is_there, "{scopes:?}: {image} is lost at the end");
            assert!(is_read || !is_due, "{scopes:?}: {image} is kept for nobody");
        }
    }
}

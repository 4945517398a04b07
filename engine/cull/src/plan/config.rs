//! Every constant of the method, each with its reason. None is needed for exactness.

/// How the past is turned into guesses. Times are in frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CullConfig {
    /// Leaves that an unknown node may have to be tested as one. Small, because all of them are
    /// drawn if a single sample of the box shows.
    pub unknown_leaves: u32,
    /// The same for an unknown node that looks small, so that a million unknown objects do not
    /// need a hundred thousand queries.
    pub unknown_leaves_far: u32,
    /// What "looks small" means: diagonal over distance (radians, nearly).
    pub unknown_angle: f32,
    /// A node that was seen hidden for this long may be tested with twice the leaves. What was
    /// hidden for long will stay so for long; doubling lets the frontier of a still camera shrink
    /// to the logarithm of the scene.
    pub growth_frames: u32,
    /// The same where the leaves of a node that shows are tested one by one before they are drawn:
    /// a guess that was too bold costs little there.
    pub growth_frames_parts: u32,
    /// The most leaves that a node may have to be tested as one, however long it was hidden: if it
    /// shows, each of them is tested in that frame, and noted when the answer is home.
    pub shared_leaves: u32,
    /// Leaves that a node may have to be tested as one where it sticks out of the frustum while
    /// the view turns: what lies outside was not observed, however long its neighbours are known.
    pub edge_leaves: u32,
    /// How long a view counts as turning after it did.
    pub turning_frames: u32,
    /// What counts as turning: the sine of the angle between two frames.
    pub turning_sine: f32,
    /// What has not been visited for longer is stale: a visible leaf that comes back into the
    /// frustum is tested before it is drawn.
    pub stale_frames: u32,
    /// How long an opened node stays open before its parts may share a query again. Too short and
    /// nodes flip, too long and the frontier explodes (60 did).
    pub open_frames: u32,
    /// Random addition to `open_frames`, so that nodes that opened together do not merge together.
    pub open_jitter: u32,
    /// Levels opened at once below a node that showed: refinement by one level a round trip is
    /// too slow, and in each of those frames all that is left under the node is drawn.
    pub open_levels: u32,
    /// Opening goes deeper than `open_levels` until a part has no more leaves than this ...
    pub open_leaves: u32,
    /// ... but never deeper than this, which bounds the tests that one surprise can cause.
    pub open_levels_max: u32,
    /// An own-draw test follows a proxy that showed within this time: proxies are larger than
    /// what they stand for, so a third of those that show hide nothing that does.
    pub retest_first: u32,
    /// The interval between own-draw tests doubles with each that succeeds, up to this.
    pub retest_max: u32,
    /// A leaf that is overdue by more than this, or not due for longer, is tested within this time:
    /// so that a change of the interval neither comes late nor tests all leaves at once. 0 for
    /// never.
    pub retest_spread: u32,
    /// Own draws are tested in every so many-th frame only: where a device waits for answers, a
    /// frame without a question is cheaper than one with a single question.
    pub retest_gate: u32,
    /// A visible leaf that looks smaller than this (diagonal over distance) is tested by its box,
    /// where there are flags: a box costs little if it is small.
    pub own_box_angle: f32,
    /// The interval between such tests.
    pub own_box_frames: u32,
    /// After so many of them its own draw is tested, which the box may hide.
    pub own_box_streak: u32,
    /// A leaf whose proxy shows within this time after its own draw did not has a proxy that is
    /// too loose for the place: the interval doubles each time that happens, ...
    pub flip_frames: u32,
    /// ... up to this: testing such a leaf more often would cost more than drawing it.
    pub flip_retest_max: u32,
    /// How soon a probe may be repeated if its answer does not come.
    pub probe_retry: u32,
    /// A probe that failed is repeated after `open_frames`, doubled this often at most.
    pub probe_backoff: u32,
    /// Probes that a frame may always have.
    pub probes_min: u32,
    /// Beyond that, one probe for so many tests.
    pub tests_per_probe: u32,
    /// Nearest unknown leaves that are drawn at once when much is unknown: without any depth all
    /// tests would show.
    pub occluders: u32,
    /// "Much is unknown": one unknown test in so many ...
    pub cut_share: u32,
    /// ... and at least so many.
    pub cut_tests: u32,
    /// Slabs of tests in a frame that mostly confirms what is known.
    pub rounds_calm: u32,
    /// Slabs of tests when much is unknown, each twice as long as the one before, so that what is
    /// near can hide what is far.
    pub rounds_cut: u32,
    /// The same where a compute shader tests: each slab looks at the whole depth buffer first.
    pub rounds_compute_calm: u32,
    /// The same after a cut.
    pub rounds_compute_cut: u32,
    /// A slab is not worth a break in the passes with fewer tests.
    pub round_tests_min: u32,
    /// A node of so many leaves has them tested one by one in the frame in which it shows, where
    /// the device can.
    pub parts_leaves: u32,
    /// Tests of which at least this share of the picture is covered may answer for what is behind
    /// them.
    pub front_area: f32,
    /// So many of them, the largest.
    pub fronts: u32,
    /// The most leaves that one of them may answer for: all are tested one by one if it shows.
    pub leaves_behind: u32,
    /// The same for each frame that it has been hidden, none for what is unknown: what was not
    /// hidden for long is the likeliest to show.
    pub leaves_behind_a_frame: u32,
    /// More tests than this are too many even where there are queries for them: the allowed sizes
    /// are raised, and open nodes whose parts are all hidden are tested as one without a probe.
    /// After a cut in a huge scene this brings the frontier down in tens of frames, not hundreds.
    pub tests_wished: u32,
    /// How often at most the allowed sizes are raised fourfold before, if there are more tests than
    /// queries, anything is drawn without a test.
    pub coarsen_attempts: u32,
    /// Seed of the jitter. Two cullers with equal seeds and inputs make equal plans.
    pub seed: u64,
}

impl Default for CullConfig {
    fn default() -> Self {
        Self {
            unknown_leaves: 8,
            unknown_leaves_far: 128,
            unknown_angle: 0.1,
            growth_frames: 6,
            growth_frames_parts: 2,
            shared_leaves: 16_384,
            edge_leaves: 64,
            turning_frames: 8,
            turning_sine: 0.004,
            stale_frames: 8,
            open_frames: 12,
            open_jitter: 8,
            open_levels: 3,
            open_leaves: 32,
            open_levels_max: 7,
            retest_first: 4,
            retest_max: 16,
            retest_spread: 0,
            retest_gate: 1,
            own_box_angle: 0.15,
            own_box_frames: 3,
            own_box_streak: 6,
            flip_frames: 16,
            flip_retest_max: 64,
            probe_retry: 6,
            probe_backoff: 2,
            probes_min: 16,
            tests_per_probe: 4,
            occluders: 32,
            cut_share: 3,
            cut_tests: 16,
            rounds_calm: 3,
            rounds_cut: 8,
            rounds_compute_calm: 1,
            rounds_compute_cut: 3,
            round_tests_min: 8,
            parts_leaves: 2,
            front_area: 0.002,
            fronts: 48,
            leaves_behind: 4_096,
            leaves_behind_a_frame: 64,
            tests_wished: 1024,
            coarsen_attempts: 4,
            seed: 0x6e6f_7374_616c_6c73,
        }
    }
}

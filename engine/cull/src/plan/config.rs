//! Every constant of the method, each with its reason. None is needed for exactness.

/// The constants by which the history is turned into guesses. Times are in frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CullConfig {
    /// The most leaves with which an unknown node is tested as one. Small, because all of them are
    /// drawn if a single sample of the box shows.
    pub unknown_leaves: u32,
    /// The same for an unknown node that looks small, so that a million unknown objects do not
    /// need a hundred thousand queries.
    pub unknown_leaves_far: u32,
    /// The size below which a node "looks small": diagonal over distance (radians, nearly).
    pub unknown_angle: f32,
    /// The time for which a node must have been hidden to be tested with twice the leaves. A node
    /// that was hidden for long will stay so for long; doubling lets the frontier of a still camera
    /// shrink to the logarithm of the scene.
    pub growth_frames: u32,
    /// The same if the leaves of a visible node are tested one by one before they are drawn: a
    /// guess that was too bold costs little then.
    pub growth_frames_parts: u32,
    /// The most leaves with which a node is tested as one after any time hidden: if it shows, each
    /// of them is tested in that frame, and recorded when the results are read back.
    pub shared_leaves: u32,
    /// The most leaves with which a node is tested as one while it is partly outside of the frustum
    /// of a turning view: the part outside was not observed, even if its neighbours are known for
    /// long.
    pub edge_leaves: u32,
    /// The time for which a view counts as turning after it turned.
    pub turning_frames: u32,
    /// The least turn that counts as turning: the sine of the angle between two frames.
    pub turning_sine: f32,
    /// The time without a visit after which a record is stale: a visible leaf that returns to the
    /// frustum is then tested before it is drawn.
    pub stale_frames: u32,
    /// The time for which an opened node stays open before its parts may share a query again. Too
    /// short and nodes flip, too long and the frontier explodes (60 did).
    pub open_frames: u32,
    /// The random addition to `open_frames`, so that nodes that opened together do not merge
    /// together.
    pub open_jitter: u32,
    /// The levels opened at once below a visible node: refinement by one level per round trip is
    /// too slow, and in each of those frames all that is left under the node is drawn.
    pub open_levels: u32,
    /// The leaves of a part down to which opening goes deeper than `open_levels` ...
    pub open_leaves: u32,
    /// ... but never deeper than this, which bounds the tests that one surprise can cause.
    pub open_levels_max: u32,
    /// The time within which the leaf's own draw is tested after its proxy showed: proxies are
    /// larger than their objects, so the objects of a third of the visible proxies do not show.
    pub retest_first: u32,
    /// The longest interval between tests of an own draw: it doubles with each that succeeds.
    pub retest_max: u32,
    /// The time within which a leaf is tested that is overdue by more than this, or not due for
    /// longer: so that a change of the interval neither comes late nor tests all leaves at once. 0
    /// for never.
    pub retest_spread: u32,
    /// The interval of frames in which own draws are tested: on a device that waits for results, a
    /// frame without a test is cheaper than one with a single test.
    pub retest_gate: u32,
    /// The size (diagonal over distance) below which a visible leaf is tested by its box, if there
    /// are flags: a small box costs little.
    pub own_box_angle: f32,
    /// The interval between such tests.
    pub own_box_frames: u32,
    /// The number of them after which its own draw is tested, which the box may hide.
    pub own_box_streak: u32,
    /// The time after a hidden own draw within which a visible proxy counts as too loose for the
    /// place: the interval doubles each time that happens, ...
    pub flip_frames: u32,
    /// ... up to this: testing such a leaf more often would cost more than drawing it.
    pub flip_retest_max: u32,
    /// The time after which a probe may be repeated if its result does not come.
    pub probe_retry: u32,
    /// The most doublings of `open_frames`, after which a failed probe is repeated.
    pub probe_backoff: u32,
    /// The probes that a frame may always have.
    pub probes_min: u32,
    /// The number of tests per probe beyond that.
    pub tests_per_probe: u32,
    /// The nearest unknown leaves that are drawn at once when much is unknown: without any depth
    /// all tests would show.
    pub occluders: u32,
    /// The threshold of "much is unknown": one unknown test in so many ...
    pub cut_share: u32,
    /// ... and at least so many.
    pub cut_tests: u32,
    /// The slabs of tests in a frame that mostly confirms the history.
    pub rounds_calm: u32,
    /// The slabs of tests when much is unknown, each twice as long as the one before, so that near
    /// objects can hide far ones.
    pub rounds_cut: u32,
    /// The same if a compute shader tests: each slab looks at the whole depth buffer first.
    pub rounds_compute_calm: u32,
    /// The same after a cut.
    pub rounds_compute_cut: u32,
    /// The least tests of a slab: fewer are not worth a break in the passes.
    pub round_tests_min: u32,
    /// The fewest leaves of a node that are tested one by one in the frame in which it shows, if
    /// the device supports it.
    pub parts_leaves: u32,
    /// The least share of the picture that a test must cover to answer for the leaves behind it.
    pub front_area: f32,
    /// The number of them: the largest.
    pub fronts: u32,
    /// The most leaves that one of them may answer for: all are tested one by one if it shows.
    pub leaves_behind: u32,
    /// The same per frame that it has been hidden, none for an unknown one: a node that was not
    /// hidden for long is the likeliest to show.
    pub leaves_behind_a_frame: u32,
    /// The number of tests above which there are too many even with queries for them: the allowed
    /// sizes are raised, and open nodes whose parts are all hidden are tested as one without a
    /// probe. After a cut in a huge scene this shrinks the frontier in tens of frames, not
    /// hundreds.
    pub tests_wished: u32,
    /// The most times that the allowed sizes are raised fourfold if there are more tests than
    /// queries. After that, leaves are drawn without a test.
    pub coarsen_attempts: u32,
    /// The seed of the jitter. Two cullers with equal seeds and inputs make equal plans.
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

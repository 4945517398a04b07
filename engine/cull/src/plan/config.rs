//! The constants of the method that affect its cost, each with its reason. Exactness depends on
//! none of them. docs/lab/cull_config.md lists the effect of halving and doubling each constant.

/// The constants by which the culler turns history into predictions. Times are in frames.
///
/// The last line of each constant names the count of a walk that changed most when the constant was
/// halved or doubled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CullConfig {
    /// The most leaves of an unknown node that is tested as one. Small, because all of its leaves
    /// are drawn if a single sample of the box shows.
    ///
    /// Halved: +20.1 % tests, `cut`; doubled: -15.6 % tests, `cut`.
    pub unknown_leaves: u32,
    /// The longest interval between tests of an own draw: the interval doubles with each test that
    /// shows.
    ///
    /// Halved: +0.8 % rounds, `cut`; doubled: -2.9 % tests, `fly`.
    pub retest_max: u32,
    /// The interval between tests of a visible leaf by its box.
    ///
    /// Halved: +27.3 % tests, `fly`; doubled: -10.5 % tests, `fly`.
    pub visible_box_frames: u32,
    /// The number of rounds in a frame that mostly confirms the history; fewer where the cost model
    /// finds that further rounds do not pay.
    ///
    /// Halved: -66.7 % rounds, `street`; doubled: +100.0 % rounds, `street`.
    pub rounds_calm: u32,
    /// The number of tests above which there are too many, even if queries are left. The allowed
    /// sizes are then raised, and open nodes whose parts are all hidden are tested as one without a
    /// pull-up query, as they always are where leaves are tested individually. After a cut in a
    /// huge scene this shrinks the frontier in tens of frames, not hundreds.
    ///
    /// Halved: -62.7 % tests, `cut`; doubled: -40.9 % draws, `street` (queries alone, 100,000).
    pub tests_wished: u32,
    /// The seed of the jitter. Two cullers with equal seeds and inputs make equal plans.
    pub seed: u64,
    /// The constants that change counts less, or in special walks. They may change with any
    /// version.
    #[doc(hidden)]
    pub tuning: CullTuning,
}

/// The constants of the culler that only experiments change.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CullTuning {
    /// The most leaves of an unknown node that looks small and is tested as one. Larger than
    /// `unknown_leaves`, so that a million unknown objects do not need a hundred thousand queries.
    ///
    /// Halved: -3.0 % draws, `street`; doubled: nothing (queries alone, 100,000).
    pub unknown_leaves_far: u32,
    /// The size below which a node "looks small": its diagonal over its distance (nearly radians).
    ///
    /// Halved: nothing; doubled: +1.6 % rounds, `cut`.
    pub unknown_angle: f32,
    /// The time for which a node must have been hidden before the number of leaves tested as one
    /// doubles. A node that was hidden for long tends to stay hidden for long; with doubling, the
    /// frontier of a still camera shrinks to the logarithm of the scene.
    ///
    /// Halved: +11.7 % draws, `cut`; doubled: +13.2 % tests, `street` (queries alone).
    pub growth_frames: u32,
    /// The time that replaces `growth_frames` if the leaves of a node that shows are tested
    /// individually before they are drawn: a wrong prediction then costs little.
    ///
    /// Halved: nothing; doubled: +6.5 % tests, `cut`.
    pub growth_frames_per_leaf: u32,
    /// The most leaves of a node that is tested as one while it is partly outside of the frustum of
    /// a turning view: the part outside was not observed, even if the rest has been known for long.
    ///
    /// Halved: +1.0 % tests, `street`; doubled: -2.7 % tests, `street`.
    pub edge_leaves: u32,
    /// The time for which a view counts as turning after its last turn.
    ///
    /// Halved: -1.2 % tests, `street`; doubled: +1.6 % tests, `street`.
    pub turning_frames: u32,
    /// The smallest turn that counts: the sine of the angle between the directions of two frames.
    ///
    /// Halved: +2.0 % tests, `street`; doubled: nothing.
    pub turning_sine: f32,
    /// The time without a visit after which a record is stale. A visible leaf with a stale record
    /// is tested before it is drawn when it returns to the frustum.
    ///
    /// Halved: nothing; doubled: +1.7 % triangles, `cut`.
    pub stale_frames: u32,
    /// The time for which an opened node stays open before its parts may share a query again. If it
    /// is too short, nodes flip between open and closed; if it is too long, the frontier explodes
    /// (it did at 60).
    ///
    /// Halved: -6.2 % tests, `fly`; doubled: +14.1 % tests, `fly`.
    pub open_frames: u32,
    /// The largest random addition to `open_frames`, so that nodes that opened in one frame do not
    /// merge in one frame.
    ///
    /// Halved: -1.9 % tests, `fly`; doubled: +6.1 % tests, `fly`.
    pub open_jitter: u32,
    /// The number of levels opened at once below a node that shows. Opening one level per round
    /// trip of a result is too slow: in each of these frames, all leaves that remain under the node
    /// are drawn.
    ///
    /// Halved: +8.1 % draws, `cut`; doubled: +3.0 % rounds, `cut` (queries alone).
    pub open_levels: u32,
    /// The number of leaves above which a part is opened even below `open_levels` ...
    ///
    /// Halved: +1.9 % draws, `street`; doubled: -3.5 % draws, `street` (queries alone, 100,000).
    pub open_leaves: u32,
    /// ... and the deepest level of such opening, to bound the tests that one surprise can cause.
    ///
    /// Halved: -3.5 % draws, `street`; doubled: nothing (queries alone, 100,000).
    pub open_levels_max: u32,
    /// The time within which a leaf's own draw is tested after its proxy showed. Proxies are larger
    /// than their objects: for a third of the visible proxies, the object does not show.
    ///
    /// Halved: +1.6 % rounds, `cut`; doubled: -3.3 % rounds, `cut`.
    pub retest_first: u32,
    /// The time over which retests are spread for leaves that are overdue by more than this, or not
    /// due for longer than this. A change of the retest interval then takes effect soon without
    /// testing all leaves in one frame. 0 disables it.
    ///
    /// At 4: -1.6 % rounds, `cut`; at 16: -0.1 % nodes visited, `fly`.
    pub retest_spread: u32,
    /// The interval of frames in which own draws are tested: on a device that waits for results, a
    /// frame without any test is cheaper than a frame with a single test.
    ///
    /// Halved: nothing; doubled: -1.1 % tests, `fly`.
    pub retest_gate: u32,
    /// The size (diagonal over distance) below which a visible leaf is tested by its box, if the
    /// device has flags: a small box costs little.
    ///
    /// Halved: -15.8 % tests, `fly`; doubled: +8.8 % tests, `fly`.
    pub visible_box_angle: f32,
    /// The number of consecutive box tests of a visible leaf after which its own draw is tested:
    /// the box may show where the draw does not.
    ///
    /// Halved: -4.7 % tests, `fly`; doubled: +2.4 % tests, `fly`.
    pub visible_box_tests: u32,
    /// The longest interval between tests of a leaf whose proxy shows again soon after its own draw
    /// did not. The interval doubles each time, since the proxy is too loose in this view: more
    /// tests would cost more than drawing the leaf.
    ///
    /// Halved: +0.8 % tests, `fly`; doubled: -1.1 % tests, `street` (200 frames).
    pub flicker_retest_max: u32,
    /// The most doublings of `open_frames`, the time after which a failed pull-up query is
    /// repeated.
    ///
    /// Halved: +2.4 % draws, `cut`; doubled: nothing (200 frames).
    pub pull_up_backoff: u32,
    /// The number of tests for which a frame may have one pull-up query, above a small minimum.
    ///
    /// Halved: nothing; doubled: +2.1 % tests, `cut`.
    pub tests_per_pull_up: u32,
    /// The number of leaves, the nearest unknown ones, that are drawn at once when much is unknown:
    /// without any depth in the buffer all tests would show.
    ///
    /// Halved: -4.4 % triangles, `cut`; doubled: +9.3 % draws, `cut`.
    pub occluders: u32,
    /// The threshold of "much is unknown": at least one in this number of tests is unknown ...
    ///
    /// Halved: +15.3 % tests, `cut`; doubled: nothing.
    pub cut_share: u32,
    /// ... and at least this number of tests is unknown.
    ///
    /// Halved: nothing; doubled: +9.8 % tests, `cut`.
    pub cut_tests: u32,
    /// The number of rounds when much is unknown, each twice as long as the one before, so that
    /// near objects can hide far ones; fewer where the cost model finds that further rounds do not
    /// pay.
    ///
    /// Halved: -1.5 % draws, `cut`; doubled: +0.2 % tests, `fly`.
    pub rounds_cut: u32,
    /// The value of `rounds_calm` for the compute tester, which reads the whole depth buffer per
    /// round.
    ///
    /// Halved: nothing; doubled: +100.0 % rounds, `street` (compute tester).
    pub rounds_compute_calm: u32,
    /// The value of `rounds_cut` for the compute tester.
    ///
    /// Halved: +31.2 % tests, `cut`; doubled: -14.0 % tests, `cut` (compute tester).
    pub rounds_compute_cut: u32,
    /// The least tests of a round: fewer are not worth an interruption of the render pass.
    ///
    /// Halved: +10.6 % rounds, `cut`; doubled: -27.6 % rounds, `cut`.
    pub round_tests_min: u32,
    /// The least number of leaves for testing the leaves of a node that shows individually in the
    /// same frame, if the device supports it.
    ///
    /// Halved: +7.5 % tests, `street`; doubled: -5.8 % tests, `fly`.
    pub per_leaf_min: u32,
}

impl Default for CullConfig {
    fn default() -> Self {
        Self {
            unknown_leaves: 8,
            retest_max: 16,
            visible_box_frames: 3,
            rounds_calm: 3,
            tests_wished: 1024,
            seed: 0x6e6f_7374_616c_6c73,
            tuning: CullTuning::default(),
        }
    }
}

impl Default for CullTuning {
    fn default() -> Self {
        Self {
            unknown_leaves_far: 128,
            unknown_angle: 0.1,
            growth_frames: 6,
            growth_frames_per_leaf: 2,
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
            retest_spread: 0,
            retest_gate: 1,
            visible_box_angle: 0.15,
            visible_box_tests: 6,
            flicker_retest_max: 64,
            pull_up_backoff: 2,
            tests_per_pull_up: 4,
            occluders: 32,
            cut_share: 3,
            cut_tests: 16,
            rounds_cut: 8,
            rounds_compute_calm: 1,
            rounds_compute_cut: 3,
            round_tests_min: 8,
            per_leaf_min: 2,
        }
    }
}

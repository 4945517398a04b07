//! The description of an object, with the reason why it is drawn or not.

use antumbra::cull::{
    Decision, FrameId, LeafExplanation, NodeHistory, NodeState, Outcome, QueryKind, Rays,
    VisibilityTest,
};

use super::page_text::{Facts, fact};
use bench::strategy::Strategy;

/// The facts from which an object is described.
#[derive(Clone, Copy, Debug)]
pub struct ObjectCard<'a> {
    /// The decision of the plan, and the history.
    pub explained: &'a LeafExplanation,
    /// The newest outcome, and its frame.
    pub outcome: Option<(FrameId, Outcome)>,
    /// The name of its mesh, if it is known.
    pub mesh: Option<&'a str>,
    /// The number of its triangles, at its level of detail.
    pub triangles: u64,
    /// The rays of the view in the explained frame.
    pub rays: Rays,
    /// The strategy that decided.
    pub strategy: Strategy,
}

impl ObjectCard<'_> {
    /// Returns the rows of the card.
    pub fn facts(&self) -> Facts {
        let explained = self.explained;
        let size = explained.bounds.max - explained.bounds.min;
        let distance_m = self.rays.distance(&explained.bounds);
        let name = match self.mesh.filter(|name| !name.is_empty()) {
            Some(mesh) => format!("{}, {mesh}", explained.object.0),
            None => explained.object.0.to_string(),
        };
        let mut facts = vec![
            fact("object", name),
            fact("box", format!("{:.2} x {:.2} x {:.2} m", size.x, size.y, size.z)),
            fact("distance", format!("{distance_m:.1} m")),
            fact("triangles", self.triangles.to_string()),
            fact("decision", self.decision()),
        ];
        // Other strategies keep no history here, or test in other ways.
        if !self.strategy.uses_cost_model() {
            return facts;
        }
        if let Decision::Tested { leaves, level, history, .. } = explained.decision
            && leaves > 1
        {
            facts.push(fact("group", format!("{leaves} objects, level {level}")));
            facts.push(fact("group is", self.state(&history)));
            facts.push(fact("last answer", self.answer(&history)));
        } else if !matches!(explained.decision, Decision::Outside | Decision::CutAway) {
            facts.push(fact("object is", self.state(&explained.history)));
            facts.push(fact("last answer", self.answer(&explained.history)));
        }
        if let (Some(next), true) = (explained.history.next_test, self.is_drawn_at_once()) {
            facts.push(fact("next test", until(next.0, explained.frame.0)));
        }
        facts
    }

    fn is_drawn_at_once(&self) -> bool {
        use Decision::{Drawn, DrawnAndBoxTested, DrawnAndTested};
        matches!(self.explained.decision, Drawn | DrawnAndTested | DrawnAndBoxTested { .. })
    }

    fn decision(&self) -> String {
        let by = |tester: VisibilityTest| match tester {
            VisibilityTest::Flag => "a fragment flag",
            VisibilityTest::Query => "an occlusion query",
            VisibilityTest::Compute => "the compute test",
            VisibilityTest::SharedProxy(_) => "the test of a box in front",
        };
        match self.explained.decision {
            Decision::Outside => "not drawn: outside of the frustum".to_owned(),
            Decision::CutAway => "not drawn: cut away by section planes".to_owned(),
            Decision::Drawn if self.strategy == Strategy::FRUSTUM => {
                "drawn: in the frustum".to_owned()
            }
            Decision::Drawn => "drawn: taken as visible".to_owned(),
            Decision::DrawnAndTested => {
                "drawn: taken as visible; its draw is tested by an occlusion query".to_owned()
            }
            Decision::DrawnAndBoxTested { tester } => {
                format!("drawn: taken as visible; its box is tested by {}", by(tester))
            }
            Decision::Unplanned => format!("{} decides elsewhere", self.strategy),
            Decision::Tested { leaves, kind, tester, .. } => {
                let whose = if leaves > 1 { "the box of its group" } else { "its box" };
                let each = match (kind, leaves) {
                    (QueryKind::PerLeaf, 2..) => ", then its own",
                    _ => "",
                };
                let tested = format!("{whose} is tested{each} by {}", by(tester));
                match self.outcome {
                    Some((frame, Outcome::Revealed)) => {
                        format!("drawn, revealed in frame {}: {tested}", frame.0)
                    }
                    Some((frame, Outcome::Hidden)) => {
                        format!("not drawn, hidden in frame {}: {tested}", frame.0)
                    }
                    None => format!("drawn if it shows: {tested}"),
                }
            }
        }
    }

    fn state(&self, history: &NodeHistory) -> String {
        let name = match history.state {
            NodeState::Unknown => return "never asked".to_owned(),
            NodeState::Visible => "visible",
            NodeState::Hidden => "hidden",
        };
        match history.since {
            Some(since) => {
                let frames = self.explained.frame.0.saturating_sub(since.0);
                format!("{name} since frame {}, for {}", since.0, in_frames(frames))
            }
            None => name.to_owned(),
        }
    }

    fn answer(&self, history: &NodeHistory) -> String {
        match history.answered {
            Some(answered) => {
                let frames = self.explained.frame.0.saturating_sub(answered.0);
                format!("asked in frame {}, {} ago", answered.0, in_frames(frames))
            }
            None => "none yet".to_owned(),
        }
    }
}

/// Returns words for the time of a test that is due in frame `due`. Tests wait while they do not
/// pay off.
fn until(due: u64, now: u64) -> String {
    match due.checked_sub(now) {
        None | Some(0) => "due, once it pays".to_owned(),
        Some(frames) => format!("in {}", in_frames(frames)),
    }
}

fn in_frames(frames: u64) -> String {
    if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") }
}

#[cfg(test)]
mod tests {
    use antumbra::cull::{
        self, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, ObjectId, Projection,
        QueryTag,
    };

    use antumbra::glam::Vec3;

    use super::*;

    const CAMERA: Camera = Camera {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };

    /// Returns the facts about an object after some frames. The scene has a wall, a cube behind it,
    /// and a cube behind the eye; only the wall is visible.
    fn facts(object: u32, strategy: Strategy) -> String {
        let cube = |z: f32, half: f32| {
            cull::Aabb::new(Vec3::new(-half, -half, z - 1.0), Vec3::new(half, half, z))
        };
        let hierarchy =
            Hierarchy::build(&[cube(-5.0, 4.0), cube(-9.0, 0.5), cube(9.0, 0.5)]).unwrap();
        let view = CullView::new(&CAMERA, [64, 64], 8);
        let mut culler = Culler::new(CullConfig::default());
        let mut plan = FramePlan::default();
        let wall = hierarchy.node_of(ObjectId(0)).unwrap();
        let mut answers: Vec<cull::Answer> = Vec::new();
        for _ in 0..60 {
            culler.ingest(&hierarchy, answers.drain(..));
            culler.plan(&hierarchy, strategy, &view, 100, &mut plan);
            let tags = plan.tests.iter().map(|test| test.tag);
            let tags = tags.chain(plan.queried_draws.iter().map(|(_, tag)| *tag));
            let answer = |tag: QueryTag| {
                let samples =
                    u32::from(hierarchy.leaves(tag.node).contains(hierarchy.leaves(wall).first));
                cull::Answer { tag, samples }
            };
            answers.extend(tags.map(answer));
        }
        let explained = culler.explain(&hierarchy, &view, &plan, ObjectId(object)).unwrap();
        let outcome = explained.outcome(&hierarchy, &answers);
        let card = ObjectCard {
            explained: &explained,
            outcome: outcome.map(|outcome| (plan.frame, outcome)),
            mesh: Some("wall"),
            triangles: 12,
            rays: view.rays,
            strategy,
        };
        let rows = card.facts().into_iter().map(|(name, value)| format!("{name}: {value}"));
        rows.collect::<Vec<_>>().join("\n")
    }

    fn assert_says(text: &str, parts: &[&str]) {
        parts.iter().for_each(|part| assert!(text.contains(part), "{part}: {text}"));
    }

    #[test]
    fn what_is_visible_is_said_to_be_drawn_and_since_when() {
        let text = facts(0, Strategy::ANTUMBRA);
        let size = "object: 0, wall\nbox: 8.00 x 8.00 x 1.00 m\ndistance: 5.0 m\ntriangles: 12\n";
        assert_says(&text, &[size, "decision: drawn: taken as visible"]);
        assert_says(&text, &["object is: visible since frame", "asked in frame", "next test: in"]);
    }

    #[test]
    fn a_test_that_is_late_is_said_to_be_due() {
        assert_eq!(until(7, 5), "in 2 frames");
        assert!(until(5, 5).starts_with("due") && until(5, 90).starts_with("due"));
    }

    #[test]
    fn what_is_hidden_is_said_to_be_tested_and_how() {
        let text = facts(1, Strategy::ANTUMBRA);
        let decision =
            "decision: not drawn, hidden in frame 60: its box is tested by an occlusion query";
        assert_says(&text, &[decision, "object is: hidden since frame", "1 frame ago"]);
        assert!(!text.contains("next test"), "{text}");
    }

    #[test]
    fn what_is_outside_or_not_culled_is_said() {
        let outside = facts(2, Strategy::ANTUMBRA);
        assert_says(&outside, &["decision: not drawn: outside of the frustum"]);
        assert!(!outside.contains("next test"), "{outside}");
        assert_says(&facts(1, Strategy::FRUSTUM), &["decision: drawn: in the frustum"]);
    }
}

//! The strategies that a walk compares, by their names on the command line and in reports.

pub use cull::Strategy;

/// Returns a summary of a strategy in a few words.
pub const fn summary(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Frustum => "the baseline: all that is in the view frustum",
        Strategy::Naive => "an occlusion query per object, a wait for each",
        Strategy::Batched => "a query per object behind large ones, one wait",
        Strategy::NextFrame => "a query per object, used a frame later: it pops",
        Strategy::StopAndWait => "the hierarchy from its root, a wait at each node",
        Strategy::Coherent => "coherent hierarchical culling, as published",
        Strategy::Pyramid => "two phases against a depth pyramid, on the GPU",
        Strategy::Antumbra => "ours: late answers, made exact by predicates",
        Strategy::AntumbraQueries => "ours, with occlusion queries for all tests",
        Strategy::AntumbraFlags => "ours, with flags set by fragments for all tests",
        Strategy::AntumbraCompute => "ours, with a compute shader for all tests",
        Strategy::Ideal => "the bound: the exact visible set, found in advance",
    }
}

/// Returns a line for each strategy: its name, exact or not, its summary.
pub fn list() -> String {
    let line = |strategy: Strategy| {
        let exact = if strategy.is_exact() { "exact" } else { "not exact" };
        format!("{:<17} {exact:<10} {}\n", strategy.name(), summary(strategy))
    };
    Strategy::ALL.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_begins_with_a_name_and_fits_a_terminal() {
        let list = list();
        let names = list.lines().map(|line| line.split(' ').next().unwrap());
        assert!(names.eq(Strategy::ALL.map(Strategy::name)));
        for line in list.lines() {
            assert!(line.len() <= 79 && line.len() > 40, "{line}");
        }
        assert_eq!(list.matches("not exact").count(), 1);
    }
}

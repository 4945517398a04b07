//! The strategies that a walk compares, by their names on the command line and in reports.

pub use antumbra::cull::Strategy;
pub use antumbra::methods::strategies;

/// Returns the strategy of this name.
pub fn named(name: &str) -> Option<Strategy> {
    strategies().into_iter().find(|strategy| strategy.name() == name)
}

/// Returns a line for each strategy: its name, exact or not, its summary.
pub fn list() -> String {
    let line = |strategy: Strategy| {
        let exact = if strategy.is_exact() { "exact" } else { "not exact" };
        format!("{:<17} {exact:<10} {}\n", strategy.name(), strategy.summary())
    };
    strategies().into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_begins_with_a_name_and_fits_a_terminal() {
        let list = list();
        let names = list.lines().map(|line| line.split(' ').next().unwrap());
        assert!(names.eq(strategies().into_iter().map(Strategy::name)));
        for line in list.lines() {
            assert!(line.len() <= 79 && line.len() > 40, "{line}");
        }
        assert_eq!(list.matches("not exact").count(), 1);
    }
}

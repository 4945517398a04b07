//! The division of one budget of queries among the views of a frame.
//!
//! Views are planned in ascending order of the queries that they used last time. Each view gets an
//! equal share of the queries that are left, so queries that a view does not use go to the views
//! after it. No view gets less than an equal share of the whole budget. A share is rounded up.
//! Views that used equal numbers of queries take turns at the front of the order. So if there are
//! fewer queries than views, a view without queries gets some at the latest after one frame per
//! view.

/// One budget of queries for all views of a frame, each of which has a history of its own: the eyes
/// of a stereo pair, the parts of a split screen, mirrors, the faces of a cube. Keep it from frame
/// to frame. It affects only the cost, never the image.
#[derive(Clone, Debug, Default)]
pub struct QueryShares {
    /// The indices of the views, in the order of planning.
    order: Vec<usize>,
    /// The number of frames planned.
    frames: usize,
}

impl QueryShares {
    /// Plans the next frame of `views`, which must come in the same order each time, with at most
    /// `query_budget` queries together.
    ///
    /// `used` returns the number of queries in a view's newest plan (such as
    /// [`FramePlan::query_count`](crate::FramePlan::query_count)). `plan` plans the view of an
    /// index, with at most the given share of queries ([`Culler::plan`](crate::Culler::plan)); it
    /// is called once per view. Record the views after this call, because the order of planning is
    /// not the order of drawing. Allocates if there are more views than ever before.
    pub fn plan_views<V>(
        &mut self,
        query_budget: usize,
        views: &mut [V],
        used: impl Fn(&V) -> usize,
        mut plan: impl FnMut(usize, &mut V, usize),
    ) {
        let count = views.len();
        self.frames = self.frames.wrapping_add(1);
        let first = self.frames % count.max(1);
        let turn = |number: usize| (number + count - first) % count;
        self.order.clear();
        self.order.extend(0..count);
        self.order.sort_unstable_by_key(|number| (used(&views[*number]), turn(*number)));
        let mut left = query_budget;
        for (planned, number) in self.order.iter().enumerate() {
            let view = &mut views[*number];
            plan(*number, view, left.div_ceil(count - planned));
            left = left.saturating_sub(used(view));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::QueryShares;

    /// A view that requests some queries, with the number that it used in each frame.
    struct Asking {
        asks: usize,
        used: Vec<usize>,
    }

    fn frames(count: usize, query_budget: usize, asks: &[usize]) -> Vec<Asking> {
        let mut views: Vec<Asking> =
            asks.iter().map(|asks| Asking { asks: *asks, used: Vec::new() }).collect();
        let mut shares = QueryShares::default();
        for _ in 0..count {
            next(&mut shares, query_budget, &mut views);
        }
        views
    }

    fn next(shares: &mut QueryShares, query_budget: usize, views: &mut [Asking]) {
        let used = |view: &Asking| view.used.last().copied().unwrap_or(0);
        let mut planned = vec![0; views.len()];
        shares.plan_views(query_budget, views, used, |number, view, share| {
            planned[number] += 1;
            view.used.push(view.asks.min(share));
        });
        assert!(planned.iter().all(|times| *times == 1), "{planned:?}");
        assert!(views.iter().map(used).sum::<usize>() <= query_budget);
    }

    fn last(views: &[Asking]) -> Vec<usize> {
        views.iter().map(|view| view.used.last().copied().unwrap_or(0)).collect()
    }

    #[test]
    fn what_a_view_leaves_goes_to_the_others() {
        assert_eq!(last(&frames(1, 100, &[500])), [100]);
        assert_eq!(last(&frames(3, 100, &[10, 500])), [10, 90]);
        assert_eq!(last(&frames(3, 100, &[500, 10, 500])), [45, 10, 45]);
        assert_eq!(last(&frames(3, 100, &[500, 0, 500, 20])), [40, 0, 40, 20]);
        assert_eq!(last(&frames(3, 100, &[30, 30, 30])), [30, 30, 30]);
        assert!(last(&frames(1, 100, &[])).is_empty());
    }

    #[test]
    fn a_view_that_asks_for_more_gets_it_within_few_frames() {
        let mut shares = QueryShares::default();
        let asking = |asks| Asking { asks, used: Vec::new() };
        let mut views = [asking(10), asking(10), asking(500)];
        for _ in 0..3 {
            next(&mut shares, 100, &mut views);
        }
        assert_eq!(last(&views), [10, 10, 80]);
        views[0].asks = 500;
        next(&mut shares, 100, &mut views);
        assert!(views[0].used.last() >= Some(&33), "{:?}", last(&views));
        next(&mut shares, 100, &mut views);
        assert_eq!(last(&views), [45, 10, 45]);
    }

    /// Checks budgets down to a single query for views that could all use more.
    #[test]
    fn no_view_starves() {
        for count in 1..=7 {
            for query_budget in 1..=2 * count {
                for idle in 0..count {
                    let mut asks = vec![50; count];
                    asks[..idle].fill(0);
                    for (number, view) in frames(60, query_budget, &asks)[idle..].iter().enumerate()
                    {
                        let what = format!("view {number} of {count}, {query_budget} queries");
                        let mut gaps = view.used.windows(count + 1);
                        let served = gaps.all(|gap| gap.iter().any(|gap| *gap > 0));
                        assert!(served, "{what}: {:?}", view.used);
                        let equal = view.used.iter().all(|used| *used >= query_budget / count);
                        assert!(equal, "{what}: {:?}", view.used);
                    }
                }
            }
        }
    }
}

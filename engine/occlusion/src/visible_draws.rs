//! The visible draws of a plan, bucket by bucket and front to back.

use std::ops::Range;

use cull::{FramePlan, LeafIndex, QueryTag};

use crate::leaf_table::{BucketId, DrawLayout};

/// The visible draws of one frame, kept to allocate nothing in the steady state.
#[derive(Debug, Default)]
pub(crate) struct VisibleDraws {
    /// The cell of each draw.
    cells: Vec<u32>,
    /// The draws under a query of their own.
    queried: Vec<QueriedDraws>,
    buckets: Vec<VisibleBucket>,
    /// The next position in the list of draws, and in the list of queried draws, for each bucket.
    next: Vec<[u32; 2]>,
}

/// The draws of one leaf in one bucket, under one query.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct QueriedDraws {
    /// The positions in the list of draws.
    pub(crate) draws: Range<u32>,
    pub(crate) query: u32,
}

/// The draws of one bucket.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct VisibleBucket {
    pub(crate) bucket: BucketId,
    /// The positions in the list of draws.
    pub(crate) draws: Range<u32>,
    /// The draws under queries, in the order of their draws.
    queried: Range<u32>,
}

impl VisibleDraws {
    /// Lays out the visible draws of a plan. Calls `query` with the tag of each query: a queried
    /// leaf has a query with this tag for each bucket in which it has draws.
    pub(crate) fn lay_out(
        &mut self,
        plan: &FramePlan,
        layout: &DrawLayout,
        mut query: impl FnMut(QueryTag),
    ) {
        self.next.clear();
        self.next.resize(layout.bucket_count() as usize, [0, 0]);
        let mut draws = 0;
        let mut queries = 0;
        for (leaf, tag) in front_to_back(plan) {
            let mut before = None;
            layout.cells_of(leaf, |bucket, _| {
                let [of_bucket, queried] = &mut self.next[bucket.0 as usize];
                *of_bucket += 1;
                draws += 1;
                if let Some(tag) = tag.filter(|_| before.replace(bucket) != Some(bucket)) {
                    *queried += 1;
                    queries += 1;
                    query(tag);
                }
            });
        }
        self.begin_buckets();
        self.cells.clear();
        self.cells.resize(draws, 0);
        self.queried.clear();
        self.queried.resize(queries, QueriedDraws::default());
        self.place(plan, layout);
    }

    /// Clears the list.
    pub(crate) fn clear(&mut self) {
        self.cells.clear();
        self.queried.clear();
        self.buckets.clear();
    }

    /// Turns the counts in `next` into positions, one bucket after the other.
    fn begin_buckets(&mut self) {
        self.buckets.clear();
        let mut ends = [0, 0];
        for (bucket, next) in (0..).map(BucketId).zip(&mut self.next) {
            let starts = ends;
            ends = [starts[0] + next[0], starts[1] + next[1]];
            *next = starts;
            if starts[0] < ends[0] {
                let [draws, queried] = [0, 1].map(|list| starts[list]..ends[list]);
                self.buckets.push(VisibleBucket { bucket, draws, queried });
            }
        }
    }

    fn place(&mut self, plan: &FramePlan, layout: &DrawLayout) {
        let Self { cells, queried, next, .. } = self;
        let mut queries = 0..;
        for (leaf, tag) in front_to_back(plan) {
            let mut before = None;
            layout.cells_of(leaf, |bucket, cell| {
                let [draw, of_bucket] = &mut next[bucket.0 as usize];
                cells[*draw as usize] = cell;
                if tag.is_some() {
                    if before.replace(bucket) != Some(bucket) {
                        let query = queries.next().unwrap_or_default();
                        queried[*of_bucket as usize] = QueriedDraws { draws: *draw..*draw, query };
                        *of_bucket += 1;
                    }
                    queried[*of_bucket as usize - 1].draws.end += 1;
                }
                *draw += 1;
            });
        }
    }

    pub(crate) fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Returns the buckets with draws, in their order.
    pub(crate) fn buckets(&self) -> &[VisibleBucket] {
        &self.buckets
    }

    /// Returns the draws of a bucket that are under queries.
    pub(crate) fn queried(&self, bucket: &VisibleBucket) -> &[QueriedDraws] {
        &self.queried[bucket.queried.start as usize..bucket.queried.end as usize]
    }
}

/// Returns the visible leaves of a plan in their order, with the tags of the queried ones.
fn front_to_back(plan: &FramePlan) -> impl Iterator<Item = (LeafIndex, Option<QueryTag>)> {
    let mut queried = plan.queried_draws.iter().zip(&plan.queried_after).peekable();
    let mut draws = plan.draws.iter();
    let mut drawn = 0;
    std::iter::from_fn(move || {
        if let Some(((leaf, tag), _)) = queried.next_if(|(_, after)| **after <= drawn) {
            return Some((*leaf, Some(*tag)));
        }
        drawn += 1;
        match draws.next() {
            Some(leaf) => Some((*leaf, None)),
            None => queried.next().map(|((leaf, tag), _)| (*leaf, Some(*tag))),
        }
    })
}

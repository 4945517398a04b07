//! Plans the six faces of a cube in one call that shares a budget of queries, and in six calls with
//! a sixth of the budget each, alternately. Prints the medians of the CPU time per frame, their
//! ratio, and the number of leaves that were drawn untested because of missing queries. Arguments:
//! the number of objects, of frames, and of queries.

use std::error::Error;
use std::time::{Duration, Instant};

use antumbra_cull::{
    Aabb, Answer, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, Projection,
    QueryShares, Strategy,
};
use glam::{Vec3, vec3};

const FACES: [Vec3; 6] = [Vec3::NEG_Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z];

/// A face with its history.
struct Face {
    culler: Culler,
    plan: FramePlan,
    answers: Vec<Answer>,
}

impl Face {
    fn plan(&mut self, hierarchy: &Hierarchy, view: &CullView, queries: usize) {
        self.culler.ingest(hierarchy, self.answers.drain(..));
        self.culler.plan(hierarchy, Strategy::ANTUMBRA, view, queries, &mut self.plan);
    }

    /// Answers in place of a GPU: near objects show.
    fn answer(&mut self, hierarchy: &Hierarchy, view: &CullView) {
        let Self { plan, answers, .. } = self;
        let tested = plan.tests.iter().map(|test| test.tag);
        answers.extend(
            tested.chain(plan.queried_draws.iter().map(|queried_draw| queried_draw.1)).map(|tag| {
                let distance_squared = view.rays.distance_squared(&hierarchy.bounds(tag.node));
                Answer { tag, samples: u32::from(distance_squared < 3600.0) }
            }),
        );
    }
}

/// Returns houses on a square.
fn houses(count: usize) -> Vec<Aabb> {
    let side = count.isqrt().max(1);
    let house = |number: usize| {
        let corner = vec3((number % side) as f32, 0.0, (number / side) as f32) * 4.0;
        Aabb::new(corner, corner + vec3(3.0, 1.0 + (number * 7919 % 31) as f32, 3.0))
    };
    (0..count).map(house).collect()
}

/// Returns the six faces around a position on a walk through the houses.
fn views(count: usize, frame: usize) -> [CullView; 6] {
    let middle = count.isqrt() as f32 * 2.0;
    let step = frame as f32 * 0.1;
    FACES.map(|forward| {
        let up = if forward.y == 0.0 { Vec3::Y } else { Vec3::X };
        let projection = Projection::perspective(std::f32::consts::FRAC_PI_2);
        let eye = vec3(middle + 3.5, 1.7, middle + step);
        CullView::new(&Camera { eye, forward, up, projection, near: 0.1 }, [512, 512], 8)
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let number = |place| std::env::args().nth(place).and_then(|text| text.parse::<usize>().ok());
    let count = number(1).unwrap_or(100_000);
    let frames = number(2).unwrap_or(400);
    let query_budget = number(3).unwrap_or(600);
    let hierarchy = Hierarchy::build(&houses(count))?;
    let new = || Face {
        culler: Culler::new(CullConfig::default()),
        plan: FramePlan::default(),
        answers: Vec::new(),
    };
    let [mut together, mut apart] = [(); 2].map(|()| FACES.map(|_| new()));
    let mut shares = QueryShares::default();
    let mut times: [Vec<Duration>; 2] = Default::default();
    let mut untested = [0_u64; 2];
    for frame in 0..frames {
        let views = views(count, frame);
        let begun = Instant::now();
        let queries = |face: &Face| face.plan.query_count();
        shares.plan_views(query_budget, &mut together, queries, |number, face, share| {
            face.plan(&hierarchy, &views[number], share);
        });
        times[0].push(begun.elapsed());
        let begun = Instant::now();
        for (face, view) in apart.iter_mut().zip(&views) {
            face.plan(&hierarchy, view, query_budget / FACES.len());
        }
        times[1].push(begun.elapsed());
        for (untested, faces) in untested.iter_mut().zip([&mut together, &mut apart]) {
            for (face, view) in faces.iter_mut().zip(&views) {
                face.answer(&hierarchy, view);
                *untested += u64::from(face.plan.stats.over_budget);
            }
        }
    }
    let [one, six] = times.map(|mut times| {
        times.sort_unstable();
        times.get(times.len() / 2).map_or(0.0, |median| 1e3 * median.as_secs_f64())
    });
    println!("median CPU ms: {one:.3} by one call, {six:.3} by six; ratio {:.3}", one / six);
    println!("leaves drawn untested: {} by one call, {} by six", untested[0], untested[1]);
    Ok(())
}

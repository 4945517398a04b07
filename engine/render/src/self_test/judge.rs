//! The verdicts that follow from the results of the probe. Pure: tests need no device.

use gpu::ResultSource;
use occlusion::Rect;

use super::check_result::CheckResult;
use super::probe::{PER_DECISION, QueriedSamples, TestedProxies};
use super::probe_scene::{CELL, CELLS, PROBES, SIZE};

const PIXEL_BYTES: usize = 4;

/// Returns the number of drawn pixels in each cell.
pub(super) fn drawn_pixels(rgba: &[u8]) -> Vec<u32> {
    pixels_of_cells(rgba, differs).iter().map(|pixels| pixels.len() as u32).collect()
}

/// Returns the number of pixels with a warm or green colour in each cell. All objects have such a
/// colour under any light; the sky, and pixels with depth alone, do not.
pub(super) fn shaded_pixels(rgba: &[u8]) -> Vec<u32> {
    let is_shaded = |pixel: Option<&[u8]>, _: Option<&[u8]>| match pixel {
        Some([red, green, blue, _]) => red.max(green) > blue,
        _ => false,
    };
    pixels_of_cells(rgba, is_shaded).iter().map(|pixels| pixels.len() as u32).collect()
}

/// Returns the smallest area around the drawn pixels of each cell.
pub(super) fn drawn_areas(rgba: &[u8]) -> Vec<Rect> {
    let area = |pixels: &Vec<[u32; 2]>| {
        let side = |axis: usize| {
            let places = || pixels.iter().map(|pixel| pixel[axis]);
            let low = places().min().unwrap_or(0);
            let high = places().max().map_or(0, |places| places + 1);
            (low, high - low)
        };
        let (left, width) = side(0);
        let (top, height) = side(1);
        Rect { origin: [left, top], size: [width, height] }
    };
    pixels_of_cells(rgba, differs).iter().map(area).collect()
}

/// Returns true if a pixel has another colour than the corner of its cell, where nothing is drawn.
fn differs(pixel: Option<&[u8]>, corner: Option<&[u8]>) -> bool {
    pixel != corner
}

/// Returns the drawn pixels of each cell. `is_drawn` compares a pixel with the corner of the cell.
fn pixels_of_cells(
    rgba: &[u8],
    is_drawn: impl Fn(Option<&[u8]>, Option<&[u8]>) -> bool,
) -> Vec<Vec<[u32; 2]>> {
    let pixel = |x: u32, y: u32| {
        let first = (y * SIZE[0] + x) as usize * PIXEL_BYTES;
        rgba.get(first..first + PIXEL_BYTES)
    };
    let cell = |number: usize| {
        let left = number as u32 % CELLS[0] * CELL;
        let top = number as u32 / CELLS[0] * CELL;
        let corner = pixel(left, top);
        let pixels = (top..top + CELL).flat_map(|y| (left..left + CELL).map(move |x| [x, y]));
        pixels.filter(|[x, y]| is_drawn(pixel(*x, *y), corner)).collect()
    };
    (0..PROBES).map(cell).collect()
}

/// Counts the places at which two lists do not agree. Missing values at the end of `found` do not
/// agree.
fn faults(expected: &[u32], found: &[u32], agree: impl Fn(u32, u32) -> bool) -> usize {
    let found = found.iter().copied().map(Some).chain(std::iter::repeat(None));
    let agrees =
        |(expected, found): (&u32, Option<u32>)| found.is_some_and(|found| agree(*expected, found));
    expected.iter().zip(found).filter(|pair| !agrees(*pair)).count()
}

/// Judges the counts of queries by the pixels of the image.
pub(super) fn query_counts(
    pixels: &[u32],
    found: &QueriedSamples,
    counts: CountsSamples,
) -> CheckResult {
    let agree = |expected: u32, samples: u32| match counts {
        // A pixel where faces of an object meet may count for each of the three visible faces.
        CountsSamples::Exactly => (expected..=3 * expected).contains(&samples),
        CountsSamples::No => (samples > 0) == (expected > 0),
    };
    let wrong = faults(pixels, &found.objects, agree);
    let hidden = faults(pixels, &found.hidden, |_, samples| samples == 0);
    let sum = |samples: &[u32]| samples.iter().copied().map(u64::from).sum::<u64>();
    // Such pixels are few.
    let is_more = counts == CountsSamples::Exactly && 4 * sum(&found.objects) > 5 * sum(pixels);
    CheckResult::of_faults(
        wrong + hidden + usize::from(is_more),
        2 * pixels.len() + 1,
        "occlusion queries say something else than the image",
    )
}

/// The meaning of the results of queries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CountsSamples {
    /// Results are numbers of samples.
    Exactly,
    /// Results only distinguish zero from other numbers.
    No,
}

/// Judges the visible proxies that a tester reports by the pixels of the image.
pub(super) fn shown_proxies(pixels: &[u32], found: &TestedProxies, of: &str) -> CheckResult {
    let lost = faults(pixels, &found.shown, |expected, result| expected == 0 || result > 0);
    CheckResult::of_faults(lost, pixels.len(), &format!("objects that show are lost by {of}"))
}

/// Judges the results of a tester for proxies that are entirely hidden.
pub(super) fn hidden_proxies(pixels: &[u32], found: &TestedProxies, of: &str) -> CheckResult {
    let wrong = faults(pixels, &found.hidden, |_, result| result == 0);
    CheckResult::of_faults(wrong, pixels.len(), &format!("hidden boxes count as visible by {of}"))
}

/// Judges the samples of a proxy by the samples of its object: the proxy must cover all of them.
pub(super) fn enclosing(
    pixels: &[u32],
    samples: &[u32],
    counts: CountsSamples,
    sentence: &str,
) -> CheckResult {
    let agree = |expected: u32, samples: u32| match counts {
        CountsSamples::Exactly => samples >= expected,
        CountsSamples::No => expected == 0 || samples > 0,
    };
    CheckResult::of_faults(faults(pixels, samples, agree), pixels.len(), sentence)
}

/// Judges the image of objects under predicates that enable every other range.
pub(super) fn predicated(pixels: &[u32], found: &[u32], source: ResultSource) -> CheckResult {
    let expected = |(place, pixels): (usize, &u32)| {
        if (place / PER_DECISION).is_multiple_of(2) { *pixels } else { 0 }
    };
    let expected: Vec<u32> = pixels.iter().enumerate().map(expected).collect();
    let of = match source {
        ResultSource::Queries => "queries",
        ResultSource::Fragments => "flags",
        ResultSource::Compute => "the compute tester",
    };
    let wrong = faults(&expected, found, |expected, found| expected == found);
    CheckResult::of_faults(
        wrong,
        expected.len(),
        &format!("draws under predicates of {of} are drawn or skipped against them"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(pixels: &[u32]) -> QueriedSamples {
        QueriedSamples {
            objects: pixels.to_vec(),
            proxies: pixels.to_vec(),
            alone: pixels.iter().map(|pixel| pixel + 9).collect(),
            hidden: vec![0; pixels.len()],
        }
    }

    #[test]
    fn queries_are_judged_by_pixels() {
        let pixels = [3, 0, 5];
        let exactly = CountsSamples::Exactly;
        assert_eq!(query_counts(&pixels, &samples(&pixels), exactly), CheckResult::Passed);
        let vague = QueriedSamples { objects: vec![1, 0, 1], ..samples(&pixels) };
        assert_eq!(query_counts(&pixels, &vague, CountsSamples::No), CheckResult::Passed);
        assert_ne!(query_counts(&pixels, &vague, exactly), CheckResult::Passed);
        for broken in [
            QueriedSamples { hidden: vec![0, 1, 0], ..samples(&pixels) },
            QueriedSamples { objects: vec![3, 0], ..samples(&pixels) },
            QueriedSamples { objects: vec![3, 0, 16], ..samples(&pixels) },
            QueriedSamples { objects: pixels.map(|pixel| 2 * pixel).to_vec(), ..samples(&pixels) },
        ] {
            assert_ne!(query_counts(&pixels, &broken, exactly), CheckResult::Passed);
        }
    }

    #[test]
    fn a_proxy_may_have_more_samples_than_its_object_and_never_fewer() {
        let judge = |samples: &[u32], counts| enclosing(&[3, 0], samples, counts, "are lost");
        assert_eq!(judge(&[3, 0], CountsSamples::Exactly), CheckResult::Passed);
        assert_eq!(judge(&[9, 9], CountsSamples::Exactly), CheckResult::Passed);
        let broken = CheckResult::Failed("1 of 2 are lost".to_owned());
        assert_eq!(judge(&[2, 9], CountsSamples::Exactly), broken);
        assert_eq!(judge(&[2, 0], CountsSamples::No), CheckResult::Passed);
        assert_eq!(judge(&[0, 9], CountsSamples::No), broken);
    }

    #[test]
    fn testers_are_judged_by_both_kinds_of_error() {
        let found = |shown: &[u32], hidden: &[u32]| TestedProxies {
            shown: shown.to_vec(),
            hidden: hidden.to_vec(),
        };
        assert_eq!(shown_proxies(&[3, 0], &found(&[1, 0], &[]), "x"), CheckResult::Passed);
        assert_ne!(shown_proxies(&[3, 0], &found(&[0, 1], &[]), "x"), CheckResult::Passed);
        assert_eq!(hidden_proxies(&[3, 0], &found(&[], &[0, 0]), "x"), CheckResult::Passed);
        assert_ne!(hidden_proxies(&[3, 0], &found(&[], &[0, 1]), "x"), CheckResult::Passed);
    }

    #[test]
    fn every_other_range_is_drawn() {
        let pixels = [2; 3 * PER_DECISION];
        let mut drawn = [[2; PER_DECISION], [0; PER_DECISION], [2; PER_DECISION]].concat();
        let judge = |drawn: &[u32]| predicated(&pixels, drawn, ResultSource::Queries);
        assert_eq!(judge(&drawn), CheckResult::Passed);
        drawn[PER_DECISION] = 2;
        assert!(judge(&drawn).detail().starts_with("1 of 12 draws under predicates of queries"));
        assert_ne!(judge(&[0; 3 * PER_DECISION]), CheckResult::Passed);
        assert_ne!(judge(&pixels), CheckResult::Passed);
    }

    #[test]
    fn drawn_pixels_differ_from_the_corner_of_their_cell() {
        let mut rgba = vec![7; (SIZE[0] * SIZE[1]) as usize * PIXEL_BYTES];
        assert!(drawn_pixels(&rgba).iter().all(|pixels| *pixels == 0));
        let x = CELL + 4;
        let y = 2 * CELL + 5;
        rgba[(y * SIZE[0] + x) as usize * PIXEL_BYTES] = 9;
        let drawn = drawn_pixels(&rgba);
        assert_eq!(drawn.iter().sum::<u32>(), 1);
        let cell = (2 * CELLS[0] + 1) as usize;
        assert_eq!(drawn[cell], 1);
        let areas = drawn_areas(&rgba);
        assert_eq!(areas[cell], Rect { origin: [x, y], size: [1, 1] });
        assert_eq!(areas[0].size, [0, 0]);
        assert_eq!(shaded_pixels(&rgba)[cell], 1);
        rgba[(y * SIZE[0] + x) as usize * PIXEL_BYTES + 2] = 9;
        assert_eq!((drawn_pixels(&rgba)[cell], shaded_pixels(&rgba)[cell]), (1, 0));
    }
}

//! Wrong pixels of every strategy: the number of compared frames, and the result.

use super::cases::{Cases, Place, distinct};
use super::palette;
use crate::strategy::{Strategy, named};

/// The circumstances that can make exactness harder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Setting {
    /// A scene that stands still, in one view.
    Still,
    /// Objects move, appear and disappear.
    Moving,
    /// Several views of one scene.
    Views,
    /// Objects move, in several views.
    MovingViews,
}

impl Setting {
    /// Every setting, in the order of the table.
    pub const ALL: [Self; 4] = [Self::Still, Self::Moving, Self::Views, Self::MovingViews];

    /// Returns its name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Still => "still scenes",
            Self::Moving => "moving objects",
            Self::Views => "several views",
            Self::MovingViews => "moving objects, several views",
        }
    }

    fn of(place: &Place) -> Self {
        match (place.moving, place.views) {
            (1.., 2..) => Self::MovingViews,
            (1.., _) => Self::Moving,
            (_, 2..) => Self::Views,
            _ => Self::Still,
        }
    }

    /// Returns true if a strategy cannot run here, so that a missing comparison is not a gap.
    fn refuses(self, strategy: &str) -> bool {
        let moves = matches!(self, Self::Moving | Self::MovingViews);
        moves && named(strategy).is_some_and(Strategy::needs_still_scene)
    }
}

/// The result of one strategy in one setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Book {
    /// The name of the strategy.
    pub strategy: String,
    /// True if it promises the picture of plain frustum culling. A strategy unknown to this build
    /// promises nothing, nor does one that ran with a threshold in some report.
    pub is_exact: bool,
    /// The setting in which frames were compared.
    pub setting: Setting,
    /// True if it is refused there by design.
    pub is_refused: bool,
    /// The number of compared frames.
    pub frames_compared: u64,
    /// The number of their pixels that differed.
    pub pixels_wrong: u64,
}

/// Returns the result of every strategy of the reports in every setting, by setting and then in the
/// order of the palette. A strategy that was not compared has 0 frames.
pub fn books(cases: &Cases<'_>) -> Vec<Book> {
    let reports = cases.iter().flat_map(|(_, case)| case.reports());
    let runs = reports.flat_map(|report| &report.runs);
    let mut names = distinct(runs.map(|run| run.strategy.as_str()));
    names.sort_by_key(|name| palette::place_of(name));
    let book = |setting: Setting| {
        move |name: &&str| Book {
            strategy: (*name).to_owned(),
            is_exact: named(name).is_some_and(Strategy::is_exact),
            setting,
            is_refused: setting.refuses(name),
            frames_compared: 0,
            pixels_wrong: 0,
        }
    };
    let mut books: Vec<Book> =
        Setting::ALL.into_iter().flat_map(|setting| names.iter().map(book(setting))).collect();
    for (place, case) in cases.iter() {
        let runs = case
            .reports()
            .iter()
            .flat_map(|report| report.runs.iter().map(|run| (run, report.threshold_pixels > 0)));
        for (run, has_threshold) in runs {
            let here = |book: &&mut Book| {
                book.setting == Setting::of(place) && book.strategy == run.strategy
            };
            if let Some(book) = books.iter_mut().find(here) {
                let leaves_out = has_threshold
                    && named(&run.strategy).is_some_and(Strategy::has_sample_threshold);
                book.is_exact &= !leaves_out;
                book.frames_compared += run.frames_verified + run.warm_up_frames_verified;
                book.pixels_wrong += run.pixels_wrong.unwrap_or(0);
            }
        }
    }
    books
}

#[cfg(test)]
mod tests {
    use super::super::testing::{measured, verified};
    use super::*;

    #[test]
    fn every_strategy_has_its_book_in_every_setting() {
        let mut moving = verified("city", "street", 500, &[("antumbra", 12, 3)]);
        moving.provenance.command.extend(["--moving-percent".to_owned(), "10".to_owned()]);
        let reports = [
            measured("city", "street", 2_000, &[("frustum", 4.0), ("mystery", 1.0)]),
            verified("city", "street", 500, &[("antumbra", 12, 0), ("mystery", 12, 7)]),
            verified("city", "fly", 500, &[("antumbra", 8, 0)]),
            moving,
        ];
        let cases = Cases::of(&reports);
        let books = books(&cases);
        assert_eq!(books.len(), 3 * 4);
        let find = |name: &str, setting| {
            books.iter().find(|book| book.strategy == name && book.setting == setting).unwrap()
        };
        let still = find("antumbra", Setting::Still);
        assert_eq!((still.frames_compared, still.pixels_wrong, still.is_exact), (20, 0, true));
        assert_eq!(find("antumbra", Setting::Moving).pixels_wrong, 3);
        assert_eq!(find("antumbra", Setting::Views).frames_compared, 0);
        let mystery = find("mystery", Setting::Still);
        assert_eq!((mystery.pixels_wrong, mystery.is_exact), (7, false));
        assert_eq!(find("frustum", Setting::Still).frames_compared, 0);
    }

    #[test]
    fn what_needs_a_still_scene_is_refused_where_objects_move() {
        let reports = [verified("city", "street", 500, &[("antumbra", 12, 0), ("ideal", 12, 0)])];
        let books = books(&Cases::of(&reports));
        let refused = books.iter().filter(|book| book.is_refused);
        let refused: Vec<_> = refused.map(|book| (book.strategy.as_str(), book.setting)).collect();
        assert_eq!(refused, [("ideal", Setting::Moving), ("ideal", Setting::MovingViews)]);
    }

    #[test]
    fn moving_objects_before_two_eyes_are_a_setting_of_their_own() {
        let mut both = verified("city", "street", 500, &[("antumbra", 12, 3)]);
        both.provenance.command = ["--moving-percent=10", "--views=2"].map(str::to_owned).to_vec();
        both.runs[0].warm_up_frames_verified = 4;
        let reports = [both];
        let books = books(&Cases::of(&reports));
        let wrong = books.iter().map(|book| (book.setting, book.pixels_wrong));
        let wrong: Vec<_> = wrong.filter(|(_, pixels)| *pixels > 0).collect();
        assert_eq!(wrong, [(Setting::MovingViews, 3)]);
        assert!(books.iter().any(|book| book.frames_compared == 16), "with those that warm up");
    }

    #[test]
    fn a_threshold_takes_the_promise_from_those_that_have_it() {
        let mut report = verified("city", "street", 500, &[("antumbra", 12, 3), ("hzb", 12, 0)]);
        report.threshold_pixels = 5;
        let reports = [report];
        let books = books(&Cases::of(&reports));
        let is_exact = |name: &str| {
            let mut still = books.iter().filter(|book| book.setting == Setting::Still);
            still.find(|book| book.strategy == name).unwrap().is_exact
        };
        assert_eq!([is_exact("antumbra"), is_exact("hzb")], [false, true]);
    }
}

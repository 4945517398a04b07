//! A figure over several repetitions: its median and its spread.

use std::fmt;

use crate::statistics::{TimeSummary, thousands};

/// At least one finite value, in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    sorted: Vec<f64>,
}

impl Spread {
    /// Creates a spread of values in any order; those that are not finite are left out.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        (!sorted.is_empty()).then_some(Self { sorted })
    }

    /// Returns the middle value.
    pub fn median(&self) -> f64 {
        TimeSummary::of(self.sorted.iter().copied()).median.unwrap_or(f64::NAN)
    }

    /// Returns the smallest value.
    pub fn least(&self) -> f64 {
        self.sorted.first().copied().unwrap_or(f64::NAN)
    }

    /// Returns the largest value.
    pub fn most(&self) -> f64 {
        self.sorted.last().copied().unwrap_or(f64::NAN)
    }

    /// Returns the number of values.
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// Returns each value of this times each of `other`, since repetitions of the two are not
    /// paired.
    pub fn times(&self, other: &Self) -> Option<Self> {
        Self::of(self.sorted.iter().flat_map(|a| other.sorted.iter().map(move |b| a * b)))
    }

    /// Returns each value of this over each of `other`.
    pub fn over(&self, other: &Self) -> Option<Self> {
        Self::of(self.sorted.iter().flat_map(|a| other.sorted.iter().map(move |b| a / b)))
    }

    /// Returns the reciprocal of each value.
    pub fn inverse(&self) -> Option<Self> {
        Self::of(self.sorted.iter().map(|value| value.recip()))
    }
}

/// Shows it as "1.23 (1.20 to 1.31)", or the value alone if there is only one.
impl fmt::Display for Spread {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", short(self.median()))?;
        if self.count() > 1 {
            write!(formatter, " ({} to {})", short(self.least()), short(self.most()))?;
        }
        Ok(())
    }
}

/// Returns a number with the significant digits: "1.23", "45.6", "158", "0".
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size < 0.1 => format!("{value:.3}"),
        size if size < 9.995 => format!("{value:.2}"),
        size if size < 99.95 => format!("{value:.1}"),
        _ => thousands(value),
    }
}

/// Returns a number of objects as on an axis: "2k", "1M", "500".
pub fn objects(count: f64) -> String {
    match count {
        count if count >= 1e6 => format!("{}M", count / 1e6),
        count if count >= 1e3 => format!("{}k", count / 1e3),
        count => format!("{count}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_have_a_median_and_a_spread() {
        let spread = Spread::of([1.31, 1.2, f64::NAN, 1.23]).unwrap();
        assert_eq!((spread.median(), spread.least(), spread.most()), (1.23, 1.2, 1.31));
        assert_eq!(spread.to_string(), "1.23 (1.20 to 1.31)");
        assert_eq!(Spread::of([2.0]).unwrap().to_string(), "2.00");
        assert_eq!(Spread::of([f64::NAN]), None);
    }

    #[test]
    fn products_and_quotients_take_every_pair() {
        let a = Spread::of([1.0, 2.0]).unwrap();
        let b = Spread::of([4.0, 8.0]).unwrap();
        let product = a.times(&b).unwrap();
        assert_eq!((product.least(), product.most(), product.count()), (4.0, 16.0, 4));
        let quotient = b.over(&a).unwrap();
        assert_eq!((quotient.least(), quotient.most()), (2.0, 8.0));
        assert_eq!(a.inverse().unwrap().least(), 0.5);
        assert_eq!(Spread::of([0.0]).unwrap().inverse(), None);
    }

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (0.0456, "0.046"),
            (0.5, "0.50"),
            (1.234, "1.23"),
            (12.34, "12.3"),
            (158.4, "158"),
            (1_234_567.0, "1,234,567"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
        assert_eq!([500.0, 2e3, 1e6].map(objects), ["500", "2k", "1M"]);
    }
}

//! Axes: from values to places between 0 and 1, linear or logarithmic, with ticks at round values.

use super::spread;

/// The spread of values over an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally far.
    Linear,
    /// Equal ratios are equally far.
    Logarithmic,
}

/// An axis from its least value (place 0) to its largest (place 1).
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    scale: Scale,
    least: f64,
    most: f64,
    /// The ticks' values, with their labels.
    pub ticks: Vec<(f64, String)>,
    /// The quantity on it, with the unit.
    pub label: String,
}

impl Axis {
    /// Returns an axis that covers `least` to `most` with ticks at 1, 2 or 5 times a power of ten.
    pub fn linear(label: &str, least: f64, most: f64) -> Self {
        let most = if most > least { most } else { least + 1.0 };
        let step = round_step((most - least) / 5.0);
        let first = (least / step).ceil();
        let count = ((most / step).floor() - first).max(0.0) as u32;
        let ticks = (0..=count).map(|place| (first + f64::from(place)) * step);
        let digits = (-step.log10().floor()).clamp(0.0, 4.0) as usize;
        let text = |tick: f64| match digits {
            0 => spread::thousands(tick),
            _ => format!("{tick:.digits$}"),
        };
        Self {
            scale: Scale::Linear,
            least,
            most,
            ticks: ticks.map(|tick| (tick, text(tick))).collect(),
            label: label.to_owned(),
        }
    }

    /// Returns an axis that covers `least` to `most`, both above 0, with ticks at powers of ten,
    /// and between them where there are few.
    pub fn logarithmic(label: &str, least: f64, most: f64) -> Self {
        let least = if least > 0.0 { least } else { 1e-3 };
        let most = if most > least { most } else { least * 10.0 };
        let decades = (most / least).log10();
        let steps: &[f64] = if decades > 2.6 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let mut ticks = Vec::new();
        for power in least.log10().floor() as i32..=most.log10().ceil() as i32 {
            let unit = 10f64.powi(power);
            ticks.extend(steps.iter().map(|step| step * unit));
        }
        let margin = 1.0 + 1e-9;
        ticks.retain(|tick| *tick * margin >= least && *tick <= most * margin);
        Self {
            scale: Scale::Logarithmic,
            least,
            most,
            ticks: ticks.into_iter().map(|tick| (tick, plain(tick))).collect(),
            label: label.to_owned(),
        }
    }

    /// Returns the same axis with these ticks.
    pub fn with_ticks(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks, ..self }
    }

    /// Returns the largest value on it.
    pub fn most(&self) -> f64 {
        self.most
    }

    /// Returns the place of a value: 0 at the least, 1 at the largest, beyond them for values
    /// beyond. Values that a logarithmic axis has no place for lie at its beginning.
    pub fn place(&self, value: f64) -> f64 {
        let place = match self.scale {
            Scale::Linear => (value - self.least) / (self.most - self.least),
            Scale::Logarithmic => (value / self.least).ln() / (self.most / self.least).ln(),
        };
        if place.is_finite() { place } else { 0.0 }
    }
}

/// Returns the round step (1, 2 or 5 times a power of ten) nearest above a wanted one.
fn round_step(wanted: f64) -> f64 {
    let unit = 10f64.powf(wanted.log10().floor());
    let multiple = [1.0, 2.0, 5.0].into_iter().find(|step| step * unit >= wanted * 0.999);
    multiple.unwrap_or(10.0) * unit
}

/// Returns a tick's value without insignificant digits.
fn plain(value: f64) -> String {
    if value >= 1.0 {
        return spread::thousands(value);
    }
    let digits = (-value.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(texts(&Axis::linear("", 0.0, 50.0)), ["0", "10", "20", "30", "40", "50"]);
        assert_eq!(texts(&Axis::linear("", 0.9, 2.1)), ["1.0", "1.5", "2.0"]);
        assert_eq!(texts(&Axis::linear("", 0.0, 4_000.0)).last(), Some(&"4,000"));
        assert_eq!(texts(&Axis::logarithmic("", 0.9, 51.0)), ["1", "2", "5", "10", "20", "50"]);
        assert_eq!(texts(&Axis::logarithmic("", 0.05, 0.6)), ["0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(texts(&Axis::logarithmic("", 1.0, 1e4)), ["1", "10", "100", "1,000", "10,000"]);
    }

    #[test]
    fn equal_ratios_are_equally_far_on_a_logarithmic_axis() {
        let axis = Axis::logarithmic("", 1.0, 100.0);
        assert!((axis.place(10.0) - 0.5).abs() < 1e-12);
        assert_eq!((axis.place(1.0), axis.place(100.0)), (0.0, 1.0));
        assert_eq!(axis.place(0.0), 0.0, "has no logarithm");
    }

    proptest! {
        #[test]
        fn any_range_gives_an_axis(least in -1e6..1e6, length in -10.0..1e6) {
            for axis in [
                Axis::linear("", least, least + length), Axis::logarithmic("", least, least + length),
            ] {
                prop_assert!(axis.ticks.len() < 30, "{axis:?}");
                for (tick, _) in &axis.ticks {
                    prop_assert!((-1e-6..=1.0 + 1e-6).contains(&axis.place(*tick)), "{axis:?}");
                }
            }
        }
    }
}

//! The ways to draw shadows that a walk compares, by their names on the command line and in
//! reports.

use std::str::FromStr;

use antumbra::shadows::{
    CasterCulling, ShadowBias, ShadowCaching, ShadowFilter, ShadowMethod, ShadowOptions,
};

use crate::choices::parse_listed;

/// A way to make shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShadowWay {
    /// `off`: no shadows.
    Off,
    /// `maps`: shadow maps that are drawn again only where something changed.
    Maps,
    /// `maps_uncached`: shadow maps that are drawn afresh in each frame, with the casters that
    /// matter.
    MapsUncached,
    /// `maps_unculled`: shadow maps that are drawn afresh in each frame, with all casters.
    MapsUnculled,
    /// `volumes`: stencil shadow volumes of the casters that matter, which no filter changes.
    Volumes,
    /// `volumes_unculled`: stencil shadow volumes of all casters.
    VolumesUnculled,
}

impl ShadowWay {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Off,
        Self::Maps,
        Self::MapsUncached,
        Self::MapsUnculled,
        Self::Volumes,
        Self::VolumesUnculled,
    ];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Maps => "maps",
            Self::MapsUncached => "maps_uncached",
            Self::MapsUnculled => "maps_unculled",
            Self::Volumes => "volumes",
            Self::VolumesUnculled => "volumes_unculled",
        }
    }

    /// Returns the way whose images are right by construction: nothing is kept from earlier frames,
    /// and nothing left out.
    fn reference(self) -> Self {
        match self {
            Self::Off => Self::Off,
            Self::Maps | Self::MapsUncached | Self::MapsUnculled => Self::MapsUnculled,
            Self::Volumes | Self::VolumesUnculled => Self::VolumesUnculled,
        }
    }
}

impl FromStr for ShadowWay {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        parse_listed("way to make shadows", text, &Self::ALL, Self::name)
    }
}

/// Finds a filter by its name.
///
/// # Errors
/// A sentence with all names.
pub fn parse_filter(text: &str) -> Result<ShadowFilter, String> {
    parse_listed("filter", text, &ShadowFilter::ALL, ShadowFilter::name)
}

/// Finds a bias by its name.
///
/// # Errors
/// A sentence with all names.
pub fn parse_bias(text: &str) -> Result<ShadowBias, String> {
    parse_listed("bias", text, &ShadowBias::ALL, ShadowBias::name)
}

/// A way to make shadows, and their filter and bias.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadowChoice {
    /// The way to make them.
    pub way: ShadowWay,
    /// The filter of shadow maps.
    pub filter: ShadowFilter,
    /// The remedy of shadow maps against surfaces that shadow themselves.
    pub bias: ShadowBias,
}

impl ShadowChoice {
    /// No shadows.
    pub const OFF: Self =
        Self { way: ShadowWay::Off, filter: ShadowFilter::Adaptive, bias: ShadowBias::Plane };

    /// Returns the choice whose images are right by construction, with the same filter and bias.
    /// Without shadows the filter does not matter.
    #[must_use]
    pub fn reference(self) -> Self {
        match self.way.reference() {
            ShadowWay::Off => Self::OFF,
            way => Self { way, ..self },
        }
    }

    /// Returns the choice with 64 samples everywhere and no kept maps, for comparing the images of
    /// other filters; `None` if there are no maps to filter.
    #[must_use]
    pub fn fixed64(self) -> Option<Self> {
        let has_maps = matches!(self.way, ShadowWay::Maps | ShadowWay::MapsUncached);
        has_maps.then(|| Self { filter: ShadowFilter::Fixed64, ..self.reference() })
    }

    /// Returns the renderer's options.
    #[must_use]
    pub fn options(self) -> ShadowOptions {
        let method = match self.way {
            ShadowWay::Off => ShadowMethod::Off,
            ShadowWay::Maps | ShadowWay::MapsUncached | ShadowWay::MapsUnculled => {
                ShadowMethod::Maps
            }
            ShadowWay::Volumes | ShadowWay::VolumesUnculled => ShadowMethod::Volumes,
        };
        let caching = match self.way {
            ShadowWay::Off | ShadowWay::Maps => ShadowCaching::Cached,
            ShadowWay::MapsUncached
            | ShadowWay::MapsUnculled
            | ShadowWay::Volumes
            | ShadowWay::VolumesUnculled => ShadowCaching::Uncached,
        };
        let culling = match self.way {
            ShadowWay::MapsUnculled | ShadowWay::VolumesUnculled => CasterCulling::Unculled,
            _ => CasterCulling::Culled,
        };
        let Self { filter, bias, .. } = self;
        ShadowOptions { method, caching, culling, filter, bias, ..ShadowOptions::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_and_filters_are_found_by_name_or_refused_in_a_sentence() {
        for way in ShadowWay::ALL {
            assert_eq!(way.name().parse(), Ok(way));
        }
        for filter in ShadowFilter::ALL {
            assert_eq!(parse_filter(filter.name()), Ok(filter));
        }
        let refused = "map".parse::<ShadowWay>().unwrap_err();
        assert!(refused.ends_with("did you mean 'maps'?"), "{refused}");
        for bias in ShadowBias::ALL {
            assert_eq!(parse_bias(bias.name()), Ok(bias));
        }
        let refused = parse_bias("midpiont").unwrap_err();
        assert!(refused.ends_with("did you mean 'midpoint'?"), "{refused}");
        let refused = parse_filter("pcf5").unwrap_err();
        assert!(refused.contains("unknown filter 'pcf5'"), "{refused}");
    }

    #[test]
    fn references_keep_nothing_of_earlier_frames() {
        for (filter, bias) in ShadowFilter::ALL.into_iter().zip(ShadowBias::ALL.repeat(2)) {
            for way in ShadowWay::ALL {
                let reference = ShadowChoice { way, filter, bias }.reference();
                assert_eq!(reference.reference(), reference);
                let options = reference.options();
                assert_eq!(options.method == ShadowMethod::Off, way == ShadowWay::Off);
                if way != ShadowWay::Off {
                    assert_eq!(options.caching, ShadowCaching::Uncached);
                    assert_eq!(options.culling, CasterCulling::Unculled);
                    assert_eq!((options.filter, options.bias), (filter, bias));
                }
                assert_eq!(options.check(), Ok(()));
            }
        }
    }
}

//! The options of shadows, and their checks.

/// The way in which shadows are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowMethod {
    /// No shadows.
    #[default]
    Off,
    /// Shadow maps: the depth as each light sees it.
    Maps,
    /// Stencil shadow volumes: hard edges, exact to the pixel. The options of maps have no effect.
    /// Volumes are counted against the depth of each view.
    Volumes,
}

impl ShadowMethod {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Off, Self::Maps, Self::Volumes];
}

/// The filter of shadow maps. Each sample compares with the four nearest texels and mixes the
/// results bilinearly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowFilter {
    /// One sample: edges as wide as a texel.
    Single,
    /// Percentage-closer filtering of three by three samples, a texel apart.
    Pcf3,
    /// 64 samples of a disk as wide as the light's penumbra, for every pixel.
    Fixed64,
    /// 64 samples of the disk of [`ShadowFilter::Fixed64`], of which the first 8 lie at its edge:
    /// they decide whether the other 56 are taken (Uralsky, "Efficient Soft-Edged Shadows Using
    /// Pixel Shader Branching", GPU Gems 2, chapter 17).
    #[default]
    Adaptive,
    /// A disk whose width follows from the distance to the blockers (Fernando, "Percentage-Closer
    /// Soft Shadows", 2005): 8 samples find blockers, 12 filter.
    Pcss12,
    /// The filter of [`ShadowFilter::Pcss12`] with 32 samples that find blockers and 64 that
    /// filter.
    Pcss64,
}

impl ShadowFilter {
    /// All filters, the cheapest first.
    pub const ALL: [Self; 6] =
        [Self::Single, Self::Pcf3, Self::Adaptive, Self::Pcss12, Self::Fixed64, Self::Pcss64];

    /// Returns the name, as in reports and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Pcf3 => "pcf3",
            Self::Fixed64 => "fixed64",
            Self::Adaptive => "adaptive",
            Self::Pcss12 => "pcss",
            Self::Pcss64 => "pcss64",
        }
    }
}

/// The remedy against surfaces that shadow themselves (shadow acne).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowBias {
    /// The maps hold the nearest surfaces, whichever side faces the light. Every sample compares
    /// with the depth of the receiver's plane at the sample, moved towards the light by the slope
    /// of a texel.
    #[default]
    Plane,
    /// The maps hold the surfaces that face away from the light. Needs closed meshes, seen from
    /// outside. An open mesh casts no shadow where its fronts face the light, and a closed mesh
    /// around a lamp does cast one.
    BackFaces,
    /// The maps hold depths halfway between the nearest front face and the nearest back face, as
    /// seen from the light, at most [`MIDPOINT_TEXELS`] behind the front face (Woo, "The Shadow
    /// Depth Map Revisited", Graphics Gems III, 1992; Weiskopf, Ertl, "Shadow Mapping Based on Dual
    /// Depth Layers", 2003). Samples are compared as with [`ShadowBias::Plane`]. So curved surfaces
    /// do not shadow themselves even under wide filters. Where the nearest surface is a back face,
    /// or has no back face behind it, the map holds the nearest surface. Takes three images instead
    /// of one, and two instead of one for resting casters. Each caster is drawn twice, and no
    /// caster is culled.
    Midpoint,
}

/// The most texels by which [`ShadowBias::Midpoint`] moves a surface away from the light. So an
/// open mesh keeps its shadow on surfaces that are farther behind it.
pub const MIDPOINT_TEXELS: f32 = 8.0;

impl ShadowBias {
    /// All remedies.
    pub const ALL: [Self; 3] = [Self::Plane, Self::BackFaces, Self::Midpoint];

    /// Returns the name, as in reports and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::BackFaces => "back_faces",
            Self::Midpoint => "midpoint",
        }
    }
}

/// The reuse of maps of earlier frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadowCaching {
    /// A face is drawn again only if it or something in it has changed.
    #[default]
    Cached,
    /// Every face is drawn in every frame.
    Uncached,
}

/// The choice of casters for maps that are not kept yet, and for volumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CasterCulling {
    /// Maps that are not kept hold only casters whose shadow can fall on something visible
    /// (Bittner, Mattausch, Silvennoinen, Wimmer, "Shadow Caster Culling for Efficient Shadow
    /// Mapping", I3D 2011), and only volumes of these casters are counted. Maps that are kept for
    /// later views hold all of their casters. Needs frames of one view with one sample per pixel.
    #[default]
    Culled,
    /// All casters in a map's view are drawn, and all volumes are counted.
    Unculled,
}

/// The most cascades of a directional light.
pub const MAX_CASCADES: u32 = 8;

/// The least side of a tile in texels.
pub const MIN_SIDE: u32 = 16;

/// The options of shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowOptions {
    /// The way in which shadows are drawn.
    pub method: ShadowMethod,
    /// The filter of shadow maps.
    pub filter: ShadowFilter,
    /// The remedy against surfaces that shadow themselves.
    pub bias: ShadowBias,
    /// The reuse of maps of earlier frames.
    pub caching: ShadowCaching,
    /// The choice of casters.
    pub culling: CasterCulling,
    /// The width of penumbras in metres, at least 0, for lights without a width of their own.
    pub penumbra_m: f32,
    /// The number of maps of a directional light, 1 to [`MAX_CASCADES`]: each reaches three times
    /// as far as the previous one.
    pub cascades: u32,
    /// The width of the band in which a cascade blends into the next one, and the last one into
    /// full light, as a share of half its side: 0 to 0.5. At 0 the sharpness changes visibly from
    /// one pixel to the next. Pixels in the band sample two maps.
    pub cascade_blend: f32,
    /// The distance from the eye up to which directional lights have shadows, in metres. `None`
    /// computes the distance from the scene of the first frame with these options. It is 200, or
    /// more where objects are larger than houses, as in a scene in another unit.
    pub distance_m: Option<f32>,
    /// The side of a directional light's maps in texels: a power of two from [`MIN_SIDE`] on, like
    /// the next two sides.
    pub sun_side: u32,
    /// The side of a spot light's map in texels.
    pub spot_side: u32,
    /// The side of each of a point light's six maps in texels.
    pub point_side: u32,
    /// The most layers of maps, each as large as the largest map. Lights that do not fit get
    /// smaller maps, at last none. Layers of resting casters take the same number again.
    /// [`ShadowBias::Midpoint`] takes three times the number, or five times with resting casters.
    /// With volumes, this is the most layers of a mask as large as the image. Each layer of the
    /// mask holds [`MASK_LIGHTS`](crate::MASK_LIGHTS) of the lights that a view shows.
    pub layers_max: u32,
}

impl Default for ShadowOptions {
    /// Returns options without shadows. With a method set, they give four cascades of 2048 texels
    /// and at most 128 MiB of maps, twice that while some casters move and others rest.
    fn default() -> Self {
        Self {
            method: ShadowMethod::Off,
            filter: ShadowFilter::default(),
            bias: ShadowBias::default(),
            caching: ShadowCaching::default(),
            culling: CasterCulling::default(),
            penumbra_m: 0.15,
            cascades: 4,
            cascade_blend: 0.1,
            distance_m: None,
            sun_side: 2048,
            spot_side: 512,
            point_side: 256,
            layers_max: 8,
        }
    }
}

/// An option that no device can fulfil.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShadowOptionsError {
    /// A number of cascades out of range.
    #[error("a sun with {cascades} cascades is impossible: it has 1 to {MAX_CASCADES}")]
    Cascades {
        /// The requested number.
        cascades: u32,
    },
    /// A blend band that is not a share of 0 to 0.5.
    #[error("cascades that blend over {blend} of half their side are impossible: give 0 to 0.5")]
    CascadeBlend {
        /// The requested share.
        blend: f32,
    },
    /// A distance at which cascades have no size.
    #[error(
        "cascades that reach {distance_m} m have no size: give a distance above 0 and below 1e6 m"
    )]
    Distance {
        /// The requested distance.
        distance_m: f32,
    },
    /// A width of penumbras that is out of range.
    #[error("penumbras of {penumbra_m} m are impossible: give a width from 0 to below 1e3 m")]
    Penumbra {
        /// The requested width.
        penumbra_m: f32,
    },
    /// A side of a map that is not a power of two, or is too small.
    #[error("a shadow map of {side} texels is impossible: give a power of two from {MIN_SIDE} on")]
    Side {
        /// The requested side.
        side: u32,
    },
    /// No layers.
    #[error("shadow maps need at least one layer: raise `layers_max`")]
    NoLayer,
}

impl ShadowOptions {
    /// Returns the side of a layer, which is the side of the largest map.
    #[must_use]
    pub fn layer_side(&self) -> u32 {
        self.sun_side.max(self.spot_side).max(self.point_side)
    }

    /// Returns true if casters may be left out if their shadow falls on nothing visible. This is
    /// not so for maps of [`ShadowBias::Midpoint`]: the back of such a caster may determine a
    /// midpoint.
    #[must_use]
    pub fn may_cull_casters(&self) -> bool {
        let has_midpoints = self.method == ShadowMethod::Maps && self.bias == ShadowBias::Midpoint;
        self.culling == CasterCulling::Culled && !has_midpoints
    }

    /// Checks that a device can fulfil the options.
    ///
    /// # Errors
    /// The first impossible option.
    pub fn check(&self) -> Result<(), ShadowOptionsError> {
        if !(1..=MAX_CASCADES).contains(&self.cascades) {
            return Err(ShadowOptionsError::Cascades { cascades: self.cascades });
        }
        if !(0.0..=0.5).contains(&self.cascade_blend) {
            return Err(ShadowOptionsError::CascadeBlend { blend: self.cascade_blend });
        }
        let is_distance = |distance_m: &f32| *distance_m > 0.0 && *distance_m < 1.0e6;
        if let Some(distance_m) = self.distance_m.filter(|distance_m| !is_distance(distance_m)) {
            return Err(ShadowOptionsError::Distance { distance_m });
        }
        if !(0.0..1.0e3).contains(&self.penumbra_m) {
            return Err(ShadowOptionsError::Penumbra { penumbra_m: self.penumbra_m });
        }
        let is_possible = |side: &u32| side.is_power_of_two() && *side >= MIN_SIDE;
        let mut sides = [self.sun_side, self.spot_side, self.point_side].into_iter();
        if let Some(side) = sides.find(|side| !is_possible(side)) {
            return Err(ShadowOptionsError::Side { side });
        }
        if self.layers_max == 0 { Err(ShadowOptionsError::NoLayer) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn midpoints_alone_are_made_of_all_casters() {
        for bias in ShadowBias::ALL {
            for method in ShadowMethod::ALL {
                let options = ShadowOptions { bias, method, ..ShadowOptions::default() };
                let has_midpoints = (method, bias) == (ShadowMethod::Maps, ShadowBias::Midpoint);
                assert_eq!(options.may_cull_casters(), !has_midpoints, "{options:?}");
                let all = ShadowOptions { culling: CasterCulling::Unculled, ..options };
                assert!(!all.may_cull_casters());
            }
        }
    }

    #[test]
    fn impossible_options_are_named() {
        let options = ShadowOptions::default();
        assert_eq!(options.check(), Ok(()));
        for cascades in [0, MAX_CASCADES + 1] {
            let refused = ShadowOptions { cascades, ..options }.check();
            assert_eq!(refused, Err(ShadowOptionsError::Cascades { cascades }));
        }
        for cascade_blend in [-0.1, 0.51, f32::NAN, f32::INFINITY] {
            let refused = ShadowOptions { cascade_blend, ..options }.check();
            assert!(refused.unwrap_err().to_string().contains("0 to 0.5"), "{cascade_blend}");
        }
        for distance_m in [0.0, -1.0, f32::INFINITY, f32::NAN] {
            let refused = ShadowOptions { distance_m: Some(distance_m), ..options }.check();
            assert!(refused.is_err(), "{distance_m}");
        }
        for penumbra_m in [-0.1, 1.0e3, f32::NAN] {
            assert!(ShadowOptions { penumbra_m, ..options }.check().is_err(), "{penumbra_m}");
        }
        for side in [0, 8, 1000, u32::MAX] {
            for options in [
                ShadowOptions { sun_side: side, ..options },
                ShadowOptions { spot_side: side, ..options },
                ShadowOptions { point_side: side, ..options },
            ] {
                assert_eq!(options.check(), Err(ShadowOptionsError::Side { side }));
            }
        }
        let none = ShadowOptions { layers_max: 0, ..options };
        assert_eq!(none.check(), Err(ShadowOptionsError::NoLayer));
    }
}

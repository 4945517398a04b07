//! The options of `walkthrough` for section planes.

use antumbra::cull::{SectionMode, SectionPlane, SectionPlanes};
use antumbra::glam::DVec3;
use clap::Args;

use crate::options::UsageError;

/// Section planes, as the command line has them.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct SectionArguments {
    /// Up to six section planes: each keeps the points x, y, z (metres) with X*x + Y*y + Z*z + D at
    /// least 0, and cuts the rest away. Large meshes of a file stay whole, as with --whole-meshes,
    /// since pieces have no caps [default: none]
    #[arg(long, value_name = "X,Y,Z,D[;...]", help_heading = "Scene", allow_hyphen_values = true)]
    #[arg(value_parser = parse_planes)]
    pub section: Option<PlaneList>,
    /// The part that several planes keep: intersection, of all; union, of any one of them
    /// [default: intersection]
    #[arg(long, value_name = "MODE", help_heading = "Scene", requires = "section")]
    #[arg(value_parser = parse_mode)]
    pub section_mode: Option<SectionMode>,
}

/// Section planes, separated by semicolons.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneList(pub Vec<SectionPlane>);

impl SectionArguments {
    /// Returns the planes.
    ///
    /// # Errors
    /// More planes than are possible.
    pub fn planes(&self) -> Result<SectionPlanes, UsageError> {
        let planes = self.section.as_ref().map_or(&[][..], |list| &list.0);
        SectionPlanes::new(planes, self.section_mode.unwrap_or_default())
            .map_err(|error| UsageError(format!("--section: {error}")))
    }
}

/// Parses planes `X,Y,Z,D`, separated by semicolons.
///
/// # Errors
/// A sentence about the first invalid plane.
pub fn parse_planes(text: &str) -> Result<PlaneList, String> {
    text.split(';').map(parse_plane).collect::<Result<_, _>>().map(PlaneList)
}

fn parse_plane(text: &str) -> Result<SectionPlane, String> {
    let number = |part: &str| {
        let part = part.trim();
        part.parse::<f64>().map_err(|_| format!("'{part}' in '{text}' is not a number"))
    };
    let numbers = text.split(',').map(number).collect::<Result<Vec<f64>, String>>()?;
    let [x, y, z, offset_m] = numbers[..] else {
        return Err(format!("'{text}' is not a plane: that is four numbers, X,Y,Z,D"));
    };
    SectionPlane::new(DVec3::new(x, y, z), offset_m).map_err(|error| format!("'{text}': {error}"))
}

fn parse_mode(text: &str) -> Result<SectionMode, String> {
    match text {
        "intersection" => Ok(SectionMode::Intersection),
        "union" => Ok(SectionMode::Union),
        _ => Err(format!("unknown mode '{text}': say intersection or union")),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::Arguments;
    use crate::report::SectionReport;

    fn planes(line: &[&str]) -> Result<SectionPlanes, String> {
        let line = std::iter::once("walkthrough").chain(line.iter().copied());
        let arguments = Arguments::try_parse_from(line).map_err(|error| error.to_string())?;
        arguments.section.planes().map_err(|error| error.0)
    }

    #[test]
    fn planes_are_four_numbers_each() {
        assert!(planes(&[]).unwrap().is_empty());
        let two = planes(&["--section", "-1,0,0,5; 0,2,0,-4", "--section-mode", "union"]).unwrap();
        assert_eq!((two.planes().len(), two.mode()), (2, SectionMode::Union));
        assert_eq!(two.planes()[0].normal(), DVec3::NEG_X);
        assert_eq!(two.planes()[1].offset_m(), -2.0);
        let report = SectionReport::of(&two).unwrap();
        assert_eq!(report.planes, [[-1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, -2.0]]);
        assert_eq!(
            (report.mode.as_str(), SectionReport::of(&planes(&[]).unwrap())),
            ("union", None)
        );
    }

    #[test]
    fn what_is_no_plane_gets_a_sentence() {
        let seven = ["1,0,0,0"; 7].join(";");
        for (text, says) in [
            ("0,0,0,1", "needs a normal"),
            ("NaN,0,0,1", "needs a normal"),
            ("1,0,0,inf", "finite number"),
            ("1,0,0", "four numbers"),
            ("1,0,0,x", "'x' in '1,0,0,x' is not a number"),
            (&seven, "7 section planes: there may be up to 6"),
        ] {
            let error = planes(&["--section", text]).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
        let error = planes(&["--section", "1,0,0,0", "--section-mode", "xor"]).unwrap_err();
        assert!(error.contains("intersection or union"), "{error}");
        assert!(planes(&["--section-mode", "union"]).is_err());
    }
}

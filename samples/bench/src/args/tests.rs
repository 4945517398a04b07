//! Tests of the command line: defaults, every option, every refusal.

use super::*;
use crate::choices::{
    CameraPathChoice, CostModelChoice, EdgesChoice, PredicatesChoice, ProjectionChoice,
    QuirksChoice, ValidationChoice,
};
use crate::strategy::Strategy;
use antumbra::cull::SectionPlanes;
use antumbra::import::BrokenParts;
use antumbra::methods;
use clap::CommandFactory;
use proptest::collection::vec as any_vec;
use proptest::{prop_assert, proptest};
use std::num::NonZeroU32;

fn parse(line: &[&str]) -> Result<Options, String> {
    let parsed = Arguments::try_parse_from([&["walkthrough"], line].concat());
    parsed.map_err(|error| error.to_string())?.options().map_err(|error| error.to_string())
}

fn refusal(line: &[&str]) -> String {
    parse(line).unwrap_err()
}

#[test]
fn the_declaration_is_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn help_says_what_the_program_does() {
    let help = Arguments::command().render_long_help().to_string().replace('\n', " ");
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "the streets of a city: plain frustum culling, ours, the ideal.",
        "from above nothing hides anything",
    ] {
        assert!(help.contains(words), "{help}");
    }
    assert!(!help.contains("all strategies."), "the default is three");
}

#[test]
fn without_arguments_it_is_a_street_walk_against_both_bounds() {
    let options = parse(&[]).unwrap();
    let city = MadeScene { scene: GeneratorChoice::City, objects: 10_000, seed: 1 };
    assert_eq!(options.scene, SceneChoice::Made(city));
    assert_eq!(options.path, PathChoice::Made(CameraPathChoice::Street));
    assert_eq!(options.asked.size, FrameSize { width: 1280, height: 720 });
    assert_eq!(options.strategies, [Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::IDEAL]);
    assert_eq!(options.asked.verify, Verify::Off);
    assert_eq!(options.asked.frames_in_flight, 2);
    assert_eq!((options.asked.views, options.asked.moving_percent), (1, 0));
    assert_eq!(options.asked.threshold, 0);
    assert_eq!(options.asked.device.choice(), DeviceChoice::Best);
    assert_eq!((options.images, options.top_down), (0, None));
    assert_eq!(
        (options.asked.out, options.asked.report, options.asked.device.shaders),
        (None, None, None)
    );
}

#[test]
fn every_option_arrives() {
    let options = parse(&[
        "--scene=field",
        "--objects=33554432",
        "--seed=18446744073709551615",
        "--path=cut",
        "--views=2",
        "--projection=jittered",
        "--edges=hidden",
        "--transparency=fragments",
        "--moving-percent=30",
        "--frames=7",
        "--size=64X32",
        "--strategy=antumbra, frustum",
        "--verify=3",
        "--frames-in-flight=4",
        "--device=llvmpipe",
        "--validation=sync",
        "--predicates=instances",
        "--threshold=9",
        "--shaders=glsl",
        "--out=images",
        "--report=r.json",
        "--images=7",
        "--msaa=4",
        "--top-down=6",
        "--depth-complexity",
    ])
    .unwrap();
    let field = MadeScene { scene: GeneratorChoice::Field, objects: 33_554_432, seed: u64::MAX };
    assert_eq!(options.scene, SceneChoice::Made(field));
    assert_eq!(options.path, PathChoice::Made(CameraPathChoice::Cut));
    assert_eq!(options.strategies, [Strategy::ANTUMBRA, Strategy::FRUSTUM]);
    assert_eq!((options.cost_model, options.left_out), (CostModelChoice::Measured, vec![]));
    assert_eq!((options.shadows, options.section), (vec![], SectionPlanes::default()));
    assert_eq!((options.images, options.top_down), (7, Some(6)));
    assert_eq!(options.cut_above_triangles, None);
    let asked = options.asked;
    assert_eq!((asked.views, asked.moving_percent, asked.frames), (2, 30, 7));
    assert_eq!((asked.projection, asked.edges), (ProjectionChoice::Jittered, EdgesChoice::Hidden));
    assert_eq!(asked.transparency, TransparencyChoice::Fragments);
    assert_eq!(asked.size, FrameSize { width: 64, height: 32 });
    assert_eq!((asked.msaa, asked.frames_in_flight), (SampleCount::Four, 4));
    assert_eq!(asked.verify, Verify::EveryNth(NonZeroU32::new(3).unwrap()));
    assert_eq!((asked.predicates, asked.threshold), (PredicatesChoice::Instances, 9));
    assert_eq!(asked.device.choice(), DeviceChoice::Name("llvmpipe".into()));
    assert_eq!(asked.device.validation, ValidationChoice::Sync);
    assert_eq!(asked.device.shaders, Some("glsl".into()));
    assert_eq!((asked.out, asked.report), (Some("images".into()), Some("r.json".into())));
    assert!(asked.depth_complexity && !asked.time_passes && !asked.file.strict);
    assert_eq!(parse(&["--device", "1"]).unwrap().asked.device.choice(), DeviceChoice::Index(1));
    assert_eq!(
        parse(&["--verify", "every"]).unwrap().asked.verify,
        Verify::EveryNth(NonZeroU32::MIN)
    );
}

#[test]
fn of_an_option_said_twice_the_last_counts() {
    for (option, first, last) in [
        ("--scene", "field", "a.glb"),
        ("--objects", "1", "2"),
        ("--seed", "1", "2"),
        ("--path", "fly", "cut"),
        ("--views", "1", "2"),
        ("--projection", "jittered", "orthographic"),
        ("--moving-percent", "1", "2"),
        ("--frames", "1", "2"),
        ("--size", "1x1", "2x2"),
        ("--strategy", "frustum", "antumbra,ideal"),
        ("--verify", "off", "3"),
        ("--msaa", "1", "4"),
        ("--frames-in-flight", "1", "3"),
        ("--predicates", "auto", "count"),
        ("--threshold", "0", "4"),
        ("--cost-model", "off", "measured"),
        ("--device", "0", "llvmpipe"),
        ("--validation", "on", "sync"),
        ("--shaders", "a", "b"),
        ("--out", "a", "b"),
        ("--images", "1", "2"),
        ("--top-down", "1", "off"),
        ("--report", "a", "b"),
    ] {
        let out = if option == "--out" { vec![] } else { vec!["--out", "o"] };
        let twice = parse(&[&out[..], &[option, first, option, last]].concat());
        let once = parse(&[&out[..], &[option, last]].concat());
        assert_eq!((twice.as_ref(), twice.is_ok()), (once.as_ref(), true), "{option}");
    }
    for flag in ["--quiet", "--time-passes", "--list-devices", "--list-strategies"] {
        assert!(parse(&[flag, flag]).is_ok(), "{flag}");
    }
}

#[test]
fn numbers_outside_their_range_are_refused() {
    for (option, values) in [
        ("--objects", ["0", "33554433", "-5", "many", "", "1e6"]),
        ("--views", ["0", "3", "-1", "two", "", "1.0"]),
        ("--moving-percent", ["101", "-1", "ten", "5%", "", "1.5"]),
        ("--threshold", ["-1", "4294967296", "few", "", "1.5", "2px"]),
        ("--frames", ["0", "1000001", "-1", "1.5", " 3", "4294967296"]),
        ("--frames-in-flight", ["0", "5", "-1", "two", "", "99999999999"]),
        ("--msaa", ["0", "2", "8", "-4", "", "four"]),
        ("--seed", ["-1", "18446744073709551616", "abc", "", "0x10", "1.0"]),
    ] {
        for value in values {
            let message = refusal(&[option, value]);
            let named = message.starts_with("error: ") && message.contains(&format!("{option} <"));
            assert!(named && message.contains(&format!("'{value}'")), "{message}");
        }
    }
    assert!(refusal(&["--objects", "0"]).contains("0 is not in 1..=33554432"));
}

#[test]
fn sizes_that_are_none_are_refused() {
    for size in ["0x720", "1280x0", "1280", "x", "", "-1x5", "1280x720x3", "axb", "99999999999x1"] {
        let message = refusal(&[&format!("--size={size}")]);
        assert!(message.contains("such as 1280x720"), "{message}");
    }
}

#[test]
fn every_eye_needs_a_column() {
    assert!(refusal(&["--views=2", "--size=1x9"]).contains("--size 1x9 is too narrow"));
    assert_eq!(parse(&["--views=2", "--size=2x9"]).unwrap().asked.views, 2);
}

#[test]
fn unknown_names_are_refused_with_what_there_is() {
    assert!(
        refusal(&["--scene", "citty"])
            .contains("city, field, assembly and waffle; did you mean 'city'?")
    );
    assert!(refusal(&["--path", "steet"]).contains("did you mean 'street'?"));
    assert!(refusal(&["--strategy", "antumbra,magic"]).contains("unknown strategy 'magic'"));
    assert!(refusal(&["--strategy", ""]).contains("unknown strategy ''"));
    assert!(refusal(&["--strategy", "frustum,"]).contains("unknown strategy ''"));
    assert!(refusal(&["--validation", "yes"]).contains("[possible values: off, on, sync]"));
    assert!(
        refusal(&["--predicates", "none"])
            .contains("[possible values: auto, conditional, count, instances, compacted]")
    );
    assert!(refusal(&["--verify", "0"]).contains("above 0"));
    assert!(refusal(&["--verify", "always"]).contains("'always'"));
    assert!(refusal(&["--device", " "]).contains("--list-devices"));
}

#[test]
fn the_ideal_is_left_out_of_scenes_that_move_and_refused_by_name() {
    assert!(
        refusal(&["--strategy=frustum,ideal", "--moving-percent=10"])
            .contains("do not go together")
    );
    for arguments in [&["--moving-percent=10"][..], &["--moving-percent=10", "--strategy=all"]] {
        let options = parse(arguments).unwrap();
        assert!(!options.strategies.contains(&methods::IDEAL));
        assert_eq!(options.left_out[0].strategy, "ideal");
        assert_eq!(options.left_out.len(), 1);
    }
    assert_eq!(parse(&["--strategy=all"]).unwrap().strategies, crate::strategy::strategies());
    assert!(parse(&["--strategy=ideal"]).unwrap().left_out.is_empty());
}

#[test]
fn a_threshold_cannot_be_compared_by_conditional_rendering() {
    let both = ["--threshold=4", "--predicates=conditional"];
    assert!(refusal(&both).contains("do not go together"));
    assert!(parse(&["--threshold=0", "--predicates=conditional"]).is_ok());
    assert_eq!(parse(&["--threshold=4"]).unwrap().asked.threshold, 4);
}

#[test]
fn former_names_of_options_and_strategies_still_work() {
    let former =
        ["--costs=ignored", "--trust=driver", "--moving=10", "--strategy=coherent,pyramid"];
    let now = ["--cost-model=off", "--quirks=none", "--moving-percent=10", "--strategy=chc,hzb"];
    assert_eq!(parse(&former).unwrap(), parse(&now).unwrap());
    assert_eq!(parse(&["--trust=tested"]).unwrap().asked.quirks, QuirksChoice::Tested);
}

#[test]
fn options_that_no_strategy_heeds_are_refused() {
    let said = refusal(&["--threshold=4", "--strategy=frustum,hzb"]);
    assert!(said.contains("--threshold 4 changes nothing for --strategy frustum and hzb"));
    assert!(said.ends_with("(chc, antumbra and antumbra_queries)"), "{said}");
    let said = refusal(&["--cost-model=measured", "--strategy=chc,ideal"]);
    assert!(said.contains("--cost-model measured changes nothing for --strategy chc and ideal"));
    for line in [
        &["--threshold=4", "--strategy=frustum,chc"][..],
        &["--threshold=0", "--strategy=frustum"],
        &["--cost-model=measured", "--strategy=frustum,antumbra_flags"],
        &["--cost-model=measured", "--threshold=4"],
    ] {
        assert!(parse(line).is_ok(), "{line:?}");
    }
}

#[test]
fn a_strategy_named_twice_is_refused() {
    assert!(refusal(&["--strategy", "frustum,antumbra,frustum"]).contains("'frustum' twice"));
}

#[test]
fn what_has_a_dot_or_a_slash_is_a_file() {
    for file in ["town.glb", "TOWN.GLTF", "./city", "a/b", "town.png"] {
        let options = parse(&["--scene", file]).unwrap();
        assert_eq!(options.scene, SceneChoice::File(file.into()));
        assert_eq!(options.path, PathChoice::OfFile(None));
    }
    let options = parse(&["--scene=a.glb", "--path=Camera.001", "--moving-percent=0"]).unwrap();
    assert_eq!(options.path, PathChoice::OfFile(Some("Camera.001".to_owned())));
    assert!(options.strategies.contains(&methods::IDEAL), "it knows what moves");
    assert!(refusal(&["--path", "Camera"]).contains("cameras have names in glTF files only"));
    assert!(refusal(&["--scene", "town"]).contains("a dot or a slash"));
}

#[test]
fn what_is_for_made_scenes_is_refused_for_files() {
    for [option, value] in [["--objects", "10"], ["--seed", "1"], ["--moving-percent", "10"]] {
        let said = refusal(&["--scene=a.glb", option, value]);
        assert!(said.starts_with(&format!("{option} is for scenes that are made")), "{said}");
    }
}

#[test]
fn a_strict_reading_is_for_files() {
    let parts = |line: &[&str]| parse(line).unwrap().asked.file.broken_parts();
    assert_eq!(parts(&["--scene=a.glb"]), BrokenParts::LeaveOut);
    assert_eq!(parts(&["--scene=a.glb", "--strict"]), BrokenParts::Refuse);
    assert!(refusal(&["--strict"]).starts_with("--strict is about files"));
}

#[test]
fn images_need_a_folder_and_their_frames() {
    assert!(refusal(&["--images", "3"]).contains("--out"));
    assert!(refusal(&["--top-down", "3"]).contains("--out"));
    assert!(refusal(&["--out", "o", "--frames", "9", "--images", "10"]).contains("from 0 to 9"));
    assert!(refusal(&["--out", "o", "--frames", "9", "--top-down", "9"]).contains("from 0 to 8"));
    let options = parse(&["--out", "o", "--frames", "1"]).unwrap();
    assert_eq!((options.images, options.top_down), (1, Some(0)));
}

#[test]
fn images_are_spread_over_the_walk() {
    let options = parse(&["--out", "o", "--frames", "10", "--images", "3"]).unwrap();
    assert_eq!(options.image_frames(), [0, 3, 6]);
    let options = parse(&["--out", "o", "--frames", "4", "--images", "4"]).unwrap();
    assert_eq!(options.image_frames(), [0, 1, 2, 3]);
    assert!(parse(&[]).unwrap().image_frames().is_empty());
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(texts in any_vec(".{0,12}", 9)) {
        let options = ["scene", "objects", "size", "strategy", "verify", "path", "frames",
            "images", "top-down"];
        let said = |(option, text): (&str, &String)| format!("--{option}={text}");
        for (place, text) in options.into_iter().zip(&texts) {
            let line = [said((place, text)), "--out=o".to_owned()];
            if let Err(message) = parse(&line.each_ref().map(String::as_str)) {
                prop_assert!(!message.is_empty());
            }
        }
        let all: Vec<String> = options.into_iter().zip(&texts).map(said).collect();
        let _whatever = parse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    }
}

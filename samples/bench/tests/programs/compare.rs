//! Runs `compare` as users do: it writes a page of reports, or one sentence on failure.

use std::fs;
use std::process::{Command, Output};

use harness::{Scratch, stderr};
use serde_json::{Value, json};

use crate::walkthrough;

fn compare(scratch: &Scratch, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_compare"));
    command.current_dir(&scratch.0).args(arguments).output().expect("it starts")
}

/// Returns a report as `walkthrough` writes it, for strategies with these times in each of 24
/// frames.
fn report(path: &str, objects: u64, times_ms: &[(&str, f64)]) -> Value {
    let summary = |time: f64| json!({"median": time, "p95": time, "max": time});
    let run = |&(name, time): &(&str, f64)| {
        json!({
            "strategy": name, "frame_ms": summary(time), "frame_times_ms": vec![time; 24],
            "cpu_ms": summary(time / 20.0), "draws": 60, "tests": 480, "queries": 170, "nodes_visited": 300,
            "frames_verified": 0, "pixels_wrong": null,
        })
    };
    let mut ratios = serde_json::Map::new();
    for (a, a_ms) in times_ms {
        for (b, b_ms) in times_ms.iter().filter(|(b, _)| a != b) {
            ratios.insert(format!("{a}/{b}"), json!(a_ms / b_ms));
        }
    }
    json!({
        "device": {"name": "llvmpipe", "driver": "Mesa", "api": "1.3.230"},
        "scene": {"name": "city", "objects": objects, "triangles": 1, "seed": 1},
        "path": path, "frames": 24, "size": [1280, 720], "frames_in_flight": 2,
        "runs": times_ms.iter().map(run).collect::<Vec<_>>(),
        "ratios": ratios.clone(), "paired_ratios": ratios,
    })
}

fn write(scratch: &Scratch, name: &str, report: &Value) {
    let folder = scratch.0.join("reports");
    fs::create_dir_all(&folder).expect("the target folder is writable");
    fs::write(folder.join(name), report.to_string()).expect("the target folder is writable");
}

/// Checks that a page is well-formed, has a title, and names these strategies.
fn assert_image(svg: &str, strategies: &[&str]) {
    let document = roxmltree::Document::parse(svg).expect("well-formed");
    let texts = |tag: &str| -> Vec<String> {
        let nodes = document.descendants().filter(|node| node.tag_name().name() == tag);
        nodes.map(|node| node.text().unwrap_or_default().trim().to_owned()).collect()
    };
    assert_eq!(document.root_element().tag_name().name(), "svg");
    assert_eq!(texts("title").len(), 1);
    let names = texts("text");
    for strategy in strategies {
        assert!(names.iter().any(|name| name == strategy), "{strategy} is not among {names:?}");
    }
}

fn assert_refused(output: &Output, parts: &[&str]) {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "{message}");
    for part in parts {
        assert!(message.contains(part), "{part} is missing in {message}");
    }
}

#[test]
fn page_table_and_image_are_written() {
    let scratch = Scratch::new("compare-all");
    write(&scratch, "a.1.json", &report("street", 10_000, &[("ideal", 10.0), ("antumbra", 12.0)]));
    write(&scratch, "a.2.json", &report("street", 10_000, &[("ideal", 10.0), ("antumbra", 13.0)]));
    write(&scratch, "a.3.json", &report("street", 10_000, &[("ideal", 10.0), ("antumbra", 12.1)]));
    write(&scratch, "tie.json", &report("street", 10_000, &[("frustum", 130.0), ("ideal", 10.0)]));
    fs::write(scratch.0.join("reports/notes.txt"), "not a report").expect("writable");
    fs::write(scratch.0.join("reports/left.txt"), "x: no <y>.\nx: no <y>.\n").expect("writable");
    let outputs = ["--page", "page.html", "--table", "table.md", "--svg", "ratios.svg"];
    let notes = ["reports", "--notes", "reports/left.txt"];
    let output = compare(&scratch, &[&notes[..], &outputs].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        told.contains("antumbra takes 1.21 times") && stderr(&output).contains("wrote page.html"),
        "{told}"
    );
    assert_eq!(scratch.names("."), ["page.html", "ratios.svg", "reports", "table.md"]);

    let read = |name: &str| fs::read_to_string(scratch.0.join(name)).expect("it is there");
    let nearly = "1.21 (1.20 to 1.30)";
    let page = read("page.html");
    let table = read("table.md");
    let svg = read("ratios.svg");
    assert!(page.contains(nearly) && page.contains("≈ reached in the median, not in every run"));
    assert!(
        table.contains(&format!("| street 10k | antumbra / ideal | at most 1.22 | {nearly} |"))
    );
    assert!(page.contains("– not measured") && page.contains("a.2.json: not recorded"));
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert_eq!(
        (page.matches("x: no &lt;y&gt;.").count(), table.matches("x: no <y>.").count()),
        (1, 1)
    );
    let images = page.match_indices("<svg").zip(page.match_indices("</svg>"));
    let mut images: Vec<&str> = images.map(|((from, _), (to, _))| &page[from..to + 6]).collect();
    assert_eq!(images.len(), 4, "ratios, the path, CPU time, tests with queries and draws");
    assert!(page.contains("boxes tested") && page.contains("480"));
    images.push(&svg);
    for image in images {
        assert_image(image, &["antumbra", "ideal"]);
    }
    for strategy in ["antumbra", "ideal", "frustum"] {
        assert!(svg.lines().any(|line| line.trim() == strategy), "{strategy} is not named");
    }
}

/// Returns a PNG of one colour.
fn image(size: [u32; 2]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    let pixels = [200, 30, 60].repeat((size[0] * size[1]) as usize);
    encoder.write_header().expect("a PNG").write_image_data(&pixels).expect("all of it");
    file
}

#[test]
fn the_page_shows_what_was_walked_through_and_how_steady_the_machine_was() {
    let scratch = Scratch::new("compare-images");
    for (name, path, ideal) in
        [("a.1", "street", 10.0), ("a.2", "street", 10.2), ("b.1", "fly", 9.0)]
    {
        let times = [("ideal", ideal), ("antumbra", 1.1 * ideal)];
        write(&scratch, &format!("{name}.json"), &report(path, 10_000, &times));
    }
    for (folder, file, bytes) in [
        ("a.1", "frame_00000.png", image([1280, 720])),
        ("b.1", "frame_00000.png", b"no image".to_vec()),
    ] {
        fs::create_dir_all(scratch.0.join("images").join(folder)).expect("writable");
        fs::write(scratch.0.join("images").join(folder).join(file), bytes).expect("writable");
    }
    let output = compare(&scratch, &["reports", "--images=images", "--page=page.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("The machine was steady: the ideal's own time spreads by 2 %"), "{told}");
    let page = fs::read_to_string(scratch.0.join("page.html")).expect("it is there");
    assert_eq!(page.matches("<img ").count(), 1);
    assert!(page.contains("alt=\"street 10k\" width=\"240\" height=\"135\""), "no thumbnail");
    assert!(page.contains("src=\"data:image/png;base64,iVBORw0KGgo"), "no image in it");
    assert!(page.contains("images/b.1/frame_00000.png: "), "what is no image is named");
    // `--noisy` names the walks that were measured only once, or that differ too much.
    let noisy = compare(&scratch, &["reports", "--noisy"]);
    assert_eq!(String::from_utf8_lossy(&noisy.stdout), "b\n");
}

/// Checks that the result is printed even if files cannot be written, and that each file is tried.
#[test]
fn a_full_disk_costs_its_file_only() {
    let scratch = Scratch::new("compare-full");
    write(&scratch, "a.json", &report("street", 10_000, &[("ideal", 1.0), ("antumbra", 1.2)]));
    let outputs = ["reports", "--page", "/dev/full", "--table", "/dev/full", "--svg", "x.svg"];
    let output = compare(&scratch, &outputs);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("antumbra takes 1.20 times"));
    assert_eq!(message.matches("error: cannot write '/dev/full'").count(), 2, "{message}");
    assert!(message.contains("wrote x.svg"), "{message}");
    assert_eq!(scratch.names("."), ["reports", "x.svg"]);
}

#[test]
fn a_broken_report_is_named_and_nothing_is_written() {
    let good = report("street", 10_000, &[("ideal", 10.0), ("antumbra", 12.0)]);
    for (case, text, reason) in [
        ("cut", &good.to_string()[..200], "line 1 column"),
        ("other", "{\"name\": \"something else\"}", "no scene"),
        ("empty", "", "EOF"),
        ("binary", "\u{0}\u{1}", "expected value"),
    ] {
        let scratch = Scratch::new(&format!("compare-broken-{case}"));
        write(&scratch, "good.json", &good);
        fs::write(scratch.0.join("reports/bad.json"), text).expect("writable");
        let output = compare(&scratch, &["reports", "--page", "page.html"]);
        assert_refused(&output, &["bad.json", reason, "measure it again"]);
        assert_eq!(scratch.names("."), ["reports"]);
    }
}

#[test]
fn a_folder_without_reports_says_what_to_do() {
    let scratch = Scratch::new("compare-empty");
    fs::create_dir(scratch.0.join("reports")).expect("writable");
    assert_refused(&compare(&scratch, &["reports"]), &["no report in 'reports'", "run ci/compare"]);
    write(&scratch, "a.json", &report("fly", 10_000, &[("antumbra", 1.2)]));
    let refused = compare(&scratch, &["reports", "--notes", "none.txt"]);
    assert_refused(&refused, &["cannot read the notes 'none.txt'"]);
    assert_refused(&compare(&scratch, &["nowhere"]), &["cannot read the folder 'nowhere'"]);
}

#[test]
fn reports_of_two_devices_are_not_mixed() {
    let scratch = Scratch::new("compare-devices");
    let mut other = report("street", 10_000, &[("ideal", 1.0), ("antumbra", 1.2)]);
    write(&scratch, "one.json", &other);
    other["device"]["name"] = json!("GeForce");
    write(&scratch, "two.json", &other);
    let refused = compare(&scratch, &["reports"]);
    assert_refused(&refused, &["llvmpipe and GeForce", "a folder of its own"]);
}

#[test]
fn without_anything_to_compare_there_is_a_page_but_no_image() {
    let scratch = Scratch::new("compare-alone");
    write(&scratch, "fly.json", &report("fly", 10_000, &[("antumbra", 1.2)]));
    assert_refused(&compare(&scratch, &["reports", "--svg", "x.svg"]), &["nothing to show"]);
    let output = compare(&scratch, &["reports", "--page", "page.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn a_file_in_no_folder_is_refused_before_any_work() {
    let scratch = Scratch::new("compare-unwritable");
    for option in ["--page", "--table", "--svg", "--shadows"] {
        let refused = compare(&scratch, &["no-reports", option, "nowhere/file"]);
        assert_refused(&refused, &[option, "cannot write 'nowhere/file'", "no folder 'nowhere'"]);
    }
    assert!(scratch.names(".").is_empty());
}

#[test]
fn what_walkthrough_writes_is_read() {
    let scratch = Scratch::new("compare-walk");
    fs::create_dir(scratch.0.join("reports")).expect("writable");
    let small = ["--quiet", "--objects=200", "--frames=12", "--size=64x48", "--device=llvmpipe"];
    let more = ["--path=street", "--strategy=frustum,antumbra", "--report=reports/street.json"];
    let output = walkthrough(&scratch.0, &[&small[..], &more].concat()).output();
    let output = output.expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = compare(&scratch, &["reports", "--page", "page.html", "--svg", "ratios.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = fs::read_to_string(scratch.0.join("page.html")).expect("it is there");
    assert!(page.contains("times that of frustum"), "there is no ideal");
    assert!(page.contains("frames of 64x48") && page.contains("--objects=200"));
}

#[test]
fn shadows_have_tables_of_their_own() {
    let scratch = Scratch::new("compare-shadows");
    write(&scratch, "plain.json", &report("fly", 10_000, &[("antumbra", 1.2)]));
    let refused = compare(&scratch, &["reports", "--shadows", "shadows.md"]);
    assert_refused(&refused, &["no report has lights", "ci/compare --shadows"]);
    fs::remove_file(scratch.0.join("reports/plain.json")).expect("it was written");
    let small = ["--quiet", "--objects=200", "--frames=12", "--size=64x48", "--device=llvmpipe"];
    let lights = ["--lights=2", "--shadows=maps,maps_uncached", "--filter=pcf3,fixed64"];
    let more = ["--strategy=antumbra", "--verify=6", "--time-passes", "--report=reports/lit.json"];
    let output = walkthrough(&scratch.0, &[&small[..], &lights, &more].concat()).output();
    let output = output.expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = compare(&scratch, &["reports", "--shadows", "shadows.md"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let tables = fs::read_to_string(scratch.0.join("shadows.md")).expect("it is there");
    for title in ["## Filters", "## Cached maps", "## Number of lights"] {
        assert!(tables.contains(title), "{title} is missing in {tables}");
    }
    assert!(tables.lines().filter(|line| line.contains("| pcf3 |")).count() >= 3, "{tables}");
}

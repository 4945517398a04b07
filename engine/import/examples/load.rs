//! Measures the time and the memory of loading a scene: `load [--bare] FILE`. With `--bare`, it
//! measures `gltf::import` for comparison.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use antumbra_import as import;

/// Returns a value of `/proc/self/status` in MiB; 0 if the file does not exist.
fn memory_mib(what: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kib.unwrap_or_default() / 1024.0
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let is_bare = words.first().is_some_and(|word| word == "--bare");
    if is_bare {
        words.remove(0);
    }
    let [file] = words.as_slice() else {
        return Err("usage: load [--bare] FILE".into());
    };
    let before = memory_mib("VmRSS");
    let began = Instant::now();
    if is_bare {
        let (document, buffers, images) = gltf::import(file)?;
        report(began, before);
        println!(
            "{} nodes, {} buffers, {} images",
            document.nodes().len(),
            buffers.len(),
            images.len()
        );
        return Ok(());
    }
    let options = import::LoadOptions::default();
    let imported =
        import::load(&PathBuf::from(file), &options, &mut |_| ControlFlow::Continue(()))?;
    report(began, before);
    println!("{} objects", imported.scene.objects.len());
    Ok(())
}

fn report(began: Instant, before: f64) {
    let ms = began.elapsed().as_secs_f64() * 1e3;
    let now = memory_mib("VmRSS") - before;
    let peak = memory_mib("VmHWM") - before;
    println!("{ms:.1} ms; memory {now:.1} MiB afterwards, {peak:.1} MiB at most");
}

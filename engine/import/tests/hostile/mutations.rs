//! Tests that many small, reproducible changes of valid files never cause a panic.

use std::path::Path;
use std::time::{Duration, Instant};

use gltf_files::mutations::{SplitMix, corpus, mutant};
use gltf_files::target::try_bytes;

/// The number of tries in a test; `cargo fuzz` continues where this ends.
const TRIES: u64 = 200_000;

#[test]
fn no_change_of_a_file_makes_it_panic() {
    let corpus = corpus();
    let mut random = SplitMix(1);
    let mut accepted = 0;
    let start = Instant::now();
    for turn in 0..TRIES {
        let bytes = mutant(&corpus, &mut random);
        let began = Instant::now();
        accepted += u64::from(try_bytes(&bytes).is_ok());
        assert!(began.elapsed() < Duration::from_secs(10), "try {turn} took {:?}", began.elapsed());
    }
    eprintln!("{TRIES} tries, {accepted} accepted, {:?}", start.elapsed());
    // Both must happen often, otherwise the changes prove nothing.
    assert!((TRIES / 50..TRIES * 49 / 50).contains(&accepted), "{accepted} of {TRIES} accepted");
}

#[test]
fn random_bytes_are_refused() {
    let mut random = SplitMix(2);
    for turn in 0..4_000 {
        let length = random.below(300);
        let mut bytes: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
        if turn % 2 == 0 {
            bytes.splice(0..0, *b"glTF\x02\0\0\0");
        }
        assert!(try_bytes(&bytes).is_err());
    }
}

/// Writes the corpus: `cargo test -p antumbra-import --test hostile -- --ignored corpus`.
#[test]
#[ignore = "writes into the project"]
fn write_corpus() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/read");
    for (name, bytes) in super::accepted::seeds().into_iter().chain(super::compressed::seeds()) {
        std::fs::write(folder.join(name), bytes).expect("it can be written");
    }
}

#[test]
fn every_seed_is_accepted() {
    for (index, seed) in corpus().iter().enumerate() {
        try_bytes(seed).unwrap_or_else(|error| panic!("seed {index}: {error}"));
    }
}

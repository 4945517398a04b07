//! Watches a folder of shaders for changes.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use antumbra::pacing::Time;

/// The time between two checks.
const INTERVAL: Duration = Duration::from_millis(300);

/// A folder that is checked at intervals.
pub struct ShaderWatch {
    folder: PathBuf,
    seen: Seen,
    next_look: Time,
}

/// Values that change with the files: their number, their total size, and the newest modification.
type Seen = (usize, u64, Option<SystemTime>);

impl ShaderWatch {
    /// Watches a folder.
    pub fn new(folder: PathBuf) -> Self {
        Self { seen: look(&folder), folder, next_look: Time::ZERO }
    }

    /// Returns the folder.
    pub fn folder(&self) -> &std::path::Path {
        &self.folder
    }

    /// Returns true if the files have changed since it last returned true. Checks a few times per
    /// second.
    pub fn has_changed(&mut self, now: Time) -> bool {
        if now < self.next_look {
            return false;
        }
        self.next_look = now.after(INTERVAL);
        let seen = look(&self.folder);
        std::mem::replace(&mut self.seen, seen) != seen
    }
}

fn look(folder: &PathBuf) -> Seen {
    // A folder that cannot be read may become readable later.
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter_map(|entry| {
        let is_shader = !entry.file_name().to_string_lossy().ends_with(".spv");
        entry.metadata().ok().filter(|data| is_shader && data.is_file())
    });
    files.fold((0, 0, None), |(count, bytes, newest), data| {
        (count + 1, bytes + data.len(), newest.max(data.modified().ok()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_seen_once_and_not_too_often() {
        let folder = std::env::temp_dir().join(format!("antumbra-watch-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("a.vert"), "1").unwrap();
        let mut watch = ShaderWatch::new(folder.clone());
        let at = |ms: u64| Time::from_nanos(ms * 1_000_000);
        assert!(!watch.has_changed(at(1)));
        fs::write(folder.join("a.vert"), "22").unwrap();
        assert!(!watch.has_changed(at(100)));
        assert!(watch.has_changed(at(400)));
        assert!(!watch.has_changed(at(800)));
        fs::write(folder.join("a.vert.spv"), "compiled").unwrap();
        assert!(!watch.has_changed(at(1200)));
        fs::write(folder.join("b.frag"), "").unwrap();
        assert!(watch.has_changed(at(1600)));
        fs::remove_dir_all(&folder).unwrap();
        assert!(watch.has_changed(at(2000)));
    }
}

//! Words for messages.

/// Returns a count with the words that fit it: "1 light has" or "5 lights have".
///
/// ```
/// # use antumbra_scene as scene;
/// assert_eq!(scene::counted(1_usize, "light has", "lights have"), "1 light has");
/// assert_eq!(scene::counted(0_u64, "byte", "bytes"), "0 bytes");
/// ```
pub fn counted(count: impl TryInto<u64>, one: &str, several: &str) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    let words = if count == 1 { one } else { several };
    format!("{count} {words}")
}

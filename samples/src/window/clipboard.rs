//! The text in the desktop's clipboard.

/// Returns the newest text in the clipboard.
///
/// # Errors
/// A sentence, if there is no text or the desktop does not provide it.
pub fn text() -> Result<String, String> {
    let text = arboard::Clipboard::new().and_then(|mut clipboard| clipboard.get_text());
    text.map_err(|error| format!("nothing can be pasted: {error}; type the path"))
}

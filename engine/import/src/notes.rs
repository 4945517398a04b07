//! What is said to people about a file that is used although not all of it is understood.

/// Notes, of which a file can only cause so many.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Notes {
    texts: Vec<String>,
}

impl Notes {
    const MOST: usize = 64;

    pub(crate) fn add(&mut self, text: impl FnOnce() -> String) {
        if self.texts.len() < Self::MOST {
            self.texts.push(text());
        }
    }

    pub(crate) fn into_texts(self) -> Vec<String> {
        self.texts
    }
}

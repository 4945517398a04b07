//! Present modes: the ways in which frames follow each other on the screen, and the choice of the
//! nearest supported one.

use ash::vk;

/// The way in which a frame replaces the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PresentMode {
    /// Each frame at a refresh, in order. Every driver supports it.
    #[default]
    Fifo,
    /// Each frame at a refresh, in order, but a late frame at once; it may tear.
    FifoRelaxed,
    /// The newest frame at a refresh; older waiting frames are never shown.
    Mailbox,
    /// Each frame at once; it may tear.
    Immediate,
}

/// A requested present mode, and the mode that replaces it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fallback {
    /// The requested mode.
    pub wanted: PresentMode,
    /// The nearest mode that the surface supports.
    pub taken: PresentMode,
}

impl PresentMode {
    /// All present modes.
    pub const ALL: [PresentMode; 4] =
        [PresentMode::Fifo, PresentMode::FifoRelaxed, PresentMode::Mailbox, PresentMode::Immediate];

    /// Returns the name of the mode, as users write it.
    pub fn name(self) -> &'static str {
        match self {
            PresentMode::Fifo => "fifo",
            PresentMode::FifoRelaxed => "fifo_relaxed",
            PresentMode::Mailbox => "mailbox",
            PresentMode::Immediate => "immediate",
        }
    }

    /// Returns the mode with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// Returns this mode, or the nearest of those `offered`: a mode that does not wait for a
    /// refresh if this one does not, and a mode without tearing if this one has none. `Fifo`, which
    /// is always supported, is the last resort.
    pub fn nearest(self, offered: &[PresentMode]) -> PresentMode {
        let order: &[PresentMode] = match self {
            PresentMode::Fifo => &[],
            PresentMode::FifoRelaxed => &[PresentMode::FifoRelaxed],
            PresentMode::Mailbox => &[PresentMode::Mailbox],
            PresentMode::Immediate => &[PresentMode::Immediate, PresentMode::Mailbox],
        };
        order.iter().copied().find(|mode| offered.contains(mode)).unwrap_or(PresentMode::Fifo)
    }

    /// Returns true if each frame waits for its refresh, so that presenting may have to wait for
    /// the screen.
    pub fn is_queued(self) -> bool {
        matches!(self, PresentMode::Fifo | PresentMode::FifoRelaxed)
    }

    pub(crate) fn raw(self) -> vk::PresentModeKHR {
        match self {
            PresentMode::Fifo => vk::PresentModeKHR::FIFO,
            PresentMode::FifoRelaxed => vk::PresentModeKHR::FIFO_RELAXED,
            PresentMode::Mailbox => vk::PresentModeKHR::MAILBOX,
            PresentMode::Immediate => vk::PresentModeKHR::IMMEDIATE,
        }
    }

    pub(crate) fn from_raw(raw: vk::PresentModeKHR) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.raw() == raw)
    }
}

impl std::fmt::Display for PresentMode {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use PresentMode::{Fifo, FifoRelaxed, Immediate, Mailbox};

    #[test]
    fn what_is_offered_is_taken() {
        for mode in PresentMode::ALL {
            assert_eq!(mode.nearest(&PresentMode::ALL), mode);
            assert_eq!(mode.nearest(&[Fifo]), Fifo);
            assert_eq!(mode.nearest(&[]), Fifo);
            assert_eq!(PresentMode::from_name(mode.name()), Some(mode));
            assert_eq!(PresentMode::from_raw(mode.raw()), Some(mode));
        }
    }

    #[test]
    fn the_nearest_never_tears_where_the_wanted_does_not() {
        assert_eq!(Immediate.nearest(&[Fifo, Mailbox]), Mailbox);
        assert_eq!(Mailbox.nearest(&[Fifo, Immediate]), Fifo);
        assert_eq!(FifoRelaxed.nearest(&[Fifo, Mailbox, Immediate]), Fifo);
        assert_eq!(PresentMode::from_name("vsync"), None);
    }
}

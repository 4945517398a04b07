//! The limit of a process's address space. If the limit is too low, a loader cannot load a driver
//! and reports that there is none.

use crate::core::error::Error;

/// The address space that a driver may need for its libraries and threads. If less is free, the
/// limit is the likely cause of a failure.
const DRIVER_BYTES: u64 = 1 << 30;

/// The least free address space for a driver. With less, software drivers (lavapipe and SwiftShader
/// in 2026) fail in ways that end the process.
const LEAST_DRIVER_BYTES: u64 = 512 << 20;

/// The address space of a process that has a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct AddressSpace {
    /// The limit in bytes.
    limit_bytes: u64,
    /// The part in use.
    used_bytes: u64,
}

impl AddressSpace {
    /// Returns the address space of this process; `None` without a limit, or if the system does not
    /// report it.
    fn of_this_process() -> Option<Self> {
        let read = |file: &str| std::fs::read_to_string(file).ok();
        Self::parse(&read("/proc/self/limits")?, &read("/proc/self/status")?)
    }

    /// Reads Linux' description of a process's limits and of its status.
    fn parse(limits: &str, status: &str) -> Option<Self> {
        let first_number = |text: &str| text.split_ascii_whitespace().next()?.parse::<u64>().ok();
        let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
        let used = status.lines().find_map(|line| line.strip_prefix("VmSize:"))?;
        Some(Self {
            // "unlimited" is not a number.
            limit_bytes: first_number(limit)?,
            used_bytes: first_number(used)?.saturating_mul(1 << 10),
        })
    }

    fn room_bytes(&self) -> u64 {
        self.limit_bytes.saturating_sub(self.used_bytes)
    }

    /// Returns an error if no driver can run under the limit.
    fn check(&self) -> Result<(), Error> {
        if self.room_bytes() < LEAST_DRIVER_BYTES {
            Err(self
                .blamed(format!("they take {} MiB at the very least", LEAST_DRIVER_BYTES >> 20)))
        } else {
            Ok(())
        }
    }

    /// Returns an error of the loader, attributed to the limit if too little address space is left
    /// for a driver.
    fn explain(space: Option<Self>, error: Error) -> Error {
        match space.filter(|space| space.room_bytes() < DRIVER_BYTES) {
            Some(space) => space.blamed(error.to_string()),
            None => error,
        }
    }

    fn blamed(self, failure: String) -> Error {
        let Self { limit_bytes, used_bytes } = self;
        Error::AddressSpace { limit_bytes, used_bytes, failure }
    }
}

/// Returns an error if the limit of this process leaves too little address space for a driver.
pub(crate) fn check_room() -> Result<(), Error> {
    AddressSpace::of_this_process().map_or(Ok(()), |space| space.check())
}

/// Returns an error of the loader, attributed to the limit of this process if that is the cause.
pub(crate) fn explained(error: Error) -> Error {
    AddressSpace::explain(AddressSpace::of_this_process(), error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(soft: &str) -> String {
        format!(
            "Limit                     Soft Limit           Hard Limit           Units     \n\
             Max cpu time              unlimited            unlimited            seconds   \n\
             Max address space         {soft:<20} unlimited            bytes     \n"
        )
    }

    const STATUS: &str = "Name:\twalkthrough\nVmPeak:\t   90000 kB\nVmSize:\t   80000 kB\n";

    #[test]
    fn limits_are_read_as_linux_writes_them() {
        let space = AddressSpace::parse(&limits("204800000"), STATUS);
        let expected = AddressSpace { limit_bytes: 204_800_000, used_bytes: 80_000 << 10 };
        assert_eq!(space, Some(expected));
        assert_eq!(AddressSpace::parse(&limits("unlimited"), STATUS), None);
        assert_eq!(AddressSpace::parse("", STATUS), None);
        assert_eq!(AddressSpace::parse(&limits("204800000"), ""), None);
    }

    fn no_driver() -> Error {
        Error::NoDriver("vkCreateInstance failed with ERROR_INCOMPATIBLE_DRIVER".to_owned())
    }

    #[test]
    fn only_a_limit_without_room_for_a_driver_is_blamed() {
        let explained = |limit_bytes, used_bytes| {
            let space = Some(AddressSpace { limit_bytes, used_bytes });
            AddressSpace::explain(space, no_driver())
        };
        let blamed = explained(200 << 20, 80 << 20);
        assert!(matches!(blamed, Error::AddressSpace { .. }), "{blamed}");
        let text = blamed.to_string();
        assert!(text.contains("200 MiB") && text.contains("80 MiB"), "{text}");
        assert!(text.contains("ulimit -v") && text.contains("found no driver"), "{text}");
        assert!(matches!(explained(8 << 30, 80 << 20), Error::NoDriver(_)), "there is room");
        assert!(matches!(AddressSpace::explain(None, no_driver()), Error::NoDriver(_)));
        let checked = |limit_mib: u64| {
            let limit_bytes = limit_mib << 20;
            AddressSpace { limit_bytes, used_bytes: 80 << 20 }.check()
        };
        assert!(checked(592).is_ok(), "room for the least");
        let text = checked(591).unwrap_err().to_string();
        assert!(text.contains("591 MiB") && text.contains("512 MiB"), "{text}");
    }
}

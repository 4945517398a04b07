//! Memory of this process: its peak, from the operating system, and copies of images.

use std::fs;

use crate::run_error::RunError;

/// Returns a copy of the pixels of an image.
///
/// # Errors
/// No memory for it.
pub fn copy_of(pixels: &[u8]) -> Result<Vec<u8>, RunError> {
    let mut copy = Vec::new();
    copy.try_reserve_exact(pixels.len()).map_err(|_| {
        let mib = pixels.len() >> 20;
        RunError::machine(format!(
            "there is no memory for a copy of an image (about {mib} MiB): draw smaller ones, or end other programs"
        ))
    })?;
    copy.extend_from_slice(pixels);
    Ok(copy)
}

/// Returns the largest resident memory of this process so far, in MiB; absent where the system does
/// not report it (it is read from Linux' `/proc/self/status`, `VmHWM`).
pub fn peak_resident_mib() -> Option<f64> {
    parse_peak_mib(&fs::read_to_string("/proc/self/status").ok()?)
}

fn parse_peak_mib(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u32 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(f64::from(kib) / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_high_water_mark() {
        let status = "Name:\tx\nVmPeak:\t  9999 kB\nVmHWM:\t    2048 kB\nVmRSS:\t 1 kB\n";
        assert_eq!(parse_peak_mib(status), Some(2.0));
        assert_eq!(parse_peak_mib("VmHWM: many kB"), None);
        assert_eq!(parse_peak_mib(""), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_peak_covers_what_was_touched() {
        let block = vec![1_u8; 32 << 20];
        let peak = peak_resident_mib().unwrap();
        assert!(peak >= 32.0 && block.iter().map(|&b| u64::from(b)).sum::<u64>() == 32 << 20);
    }
}

//! Checks that large memory is available before it is used: a failed allocation would end the
//! program.

use crate::error::Reason;

/// Checks that `size_bytes` bytes can be allocated, and frees them again.
pub(crate) fn ask(size_bytes: u64) -> Result<(), Reason> {
    let asked = usize::try_from(size_bytes)
        .is_ok_and(|size_bytes| Vec::<u8>::new().try_reserve_exact(size_bytes).is_ok());
    if asked { Ok(()) } else { Err(Reason::no_memory(size_bytes)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_there_is_no_memory_for_is_refused_in_a_sentence() {
        assert_eq!(ask(1 << 20), Ok(()));
        let refused = ask(1 << 60).expect_err("so much is nowhere").of("image 3").in_file("it.glb");
        assert_eq!(
            refused.to_string(),
            "it.glb: image 3: there is no memory for the 1099511627776 MiB that it takes \
             (end other programs, or make the scene smaller)"
        );
    }
}

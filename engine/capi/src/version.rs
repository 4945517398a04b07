//! The version of the interface.

/// The version of the interface: its declarations and their meaning. It grows by one with each
/// change that breaks compiled programs. New functions, and new fields at the end of structs with a
/// `struct_size`, do not change it.
pub const ANTUMBRA_ABI_VERSION: u32 = 1;

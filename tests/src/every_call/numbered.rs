//! The macro that numbers the calls of the registry.

/// Defines the names and wrappers of calls. Their numbers are their places in the list.
macro_rules! numbered {
    ($($wrap:ident: $($pfn:ident)+;)+) => {
        #[allow(non_camel_case_types)]
        #[repr(usize)]
        enum Number {
            $($($pfn),+),+
        }

        /// The names of the functions, by number.
        pub const NAMES: &[&str] = &[$($(stringify!($pfn).split_at("PFN_".len()).1),+),+];

        pub(super) fn wrappers() -> Vec<super::state::Function> {
            use super::wrappers::{Index, $($wrap),+};
            use ash::vk;
            vec![$($($wrap(Index::<{ Number::$pfn as usize }>, None::<vk::$pfn>)),+),+]
        }
    };
}

pub(super) use numbered;

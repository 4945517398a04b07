//! Contexts, and structs of older and newer callers.

use std::ptr::{from_mut, from_ref, null, null_mut};

use antumbra_capi::api::context::*;
use antumbra_capi::api::hierarchy::*;
use antumbra_capi::context::*;
use antumbra_capi::decisions::hierarchy::*;
use antumbra_capi::error::AntumbraResult::{
    AbiVersion, BadArgument, BadPointer, BadStructSize, Ok, UnknownHandle,
};
use antumbra_capi::layout::Versioned;
use antumbra_capi::version::ANTUMBRA_ABI_VERSION;

use crate::{Host, no_error, text};

#[test]
fn contexts_are_refused_with_a_reason() {
    let mut error = no_error();
    let mut context = null_mut();
    let of_other_abi = AntumbraContextDesc {
        abi_version: ANTUMBRA_ABI_VERSION + 1,
        ..AntumbraContextDesc::current()
    };
    let loud = AntumbraContextDesc { log_level: 9, ..AntumbraContextDesc::current() };
    // SAFETY: pointers are null, or to values that live as long as the calls.
    unsafe {
        assert_eq!(antumbra_context_create(null(), &mut context, &mut error), BadPointer);
        assert_eq!(text(&error), "desc is null");
        let out = antumbra_context_create(&AntumbraContextDesc::current(), null_mut(), &mut error);
        assert_eq!((out, text(&error)), (BadPointer, "context is null"));
        let out = antumbra_context_create(&of_other_abi, &mut context, &mut error);
        assert_eq!(out, AbiVersion);
        assert!(text(&error).contains("version 2 of antumbra.h"), "{}", text(&error));
        assert_eq!(antumbra_context_create(&loud, &mut context, &mut error), BadArgument);
        assert!(context.is_null());
        // Also without a place for the message.
        assert_eq!(antumbra_context_create(null(), &mut context, null_mut()), BadPointer);

        assert_eq!(antumbra_context_destroy(null_mut(), &mut error), Ok);
        let mut other = [0_u64; 64];
        let other = from_mut(&mut other).cast::<AntumbraContext>();
        assert_eq!(antumbra_context_destroy(other, &mut error), UnknownHandle);
        let odd = other.wrapping_byte_add(1);
        assert_eq!(antumbra_context_destroy(odd, &mut error), UnknownHandle);
    }
}

#[test]
fn callers_of_other_versions_are_understood() {
    let mut host = Host::new();
    /// The struct of an older caller, without `log` and the fields after it.
    #[repr(C)]
    struct Older {
        struct_size: u32,
        abi_version: u32,
    }
    /// The struct of a newer caller, with one more field.
    #[repr(C)]
    struct Newer {
        desc: AntumbraContextDesc,
        more: u64,
    }
    let create = |struct_size: usize, more: u64, is_older: bool| {
        let mut context = null_mut();
        let mut error = no_error();
        let struct_size = struct_size as u32;
        let older = Older { struct_size, abi_version: ANTUMBRA_ABI_VERSION };
        let desc = AntumbraContextDesc { struct_size, ..AntumbraContextDesc::current() };
        let newer = Newer { desc, more };
        let desc = if is_older { from_ref(&older).cast() } else { from_ref(&newer).cast() };
        // SAFETY: the struct has as many bytes as it says, or is refused before they are read.
        unsafe {
            let result = antumbra_context_create(desc, &mut context, &mut error);
            antumbra_context_destroy(context, null_mut());
            (result, text(&error).to_owned())
        }
    };
    let ours = size_of::<AntumbraContextDesc>();
    let newer = size_of::<Newer>();
    assert_eq!(create(size_of::<Older>(), 0, true).0, Ok);
    assert_eq!(create(ours, 1, false).0, Ok, "what lies behind is not ours");
    assert_eq!(create(newer, 0, false).0, Ok);
    let (refused, reason) = create(newer, 1, false);
    assert_eq!(refused, BadStructSize);
    assert!(
        reason.contains(&format!("AntumbraContextDesc) has a field at byte {ours}")),
        "{reason}"
    );
    // Sizes that end within a field or before the last required one, and sizes that were never set.
    for size in [0, 1, 4, 7, 10, ours - 1, 5000, u32::MAX as usize] {
        let (refused, reason) = create(size, 0, false);
        assert_eq!(refused, BadStructSize, "{size}");
        assert!(reason.contains("sizeof(AntumbraContextDesc)"), "{reason}");
    }

    // In a struct for output, only the fields that the caller has are written.
    #[repr(C)]
    struct NewerLeaves {
        leaves: AntumbraLeaves,
        more: u64,
        behind: u64,
    }
    let size = size_of::<AntumbraLeaves>() + 8;
    let leaves = AntumbraLeaves { struct_size: size as u32, ..Versioned::INIT };
    let mut output = NewerLeaves { leaves, more: 1, behind: 1 };
    let pointer = from_mut(&mut output).cast::<AntumbraLeaves>();
    // SAFETY: the struct has as many bytes as it says.
    let listed = unsafe {
        antumbra_hierarchy_leaves(host.context, host.hierarchy, pointer, &mut host.error)
    };
    assert_eq!((listed, output.leaves.struct_size), (Ok, size as u32));
    assert_eq!((output.leaves.count, output.more, output.behind), (2, 0, 1));
}

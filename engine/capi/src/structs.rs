//! The list of all structs.

use crate::context::AntumbraContextDesc;
use crate::decisions::culler::{AntumbraCuller, AntumbraCullerDesc, AntumbraPlanDesc};
use crate::decisions::hierarchy::{
    AntumbraAabb, AntumbraHierarchy, AntumbraHierarchyDesc, AntumbraLeaves,
};
use crate::decisions::plan::{
    AntumbraAnswer, AntumbraDraw, AntumbraFramePlan, AntumbraQueryTag, AntumbraRound, AntumbraTest,
};
use crate::decisions::view::AntumbraViewDesc;
use crate::error::AntumbraError;
use crate::layout::StructLayout;

/// All structs of the interface, for comparison with a C compiler.
pub const STRUCTS: &[StructLayout] = &[
    StructLayout::of::<AntumbraContextDesc>(),
    StructLayout::of::<AntumbraCuller>(),
    StructLayout::of::<AntumbraCullerDesc>(),
    StructLayout::of::<AntumbraPlanDesc>(),
    StructLayout::of::<AntumbraError>(),
    StructLayout::of::<AntumbraAabb>(),
    StructLayout::of::<AntumbraHierarchy>(),
    StructLayout::of::<AntumbraHierarchyDesc>(),
    StructLayout::of::<AntumbraLeaves>(),
    StructLayout::of::<AntumbraAnswer>(),
    StructLayout::of::<AntumbraDraw>(),
    StructLayout::of::<AntumbraFramePlan>(),
    StructLayout::of::<AntumbraQueryTag>(),
    StructLayout::of::<AntumbraRound>(),
    StructLayout::of::<AntumbraTest>(),
    StructLayout::of::<AntumbraViewDesc>(),
];

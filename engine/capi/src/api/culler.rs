//! Functions of cullers.

use crate::context::{AntumbraContext, entry};
use crate::decisions::culler::{
    AntumbraCuller, AntumbraCullerDesc, AntumbraPlanDesc, ViewCuller, queries, strategy,
};
use crate::decisions::hierarchy::AntumbraHierarchy;
use crate::decisions::plan::{AntumbraAnswer, AntumbraFramePlan};
use crate::error::{AntumbraError, AntumbraResult};
use crate::pointers::{Output, check_output, read, slice};

/// Creates a culler without a history.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_culler_create(
    context: *const AntumbraContext,
    desc: *const AntumbraCullerDesc,
    culler: *mut AntumbraCuller,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            check_output("culler", culler)?;
            let desc = read("desc", desc)?;
            *culler = context.cullers.insert(ViewCuller::new(&desc)?)?;
            Ok(())
        })
    }
}

/// Destroys a culler. A handle of 0 is not an error.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_culler_destroy(
    context: *const AntumbraContext,
    culler: AntumbraCuller,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe { entry(context, error, |context| context.cullers.destroy(culler)) }
}

/// Clears the history of a culler, after a change that makes the history worthless.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_culler_reset(
    context: *const AntumbraContext,
    culler: AntumbraCuller,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            context.cullers.find(culler)?.write()?.reset();
            Ok(())
        })
    }
}

/// Takes answers to queries of earlier plans. Answers may come in any order, late, twice, or never;
/// outdated answers are ignored. If an answer is invalid, no answer is taken.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_culler_ingest(
    context: *const AntumbraContext,
    culler: AntumbraCuller,
    hierarchy: AntumbraHierarchy,
    answers: *const AntumbraAnswer,
    count: usize,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let answers = slice("answers", answers, count)?;
            let culler = context.cullers.find(culler)?;
            let hierarchy = context.hierarchies.find(hierarchy)?;
            let hierarchy = hierarchy.read()?;
            culler.write()?.ingest(&hierarchy.hierarchy, answers)
        })
    }
}

/// Plans the next frame.
///
/// # Safety
/// The rules of the interface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn antumbra_culler_plan(
    context: *const AntumbraContext,
    culler: AntumbraCuller,
    hierarchy: AntumbraHierarchy,
    desc: *const AntumbraPlanDesc,
    plan: *mut AntumbraFramePlan,
    error: *mut AntumbraError,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        entry(context, error, |context| {
            let output = Output::new("plan", plan)?;
            let desc = read("desc", desc)?;
            let view = read("desc.camera", desc.camera)?.view()?;
            let strategy = strategy(desc.strategy)?;
            let culler = context.cullers.find(culler)?;
            let hierarchy = context.hierarchies.find(hierarchy)?;
            let mut culler = culler.write()?;
            let hierarchy = hierarchy.read()?;
            let budget = queries(desc.query_budget);
            let plan = culler.plan(&hierarchy.hierarchy, strategy, &view, budget);
            output.write(&plan);
            Ok(())
        })
    }
}

//! The plan of faults, and what happened since it was installed.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Mutex, PoisonError};

use ash::vk;
use ash::vk::Handle;

use super::calls::NAMES;
use super::codes::{INVENTED, codes_of};
use super::live::{LiveObjects, NAMING};
use crate::window_fixture::Random;

/// The number of a call in [`NAMES`].
pub type CallNumber = usize;

pub(super) type Function = unsafe extern "system" fn();

/// The time for which a fault lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lasts {
    /// One call.
    Once,
    /// All later calls of the function; of a lost device, all its calls that can report the loss.
    Forever,
}

/// A call that fails.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// The function.
    pub call: CallNumber,
    /// The number of the call of the function, from 0.
    pub nth: usize,
    /// The code that it returns.
    pub code: vk::Result,
    /// The time for which it fails.
    pub lasts: Lasts,
}

/// A second fault, in the clean-up or recovery after the first.
#[derive(Clone, Copy, Debug)]
pub struct NextFault {
    /// The number of calls between the first fault and this one, without those that name objects.
    pub after: usize,
    /// The choice among the codes of the function that is called then.
    pub seed: u64,
}

/// The faults of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaultPlan {
    /// The first fault.
    pub first: Option<Fault>,
    /// The second fault.
    pub second: Option<NextFault>,
}

impl FaultPlan {
    /// Returns true if the only fault is that the device is lost.
    pub fn is_one_loss(&self) -> bool {
        let is_loss = |fault: Fault| fault.code == vk::Result::ERROR_DEVICE_LOST;
        self.first.is_some_and(is_loss) && self.second.is_none()
    }
}

#[derive(Default)]
pub(super) struct State {
    plan: FaultPlan,
    counts: HashMap<CallNumber, usize>,
    has_failed: bool,
    /// The number of calls since the first fault that can be the second one.
    pub(super) calls_after: usize,
    pub(super) second_fired: bool,
    /// The device that the first fault has lost, until it is destroyed.
    lost: Option<vk::Device>,
    pub(super) trace: Vec<CallNumber>,
    pub(super) fired: Vec<(CallNumber, vk::Result)>,
    pub(super) asked: BTreeSet<String>,
    pub(super) real: Vec<Option<Function>>,
    pub(super) others: HashMap<&'static str, Function>,
    pub(super) devices: Vec<vk::Device>,
    /// The devices of queues, by their handles.
    pub(super) queues: HashMap<u64, vk::Device>,
    pub(super) live: LiveObjects,
    /// The objects that are alive and have no debug name yet, with their types.
    pub(super) unnamed: HashMap<u64, &'static str>,
    /// The objects that were destroyed without a debug name.
    pub(super) never_named: LiveObjects,
}

impl State {
    pub(super) fn install(&mut self, plan: FaultPlan) {
        self.plan = plan;
        self.counts = HashMap::new();
        self.has_failed = false;
        self.calls_after = 0;
        self.second_fired = false;
        self.lost = None;
        self.trace = Vec::new();
        self.fired = Vec::new();
    }

    pub(super) fn stop(&mut self) {
        self.plan = FaultPlan::default();
    }

    /// Notes the end of a device, whose handle another one may have later.
    pub(super) fn note_device_destroyed(&mut self, device: vk::Device) {
        self.devices.retain(|other| *other != device);
        self.queues.retain(|_, of| *of != device);
        self.lost = self.lost.filter(|lost| *lost != device);
    }

    /// Returns the device of a call with this first argument.
    fn device_of(&self, call: CallNumber, first: u64) -> Option<vk::Device> {
        let itself = self.devices.iter().find(|device| device.as_raw() == first);
        let of_queue = || self.queues.get(&first);
        // A host has asked for its queue itself, and has one device.
        let of_host = || self.devices.last().filter(|_| NAMES[call].starts_with("vkQueue"));
        itself.or_else(of_queue).or_else(of_host).copied()
    }

    /// Counts a call with this first argument, and returns its code if it must fail.
    pub(super) fn due(&mut self, call: CallNumber, first: u64) -> Option<vk::Result> {
        let count = self.counts.entry(call).or_default();
        let nth = *count;
        *count += 1;
        self.trace.push(call);
        let can_be_second = self.has_failed && call_matters(call);
        let device = self.device_of(call, first);
        let first = self.first(call, nth, device);
        let code = first.or_else(|| if can_be_second { self.second(call) } else { None });
        self.calls_after += usize::from(can_be_second);
        self.second_fired |= first.is_none() && code.is_some();
        self.has_failed |= code.is_some();
        self.fired.extend(code.map(|code| (call, code)));
        code
    }

    fn first(
        &mut self,
        call: CallNumber,
        nth: usize,
        device: Option<vk::Device>,
    ) -> Option<vk::Result> {
        let Fault { call: wanted, nth: from, code, lasts } = self.plan.first?;
        let is_here = call == wanted && nth == from;
        let is_later = lasts == Lasts::Forever
            && self.has_failed
            && if code == vk::Result::ERROR_DEVICE_LOST {
                self.lost.is_some() && device == self.lost && codes_of(call).contains(&code)
            } else {
                call == wanted
            };
        if is_here && code == vk::Result::ERROR_DEVICE_LOST {
            self.lost = device;
        }
        (is_here || is_later).then_some(code)
    }

    fn second(&self, call: CallNumber) -> Option<vk::Result> {
        let NextFault { after, seed } = self.plan.second?;
        if self.calls_after != after {
            return None;
        }
        let codes = codes_of(call);
        let choice = Random::new(seed).below(codes.len() as u32 + 1) as usize;
        Some(codes.get(choice).copied().unwrap_or(INVENTED))
    }
}

/// Returns true if a program can notice that the call fails. The engine goes on without debug
/// names.
pub fn call_matters(call: CallNumber) -> bool {
    NAMES[call] != NAMING
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

pub(super) fn with_state<R>(use_it: impl FnOnce(&mut State) -> R) -> R {
    let mut state = STATE.lock().unwrap_or_else(PoisonError::into_inner);
    use_it(state.get_or_insert_with(|| State { real: vec![None; NAMES.len()], ..State::default() }))
}

/// Returns the real function of a call.
///
/// # Safety
/// `F` is the type of the function.
pub(super) unsafe fn real<F: Copy>(call: CallNumber) -> F {
    // SAFETY: as the caller promises.
    unsafe { typed(with_state(|state| state.real[call])) }
}

/// Returns the real function that has a replacement of its own.
///
/// # Safety
/// `F` is the type of the function.
pub(super) unsafe fn real_other<F: Copy>(name: &str) -> F {
    // SAFETY: as the caller promises.
    unsafe { typed(with_state(|state| state.others.get(name).copied())) }
}

/// Returns a function by its type.
///
/// # Safety
/// `F` is the type of the function.
unsafe fn typed<F: Copy>(function: Option<Function>) -> F {
    let function = function.expect("a function that was asked for");
    assert_eq!(size_of::<F>(), size_of::<Function>());
    // SAFETY: both are function pointers, and the caller vouches for the type.
    unsafe { std::mem::transmute_copy(&function) }
}

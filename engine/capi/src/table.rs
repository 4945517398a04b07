//! The objects of one kind in a context. Their handles are numbers, and the number of a destroyed
//! object is not used again.

use std::marker::PhantomData;
use std::sync::{Arc, Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use crate::error::{AntumbraResult, Failure};

/// A handle in C: 64 bits, of which 0 is none.
pub(crate) trait Handle: Copy {
    /// The name of its kind of object in messages.
    const KIND: &'static str;

    fn from_id(id: u64) -> Self;

    fn id(self) -> u64;
}

/// An object that calls on several threads may use.
pub(crate) struct Shared<T>(Arc<RwLock<T>>);

impl<T> Shared<T> {
    /// Locks the object for a call that reads it.
    pub fn read(&self) -> Result<RwLockReadGuard<'_, T>, Failure> {
        self.0.try_read().map_err(|error| unavailable(&error))
    }

    /// Locks the object for a call that changes it.
    pub fn write(&self) -> Result<RwLockWriteGuard<'_, T>, Failure> {
        self.0.try_write().map_err(|error| unavailable(&error))
    }
}

fn unavailable<T>(error: &TryLockError<T>) -> Failure {
    match error {
        TryLockError::WouldBlock => Failure::new(
            AntumbraResult::Busy,
            "another call is using this object: order the calls of your threads",
        ),
        TryLockError::Poisoned(_) => Failure::new(
            AntumbraResult::Poisoned,
            "the object was being changed when an earlier call failed by a panic: destroy it and \
             create it again",
        ),
    }
}

/// A place for an object, and the generation that is the upper half of the object's handle.
struct Slot<T> {
    generation: u32,
    object: Option<Arc<RwLock<T>>>,
}

/// All objects of one kind.
pub(crate) struct Table<T, H> {
    slots: Mutex<Vec<Slot<T>>>,
    /// The generation that slots begin with. It differs between tables, so that handles of other
    /// contexts and kinds are detected.
    first_generation: u32,
    handle: PhantomData<H>,
}

impl<T, H: Handle> Table<T, H> {
    /// Creates a table. `salt` differs between all contexts, scenes and renderers that exist at
    /// the same time.
    pub fn new(salt: u64) -> Self {
        let hash = |sum: u64, byte| sum.wrapping_mul(31).wrapping_add(u64::from(byte));
        let kind = H::KIND.bytes().fold(0, hash);
        // The finalizer of SplitMix64: similar salts give very different generations.
        let mut mixed = salt.wrapping_add(kind).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let first_generation = (mixed >> 32) as u32;
        Self { slots: Mutex::new(Vec::new()), first_generation, handle: PhantomData }
    }

    /// Adds an object and returns its handle.
    pub fn insert(&self, object: T) -> Result<H, Failure> {
        self.insert_with(|_| object)
    }

    /// Adds an object that is made for its handle, and returns the handle.
    pub fn insert_with(&self, make: impl FnOnce(H) -> T) -> Result<H, Failure> {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let index = match slots.iter().position(|slot| slot.object.is_none()) {
            Some(free) => free,
            None => {
                slots.push(Slot { generation: self.first_generation, object: None });
                slots.len() - 1
            }
        };
        let number = u32::try_from(index)
            .ok()
            .and_then(|index| index.checked_add(1))
            .ok_or_else(|| Failure::argument(format_args!("too many objects: {}", H::KIND)))?;
        let handle = H::from_id(u64::from(slots[index].generation) << 32 | u64::from(number));
        slots[index].object = Some(Arc::new(RwLock::new(make(handle))));
        Ok(handle)
    }

    /// Returns an object.
    pub fn find(&self, handle: H) -> Result<Shared<T>, Failure> {
        let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = index_of(&slots, handle).and_then(|index| slots[index].object.as_ref());
        slot.cloned().map(Shared).ok_or_else(|| unknown(handle))
    }

    /// Returns all objects.
    #[cfg(feature = "renderer")]
    pub fn all(&self) -> Vec<Shared<T>> {
        let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        slots.iter().filter_map(|slot| slot.object.clone()).map(Shared).collect()
    }

    /// Takes an object out. It lives on until calls that use it have returned.
    pub fn remove(&self, handle: H) -> Result<Shared<T>, Failure> {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let index = index_of(&slots, handle).ok_or_else(|| unknown(handle))?;
        slots[index].generation = slots[index].generation.wrapping_add(1);
        let object = slots[index].object.take();
        object.map(Shared).ok_or_else(|| unknown(handle))
    }

    /// Destroys an object, if the handle is not 0.
    pub fn destroy(&self, handle: H) -> Result<(), Failure> {
        if handle.id() != 0 {
            drop(self.remove(handle)?);
        }
        Ok(())
    }
}

/// Returns the slot of a handle, if the slot still belongs to the handle.
fn index_of<T, H: Handle>(slots: &[Slot<T>], handle: H) -> Option<usize> {
    let index = (handle.id() as u32).checked_sub(1)? as usize;
    let generation = (handle.id() >> 32) as u32;
    slots.get(index).is_some_and(|slot| slot.generation == generation).then_some(index)
}

fn unknown<H: Handle>(handle: H) -> Failure {
    let kind = H::KIND;
    let id = handle.id();
    let reason = match id {
        0 => format!("the handle of a {kind} is 0: create one first"),
        _ => format!(
            "there is no {kind} {id:#x} here: it was destroyed, or belongs to another context, \
             scene or renderer"
        ),
    };
    Failure::new(AntumbraResult::UnknownHandle, reason)
}

/// Implements [`Handle`] for a struct in C.
macro_rules! handle {
    ($name:ident = $kind:literal) => {
        impl $crate::table::Handle for $name {
            const KIND: &'static str = $kind;

            fn from_id(id: u64) -> Self {
                Self { id }
            }

            fn id(self) -> u64 {
                self.id
            }
        }
        $crate::layout::layout!($name: id);
    };
}
pub(crate) use handle;

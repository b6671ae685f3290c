//! Arrays that come over the border, and copies of instances that importing programs keep.

use std::ffi::{c_int, c_void};
use std::slice;

use super::{Component, ERROR, Listener, OK};
use crate::instance::{Instance, Refused};

/// An array of C; empty where there is none.
///
/// # Safety
/// It has `count` values if it is not null, and outlives the result.
pub(super) unsafe fn array<'a, T>(values: *const T, count: usize) -> &'a [T] {
    if values.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: as promised to this function.
    unsafe { slice::from_raw_parts(values, count) }
}

/// The same, to be written to.
///
/// # Safety
/// As [`array`], and nobody else uses it.
pub(super) unsafe fn array_mut<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    if values.is_null() || count == 0 {
        return &mut [];
    }
    // SAFETY: as promised to this function.
    unsafe { slice::from_raw_parts_mut(values, count) }
}

/// Writes what these variables are into `values`, each as `to` has it.
pub(super) fn get<T>(
    instance: &mut Instance,
    (references, values): (&[u32], &mut [T]),
    is_switch: bool,
    to: impl Fn(f64) -> T,
) -> Result<(), Refused> {
    references.iter().zip(values).try_for_each(|(reference, value)| {
        *value = to(instance.get(*reference, is_switch)?);
        Ok(())
    })
}

/// Sets these variables to `values`, each as `from` takes it.
pub(super) fn set<T: Copy>(
    instance: &mut Instance,
    (references, values): (&[u32], &[T]),
    is_switch: bool,
    from: impl Fn(T) -> f64,
) -> Result<(), Refused> {
    references
        .iter()
        .zip(values)
        .try_for_each(|(reference, value)| instance.set(*reference, is_switch, from(*value)))
}

/// Keeps a copy of an instance under `state`: in the one that is there, or in a new one.
///
/// # Safety
/// `state` is null or a place; in it null, or what this function put there.
pub(super) unsafe fn get_state<L: Listener + 'static>(
    component: *mut c_void,
    state: *mut *mut c_void,
    own: impl FnOnce(*mut c_void) -> Option<&'static mut Component<L>>,
) -> c_int {
    // SAFETY: null, or a place for a pointer.
    let Some(state) = (unsafe { state.as_mut() }) else { return ERROR };
    let mut copy = None;
    let status = own(component).map_or(ERROR, |component| {
        component.obey(|instance| {
            copy = Some(instance.clone());
            Ok(())
        })
    });
    if let Some(copy) = copy {
        // SAFETY: null, or a copy that this function made.
        match unsafe { state.cast::<Instance>().as_mut() } {
            Some(there) => *there = copy,
            None => *state = Box::into_raw(Box::new(copy)).cast(),
        }
    }
    status
}

/// Ends a copy.
///
/// # Safety
/// As [`get_state`].
pub(super) unsafe fn free_state(state: *mut *mut c_void) -> c_int {
    // SAFETY: null, or a place for a pointer.
    if let Some(state) = unsafe { state.as_mut() }
        && !state.is_null()
    {
        // SAFETY: it came from `Box::into_raw`, and is not used again.
        drop(unsafe { Box::from_raw(state.cast::<Instance>()) });
        *state = std::ptr::null_mut();
    }
    OK
}

//! FMI 3.0, co-simulation.
//!
//! Every function keeps to the standard's contract of its arguments: an instance is one that
//! [`fmi3InstantiateCoSimulation`] gave and [`fmi3FreeInstance`] has not taken back, used by one thread at a time; arrays
//! have the length that is said. What model exchange, scheduled execution, clocks and other types of variables need is
//! there as well, because importing programs look it up, and refuses.

#![allow(non_snake_case, reason = "the standard's names")]
#![allow(clippy::missing_safety_doc, reason = "said above, once for all")]

use std::ffi::{CString, c_char, c_int, c_void};

use super::memory::{array, array_mut, free_state, get, get_state, set};
use super::text::text;
use super::{Component, ERROR, Listener, OK, begun};
use crate::instance::{Instance, Refused};

type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

struct ToLog {
    log: Option<LogMessage>,
    environment: *mut c_void,
}

impl Listener for ToLog {
    fn tell(&self, status: i32, message: &CString) {
        let Some(log) = self.log else { return };
        // SAFETY: the callback and its environment are the importing program's, and valid as long as the instance.
        unsafe { log(self.environment, status, c"error".as_ptr(), message.as_ptr()) }
    }
}

type Own = Component<ToLog>;

/// The version.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Messages are told always: there are few.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(_: *mut c_void, _: bool, _: usize, _: *const *const c_char) -> c_int {
    OK
}

/// A new instance; null where there can be none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    log: Option<LogMessage>,
    _update: *const c_void,
) -> *mut c_void {
    let listener = ToLog { log, environment };
    // SAFETY: null, or a text of C.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let Some(resources) = resources else {
        super::tell(&listener, "fmi3InstantiateCoSimulation was called without the path of the resources");
        return std::ptr::null_mut();
    };
    match begun(listener, resources.as_ref().as_ref(), token.as_deref()) {
        Some(component) => Box::into_raw(component).cast(),
        None => std::ptr::null_mut(),
    }
}

/// It is for co-simulation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: *const c_void,
) -> *mut c_void {
    std::ptr::null_mut()
}

/// It is for co-simulation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: *const c_void,
    _: *const c_void,
    _: *const c_void,
    _: *const c_void,
) -> *mut c_void {
    std::ptr::null_mut()
}

/// Ends an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it came from `Box::into_raw`, and is not used again.
        drop(unsafe { Box::from_raw(instance.cast::<Own>()) });
    }
}

/// Obeys a call to an instance.
///
/// # Safety
/// `instance` is null or valid.
unsafe fn obey(instance: *mut c_void, call: impl FnOnce(&mut Instance) -> Result<(), Refused>) -> c_int {
    // SAFETY: null, or an instance that nobody else uses now.
    unsafe { instance.cast::<Own>().as_mut() }.map_or(ERROR, |component| component.obey(call))
}

/// The time of the start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _: bool,
    _: f64,
    start: f64,
    _: bool,
    _: f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            instance.start_at(start);
            Ok(())
        })
    }
}

/// The drive begins.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(instance, Instance::initialize) }
}

/// Nothing to do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(instance, |_| Ok(())) }
}

/// As at the beginning.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

/// Values of numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            get(instance, (array(references, count), array_mut(values, value_count)), false, |value| value)
        })
    }
}

/// Values of switches.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut bool,
    value_count: usize,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            let pairs = (array(references, count), array_mut(values, value_count));
            get(instance, pairs, true, |value| value != 0.0)
        })
    }
}

/// Sets numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            set(instance, (array(references, count), array(values, value_count)), false, |value| value)
        })
    }
}

/// Sets switches.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const bool,
    value_count: usize,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            // As bytes: what is neither true nor false must not become a bool.
            let pairs = (array(references, count), array(values.cast::<u8>(), value_count));
            set(instance, pairs, true, |value| f64::from(u8::from(value != 0)))
        })
    }
}

/// A copy of all that the instance is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { get_state(instance, state, |instance| instance.cast::<Own>().as_mut()) }
}

/// Goes back to a copy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: null, or a copy that `fmi3GetFMUState` made.
    let Some(state) = (unsafe { state.cast::<Instance>().as_ref() }) else { return ERROR };
    // SAFETY: see the module.
    unsafe {
        obey(instance, |instance| {
            *instance = state.clone();
            Ok(())
        })
    }
}

/// Ends a copy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(_: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { free_state(state) }
}

/// A step. It is made at once and as a whole.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    from: f64,
    seconds: f64,
    _: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    last: *mut f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        for flag in [event, terminate, early] {
            if !flag.is_null() {
                flag.write(false);
            }
        }
        obey(instance, |instance| {
            let done = instance.step(from, seconds);
            if !last.is_null() {
                last.write(instance.seconds());
            }
            done
        })
    }
}

/// Nothing to do: there are no events.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3EnterEventMode(_: *mut c_void) -> c_int {
    OK
}

/// Nothing to do.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3EnterStepMode(_: *mut c_void) -> c_int {
    OK
}

/// There are no discrete states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    _: *mut c_void,
    need_update: *mut bool,
    terminate: *mut bool,
    nominals: *mut bool,
    values: *mut bool,
    next_event_is_defined: *mut bool,
    _next_event: *mut f64,
) -> c_int {
    for flag in [need_update, terminate, nominals, values, next_event_is_defined] {
        if !flag.is_null() {
            // SAFETY: a place for a bool, by the standard.
            unsafe { flag.write(false) };
        }
    }
    OK
}

/// Functions of what this FMU has not: they obey calls for nothing (their count is zero) and refuse the others. The
/// arguments are of C's calling convention, in which further ones may be left out by who is called.
macro_rules! of_none {
    ($($name:ident)*) => {
        $(
            /// There are no variables of this type.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(_: *mut c_void, _: *const u32, count: usize) -> c_int {
                if count == 0 { OK } else { ERROR }
            }
        )*
    };
}

of_none! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetInt64
    fmi3GetUInt64 fmi3GetString fmi3GetBinary fmi3GetClock fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16
    fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64 fmi3SetString fmi3SetBinary fmi3SetClock
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction fmi3SetIntervalDecimal
    fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction fmi3GetOutputDerivatives
}

macro_rules! refused {
    ($($name:ident)*) => {
        $(
            /// This FMU has nothing of the kind.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(_: *mut c_void) -> c_int {
                ERROR
            }
        )*
    };
}

refused! {
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies fmi3SerializedFMUStateSize fmi3SerializeFMUState
    fmi3DeserializeFMUState fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3EnterConfigurationMode
    fmi3ExitConfigurationMode fmi3EvaluateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep
    fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfContinuousStates fmi3ActivateModelPartition
}

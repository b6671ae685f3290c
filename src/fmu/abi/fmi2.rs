//! FMI 2.0, co-simulation.
//!
//! Every function keeps to the standard's contract of its arguments: a component is one that [`fmi2Instantiate`] gave and
//! [`fmi2FreeInstance`] has not taken back, used by one thread at a time; arrays have the length that is said.

#![allow(non_snake_case, reason = "the standard's names")]
#![allow(clippy::missing_safety_doc, reason = "said above, once for all")]

use std::ffi::{CString, c_char, c_int, c_void};

use super::memory::{array, array_mut, free_state, get, get_state, set};
use super::text::{folder, text};
use super::{Component, ERROR, Listener, OK, begun};
use crate::instance::{Instance, Refused};

type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// The callbacks of the importing program.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

struct ToLogger {
    logger: Option<Logger>,
    environment: *mut c_void,
    name: CString,
}

impl Listener for ToLogger {
    fn tell(&self, status: i32, message: &CString) {
        let Some(logger) = self.logger else { return };
        // SAFETY: the logger and its environment are the importing program's, and valid as long as the component; the
        // message is an argument, so that no sign of it is taken for a format.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status,
                c"error".as_ptr(),
                c"%s".as_ptr(),
                message.as_ptr(),
            );
        }
    }
}

type Own = Component<ToLogger>;

/// Co-simulation, in the enumeration of types.
const CO_SIMULATION: c_int = 1;

/// The platform of the types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// The version.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Messages are told always: there are few.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetDebugLogging(_: *mut c_void, _: c_int, _: usize, _: *const *const c_char) -> c_int {
    OK
}

/// A new instance; null where there can be none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    of_type: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: null, or a text of C.
    let (name, guid, resources) = unsafe { (text(name), text(guid), text(resources)) };
    // SAFETY: null, or a struct of callbacks.
    let callbacks = unsafe { callbacks.as_ref() };
    let listener = ToLogger {
        logger: callbacks.and_then(|callbacks| callbacks.logger),
        environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.environment),
        name: CString::new(name.as_deref().unwrap_or_default()).unwrap_or_default(),
    };
    if of_type != CO_SIMULATION {
        super::tell(&listener, "this FMU is for co-simulation, not for model exchange");
        return std::ptr::null_mut();
    }
    let Some(resources) = resources else {
        super::tell(&listener, "fmi2Instantiate was called without the place of the resources");
        return std::ptr::null_mut();
    };
    match begun(listener, &folder(&resources), guid.as_deref()) {
        Some(component) => Box::into_raw(component).cast(),
        None => std::ptr::null_mut(),
    }
}

/// Ends an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut c_void) {
    if !component.is_null() {
        // SAFETY: it came from `Box::into_raw`, and is not used again.
        drop(unsafe { Box::from_raw(component.cast::<Own>()) });
    }
}

/// Obeys a call to a component.
///
/// # Safety
/// `component` is null or valid.
unsafe fn obey(component: *mut c_void, call: impl FnOnce(&mut Instance) -> Result<(), Refused>) -> c_int {
    // SAFETY: null, or a component that nobody else uses now.
    unsafe { component.cast::<Own>().as_mut() }.map_or(ERROR, |component| component.obey(call))
}

/// The time of the start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: *mut c_void,
    _: c_int,
    _: f64,
    start: f64,
    _: c_int,
    _: f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            instance.start_at(start);
            Ok(())
        })
    }
}

/// Nothing to do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(component, |_| Ok(())) }
}

/// The drive begins.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(component, Instance::initialize) }
}

/// Nothing to do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(component: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(component, |_| Ok(())) }
}

/// As at the beginning.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

/// Values of real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            get(instance, (array(references, count), array_mut(values, count)), false, |value| value)
        })
    }
}

/// Values of switches.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            let pairs = (array(references, count), array_mut(values, count));
            get(instance, pairs, true, |value| c_int::from(value != 0.0))
        })
    }
}

/// Sets real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            set(instance, (array(references, count), array(values, count)), false, |value| value)
        })
    }
}

/// Sets switches.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const c_int,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            let pairs = (array(references, count), array(values, count));
            set(instance, pairs, true, |value| f64::from(u8::from(value != 0)))
        })
    }
}

/// There are none of these types: only a call for nothing is obeyed.
fn of_no_variable(count: usize) -> c_int {
    if count == 0 { OK } else { ERROR }
}

/// There are no integers.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetInteger(_: *mut c_void, _: *const u32, count: usize, _: *mut c_int) -> c_int {
    of_no_variable(count)
}

/// There are no texts.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetString(_: *mut c_void, _: *const u32, count: usize, _: *mut *const c_char) -> c_int {
    of_no_variable(count)
}

/// There are no integers.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetInteger(_: *mut c_void, _: *const u32, count: usize, _: *const c_int) -> c_int {
    of_no_variable(count)
}

/// There are no texts.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetString(
    _: *mut c_void,
    _: *const u32,
    count: usize,
    _: *const *const c_char,
) -> c_int {
    of_no_variable(count)
}

/// A copy of all that the instance is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { get_state(component, state, |component| component.cast::<Own>().as_mut()) }
}

/// Goes back to a copy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: null, or a copy that `fmi2GetFMUstate` made.
    let Some(state) = (unsafe { state.cast::<Instance>().as_ref() }) else { return ERROR };
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            *instance = state.clone();
            Ok(())
        })
    }
}

/// Ends a copy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(_: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: see the module.
    unsafe { free_state(state) }
}

/// Copies stay in memory.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SerializedFMUstateSize(_: *mut c_void, _: *mut c_void, _: *mut usize) -> c_int {
    ERROR
}

/// Copies stay in memory.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SerializeFMUstate(_: *mut c_void, _: *mut c_void, _: *mut c_char, _: usize) -> c_int {
    ERROR
}

/// Copies stay in memory.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2DeSerializeFMUstate(
    _: *mut c_void,
    _: *const c_char,
    _: usize,
    _: *mut *mut c_void,
) -> c_int {
    ERROR
}

/// There are none.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetDirectionalDerivative(
    _: *mut c_void,
    _: *const u32,
    _: usize,
    _: *const u32,
    _: usize,
    _: *const f64,
    _: *mut f64,
) -> c_int {
    ERROR
}

/// Rates of inputs for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            let all = array(references, count).iter().zip(array(orders, count)).zip(array(values, count));
            // Those of higher order are left out: the steps are short.
            let mut first = all.filter(|((_, order), _)| **order == 1);
            first.try_for_each(|((reference, _), rate)| instance.set_rate(*reference, *rate))
        })
    }
}

/// There are none.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetRealOutputDerivatives(
    _: *mut c_void,
    _: *const u32,
    count: usize,
    _: *const c_int,
    _: *mut f64,
) -> c_int {
    of_no_variable(count)
}

/// A step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(component: *mut c_void, from: f64, seconds: f64, _: c_int) -> c_int {
    // SAFETY: see the module.
    unsafe { obey(component, |instance| instance.step(from, seconds)) }
}

/// Steps are made at once.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2CancelStep(_: *mut c_void) -> c_int {
    ERROR
}

/// Steps are made at once: none is pending.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetStatus(_: *mut c_void, _: c_int, _: *mut c_int) -> c_int {
    ERROR
}

/// The time of the last step's end, of all that can be asked.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(component: *mut c_void, _: c_int, value: *mut f64) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |instance| {
            if let Some(value) = value.as_mut() {
                *value = instance.seconds();
            }
            Ok(())
        })
    }
}

/// None is asked for.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetIntegerStatus(_: *mut c_void, _: c_int, _: *mut c_int) -> c_int {
    ERROR
}

/// The car never ends a drive by itself.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(component: *mut c_void, _: c_int, value: *mut c_int) -> c_int {
    // SAFETY: see the module.
    unsafe {
        obey(component, |_| {
            if let Some(value) = value.as_mut() {
                *value = 0;
            }
            Ok(())
        })
    }
}

/// None is asked for.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetStringStatus(_: *mut c_void, _: c_int, _: *mut *const c_char) -> c_int {
    ERROR
}

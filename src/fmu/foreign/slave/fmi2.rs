//! FMI 2.0.

use std::ffi::{c_char, c_int, c_void};

use libloading::Library;

use super::{checked, function, heard, path_text, text};
use crate::foreign::description::Kind;
use crate::foreign::job::Job;

type Component = *mut c_void;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Component;
type Call = unsafe extern "C" fn(Component) -> c_int;
type Access<T> = unsafe extern "C" fn(Component, *const u32, usize, T) -> c_int;
type Derivatives = unsafe extern "C" fn(Component, *const u32, usize, *const c_int, *const f64) -> c_int;

/// The library's functions, as long as it is loaded.
pub(in crate::foreign) struct Functions {
    instantiate: Instantiate,
    free: unsafe extern "C" fn(Component),
    set_up: unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int,
    enter: Call,
    exit: Call,
    terminate: Call,
    set_real: Access<*const f64>,
    get_real: Access<*mut f64>,
    set_integer: Access<*const c_int>,
    get_integer: Access<*mut c_int>,
    set_boolean: Access<*const c_int>,
    get_boolean: Access<*mut c_int>,
    derivatives: Option<Derivatives>,
    do_step: unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int,
    callbacks: Box<Callbacks>,
    _library: Library,
}

/// What the library may call.
#[repr(C)]
struct Callbacks {
    /// Variadic by the standard: what comes behind the message is not looked at, which C's calling convention allows.
    logger: unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char),
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

unsafe extern "C" fn logger(
    _: *mut c_void,
    _: *const c_char,
    status: c_int,
    _: *const c_char,
    message: *const c_char,
) {
    // SAFETY: null, or a text of C, by the standard.
    unsafe { heard(status, message) };
}

impl Functions {
    pub(super) fn of(library: Library) -> Result<Self, String> {
        // SAFETY: the types are those of the standard.
        unsafe {
            Ok(Self {
                instantiate: function(&library, "fmi2Instantiate")?,
                free: function(&library, "fmi2FreeInstance")?,
                set_up: function(&library, "fmi2SetupExperiment")?,
                enter: function(&library, "fmi2EnterInitializationMode")?,
                exit: function(&library, "fmi2ExitInitializationMode")?,
                terminate: function(&library, "fmi2Terminate")?,
                set_real: function(&library, "fmi2SetReal")?,
                get_real: function(&library, "fmi2GetReal")?,
                set_integer: function(&library, "fmi2SetInteger")?,
                get_integer: function(&library, "fmi2GetInteger")?,
                set_boolean: function(&library, "fmi2SetBoolean")?,
                get_boolean: function(&library, "fmi2GetBoolean")?,
                derivatives: function(&library, "fmi2SetRealInputDerivatives").ok(),
                do_step: function(&library, "fmi2DoStep")?,
                callbacks: Box::new(Callbacks {
                    logger,
                    allocate: calloc,
                    free,
                    step_finished: None,
                    environment: std::ptr::null_mut(),
                }),
                _library: library,
            })
        }
    }
}

/// An instance.
pub(in crate::foreign) struct Instance<'s> {
    functions: &'s Functions,
    component: Component,
}

impl<'s> Instance<'s> {
    pub(super) fn new(functions: &'s Functions, job: &Job) -> Result<Self, String> {
        let (name, token) = (text(&job.name)?, text(&job.token)?);
        let resources = text(&uri(&path_text(&job.resources)))?;
        let callbacks: *const Callbacks = &raw const *functions.callbacks;
        // SAFETY: texts and callbacks outlive the instance; the type is co-simulation.
        let component = unsafe {
            (functions.instantiate)(name.as_ptr(), 1, token.as_ptr(), resources.as_ptr(), callbacks, 0, 0)
        };
        if component.is_null() {
            return Err("fmi2Instantiate gave no instance".into());
        }
        Ok(Self { functions, component })
    }

    pub(super) fn begin(&mut self, seconds: f64) -> Result<(), String> {
        // SAFETY: the component is the library's own.
        let status = unsafe { (self.functions.set_up)(self.component, 0, 0.0, 0.0, 1, seconds) };
        checked(status, "fmi2SetupExperiment")?;
        // SAFETY: as above.
        checked(unsafe { (self.functions.enter)(self.component) }, "fmi2EnterInitializationMode")
    }

    pub(super) fn begun(&mut self) -> Result<(), String> {
        // SAFETY: as in `begin`.
        checked(unsafe { (self.functions.exit)(self.component) }, "fmi2ExitInitializationMode")
    }

    pub(super) fn set(&mut self, kind: Kind, reference: u32, value: f64) -> Result<(), String> {
        let Self { functions, component } = self;
        // SAFETY: as in `begin`; the arrays have one value.
        let status = unsafe {
            match kind {
                Kind::Real | Kind::Single => (functions.set_real)(*component, &reference, 1, &value),
                Kind::Integer => {
                    (functions.set_integer)(*component, &reference, 1, &(value.round() as c_int))
                }
                Kind::Switch => {
                    (functions.set_boolean)(*component, &reference, 1, &c_int::from(value != 0.0))
                }
            }
        };
        checked(status, &format!("setting the variable {reference} to {value}"))
    }

    pub(super) fn get(&mut self, kind: Kind, reference: u32) -> Result<f64, String> {
        let Self { functions, component } = self;
        let (mut real, mut integer) = (f64::NAN, 0);
        // SAFETY: as in `set`.
        let status = unsafe {
            match kind {
                Kind::Real | Kind::Single => (functions.get_real)(*component, &reference, 1, &mut real),
                Kind::Integer => (functions.get_integer)(*component, &reference, 1, &mut integer),
                Kind::Switch => (functions.get_boolean)(*component, &reference, 1, &mut integer),
            }
        };
        checked(status, &format!("asking for the variable {reference}"))?;
        Ok(if matches!(kind, Kind::Real | Kind::Single) { real } else { f64::from(integer) })
    }

    pub(super) fn set_rate(&mut self, reference: u32, rate: f64) -> Result<(), String> {
        let function = self.functions.derivatives.ok_or("its library has no fmi2SetRealInputDerivatives")?;
        // SAFETY: as in `set`.
        let status = unsafe { function(self.component, &reference, 1, &1, &rate) };
        checked(status, "fmi2SetRealInputDerivatives")
    }

    pub(super) fn step(&mut self, from: f64, seconds: f64) -> Result<(), String> {
        // SAFETY: as in `begin`.
        let status = unsafe { (self.functions.do_step)(self.component, from, seconds, 1) };
        checked(status, &format!("the step from {from} s on"))
    }

    pub(super) fn end(self) {
        // SAFETY: as in `begin`; the component is not used again.
        unsafe {
            (self.functions.terminate)(self.component);
            (self.functions.free)(self.component);
        }
    }
}

/// A path as a URI.
fn uri(path: &str) -> String {
    let mut text = String::from("file://");
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte) {
            text.push(char::from(byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

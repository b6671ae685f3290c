//! FMI 3.0.

use std::ffi::{c_char, c_int, c_void};

use libloading::Library;

use super::{checked, function, heard, path_text, text};
use crate::foreign::description::Kind;
use crate::foreign::job::Job;

type Raw = *mut c_void;
type Log = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *mut c_void,
    Log,
    *const c_void,
) -> Raw;
type Call = unsafe extern "C" fn(Raw) -> c_int;
type Access<T> = unsafe extern "C" fn(Raw, *const u32, usize, T, usize) -> c_int;
type DoStep = unsafe extern "C" fn(Raw, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

/// The library's functions, as long as it is loaded.
pub(in crate::foreign) struct Functions {
    instantiate: Instantiate,
    free: unsafe extern "C" fn(Raw),
    enter: unsafe extern "C" fn(Raw, bool, f64, f64, bool, f64) -> c_int,
    exit: Call,
    terminate: Call,
    set_double: Access<*const f64>,
    get_double: Access<*mut f64>,
    set_single: Access<*const f32>,
    get_single: Access<*mut f32>,
    set_integer: Access<*const i32>,
    get_integer: Access<*mut i32>,
    set_boolean: Access<*const bool>,
    /// As bytes: what a library writes need not be a bool.
    get_boolean: Access<*mut u8>,
    do_step: DoStep,
    _library: Library,
}

unsafe extern "C" fn log(_: *mut c_void, status: c_int, _: *const c_char, message: *const c_char) {
    // SAFETY: null, or a text of C, by the standard.
    unsafe { heard(status, message) };
}

impl Functions {
    pub(super) fn of(library: Library) -> Result<Self, String> {
        // SAFETY: the types are those of the standard.
        unsafe {
            Ok(Self {
                instantiate: function(&library, "fmi3InstantiateCoSimulation")?,
                free: function(&library, "fmi3FreeInstance")?,
                enter: function(&library, "fmi3EnterInitializationMode")?,
                exit: function(&library, "fmi3ExitInitializationMode")?,
                terminate: function(&library, "fmi3Terminate")?,
                set_double: function(&library, "fmi3SetFloat64")?,
                get_double: function(&library, "fmi3GetFloat64")?,
                set_single: function(&library, "fmi3SetFloat32")?,
                get_single: function(&library, "fmi3GetFloat32")?,
                set_integer: function(&library, "fmi3SetInt32")?,
                get_integer: function(&library, "fmi3GetInt32")?,
                set_boolean: function(&library, "fmi3SetBoolean")?,
                get_boolean: function(&library, "fmi3GetBoolean")?,
                do_step: function(&library, "fmi3DoStep")?,
                _library: library,
            })
        }
    }
}

/// An instance.
pub(in crate::foreign) struct Instance<'s> {
    functions: &'s Functions,
    raw: Raw,
}

impl<'s> Instance<'s> {
    pub(super) fn new(functions: &'s Functions, job: &Job) -> Result<Self, String> {
        let (name, token) = (text(&job.name)?, text(&job.token)?);
        let resources = text(&format!("{}/", path_text(&job.resources)))?;
        // SAFETY: the texts are there during the call; events, early return and intermediate updates are not asked for.
        let raw = unsafe {
            (functions.instantiate)(
                name.as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                false,
                false,
                false,
                std::ptr::null(),
                0,
                std::ptr::null_mut(),
                log,
                std::ptr::null(),
            )
        };
        if raw.is_null() {
            return Err("fmi3InstantiateCoSimulation gave no instance".into());
        }
        Ok(Self { functions, raw })
    }

    pub(super) fn begin(&mut self, seconds: f64) -> Result<(), String> {
        // SAFETY: the instance is the library's own.
        let status = unsafe { (self.functions.enter)(self.raw, false, 0.0, 0.0, true, seconds) };
        checked(status, "fmi3EnterInitializationMode")
    }

    pub(super) fn begun(&mut self) -> Result<(), String> {
        // SAFETY: as in `begin`.
        checked(unsafe { (self.functions.exit)(self.raw) }, "fmi3ExitInitializationMode")
    }

    pub(super) fn set(&mut self, kind: Kind, reference: u32, value: f64) -> Result<(), String> {
        let Self { functions, raw } = self;
        // SAFETY: as in `begin`; the arrays have one value.
        let status = unsafe {
            match kind {
                Kind::Real => (functions.set_double)(*raw, &reference, 1, &value, 1),
                Kind::Single => (functions.set_single)(*raw, &reference, 1, &(value as f32), 1),
                Kind::Integer => (functions.set_integer)(*raw, &reference, 1, &(value.round() as i32), 1),
                Kind::Switch => (functions.set_boolean)(*raw, &reference, 1, &(value != 0.0), 1),
            }
        };
        checked(status, &format!("setting the variable {reference} to {value}"))
    }

    pub(super) fn get(&mut self, kind: Kind, reference: u32) -> Result<f64, String> {
        let Self { functions, raw } = self;
        let (mut double, mut single, mut integer, mut switch) = (f64::NAN, f32::NAN, 0, 0);
        // SAFETY: as in `set`.
        let status = unsafe {
            match kind {
                Kind::Real => (functions.get_double)(*raw, &reference, 1, &mut double, 1),
                Kind::Single => (functions.get_single)(*raw, &reference, 1, &mut single, 1),
                Kind::Integer => (functions.get_integer)(*raw, &reference, 1, &mut integer, 1),
                Kind::Switch => (functions.get_boolean)(*raw, &reference, 1, &mut switch, 1),
            }
        };
        checked(status, &format!("asking for the variable {reference}"))?;
        Ok(match kind {
            Kind::Real => double,
            Kind::Single => f64::from(single),
            Kind::Integer => f64::from(integer),
            Kind::Switch => f64::from(u8::from(switch != 0)),
        })
    }

    pub(super) fn step(&mut self, from: f64, seconds: f64) -> Result<(), String> {
        let (mut event, mut ended, mut early, mut last) = (0, 0, 0, from);
        // SAFETY: as in `begin`; the flags are bytes, whatever is written into them.
        let status = unsafe {
            (self.functions.do_step)(
                self.raw, from, seconds, true, &mut event, &mut ended, &mut early, &mut last,
            )
        };
        checked(status, &format!("the step from {from} s on"))?;
        if ended != 0 {
            return Err(format!("it ended the simulation at {last} s"));
        }
        if early != 0 {
            return Err(format!("the step from {from} s on ended early, at {last} s, which was not allowed"));
        }
        Ok(())
    }

    pub(super) fn end(self) {
        // SAFETY: as in `begin`; the instance is not used again.
        unsafe {
            (self.functions.terminate)(self.raw);
            (self.functions.free)(self.raw);
        }
    }
}

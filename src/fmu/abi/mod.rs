//! The interface of FMI: functions of C over [`Instance`].
//!
//! Whatever an importing program does wrong is refused with a status and, where it listens, a message. A panic would end
//! that program: none leaves these functions.

mod fmi2;
mod fmi3;
mod memory;
mod text;

use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::car::{CAR_FILE, Car};
use crate::description::token;
use crate::instance::{Instance, Refused};

/// All is well, in both versions.
const OK: i32 = 0;
/// The call was refused; the instance is of no more use.
const ERROR: i32 = 3;

/// Who listens to messages.
trait Listener {
    /// Tells a message.
    fn tell(&self, status: i32, message: &CString);
}

/// An instance as an importing program holds it.
struct Component<L> {
    listener: L,
    instance: Instance,
}

impl<L: Listener> Component<L> {
    /// Obeys a call.
    fn obey(&mut self, call: impl FnOnce(&mut Instance) -> Result<(), Refused>) -> i32 {
        let instance = &mut self.instance;
        let reason = match catch_unwind(AssertUnwindSafe(|| call(instance))) {
            Ok(Ok(())) => return OK,
            Ok(Err(refused)) => refused.to_string(),
            Err(_) => "an error of gripd's own; please tell its authors".to_owned(),
        };
        tell(&self.listener, &reason);
        ERROR
    }
}

fn tell(listener: &impl Listener, reason: &str) {
    // The mark stands in the library because it is said.
    let whole = format!("{}: {}", crate::MARK, reason.replace('\0', " "));
    if let Ok(message) = CString::new(whole) {
        listener.tell(ERROR, &message);
    }
}

/// A new instance of the car in the resources, or nothing, with the reason told.
fn begun<L: Listener>(listener: L, resources: &Path, expected: Option<&str>) -> Option<Box<Component<L>>> {
    let made = catch_unwind(AssertUnwindSafe(|| {
        let path = resources.join(CAR_FILE);
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        if expected.is_some_and(|expected| expected != token(&text)) {
            let reason = "description, resources and library do not belong together; export the car anew";
            return Err(reason.to_owned());
        }
        Car::parse(&text).map(Instance::new).map_err(|error| error.to_string())
    }));
    match made {
        Ok(Ok(instance)) => Some(Box::new(Component { listener, instance })),
        Ok(Err(reason)) => {
            tell(&listener, &reason);
            None
        }
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::{CStr, c_char, c_int, c_void};
    use std::ptr::{null, null_mut};
    use std::sync::Mutex;

    use super::*;
    use crate::car::Part;
    use physics::model::Vehicle;

    static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

    unsafe extern "C" fn log(_: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
        // SAFETY: a text of C, by the standard.
        let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
        SAID.lock().unwrap().push(text);
    }

    fn instantiated(resources: &Path, token: &str) -> *mut c_void {
        let (resources, token) =
            (CString::new(resources.to_str().unwrap()).unwrap(), CString::new(token).unwrap());
        // SAFETY: the texts are there during the call.
        unsafe {
            fmi3::fmi3InstantiateCoSimulation(
                null(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                false,
                false,
                false,
                null(),
                0,
                null_mut(),
                Some(log),
                null(),
            )
        }
    }

    /// GIVEN calls that cannot be obeyed THEN each has a status and says why, and the instance can be ended.
    #[test]
    fn wrong_calls_are_refused_and_said() {
        let folder = tempfile::tempdir().unwrap();
        let car = Car { name: "car".into(), part: Part::Car, vehicle: Vehicle::thesis(), effect: vec![] };
        let text = car.text().unwrap();
        assert!(instantiated(folder.path(), &token(&text)).is_null(), "there are no resources");
        std::fs::write(folder.path().join(CAR_FILE), &text).unwrap();
        assert!(instantiated(folder.path(), "{another}").is_null());
        let instance = instantiated(folder.path(), &token(&text));
        assert!(!instance.is_null());
        let mut value = 0.0;
        // SAFETY: the instance is there until it is freed; arrays have one value.
        unsafe {
            assert_eq!(fmi3::fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), OK);
            assert_eq!(fmi3::fmi3GetFloat64(instance, &100_000, 1, &mut value, 1), ERROR);
            assert_eq!(fmi3::fmi3SetFloat64(instance, &0, 1, &1.0, 1), ERROR, "the time");
            assert_eq!(fmi3::fmi3GetFloat64(instance, null(), 0, null_mut(), 0), OK);
            assert_eq!(fmi3::fmi3ExitInitializationMode(instance), OK);
            let mut last = 0.0;
            let step = |seconds, last: &mut f64| {
                fmi3::fmi3DoStep(instance, 0.0, seconds, true, null_mut(), null_mut(), null_mut(), last)
            };
            assert_eq!(step(0.0123456, &mut last), ERROR);
            assert_eq!((step(0.01, &mut last), last), (OK, 0.01));
            let mut state = null_mut();
            assert_eq!(fmi3::fmi3GetFMUState(instance, &mut state), OK);
            assert_eq!(fmi3::fmi3Reset(instance), OK);
            assert_eq!(fmi3::fmi3SetFMUState(instance, state), OK);
            assert_eq!((fmi3::fmi3GetFloat64(instance, &0, 1, &mut value, 1), value), (OK, 0.01));
            assert_eq!(fmi3::fmi3FreeFMUState(instance, &mut state), OK);
            assert!(state.is_null());
            fmi3::fmi3FreeInstance(instance);
            assert_eq!(fmi3::fmi3Terminate(null_mut()), ERROR);
            assert_eq!(fmi2::fmi2Terminate(null_mut()), ERROR);
        }
        let said = SAID.lock().unwrap();
        for expected in ["cannot read", "do not belong together", "100000", "calculated", "internal_step"] {
            assert!(said.iter().any(|said| said.contains(expected)), "{expected}: {said:?}");
        }
        assert_eq!(said.len(), 5, "{said:?}");
    }
}

//! The interface of FMI: functions of C over [`Instance`].
//!
//! Whatever an importing program does wrong is refused with a status and, where it listens, a message. A panic would end
//! that program: none leaves these functions.

mod fmi2;
mod fmi3;
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

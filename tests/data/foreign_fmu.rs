//! Somebody else's FMU for FMI 2.0, as small as can be, which misbehaves when it is told to. The tests compile it by itself.
//!
//! Variables: 0 steering_wheel_angle (input, deg), 1 psi_dot (output, deg/s), 2 gain (tunable), 3 lag (tunable, s),
//! 4 mood (an integer).

use std::ffi::{c_char, c_int, c_void};

struct Model {
    steering: f64,
    yaw_rate: f64,
    gain: f64,
    lag: f64,
    mood: c_int,
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2Instantiate(
    _: *const c_char,
    _: c_int,
    _: *const c_char,
    _: *const c_char,
    _: *const c_void,
    _: c_int,
    _: c_int,
) -> *mut c_void {
    let model = Model { steering: 0.0, yaw_rate: 0.0, gain: 1.0, lag: 0.1, mood: 0 };
    Box::into_raw(Box::new(model)).cast()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(model: *mut c_void) {
    drop(unsafe { Box::from_raw(model.cast::<Model>()) });
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetupExperiment(_: *mut c_void, _: c_int, _: f64, _: f64, _: c_int, _: f64) -> c_int {
    0
}

macro_rules! fine {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(_: *mut c_void) -> c_int {
                0
            }
        )*
    };
}
fine! { fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2SetBoolean fmi2GetBoolean }

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(model: *mut c_void, reference: *const u32, _: usize, value: *const f64) -> c_int {
    let (model, value) = unsafe { (&mut *model.cast::<Model>(), *value) };
    match unsafe { *reference } {
        0 => model.steering = value,
        2 => model.gain = value,
        3 => model.lag = value,
        _ => return 3,
    }
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(model: *mut c_void, _: *const u32, _: usize, value: *mut f64) -> c_int {
    let model = unsafe { &*model.cast::<Model>() };
    unsafe { *value = if model.mood == 3 { f64::NAN } else { model.yaw_rate } };
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(model: *mut c_void, _: *const u32, _: usize, value: *const c_int) -> c_int {
    unsafe { (*model.cast::<Model>()).mood = *value };
    0
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetInteger(_: *mut c_void, _: *const u32, _: usize, _: *mut c_int) -> c_int {
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(model: *mut c_void, from: f64, seconds: f64, _: c_int) -> c_int {
    let model = unsafe { &mut *model.cast::<Model>() };
    if from > 1.0 {
        match model.mood {
            1 => unsafe { std::ptr::null_mut::<u8>().write_volatile(1) },
            2 => loop {
                std::thread::sleep(std::time::Duration::from_millis(1));
            },
            4 => return 3,
            5 => std::process::exit(0),
            6 => {
                eprintln!("no licence was found");
                std::process::abort();
            }
            _ => {}
        }
    }
    // Exact for an input that holds.
    let left = (-seconds / model.lag).exp();
    model.yaw_rate = left * model.yaw_rate + (1.0 - left) * model.gain * model.steering;
    0
}

//! What was put into a recording, for who judges the answers.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::asked::Wanted;
use bus::signals::Alterer;
use lab::explain::ordinary::conceal::{Concealment, Way, intervals, way};
use physics::Quantity;
use physics::model::effect::{Course, EffectConfig};

/// All there is to tell of.
pub struct Done<'a> {
    pub log: &'a Path,
    pub seed: u64,
    pub wanted: &'a [Wanted],
    pub effects: &'a [EffectConfig],
    pub seconds: f64,
    pub concealment: &'a Concealment,
    pub alterer: &'a Alterer,
    pub notes: &'a [String],
}

/// The JSON.
pub fn of(done: &Done<'_>) -> Value {
    let effects: Vec<Value> =
        done.effects.iter().zip(done.wanted).map(|(effect, wanted)| put_in(effect, wanted, done)).collect();
    let name = done.log.file_name().unwrap_or(done.log.as_os_str()).to_string_lossy();
    let car = done.concealment.car.as_ref().map(|car| {
        let numbers = car.numbers.iter().map(|number| (number.name.clone(), json!(number.estimate)));
        json!({ "yaw_rate_fit": car.fit, "numbers": numbers.collect::<Map<_, _>>() })
    });
    json!({
        "recording": name,
        "seconds": done.seconds,
        "seed": done.seed,
        "effects": effects,
        "frames_changed": done.alterer.frames(),
        "channels": channels(done),
        "car": car,
        "notes": done.notes,
    })
}

/// An effect with its numbers, where it is there and how it was put in.
fn put_in(effect: &EffectConfig, wanted: &Wanted, done: &Done<'_>) -> Value {
    let numbers = effect.specs().zip(effect.numbers()).map(|(spec, number)| {
        let value = if number.value.is_finite() { json!(number.value) } else { Value::Null };
        (spec.name.to_owned(), value)
    });
    let how = match way(effect.kind()) {
        Way::Sensor | Way::Wheels => "on the frames",
        Way::Runs => "difference of two free runs",
    };
    let mut value = json!({
        "effect": effect.kind().name,
        "channel": effect.channel().map(|channel| channel.to_string()),
        "parameters": numbers.collect::<Map<_, _>>(),
        "intervals": intervals(effect, done.seconds),
        "put_in": how,
    });
    match effect.course() {
        Course::None | Course::Live(_) => {}
        Course::Constant(course) | Course::Stretches { value: course, .. } => value["value"] = json!(course),
        Course::Series(series) => {
            if let (Some(size), Some(course)) = (wanted.drawn, effect.kind().course) {
                value["parameters"][course.rms_name] = json!(size);
            }
            value["series"] = json!(series);
        }
    }
    value
}

/// What became of each quantity that is in the recording, beside what the ordinary car leaves of it.
fn channels(done: &Done<'_>) -> Map<String, Value> {
    let there = Quantity::ALL.into_iter().filter(|quantity| {
        let altered = done.alterer.of(*quantity);
        altered.readings > 0
            && (altered.wanted_rms() > 0.0 || done.concealment.unexplained(*quantity).is_some())
    });
    let of = |quantity: Quantity| {
        let altered = done.alterer.of(quantity);
        let unexplained = done.concealment.unexplained(quantity);
        let value = json!({
            "unit": quantity.unit(),
            "values": altered.readings,
            "changed": altered.changed,
            "clipped": altered.clipped,
            "raw_unit": altered.step,
            "wanted_rms": altered.wanted_rms(),
            "rms": altered.rms(),
            "kept": (altered.wanted_rms() > 0.0).then(|| altered.kept()),
            "unexplained_rms": unexplained,
            "strength": unexplained.filter(|rms| *rms > 0.0).map(|rms| altered.rms() / rms),
        });
        (quantity.name().to_owned(), value)
    };
    there.map(of).collect()
}

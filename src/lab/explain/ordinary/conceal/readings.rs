//! Effects of sensors and of the wheels' radii, on the readings themselves.

use physics::model::body::{Body, Velocity};
use physics::model::effect::{Acting, Before, Effect, EffectConfig, Felt, Now, Readings};
use physics::model::{Plant, Vehicle};
use physics::{Quantity, Wheel};

use super::{Way, way};
use crate::explain::Recording;

/// Sensors and wheels with what is put onto them.
#[derive(Debug)]
pub struct Readers {
    plant: Plant,
    body: Body,
    ratio: f64,
    sensors: Vec<Box<dyn Effect>>,
    wheels: Vec<Box<dyn Effect>>,
    delay: [f64; Quantity::COUNT],
    /// What changes places with a quantity.
    swapped: [Option<Quantity>; Quantity::COUNT],
    tracks: [Vec<(f64, f64)>; Quantity::COUNT],
}

impl Readers {
    /// Of a car and a recording of it.
    pub fn new(vehicle: &Vehicle, effects: &[EffectConfig], recording: &Recording) -> Self {
        let made = |wanted: Way| {
            let ordered = EffectConfig::in_order(effects).into_iter();
            ordered.filter(|effect| way(effect.kind()) == wanted).map(EffectConfig::effect).collect()
        };
        let sensors: Vec<Box<dyn Effect>> = made(Way::Sensor);
        let mut delay = [0.0; Quantity::COUNT];
        for (quantity, by) in sensors.iter().filter_map(|effect| effect.delay()) {
            delay[quantity as usize] += by;
        }
        let mut swapped = [None; Quantity::COUNT];
        for channel in effects.iter().filter_map(EffectConfig::channel) {
            let pair: Vec<Quantity> = channel.quantities().collect();
            if let [one, other] = pair[..] {
                (swapped[one as usize], swapped[other as usize]) = (Some(other), Some(one));
            }
        }
        Self {
            plant: Plant::new(vehicle),
            body: Body::new(vehicle),
            ratio: vehicle.steering_ratio.value,
            sensors,
            wheels: made(Way::Wheels),
            delay,
            swapped,
            tracks: recording.tracks.clone(),
        }
    }

    /// What a reading becomes. `changed` says what a quantity's recorded value at a time was in the car that drives there
    /// now.
    pub fn reading(
        &self,
        quantity: Quantity,
        t: f64,
        recorded: f64,
        changed: impl Fn(Quantity, f64, f64) -> f64,
    ) -> f64 {
        let mut readings: Readings = [f64::NAN; Quantity::COUNT];
        for of in [Some(quantity), self.swapped[quantity as usize]].into_iter().flatten() {
            let late = t - self.delay[of as usize];
            let is_itself = of == quantity && late == t;
            let was = if is_itself { Some(recorded) } else { self.recorded(of, late) };
            let Some(was) = was else { return recorded };
            readings[of as usize] = self.rolled(of, late, changed(of, late, was));
        }
        let now = self.now(t, 0.0);
        for effect in &self.sensors {
            effect.sense(&now, &Felt::default(), &[], &mut readings);
        }
        readings[quantity as usize]
    }

    /// What was recorded of a quantity around a time, on a straight line between two readings; the first and the last one
    /// stay beyond the ends.
    pub fn recorded(&self, quantity: Quantity, t: f64) -> Option<f64> {
        let track = &self.tracks[quantity as usize];
        let after = track.partition_point(|(time, _)| *time < t).clamp(1, track.len().max(2) - 1);
        let ((t0, a), (t1, b)) = (*track.get(after - 1)?, *track.get(after)?);
        let share = if t1 > t0 { ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { 1.0 };
        // The readings themselves come back as they are.
        Some(if share == 1.0 { b } else { a + share * (b - a) })
    }

    /// A wheel's speed with the radius that it has now: as far as it goes, it turns the more often the smaller it is.
    fn rolled(&self, quantity: Quantity, t: f64, speed: f64) -> f64 {
        let Some(wheel) = quantity.wheel().filter(|_| !self.wheels.is_empty()) else { return speed };
        let own = self.plant.radius[wheel as usize];
        let now = self.now(t, speed * own);
        let mut on = Acting::plain(&self.plant, 0.0, self.ratio);
        for effect in &self.wheels {
            effect.act(&now, &[], &mut on);
        }
        // Of a wheel that is as it was, nothing is rounded.
        if on.radius[wheel as usize] == own { speed } else { speed * own / on.radius[wheel as usize] }
    }

    /// An instant of straight driving: what sensors and radii look at.
    fn now(&self, t: f64, speed: f64) -> Now<'_> {
        let velocity = Velocity { vx: speed, vy: 0.0, yaw_rate: 0.0 };
        let plain = Now::new(&self.plant, self.ratio, t, velocity, &Before::default());
        Now { body: &self.body, ..plain }
    }
}

/// Do wheels come in the order of the quantities?
const _: () = assert!(Wheel::Rr as usize == 3);

#[cfg(test)]
mod tests {
    use super::*;

    fn effects(text: &str) -> Vec<EffectConfig> {
        #[derive(serde::Deserialize)]
        struct File {
            effect: Vec<EffectConfig>,
        }
        toml::from_str::<File>(text).unwrap().effect
    }

    fn readers(text: &str) -> Readers {
        let mut recording = Recording::default();
        for (place, track) in recording.tracks.iter_mut().enumerate() {
            *track = (0..200).map(|i| (0.05 * f64::from(i), place as f64 + 0.01 * f64::from(i))).collect();
        }
        Readers::new(&Vehicle::thesis(), &effects(text), &recording)
    }

    fn reading(readers: &Readers, quantity: Quantity, t: f64) -> f64 {
        readers.reading(quantity, t, readers.recorded(quantity, t).unwrap(), |_, _, value| value)
    }

    #[test]
    fn sensors_say_what_their_effects_make_of_it_together() {
        let readers = readers(
            "[[effect]]\nkind = \"sensor_scale\"\nchannel = \"yaw_rate\"\nrelative_error = 0.1\n\
             [[effect]]\nkind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.2\nat_s = 5\n\
             [[effect]]\nkind = \"sensor_delay\"\nchannel = \"lateral_acceleration\"\ndelay_s = 0.1\n",
        );
        let was = |quantity, t| readers.recorded(quantity, t).unwrap();
        let yaw = Quantity::YawRate;
        assert!((reading(&readers, yaw, 4.0) - 1.1 * was(yaw, 4.0)).abs() < 1e-12);
        assert!((reading(&readers, yaw, 6.0) - 1.1 * was(yaw, 6.0) - 0.2).abs() < 1e-12);
        let lateral = Quantity::LateralAcceleration;
        assert!((reading(&readers, lateral, 6.0) - was(lateral, 5.9)).abs() < 1e-12);
        assert_eq!(
            reading(&readers, lateral, 0.0),
            was(lateral, 0.0),
            "before the recording stands its first value"
        );
        let wheel = Quantity::WheelSpeedFl;
        assert_eq!(reading(&readers, wheel, 3.3), was(wheel, 3.3));
    }

    #[test]
    fn swapped_channels_say_each_others() {
        let readers =
            readers("[[effect]]\nkind = \"channel_swap\"\nchannel = \"wheel_speed_fl/wheel_speed_rr\"\n");
        let (one, other) = (Quantity::WheelSpeedFl, Quantity::WheelSpeedRr);
        assert_eq!(reading(&readers, one, 2.0), readers.recorded(other, 2.0).unwrap());
        assert_eq!(reading(&readers, other, 2.0), readers.recorded(one, 2.0).unwrap());
    }

    #[test]
    fn a_small_wheel_turns_faster_and_a_growing_one_the_slower_the_faster_it_is() {
        let readers = readers(
            "[[effect]]\nkind = \"tire_radius\"\nrelative_difference_rl = -0.015\n\
             [[effect]]\nkind = \"radius_growth\"\nrelative_per_mps_squared = 1e-5\n",
        );
        let at = |quantity, speed: f64| readers.reading(quantity, 1.0, speed, |_, _, value| value) / speed;
        let radius = readers.plant.radius[2];
        let growth = |ratio: f64, speed: f64| 1.0 + 1e-5 * (radius * speed * ratio).powi(2);
        for speed in [20.0, 90.0] {
            let fl = at(Quantity::WheelSpeedFl, speed);
            assert!((fl * growth(fl, speed) - 1.0).abs() < 1e-5, "{speed}: {fl}");
            let rl = at(Quantity::WheelSpeedRl, speed);
            assert!((rl * 0.985 / fl - 1.0).abs() < 1e-12, "{speed}: {rl}");
        }
    }
}

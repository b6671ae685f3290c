//! Where wheels slide: they spin under too much torque, or lock.
//!
//! In the model a wheel has no inertia of its own: it turns as its force makes it slip. A wheel beyond the limit of
//! its tire does not. The torque that the road does not take turns it faster and faster, it has no side force, and on
//! its way back its spin drives the car. Until the wheels slide most, only the car's longitudinal motion is compared:
//! it tells the friction that is used. On their way back nothing is compared.

use super::grid::{Measured, SLOWEST_MPS, STEP_S};
use physics::Quantity;
use physics::model::{DrivenAxle, Vehicle};

/// Wheels of an axle slide if they turn by more than this share slower or faster than those of the other. Physical: no
/// tire grips with so much slip.
const APART: f64 = 0.25;

/// So long before and after that, s, they slip too much for a wheel that follows its force. Tuned: with less, wrong effects
/// were found beside the friction of a simulated road.
const MARGIN_S: f64 = 0.4;

/// Shorter slides are none, s. Physical: a wheel that hops.
const SHORTEST_S: f64 = 0.15;

/// Wheels that slide for more than this share of a drive do not. Physical: their scale is wrong.
const MOST: f64 = 0.15;

/// One slide of an axle's wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// From, s.
    pub from: f64,
    /// When they slid most, s.
    pub most: f64,
    /// To, s.
    pub to: f64,
    is_front: bool,
}

impl Slide {
    /// Is this a reading that the model cannot have?
    pub(super) fn spoils(&self, reading: &Measured) -> bool {
        let quantity = Quantity::ALL[usize::from(reading.channel)];
        let follows = match quantity.wheel() {
            Some(wheel) => ((wheel as usize) < 2) == self.is_front,
            None => quantity != Quantity::LongitudinalAcceleration,
        };
        follows && (self.from - MARGIN_S..self.to + MARGIN_S).contains(&reading.time())
    }

    /// Does the wheel come back at this time, s?
    pub(super) fn comes_back(&self, time: f64) -> bool {
        (self.most..self.to + MARGIN_S).contains(&time)
    }
}

/// All slides, by readings in the order of time. A wheel of which nothing is heard slides on as it was heard last.
pub(super) fn slides(measured: &[Measured], vehicle: &Vehicle) -> Vec<Slide> {
    let driven = vehicle.driven_axle;
    let slowest = 2.0 * SLOWEST_MPS / vehicle.wheel_radius_m.value;
    let mut all: Vec<Slide> = Vec::new();
    let mut wheels = [f64::NAN; 4];
    let mut largest = 0.0;
    for reading in measured {
        let Some(wheel) = Quantity::ALL[usize::from(reading.channel)].wheel() else { continue };
        wheels[wheel as usize] = reading.value;
        let [front, rear] = [wheels[0] + wheels[1], wheels[2] + wheels[3]];
        let apart = (front - rear).abs() / front.max(rear);
        if !(apart > APART && front.max(rear) > slowest) {
            continue;
        }
        // Driven wheels that are faster spin; otherwise those that are slower are braked.
        let spins = if front > rear { driven != DrivenAxle::Rear } else { driven != DrivenAxle::Front };
        let (is_front, time) = ((front > rear) == spins, reading.time());
        match all.last_mut() {
            Some(last) if last.is_front == is_front && time <= last.to + 2.0 * MARGIN_S => {
                last.to = time;
                if apart > largest {
                    (largest, last.most) = (apart, time);
                }
            }
            _ => {
                largest = apart;
                all.push(Slide { from: time - STEP_S, most: time, to: time, is_front });
            }
        }
    }
    all.retain(|slide| slide.to - slide.from > SHORTEST_S);
    let seconds = measured.last().map_or(0.0, Measured::time);
    let sliding: f64 = all.iter().map(|slide| slide.to - slide.from).sum();
    if sliding > MOST * seconds { Vec::new() } else { all }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A minute at 70 rad/s of all wheels, and those of the front at this speed.
    fn readings(front: impl Fn(f64) -> f64) -> Vec<Measured> {
        let of_step = |step: u32| {
            let wheels = [
                Quantity::WheelSpeedFl,
                Quantity::WheelSpeedFr,
                Quantity::WheelSpeedRl,
                Quantity::WheelSpeedRr,
            ];
            let front = front(f64::from(step) * STEP_S);
            let reading = |(place, quantity): (usize, Quantity)| Measured {
                step,
                share: 1.0,
                channel: quantity as u8,
                value: if place < 2 { front } else { 70.0 },
            };
            wheels.into_iter().enumerate().map(reading).collect::<Vec<_>>()
        };
        (0..3000).flat_map(of_step).collect()
    }

    fn found(front: impl Fn(f64) -> f64) -> Vec<Slide> {
        slides(&readings(front), &Vehicle { driven_axle: DrivenAxle::Front, ..Vehicle::thesis() })
    }

    #[test]
    fn driven_wheels_that_are_much_faster_spin() {
        let spinning = |t: f64| 70.0 + 120.0 * (1.0 - (t - 20.5).abs() / 0.5).max(0.0);
        let [slide] = found(spinning)[..] else { panic!("{:?}", found(spinning)) };
        assert!((slide.from - 20.1).abs() < 0.05 && (slide.to - 20.9).abs() < 0.05, "{slide:?}");
        assert!((slide.most - 20.5).abs() < 0.03 && slide.is_front, "{slide:?}");
        assert!(slide.comes_back(20.7) && !slide.comes_back(20.3) && !slide.comes_back(21.5));
        let spoiled = |quantity: Quantity, t: f64| {
            let step = (t / STEP_S) as u32;
            slide.spoils(&Measured { step, share: 0.5, channel: quantity as u8, value: 0.0 })
        };
        assert!(spoiled(Quantity::WheelSpeedFr, 20.3) && !spoiled(Quantity::WheelSpeedFr, 22.0));
        assert!(spoiled(Quantity::YawRate, 20.3) && !spoiled(Quantity::WheelSpeedRl, 20.3));
        assert!(!spoiled(Quantity::LongitudinalAcceleration, 20.3));
    }

    #[test]
    fn slower_ones_are_braked_and_a_wrong_scale_is_no_slide() {
        let [slide] = found(|t| if (30.0..30.5).contains(&t) { 20.0 } else { 70.0 })[..] else { panic!() };
        assert!(slide.is_front, "{slide:?}");
        assert!(found(|t| 70.0 + (9.0 * t).sin()).is_empty());
        assert!(found(|_| 100.0).is_empty());
    }
}

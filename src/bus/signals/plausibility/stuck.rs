//! A sensor that does not move although others show that it must.

use super::{Contradiction, Kinematics, Run, SLOW};
use physics::{Faults, Micros, Quantity, Sample, Wheel};

/// Fewer equal values than these are no evidence, however slow the message.
const FRAMES: u32 = 20;
/// Runs are those of the frames, which are ahead of the samples: the last equal values have yet to come
/// when the sensor is seen to move again, s.
const DISTRUST_S: f64 = 0.1;

/// What others are witnesses of: the turning of the car and of its wheels.
const WATCHED: [Quantity; 7] = [
    Quantity::WheelSpeedFl,
    Quantity::WheelSpeedFr,
    Quantity::WheelSpeedRl,
    Quantity::WheelSpeedRr,
    Quantity::YawRate,
    Quantity::LateralAcceleration,
    Quantity::SteeringWheelAngle,
];

/// A coarse sensor shows the very same value for long on a straight road, so a constant value alone
/// says nothing: the witnesses must have moved far more than any sensor's step meanwhile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StuckCheck {
    watched: [Watch; Quantity::COUNT],
}

/// What the witnesses did during a run of equal values.
#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    /// The run's beginning and its value.
    since: Micros,
    value: f64,
    first: Span,
    second: Span,
    /// How long a value is still not believed, s.
    distrust_s: f64,
}

/// Lowest and highest.
#[derive(Clone, Copy, Debug)]
struct Span {
    low: f64,
    high: f64,
}

impl Default for Span {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl Span {
    fn include(&mut self, value: f64) {
        if value < self.low {
            self.low = value;
        }
        if value > self.high {
            self.high = value;
        }
    }

    /// Minus infinity while empty.
    fn width(&self) -> f64 {
        self.high - self.low
    }
}

impl Watch {
    /// Nothing moved yet during this run.
    fn begin(&mut self, since: Micros) {
        *self = Self { since, first: Span::default(), second: Span::default(), ..*self };
    }
}

impl StuckCheck {
    /// The sensor that stands still, if one does.
    pub(super) fn reason(&self) -> Option<Contradiction> {
        let stuck = |quantity: &Quantity| self.watched[*quantity as usize].distrust_s > 0.0;
        let quantity = WATCHED.into_iter().find(stuck)?;
        Some(Contradiction::Stuck { quantity, value: self.watched[quantity as usize].value })
    }

    pub(super) fn check(
        &mut self,
        sample: &mut Sample,
        wheels: &Kinematics,
        runs: &[Run; Quantity::COUNT],
    ) -> Faults {
        let mut faults = Faults::empty();
        let speeds = sample.wheel_speeds();
        let moving = wheels.speed.is_some_and(|speed| speed > SLOW);
        for quantity in WATCHED {
            let run = &runs[quantity as usize];
            let watch = &mut self.watched[quantity as usize];
            watch.distrust_s = (watch.distrust_s - sample.elapsed_s).max(0.0);
            watch.value = run.value;
            if watch.since != run.since {
                watch.begin(run.since);
            }
            let Some(value) = sample.get(quantity) else { continue };
            if !moving {
                watch.begin(run.since);
                continue;
            }
            let lasted = |seconds| (run.until - run.since).seconds() > seconds;
            let stuck = match quantity {
                Quantity::YawRate => {
                    let (Some(yaw), Some(steering)) =
                        (wheels.yaw_rate, sample.get(Quantity::SteeringWheelAngle))
                    else {
                        continue;
                    };
                    watch.first.include(yaw);
                    watch.second.include(steering);
                    watch.first.width() > 0.15 && watch.second.width() > 0.15 && lasted(2.0)
                }
                Quantity::LateralAcceleration => {
                    let (Some(yaw), Some(speed)) = (sample.get(Quantity::YawRate), wheels.speed) else {
                        continue;
                    };
                    watch.first.include(yaw * speed);
                    watch.first.width() > 2.0 && lasted(2.0)
                }
                Quantity::SteeringWheelAngle => {
                    // A wheel held still while the car turns from left to right and back is not held.
                    let (Some(yaw), Some(other)) = (sample.get(Quantity::YawRate), wheels.yaw_rate) else {
                        continue;
                    };
                    watch.first.include(yaw);
                    watch.second.include(other);
                    let both_ways = |span: &Span| span.low < -0.1 && span.high > 0.1;
                    both_ways(&watch.first) && both_ways(&watch.second) && lasted(5.0)
                }
                _ => {
                    let (Some(wheel), Some(speeds)) = (quantity.wheel(), speeds) else { continue };
                    let others = Wheel::ALL.into_iter().filter(|other| *other != wheel);
                    watch.first.include(others.map(|other| speeds[other as usize]).sum::<f64>() / 3.0);
                    // At standstill a wheel is locked rather than its sensor stuck.
                    let moved = watch.first.width() > 3.0 + 0.2 * watch.first.high;
                    value.abs() > 1.0 && moved && lasted(1.0)
                }
            };
            if stuck && run.frames >= FRAMES {
                watch.distrust_s = DISTRUST_S;
            }
            if watch.distrust_s > 0.0 {
                sample.clear(quantity);
                faults |= Faults::STUCK;
            }
        }
        faults
    }
}

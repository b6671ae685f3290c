//! Delays are told against the earliest sensor. A recording shows only how late sensors are one against another, and no
//! sensor reads what has not happened yet: steering and speed that both come 65 ms before the yaw rate are one late gyroscope.

use physics::Quantity;

use super::result::{Estimate, Finding, Nature};

/// Shorter delays are those of any two sensors, s. Physical: each is read for a frame of 100 Hz, and waits for it; the
/// steering of unchanged real drives comes up to 17 ms before or after the yaw rate (`concealed_in_real_drives`).
pub(super) const LEAST_DELAY_S: f64 = 0.02;

/// So many standard deviations are a delay. Statistical.
const TOLD: f64 = 3.0;

/// The sensors that every ordinary car's fit compares.
const SENSORS: [Quantity; 3] = [Quantity::YawRate, Quantity::SteeringWheelAngle, Quantity::VehicleSpeed];

const NONE: Estimate = Estimate { value: 0.0, std: 0.0 };
const KIND: &str = "sensor_delay";
const NUMBER: &str = "delay_s";

/// Counts the delays of the measurement from another sensor if fewer sensors are late then, and none is early.
pub fn against_the_earliest(findings: &mut Vec<Finding>) {
    let delays = SENSORS.map(|sensor| of(findings, sensor).map(|place| delay(&findings[place])));
    let told: Vec<Estimate> = delays.iter().copied().flatten().collect();
    let late = |from: Estimate| {
        delays.iter().map(|delay| difference(delay.unwrap_or(NONE), from)).collect::<Vec<Estimate>>()
    };
    let count = |all: &[Estimate]| all.iter().filter(|delay| is_clear(delay)).count();
    let as_told = count(&late(NONE));
    let others = told.into_iter().map(|from| (from, late(from)));
    let possible = others.filter(|(_, all)| all.iter().all(|delay| delay.value > 0.0 || !is_clear(delay)));
    let Some((from, all)) =
        possible.min_by_key(|(_, all)| count(all)).filter(|(_, all)| count(all) < as_told)
    else {
        return;
    };
    let clearest = SENSORS.iter().filter_map(|sensor| of(findings, *sensor)).min();
    let Some(clearest) = clearest.map(|place| findings[place].clone()) else { return };
    for (sensor, delay) in SENSORS.into_iter().zip(all) {
        let told = of(findings, sensor);
        if !is_clear(&delay) {
            told.map(|place| findings.remove(place));
            continue;
        }
        let place = told.unwrap_or_else(|| {
            let place = findings.iter().position(is_delay).unwrap_or(0);
            let words = format!("the other sensors come {:.0} ms before it", -1e3 * from.value);
            findings.insert(place, Finding { about: words, ..clearest.clone() });
            place
        });
        let finding = &mut findings[place];
        finding.channel = Some(sensor.name().to_owned());
        finding.place.channels = vec![sensor.name().to_owned()];
        finding.parameters.insert(NUMBER.into(), delay);
    }
}

fn is_delay(finding: &Finding) -> bool {
    finding.effect == KIND && finding.kind == Nature::Measurement && finding.parameters.contains_key(NUMBER)
}

fn of(findings: &[Finding], sensor: Quantity) -> Option<usize> {
    findings.iter().position(|finding| is_delay(finding) && finding.channel.as_deref() == Some(sensor.name()))
}

fn delay(finding: &Finding) -> Estimate {
    finding.parameters.get(NUMBER).copied().unwrap_or(NONE)
}

fn difference(one: Estimate, other: Estimate) -> Estimate {
    let std = if one == other { one.std } else { one.std.hypot(other.std) };
    Estimate { value: one.value - other.value, std }
}

fn is_clear(delay: &Estimate) -> bool {
    delay.value.abs() > LEAST_DELAY_S && delay.value.abs() > TOLD * delay.std
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(delays: &[(&str, f64, f64)]) -> Vec<(String, f64)> {
        let finding = |(channel, value, std): &(&str, f64, f64)| Finding {
            effect: KIND.into(),
            channel: Some((*channel).to_owned()),
            kind: Nature::Measurement,
            parameters: [(NUMBER.to_owned(), Estimate { value: *value, std: *std })].into(),
            ..Finding::default()
        };
        let mut findings: Vec<Finding> = delays.iter().map(finding).collect();
        against_the_earliest(&mut findings);
        let of = |finding: Finding| (finding.channel.clone().unwrap(), (1e3 * delay(&finding).value).round());
        findings.into_iter().map(of).collect()
    }

    #[test]
    fn what_comes_before_its_time_makes_another_sensor_late() {
        let early = [("vehicle_speed", -0.065, 0.004), ("steering_wheel_angle", -0.061, 0.002)];
        assert_eq!(told(&early), [("yaw_rate".to_owned(), 61.0)]);
        // The audit took too much, and what it took stands in the others.
        let more = [
            ("yaw_rate", 0.103, 0.012),
            ("steering_wheel_angle", 0.030, 0.003),
            ("vehicle_speed", 0.025, 0.003),
        ];
        assert_eq!(told(&more), [("yaw_rate".to_owned(), 73.0)]);
    }

    #[test]
    fn what_could_be_stays_as_it_is() {
        let late = [("steering_wheel_angle", 0.03, 0.002), ("vehicle_speed", 0.03, 0.002)];
        assert_eq!(told(&late).len(), 2);
        assert_eq!(told(&late[..1]), [("steering_wheel_angle".to_owned(), 30.0)]);
        assert_eq!(
            told(&[("steering_wheel_angle", -0.03, 0.002)]),
            [("steering_wheel_angle".to_owned(), -30.0)]
        );
        assert_eq!(told(&[]), []);
    }
}

//! A finding beside somebody's simulation as a modeller says it: what the model has not, and what that comes to in a hard turn
//! of this drive.

use super::words::{self, number, three};
use crate::explain::{Finding, OffBy, SecondPass};
use physics::Quantity;
use physics::model::effect::{Spec, named};

/// Side forces that differ by less are the same.
const LEAST_SIDE_FORCE: f64 = 0.005;

/// A simulation that has less than this share of what the recording has has none of it.
const LEAST_THERE: f64 = 0.1;

/// Tires and axles as they are called, in the order in which they are told.
const TIRES: [(&str, &str); 4] = [
    ("front_outer", "outer front tire"),
    ("front_inner", "inner front tire"),
    ("rear_outer", "outer rear tire"),
    ("rear_inner", "inner rear tire"),
];
const AXLES: [(&str, &str); 2] = [("front", "front axle"), ("rear", "rear axle")];

/// What to change, in a sentence without full stop.
pub fn sentence(finding: &Finding) -> String {
    let with_forces = |has: String, parts: &[(&str, &str)]| match side_forces(finding, parts) {
        Some(forces) => format!("{has}: {forces}"),
        None => has,
    };
    match finding.effect.as_str() {
        "law" => law(finding),
        "sensor_delay" => late(finding),
        "sensor_scale" => scale(finding),
        "sensor_bias" => jump(finding),
        "load_transfer" => with_forces(lacks(finding), &[&TIRES[..2], &AXLES].concat()),
        "relaxation_length" => relaxation(finding),
        "body_roll" => lean(finding),
        "friction_change" | "surface_stiffness" => with_forces(patch(finding), &AXLES),
        name if words::is_of_sensors(name) => {
            format!("your model may stay as it is: {} is of how the recording is measured", what(finding))
        }
        name if named(name).is_none() => with_forces(of_the_car(finding), &AXLES),
        _ => with_forces(lacks(finding), &AXLES),
    }
}

/// Its numbers, those of the simulation behind them.
pub fn numbers(finding: &Finding) -> String {
    let rows: Vec<String> = words::parameters(finding)
        .iter()
        .filter(|row| row.is_main || finding.reference_value.is_some())
        .map(|row| format!("{} {}", row.name, row.value()))
        .collect();
    let was = words::reference(finding).map_or_else(String::new, |was| format!(" ({was})"));
    words::list(&rows) + &was
}

/// By how much the yaw rate of a model without it is off.
pub fn off_by(second: &SecondPass) -> String {
    let Some(OffBy { rms, most, most_at_s }) = second.without.yaw_rate else {
        return "it slides off the road".into();
    };
    let (factor, unit) = words::shown_unit("yaw_rate", Quantity::YawRate.unit());
    format!(
        "{} {unit} (rms), {} {unit} at most, at {} s",
        three(factor * rms),
        three(factor * most),
        number(most_at_s, 1)
    )
}

fn what(finding: &Finding) -> String {
    words::effect(&finding.effect, finding.channel.as_deref())
}

/// The main number's value in its SI unit.
fn main(finding: &Finding) -> Option<f64> {
    let kind = named(&finding.effect)?;
    let main = kind.parameters.iter().filter(|spec| spec.is_main);
    main.filter_map(|spec| finding.parameters.get(spec.name)).map(|it| it.value).next()
}

/// "your model has no load transfer", or another one.
fn lacks(finding: &Finding) -> String {
    let name = what(finding);
    let shown = words::parameters(finding);
    let value = shown.first().map_or_else(String::new, |row| format!(" ({} {})", row.name, row.value()));
    match (finding.reference_value, finding.parameters.values().next()) {
        (Some(was), Some(is)) if was.value.abs() > LEAST_THERE * is.value.abs() => {
            let much = if was.value.abs() < is.value.abs() { "little" } else { "much" };
            format!("your model has too {much} {name}{value}")
        }
        _ => format!("your model has no {name}{value}"),
    }
}

/// A number of the car that is another one.
fn of_the_car(finding: &Finding) -> String {
    let (Some(was), Some((name, is))) = (finding.reference_value, finding.parameters.first_key_value())
    else {
        return lacks(finding);
    };
    let shown = words::ordinary(name, *is);
    let by = was.value / is.value - 1.0;
    let large = if by > 0.0 { "large" } else { "small" };
    format!(
        "your model's {} is {} % too {large}; make it {}",
        shown.name,
        number(100.0 * by.abs(), 0),
        shown.value()
    )
}

fn law(finding: &Finding) -> String {
    let law = finding.law.as_ref();
    law.map_or_else(
        || lacks(finding),
        |law| format!("add {} to the {}, which no effect of the library does", law.expression, law.place),
    )
}

/// Does a simulation take this quantity, or give it?
fn is_input(channel: &str) -> bool {
    ["steering_wheel_angle", "vehicle_speed", "drive_torque", "brake_pressure"].contains(&channel)
}

fn late(finding: &Finding) -> String {
    let channel = finding.channel.as_deref().unwrap_or_default();
    let by = number(1e3 * main(finding).unwrap_or(0.0).abs(), 0);
    let early = main(finding).is_some_and(|delay| delay < 0.0);
    let name = words::channel(channel);
    let when = if early { "early" } else { "late" };
    if is_input(channel) {
        let sooner = if early { "later" } else { "sooner" };
        return format!(
            "the recorded {name} is {by} ms {when}: give it to your model {by} ms {sooner}, or let your actuator be as fast"
        );
    }
    let instead = if early {
        format!("take a delay of {by} ms out of your model's")
    } else {
        format!("delay that of your model by {by} ms")
    };
    format!("the recorded {name} is {by} ms {when}: {instead}")
}

fn scale(finding: &Finding) -> String {
    let channel = finding.channel.as_deref().unwrap_or_default();
    let error = main(finding).or(finding.parameters.values().next().map(|it| it.value)).unwrap_or(0.0);
    let percent = number(100.0 * error.abs(), 1);
    let name = words::channel(channel);
    match channel {
        "steering_wheel_angle" => {
            let ratio = if error > 0.0 { "larger" } else { "smaller" };
            format!("make your model's steering ratio {percent} % {ratio}, if the recorded {name} is right")
        }
        "vehicle_speed" => {
            let much = if error > 0.0 { "much" } else { "little" };
            format!(
                "the recorded speed reads {percent} % too {much} (tire radii, or the message): drive your model by the true one"
            )
        }
        _ => {
            let much = if error > 0.0 { "more" } else { "less" };
            format!(
                "the recorded {name} reads {percent} % {much} than what your model gives; nothing of the car does that"
            )
        }
    }
}

fn jump(finding: &Finding) -> String {
    let rows = words::parameters(finding);
    let value = rows.iter().find(|row| row.is_main).or(rows.first());
    let value = value.map_or_else(String::new, words::Shown::value);
    let at = finding.parameters.get(Spec::AT_S.name).map(|at| format!(" from {} s on", number(at.value, 1)));
    format!(
        "the recorded {} reads {value} more{}: add that to your model's, or take it out of the recording",
        words::channel(finding.channel.as_deref().unwrap_or_default()),
        at.unwrap_or_default()
    )
}

fn relaxation(finding: &Finding) -> String {
    let has = lacks(finding);
    let speed = finding.second_pass.as_ref().map(|second| second.without.turning_at_mps);
    let was = finding.reference_value.map_or(0.0, |was| was.value);
    match (speed.filter(|speed| *speed > 0.0), main(finding)) {
        (Some(speed), Some(length)) => {
            let by = length - was.max(0.0);
            let early = if by > 0.0 { "early" } else { "late" };
            format!(
                "{has}: at {} km/h its side forces are {} ms too {early}",
                number(3.6 * speed, 0),
                number(1e3 * by.abs() / speed, 0)
            )
        }
        _ => has,
    }
}

fn lean(finding: &Finding) -> String {
    let has = lacks(finding);
    let turning = finding.second_pass.as_ref().map(|second| second.without.turning_mps2);
    match (turning.filter(|turning| *turning > 0.0), main(finding)) {
        (Some(turning), Some(gain)) => format!(
            "{has}: at {} m/s² the accelerometer leans by {}°, which your lateral acceleration has not",
            number(turning, 1),
            number((gain * turning).to_degrees(), 1)
        ),
        _ => has,
    }
}

fn patch(finding: &Finding) -> String {
    let rows = words::parameters(finding);
    let value = rows.first().map_or_else(String::new, |row| format!("{} {}", row.name, row.value()));
    let when = words::intervals(&finding.place, 3);
    let when = if when.is_empty() { "the road".to_owned() } else { format!("the road at {when}") };
    format!("your model's road is the same all the way; {when} has {value}")
}

/// What too much or too little side force there is without it in hard turns; nothing where there is none.
fn side_forces(finding: &Finding, parts: &[(&str, &str)]) -> Option<String> {
    let without = &finding.second_pass.as_ref()?.without;
    let told: Vec<String> = parts
        .iter()
        .filter_map(|(key, name)| {
            let share = *without.too_much_side_force.get(*key)?;
            let stiff = if share > 0.0 { "stiff" } else { "soft" };
            (share.abs() >= LEAST_SIDE_FORCE)
                .then(|| format!("its {name} is {} % too {stiff}", number(100.0 * share.abs(), 0)))
        })
        .collect();
    (!told.is_empty() && without.turning_mps2 > 0.0).then(|| {
        format!(
            "at {} m/s² and {} km/h {}",
            number(without.turning_mps2, 1),
            number(3.6 * without.turning_at_mps, 0),
            words::list(&told)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;
    use crate::explain::Estimate;

    fn finding(effect: &str) -> Finding {
        let all = sample::beside_a_simulation().findings;
        all.into_iter().find(|finding| finding.effect == effect).unwrap()
    }

    /// GIVEN a model without load transfer THEN it is told which tire gives too much, at the drive's own hard turns.
    #[test]
    fn load_transfer_is_told_by_the_tires() {
        let mut lacking = finding("load_transfer");
        assert_eq!(
            sentence(&lacking),
            "your model has no load transfer (height of the centre of gravity 0.553 ± 0.021 m): at 6.0 m/s² and 54 km/h its \
             outer front tire is 11 % too soft, its inner front tire is 19 % too stiff and its front axle is 3 % too stiff"
        );
        // Other numbers are other words.
        let without = &mut lacking.second_pass.as_mut().unwrap().without;
        without.too_much_side_force.insert("front_outer".into(), 0.07);
        without.turning_mps2 = 4.2;
        assert!(sentence(&lacking).contains("at 4.2 m/s²"), "{}", sentence(&lacking));
        assert!(sentence(&lacking).contains("outer front tire is 7 % too stiff"), "{}", sentence(&lacking));
    }

    #[test]
    fn a_number_of_the_car_is_told_against_the_simulation_s() {
        let stiffer = finding("lateral_stiffness_front");
        assert!(
            sentence(&stiffer)
                .starts_with("your model's front cornering stiffness is 25 % too large; make it 12.0"),
            "{}",
            sentence(&stiffer)
        );
        assert!(numbers(&stiffer).contains("(15.0"), "{}", numbers(&stiffer));
        let mut softer = stiffer.clone();
        softer.reference_value = Some(Estimate { value: 9.0, std: 0.1 });
        assert!(sentence(&softer).contains("25 % too small"), "{}", sentence(&softer));
    }

    #[test]
    fn what_is_measured_is_no_change_of_the_car() {
        let late = finding("sensor_delay");
        assert_eq!(sentence(&late), "the recorded yaw rate is 43 ms late: delay that of your model by 43 ms");
        let mut steering = late.clone();
        steering.channel = Some("steering_wheel_angle".into());
        assert!(
            sentence(&steering).contains("give it to your model 43 ms sooner"),
            "{}",
            sentence(&steering)
        );
    }
}

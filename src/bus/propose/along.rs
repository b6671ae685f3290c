//! Do signals behave like what drives the car and what brakes it?

use super::evidence::{Evidence, Verdict};
use super::motion::Motion;
use super::regression::line;
use super::source::{RADIUS_M, Unit};

/// The change of speed while the car moves: who waits at a light stands on the brake.
fn moving(motion: &Motion) -> impl Iterator<Item = f64> {
    let moving = motion.change.iter().zip(&motion.speed);
    moving.map(|(change, speed)| if speed.is_finite() { *change } else { f64::NAN })
}

/// Pressed while the car slows down, and else not.
pub(super) fn brake(series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let slowing: Vec<f64> =
        moving(motion).map(|a| if a.is_nan() { a } else { (-a - 0.3).max(0.0) }).collect();
    let is_there = |i: &usize| slowing[*i].is_finite() && series.get(*i).is_some_and(|x| x.is_finite());
    let (braking, rolling): (Vec<usize>, Vec<usize>) =
        (0..slowing.len()).filter(is_there).partition(|i| slowing[*i] > 0.5);
    if braking.len() < 5 {
        return Evidence::silent(unit, "hardly any braking in the recording".into());
    }
    // Who brakes seldom brakes less than the tenth of the time that a line may leave out as wrong: so the rest is
    // thinned to three times as much, from all over the drive.
    let every = (rolling.len() / (3 * braking.len()).max(30)).max(1);
    let rows: Vec<usize> = braking.iter().copied().chain(rolling.into_iter().step_by(every)).collect();
    let [series, slowing] =
        [series, &slowing].map(|of| rows.iter().map(|row| of[*row]).collect::<Vec<f64>>());
    let Some(found) = line(&series, &[&slowing]) else {
        let words = "does not move while the car brakes".to_owned();
        return Evidence { verdict: Verdict::Contradicts, ..Evidence::silent(unit, words) };
    };
    let fits = found.correlation > 0.6;
    let verdict = match found.correlation {
        _ if fits => Verdict::Fits,
        c if c < 0.25 => Verdict::Contradicts,
        _ => Verdict::Silent,
    };
    Evidence {
        verdict,
        correlation: Some(found.correlation),
        words: format!("correlation {:.2} with slowing down", found.correlation),
        ..Evidence::silent(unit, String::new())
    }
}

/// In proportion to acceleration and drag while the brakes rest.
pub(super) fn torque(series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let driven: Vec<f64> = motion.change.iter().map(|a| if *a > -0.5 { *a } else { f64::NAN }).collect();
    let square: Vec<f64> = motion.speed.iter().map(|v| v * v).collect();
    let Some(found) = line(series, &[&driven, &square]) else {
        return Evidence::silent(unit, "does not move with acceleration".into());
    };
    let per_acceleration = unit.to_si().map(|to_si| to_si * found.factors[0]);
    let verdict = match found.correlation {
        c if c > 0.75 => Verdict::Fits,
        c if c < 0.3 => Verdict::Contradicts,
        _ => Verdict::Silent,
    };
    let size = per_acceleration.map_or_else(String::new, |size| {
        format!(", {size:.0} N m for 1 m/s² (an axle of a car of 1,500 kg: {:.0})", 1500.0 * RADIUS_M)
    });
    Evidence {
        verdict,
        correlation: Some(found.correlation),
        scale: per_acceleration.map(|size| size / (1500.0 * RADIUS_M)),
        words: format!("correlation {:.2} with acceleration{size}", found.correlation),
        ..Evidence::silent(unit, String::new())
    }
}

/// On while the car slows down, off while it gains speed.
pub(super) fn pedal(series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let mut table = [[0_u32; 2]; 2];
    for (value, change) in series.iter().zip(moving(motion)) {
        if !(value.is_finite() && change.is_finite()) {
            continue;
        }
        let on = *value > 0.5;
        // What is neither braking nor the contrary may be either.
        if !(-0.8..=-0.1).contains(&change) {
            table[usize::from(on)][usize::from(change < -0.8)] += 1;
        }
    }
    let [[off_going, off_braking], [on_going, on_braking]] = table.map(|row| row.map(f64::from));
    let (on, off) = (on_going + on_braking, off_going + off_braking);
    let (going, braking) = (off_going + on_going, off_braking + on_braking);
    if on < 4.0 || off < 4.0 || braking < 4.0 {
        let words =
            if on < 4.0 { "never on while driving" } else { "not on and off while driving and braking" };
        return Evidence::silent(unit, words.into());
    }
    let matched = (on_braking * off_going - on_going * off_braking) / (on * off * going * braking).sqrt();
    let verdict = match matched {
        m if m > 0.55 => Verdict::Fits,
        m if m < 0.15 => Verdict::Contradicts,
        _ => Verdict::Silent,
    };
    Evidence {
        verdict,
        correlation: Some(matched),
        words: format!(
            "on in {:.0} % of braking and {:.0} % of the rest",
            100.0 * on_braking / braking,
            100.0 * on_going / going.max(1.0)
        ),
        ..Evidence::silent(unit, String::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many points of this speed and change.
    fn drive(parts: &[(usize, f64, f64)]) -> Motion {
        let all = |of: fn(&(usize, f64, f64)) -> f64| -> Vec<f64> {
            parts.iter().flat_map(|part| std::iter::repeat_n(of(part), part.0)).collect()
        };
        let speed = all(|part| part.1);
        Motion {
            change: all(|part| part.2),
            difference: vec![0.0; speed.len()],
            turn: vec![0.0; speed.len()],
            speed,
            sides: [[0, 2], [1, 3]],
            turned: false,
            front: None,
            confirmed: None,
        }
    }

    /// GIVEN a long wait with the foot on the brake, and brakings that are a small part of the drive.
    #[test]
    fn waiting_with_the_foot_on_the_brake_speaks_against_no_brake() {
        let motion = drive(&[(200, f64::NAN, 0.0), (300, 10.0, 0.4), (12, 10.0, -3.0), (300, 10.0, 0.0)]);
        let pressure: Vec<f64> = (0..812)
            .map(|point| match point {
                0..200 => 33.0,
                500..512 => 25.0 + f64::from(point % 3),
                _ => 0.1 * f64::from(point % 5),
            })
            .collect();
        let found = brake(&pressure, &Unit::Known(1.0), &motion);
        assert_eq!(found.verdict, Verdict::Fits, "{}", found.words);
        let flag: Vec<f64> = pressure.iter().map(|pressure| f64::from(u8::from(*pressure > 5.0))).collect();
        assert_eq!(pedal(&flag, &Unit::Unknown, &motion).verdict, Verdict::Fits);
        // What is pressed at other times is none.
        let other: Vec<f64> = (0..812).map(|point| f64::from(point % 7)).collect();
        assert_ne!(brake(&other, &Unit::Known(1.0), &motion).verdict, Verdict::Fits);
    }
}

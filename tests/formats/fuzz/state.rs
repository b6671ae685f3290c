//! The file that what was learned is kept in.

use gripd::Micros;
use gripd::estimate::{Known, Learned};
use gripd::service::saved::text;
use testing::hostile::state::{check, sealed};

use super::mutate::Mutator;
use super::run::fuzz;

const WORDS: [&str; 8] =
    ["value = ", "std = ", "[slip_slope.fl]\n", "version = ", "format = ", "nan", "[", "driving_s = "];

fn learned() -> Learned {
    let known = |value, std| Some(Known { value, std });
    Learned {
        time: Micros(1_795_320_000_123_456),
        driving_s: 1234.5,
        slope: [known(95.25, 2.0), known(100.0, 3.0), None, None],
        slip_offset: [known(0.015, 1e-5), known(-0.001, 2e-5), None, None],
        cornering: [known(12.1, 0.3), None],
        yaw_rate_offset: known(0.12, 4e-4),
        lateral_acceleration_offset: known(-0.3, 0.01),
        road_angle_offset: known(-3e-7, 1e-12),
        speed_scale: known(0.0, 0.01),
        road_angle_scale: None,
        error_correlations: [0.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.1, 0.0, 0.0],
    }
}

#[test]
fn files() {
    let whole = text(&learned(), "car").unwrap().into_bytes();
    check(&whole);
    let after_checksum = whole.iter().position(|byte| *byte == b'\n').unwrap() + 1;
    let seeds = [whole[after_checksum..].to_vec()];
    let mutator = Mutator { seeds: &seeds, words: &WORDS, longest: 10_000 };
    fuzz(
        "state",
        4000,
        |dice| {
            let mut file = sealed(&mutator.make(dice));
            if dice.once_in(10) {
                let place = dice.below(file.len());
                file[place] ^= 1 << dice.below(8);
            }
            file
        },
        |file| check(file),
    );
}

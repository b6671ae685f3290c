//! GIVEN Sim2, stiffness and friction halved from 100 to 150 s, and sensors as an ESP has them WHEN one steers
//! gently or until the tires slide THEN the joint filter has the cornering stiffness before the change, and again
//! five seconds after each.

use gripd::estimate::thesis::lateral_filter::LateralFilterConfig;
use gripd::reproduce::sim2_grid::{AMPLITUDES, Cell, FREQUENCIES};
use testing::results::Section;

fn print(cell: &Cell) {
    let percent = |f: &dyn Fn(usize) -> f64| [0, 1, 2].map(|i| format!("{:5.2}", 100.0 * f(i))).join(" ");
    let runs = cell.runs.len() as f64;
    let mean =
        |f: &dyn Fn(&gripd::reproduce::sim2_grid::Run) -> f64| cell.runs.iter().map(f).sum::<f64>() / runs;
    println!(
        "{:4} rad {:4} Hz: worst {} %, rms {} %, bound {} %; NIS {:.2} {:.2}, {:3.0} % within; settled {:.1} {:.1} s; \
         {:.1} changes",
        cell.amplitude,
        cell.frequency,
        percent(&|i| cell.worst(i)),
        percent(&|i| cell.rms(i)),
        percent(&|i| cell.bound[i]),
        mean(&|r| r.nis[0]),
        mean(&|r| r.nis[1]),
        100.0 * mean(&|r| r.within),
        cell.runs.iter().map(|r| r.settled_s[0]).fold(0.0, f64::max),
        cell.runs.iter().map(|r| r.settled_s[1]).fold(0.0, f64::max),
        mean(&|r| f64::from(r.changes)),
    );
}

#[test]
fn the_stiffness_is_followed_in_gentle_steering_and_in_sliding() {
    let config = LateralFilterConfig::ideal_road();
    for (amplitude, frequency) in [(0.01, 1.0), (0.02, 0.5), (0.1, 0.25), (0.1, 1.0)] {
        let cell = Cell::drive(amplitude, frequency, 2, &config).unwrap();
        print(&cell);
        for check in 0..3 {
            assert!(cell.worst(check) < 0.05, "{amplitude} {frequency} {check}: {}", cell.worst(check));
            assert!(cell.bound[check] < 0.02);
        }
        for run in &cell.runs {
            assert!(run.changes >= 2);
            assert!(run.nis.iter().all(|nis| (0.9..1.1).contains(nis)), "{:?}", run.nis);
            assert!(run.within > 0.8, "{}", run.within);
        }
    }
}

/// A bank may be there, the sensors' offsets are unknown: no tuning for a flat road.
#[test]
fn with_the_defaults_for_real_roads_too() {
    let cell = Cell::drive(0.05, 0.5, 2, &LateralFilterConfig::default()).unwrap();
    print(&cell);
    assert!((0..3).all(|check| cell.worst(check) < 0.05));
}

mod by_hand {
    use super::*;

    /// The whole grid; for the numbers.
    #[test]
    #[ignore = "by hand: 25 s of a processor"]
    fn the_whole_grid() {
        let mut rows = Vec::new();
        for (name, config) in
            [("ideal road", LateralFilterConfig::ideal_road()), ("defaults", LateralFilterConfig::default())]
        {
            let (mut worst, mut rms) = ([0.0_f64; 3], [0.0_f64; 3]);
            for amplitude in AMPLITUDES {
                for frequency in FREQUENCIES {
                    let cell = Cell::drive(amplitude, frequency, 4, &config).unwrap();
                    print(&cell);
                    for check in 0..3 {
                        worst[check] = worst[check].max(cell.worst(check));
                        rms[check] = rms[check].max(cell.rms(check));
                    }
                    if name == "ideal road" {
                        assert!((0..3).all(|check| cell.worst(check) < 0.065 && cell.rms(check) < 0.03));
                    }
                }
            }
            let percent =
                |values: [f64; 3]| values.map(|value| format!("{:.1} %", 100.0 * value)).join(" | ");
            rows.push(format!("{name} | {} | {}", percent(worst), percent(rms)));
        }
        let section = Section {
            name: "sim2_joint",
            seed: "4 seeds a cell",
            tolerance: 0.02,
            header: "Sim2, joint filter, all amplitudes and frequencies | worst before the change | 5 s after it | 5 s after \
                     the change back | rms before | after | after the change back",
        };
        section.check(&rows);
    }
}

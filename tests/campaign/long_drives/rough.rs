//! GIVEN two surfaces as soft as each other, one rough and one smooth WHEN the car goes from asphalt onto either THEN the
//! roughness tells them apart.

use gripd::Estimates;
use gripd::model::{Scenario, Truth};

use super::roads;
use testing::driven;

/// Begin, friction, slope and roughness (m/s) of each stretch.
const ROAD: [(f64, f64, f64, f64); 4] =
    [(0.0, 1.0, 95.0, 0.01), (60.0, 0.6, 50.0, 0.12), (120.0, 1.0, 95.0, 0.01), (180.0, 0.3, 50.0, 0.0)];
const END_S: f64 = 240.0;
/// What is known has settled so long after a change, s.
const SETTLED_S: f64 = 20.0;

fn scenario() -> Scenario {
    let inputs = roads::holding(&[[0.0, 18.0]], 4.0) + &roads::wavering(0.1, 2.0, END_S);
    let mut scenario = roads::scenario(END_S, 18.0, &inputs, "");
    let asphalt = scenario.road[0].clone();
    let stretch = |&(from_s, friction, slope, roughness_mps): &(f64, f64, f64, f64)| {
        let mut stretch = asphalt.clone();
        (stretch.from_s, stretch.roughness_mps) = (from_s, roughness_mps);
        (stretch.friction, stretch.slope) = (Some(friction), Some(slope));
        stretch
    };
    scenario.road = ROAD.iter().map(stretch).collect();
    scenario
}

#[test]
fn gravel_is_told_from_snow_by_its_roughness() {
    let mut seen = [(0.0, 0.0, 0.0); ROAD.len()];
    let scenario = scenario();
    let take = |_: &gripd::Sample, truth: &Truth, now: &Estimates| {
        let t = truth.time.seconds();
        let place = ROAD.iter().rposition(|stretch| t >= stretch.0 + SETTLED_S);
        let (Some(place), Some(roughness)) = (place, now.roughness) else { return };
        if ROAD.get(place + 1).is_some_and(|next| t >= next.0) {
            return;
        }
        let (count, mean, std) = &mut seen[place];
        *count += 1.0;
        *mean += (roughness.value - *mean) / *count;
        *std += (roughness.std - *std) / *count;
    };
    driven::drive(&scenario, scenario.seed, roads::config(), &[], |reading| *reading, take);
    println!("count, roughness, its deviation: {seen:.3?}");
    let [asphalt, gravel, again, snow] = seen;
    for (count, ..) in seen {
        assert!(count > 2000.0, "{seen:?}");
    }
    assert!((gravel.1 / 0.12 - 1.0).abs() < 0.3, "{seen:?}");
    for smooth in [asphalt, again, snow] {
        assert!(gravel.1 - smooth.1 > 5.0 * (gravel.2 + smooth.2), "{seen:?}");
    }
}

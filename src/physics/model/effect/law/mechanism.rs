//! What in a car could make a law: the forms that its known parts have.

use super::{Law, Place};

/// A part of a car, where it acts, and what it follows.
struct Mechanism {
    words: &'static str,
    places: &'static [Place],
    /// Features' names; of those with brackets the beginnings.
    follows: &'static [&'static str],
}

const fn by(words: &'static str, places: &'static [Place], follows: &'static [&'static str]) -> Mechanism {
    Mechanism { words, places, follows }
}

use Place::{
    FrontSlipAngle as FRONT, FrontStiffness, LateralAcceleration, LateralForce, RearSlipAngle as REAR,
    RearStiffness, Stiffness, YawMoment, YawRate,
};

const RADII: &[Place] = &[Place::Radius(0), Place::Radius(1), Place::Radius(2), Place::Radius(3)];
const GRIP: &[Place] = &[FrontStiffness, RearStiffness, Stiffness];

/// After Reimpell, The Automotive Chassis (ch. 3, 4 and 6), Gillespie, Fundamentals of Vehicle Dynamics (ch. 4, 6 and 8),
/// and Pacejka, Tire and Vehicle Dynamics (ch. 1, 4 and 5). The likelier first.
static ALL: &[Mechanism] = &[
    by(
        "a pull under braking or drive: unequal brakes, a scrub radius, bushings that give way on one side",
        &[FRONT, REAR, YawMoment, LateralForce],
        &["a_x", "min(a_x", "max(a_x"],
    ),
    by(
        "toe that changes with brake or drive forces: bushings along the car",
        &[FRONT, REAR],
        &["a_x", "min(a_x", "max(a_x", "a_y*a_x", "a_y*min(a_x", "delta*a_x"],
    ),
    by(
        "bump steer: the nose dives or lifts, and the linkage turns the wheels",
        &[FRONT, REAR],
        &["a_x", "min(a_x", "v^2"],
    ),
    by(
        "a road that is banked or crowned all the way, or wheels out of alignment",
        &[FRONT, REAR, LateralForce],
        &["v", "t"],
    ),
    by("rear wheels that are steered with the front ones", &[REAR], &["delta", "memory(delta"]),
    by(
        "a steering whose ratio changes with the angle, or Ackermann's geometry",
        &[FRONT],
        &["delta*|delta|", "delta^3", "delta"],
    ),
    by(
        "a steering column or rack that gives way, or a power steering that lags",
        &[FRONT],
        &["a_y", "memory(delta", "memory(a_y", "beta"],
    ),
    by(
        "roll steer: the body leans, and the linkage turns the wheels",
        &[FRONT, REAR],
        &["a_y", "memory(a_y"],
    ),
    by("bushings that give way to side forces", &[FRONT, REAR], &["a_y", "a_y*|a_y|", "a_y^3", "beta"]),
    by(
        "camber that changes as the body leans",
        &[FRONT, REAR, LateralForce],
        &["a_y", "a_y*|a_y|", "memory(a_y"],
    ),
    by("tires that lose grip as loads move to the outer wheels", GRIP, &["|a_y|", "a_y^2"]),
    by(
        "loads that move between the axles under braking and drive",
        &[FrontStiffness, RearStiffness],
        &["a_x", "min(a_x", "max(a_x"],
    ),
    by("grip that brakes or drive take away (the friction ellipse)", GRIP, &["a_x", "min(a_x", "max(a_x"]),
    by("tires that heat up or cool down", GRIP, &["memory(v*", "t"]),
    by("brakes that heat the tires", GRIP, &["memory(v*max(-a_x"]),
    by("a road that dries, gets wet, or is another one", GRIP, &["t"]),
    by("downforce or lift", GRIP, &["v^2", "v"]),
    by("a slow loss of air", &[FrontStiffness, RearStiffness], &["t"]),
    by(
        "side forces of the air: a body, a box or a wing far from the centre of gravity",
        &[LateralForce, YawMoment, REAR],
        &["beta*v^2", "beta*v", "beta"],
    ),
    by(
        "a differential that locks, or drive torque that is shared between the sides",
        &[YawMoment],
        &["r", "r/v", "r*a_x", "a_y*a_x", "delta*a_x"],
    ),
    by(
        "brakes that steer (a stability program)",
        &[YawMoment],
        &["a_y*min(a_x", "r*a_x", "beta", "r", "delta"],
    ),
    by(
        "tires' own aligning moments, or turning on the spot of twin axles",
        &[YawMoment],
        &["delta/v", "r/v", "beta", "a_y"],
    ),
    by("a trailer, a hanging or a sloshing load", &[LateralForce, YawMoment, REAR], &["resonance(a_y"]),
    by(
        "a body that rocks on its springs",
        &[LateralForce, YawMoment, FRONT, REAR, LateralAcceleration],
        &["resonance(a_y", "memory(a_y"],
    ),
    by("a load that slides in curves", &[YawMoment, REAR, FRONT], &["memory(a_y, 8", "memory(a_y, 1"]),
    by("a sensor that leans with the body and feels gravity", &[LateralAcceleration], &["a_y", "memory(a_y"]),
    by(
        "an accelerometer ahead of or behind where it is thought to be",
        &[LateralAcceleration],
        &["r*v", "resonance(a_y", "delta"],
    ),
    by(
        "a sensor that is turned, and feels the other axis",
        &[LateralAcceleration],
        &["a_x", "min(a_x", "max(a_x"],
    ),
    by(
        "a scale that is wrong, or not the same at large values",
        &[YawRate, LateralAcceleration],
        &["r", "a_y", "a_y*|a_y|", "a_y^3"],
    ),
    by("a sensor that is filtered or late", &[YawRate, LateralAcceleration], &["memory(", "delta"]),
    by("a zero that moves with time or heat", &[YawRate, LateralAcceleration], &["t", "memory(v*"]),
    by("a gyroscope that feels accelerations", &[YawRate], &["a_x", "a_y", "a_y^2", "|a_y|"]),
    by("a tire that loses air", RADII, &["t"]),
    by("a tire that grows with speed", RADII, &["v^2"]),
    by(
        "a tire that is pressed by its load: load transfer in curves, under braking and drive",
        RADII,
        &["a_y", "a_x"],
    ),
    by("a tire that grows with heat and pressure", RADII, &["memory(v*", "t"]),
    by("slip that goes with drive and brake forces", RADII, &["a_x"]),
];

impl Law {
    /// What in a car could make it, in words; the likelier first. Nothing where no known part has this form.
    pub fn mechanisms(self) -> Vec<&'static str> {
        let feature = self.feature.name();
        let follows = |it: &str| if it.contains('(') { feature.starts_with(it) } else { feature == it };
        let could =
            |it: &&Mechanism| it.places.contains(&self.place) && it.follows.iter().any(|it| follows(it));
        ALL.iter().filter(could).map(|it| it.words).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::effect::law::Feature;

    /// GIVEN the table THEN each of its lines is about some law, and each beginning is one of a feature.
    #[test]
    fn each_line_is_of_a_law() {
        for it in ALL {
            for start in it.follows {
                let of =
                    |law: Law| law.feature.name().starts_with(start) && law.mechanisms().contains(&it.words);
                assert!(Law::all().any(of), "{}: {start}", it.words);
            }
        }
    }

    #[test]
    fn known_laws_have_their_mechanism() {
        let law =
            |place, name: &str| Law { place, feature: Feature::all().find(|it| it.name() == name).unwrap() };
        let first = |place, name: &str| law(place, name).mechanisms().first().copied().unwrap_or_default();
        assert!(first(FRONT, "a_x").starts_with("a pull under braking"));
        assert!(first(REAR, "delta").starts_with("rear wheels"));
        assert!(first(Stiffness, "memory(v*|a_y|, 90 s)").starts_with("tires that heat"));
        assert!(first(YawMoment, "resonance(a_y, 0.6 Hz)").starts_with("a trailer"));
        assert!(first(Place::Radius(2), "t").starts_with("a tire that loses air"));
        assert!(!law(FRONT, "a_x").mechanisms().iter().any(|it| it.contains("roll steer")));
        assert_eq!(law(YawRate, "beta*|beta|").mechanisms(), Vec::<&str>::new());
    }
}

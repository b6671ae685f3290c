//! Why the filter contradicts itself.

use std::fmt;

use super::{CorneringEstimator, FRONT, REAR};

/// The first reason not to believe what the lateral filter says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Sensors contradict each other, or did a moment ago.
    Sensors,
    /// A window's slip angle was not what the filter expected.
    Surprise {
        /// Whose.
        axle: Axle,
        /// By so many of its standard deviations, positive: too little for the force.
        deviations: f64,
    },
    /// What an axle measures is further off than the filter believes, and has been for a while.
    TooSure {
        /// Whose.
        axle: Axle,
        /// Mean square of the normalized innovations; 1 where all is well.
        nis: f64,
    },
    /// An axle measures with a noise that is no sensor's.
    Noise {
        /// Whose.
        axle: Axle,
        /// Standard deviation, in those that the data sheets promise.
        times: f64,
    },
}

/// Where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axle {
    /// The front one.
    Front,
    /// The rear one.
    Rear,
}

impl fmt::Display for Axle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::Front { "front" } else { "rear" })
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensors => f.write_str("sensors contradict each other"),
            Self::Surprise { axle, deviations } => write!(
                f,
                "the {axle} axle's slip angle was {:.1} standard deviations {} than its force explains",
                deviations.abs(),
                if *deviations > 0.0 { "less" } else { "more" }
            ),
            Self::TooSure { axle, nis } => {
                write!(f, "the {axle} axle has been off by {:.1} times what is believed", nis.sqrt())
            }
            Self::Noise { axle, times } => {
                write!(f, "the {axle} axle measures {times:.0} times as noisily as its sensors should")
            }
        }
    }
}

impl CorneringEstimator {
    /// Innovations are not about as large as the filter believes, on the whole or lately, or the noise it had to
    /// assume for that is no sensor's.
    pub fn doubt(&self) -> Option<Doubt> {
        if self.surprise >= Self::DOUBTFUL {
            return Some(self.surprised_by);
        }
        let places = [(Axle::Front, FRONT), (Axle::Rear, REAR)];
        places.into_iter().find_map(|(axle, place)| {
            let noise = &self.axles[place - FRONT].noise;
            let (nis, scale) = (noise.nis(), noise.scale());
            let beyond = |number: f64, limit: f64| number >= limit || number.is_nan();
            if beyond(nis, self.config.inconsistent_nis) {
                Some(Doubt::TooSure { axle, nis })
            } else if beyond(scale, Self::NOISE_LIMIT) {
                Some(Doubt::Noise { axle, times: scale.sqrt() })
            } else {
                None
            }
        })
    }
}

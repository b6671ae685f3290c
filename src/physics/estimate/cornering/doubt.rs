//! Why the filter contradicts itself.

use std::fmt;

/// The first reason not to believe what the lateral filter says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Sensors contradict each other, or did a moment ago.
    Sensors,
    /// Two sensors, or what they measure by way of the car, disagree.
    Disagreement {
        /// Their names, and the unit of the numbers.
        sensors: [&'static str; 3],
        /// By how much (rms) …
        off: f64,
        /// … of how much that there is (rms).
        of: f64,
        /// For how long, s.
        lasts_s: f64,
        /// Which of them is left out, where others tell.
        left_out: Option<&'static str>,
    },
    /// A sensor's readings come later than another's.
    Late {
        /// The late one, and the other.
        sensors: [&'static str; 2],
        /// By how much, s, …
        by_s: f64,
        /// … and for how long, s.
        lasts_s: f64,
        /// Which of them is left out, where others tell.
        left_out: Option<&'static str>,
    },
    /// One axle seems to have become stiffer, the other not.
    Apart {
        /// Factor of the front axle's stiffness over the rear one's, against what it was.
        factor: f64,
        /// For how long, s.
        lasts_s: f64,
    },
    /// A window's innovation was beyond the gate.
    Surprise {
        /// Whose.
        axle: Axle,
        /// By so many of its standard deviations, positive: too little for the force.
        deviations: f64,
    },
    /// The innovations of an axle have been larger than expected for a while.
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

fn without(f: &mut fmt::Formatter<'_>, left_out: Option<&str>) -> fmt::Result {
    left_out.map_or(Ok(()), |sensor| write!(f, "; the motion is known without {sensor}"))
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensors => f.write_str("sensors contradict each other"),
            Self::Disagreement { sensors: [one, other, unit], off, of, lasts_s, left_out } => {
                write!(
                    f,
                    "{one} and {other} disagree by {off:.2} {unit} of {of:.2} {unit}, for {lasts_s:.1} s"
                )?;
                without(f, *left_out)
            }
            Self::Late { sensors: [late, early], by_s, lasts_s, left_out } => {
                write!(f, "{late} comes at least {by_s:.2} s after {early}, for {lasts_s:.1} s")?;
                without(f, *left_out)
            }
            Self::Apart { factor, lasts_s } => write!(
                f,
                "the front tires seem {factor:.2} times as stiff as they were against the rear ones, for {lasts_s:.1} s: \
                 a sensor has changed, perhaps the steering_wheel_angle"
            ),
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

/// Counts surprises.
#[derive(Clone, Copy, Debug)]
pub struct Surprises {
    /// Rises by two with each window that surprises, falls by one with each that does not.
    count: u32,
    /// What surprised last.
    last: Doubt,
}

impl Surprises {
    /// With so many the filter is doubted, until two windows have not surprised. Tuned with the test `faults`.
    const DOUBTFUL: u32 = 2;
    /// More than three windows that surprise count as three. Tuned with the test `faults`.
    const MOST: u32 = 6;

    /// None so far.
    pub const NONE: Self = Self { count: 0, last: Doubt::Sensors };

    /// As many as count: sensors contradict each other.
    pub const CONTRADICTION: Self = Self { count: Self::MOST, last: Doubt::Sensors };

    /// Something surprised.
    pub fn by(&mut self, surprise: Doubt) {
        self.last = surprise;
    }

    /// A window has ended.
    pub fn end_window(&mut self, surprised: bool) {
        self.count = if surprised { self.count + 2 } else { self.count.saturating_sub(1) };
        self.count = self.count.min(Self::MOST);
    }

    /// What surprised, while it counts.
    pub fn doubt(&self) -> Option<Doubt> {
        (self.count >= Self::DOUBTFUL).then_some(self.last)
    }
}

//! What quantities are called: by English, German, French and Italian names and by the abbreviations of car makers.
//!
//! The words were collected from public DBC files of eight makes and from dictionaries; none of them says more
//! than "this may be it".

mod quantities;

use super::words::Words;
use physics::Quantity;

/// How a quantity is spoken of: a word of each of the groups, and none of the others.
pub(super) struct Vocabulary {
    /// One word of each, in the signal's name, its comment or the message's name.
    pub(super) groups: &'static [&'static [&'static str]],
    /// Words that make it more likely.
    pub(super) better: &'static [&'static str],
    /// Words that make it less likely.
    pub(super) worse: &'static [&'static str],
    /// Words with which it is something else.
    pub(super) not: &'static [&'static str],
}

/// What tells *about* a value, or is asked for and not measured.
pub(super) const NO_MEASUREMENT: &[&str] = &[
    "req*",
    "rq",
    "rqst",
    "cmd",
    "command*",
    "soll~",
    "target*",
    "tgt",
    "desired",
    "des",
    "wunsch~",
    "limit*",
    "lim",
    "max",
    "min",
    "mn",
    "mx",
    "fault*",
    "falt",
    "flt",
    "fehler~",
    "error",
    "err",
    "fail*",
    "stat",
    "status",
    "sta",
    "state",
    "qf",
    "qbit",
    "qb",
    "qual*",
    "valid*",
    "vld",
    "cnt",
    "counter",
    "cs",
    "crc",
    "chk*",
    "chksum",
    "checksum*",
    "zaehler~",
    "offset",
    "offst",
    "ofs",
    "init*",
    "warn*",
    "lamp*",
    "mode",
    "mde",
    "display",
    "dsply",
    "disp",
    "hud",
    "ui",
    "set",
    "vz",
    "sign",
    "vorz*",
    "alive",
    "delta",
    "diff",
    "grad",
    "gradient",
    "druckgradient",
    "bremsdruckgradient",
    "thresh*",
    "threshold",
    "std",
    "var",
    "trailer",
    "trlr",
    "hitch",
    "lead",
    "obj*",
    "lane",
    "gps",
    "nav*",
    "anf",
    "anforderung*",
    "reserved*",
    "reservd*",
    "frei",
    "verbauliste",
    "timer",
    "index",
    "predict*",
    "lka",
    "lkas",
    "adas",
    "ldws",
];

/// The same for flags, which may be called a status or a lamp themselves.
pub(super) const NO_FLAG: &[&str] = &[
    "req*",
    "rq",
    "rqst",
    "cmd",
    "anf",
    "anforderung*",
    "fault*",
    "falt",
    "flt",
    "fehler~",
    "error",
    "err",
    "fail*",
    "qf",
    "qbit",
    "qb",
    "qual*",
    "valid*",
    "vld",
    "cnt",
    "counter",
    "cs",
    "crc",
    "chk*",
    "checksum*",
    "warn*",
    "diag*",
    "def",
    "defekt",
    "unplausibel",
    "park*",
    "pbrake*",
    "prk*",
    "dcnnt",
    "trlr",
    "epb",
    "handbr*",
    "hold",
    "fluid",
    "fluessig*",
    "wear",
    "belag~",
    "acc",
    "aeb",
    "anb",
    "awv*",
    "fcw",
    "cmbb",
    "lscmbb",
    "lsmc*",
    "emerg*",
    "notbrems~",
    "temp*",
    "bremsentemp",
    "pad",
    "disc",
    "assist",
    "hazard",
    "asr",
    "regen",
    "rgen*",
    "trailer",
    "anhaenger",
    "aag",
    "asp",
    "maybe",
    "thresh*",
    "mod*",
    "pla",
    "stab*",
    "ecd",
    "wip*",
    "frei",
    "verbauliste",
    "disable*",
    "off",
    "avail*",
    "enable*",
    "freigabe*",
    "teilbremsung",
    "bremsruck*",
    "hdc",
    "auto*",
    "timeout",
    "deact*",
    "prchg",
    "prefill",
    "timer",
    "out",
    "dis",
    "deny",
    "decel",
    "nm",
    "uds",
];

/// Of a quantity; all wheels have the same.
pub(super) fn of(quantity: Quantity) -> &'static Vocabulary {
    match quantity {
        Quantity::WheelSpeedFl | Quantity::WheelSpeedFr | Quantity::WheelSpeedRl | Quantity::WheelSpeedRr => {
            &quantities::WHEEL_SPEED
        }
        Quantity::YawRate => &quantities::YAW_RATE,
        Quantity::LateralAcceleration => &quantities::LATERAL,
        Quantity::SteeringWheelAngle => &quantities::STEERING,
        Quantity::LongitudinalAcceleration => &quantities::LONGITUDINAL,
        Quantity::DriveTorque => &quantities::DRIVE_TORQUE,
        Quantity::BrakeTorque => &quantities::BRAKE_TORQUE,
        Quantity::BrakePressure => &quantities::BRAKE_PRESSURE,
        Quantity::VehicleSpeed => &quantities::VEHICLE_SPEED,
        Quantity::BrakeActive => &quantities::BRAKE_ACTIVE,
        Quantity::AbsActive => &quantities::ABS_ACTIVE,
    }
}

/// The three places where a signal is spoken of.
pub(super) struct Spoken {
    pub(super) signal: Words,
    pub(super) comment: Words,
    pub(super) message: Words,
}

impl Vocabulary {
    /// How much the words speak for it, 0 to 1.
    pub(super) fn score(&self, spoken: &Spoken, flag: bool) -> f64 {
        let mut score = 1.0;
        let mut own = false;
        for group in self.groups {
            let (weight, here) = if spoken.signal.any(group) {
                (1.0, true)
            } else if spoken.comment.any(group) {
                (0.85, true)
            } else if spoken.message.any(group) {
                (0.65, false)
            } else {
                return 0.0;
            };
            score *= weight;
            own |= here;
        }
        let none = if flag { NO_FLAG } else { NO_MEASUREMENT };
        if !own || spoken.signal.any(none) || spoken.signal.any(self.not) {
            return 0.0;
        }
        if spoken.message.any(none) || spoken.message.any(self.not) {
            score *= 0.7;
        }
        if spoken.signal.any(self.worse) || spoken.message.any(self.worse) {
            score *= 0.75;
        }
        // Words of which nothing is known may turn it into anything.
        let strangers = spoken.signal.others(self.groups).min(6);
        let is_better = spoken.signal.any(self.better) || spoken.message.any(self.better);
        if !is_better && strangers > 0 {
            score *= 0.9;
        }
        score * (1.0 - 0.015 * strangers as f64)
    }
}

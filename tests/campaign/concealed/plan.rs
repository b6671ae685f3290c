//! What is put into which drive, how strong, and by whom.

/// A real drive.
#[derive(Clone, Copy)]
pub struct Drive {
    pub config: &'static str,
    pub name: &'static str,
    /// Healthy drives of the same car on the same road.
    pub references: &'static [&'static str],
}

/// Drives of one car on a lot; it turns to the left only. Each is asked what it has that the next three have not.
pub const HEALTHY: [&str; 14] = [
    "group8controller",
    "group4controller",
    "group1controller",
    "group10controller",
    "group11controller",
    "group12controller",
    "group2controller",
    "group5controller",
    "group1lookahead",
    "group3lookahead",
    "group5lookahead",
    "group7lookahead",
    "group10lookahead",
    "group132020controller",
];

/// On the lot, with three references that are none of them.
const LOT: [&str; 8] = [
    "gti/group8controller",
    "gti/group4controller",
    "gti/group2controller",
    "gti/group11controller",
    "gti/group3lookahead",
    "gti/group12controller",
    "gti/group5lookahead",
    "gti/group7lookahead",
];
const REFERENCES: [&str; 3] = ["group1controller", "group5controller", "group1lookahead"];

/// Alone of their kind: two laps, and two of another car.
const OTHERS: [Drive; 4] = [
    Drive { config: "gti/laps.toml", name: "gti/dry4", references: &[] },
    Drive { config: "tts/car.toml", name: "tts/aa", references: &[] },
    Drive { config: "gti/laps.toml", name: "gti/wet1", references: &[] },
    Drive { config: "tts/car.toml", name: "tts/ad", references: &[] },
];

/// An effect in four sizes. `{}` stands for the size.
pub struct Effect {
    pub name: &'static str,
    pub channel: Option<&'static str>,
    /// Its main number, as `explain` calls it.
    pub number: &'static str,
    /// Rising; the second is about what is usual.
    sizes: [f64; 4],
    /// Of `gripd conceal`.
    own: &'static str,
    /// Of the tool with the recordings, if it knows the effect …
    tool: Option<&'static str>,
    /// … and whether the number is the tool's as well: not where it adds to what the car has of its own.
    is_tools_number: bool,
}

pub const EFFECTS: [Effect; 14] = [
    Effect {
        name: "tire_radius",
        channel: None,
        number: "relative_difference_rl",
        sizes: [-0.005, -0.01, -0.015, -0.03],
        own: "kind = 'tire_radius', relative_difference_rl = {}",
        tool: Some("tire_radius wheel=2 relative={}"),
        is_tools_number: true,
    },
    Effect {
        name: "sensor_bias",
        channel: Some("yaw_rate"),
        number: "bias",
        sizes: [0.01, 0.02, 0.03, 0.06],
        own: "kind = 'sensor_bias', channel = 'yaw_rate', bias = {}, at_s = 30",
        tool: Some("sensor_bias channel=yaw_rate bias={} from=30"),
        is_tools_number: true,
    },
    Effect {
        name: "sensor_scale",
        channel: Some("yaw_rate"),
        number: "relative_error",
        sizes: [0.03, 0.06, 0.1, 0.15],
        own: "kind = 'sensor_scale', channel = 'yaw_rate', relative_error = {}",
        tool: Some("sensor_scale channel=yaw_rate relative={}"),
        is_tools_number: true,
    },
    Effect {
        name: "sensor_delay",
        channel: Some("yaw_rate"),
        number: "delay_s",
        sizes: [0.03, 0.05, 0.08, 0.15],
        own: "kind = 'sensor_delay', channel = 'yaw_rate', delay_s = {}",
        tool: None,
        is_tools_number: true,
    },
    Effect {
        name: "sensor_drift",
        channel: Some("yaw_rate"),
        number: "drift_rms",
        sizes: [0.005, 0.01, 0.02, 0.04],
        own: "kind = 'sensor_drift', channel = 'yaw_rate', drift_rms = {}",
        tool: Some("sensor_drift channel=yaw_rate rms={}"),
        is_tools_number: true,
    },
    Effect {
        name: "accelerometer_position",
        channel: None,
        number: "forward_of_cg_m",
        sizes: [0.5, 1.0, 1.5, 2.5],
        own: "kind = 'accelerometer_position', forward_of_cg_m = {}",
        tool: Some("accelerometer_position ahead={}"),
        is_tools_number: true,
    },
    Effect {
        name: "relaxation_length",
        channel: None,
        number: "length_m",
        sizes: [0.8, 1.1, 1.5, 2.0],
        own: "kind = 'relaxation_length', length_m = {}",
        tool: Some("relaxation_length length={}"),
        is_tools_number: false,
    },
    Effect {
        name: "steering_compliance",
        channel: None,
        number: "compliance_rad_per_nm",
        sizes: [1e-4, 2e-4, 3e-4, 4e-4],
        own: "kind = 'steering_compliance', compliance_rad_per_nm = {}",
        tool: Some("steering_compliance rad_per_kn={}"),
        is_tools_number: false,
    },
    Effect {
        name: "steering_ratio",
        channel: None,
        number: "curvature_per_rad2",
        sizes: [0.003, 0.01, 0.02, 0.03],
        own: "kind = 'steering_ratio', curvature_per_rad2 = {}",
        tool: Some("steering_ratio curvature={}"),
        is_tools_number: false,
    },
    Effect {
        name: "payload",
        channel: None,
        number: "mass_kg",
        sizes: [150.0, 250.0, 350.0, 500.0],
        own: "kind = 'payload', mass_kg = {}, position_behind_cg_m = 1.2",
        tool: Some("payload mass={} behind=1.2"),
        is_tools_number: true,
    },
    Effect {
        name: "friction_change",
        channel: None,
        number: "friction",
        sizes: [0.8, 0.65, 0.5, 0.4],
        own: "kind = 'friction_change', friction = {}, intervals = [[25, 40]]",
        // Times what the road has.
        tool: Some("friction_change factor={} from=25 to=40"),
        is_tools_number: false,
    },
    Effect {
        name: "cg_shift",
        channel: None,
        number: "shift_m",
        sizes: [0.06, 0.12, 0.18, 0.25],
        own: "kind = 'cg_shift', shift_m = {}, at_s = 30",
        tool: None,
        is_tools_number: true,
    },
    Effect {
        name: "crosswind",
        channel: None,
        number: "force_rms_n",
        sizes: [300.0, 600.0, 900.0, 1500.0],
        own: "kind = 'crosswind', force_rms_n = {}",
        tool: Some("crosswind rms={}"),
        is_tools_number: true,
    },
    Effect {
        name: "road_bank",
        channel: None,
        number: "bank_rms_rad",
        sizes: [0.02, 0.04, 0.06, 0.1],
        own: "kind = 'road_bank', bank_rms_rad = {}",
        tool: Some("road_bank rms={}"),
        is_tools_number: true,
    },
];

/// Who puts it in.
#[derive(Clone, Copy, PartialEq)]
pub enum By {
    Gripd,
    Tool,
}

/// One drive with one effect.
pub struct Case {
    pub drive: Drive,
    pub effect: &'static Effect,
    /// Which of its sizes.
    pub size: usize,
    pub by: By,
}

impl Case {
    /// As its maker is told of it.
    pub fn told(&self) -> String {
        let size = self.effect.sizes[self.size];
        match self.by {
            By::Gripd => self.effect.own.replace("{}", &size.to_string()),
            By::Tool => {
                // Per kN of side force, not per moment; the trail is 0.05 m.
                let size = if self.effect.name == "steering_compliance" { 50.0 * size } else { size };
                self.effect.tool.unwrap_or_default().replace("{}", &size.to_string())
            }
        }
    }

    /// What its main number should be found to be; none where that is the drive's.
    pub fn expected(&self) -> Option<f64> {
        let is_plain = self.by == By::Gripd || self.effect.is_tools_number;
        is_plain.then_some(self.effect.sizes[self.size])
    }
}

/// Each effect in each size on two drives of the lot, of which one has references but for the smallest size, and in three
/// sizes on another road; those first that are most likely to show.
pub fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    for size in [2, 3, 1, 0] {
        for (number, effect) in EFFECTS.iter().enumerate() {
            let tool = if effect.tool.is_some() { By::Tool } else { By::Gripd };
            for (place, by) in [(0, By::Gripd), (1, tool)] {
                let name = LOT[(2 * number + 3 * size + 5 * place) % LOT.len()];
                // Of what is usual by gripd, of what is larger by the other tool.
                let has_references = size > 0 && (place == 1) == (size > 1);
                let references: &[&str] = if has_references { &REFERENCES } else { &[] };
                let drive = Drive { config: "gti/drives.toml", name, references };
                all.push(Case { drive, effect, size, by });
            }
            if size > 0 {
                let by = if (number + size) % 3 == 0 { By::Gripd } else { tool };
                all.push(Case { drive: OTHERS[(number + size) % OTHERS.len()], effect, size, by });
            }
        }
    }
    all
}

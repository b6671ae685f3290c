//! What the user tells, as options: the car's class and numbers, and signals by name.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::sizes::Size;
use crate::cli::Failure;
use bus::dbc::Database;
use bus::propose::{CarClass, Place, Wishes};
use physics::Quantity;
use physics::model::{DrivenAxle, Uncertain};

/// The car. Numbers may have a deviation: 1600+-50.
#[derive(Args, Debug, Default)]
pub struct Answers {
    /// What kind of car it is, for all that nobody tells [default: midsize].
    #[arg(long, value_parser = PossibleValuesParser::new(CarClass::ALL.map(CarClass::name))
        .try_map(|name| name.parse::<CarClass>()))]
    pub class: Option<CarClass>,
    /// The driven axle.
    #[arg(long, value_parser = PossibleValuesParser::new(DrivenAxle::ALL.map(DrivenAxle::name))
        .try_map(|name| DrivenAxle::named(&name).ok_or("no axle is called so")))]
    pub driven: Option<DrivenAxle>,
    /// Mass with driver and load, kg.
    #[arg(long, value_name = "KG", value_parser = |text: &str| Size::MASS.parse(text))]
    pub mass: Option<Uncertain>,
    /// Distance between the axles, m.
    #[arg(long, value_name = "M", value_parser = |text: &str| Size::WHEELBASE.parse(text))]
    pub wheelbase: Option<Uncertain>,
    /// From the front axle to the centre of gravity, m.
    #[arg(long, value_name = "M", value_parser = |text: &str| Size::CG_TO_FRONT.parse(text))]
    pub cg_to_front: Option<Uncertain>,
    /// Height of the centre of gravity, m.
    #[arg(long, value_name = "M", value_parser = |text: &str| Size::CG_HEIGHT.parse(text))]
    pub cg_height: Option<Uncertain>,
    /// Track width of both axles, m.
    #[arg(long, value_name = "M", value_parser = |text: &str| Size::TRACK.parse(text))]
    pub track: Option<Uncertain>,
    /// Rolling radius of the tires, m.
    #[arg(long, value_name = "M", value_parser = |text: &str| Size::WHEEL_RADIUS.parse(text))]
    pub wheel_radius: Option<Uncertain>,
    /// Steering wheel angle over road wheel angle.
    #[arg(long, value_name = "RATIO", value_parser = |text: &str| Size::STEERING_RATIO.parse(text))]
    pub steering_ratio: Option<Uncertain>,
}

impl Answers {
    /// What was told, by the keys of `[vehicle]`.
    pub fn told(&self) -> Vec<(&'static str, Uncertain)> {
        let all = [
            ("mass_kg", self.mass),
            ("wheelbase_m", self.wheelbase),
            ("cg_to_front_m", self.cg_to_front),
            ("cg_height_m", self.cg_height),
            ("track_front_m", self.track),
            ("track_rear_m", self.track),
            ("wheel_radius_m", self.wheel_radius),
            ("steering_ratio", self.steering_ratio),
        ];
        all.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
    }
}

/// `--signal`: each quantity with its place in the database, or with none.
pub fn wishes(signals: &[String], database: &Database) -> Result<Wishes, Failure> {
    let mut wishes = Wishes::new();
    for wish in signals {
        let fail = |why: String| Failure::Usage(format!("--signal {wish}: {why}"));
        let (quantity, name) = wish
            .split_once('=')
            .ok_or_else(|| fail("write QUANTITY=MESSAGE.Signal, or QUANTITY=none".into()))?;
        let quantity: Quantity = quantity.trim().parse().map_err(|_| {
            let names: Vec<_> = Quantity::ALL.iter().map(|quantity| quantity.name()).collect();
            fail(format!("there is no quantity `{quantity}`; there are {}", names.join(", ")))
        })?;
        let place = match name.trim() {
            "none" => None,
            name => Some(Place::of(database, name).ok_or_else(|| {
                // Says what is nearest.
                let error = database.signal(name).err().map(|error| error.to_string());
                fail(error.unwrap_or_else(|| "there is no such signal in the DBC".into()))
            })?),
        };
        if wishes.insert(quantity, place).is_some() {
            return Err(fail("it is named twice".into()));
        }
    }
    Ok(wishes)
}

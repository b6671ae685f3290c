//! How an explanation searches for an effect.

use crate::Quantity;

/// How the influence of an effect grows with its main number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// In proportion: a small step shows all of it.
    Proportional,
    /// With curvature, a threshold or a limit: large steps show what a small one does not.
    Nonlinear,
    /// With the square: to first order it shows hardly at all, however large it is.
    Quadratic,
}

/// What the plain model and the recording must have for an effect to be told from the ordinary numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing in particular.
    Nothing,
    /// Tires without a limit of their own.
    LinearTire,
    /// Drive and brake torques.
    KnownTorque,
}

/// What is usual of an effect that not every car has.
#[derive(Clone, Copy, Debug)]
pub struct Usual {
    /// Of this channel alone; none: of any.
    pub of: Option<Quantity>,
    /// Its main numbers are within these.
    pub bounds: (f64, f64),
}

/// Statistical: standard deviations, which a number that lies at a bound passes once in forty times.
const SURELY: f64 = 2.0;

impl Usual {
    /// May all of them be within? Each is a value and its standard deviation: what is not surely beyond is usual.
    pub fn holds(&self, mut numbers: impl Iterator<Item = (f64, f64)>) -> bool {
        let (low, high) = self.bounds;
        numbers.all(|(value, std)| value + SURELY * std >= low && value - SURELY * std <= high)
    }
}

/// How an explanation searches for an effect.
#[derive(Clone, Copy, Debug)]
pub struct SearchHints {
    /// Channels of which it is not searched: an ordinary number or another effect does the same.
    pub not_of: &'static [Quantity],
    /// What there must be to tell it.
    pub needs: Needs,
    /// How its influence grows.
    pub growth: Growth,
    /// Each of its numbers is a candidate without the others: one wheel has another radius, not four.
    pub each_number_alone: bool,
    /// Of a kind with an onset: it is searched from the start of the recording, too. Others that are there from the
    /// start are ordinary numbers.
    pub from_start: bool,
    /// Its numbers beside the size are shares, of which nothing and all are as likely as what lies between.
    pub has_whole_shares: bool,
    /// Every car has some of it: finding it is nothing unusual.
    pub every_car_has: bool,
    /// Of what not every car has: little of it is nothing unusual either.
    pub usual: Option<Usual>,
    /// Of a torque's channel: the smallest main number that is worth a finding.
    pub least_of_torque: Option<f64>,
}

impl SearchHints {
    /// The search for most effects.
    pub const USUAL: Self = Self {
        not_of: &[],
        needs: Needs::Nothing,
        growth: Growth::Nonlinear,
        each_number_alone: false,
        from_start: false,
        has_whole_shares: false,
        every_car_has: false,
        usual: None,
        least_of_torque: None,
    };
}

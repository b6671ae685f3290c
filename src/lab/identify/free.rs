//! What is searched for, in coordinates in which a search finds its way.

use super::parameter::{Parameter, Values};

/// A free parameter: where it is in the search's own coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free {
    pub(super) parameters: Tied,
    /// Prior of the coordinate.
    pub(super) mean: f64,
    /// Zero information where infinite.
    pub(super) std: f64,
}

/// A parameter, or the stiffnesses of both axles as one (thesis: C_F = C_R).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tied {
    One(Parameter),
    BothLateral,
}

impl Tied {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::One(parameter) => parameter.name(),
            Self::BothLateral => "lateral_stiffness",
        }
    }

    /// The one that stands for it.
    pub(super) fn first(self) -> Parameter {
        match self {
            Self::One(parameter) => parameter,
            Self::BothLateral => Parameter::LateralFront,
        }
    }

    /// Sets its value.
    pub(super) fn put(self, values: &mut Values, value: f64) {
        for parameter in Parameter::ALL.into_iter().filter(|parameter| self.is(*parameter)) {
            values.set(parameter, value);
        }
    }

    /// Do both have a parameter in common?
    pub(super) fn overlaps(self, other: Self) -> bool {
        Parameter::ALL.into_iter().any(|parameter| self.is(parameter) && other.is(parameter))
    }

    pub(super) fn is(self, parameter: Parameter) -> bool {
        match self {
            Self::One(one) => one == parameter,
            Self::BothLateral => matches!(parameter, Parameter::LateralFront | Parameter::LateralRear),
        }
    }

    /// From the parameter's unit to the search's coordinate.
    pub(super) fn coordinate(self, value: f64) -> f64 {
        let first = self.first();
        if first.is_logarithmic() { value.ln() } else { value / first.scale() }
    }

    /// What it can be at all.
    pub(super) fn coordinate_bounds(self) -> (f64, f64) {
        let (low, high) = self.first().bounds();
        (self.coordinate(low), self.coordinate(high))
    }

    /// And back, to what it can be: a bound exactly, though its logarithm's exponential is not.
    pub(super) fn value(self, coordinate: f64) -> f64 {
        let first = self.first();
        let ((low, high), (lowest, highest)) = (first.bounds(), self.coordinate_bounds());
        if coordinate <= lowest {
            low
        } else if coordinate >= highest {
            high
        } else if first.is_logarithmic() {
            coordinate.exp()
        } else {
            coordinate * first.scale()
        }
    }

    /// Derivative of the value by the coordinate.
    pub(super) fn value_by_coordinate(self, coordinate: f64) -> f64 {
        let first = self.first();
        if first.is_logarithmic() { coordinate.exp() } else { first.scale() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_come_back_exactly() {
        for tied in Parameter::ALL.map(Tied::One) {
            let (low, high) = tied.coordinate_bounds();
            assert_eq!((tied.value(low), tied.value(high)), tied.first().bounds(), "{}", tied.name());
        }
    }
}

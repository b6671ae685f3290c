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
    /// What it can be, in its unit.
    pub(super) bounds: (f64, f64),
}

impl Free {
    /// What it can be, in the search's coordinate.
    pub(super) fn coordinate_bounds(&self) -> (f64, f64) {
        let (low, high) = self.bounds;
        (self.parameters.coordinate(low), self.parameters.coordinate(high))
    }

    /// From the coordinate to the parameter's unit, to what it can be: a bound exactly, though its logarithm's exponential
    /// is not.
    pub(super) fn value(&self, coordinate: f64) -> f64 {
        let first = self.parameters.first();
        let ((low, high), (lowest, highest)) = (self.bounds, self.coordinate_bounds());
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
        for parameter in Parameter::ALL {
            let bounds = parameter.bounds();
            let free = Free { parameters: Tied::One(parameter), mean: 0.0, std: 1.0, bounds };
            let (low, high) = free.coordinate_bounds();
            assert_eq!((free.value(low), free.value(high)), bounds, "{}", parameter.name());
        }
    }
}

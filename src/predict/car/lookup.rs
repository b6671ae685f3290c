//! The magic formula from a table. A filter evaluates it a hundred thousand times with the same shape.

use physics::model::tire::{Curve, MagicFormula, Shape, Tire};

/// Curve and inverse of stiffness 1 and friction 1; all others are the same, scaled.
#[derive(Debug)]
pub(super) struct Lookup {
    of: MagicFormula,
    force: Table,
    slip: Table,
}

/// A tire at pure slip, looked up if there is a table of it.
pub(super) struct LookedUp<'a> {
    pub(super) tire: &'a Tire,
    pub(super) lookup: Option<&'a Lookup>,
}

impl LookedUp<'_> {
    #[inline]
    fn table(&self) -> Option<&Lookup> {
        self.lookup.filter(|lookup| matches!(self.tire, Tire::MagicFormula(own) if lookup.of == *own))
    }
}

impl Curve for LookedUp<'_> {
    #[inline]
    fn force(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let plain = || self.tire.force(stiffness, friction, slip);
        self.table().map_or_else(plain, |table| table.force(stiffness, friction, slip))
    }

    #[inline]
    fn slip(&self, stiffness: f64, friction: f64, force: f64) -> f64 {
        let plain = || self.tire.slip(stiffness, friction, force);
        self.table().map_or_else(plain, |table| table.slip(stiffness, friction, force))
    }
}

/// Slips and forces up to these are looked up; beyond they are rare.
const LARGEST_SLIP: f64 = 4.0;
const LARGEST_FORCE: f64 = 0.9;

/// Pieces of each table: cubic ones, so that they err by less than 1e-7.
const PIECES: usize = 128;

impl Lookup {
    pub(super) fn new(of: MagicFormula) -> Self {
        let slope = |slip| of.slope(1.0, 1.0, slip);
        let force = Table::new(LARGEST_SLIP, |slip| (of.force(1.0, 1.0, slip), slope(slip)));
        let slip = Table::new(LARGEST_FORCE, |force| {
            let slip = of.slip(1.0, 1.0, force);
            (slip, 1.0 / slope(slip))
        });
        Self { of, force, slip }
    }

    /// [`Curve::force`].
    fn force(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let scaled = stiffness / friction * slip;
        self.force
            .at(scaled)
            .map_or_else(|| self.of.force(stiffness, friction, slip), |force| friction * force)
    }

    /// [`Curve::slip`].
    fn slip(&self, stiffness: f64, friction: f64, force: f64) -> f64 {
        let scaled = force / friction;
        let slip = self.slip.at(scaled).map(|slip| slip * friction / stiffness);
        slip.unwrap_or_else(|| self.of.slip(stiffness, friction, force))
    }
}

/// An odd function by cubic pieces with the right slopes at their ends.
#[derive(Debug)]
struct Table {
    per_piece: f64,
    /// Value, and slope times the length of a piece.
    knots: Vec<[f64; 2]>,
}

impl Table {
    fn new(largest: f64, of: impl Fn(f64) -> (f64, f64)) -> Self {
        let length = largest / PIECES as f64;
        let knot = |i: usize| {
            let (value, slope) = of(i as f64 * length);
            [value, slope * length]
        };
        Self { per_piece: 1.0 / length, knots: (0..=PIECES).map(knot).collect() }
    }

    /// Its value, within the table.
    fn at(&self, x: f64) -> Option<f64> {
        let place = x.abs() * self.per_piece;
        let piece = place as usize;
        let [[y0, d0], [y1, d1]] = *self.knots.get(piece..piece.checked_add(2)?)? else { return None };
        let (s, rise) = (place - piece as f64, y1 - y0);
        let value = y0 + s * (d0 + s * (3.0 * rise - 2.0 * d0 - d1 + s * (d0 + d1 - 2.0 * rise)));
        Some(value.copysign(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_looked_up_is_the_formula(
            shape in 1.0..1.9,
            curvature in -2.0..0.9,
            k in 5.0..60.0,
            mu in 0.1..1.2, share in -0.99..0.99,
        ) {
            let of = MagicFormula { shape, curvature };
            let lookup = Lookup::new(of);
            let slip: f64 = of.slip(k, mu, share * mu);
            prop_assert!((lookup.slip(k, mu, share * mu) - slip).abs() < 1e-6 * slip.abs() + 1e-9);
            let error: f64 = lookup.force(k, mu, slip) - share * mu;
            prop_assert!(error.abs() < 1e-6);
        }
    }
}

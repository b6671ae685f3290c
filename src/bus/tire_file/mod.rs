//! Tires as tire property files (`.tir`) have them: read into a `[vehicle]` table, and written from one.
//!
//! The format is that of the MF-Tyre models 5.2 and 6.1: sections in brackets, `KEY = value` lines, comments behind `$`
//! or `!`. The equations are those of H. B. Pacejka, *Tire and Vehicle Dynamics*, 3rd edition 2012, chapter 4.3, at pure
//! slip, without camber and without turn slip. Of a wheel's load F, the nominal load F₀ and d = (F − F₀) / F₀ they are,
//! at nominal inflation pressure:
//!
//! ```text
//! C        PCY1 LCY                                        F₀ = LFZO FNOMIN
//! μ        (PDY1 + PDY2 d) LMUY
//! E        (PEY1 + PEY2 d) LEY, at most 1
//! K_y      |PKY1| F₀ sin(PKY4 atan(F / (PKY2 F₀))) LKY     N/rad; PKY4 is 2 where it is not given
//! K_x      F (PKX1 + PKX2 d) exp(PKX3 d) LKX               N per unit slip
//! ```
//!
//! Only these are read, and INFLPRES, NOMPRES, PPX1, PPX2, PPY1 to PPY4 for another inflation pressure. What is not the
//! same for a left and a right tire (shifts by ply steer and conicity, PEY3) is left out: over an axle it cancels. So is
//! what the plain car does not have: camber, combined slip, moments, relaxation, radii under load. The slip angle goes in
//! as an angle, in rad. The plain car has one curve for both directions, that of the lateral force.
//!
//! PKY1 may have either sign: files in the usual axes (ISO) have a negative one, and so do those written here.

mod entries;
mod error;
#[cfg(feature = "desk")]
mod page;
mod tire;
#[cfg(feature = "desk")]
mod write;

pub use error::TireFileError;
pub use tire::{AtLoad, TireFile};
#[cfg(feature = "desk")]
pub use write::{About, Axle, Written, of_vehicle};

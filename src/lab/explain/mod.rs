//! Explains where a recording and the physics of the plain model disagree.
//!
//! ```text
//! Recording ─► GriddedDrive ─┐
//! [vehicle] ─► Model ────────┴─► fit (plain model) ─► naming (scan, refit) ─► select ─► locate, proof ─► Explanation
//!                                 └ predict: one filter, many cars              └ correction: unknown forces
//! ```
//!
//! The audit of the measurement [`chain`] comes first. Then the plain model is fitted with all its uncertain numbers
//! free, by the likelihood of its predictions. A filter holds it to the recording as tightly as the noise of sensors
//! and equations allows; both are learnt from the data. So what the model misses shows as process noise.
//!
//! Every candidate effect is scored after the ordinary numbers have explained what they can. The best are fitted with
//! everything else, and the most probable one is taken. Then the next one is searched, until held-out data confirm
//! none.

mod align;
mod answer;
#[cfg(test)]
mod bench;
mod candidates;
mod case;
pub mod chain;
mod changed;
mod conclusion;
mod confirm;
mod correction;
mod course;
mod dates;
mod disturbed;
mod doubt;
mod excerpt;
mod exogenous;
mod explanation;
mod finding;
mod fit;
pub mod found;
mod held_out;
mod history;
mod lateness;
mod learn;
mod left_out;
mod locate;
mod long_recording;
mod model;
mod naming;
mod next_drive;
pub mod ordinary;
mod other_tires;
mod patches;
mod play;
mod precedence;
mod proof;
mod put_right;
mod result;
mod select;
mod sensitivity;
mod shape;
mod signs_and_swaps;
mod smooth;
mod split;
mod throughout;
mod tuning;
mod used;
mod verdict;
mod verify;
mod whole_car;
mod work;

pub use case::{Answer, Case};
pub use confirm::{Confirmed, Fits};
pub use dates::begins;
pub use history::{Change, Drive, History, InDrive, Order, Unchanged, order};
pub use model::{Chosen, Model};
pub use ordinary::{Incomparable, Simulated, speed_of};
pub use predict::{Recording, Work};
pub use result::{
    Block, ByChannel, Chance, CourseEstimate, Disturbance, Driven, Estimate, Explanation, Finding, FoundLaw,
    Missing, Models, Nature, OffBy, Parts, Ranked, SecondPass, Term, ToDrive, Trace, Verdict, Where, Without,
};
pub use sensitivity::{Detectable, Isolability, Rival, Sensitivity};
pub use used::{Unused, Used};
pub use verify::{Bin, Known, LeftOut, Outcome, Try, Verified};
pub use work::{FIT_STAGES, STAGES};

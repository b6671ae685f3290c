//! The compiled mapping as people check it: what stands behind a quantity, and what single frames say.

use super::inputs::Inputs;
use super::mapping::Reading;
use crate::can::{CanId, Frame};
use physics::{Micros, Quantity};

/// What the mapping makes of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Description<'a> {
    /// The message it comes in.
    pub message: &'a str,
    /// That message's identifier.
    pub id: CanId,
    /// SI units per unit of the DBC, gain included.
    pub to_si: f64,
    /// The finest step of the raw value, SI.
    pub resolution: f64,
    /// Lowest and highest value that the bits can carry, SI.
    pub carried: [f64; 2],
    /// Lowest and highest value that is taken for plausible, SI.
    pub plausible: [f64; 2],
    /// How late the value is in its frame.
    pub delay: Micros,
    /// Older than this the value is absent.
    pub timeout: Micros,
    /// Standard deviation of its noise, SI.
    pub noise_std: f64,
    /// Does the message have a counter that is watched?
    pub has_counter: bool,
    /// Does the message have a checksum that is verified?
    pub has_checksum: bool,
}

impl Inputs {
    /// How a quantity is mapped, if it is configured.
    pub fn describe(&self, quantity: Quantity) -> Option<Description<'_>> {
        let traits = self.traits[quantity as usize]?;
        let (message, mapping) = self.messages.iter().find_map(|message| {
            let mapping = message.mappings.iter().find(|mapping| mapping.quantity == quantity)?;
            Some((message, mapping))
        })?;
        let (mut low, mut high) = (0.0, 0.0);
        for part in &mapping.parts {
            let (from, to) = part.codec.range();
            low += part.to_si * from;
            high += part.to_si * to;
        }
        if mapping.sign.is_some() {
            low = -high;
        }
        let ends = [low, high].map(|end| mapping.gain * end + mapping.offset);
        Some(Description {
            message: &message.name,
            id: message.id,
            to_si: mapping.parts.first().map_or(f64::NAN, |part| part.to_si * mapping.gain),
            resolution: mapping.resolution(),
            carried: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            plausible: [traits.limits.min, traits.limits.max],
            delay: traits.delay,
            timeout: traits.timeout,
            noise_std: traits.noise_std,
            has_counter: message.counter.is_some(),
            has_checksum: message.checksum.is_some(),
        })
    }

    /// What a frame says of each quantity it carries, SI; `None` where it says "not available".
    ///
    /// Neither checksums nor counters nor limits are judged, and quality signals of other messages are
    /// not asked: that is the [`super::Sampler`]'s work. A frame that is too short says nothing.
    pub fn read(&self, frame: &Frame, take: &mut impl FnMut(Quantity, Option<f64>)) {
        let Ok(index) = self.ids().binary_search(&frame.id) else { return };
        let message = &self.messages[index];
        if !frame.is_data() || frame.data().len() < message.length {
            return;
        }
        for mapping in &message.mappings {
            match mapping.read(frame.data()) {
                Reading::NotInThisFrame => {}
                Reading::NotAvailable => take(mapping.quantity, None),
                Reading::Value(value) => take(mapping.quantity, Some(value)),
            }
        }
    }
}

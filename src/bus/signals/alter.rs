//! Changes quantities in frames that were recorded: the same mapping there and back, and no other bit touched.
//!
//! All frames are looked at first ([`Alterer::look`]), and changed then ([`Alterer::alter`]): only all of them tell how a
//! checksum is reckoned that nobody has configured, and what stands between two raw units.

use super::checks::Checksum;
use super::config::{CrcConfig, CrcKind, SignalsConfig};
use super::error::SignalsError;
use super::inputs::Inputs;
use super::mapping::{MessageInput, Reading};
use crate::can::{CanId, Frame, Payload};
use crate::dbc::Database;
use physics::{Micros, Quantity};

/// What a quantity shall be instead: of what, when (as it was true, not when its frame came), and what it was, SI.
pub type Change<'c> = &'c dyn Fn(Quantity, Micros, f64) -> f64;

/// Where a channel changes by less than so many of its raw units, rms, what the changed value is rounded to decides what
/// is left of the change.
const FINE_UNITS: f64 = 2.0;

/// Frames that a checksum must fit before it is believed.
const LEAST_FRAMES: u64 = 20;

/// What became of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Altered {
    /// Values that were there.
    pub readings: u64,
    /// Values whose bits are others now.
    pub changed: u64,
    /// Values that the bits cannot hold; they have the nearest that they can.
    pub clipped: u64,
    /// The smallest step of its signal, SI; 0 of floating point.
    pub step: f64,
    /// Are changes finer than the step made by what stood between the raw units?
    pub is_fine: bool,
    wanted_squares: f64,
    made_squares: f64,
    products: f64,
}

/// Changes what is configured in recorded frames.
#[derive(Clone, Debug)]
pub struct Alterer {
    messages: Vec<Message>,
    delays: [Micros; Quantity::COUNT],
    quantities: [Altered; Quantity::COUNT],
    frames: u64,
}

#[derive(Clone, Debug)]
struct Message {
    input: MessageInput,
    checksum: Guarded,
    /// For each mapping, the values that were seen …
    seen: Vec<Vec<f64>>,
    /// … what they stood above their raw units, where that matters …
    between: Vec<Vec<f64>>,
    /// … and how many of them have been changed so far.
    done: Vec<usize>,
    is_changed: bool,
}

/// How a message is guarded.
#[derive(Clone, Debug)]
enum Guarded {
    /// By what the configuration says, or by nothing.
    Known(Option<Checksum>),
    /// By a signal of this name; these may be how, and so many frames fitted them.
    Perhaps { signal: String, ways: Vec<(CrcKind, Checksum)>, frames: u64 },
}

impl Altered {
    /// Root of the mean square of the change that was wanted, SI.
    pub fn wanted_rms(&self) -> f64 {
        (self.wanted_squares / self.readings.max(1) as f64).sqrt()
    }

    /// How much of the wanted change the frames have, as a share: less than all where it is finer than the raw units, or
    /// does not fit them.
    pub fn kept(&self) -> f64 {
        if self.wanted_squares > 0.0 { self.products / self.wanted_squares } else { 1.0 }
    }

    /// Root of the mean square of the change as the frames have it, SI.
    pub fn rms(&self) -> f64 {
        (self.made_squares / self.readings.max(1) as f64).sqrt()
    }
}

impl Alterer {
    /// For the quantities of a configuration.
    ///
    /// # Errors
    /// What is wrong with the mapping, as for [`Inputs::compile`].
    pub fn compile(
        config: &SignalsConfig,
        database: &Database,
        wheel_radius_m: f64,
    ) -> Result<Self, SignalsError> {
        let inputs = Inputs::compile(config, database, wheel_radius_m)?;
        let delays = inputs.traits.map(|traits| traits.map_or(Micros(0), |traits| traits.delay));
        let mut quantities = [Altered::default(); Quantity::COUNT];
        for mapping in inputs.messages.iter().flat_map(|message| &message.mappings) {
            quantities[mapping.quantity as usize].step = mapping.step();
        }
        let messages = inputs.messages.into_iter().map(|input| Message::new(input, database)).collect();
        Ok(Self { messages, delays, quantities, frames: 0 })
    }

    /// Sees a frame as it is, and what would be wanted of it.
    pub fn look(&mut self, frame: &Frame, change: Change<'_>) {
        let Some(message) = self.messages.iter_mut().find(|message| message.input.id == frame.id) else {
            return;
        };
        if !message.carries(frame) {
            return;
        }
        message.checksum.look(frame.data());
        for (mapping, seen) in message.input.mappings.iter().zip(&mut message.seen) {
            let Reading::Value(value) = mapping.read(frame.data()) else { continue };
            let quantity = &mut self.quantities[mapping.quantity as usize];
            seen.push(value);
            quantity.readings += 1;
            let time = frame.time - self.delays[mapping.quantity as usize];
            let by = change(mapping.quantity, time, value) - value;
            quantity.wanted_squares += if by.is_finite() { by * by } else { 0.0 };
        }
    }

    /// All frames were seen; `seed` is of what has to be drawn. Returns what is to be said of messages that are guarded by
    /// what nobody knows.
    pub fn looked(&mut self, seed: u64) -> Vec<(CanId, String)> {
        for quantity in &mut self.quantities {
            quantity.is_fine = quantity.wanted_rms() < FINE_UNITS * quantity.step;
        }
        for message in &mut self.messages {
            let mappings = message.input.mappings.iter().zip(std::mem::take(&mut message.seen));
            let between = mappings.map(|(mapping, seen)| {
                let quantity = &self.quantities[mapping.quantity as usize];
                if quantity.is_fine { between_units(&seen, quantity.step, seed) } else { Vec::new() }
            });
            message.between = between.collect();
        }
        let untold = self.messages.iter_mut().map(|message| (message.input.id, message.settle()));
        untold.filter_map(|(id, words)| Some((id, words?))).collect()
    }

    /// The frame with what is wanted; none where it stays as it is.
    pub fn alter(&mut self, frame: &Frame, change: Change<'_>) -> Option<Frame> {
        let message = self.messages.iter_mut().find(|message| message.input.id == frame.id)?;
        // What nobody takes for right is not made right.
        if !message.carries(frame) {
            return None;
        }
        let is_guarded_wrong = message.checksum.known().is_some_and(|sum| !sum.is_right(frame.data()));
        let mut payload: Payload = [0; 64];
        let data = &mut payload[..frame.length()];
        data.copy_from_slice(frame.data());
        for (place, mapping) in message.input.mappings.iter().enumerate() {
            let Reading::Value(value) = mapping.read(frame.data()) else { continue };
            let number = message.done[place];
            message.done[place] += 1;
            let quantity = &mut self.quantities[mapping.quantity as usize];
            let time = frame.time - self.delays[mapping.quantity as usize];
            let wanted = change(mapping.quantity, time, value);
            if mapping.is_flag() || is_guarded_wrong || !wanted.is_finite() {
                continue;
            }
            let between = message.between[place].get(number).copied().unwrap_or(0.0);
            let goal = wanted + between;
            let half = 0.5 * quantity.step;
            if (goal - value).abs() <= half {
                continue;
            }
            mapping.put(data, goal);
            let Reading::Value(made) = mapping.read(data) else { continue };
            quantity.changed += u64::from(made != value);
            quantity.clipped += u64::from((made - goal).abs() > 1.001 * half + 1e-9 * goal.abs());
            quantity.made_squares += (made - value).powi(2);
            quantity.products += (made - value) * (wanted - value);
        }
        if data == frame.data() {
            return None;
        }
        if let Some(checksum) = message.checksum.known() {
            checksum.write(data);
        }
        self.frames += 1;
        message.is_changed = true;
        Frame::new(frame.time, frame.id, frame.kind, data).ok()
    }

    /// What became of a quantity.
    pub fn of(&self, quantity: Quantity) -> &Altered {
        &self.quantities[quantity as usize]
    }

    /// Was a frame of this message changed?
    pub fn has_changed(&self, id: CanId) -> bool {
        self.messages.iter().any(|message| message.input.id == id && message.is_changed)
    }

    /// Frames that were changed.
    pub fn frames(&self) -> u64 {
        self.frames
    }
}

impl Message {
    fn new(input: MessageInput, database: &Database) -> Self {
        let checksum = match &input.checksum {
            Some(checksum) => Guarded::Known(Some(checksum.clone())),
            None => Guarded::perhaps(database, &input).unwrap_or(Guarded::Known(None)),
        };
        let mappings = input.mappings.len();
        Self {
            input,
            checksum,
            seen: vec![Vec::new(); mappings],
            between: vec![Vec::new(); mappings],
            done: vec![0; mappings],
            is_changed: false,
        }
    }

    /// Is it a frame that the message's signals are read from?
    fn carries(&self, frame: &Frame) -> bool {
        frame.is_data() && frame.length() >= self.input.length
    }

    fn settle(&mut self) -> Option<String> {
        let Guarded::Perhaps { signal, ways, frames } = &self.checksum else { return None };
        let (way, untold) = match ways.first() {
            Some((kind, checksum)) if *frames >= LEAST_FRAMES => {
                tracing::debug!("{}.{signal} is a checksum of kind {kind:?}", self.input.name);
                (Some(checksum.clone()), None)
            }
            _ => {
                let name = &self.input.name;
                let words = format!(
                    "{name}.{signal} looks like a checksum that is not configured and of no kind that is known: it \
                     stays as it was; give a quantity of {name} crc = {{ signal = \"{name}.{signal}\", kind = … }}"
                );
                (None, Some(words))
            }
        };
        self.checksum = Guarded::Known(way);
        untold
    }
}

impl Guarded {
    /// A signal that fills a byte and is called a checksum, and the ways to reckon one that need no further numbers.
    fn perhaps(database: &Database, input: &MessageInput) -> Option<Self> {
        let message = database.message(&input.name)?;
        let is_called_so = |name: &str| {
            let name = name.to_lowercase();
            name.contains("checksum") || name.contains("chksum") || name.split('_').any(|word| word == "crc")
        };
        let signal = message.signals.iter().find(|signal| signal.size == 8 && is_called_so(&signal.name))?;
        let kinds = [CrcKind::Toyota, CrcKind::E2eP01a, CrcKind::Sum8, CrcKind::Xor8];
        let way = |kind: CrcKind| {
            let config = CrcConfig {
                signal: format!("{}.{}", message.name, signal.name),
                kind,
                // The usual choice where the specification leaves it open.
                data_id: (kind == CrcKind::E2eP01a).then_some(input.id.number() as u16),
                magic: Vec::new(),
                polynomial: None,
                init: None,
                xor_out: None,
                prefix: Vec::new(),
                suffix: Vec::new(),
            };
            Some((kind, Checksum::new(&config, message, signal.codec(), None).ok()?))
        };
        let ways = kinds.into_iter().filter_map(way).collect();
        Some(Self::Perhaps { signal: signal.name.clone(), ways, frames: 0 })
    }

    fn look(&mut self, data: &[u8]) {
        if let Self::Perhaps { ways, frames, .. } = self {
            ways.retain(|(_, checksum)| checksum.is_right(data));
            *frames += 1;
        }
    }

    fn known(&self) -> Option<&Checksum> {
        match self {
            Self::Known(checksum) => checksum.as_ref(),
            Self::Perhaps { .. } => None,
        }
    }
}

/// What each reading stood above its raw unit before it was rounded, as far as its neighbours tell: between two units
/// where the one changes to the other, on straight lines from there to the middle of a stretch of equal readings; how high
/// a top or how low a bottom was, nobody knows, so that is drawn. Always so little less than half a unit that what is not
/// changed stays as it is.
fn between_units(seen: &[f64], step: f64, seed: u64) -> Vec<f64> {
    let most = 0.499 * step;
    let mut all = Vec::with_capacity(seen.len());
    let edge =
        |here: f64, there: Option<&f64>| there.map_or(0.0, |there| (0.5 * (there - here)).clamp(-most, most));
    for stretch in seen.chunk_by(|one, other| one == other) {
        let (begin, length) = (all.len(), stretch.len());
        let here = stretch[0];
        let before = edge(here, begin.checked_sub(1).and_then(|place| seen.get(place)));
        let after = edge(here, seen.get(begin + length));
        let is_turn = before * after > 0.0;
        let middle = if is_turn { most * (2.0 * share(seed, begin as u64) - 1.0) } else { 0.0 };
        for place in 0..length {
            // From -1 at the beginning of the stretch to 1 at its end.
            let along = (2 * place + 1) as f64 / length as f64 - 1.0;
            let end = if along < 0.0 { before } else { after };
            let shape = if is_turn { along * along } else { along.abs() };
            all.push(middle + shape * (end - middle));
        }
    }
    all
}

/// A number of 0 to 1 for each seed and place (Steele, Lea & Flood 2014, SplitMix64).
fn share(seed: u64, place: u64) -> f64 {
    let mut bits = (seed.wrapping_add(1).wrapping_mul(0xD134_2543_DE82_EF95) ^ place)
        .wrapping_add(1)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((bits ^ bits >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounded, enlarged by a twentieth and rounded again, a slow signal of few raw units is larger by the most part of
    /// that; rounded to the nearest it would stay as it was.
    #[test]
    fn a_change_below_a_raw_unit_is_there_for_the_most_part() {
        let signal = |i: usize| 3.0 * (i as f64 * 0.004).sin() + 2.5 * (i as f64 * 0.0271).sin();
        let seen: Vec<f64> = (0..20_000).map(|i| signal(i).round()).collect();
        let between = between_units(&seen, 1.0, 1);
        let goal = |i: usize| (1.05 * seen[i] + between[i]).round();
        let of = |value: &dyn Fn(usize) -> f64| (0..seen.len()).map(|i| value(i) * seen[i]).sum::<f64>();
        let slope = of(&goal) / of(&|i| seen[i]);
        assert!((1.025..1.055).contains(&slope), "{slope}");
        assert!((0..seen.len()).all(|i| (seen[i] + between[i]).round() == seen[i]), "unchanged is unchanged");
    }
}

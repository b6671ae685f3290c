//! A recording as it goes by: every signal's mean over each tenth of a second, within bounded memory.

use std::collections::HashMap;

use super::beside;
use super::channel::Channel;
use super::source::Place;
use crate::can::{CanId, Frame};
use crate::dbc::{Codec, Database, ValueKind};
use physics::Micros;

/// Length of a bin.
const BIN: Micros = Micros::from_millis(100);
/// Bins of a stretch: whole stretches are left out where a recording is long.
const STRETCH: usize = 256;
/// Bins kept of each signal, 20 minutes; 48 KiB. Of a longer recording every second stretch is kept, of one
/// still longer every fourth.
const MOST: usize = 48 * STRETCH;

/// What a recording says of a database's signals, gathered frame by frame.
pub struct Drive {
    by_id: HashMap<CanId, Received>,
    /// The bin that is being filled.
    current: Option<i64>,
    /// Bins in each series.
    bins: usize,
    /// Bins that went by, kept or not.
    passed: usize,
    /// Of so many stretches one is kept.
    stride: usize,
    frames: u64,
}

/// One message's signals.
struct Received {
    length: usize,
    frames: u64,
    counter: Option<Counting>,
    channels: Vec<Channel>,
}

/// Does a counter count?
struct Counting {
    parts: Vec<Codec>,
    places: Vec<Place>,
    last: Option<u64>,
    most: u64,
    steps: u64,
    turns: u64,
    other: u64,
}

impl Drive {
    /// For a database.
    pub fn new(database: &Database) -> Self {
        let mut by_id = HashMap::new();
        for (message, content) in database.messages().iter().enumerate() {
            let channels = content.signals.iter().enumerate();
            let channels = channels.filter(|(_, signal)| signal.size <= 32 || is_float(signal.codec()));
            let channels = channels.map(|(signal, content)| {
                Channel::new(Place { message, signal }, content.codec(), content.mux().clone())
            });
            let parts = beside::counter(content);
            let counter = (!parts.is_empty()).then(|| Counting {
                parts: parts.iter().filter_map(|p| content.signals.get(*p)).map(|s| s.codec()).collect(),
                places: parts.into_iter().map(|signal| Place { message, signal }).collect(),
                last: None,
                most: 0,
                steps: 0,
                turns: 0,
                other: 0,
            });
            let received =
                Received { length: content.length, frames: 0, counter, channels: channels.collect() };
            by_id.insert(content.id, received);
        }
        Self { by_id, current: None, bins: 0, passed: 0, stride: 1, frames: 0 }
    }

    /// The next frame. Frames of other messages, and those that are too short, only move the time on.
    pub fn frame(&mut self, frame: &Frame) {
        self.advance(frame.time.0.div_euclid(BIN.0));
        let Some(received) = self.by_id.get_mut(&frame.id) else { return };
        let data = frame.data();
        if !frame.is_data() || data.len() < received.length {
            return;
        }
        self.frames += 1;
        if received.frames == 0 {
            // From here on it takes part; before, it was not there.
            for channel in &mut received.channels {
                channel.bins.resize(self.bins, f32::NAN);
            }
        }
        received.frames += 1;
        if let Some(counter) = &mut received.counter {
            counter.take(data);
        }
        for channel in &mut received.channels {
            channel.take(data);
        }
    }

    /// The recording is at its end; another one, or none, may follow.
    pub fn end_of_recording(&mut self) {
        self.close();
        self.blank();
        self.current = None;
    }

    /// Frames of messages that the database has.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    fn advance(&mut self, bin: i64) {
        match self.current {
            Some(current) if bin == current => {}
            // Clocks that jump back or far ahead are no reason to wait: what was, and a gap.
            Some(current) if bin < current || bin > current + 20 => {
                self.close();
                self.blank();
                self.current = Some(bin);
            }
            Some(current) => {
                for _ in current..bin {
                    self.close();
                }
                self.current = Some(bin);
            }
            None => self.current = Some(bin),
        }
    }

    /// Ends a bin.
    fn close(&mut self) {
        if self.current.is_some() {
            self.append(false);
        }
    }

    /// A bin that no line is drawn over, marked as infinite: what follows is not connected with what was.
    fn blank(&mut self) {
        if self.bins > 0 {
            self.append(true);
        }
    }

    fn append(&mut self, blank: bool) {
        let stretch = self.passed / STRETCH;
        let keep = stretch.is_multiple_of(self.stride);
        // The last bin of a stretch stays empty: the next one may be another time.
        let blank = blank || self.passed % STRETCH == STRETCH - 1;
        self.passed += 1;
        for channel in self.by_id.values_mut().filter(|r| r.frames > 0).flat_map(|r| &mut r.channels) {
            let mean = if channel.count > 0 { channel.sum / f64::from(channel.count) } else { f64::NAN };
            (channel.sum, channel.count) = (0.0, 0);
            if keep {
                channel.bins.push(if blank { f32::INFINITY } else { mean as f32 });
            }
        }
        self.bins += usize::from(keep);
        if self.bins >= MOST {
            self.thin();
        }
    }

    /// Every second stretch goes.
    fn thin(&mut self) {
        for channel in self.by_id.values_mut().flat_map(|r| &mut r.channels) {
            let mut place = 0;
            channel.bins.retain(|_| {
                place += 1;
                ((place - 1) / STRETCH).is_multiple_of(2)
            });
        }
        self.bins /= 2;
        self.stride *= 2;
    }

    /// The series of a signal, if its message came: a value for each tenth of a second, not a number where there
    /// is none. Gaps of up to a second are filled with the line between their ends.
    pub(super) fn series(&self, database: &Database, place: Place) -> Option<Vec<f64>> {
        let channel = self.channel(database, place)?;
        let mut series: Vec<f64> = channel.bins.iter().map(|value| f64::from(*value)).collect();
        fill(&mut series);
        Some(series)
    }

    /// The record of a signal, if its message came.
    pub(super) fn channel(&self, database: &Database, place: Place) -> Option<&Channel> {
        let received = self.by_id.get(&database.messages().get(place.message)?.id)?;
        (received.frames > 0).then(|| received.channels.iter().find(|c| c.place == place)).flatten()
    }

    /// The code that other signals of this size have all the time, if it could mean "not available" here, too: whoever
    /// writes it for what is not there writes it for all.
    pub(super) fn others_not_available(&self, channel: &Channel) -> Option<i64> {
        let kind = |channel: &Channel| (channel.codec.extractor.size(), channel.codec.kind);
        let own = channel.special.iter().flatten().filter(|special| special.neighbours == 0);
        let is_said = |bits: u64| {
            let others = self.by_id.values().flat_map(|received| &received.channels);
            let silent = others.filter(|other| other.values == 0 && kind(other) == kind(channel));
            let said =
                |other: &&Channel| other.special.iter().flatten().any(|s| s.bits == bits && s.times > 0);
            silent.filter(said).count() >= 2
        };
        let code = own.map(|special| special.bits).find(|bits| is_said(*bits))?;
        Some(channel.codec.integer(code))
    }

    /// Did the message come?
    pub(super) fn came(&self, database: &Database, place: Place) -> bool {
        let id = database.messages().get(place.message).map(|message| message.id);
        id.and_then(|id| self.by_id.get(&id)).is_some_and(|received| received.frames > 0)
    }

    /// The message's counter, if it counts by one: its parts, and at how much it starts over.
    pub(super) fn counter(&self, database: &Database, message: usize) -> Option<(&[Place], u64)> {
        let counter = self.by_id.get(&database.messages().get(message)?.id)?.counter.as_ref()?;
        let counts = counter.most > 0
            && counter.turns >= 3
            && counter.steps >= 50
            && counter.other * 20 < counter.steps;
        counts.then_some((counter.places.as_slice(), counter.most + 1))
    }
}

impl Counting {
    fn take(&mut self, data: &[u8]) {
        let mut value = 0;
        let mut shift = 0;
        for part in &self.parts {
            let Some(bits) = part.bits(data) else { return };
            value |= bits << shift;
            shift += part.extractor.size();
        }
        self.most = self.most.max(value);
        if let Some(last) = self.last {
            match value {
                v if v == last + 1 => self.steps += 1,
                0 if last == self.most => {
                    self.steps += 1;
                    self.turns += 1;
                }
                _ => self.other += 1,
            }
        }
        self.last = Some(value);
    }
}

fn is_float(codec: Codec) -> bool {
    matches!(codec.kind, ValueKind::Float32 | ValueKind::Float64)
}

/// Straight lines over gaps of up to ten bins.
fn fill(series: &mut [f64]) {
    let mut last: Option<usize> = None;
    for place in 0..series.len() {
        if series[place].is_nan() {
            continue;
        }
        if series[place].is_infinite() {
            series[place] = f64::NAN;
            last = None;
            continue;
        }
        if let Some(from) = last.filter(|from| (2..=10).contains(&(place - from))) {
            for bin in from + 1..place {
                let share = (bin - from) as f64 / (place - from) as f64;
                series[bin] = series[from] + share * (series[place] - series[from]);
            }
        }
        last = Some(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a signal of 16 bits says of its codes after these raw values.
    fn code(signal: &str, values: &[u16]) -> Option<i64> {
        let dbc = format!("BO_ 257 M: 2 X\n SG_ S : 0|16{signal} [0|0] \"m/s\" X\n");
        let database = Database::parse(dbc.as_bytes(), "car.dbc").unwrap();
        let mut drive = Drive::new(&database);
        let id = CanId::standard(257).unwrap();
        for (number, value) in values.iter().enumerate() {
            let time = Micros::from_millis(10 * number as i64);
            drive.frame(&Frame::data_frame(time, id, &value.to_le_bytes()).unwrap());
        }
        drive.end_of_recording();
        drive.channel(&database, Place { message: 0, signal: 0 }).unwrap().not_available()
    }

    #[test]
    fn a_code_is_one_only_where_no_measurement_comes_near_it() {
        assert_eq!(code("@1- (0.001,0)", &[10, 0x8000, 20]), Some(-0x8000));
        assert_eq!(code("@1- (0.001,0)", &[10, 0x8000, 0x8003]), None, "a range that is used up");
        assert_eq!(code("@1+ (0.01,0)", &[10, 0xFFFF, 20]), Some(0xFFFF));
        assert_eq!(code("@1+ (0.01,0)", &[10, 0x8000, 20]), Some(0x8000), "as if it had a sign");
        assert_eq!(code("@1+ (0.01,0)", &[10, 0x8000, 0x8100]), None, "a speed like others");
        assert_eq!(code("@1+ (0.01,-327.68)", &[10, 0x8000, 20]), None, "it is zero");
        assert_eq!(code("@1+ (0.01,0)", &[0x8000; 3]), Some(0x8000), "nothing but that");
        assert_eq!(code("@1+ (0.01,0)", &[10, 20]), None);
    }
}

//! What recordings hold: rates, gaps, stamps, noise and faults of each needed quantity.

use serde::Serialize;

use bus::can::recording::Reader;
use bus::can::{CanId, Frame};
use bus::signals::{Inputs, Pushed, Sampler};
use physics::time::Clock;
use physics::{Faults, Micros, Quantity};

use super::standing::Standing;
use std::collections::BTreeMap;

/// A value that stands still for longer than this is worth a line, s.
pub(super) const STUCK_S: f64 = 5.0;
/// So many stuck intervals are kept for each quantity.
const STUCK_KEPT: usize = 10;
/// An interval this many times the median is a gap and no jitter.
const GAP: f64 = 3.0;

/// All recordings together.
#[derive(Debug, Default, Serialize)]
pub struct RecordingReport {
    /// The files, in order.
    pub files: Vec<FileReport>,
    /// Frames, all identifiers.
    pub frames: u64,
    /// Share of frames with the very stamp of the frame before, whatever its identifier.
    pub batch_stamps: f64,
    /// Identifiers that were seen and are not needed.
    pub unneeded_ids: usize,
    /// Frames with these.
    pub unneeded_frames: u64,
    /// Every configured quantity.
    pub quantities: Vec<ChannelReport>,
    /// Messages that are needed.
    pub messages: Vec<MessageReport>,
    /// Faults as the service would count them.
    pub faults: BTreeMap<String, u64>,
    /// Uniform samples made.
    pub samples: u64,
    /// Intervals over which the car stood, all of its speeds near zero, s from the first frame.
    pub standing: Vec<[f64; 2]>,
    /// The same in UTC, where the stamps are dates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub standing_utc: Vec<[String; 2]>,
    /// From when on all seconds are counted.
    #[serde(skip)]
    pub clock: Clock,
}

impl RecordingReport {
    /// Did the car drive for a while in this interval? A car that is parked holds its steering wheel, too.
    pub fn is_while_driving(&self, [from, to]: &[f64; 2]) -> bool {
        let stood = self.standing.iter().map(|[begin, end]| (end.min(*to) - begin.max(*from)).max(0.0));
        to - from - stood.sum::<f64>() > STUCK_S
    }
}

/// One file.
#[derive(Debug, Serialize)]
pub struct FileReport {
    /// Its name.
    pub file: String,
    /// Its format.
    pub format: String,
    /// When it begins, in UTC, where its stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub begins_utc: Option<String>,
    /// First to last frame, s.
    pub seconds: f64,
    /// Frames.
    pub frames: u64,
    /// Lines (of BLF objects, of MF4 records) that could not be understood.
    pub skipped_lines: u64,
    /// The first of them, `line: reason`.
    pub first_skipped: Vec<String>,
    /// Frames that the recorder lost.
    pub dropped: u64,
    /// Frames older than the one before.
    pub time_backwards: u64,
    /// Why it could not be read to its end.
    pub broken: Option<String>,
}

/// One needed message.
#[derive(Debug, Serialize)]
pub struct MessageReport {
    /// Its name.
    pub message: String,
    /// Its identifier.
    pub id: String,
    /// Frames seen; zero: it never came.
    pub frames: u64,
    /// Dropped as too short, remote or of the wrong kind.
    pub wrong_frames: u64,
    /// Dropped for their checksum.
    pub checksum_failures: u64,
    /// Dropped as repeated by their counter.
    pub counter_repeats: u64,
}

/// One quantity, over all frames that carry it.
#[derive(Debug, Serialize)]
pub struct ChannelReport {
    /// Its name.
    pub quantity: &'static str,
    /// Frames that carried it.
    pub frames: u64,
    /// Median time between them, ms.
    pub period_ms: Option<f64>,
    /// Frames per second, from the median.
    pub rate_hz: Option<f64>,
    /// Standard deviation of the time between frames without gaps, ms.
    pub jitter_ms: Option<f64>,
    /// Longest time between two frames, s.
    pub longest_gap_s: Option<f64>,
    /// Where that was, s from the first frame of the recordings.
    pub longest_gap_at_s: Option<f64>,
    /// The same in UTC, where the stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_gap_at_utc: Option<String>,
    /// Share of frames with the very stamp of the one before.
    pub batch_stamps: f64,
    /// Share of frames that say "not available".
    pub not_available: f64,
    /// Lowest value, SI.
    pub min: Option<f64>,
    /// Highest value, SI.
    pub max: Option<f64>,
    /// Mean value, SI.
    pub mean: Option<f64>,
    /// Smallest change seen, SI.
    pub resolution_seen: Option<f64>,
    /// Standard deviation of the white part, from second differences, SI.
    pub white_noise_std: Option<f64>,
    /// Intervals over which the value did not change, s from the first frame.
    pub stuck: Vec<[f64; 2]>,
    /// The same in UTC, where the stamps are dates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stuck_utc: Vec<[String; 2]>,
}

/// Collects while frames pass.
pub struct Recorder {
    first: Option<Micros>,
    channels: BTreeMap<Quantity, Channel>,
    messages: BTreeMap<CanId, Message>,
    /// Frames of identifiers that are not needed.
    others: BTreeMap<CanId, u64>,
    last_time: Option<Micros>,
    same_stamp: u64,
    standing: Standing,
    report: RecordingReport,
}

#[derive(Default)]
struct Message {
    frames: u64,
    wrong: u64,
    checksum: u64,
    repeats: u64,
}

#[derive(Default)]
struct Channel {
    frames: u64,
    absent: u64,
    same_stamp: u64,
    last_time: Option<Micros>,
    /// Times between frames, µs.
    intervals: Vec<u32>,
    longest: Option<(i64, f64)>,
    count: u64,
    sum: f64,
    min: f64,
    max: f64,
    smallest_step: Option<f64>,
    /// The last two values.
    last: [Option<f64>; 2],
    /// Magnitudes of second differences.
    second: Vec<f32>,
    run: Option<(f64, f64)>,
    run_end: f64,
    stuck: Vec<[f64; 2]>,
}

impl Recorder {
    /// For a mapping.
    pub fn new(inputs: &Inputs) -> Self {
        let configured = Quantity::ALL.into_iter().filter(|quantity| inputs.has(*quantity));
        Self {
            first: None,
            channels: configured.map(|quantity| (quantity, Channel::default())).collect(),
            messages: inputs.ids().iter().map(|id| (*id, Message::default())).collect(),
            others: BTreeMap::new(),
            last_time: None,
            same_stamp: 0,
            standing: Standing::default(),
            report: RecordingReport::default(),
        }
    }

    /// Takes a frame, and what the sampler made of it.
    pub fn frame(&mut self, inputs: &Inputs, frame: &Frame, pushed: Pushed) {
        self.report.frames += 1;
        let first = *self.first.get_or_insert(frame.time);
        self.same_stamp += u64::from(self.last_time.replace(frame.time) == Some(frame.time));
        let Some(message) = self.messages.get_mut(&frame.id) else {
            *self.others.entry(frame.id).or_default() += 1;
            return;
        };
        message.frames += 1;
        if let Pushed::Dropped(faults) = pushed {
            message.wrong += u64::from(faults.contains(Faults::FRAME));
            message.checksum += u64::from(faults.contains(Faults::CHECKSUM));
            message.repeats += u64::from(faults.contains(Faults::COUNTER));
            if faults.intersects(Faults::FRAME | Faults::CHECKSUM) {
                return;
            }
        }
        let at = (frame.time - first).seconds();
        inputs.read(frame, &mut |quantity, value| {
            if let Some(value) = value {
                self.standing.take(quantity, at, value);
            }
            if let Some(channel) = self.channels.get_mut(&quantity) {
                channel.take(quantity, frame.time, at, value);
            }
        });
    }

    /// A file has ended.
    pub fn end_of_file(&mut self, reader: &Reader, broken: Option<String>) {
        let stats = reader.stats();
        let skipped = stats.first_skipped.iter().take(5);
        self.report.files.push(FileReport {
            file: reader.name().to_owned(),
            format: reader.format().to_string(),
            begins_utc: stats.first_time.and_then(|first| Clock::of(first).utc(0.0)),
            seconds: stats.seconds(),
            frames: stats.frames,
            skipped_lines: stats.skipped_lines,
            first_skipped: skipped.map(|line| format!("{}: {}", line.line, line.reason)).collect(),
            dropped: stats.dropped,
            time_backwards: stats.time_backwards,
            broken,
        });
        let end = self.first.zip(self.last_time).map_or(0.0, |(first, last)| (last - first).seconds());
        self.standing.end_of_file(end);
        for channel in self.channels.values_mut() {
            channel.end_run();
            channel.last_time = None;
            channel.last = [None; 2];
        }
    }

    /// The result.
    pub fn finish(mut self, sampler: &Sampler, samples: u64) -> RecordingReport {
        self.report.batch_stamps = self.same_stamp as f64 / self.report.frames.max(1) as f64;
        self.report.unneeded_ids = self.others.len();
        self.report.unneeded_frames = self.others.values().sum();
        self.report.samples = samples;
        self.report.standing = self.standing.intervals();
        let clock = Clock::of(self.first.unwrap_or_default());
        self.report.clock = clock;
        self.report.standing_utc = utc(clock, &self.report.standing);
        self.report.faults = sampler.counts().iter().collect();
        let name = |id| sampler.inputs().message_name(id).unwrap_or_default().to_owned();
        self.report.messages = self
            .messages
            .iter()
            .map(|(id, message)| MessageReport {
                message: name(*id),
                id: id.to_string(),
                frames: message.frames,
                wrong_frames: message.wrong,
                checksum_failures: message.checksum,
                counter_repeats: message.repeats,
            })
            .collect();
        self.report.quantities =
            self.channels.into_iter().map(|(quantity, channel)| channel.report(quantity, clock)).collect();
        self.report
    }
}

impl Channel {
    fn take(&mut self, quantity: Quantity, time: Micros, at: f64, value: Option<f64>) {
        self.frames += 1;
        if let Some(last) = self.last_time {
            let interval = (time - last).0;
            self.same_stamp += u64::from(interval == 0);
            if interval >= 0 {
                self.intervals.push(u32::try_from(interval).unwrap_or(u32::MAX));
                if self.longest.is_none_or(|(longest, _)| interval > longest) {
                    self.longest = Some((interval, at - 1e-6 * interval as f64));
                }
            }
        }
        self.last_time = Some(time);
        let Some(value) = value else {
            self.absent += 1;
            self.last = [None; 2];
            self.end_run();
            return;
        };
        (self.min, self.max) =
            if self.count == 0 { (value, value) } else { (self.min.min(value), self.max.max(value)) };
        self.count += 1;
        self.sum += value;
        if let [Some(before), last] = self.last {
            let step = (value - before).abs();
            if step > 1e-9 && self.smallest_step.is_none_or(|smallest| step < smallest) {
                self.smallest_step = Some(step);
            }
            if let Some(earlier) = last {
                self.second.push((value - 2.0 * before + earlier).abs() as f32);
            }
        }
        self.last = [Some(value), self.last[0]];
        match self.run {
            Some((_, level)) if level == value => self.run_end = at,
            _ => {
                self.end_run();
                // Zero is where wheels stand, and torques and pressures rest.
                if can_be_stuck(quantity) && !(value == 0.0 && quantity.wheel().is_some()) {
                    (self.run, self.run_end) = (Some((at, value)), at);
                }
            }
        }
    }

    fn end_run(&mut self) {
        if let Some((from, _)) = self.run.take()
            && self.run_end - from > STUCK_S
            && self.stuck.len() < STUCK_KEPT
        {
            self.stuck.push([from, self.run_end]);
        }
    }

    fn report(mut self, quantity: Quantity, clock: Clock) -> ChannelReport {
        let median = median(&mut self.intervals).map(f64::from);
        let white = median_of_second_differences(&mut self.second);
        let regular =
            |interval: &&u32| median.is_some_and(|median| f64::from(**interval) < GAP * median.max(1.0));
        let without_gaps: Vec<f64> = self.intervals.iter().filter(regular).map(|i| f64::from(*i)).collect();
        let any = |value: f64| (self.count > 0).then_some(value);
        let share = |count: u64| if self.frames > 0 { count as f64 / self.frames as f64 } else { 0.0 };
        ChannelReport {
            quantity: quantity.name(),
            frames: self.frames,
            period_ms: median.map(|us| 1e-3 * us),
            rate_hz: mean(&without_gaps).filter(|us| *us > 0.0).map(|us| 1e6 / us),
            jitter_ms: std(&without_gaps).map(|us| 1e-3 * us),
            longest_gap_s: self.longest.map(|(us, _)| 1e-6 * us as f64),
            longest_gap_at_s: self.longest.map(|(_, at)| at),
            longest_gap_at_utc: self.longest.and_then(|(_, at)| clock.utc(at)),
            batch_stamps: share(self.same_stamp),
            not_available: share(self.absent),
            min: any(self.min),
            max: any(self.max),
            mean: any(self.sum / self.count.max(1) as f64),
            resolution_seen: self.smallest_step,
            white_noise_std: white,
            stuck_utc: utc(clock, &self.stuck),
            stuck: self.stuck,
        }
    }
}

/// Stretches by the calendar.
fn utc(clock: Clock, stretches: &[[f64; 2]]) -> Vec<[String; 2]> {
    stretches.iter().filter_map(|stretch| clock.utc_of(*stretch)).collect()
}

/// Sensors that always move a little while the car drives.
fn can_be_stuck(quantity: Quantity) -> bool {
    quantity.is_required()
        || quantity.wheel().is_some()
        || matches!(quantity, Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration)
}

fn median<T: Copy + PartialOrd>(values: &mut [T]) -> Option<T> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, median, _) =
        values.select_nth_unstable_by(middle, |a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    Some(*median)
}

/// Second differences of white noise have six times its variance. The median keeps out the manoeuvres;
/// where most of them are zero (a coarse signal) the root mean square has to do.
fn median_of_second_differences(second: &mut [f32]) -> Option<f64> {
    const NORMAL_MEDIAN: f64 = 0.674_489_75;
    let median = f64::from(median(second)?);
    if median > 1e-9 {
        return Some(median / NORMAL_MEDIAN / 6f64.sqrt());
    }
    let squares: f64 = second.iter().map(|value| f64::from(*value).powi(2)).sum();
    Some((squares / second.len() as f64 / 6.0).sqrt())
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn std(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    Some((values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt())
}

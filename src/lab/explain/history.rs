//! Many drives in time order: since when something is different, and whether it grows. What `--history` says.

use serde::Serialize;

use super::ordinary::{OverDrives, Since};
use super::result::Estimate;
use predict::Recording;

/// The drives, and what changed on the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct History {
    /// By what the drives are in order.
    pub order: Order,
    /// The drives, the first one first.
    pub drives: Vec<Drive>,
    /// What has changed, as the findings are ordered.
    pub changes: Vec<Change>,
    /// What has not, with what would have been told.
    pub numbers: Vec<Unchanged>,
}

/// By what drives are in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// By their own clock.
    Recorded,
    /// As they were given: not all of them know the date, or two would have been driven at once.
    Given,
}

/// A drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drive {
    /// Its recording.
    pub log: String,
    /// When it begins, seconds since 1970; none where its stamps are no dates.
    pub begins: Option<f64>,
    /// The same in UTC.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub begins_utc: Option<String>,
    /// Was it given as a healthy one?
    pub is_reference: bool,
}

/// Something that is another one since a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Its name in the library, or the number of the car.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// The key of the number …
    pub parameter: String,
    /// … and its unit.
    pub unit: String,
    /// The first drive that has it …
    pub since: String,
    /// … and the first and the last one which that could be, with 95 % probability.
    pub since_ci: [String; 2],
    /// In each drive: of a number of the car its value, of an effect how much more there is of it than before.
    pub values: Vec<InDrive>,
    /// Does it grow on after that? None where it is in the last drive only.
    pub grows: Option<bool>,
    /// By how much from drive to drive, since then …
    pub trend_per_drive: Option<f64>,
    /// … and the 95 % interval of that.
    pub trend_ci95: Option<[f64; 2]>,
}

/// Something that is as it was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unchanged {
    /// Its name in the library, or the number of the car.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// The key of the number …
    pub parameter: String,
    /// … and its unit.
    pub unit: String,
    /// In each drive, as above.
    pub values: Vec<InDrive>,
    /// The smallest change from the middle of the drives on that would have been told with 90 % probability; none where
    /// nothing that a car has is large enough.
    pub told_from: Option<f64>,
    /// What it could be.
    pub ordinary: f64,
}

/// A number in one drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InDrive {
    /// The drive.
    pub log: String,
    /// Value.
    pub value: f64,
    /// Standard deviation, beside that of the other drives.
    pub std: f64,
}

/// Beyond so many times what it could be no car has it.
const MOST: f64 = 10.0;

/// When it begins, s since 1970, where its stamps are dates.
fn known(recording: &Recording) -> Option<f64> {
    recording.begins_s.filter(|_| recording.clock().date().is_some())
}

/// How drives are in order, and the place of each: by their own clock, where each has one of its own and no two were
/// driven at once.
pub fn order(recordings: &[Recording]) -> (Order, Vec<usize>) {
    let given: Vec<usize> = (0..recordings.len()).collect();
    let begins: Option<Vec<f64>> = recordings.iter().map(known).collect();
    let Some(begins) = begins else { return (Order::Given, given) };
    let mut places = given.clone();
    places.sort_by(|a, b| begins[*a].total_cmp(&begins[*b]));
    let follows = |pair: &[usize]| begins[pair[0]] + recordings[pair[0]].seconds() <= begins[pair[1]];
    if places.windows(2).all(follows) { (Order::Recorded, places) } else { (Order::Given, given) }
}

impl History {
    /// Of what the search says of these drives, which are in this order; `names` are those that could be used.
    pub(super) fn of(
        (recordings, references): (&[Recording], usize),
        names: &[String],
        found: &super::ordinary::History,
    ) -> Self {
        let drive = |(place, it): (usize, &Recording)| Drive {
            log: it.name.clone(),
            begins: known(it),
            begins_utc: it.clock().utc(0.0),
            is_reference: place < references,
        };
        let used = |(_, it): &(usize, &Recording)| names.contains(&it.name);
        Self {
            order: order(&recordings[references..]).0,
            drives: recordings.iter().enumerate().filter(used).map(drive).collect(),
            changes: found.changes.iter().map(|since| changed(since, names)).collect(),
            numbers: found.unchanged.iter().map(|it| unchanged(it, names)).collect(),
        }
    }

    /// Could the drives have told anything?
    pub(super) fn tells(&self) -> bool {
        !self.changes.is_empty()
            || self.numbers.iter().any(|it| it.told_from.is_some_and(|from| from <= it.ordinary))
    }
}

/// Effect and channel of a name.
fn parts(name: &str) -> (String, Option<String>) {
    let (effect, channel) = match name.split_once(':') {
        Some((effect, channel)) => (effect, Some(channel.to_owned())),
        None => (name, None),
    };
    (effect.split('.').next().unwrap_or_default().to_owned(), channel)
}

fn in_drives(it: &OverDrives, names: &[String]) -> Vec<InDrive> {
    let of = |(log, it): (&String, &Estimate)| InDrive { log: log.clone(), value: it.value, std: it.std };
    names.iter().zip(&it.values).map(of).collect()
}

fn changed(since: &Since, names: &[String]) -> Change {
    let name = |place: usize| names.get(place).cloned().unwrap_or_default();
    let (effect, channel) = parts(&since.number.name);
    Change {
        effect,
        channel,
        parameter: since.number.number.clone(),
        unit: since.number.unit.clone(),
        since: name(since.since),
        since_ci: since.since_ci.map(name),
        values: in_drives(&since.number, names),
        grows: since.grows,
        trend_per_drive: since.trend.map(|trend| trend.value),
        trend_ci95: since.trend.map(|trend| [-1.96, 1.96].map(|by| trend.value + by * trend.std)),
    }
}

fn unchanged(it: &OverDrives, names: &[String]) -> Unchanged {
    let (effect, channel) = parts(&it.name);
    Unchanged {
        effect,
        channel,
        parameter: it.number.clone(),
        unit: it.unit.clone(),
        values: in_drives(it, names),
        told_from: Some(it.told_from).filter(|from| *from < MOST * it.usual),
        ordinary: it.usual,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::Quantity;

    fn drive(name: &str, begins_s: Option<f64>) -> Recording {
        let mut recording = Recording { name: name.into(), begins_s, ..Recording::default() };
        recording.tracks[Quantity::YawRate as usize] = vec![(0.0, 0.0), (60.0, 0.0)];
        recording
    }

    #[test]
    fn drives_are_in_the_order_of_their_own_dates_where_they_have_such() {
        let day = |day: f64| Some(1.6e9 + 86_400.0 * day);
        let all = [drive("c", day(3.0)), drive("a", day(1.0)), drive("b", day(2.0))];
        assert_eq!(order(&all), (Order::Recorded, vec![1, 2, 0]));
        // Two at once have no clock of their own, seconds since a start are no date.
        let all = [drive("c", day(3.0)), drive("a", Some(1.6e9 + 3.0 * 86_400.0 + 30.0))];
        assert_eq!(order(&all), (Order::Given, vec![0, 1]));
        let all = [drive("c", Some(300.0)), drive("a", Some(10.0))];
        assert_eq!(order(&all), (Order::Given, vec![0, 1]));
        assert_eq!(order(&[drive("c", day(3.0)), drive("a", None)]).0, Order::Given);
    }
}

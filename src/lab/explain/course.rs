//! The smoothed course of a chosen effect, and the number that stands for it in the answer.

use std::collections::BTreeMap;

use super::candidates::Candidate;
use super::fit::Fit;
use super::result::{self, Estimate, Finding};
use super::smooth::{Smoothed, courses};
use super::tuning::TUNING;
use physics::model::effect;
use predict::noise::{Live, Noise};
use predict::{GriddedDrive, grid::points};

/// A course over the recording in which it is clearest.
#[derive(Clone, Debug)]
pub struct SmoothedCourse<'d> {
    /// That recording.
    pub drive: &'d GriddedDrive,
    smoothed: Smoothed,
    live: Live,
}

impl<'d> SmoothedCourse<'d> {
    /// Of one of a fit's effects, if it has one.
    pub fn new(
        drives: &'d [GriddedDrive],
        (fit, effect): (&Fit<'_>, usize),
        candidate: &Candidate,
        recording: &str,
    ) -> Option<Self> {
        let effect::Course::Live(slot) = fit.model.effects.get(effect)?.course else { return None };
        let drive = drives.iter().find(|drive| drive.name == recording).or(drives.first())?;
        let mut noise = fit.noise.clone();
        let smoothed =
            |noise: &Noise| courses(drive, &fit.model, noise, Default::default()).into_iter().nth(slot);
        let mut course = smoothed(&noise)?;
        let live = *noise.live.get(slot)?;
        if tells_its_peak(candidate) {
            noise.live[slot].size = live.size.max(course.peak() / TUNING.selection.peak_in_stds);
            course = smoothed(&noise)?;
        }
        Some(Self { drive, smoothed: course, live })
    }

    /// Where it is clearly not nothing, s.
    pub fn clear_stretches(&self) -> Vec<[f64; 2]> {
        let peak = self.smoothed.peak();
        self.smoothed.stretches(|value, std| value.abs() > (0.2 * peak).max(2.0 * std), 0.3, 0.15)
    }

    /// What it comes to in one number, under the contract's name.
    pub fn summarize(
        &self,
        candidate: &Candidate,
        (fit, effect): (&Fit<'_>, usize),
        parameters: &mut BTreeMap<String, Estimate>,
    ) {
        let Some(disturbance) = candidate.kind.disturbance(candidate.channel) else { return };
        let Smoothed { value, std, t } = &self.smoothed;
        let place_of_peak = value.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((peak_at, peak)) = place_of_peak.map(|(at, value)| (at, *value)) else { return };
        if disturbance.sign != 0.0 {
            // A share of a surface: what the surface is where there is most of it.
            let Some(chosen) = fit.model.effects.get(effect) else { return };
            for (place, spec) in chosen.specs().enumerate() {
                let all = chosen.numbers[place] - spec.mean;
                if all == 0.0 {
                    continue;
                }
                let coordinate = spec.mean + peak * all;
                let std = std[peak_at] * all.abs() * spec.scale.slope(coordinate).abs();
                parameters.insert(spec.name.into(), Estimate { value: spec.value(coordinate), std });
            }
            return;
        }
        let estimate = if tells_its_peak(candidate) {
            Estimate { value: peak.abs(), std: std[peak_at] }
        } else {
            let mean_square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>() / t.len() as f64;
            let variance = mean_square(std);
            // What the smoother cannot tell is in the course as well; it errs alike for a while.
            let seconds = t.last().zip(t.first()).map_or(0.0, |(last, first)| last - first);
            let independent = (seconds / (2.0 * self.live.length_s)).max(1.0);
            Estimate { value: (mean_square(value) + variance).sqrt(), std: (variance / independent).sqrt() }
        };
        parameters.insert(disturbance.rms_name.into(), estimate);
    }

    /// Ten points a second, for the answer.
    pub fn decimated(&self, candidate: &Candidate) -> result::CourseEstimate {
        let unit = candidate.kind.disturbance(candidate.channel).map_or("", |course| course.unit);
        let some = |values: &[f64]| values.iter().step_by(points(0.1)).copied().collect();
        let Smoothed { t, value, std } = &self.smoothed;
        result::CourseEstimate { t: some(t), value: some(value), std: some(std), unit: unit.into() }
    }
}

/// Is the number that stands for the course its peak, not its size?
fn tells_its_peak(candidate: &Candidate) -> bool {
    candidate.kind.course.is_some_and(|course| course.is_told_by_its_peak)
}

/// The mean of a sensor's drift over the recording is its zero, which is a number of its own: nobody can tell
/// one from the other, so the drift is told about its mean.
pub fn give_means_to_zeros(findings: &mut [Finding], numbers: &mut BTreeMap<String, Estimate>) {
    for finding in findings {
        let course = effect::named(&finding.effect).and_then(|kind| kind.course);
        let Some(course) = course.filter(|course| course.has_its_mean_in_an_offset) else { continue };
        let zero = finding.channel.as_ref().and_then(|channel| numbers.get_mut(&format!("{channel}_offset")));
        let drift = finding.parameters.get_mut(course.rms_name);
        let Some(((zero, drift), series)) = zero.zip(drift).zip(finding.series.as_mut()) else { continue };
        let mean = series.value.iter().sum::<f64>() / series.value.len().max(1) as f64;
        series.value.iter_mut().for_each(|value| *value -= mean);
        drift.value = (drift.value.powi(2) - mean * mean).max(0.0).sqrt();
        *zero = Estimate { value: zero.value + mean, std: drift.std };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_drift_is_the_sensors_zero() {
        let mut finding =
            Finding { effect: "sensor_drift".into(), channel: Some("yaw_rate".into()), ..Finding::default() };
        let rms = (0.02f64.powi(2) + 0.01f64.powi(2)).sqrt();
        finding.parameters.insert("drift_rms".into(), Estimate { value: rms, std: 0.001 });
        let value = vec![0.03, -0.01, 0.03, -0.01];
        finding.series =
            Some(result::CourseEstimate { t: vec![0.0; 4], std: vec![0.0; 4], value, unit: "rad/s".into() });
        let mut findings = [finding];
        let mut numbers = BTreeMap::from([("yaw_rate_offset".to_owned(), Estimate { value: 0.1, std: 1.0 })]);
        give_means_to_zeros(&mut findings, &mut numbers);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(numbers["yaw_rate_offset"].value, 0.11);
        near(findings[0].parameters["drift_rms"].value, 0.02);
        near(findings[0].series.as_ref().unwrap().value[1], -0.02);
        // A wheel has no zero: its drift stays as it is.
        findings[0].channel = Some("wheel_speed_fl".into());
        give_means_to_zeros(&mut findings, &mut numbers);
        near(findings[0].parameters["drift_rms"].value, 0.02);
    }
}

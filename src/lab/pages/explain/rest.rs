//! Everything else: the whole ranking, the measurement chain, all plots.

use super::courses;
use super::stretch::{self, Stretch};
use super::tried::{Tried, kinds, name, score};
use super::words::{self, number, sentence, stopped};
use crate::explain::{Explanation, Ranked, Trace};
use crate::report::{Color, Page, Plot, Span, Stroke, escape};

/// So many of the ranking have a bar; the others are a list.
const BARS: usize = 15;
/// A longer recording is not legible in one plot, s.
const LONGEST_S: f64 = 180.0;
/// Of a longer one the error is drawn, in so many pieces.
const PIECES: usize = 240;

/// Held-out stretches, as on the timeline.
const HELD_OUT: Color = Color::Surface(2);

/// Writes it.
pub fn write(page: &mut Page, explanation: &Explanation) {
    if !explanation.ranking.is_empty() {
        page.section("ranking", "Everything that was tried", "");
        ranking(page, explanation);
    }
    if !explanation.measurement_chain.is_empty() {
        page.section("chain", "The measurement chain", "");
        page.raw("<ul class=\"drive\">");
        for line in &explanation.measurement_chain {
            page.raw(&format!("<li>{}</li>", escape(&stopped(line))));
        }
        page.raw("</ul>");
    }
    page.section("plots", "All channels", "");
    if explanation.traces.is_empty() {
        page.paragraph("There is nothing to draw: no stretch of the recordings could be simulated.");
        return;
    }
    let recordings = words::recordings(explanation);
    for recording in &recordings {
        if recordings.len() > 1 {
            page.raw(&format!("<h3 class=\"recording\">{}</h3>", escape(recording)));
        }
        let traces = || explanation.traces.iter().filter(|trace| trace.recording == *recording);
        for name in words::in_order(traces().map(|trace| &trace.channel)) {
            for trace in traces().filter(|trace| trace.channel == name) {
                channel(page, explanation, trace);
            }
        }
    }
}

fn ranking(page: &mut Page, explanation: &Explanation) {
    page.raw(&format!(
        "<p class=\"aside\">{} effects{}. 2 ln odds for each alone, every ordinary parameter free to make up for it. \
         Full bars: refitted together with everything else; hatched: judged to first order.</p>",
        explanation.ranking.len(),
        kinds(explanation)
    ));
    let most =
        explanation.ranking.iter().map(|it| it.score).filter(|score| score.is_finite()).fold(0.0, f64::max);
    let tried = Tried::of(explanation);
    let (bars, others) = tried.own.split_at(BARS.min(tried.own.len()));
    page.raw("<ol class=\"ranking\">");
    for ranked in bars {
        page.raw(&bar(explanation, ranked, most));
    }
    page.raw("</ol>");
    if !others.is_empty() {
        page.heading("The others");
        page.raw("<ol class=\"others\">");
        for ranked in others {
            page.raw(&format!("<li>{} <span>{}</span></li>", escape(&name(ranked)), score(ranked.score)));
        }
        page.raw("</ol>");
    }
    if let Some(nothing) = tried.nothing() {
        page.heading(&nothing);
        let names: Vec<String> = tried.idle.iter().map(|ranked| name(ranked)).collect();
        page.raw(&format!("<p class=\"aside\">{}.</p>", escape(&names.join(", "))));
    }
}

fn bar(explanation: &Explanation, ranked: &Ranked, most: f64) -> String {
    let is_finding = explanation
        .findings
        .iter()
        .any(|finding| finding.effect == ranked.effect && finding.channel == ranked.channel);
    let share = if ranked.score.is_finite() && most > 0.0 {
        100.0 * (ranked.score / most).clamp(0.0, 1.0)
    } else {
        0.0
    };
    format!(
        "<li{}><span class=\"name\">{}</span><span class=\"bar\"><i{} style=\"width:{share:.1}%\"></i></span>\
         <span class=\"score\">{}</span></li>",
        if is_finding { " class=\"found\"" } else { "" },
        escape(&name(ranked)),
        if ranked.refitted { "" } else { " class=\"first-order\"" },
        score(ranked.score)
    )
}

fn channel(page: &mut Page, explanation: &Explanation, trace: &Trace) {
    let (Some(&from), Some(&to)) = (trace.t.first(), trace.t.last()) else { return };
    let has_extended = super::has_extension(explanation);
    let name = sentence(&words::channel(&trace.channel));
    let is_long = to - from > LONGEST_S;
    let stretch = if is_long {
        stretch::of_trace(explanation, trace)
    } else {
        Some(Stretch { trace, t: [from, to], is_holdout: false })
    };
    let Some(stretch) = stretch else { return };
    if let Some(mut plot) = courses::plot(&stretch, 180, has_extended) {
        let spans = held_out(explanation, trace);
        if !is_long && !spans.is_empty() {
            plot = plot.spans(&spans).explain("held out of the fit", HELD_OUT);
        }
        let heading = if is_long {
            format!("{name}, {} to {} s", number(stretch.t[0], 0), number(stretch.t[1], 0))
        } else {
            name.clone()
        };
        courses::draw(page, &heading, &plot, "");
    }
    if is_long && let Some(plot) = error(trace, [from, to], has_extended) {
        courses::draw(page, &format!("{name}: error over the whole recording"), &plot, "");
    }
}

fn held_out(explanation: &Explanation, trace: &Trace) -> Vec<Span> {
    let blocks = explanation.split.iter().filter(|it| it.is_holdout && it.recording == trace.recording);
    blocks.map(|block| Span { x: block.t[0]..block.t[1], label: String::new(), color: HELD_OUT }).collect()
}

/// Root mean square error, piece by piece.
fn error(trace: &Trace, [from, to]: [f64; 2], has_extended: bool) -> Option<Plot> {
    let (factor, unit) = words::shown_unit(&trace.channel, &trace.unit);
    let length = (to - from) / PIECES as f64;
    let pieces = |simulated: &[f64]| -> Vec<(f64, f64)> {
        let mut sums = vec![(0.0, 0u32); PIECES];
        for ((t, measured), simulated) in trace.t.iter().zip(&trace.measured).zip(simulated) {
            let off = factor * (measured - simulated);
            if let Some(sum) = sums.get_mut(((t - from) / length) as usize).filter(|_| off.is_finite()) {
                *sum = (sum.0 + off * off, sum.1 + 1);
            }
        }
        let point = |(place, (sum, count)): (usize, (f64, u32))| {
            let value = if count > 0 { (sum / f64::from(count)).sqrt() } else { f64::NAN };
            (from + length * (place as f64 + 0.5), value)
        };
        sums.into_iter().enumerate().map(point).collect()
    };
    let (baseline, extended) = (pieces(&trace.baseline), pieces(&trace.extended));
    let highest = courses::range(baseline.iter().chain(&extended).map(|point| point.1))?.end;
    let mut plot = Plot::new(
        &format!("{}: error", words::channel(&trace.channel)),
        &courses::axis(&unit),
        from..to,
        0.0..highest,
    )
    .height(150)
    .stroked(courses::PLAIN.0, courses::PLAIN.1, Stroke::Dashed, baseline.into_iter());
    if has_extended {
        plot = plot.line(courses::EXTENDED.0, courses::EXTENDED.1, extended.into_iter());
    }
    Some(plot)
}

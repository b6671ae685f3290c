//! Everything else: the whole ranking, and the measurement chain.

use super::tried::{Tried, kinds, name, score};
use super::words::stopped;
use crate::explain::{Explanation, Ranked};
use crate::report::{Page, escape};

/// So many of the ranking have a bar; the others are a list.
const BARS: usize = 15;

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

//! Where simulation and recording differ: equation, channels, driving, time.

use super::formula;
use super::words::{self, sentence};
use crate::explain::{Explanation, Where};
use crate::report::{Page, escape};

/// So many stretches of time are named.
const MOST_INTERVALS: usize = 12;

/// Writes it; nothing where nothing differs.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let place = &explanation.place;
    if place.equation.is_empty() && place.channels.is_empty() {
        return;
    }
    page.section("where", "Where they differ", "");
    page.raw("<dl class=\"place\">");
    about(page, place);
    if !place.intervals.is_empty() {
        let when = words::intervals(place, MOST_INTERVALS);
        let of = if place.recording.is_empty() { String::new() } else { format!(" of {}", place.recording) };
        page.raw(&format!("<div><dt>When</dt><dd>{}</dd></div>", escape(&(when + &of))));
    }
    page.raw("</dl>");
}

/// Equation, channels and driving, as entries of a list.
pub fn about(page: &mut Page, place: &Where) {
    let channels: Vec<String> = place.channels.iter().map(|name| words::channel(name)).collect();
    let one =
        |term: &str, text: &str| format!("<div><dt>{term}</dt><dd>{}</dd></div>", escape(&sentence(text)));
    let many = |term: &str, words: &[String]| {
        let items: Vec<String> =
            words.iter().map(|word| format!("<li>{}</li>", formula::html(word))).collect();
        format!("<div><dt>{term}</dt><dd><ul class=\"chips\">{}</ul></dd></div>", items.concat())
    };
    if !place.equation.is_empty() {
        page.raw(&one("Equation or sensor", &place.equation));
    }
    if !channels.is_empty() {
        page.raw(&many("Seen in", &channels));
    }
    if !place.regimes.is_empty() {
        page.raw(&many("When driving", &place.regimes));
    }
}

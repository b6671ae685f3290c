//! What to change in somebody's model, in a modeller's words: a row for each finding, with how much of the held-out difference
//! it takes away, and what the second pass says of it.

use super::in_your_model as said;
use super::words::{self, number, sentence, stopped};
use crate::explain::{ByChannel, Explanation, Finding, Parts, SecondPass};
use crate::report::Page;

/// Above this share what effects do to each other is told. Below, numbers move by less than they are known.
const LEAST_INTERPLAY: f64 = 0.1;

/// Shares of the difference below a per cent are nothing.
const LEAST_SHARE: f64 = 0.01;

/// One thing to change.
struct Row {
    what: String,
    numbers: String,
    off_by: String,
    takes: String,
    second: String,
}

/// As a table of the page; nothing where the answer is not of a simulation, or nothing was found.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let rows = rows(explanation);
    if rows.is_empty() {
        return;
    }
    page.section("change", "What to change in your model", &summary(explanation));
    let cells = |row: Row| vec![sentence(&row.what), row.numbers, row.off_by, row.takes, row.second];
    page.table_of_words(
        &[
            "change",
            "recording (your simulation)",
            "without it your yaw rate is off by",
            "takes away of the held-out difference",
            "second pass",
        ],
        &rows.into_iter().map(cells).collect::<Vec<_>>(),
    );
    page.raw(
        "<p class=\"aside\">Too stiff: more side force at the same motion and steering. Taken away: of the squared difference \
         between recording and simulation on driving that was held out, everything else of the table being there; rows need \
         not add up. Second pass: the numbers fitted again with all of the table in both runs.</p>",
    );
}

/// The same on the terminal.
pub fn text(text: &mut String, explanation: &Explanation) {
    let rows = rows(explanation);
    if rows.is_empty() {
        return;
    }
    *text += "\nWhat to change in your model\n";
    for row in rows {
        let takes = if row.takes.is_empty() { String::new() } else { format!(" Takes away {}.", row.takes) };
        super::text::wrapped(text, "  - ", &format!("{}{takes}", stopped(&row.what)));
        if row.second.starts_with(MOVED) {
            super::text::wrapped(text, "    second pass: ", &stopped(&row.second));
        }
    }
    super::text::wrapped(text, "  ", &summary(explanation));
}

/// How a second pass that differs begins.
const MOVED: &str = "moved";

fn rows(explanation: &Explanation) -> Vec<Row> {
    if explanation.simulation.is_none() || explanation.findings.is_empty() {
        return Vec::new();
    }
    let of_all = of_the_whole(explanation);
    let mut rows: Vec<Row> = explanation
        .findings
        .iter()
        .map(|finding| {
            let second = finding.second_pass.as_ref();
            let share = second.map_or(&finding.explained_share, |second| &second.explained_share);
            Row {
                what: said::sentence(finding),
                numbers: said::numbers(finding),
                off_by: second.map_or_else(String::new, said::off_by),
                takes: taken(share, &of_all),
                second: second.map_or_else(String::new, |second| second_pass(finding, second)),
            }
        })
        .collect();
    rows.extend(zeros(explanation));
    rows.extend(everything(explanation));
    rows
}

/// What the findings' shares are of, as a share of the whole squared difference, by channel: the sensors' own zeros are off.
fn of_the_whole(explanation: &Explanation) -> ByChannel {
    let error = &explanation.error;
    error.ordinary.as_ref().map_or_else(ByChannel::new, |ordinary| left(&error.baseline, ordinary))
}

/// Which share of one's squared held-out error another one has, by channel.
fn left(of: &Parts<ByChannel>, is: &Parts<ByChannel>) -> ByChannel {
    let share = |(channel, is): (&String, &f64)| {
        let share = (is / of.holdout.get(channel)?).powi(2);
        share.is_finite().then(|| (channel.clone(), share))
    };
    is.holdout.iter().filter_map(share).collect()
}

/// What is taken away, in words.
fn taken(share: &ByChannel, of_all: &ByChannel) -> String {
    let all = words::in_order(share.keys()).into_iter().filter_map(|channel| {
        let share = share[channel] * of_all.get(channel).copied().unwrap_or(1.0);
        (share >= LEAST_SHARE)
            .then(|| format!("{} % in {}", number(100.0 * share, 0), words::channel(channel)))
    });
    words::list(&all.collect::<Vec<_>>())
}

/// The same of what is left.
fn taken_by(left: &ByChannel) -> String {
    let share = left.iter().map(|(channel, left)| (channel.clone(), 1.0 - left)).collect();
    taken(&share, &ByChannel::new())
}

/// Where the recording's sensors have their zeros: that is no change of the model.
fn zeros(explanation: &Explanation) -> Option<Row> {
    let takes = taken_by(&of_the_whole(explanation));
    let numbers = explanation.parameters.ordinary.iter().flatten();
    let zeros = numbers.filter(|(name, it)| name.contains("_offset") && it.value.abs() > 2.0 * it.std);
    let zeros: Vec<String> = zeros
        .map(|(name, it)| words::ordinary(name, *it))
        .map(|shown| format!("{} {}", shown.name, shown.value()))
        .collect();
    (!takes.is_empty() && !zeros.is_empty()).then(|| Row {
        what: "nothing: these are the zeros of the recording's sensors".into(),
        numbers: words::list(&zeros),
        off_by: String::new(),
        takes,
        second: String::new(),
    })
}

fn everything(explanation: &Explanation) -> Option<Row> {
    let error = &explanation.error;
    let takes = taken_by(&left(&error.baseline, &error.extended));
    (!takes.is_empty()).then(|| Row {
        what: "all of it together".into(),
        numbers: String::new(),
        off_by: String::new(),
        takes,
        second: String::new(),
    })
}

/// What the second pass says of a finding.
fn second_pass(finding: &Finding, second: &SecondPass) -> String {
    let mut told = if second.moved.is_empty() {
        "the same".to_owned()
    } else {
        let before = Finding { parameters: second.first_parameters.clone(), law: None, ..finding.clone() };
        let names: Vec<String> = second
            .moved
            .iter()
            .map(|name| words::parameter(&finding.effect, finding.channel.as_deref(), name))
            .collect();
        let was = words::parameters(&before).into_iter().filter(|row| names.contains(&row.name));
        let was: Vec<String> = was.map(|row| format!("{} {}", row.name, row.value())).collect();
        format!("{MOVED} by more than its uncertainty; first {}", words::list(&was))
    };
    let most = second.interplay.values().copied().fold(0.0, f64::max);
    if most > LEAST_INTERPLAY {
        told += &format!("; {} % of what it does is due to the others", number(100.0 * most, 0));
    }
    told
}

/// What the second pass came to, in a sentence or two.
fn summary(explanation: &Explanation) -> String {
    let seconds = || explanation.findings.iter().filter_map(|finding| finding.second_pass.as_ref());
    let moved = seconds().filter(|second| !second.moved.is_empty()).count();
    let all = seconds().count();
    if all == 0 {
        return String::new();
    }
    let most = seconds().flat_map(|second| second.interplay.values()).copied().fold(0.0, f64::max);
    let numbers = match moved {
        0 => "no number moved by more than its uncertainty".to_owned(),
        1 => "the numbers of one finding moved by more than their uncertainty".to_owned(),
        many => format!("the numbers of {many} findings moved by more than their uncertainty"),
    };
    let sum = if all == 1 {
        String::new()
    } else {
        format!(
            "; what effects do beside each other differs by {} % at most from what they do alone",
            number(100.0 * most, 0)
        )
    };
    let gone = explanation.simulation.iter().flat_map(|simulated| &simulated.fell_away);
    let gone: Vec<String> = gone.map(|name| words::effect_named(name)).collect();
    let gone = if gone.is_empty() {
        String::new()
    } else {
        format!(" Found first and not needed beside the rest: {}.", words::list(&gone))
    };
    format!("In a second pass, with all of it in both runs, {numbers}{sum}.{gone}")
}

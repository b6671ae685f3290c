//! What became of what was predicted, as people read it.

use super::text::{table, wrapped};
use super::words::{self, number};
use crate::explain::{Bin, Outcome, Verified};
use crate::report::{Page, escape};

const ABOUT: &str = "Effects of such sizes were put into the drive and explained for real, beside the drive as it is. Named: a \
                     finding of that effect that the drive as it is has not, or not of that size.";

const BINS: [&str; 5] = ["predicted chance", "put in", "named", "that is", "95 % interval"];

const RUNS: [&str; 5] = ["effect", "put in", "predicted", "named", "found"];

fn percent(share: f64) -> String {
    format!("{} %", number(100.0 * share, 0))
}

fn bin(bin: &Bin) -> [String; 5] {
    let [low, high] = bin.predicted.map(|edge| number(100.0 * edge, 0));
    let mean = bin.mean.map_or(String::new(), |mean| format!(" (mean {})", number(100.0 * mean, 0)));
    let share = if bin.count == 0 { "–".into() } else { percent(bin.named as f64 / bin.count as f64) };
    let interval = match bin.count {
        0 => String::new(),
        _ => format!("{} to {}", percent(bin.ci95[0]), percent(bin.ci95[1])),
    };
    [format!("{low} to {high} %{mean}"), bin.count.to_string(), bin.named.to_string(), share, interval]
}

fn run(it: &Outcome) -> [String; 5] {
    let of = it.parameter.strip_prefix("relative_difference_").map(|wheel| format!(":{wheel}"));
    let of = it.channel.as_ref().map(|channel| format!(":{channel}")).or(of).unwrap_or_default();
    let size = words::size(&it.parameter, it.channel.as_deref().unwrap_or(""), &it.unit, it.change);
    let found = match &it.refused {
        Some(why) => format!("could not be put in: {why}"),
        None => words::list(&it.found.iter().map(|name| words::effect_named(name)).collect::<Vec<_>>()),
    };
    let named = match (&it.refused, it.named) {
        (Some(_), _) => "–",
        (None, true) => "yes",
        (None, false) => "no",
    };
    [words::effect_named(&(it.effect.clone() + &of)), size, percent(it.predicted), named.into(), found]
}

/// What the bins come to, in a sentence.
fn sentence(verified: &Verified) -> String {
    let said = verified.bins.iter().filter(|bin| bin.count > 0);
    let (mut within, mut below, mut above) = (Vec::new(), Vec::new(), Vec::new());
    for bin in said {
        let mean = bin.mean.unwrap_or(0.5);
        let name = bin.predicted.map(|edge| number(100.0 * edge, 0)).join(" to ") + " %";
        match bin.ci95 {
            [low, _] if mean < low => below.push(name),
            [_, high] if mean > high => above.push(name),
            _ => within.push(name),
        }
    }
    let mut words = Vec::new();
    let mut say = |bins: Vec<String>, what: &str| {
        if !bins.is_empty() {
            words.push(format!("{what} where {} were predicted", words::list(&bins)));
        }
    };
    say(within, "as often as predicted, as far as so many tell,");
    say(below, "more often");
    say(above, "less often");
    match words.is_empty() {
        true => "Nothing could be put in.".into(),
        false => format!("Effects were named {}.", words.join("; ")),
    }
}

/// As text.
pub fn text(text: &mut String, verified: &Verified) {
    *text += "\nVerified\n";
    wrapped(text, "", ABOUT);
    wrapped(text, "", &sentence(verified));
    text.push('\n');
    table(text, &BINS.map(str::to_owned), &verified.bins.iter().map(bin).collect::<Vec<_>>());
    text.push('\n');
    table(text, &RUNS.map(str::to_owned), &verified.runs.iter().map(run).collect::<Vec<_>>());
    if !verified.left_out.is_empty() {
        *text += "\nNot put in\n";
        for it in &verified.left_out {
            wrapped(text, "  - ", &format!("{}: {}", words::effect_named(&it.effect), it.why));
        }
    }
}

/// As a part of the page.
pub fn section(page: &mut Page, verified: &Verified) {
    page.section("verified", "Verified", "");
    page.paragraph(ABOUT);
    page.paragraph(&sentence(verified));
    let rows = |rows: Vec<[String; 5]>| -> Vec<Vec<String>> { rows.into_iter().map(Vec::from).collect() };
    page.table(&BINS, &rows(verified.bins.iter().map(bin).collect()));
    page.table_of_words(&RUNS, &rows(verified.runs.iter().map(run).collect()));
    for it in &verified.left_out {
        let line = format!("{}: {}", words::effect_named(&it.effect), it.why);
        page.raw(&format!("<p class=\"aside\">Not put in: {}</p>", escape(&line)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::LeftOut;

    #[test]
    fn predicted_stands_beside_found() {
        let run = |predicted: f64, named: bool| Outcome {
            effect: "tire_radius".into(),
            channel: None,
            parameter: "relative_difference_rl".into(),
            change: -0.012,
            unit: "1".into(),
            predicted,
            named,
            noticed: named,
            found: if named { vec!["tire_radius".into()] } else { vec!["sensor_scale:yaw_rate".into()] },
            refused: None,
        };
        let left_out =
            LeftOut { effect: "payload".into(), why: "no size of it is called by its name".into() };
        let runs = (0..20).map(|i| run(0.95, i > 12)).chain([run(0.5, true)]).collect();
        let verified = Verified::of(runs, vec![left_out]);
        let mut said = String::new();
        text(&mut said, &verified);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in [
            "as often as predicted, as far as so many tell, where 40 to 60 % were predicted",
            "less often where 80 to 100 % were predicted",
            "80 to 100 % (mean 95) 20 7 35 %",
            "unequal tire radii, RL −1.20 % 95 % no wrong scale of yaw rate",
            "payload: no size",
        ] {
            assert!(said.contains(part), "{part} not in\n{said}");
        }
        let mut page = Page::new("a", "b");
        section(&mut page, &verified);
        assert!(page.html().contains("less often"));
    }
}

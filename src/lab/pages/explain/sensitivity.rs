//! What a drive could have told, as people read it.

use super::text::{table, to_drive, wrapped};
use super::words::{self, number};
use crate::explain::{Detectable, Isolability, Rival, Sensitivity};
use crate::report::{Page, escape};

/// Pairs that are told apart less often are named.
const SURE: f64 = 0.9;

/// So many pairs are named.
const MOST_PAIRS: usize = 20;

/// Decades of the bars, around what is ordinary.
const DECADES: (f64, f64) = (-2.0, 2.0);

/// A row in words: effect, its number, smallest size found, smallest size named, ordinary size, what it is taken for.
fn row(it: &Detectable) -> [String; 5] {
    let size = |size: Option<f64>| size.map_or("–".into(), |size| shown(it, size));
    let taken = |rival: &Rival| {
        format!("{} ({})", words::effect_named(&rival.name), number(rival.correlation.abs(), 2))
    };
    [
        name(it),
        size(it.noticed_90),
        size(it.named_90),
        shown(it, it.ordinary),
        it.taken_for.as_ref().map_or(String::new(), taken),
    ]
}

fn name(it: &Detectable) -> String {
    let of = match (&it.channel, it.parameter.strip_prefix("relative_difference_")) {
        (Some(channel), _) => format!(":{channel}"),
        (None, Some(wheel)) => format!(":{wheel}"),
        (None, None) => String::new(),
    };
    words::effect_named(&(it.effect.clone() + &of))
}

fn shown(it: &Detectable, size: f64) -> String {
    words::size(&it.parameter, it.channel.as_deref().unwrap_or(""), &it.unit, size)
}

const COLUMNS: [&str; 5] = ["effect", "seen from", "named from", "ordinary", "taken for (correlation)"];

const ABOUT: &str = "Changes that this drive would show with 90 % probability, under any name and under their own. Reckoned \
                     from the likelihood's curvature, so for changes that act in proportion; what begins within the drive \
                     is taken to begin in its middle.";

/// As text.
pub fn text(sensitivity: &Sensitivity) -> String {
    let mut text = String::new();
    wrapped(&mut text, "", ABOUT);
    text.push('\n');
    let rows: Vec<[String; 5]> = sensitivity.effects.iter().map(row).collect();
    table(&mut text, &COLUMNS.map(str::to_owned), &rows);
    if let Some(verified) = &sensitivity.verified {
        super::verified::text(&mut text, verified);
    }
    text
}

/// As a page: a bar for each effect, from where it is named on.
pub fn page(sensitivity: &Sensitivity) -> String {
    let mut page = Page::new("gripd explain: what this drive could have told", ABOUT);
    page.raw("<div class=\"scroll\"><table><thead><tr><th>effect</th><th>seen from</th><th>named from</th>\
              <th>ordinary</th><th>0.01 … 100 times ordinary</th><th>taken for (correlation)</th></tr></thead><tbody>");
    for it in &sensitivity.effects {
        let [name, seen, named, ordinary, taken] = row(it).map(|cell| escape(&cell));
        page.raw(&format!(
            "<tr><th>{name}</th><td>{seen}</td><td>{named}</td><td>{ordinary}</td><td>{}</td><td>{taken}</td></tr>",
            bar(it)
        ));
    }
    page.raw("</tbody></table></div>");
    if let Some(verified) = &sensitivity.verified {
        super::verified::section(&mut page, verified);
    }
    page.html()
}

/// Pale from where it is seen, full from where it is named, a line at what is ordinary.
fn bar(it: &Detectable) -> String {
    let (low, high) = DECADES;
    let at = |size: Option<f64>| {
        let decade = size.map_or(high, |size| (size / it.ordinary).log10());
        100.0 * (decade.clamp(low, high) - low) / (high - low)
    };
    let (seen, named, ordinary) = (at(it.noticed_90), at(it.named_90), at(Some(it.ordinary)));
    format!(
        "<svg viewBox=\"0 0 100 8\" width=\"160\" height=\"13\" role=\"img\" aria-label=\"sizes that are seen\">\
         <rect x=\"0\" y=\"2\" width=\"100\" height=\"4\" fill=\"currentColor\" opacity=\"0.08\"/>\
         <rect x=\"{seen:.1}\" y=\"2\" width=\"{:.1}\" height=\"4\" fill=\"currentColor\" opacity=\"0.3\"/>\
         <rect x=\"{named:.1}\" y=\"2\" width=\"{:.1}\" height=\"4\" fill=\"currentColor\" opacity=\"0.8\"/>\
         <line x1=\"{ordinary:.1}\" x2=\"{ordinary:.1}\" y1=\"0\" y2=\"8\" stroke=\"currentColor\" stroke-width=\"1\"/>\
         </svg>",
        100.0 - seen,
        100.0 - named,
    )
}

/// What can be seen, and which pairs are hard to tell apart, as text.
pub fn pairs(isolability: &Isolability) -> String {
    let named = |place: usize| words::effect_named(&isolability.effects[place]);
    let mut text = String::new();
    let of = |is: bool| {
        let places = (0..isolability.effects.len()).filter(|place| isolability.detectable[*place] == is);
        words::list(&places.map(named).collect::<Vec<_>>())
    };
    for (words, is) in [("At its ordinary size this drive shows: ", true), ("It does not show: ", false)] {
        let all = of(is);
        wrapped(&mut text, words, if all.is_empty() { "nothing" } else { &all });
    }
    let mut hard: Vec<(f64, usize, usize)> = Vec::new();
    for (i, row) in isolability.separable.iter().enumerate().filter(|(i, _)| isolability.detectable[*i]) {
        hard.extend(
            row.iter()
                .enumerate()
                .filter(|(j, chance)| *j != i && **chance < SURE)
                .map(|(j, it)| (*it, i, j)),
        );
    }
    hard.sort_by(|a, b| a.0.total_cmp(&b.0));
    if hard.is_empty() {
        text += "\nEach of these is told from every other.\n";
    } else {
        hard_pairs(&mut text, &hard, &named);
    }
    to_drive(&mut text, &isolability.to_drive);
    text
}

fn hard_pairs(text: &mut String, hard: &[(f64, usize, usize)], named: &impl Fn(usize) -> String) {
    *text += "\nHard to tell apart (chance that the right one of the two has more evidence)\n";
    let row = |(chance, i, j): &(f64, usize, usize)| {
        [
            "  ".to_owned() + &named(*i),
            "from".into(),
            named(*j),
            format!("{} %", number(100.0 * chance, 0)),
            String::new(),
        ]
    };
    let rows: Vec<[String; 5]> = hard.iter().take(MOST_PAIRS).map(row).collect();
    table(text, &[const { String::new() }; 5], &rows);
    if hard.len() > MOST_PAIRS {
        *text += &format!("  and {} more\n", hard.len() - MOST_PAIRS);
    }
}

//! How sure it is: fit by channel, likelihood, what is left, and what each equation misses.

use std::collections::BTreeMap;

use super::gain;
use super::has_extension;
use super::words::{self, number, sentence, signed, three};
use crate::explain::{ByChannel, Explanation, Missing, Models, Parts};
use crate::report::{Page, escape};

type Intervals = BTreeMap<String, [f64; 2]>;

/// Writes it. Without an extended model its columns are left out.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let is_extended = has_extension(explanation);
    let fits = if is_extended { both_fits } else { plain_fits };
    page.section("sure", "How sure", "");
    page.heading("Simulation without feedback: fit, %");
    fits(page, &explanation.fit, &explanation.improvement_ci95, &explanation.unexplained);
    if is_extended && !explanation.unexplained.is_empty() {
        aside(
            page,
            "Gains in percentage points; bold where the interval is above zero. The last column is a share of \
             what the plain model leaves, not of what was recorded: its squared error above the sensors' noise, \
             on held-out data. A channel that the plain model follows well has little to be left of.",
        );
    } else if !is_extended {
        aside(page, "The error's share of the variance that was recorded, on held-out data: (1 − fit)².");
    }
    errors(page, explanation, is_extended);
    if !explanation.prediction_fit.baseline.train.is_empty() {
        page.heading("Prediction by one step: fit, %");
        fits(page, &explanation.prediction_fit, &Intervals::new(), &ByChannel::new());
    }
    likelihoods(page, &explanation.log_likelihood, is_extended);
    equations(page, &explanation.equations, is_extended);
}

/// The same in the channels' units.
fn errors(page: &mut Page, explanation: &Explanation, is_extended: bool) {
    let error = &explanation.error;
    let channels = channels(error);
    if channels.is_empty() {
        return;
    }
    page.heading("Simulation without feedback: error");
    let names = super::plots::names(explanation);
    let count = if is_extended { 2 } else { 1 };
    let row = |name: &str| {
        let (factor, unit) = gain::shown(name);
        let of = |by: &ByChannel| three(factor * of(by, name));
        let parts = [&error.baseline, &error.extended].into_iter().take(count);
        let mut row = vec![format!("{}, {unit}", sentence(&words::channel(name)))];
        row.extend(parts.flat_map(|parts| [of(&parts.train), of(&parts.holdout)]));
        row
    };
    let mut columns = vec!["channel".to_owned()];
    columns.extend(
        names.iter().take(count).flat_map(|name| [format!("{name}, fitted"), format!("{name}, held out")]),
    );
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    page.table(&columns, &channels.into_iter().map(row).collect::<Vec<_>>());
    aside(page, "Root mean square of measured − predicted.");
}

fn aside(page: &mut Page, text: &str) {
    page.raw(&format!("<p class=\"aside\">{}</p>", escape(text)));
}

fn channels(fit: &Models<Parts<ByChannel>>) -> Vec<&str> {
    let parts = [&fit.baseline.train, &fit.baseline.holdout, &fit.extended.train, &fit.extended.holdout];
    words::in_order(parts.into_iter().flat_map(BTreeMap::keys))
}

fn of(by: &ByChannel, channel: &str) -> f64 {
    by.get(channel).copied().unwrap_or(f64::NAN)
}

/// A share as per cent.
fn share(share: f64) -> String {
    let unit = if share.is_finite() { "%" } else { "" };
    words::with_unit(&number(100.0 * share, 1), unit)
}

/// Of the plain model alone. What it leaves of its own error is everything, which says nothing: so here it
/// is held against what was recorded.
fn plain_fits(page: &mut Page, fit: &Models<Parts<ByChannel>>, _: &Intervals, _: &ByChannel) {
    let row = |name: &str| {
        let holdout = of(&fit.baseline.holdout, name);
        vec![
            sentence(&words::channel(name)),
            number(of(&fit.baseline.train, name), 1),
            number(holdout, 1),
            share(words::left_of_variance(holdout)),
        ]
    };
    let rows: Vec<Vec<String>> = channels(fit).into_iter().map(row).collect();
    page.table(&["channel", "fitted", "held out", "error / recorded variance"], &rows);
}

/// Both models beside each other.
fn both_fits(
    page: &mut Page,
    fit: &Models<Parts<ByChannel>>,
    intervals: &Intervals,
    unexplained: &ByChannel,
) {
    let models: &[&str] = &["plain", "extended"];
    let mut groups =
        vec![("channel", &[][..]), ("fitted", models), ("held out", &["plain", "extended", "gain"])];
    if !intervals.is_empty() {
        groups.push(("95 % interval of the gain", &[]));
    }
    if !unexplained.is_empty() {
        groups.push(("left of the plain model's error", &[]));
    }
    let mut html = head(&groups);
    for name in channels(fit) {
        let (before, after) = (of(&fit.baseline.holdout, name), of(&fit.extended.holdout, name));
        let interval = intervals.get(name).filter(|it| it.iter().all(|end| end.is_finite()));
        let class = match interval {
            Some([low, _]) if *low > 0.0 => " class=\"gain\"",
            Some([_, high]) if *high < 0.0 => " class=\"loss\"",
            _ => "",
        };
        html += &format!("<tr><th scope=\"row\">{}</th>", escape(&sentence(&words::channel(name))));
        for value in [of(&fit.baseline.train, name), of(&fit.extended.train, name), before, after] {
            html += &format!("<td>{}</td>", number(value, 1));
        }
        html += &format!("<td{class}>{}</td>", signed(after - before, 1));
        if !intervals.is_empty() {
            html += &match interval {
                Some([low, high]) => format!("<td>{} to {}</td>", signed(*low, 1), signed(*high, 1)),
                None => "<td>–</td>".into(),
            };
        }
        if !unexplained.is_empty() {
            html += &format!("<td>{}</td>", share(of(unexplained, name)));
        }
        html += "</tr>\n";
    }
    page.raw(&(html + "</tbody></table></div>"));
}

/// The head of a table whose columns are in groups; a group without columns is one itself.
fn head(groups: &[(&str, &[&str])]) -> String {
    let mut upper = String::new();
    let mut lower = String::new();
    for (name, columns) in groups {
        let name = escape(name);
        upper += &match columns.len() {
            0 => format!("<th rowspan=\"2\" scope=\"col\">{name}</th>"),
            count => format!("<th colspan=\"{count}\" scope=\"colgroup\">{name}</th>"),
        };
        lower.extend(columns.iter().map(|column| format!("<th scope=\"col\">{}</th>", escape(column))));
    }
    format!(
        "<div class=\"scroll\"><table class=\"grouped\"><thead><tr>{upper}</tr><tr>{lower}</tr></thead><tbody>\n"
    )
}

fn likelihoods(page: &mut Page, of: &Models<Parts<f64>>, is_extended: bool) {
    let Models { baseline, extended, .. } = of;
    if ![baseline.train, baseline.holdout].iter().any(|it| it.is_finite() && *it != 0.0) {
        return;
    }
    page.heading("Log-likelihood");
    let count = if is_extended { 4 } else { 2 };
    let row = |name: &str, before: f64, after: f64| {
        let mut row = vec![name.to_owned(), number(before, 1), number(after, 1), signed(after - before, 1)];
        row.truncate(count);
        row
    };
    let columns: &[&str] = &["", "plain", "extended", "difference"];
    page.table(
        columns.get(..count).unwrap_or(columns),
        &[row("Fitted", baseline.train, extended.train), row("Held out", baseline.holdout, extended.holdout)],
    );
}

fn equations(page: &mut Page, equations: &Models<Vec<Missing>>, is_extended: bool) {
    if equations.baseline.is_empty() {
        return;
    }
    page.heading("What each equation misses");
    let mut text = String::from(
        "An unknown input is allowed in one equation after the other: how large it must be, and how much likelier that \
         makes the recording (twice the log-likelihood ratio).",
    );
    if is_extended {
        text += " Large before and small after means that the finding is what was missing there.";
    }
    aside(page, &text);
    if !is_extended {
        let row = |it: &Missing| {
            vec![sentence(&it.equation), format!("{} {}", three(it.diffusion), unit(it)), number(it.ratio, 1)]
        };
        let rows: Vec<Vec<String>> = equations.baseline.iter().map(row).collect();
        page.table(&["equation", "unknown input", "2 ln likelihood ratio"], &rows);
        return;
    }
    let models: &[&str] = &["plain", "extended"];
    let groups =
        [("equation", &[][..]), ("unknown input", models), ("unit", &[]), ("2 ln likelihood ratio", models)];
    let mut html = head(&groups);
    for before in &equations.baseline {
        let after = equations.extended.iter().find(|after| after.equation == before.equation);
        let (diffusion, ratio) = after.map_or((f64::NAN, f64::NAN), |after| (after.diffusion, after.ratio));
        html += &format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(&sentence(&before.equation)),
            three(before.diffusion),
            three(diffusion),
            escape(&unit(before)),
            number(before.ratio, 1),
            number(ratio, 1)
        );
    }
    page.raw(&(html + "</tbody></table></div>"));
}

/// Of a diffusion.
fn unit(missing: &Missing) -> String {
    let unit = &missing.unit;
    if unit.contains('√') || unit.is_empty() { unit.clone() } else { format!("{unit}/√s") }
}

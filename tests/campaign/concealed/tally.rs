//! The table: how many are named, by effect, by strength and by who put them in; how right their numbers are, and what
//! was predicted of them.

use super::judge::{Judged, Said};
use super::plan::{By, Case, EFFECTS};

/// All that was asked.
#[derive(Default)]
pub struct Tally {
    rows: Vec<Row>,
    /// What could not be put in.
    pub refused: Vec<String>,
}

struct Row {
    effect: &'static str,
    by: By,
    judged: Judged,
}

impl Row {
    fn is_strong(&self) -> bool {
        self.judged.strength >= 1.0
    }

    fn said(&self, is_beside: bool) -> Option<&Said> {
        if is_beside { self.judged.beside.as_ref() } else { Some(&self.judged.alone) }
    }
}

type Table = (&'static str, &'static str, Vec<String>);

impl Tally {
    pub fn add(&mut self, case: &Case, judged: Judged) {
        self.rows.push(Row { effect: case.effect.name, by: case.by, judged });
    }

    /// Name, header and rows of each.
    pub fn tables(&self) -> Vec<Table> {
        vec![self.by_effect(), self.by_strength(), self.numbers(), self.chances()]
    }

    fn by_effect(&self) -> Table {
        let mut rows: Vec<String> = Vec::new();
        for effect in EFFECTS {
            let of = |row: &&Row| row.effect == effect.name;
            rows.push(format!("{} | {}", effect.name, self.told(of)));
        }
        (
            "concealed_by_effect",
            "put in | alone: strength < 1 | strength ≥ 1 | beside three references: strength < 1 | strength ≥ 1",
            rows,
        )
    }

    /// First, in a class of three, named at all, noticed, misled, of so many: weaker and stronger, alone and beside others.
    fn told(&self, of: impl Fn(&&Row) -> bool) -> String {
        let rows: Vec<&Row> = self.rows.iter().filter(|row| of(row)).collect();
        let cell = |is_beside: bool, is_strong: bool| {
            let rows = rows.iter().filter(|row| row.is_strong() == is_strong);
            counts(&rows.filter_map(|row| row.said(is_beside)).collect::<Vec<_>>())
        };
        [(false, false), (false, true), (true, false), (true, true)]
            .map(|(is_beside, is_strong)| cell(is_beside, is_strong))
            .join(" | ")
    }

    fn by_strength(&self) -> Table {
        let classes = [(0.0, 0.3), (0.3, 1.0), (1.0, 2.0), (2.0, f64::INFINITY)];
        let mut rows = Vec::new();
        let mut push = |name: String, of: &dyn Fn(&Row) -> bool| {
            let of: Vec<&Row> = self.rows.iter().filter(|row| of(row)).collect();
            let [alone, beside] = [false, true].map(|is_beside| {
                counts(&of.iter().filter_map(|row| row.said(is_beside)).collect::<Vec<_>>())
            });
            rows.push(format!("{name} | {alone} | {beside}"));
        };
        for (low, high) in classes {
            let name = if high.is_finite() { format!("{low} to {high}") } else { format!("from {low}") };
            push(name, &|row| (low..high).contains(&row.judged.strength));
        }
        push("from 1, put in by gripd".into(), &|row| row.is_strong() && row.by == By::Gripd);
        push("from 1, put in by the other tool".into(), &|row| row.is_strong() && row.by == By::Tool);
        push("all".into(), &|_| true);
        rows.push(format!("refused | {} | ", self.refused.len()));
        ("concealed_by_strength", "strength | alone | beside three references", rows)
    }

    fn numbers(&self) -> Table {
        let row = |name: &str, errors: Vec<(f64, f64)>| {
            let within = errors.iter().filter(|(error, std)| error.abs() <= 1.96 * std).count();
            let mut sizes: Vec<f64> = errors.iter().map(|(error, _)| 100.0 * error.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let median = sizes.get(sizes.len() / 2).copied().unwrap_or(f64::NAN);
            format!("{name} | {} | {within} | {median:.0}", errors.len())
        };
        let of = |is_beside: bool| {
            self.rows
                .iter()
                .filter_map(move |row| row.said(is_beside))
                .filter_map(|said| said.error)
                .collect()
        };
        (
            "concealed_numbers",
            "named | numbers | truth within 1.96 standard deviations | error in the median, %",
            vec![row("alone", of(false)), row("beside three references", of(true))],
        )
    }

    /// What `--sensitivity` predicts, beside what came of it.
    fn chances(&self) -> Table {
        let bins = [(0.0, 0.2), (0.2, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.01)];
        let row = |(low, high): (f64, f64)| {
            let of: Vec<(f64, &Row)> = self
                .rows
                .iter()
                .filter_map(|row| row.judged.predicted.map(|chance| (chance, row)))
                .filter(|(chance, _)| (low..high).contains(chance))
                .collect();
            let count = of.len();
            let named = of.iter().filter(|(_, row)| row.judged.alone.is_named()).count();
            let mean = of.iter().map(|(chance, _)| chance).sum::<f64>() / count as f64;
            let mean = if count > 0 { format!("{mean:.2}") } else { "–".into() };
            let ends = lab::chance::wilson(named, count);
            format!(
                "{low:.1} to {:.1} | {mean} | {named} of {count} | {:.2} to {:.2}",
                high.min(1.0),
                ends[0],
                ends[1]
            )
        };
        (
            "concealed_predicted",
            "predicted chance | in the mean | named | 95 % interval of their chance",
            bins.into_iter().map(row).collect(),
        )
    }
}

fn counts(all: &[&Said]) -> String {
    let count = |is: fn(&Said) -> bool| all.iter().filter(|said| is(said)).count();
    if all.is_empty() {
        return "–".into();
    }
    format!(
        "{} first, {} class, {} named, {} noticed, {} misled of {}",
        count(|said| said.place == Some(0)),
        count(|said| said.is_in_class),
        count(|said| said.place.is_some()),
        count(|said| said.is_noticed),
        count(|said| said.is_misled),
        all.len()
    )
}

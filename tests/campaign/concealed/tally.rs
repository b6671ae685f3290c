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
    strength: f64,
    predicted: Option<f64>,
    alone: Counted,
    beside: Option<Counted>,
}

#[derive(Clone, Copy)]
struct Counted {
    is_first: bool,
    is_in_class: bool,
    is_named: bool,
    is_noticed: bool,
    is_misled: bool,
    error: Option<(f64, f64)>,
}

type Table = (&'static str, &'static str, Vec<String>);

impl Tally {
    pub fn add(&mut self, case: &Case, judged: &Judged) {
        let counted = |said: &Said| Counted {
            is_first: said.place == Some(0),
            is_in_class: said.is_in_class,
            is_named: said.place.is_some(),
            is_noticed: said.is_noticed,
            is_misled: said.is_misled,
            error: said.error,
        };
        self.rows.push(Row {
            effect: case.effect.name,
            by: case.by,
            strength: judged.strength,
            predicted: judged.predicted,
            alone: counted(&judged.alone),
            beside: judged.beside.as_ref().map(counted),
        });
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
            let rows = rows.iter().filter(|row| (row.strength >= 1.0) == is_strong);
            let counted: Vec<Counted> =
                rows.filter_map(|row| if is_beside { row.beside } else { Some(row.alone) }).collect();
            counts(&counted)
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
            let alone: Vec<Counted> = of.iter().map(|row| row.alone).collect();
            let beside: Vec<Counted> = of.iter().filter_map(|row| row.beside).collect();
            rows.push(format!("{name} | {} | {}", counts(&alone), counts(&beside)));
        };
        for (low, high) in classes {
            let name = if high.is_finite() { format!("{low} to {high}") } else { format!("from {low}") };
            push(name, &|row| (low..high).contains(&row.strength));
        }
        push("from 1, put in by gripd".into(), &|row| row.strength >= 1.0 && row.by == By::Gripd);
        push("from 1, put in by the other tool".into(), &|row| row.strength >= 1.0 && row.by == By::Tool);
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
        let of = |beside: bool| {
            let said =
                self.rows.iter().filter_map(move |row| if beside { row.beside } else { Some(row.alone) });
            said.filter_map(|counted| counted.error).collect()
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
                .filter_map(|row| row.predicted.map(|chance| (chance, row)))
                .filter(|(chance, _)| (low..high).contains(chance))
                .collect();
            let count = of.len();
            let named = of.iter().filter(|(_, row)| row.alone.is_named || row.alone.is_in_class).count();
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

fn counts(all: &[Counted]) -> String {
    let count = |is: fn(&Counted) -> bool| all.iter().filter(|one| is(one)).count();
    if all.is_empty() {
        return "–".into();
    }
    format!(
        "{} first, {} class, {} named, {} noticed, {} misled of {}",
        count(|one| one.is_first),
        count(|one| one.is_in_class),
        count(|one| one.is_named),
        count(|one| one.is_noticed),
        count(|one| one.is_misled),
        all.len()
    )
}

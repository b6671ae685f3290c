//! The subcommand: which experiments, two at a time, and where the results go.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use clap::Args;

use crate::cli::Failure;
use crate::cli::desk::output::Output;
use crate::cli::desk::progress::Progress;
use lab::reproduce::{Done, Experiment, ExperimentError, Picture, experiments, page, table};

/// How many at a time.
const THREADS: usize = 2;

/// Carries the experiments out and prints what was claimed, what comes out, and whether it holds. A claim
/// that differs is a result; the exit code is 1 only if an experiment could not be carried out.
#[derive(Args)]
pub struct Reproduce {
    /// Draw the pictures into this folder, one SVG file each, and a page of all of them (index.html).
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only this figure, or all of a chapter (`4.9`, `5`); may be given several times.
    #[arg(long, value_name = "FIG")]
    only: Vec<String>,
}

impl Reproduce {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let chosen = choose(&self.only)?;
        if let Some(folder) = &self.out {
            fs::create_dir_all(folder).map_err(|e| {
                Failure::work(format_args!("cannot make the folder {}: {e}", folder.display()))
            })?;
        }
        let done = carry_out(&chosen)?;
        io::stdout().write_all(table::text(&done).as_bytes())?;
        if let Some(folder) = &self.out {
            draw(folder, &done)?;
        }
        let failed: Vec<String> =
            done.iter().filter_map(|done| done.outcome.as_ref().err().map(ToString::to_string)).collect();
        if failed.is_empty() { Ok(()) } else { Err(Failure::work(failed.join("; "))) }
    }
}

/// All, or those asked for.
fn choose(only: &[String]) -> Result<Vec<Experiment>, Failure> {
    if let Some(unknown) = only.iter().find(|only| !experiments().any(|it| shows(it.figure, only))) {
        let mut figures: Vec<&str> = Vec::new();
        for part in experiments().flat_map(|it| it.figure.split(", ")) {
            if !figures.contains(&part) {
                figures.push(part);
            }
        }
        return Err(Failure::usage(format_args!(
            "no experiment shows figure `{unknown}`; there are {}",
            figures.join(", ")
        )));
    }
    Ok(experiments().filter(|it| only.is_empty() || only.iter().any(|only| shows(it.figure, only))).collect())
}

/// Is `asked` (a figure, a chapter, or the name of the experiment) among `figure` (`5.6`, `4.5–4.7`,
/// `5.1, 5.3`)?
fn shows(figure: &str, asked: &str) -> bool {
    let is = |name: &str| name == asked || name.replace('–', "-") == asked;
    if is(figure) {
        return true;
    }
    figure.split(", ").any(|part| {
        if is(part) {
            return true;
        }
        let (first, last) = part.split_once('–').unwrap_or((part, part));
        match (number(first), number(last), number(asked)) {
            (Some(first), Some(last), Some(asked)) => first <= asked && asked <= last,
            (Some((chapter, _)), _, None) => asked.parse() == Ok(chapter),
            _ => false,
        }
    })
}

/// `5.11` is chapter 5, number 11.
fn number(figure: &str) -> Option<(u32, u32)> {
    let (chapter, number) = figure.split_once('.')?;
    Some((chapter.parse().ok()?, number.parse().ok()?))
}

/// Two at a time, the results in the order of the experiments.
fn carry_out(chosen: &[Experiment]) -> Result<Vec<Done>, Failure> {
    let progress = Progress::of_parts(chosen.len());
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(experiment) = chosen.get(index).copied() else { return done };
            progress.begin(format!("{}: {}", experiment.figure, experiment.title));
            let outcome =
                (experiment.run)().map_err(|reason| ExperimentError { figure: experiment.figure, reason });
            progress.part_done();
            done.push((index, Done { experiment, outcome }));
        }
    };
    let mut all = Vec::with_capacity(chosen.len());
    thread::scope(|scope| {
        let workers: Vec<_> = (0..THREADS).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map(|done| all.extend(done)))
    })
    .map_err(|_| Failure::work("an experiment ended in a panic, which is a bug"))?;
    progress.finish();
    all.sort_by_key(|(index, _)| *index);
    Ok(all.into_iter().map(|(_, done)| done).collect())
}

/// Every picture, and the page.
fn draw(folder: &Path, done: &[Done]) -> Result<(), Failure> {
    for Picture { name, plot, .. } in
        done.iter().filter_map(|done| done.outcome.as_ref().ok()).flat_map(|outcome| &outcome.pictures)
    {
        write(&folder.join(format!("{name}.svg")), &plot.svg_file().map_err(Failure::work)?)?;
    }
    write(&folder.join("index.html"), &page::html(done).map_err(Failure::work)?)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let mut output = Output::create(path)?;
    output.write_all(text.as_bytes())?;
    output.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::reproduce::Outcome;

    #[test]
    fn a_figure_is_found_in_a_range_and_in_a_list_and_by_its_chapter() {
        for asked in ["4.5", "4.6", "4.7", "4", "4.5–4.7", "4.5-4.7"] {
            assert!(shows("4.5–4.7", asked), "{asked}");
        }
        assert!(shows("5.1, 5.3", "5.3") && shows("5.11", "5.11"));
        for asked in ["4.8", "5", "4.", "", "4.50"] {
            assert!(!shows("4.5–4.7", asked), "{asked}");
        }
        assert!(!shows("5.1, 5.3", "5.2") && !shows("5.1", "5.11"));
    }

    #[test]
    fn every_name_that_is_listed_can_be_asked_for() {
        let Err(Failure::Usage(text)) = choose(&["42".into()]) else { panic!("there is no chapter 42") };
        let names: Vec<&str> = text.split_once("there are ").unwrap().1.split(", ").collect();
        assert!(names.contains(&"eq. 6.2") && names.contains(&"8.2"), "{names:?}");
        for (index, name) in names.iter().enumerate() {
            assert!(!names[..index].contains(name), "{name} twice");
            assert!(choose(&[(*name).to_owned()]).is_ok(), "{name} is listed and refused");
        }
    }

    #[test]
    fn every_experiment_stands_once_and_in_order() {
        let figures: Vec<&str> = experiments().map(|it| it.figure).collect();
        for (index, figure) in figures.iter().enumerate() {
            assert!(!figures.iter().skip(index + 1).any(|other| other == figure), "{figure} twice");
        }
    }

    #[test]
    fn one_failure_stops_no_other_and_the_order_stays() {
        fn fails() -> Result<Outcome, String> {
            Err("no road".into())
        }
        fn works() -> Result<Outcome, String> {
            Ok(Outcome::default())
        }
        let experiment = |figure, run| Experiment { figure, title: "", run };
        let all = [experiment("1.1", fails as fn() -> _), experiment("1.2", works), experiment("1.3", works)];
        let done = carry_out(&all).unwrap();
        assert_eq!(done.iter().map(|done| done.experiment.figure).collect::<Vec<_>>(), ["1.1", "1.2", "1.3"]);
        assert_eq!(done[0].outcome.as_ref().unwrap_err().to_string(), "figure 1.1: no road");
        assert!(done[1].outcome.is_ok() && done[2].outcome.is_ok());
    }

    #[test]
    fn a_chapter_is_carried_out_and_drawn() {
        let done = carry_out(&choose(&["4".into()]).unwrap()).unwrap();
        let pictures: Vec<&str> = done
            .iter()
            .flat_map(|done| &done.outcome.as_ref().unwrap().pictures)
            .map(|it| it.name.as_str())
            .collect();
        assert!(pictures.len() > 2, "{pictures:?}");
        let folder = tempfile::tempdir().unwrap();
        draw(folder.path(), &done).unwrap();
        let page = fs::read_to_string(folder.path().join("index.html")).unwrap();
        for Done { experiment, .. } in &done {
            assert!(page.contains(experiment.figure), "{}", experiment.figure);
        }
        assert!(pictures.iter().all(|name| folder.path().join(format!("{name}.svg")).is_file()));
    }
}

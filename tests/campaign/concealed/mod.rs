//! Effects put into real drives, and what `gripd explain` says of them, alone and beside healthy drives of the same car.
//! Half of them are put in by `gripd conceal`, half by the tool that comes with the recordings, which has equations of its
//! own. The unchanged drive is the control: what it has as well was not put in.

mod answers;
mod judge;
mod plan;
mod tally;

mod by_hand {
    use rayon::prelude::*;
    use testing::results::Section;

    use super::answers::Answers;
    use super::judge::Judged;
    use super::plan::{Case, HEALTHY, cases};
    use super::tally::Tally;
    use crate::found::{findings, told};

    /// Drives with answers that are there already are not asked of again: `CONCEALED_ANSWERS` names another folder for
    /// them, as after a change of the program. `CONCEALED_CASES=84`: the first 84 only, the larger ones.
    /// `GRIPD_RENEW=1 YARDSTICK_PYTHON=… cargo test --test campaign by_hand::concealed_in_real_drives -- --ignored
    /// --nocapture`.
    #[test]
    #[ignore = "by hand: an hour, Python with numba for the tool that conceals; what was interrupted goes on"]
    fn concealed_in_real_drives() {
        let Some(answers) = Answers::in_folder() else { return };
        let mut tally = Tally::default();
        let most = std::env::var("CONCEALED_CASES").map_or(usize::MAX, |most| most.parse().unwrap());
        let all = cases();
        let seed = format!("recorded; courses of seed 1; {} of {} cases", most.min(all.len()), all.len());
        let ask = |case: Case| {
            let judged = answers.of_case(&case);
            let said = judged.as_ref().map_or_else(|reason| format!("refused: {reason}"), Judged::to_string);
            println!("{} | {} | {said}", case.drive.name, case.told());
            (case, judged)
        };
        let asked: Vec<_> = all.into_par_iter().take(most).map(ask).collect();
        for (case, judged) in asked {
            match judged {
                Ok(judged) => tally.add(&case, judged),
                Err(_) => tally.refused.push(case.told()),
            }
        }
        for (name, header, rows) in tally.tables() {
            Section { name, seed: &seed, tolerance: 0.1, header }.check(&rows);
        }
    }

    /// What healthy drives are said to have that other healthy drives have not.
    #[test]
    #[ignore = "by hand: ten minutes, and what was interrupted goes on"]
    fn healthy_beside_healthy() {
        let Some(answers) = Answers::in_folder() else { return };
        let of = |place: usize| {
            let references: Vec<&str> = (1..=3).map(|by| HEALTHY[(place + by) % HEALTHY.len()]).collect();
            let drive = HEALTHY[place];
            let answer = answers.of_healthy(drive, &references);
            let verdict = answer["verdict"].as_str().unwrap_or_default();
            let found: Vec<String> = findings(&answer).iter().map(told).collect();
            format!("{drive} | {verdict} | {}", found.join("; "))
        };
        let mut rows: Vec<String> = (0..HEALTHY.len()).into_par_iter().map(of).collect();
        let changed = rows.iter().filter(|row| !row.contains("| unchanged |")).count();
        rows.push(format!("all {} | {changed} changed | ", HEALTHY.len()));
        Section {
            name: "healthy_beside_healthy",
            seed: "recorded",
            tolerance: 0.1,
            header: "drive | beside the next three | found",
        }
        .check(&rows);
    }
}

//! The page as a whole.

use super::*;
use crate::report::escape;

/// Every tag that opens closes, in order, and attributes are quoted; in scripts nothing is a tag.
fn assert_well_formed(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let html = without_scripts(html);
    let mut rest = html.split_once("<!DOCTYPE html>").expect("a document type").1;
    while let Some((_, after)) = rest.split_once('<') {
        let (tag, behind) = after.split_once('>').expect("a tag that ends");
        assert!(!tag.contains('<'), "a stray < before <{tag}>");
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag}>");
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap_or("");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "</{name}> closes something else");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = behind;
    }
    assert!(open.is_empty(), "{open:?} never close");
}

fn without_scripts(html: &str) -> String {
    let mut parts = html.split("<script");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.split_once("</script>").expect("a script that ends").1)
}

/// The numbers of the plots.
fn data(html: &str) -> serde_json::Value {
    let text = html.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(text).unwrap()
}

fn titled<'a>(data: &'a serde_json::Value, kind: &str, title: &str) -> &'a serde_json::Value {
    let all = data[kind].as_array().unwrap();
    all.iter().find(|it| it["title"] == title).unwrap_or_else(|| panic!("no `{title}`"))
}

fn part<'a>(html: &'a str, id: &str) -> &'a str {
    let begin = html.find(&format!("id=\"{id}\"")).unwrap_or_else(|| panic!("no part {id}"));
    let rest = &html[begin..];
    let end = rest[10..].find("<h2 class=\"section\"").map_or(rest.len(), |end| end + 10);
    &rest[..end]
}

#[test]
fn every_verdict_gives_a_sound_page_that_says_it() {
    for (explanation, sentence) in sample::all() {
        let html = page(&explanation);
        assert_well_formed(&html);
        assert!(html.contains(&format!("<h1>{}</h1>", escape(sentence))), "{sentence}");
        let shown = without_scripts(&html);
        let text = shown.split_once("<body>").unwrap().1;
        for bad in ["NaN", "inf ", ">inf", "<dry>", "<learnt", "{}", " _", "src="] {
            assert!(!text.contains(bad), "{bad} in the page of {sentence}");
        }
        assert!(html.contains("default-src 'none'") && !shown.contains("https://"), "nothing is fetched");
        let first = html.find("</header>").unwrap();
        assert!(html[..first].contains(words::verdict(explanation.verdict)));
        let plot = html[first..].find("<section class=\"plots\">").unwrap();
        assert!(plot < 20, "the plots are next to the answer");
        let titles: Vec<_> =
            data(&html)["panels"].as_array().unwrap().iter().map(|it| it["title"].clone()).collect();
        assert_eq!(
            titles[..4],
            ["Yaw rate", "Yaw rate: error", "Lateral acceleration", "Lateral acceleration: error"]
        );
    }
}

#[test]
fn a_finding_is_on_the_first_screen_with_its_numbers() {
    let html = page(&sample::missing());
    let first = html.split_once("</header>").unwrap().0;
    for told in [
        "move load between the wheels",
        "0.553 ± 0.021 m",
        "97 %",
        "0.910 → 0.360 m/s²",
        "81.7 → 92.8 %",
        "+11.1 points; 95 %: +8.4 to +13.7",
        "cannot tell it from body roll at the accelerometer",
    ] {
        assert!(first.contains(told), "{told} is missing in {first}");
    }
    let parts = ["plots", "where", "missing", "sure", "ranking", "reading"];
    let places = parts.map(|id| html.find(&format!("id=\"{id}\"")).unwrap());
    assert!(places.is_sorted(), "{places:?}");
    assert!(part(&html, "where").contains("|a<sub>y</sub>| above 5 m/s²"));
    let missing = part(&html, "missing");
    assert!(
        missing.contains("C ∝ x<sup>1 − e − g/2 ln x</sup>")
            && missing.contains("Hard turns without braking"),
        "{missing}"
    );
    assert!(missing.contains("13.21 ± 0.14") && missing.contains("14.93 ± 0.21"), "what moved");
    assert!(missing.contains("hardly moved") && missing.contains("Steering ratio"));
    let sure = part(&html, "sure");
    assert!(sure.contains("+8.4 to +13.7") && sure.contains("+422.8") && sure.contains("2310.0"), "{sure}");
}

#[test]
fn a_course_is_shown_in_degrees_and_the_chain_is_linked() {
    let html = page(&sample::several());
    let data = data(&html);
    let course = titled(&data, "panels", "Road bank: its course");
    assert_eq!(course["axis"], "road bank, °");
    // It is of the second recording, which stands behind the first one.
    let values = course["series"][0]["values"].as_array().unwrap();
    let first = values.iter().position(serde_json::Value::is_number).unwrap();
    let begins = data["clocks"][1]["from_s"].as_f64().unwrap();
    assert!((data["times"][first].as_f64().unwrap() - begins).abs() < 1.0, "{begins}");
    let lanes = &titled(&data, "panels", "Where they differ")["lanes"];
    assert_eq!(lanes.as_array().unwrap().len(), 3, "{lanes}");
    let from = lanes[0]["times"][0].as_f64().unwrap();
    assert!((from - begins - 100.0).abs() < 0.1, "100 s of the second recording: {from}");
    assert!(html.contains("Late yaw rate: delay 43.1 ± 2.1 ms, probability &gt; 99 %"));
    assert!(html.contains("href=\"#chain\"") && part(&html, "chain").contains("learnt by the estimators"));
}

#[test]
fn what_is_unknown_or_not_driven_is_said_first() {
    let html = page(&sample::unknown());
    let first = html.split_once("</header>").unwrap().0;
    assert!(first.contains("in the yaw moment balance, seen in yaw rate (braking harder"), "{first}");
    assert!(first.contains("81.7 → 92.8 %"), "what a correction without a name gains");
    let html = page(&sample::insufficient());
    let first = html.split_once("</header>").unwrap().0;
    assert!(first.contains("<li>Steady turns both ways with 3 to 5 m/s².</li>"), "{first}");
    assert!(first.contains("straight ahead &amp; hard"));
    let yaw_rate = titled(&data(&html), "panels", "Yaw rate")["series"].clone();
    assert_eq!(yaw_rate.as_array().unwrap().len(), 2, "there is no extended model to be drawn");
}

#[test]
fn where_nothing_is_missing_the_error_is_held_against_what_was_recorded() {
    let mut explanation = sample::adequate();
    explanation.fit.baseline.holdout = [("yaw_rate".into(), 98.0), ("speed".into(), 90.0)].into();
    explanation.fit.extended = explanation.fit.baseline.clone();
    // By construction, without a finding.
    explanation.unexplained = [("yaw_rate".into(), 1.0), ("speed".into(), 1.0)].into();
    let html = page(&explanation);
    let first = html.split_once("</header>").unwrap().0;
    assert!(first.contains("at most 1.0 % of the variance that was recorded (speed)"), "{first}");
    assert!(!html.contains("100.0 %") && !html.contains("unexplained"), "nothing is left of nothing");
    let sure = part(&html, "sure");
    assert!(!sure.contains("extended") && sure.contains("error / recorded variance"), "{sure}");
    assert!(part(&page(&sample::missing()), "sure").contains("left of the plain model's error"));
}

#[test]
fn an_answer_with_nothing_in_it_is_still_a_page() {
    let mut explanation = sample::adequate();
    explanation.traces.clear();
    explanation.split.clear();
    explanation.ranking.clear();
    explanation.fit = Default::default();
    explanation.prediction_fit = Default::default();
    explanation.parameters = Default::default();
    explanation.unexplained.clear();
    let html = page(&explanation);
    assert_well_formed(&html);
    assert!(html.contains("There is nothing to draw"));
    let mut explanation = sample::missing();
    for trace in &mut explanation.traces {
        trace.extended.clear();
        trace.baseline.iter_mut().for_each(|value| *value = f64::NAN);
    }
    explanation.findings.clear();
    explanation.place.intervals = vec![[f64::NAN, 3.0]];
    let html = page(&explanation);
    assert_well_formed(&html);
    assert!(!without_scripts(&html).contains("NaN"));
    assert!(
        titled(&data(&html), "panels", "Yaw rate: error")["empty"].as_str().unwrap().contains("no value")
    );
}

#[test]
fn an_hour_of_several_channels_is_below_three_megabytes() {
    let html = page(&sample::long());
    println!("{:.2} MB", html.len() as f64 / 1e6);
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
    let data = data(&html);
    assert!(data["stretch_s"].as_f64().unwrap() < 1.5, "{}", data["stretch_s"]);
    assert_eq!(data["panels"].as_array().unwrap().len(), 10);
}

/// `GRIPD_PAGES=/tmp/pages cargo test sample_pages -- --ignored` and look at them.
#[test]
#[ignore = "writes files to look at"]
fn sample_pages() {
    let Some(folder) = std::env::var_os("GRIPD_PAGES").map(std::path::PathBuf::from) else { return };
    std::fs::create_dir_all(&folder).unwrap();
    for (name, (explanation, _)) in
        ["missing", "several", "adequate", "unknown", "insufficient"].iter().zip(sample::all())
    {
        std::fs::write(folder.join(format!("{name}.html")), page(&explanation)).unwrap();
        let mut text = Vec::new();
        print(&explanation, &mut text).unwrap();
        std::fs::write(folder.join(format!("{name}.txt")), text).unwrap();
    }
}

#[test]
fn numbers_in_doubt_and_what_the_audit_is_sure_of_are_told_in_text_and_page() {
    use identify::Doubt;
    use physics::model::Uncertain;
    let mut explanation = sample::unknown();
    let table = Some(Uncertain { value: 1000.0, std: 250.0 });
    let inertia = Doubt::of((3490.0, 90.0), table, true).unwrap();
    explanation.in_doubt = [("yaw_inertia_kgm2".into(), inertia)].into();
    explanation.certain = vec!["sensor_sign of yaw_rate, certain: it runs against the wheels".into()];
    let mut text = Vec::new();
    super::print(&explanation, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let told = "Yaw inertia 3490 ± 90 kg m²: at the bound of the search, 10.0 standard deviations from";
    assert!(text.replace("\n    ", " ").contains(told) && text.contains("1000 ± 250 kg m²"), "{text}");
    let places = ["Unknown physics", "First of all", "Fit on held-out"].map(|part| text.find(part).unwrap());
    assert!(places.is_sorted(), "{text}");
    let html = page(&explanation);
    let first = html.split_once("</header>").unwrap().0;
    assert!(first.contains("it runs against the wheels"), "{first}");
    assert!(html.contains("In doubt: left as they were") && html.contains("1000 ± 250 kg m²"));
    let json = serde_json::to_value(&explanation).unwrap();
    let doubt = &json["in_doubt"]["yaw_inertia_kgm2"];
    assert!(doubt["at_bound"] == true && doubt["deviations"] == 9.96, "{doubt}");
}

/// GIVEN what somebody's simulation leaves out THEN the page has three lines over time, and says what to change in the model,
/// what that takes away, and what a second pass changed.
#[test]
fn beside_a_simulation_there_are_three_lines_and_what_to_change() {
    let html = page(&sample::beside_a_simulation());
    assert_well_formed(&html);
    let data = data(&html);
    for title in ["Yaw rate", "Lateral acceleration"] {
        let panel = titled(&data, "panels", title);
        let names: Vec<&str> =
            panel["series"].as_array().unwrap().iter().map(|it| it["name"].as_str().unwrap()).collect();
        assert_eq!(
            names,
            ["measured", "your simulation", "your simulation with what was found"],
            "lines of {title}"
        );
    }
    let change = part(&html, "change");
    for words in [
        "Your model has no load transfer",
        "outer front tire is 11 % too soft",
        "40 % in yaw rate and 20 % in lateral acceleration",
        "1.20 °/s (rms), 6.88 °/s at most, at 34.2 s",
        "moved by more than its uncertainty; first delay 60.0 ± 2.0 ms",
        "Found first and not needed beside the rest: body roll",
        "All of it together",
        "97 % in yaw rate",
    ] {
        assert!(change.contains(words), "{words} is missing in\n{change}");
    }
}

//! What was found, as TOML for the configuration.

use super::{Story, digits, number};
use identify::Identified;
use physics::Quantity;

/// `[vehicle]` with what the recordings tell, and the sensors' offsets as comments: in `[signals]` they
/// stand within a quantity's own entry.
pub fn toml(story: &Story<'_>) -> String {
    let records = story.records;
    let from = match records {
        [one] => one.name.clone(),
        several => format!("{} recordings", several.len()),
    };
    let mut text = format!("# gripd identify, {:.0} s of {from}\n[vehicle]\n", story.found.seconds);
    let told = || story.found.parameters.iter().filter(|parameter| parameter.identifiable);
    if told().next().is_none() {
        text += "# nothing in it was identifiable\n";
    }
    let mut comments = String::new();
    for parameter in told() {
        let decimals = digits(parameter.value, parameter.std);
        let (value, std) = (number(parameter.value, decimals), number(parameter.std, decimals + 1));
        let line = |key: &str| format!("{key} = {{ value = {}, std = {} }}\n", float(&value), float(&std));
        match parameter.name {
            "lateral_stiffness" => {
                text += &line("lateral_stiffness_front");
                text += &line("lateral_stiffness_rear");
            }
            name if name.starts_with("slip_offset") => {
                let wheel = name.trim_start_matches("slip_offset_").to_uppercase();
                comments += &format!("#   wheel {wheel}: turns {}\n", faster(parameter));
                comments += "#     (no key: gripd finds it while it runs)\n";
            }
            name if name.ends_with("_offset") => comments += &signal_offset(story, name, parameter),
            name => text += &line(name),
        }
    }
    if !comments.is_empty() {
        text += "# sensors:\n";
        text += &comments;
    }
    text
}

/// TOML takes `12` for another kind of number than `12.0`; gripd takes both.
fn float(text: &str) -> String {
    if text.contains('.') { text.to_owned() } else { format!("{text}.0") }
}

fn faster(parameter: &Identified) -> String {
    let (value, std) = (100.0 * parameter.value, 100.0 * parameter.std);
    let decimals = digits(value, std);
    let word = if value < 0.0 { "slower" } else { "faster" };
    let (value, std) = (number(value.abs(), decimals), number(std, decimals));
    format!("{value} ± {std} % {word} than its table radius says")
}

/// The entry's offset as it is, and as it should be.
fn signal_offset(story: &Story<'_>, name: &str, parameter: &Identified) -> String {
    let quantity = Quantity::ALL.into_iter().find(|quantity| name == format!("{}_offset", quantity.name()));
    let Some(quantity) = quantity else { return String::new() };
    let now = story.offsets[quantity as usize];
    let decimals = digits(parameter.value, parameter.std);
    format!(
        "#   signals.{}: reads {} ± {} {} too much; offset = {} (is {now})\n",
        quantity.name(),
        number(parameter.value, decimals),
        number(parameter.std, decimals),
        parameter.unit,
        number(now - parameter.value, decimals)
    )
}

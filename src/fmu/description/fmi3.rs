//! FMI 3.0.

use std::fmt::Write as _;

use super::{BEFORE_VARIABLES, LIBRARY, about, escaped, kind, range, start, units};
use crate::car::Car;
use crate::variables::{Causality, Variable};

pub(super) fn description(car: &Car, variables: &[Variable], token: &str) -> String {
    let (name, about) = (escaped(&car.name), about(car));
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" instantiationToken=\"{token}\"\n  \
         description=\"{about}\"\n  generationTool=\"gripd {version}\" variableNamingConvention=\"structured\">\n  \
         <CoSimulation modelIdentifier=\"{LIBRARY}\" canHandleVariableCommunicationStepSize=\"true\" \
         canGetAndSetFMUState=\"true\"/>\n"
    );
    text.push_str(&units(variables));
    text.push_str(BEFORE_VARIABLES);
    let mut structure = [String::new(), String::new()];
    for (reference, variable) in variables.iter().enumerate() {
        let kind = kind(variable.causality);
        let typed = if variable.is_switch() { "Boolean" } else { "Float64" };
        let unit = if variable.is_switch() { String::new() } else { format!(" unit=\"{}\"", variable.unit) };
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "    <{typed} name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {kind}{unit}{}{}/>",
            escaped(&variable.name),
            escaped(&variable.description),
            range(variable),
            start(variable)
        );
        if variable.causality == Causality::Output {
            let [outputs, unknowns] = &mut structure;
            let _ = writeln!(outputs, "    <Output valueReference=\"{reference}\"/>");
            let _ = writeln!(unknowns, "    <InitialUnknown valueReference=\"{reference}\"/>");
        }
    }
    let [outputs, unknowns] = structure;
    let _ = write!(
        text,
        "  </ModelVariables>\n  <ModelStructure>\n{outputs}{unknowns}  </ModelStructure>\n</fmiModelDescription>\n"
    );
    text
}

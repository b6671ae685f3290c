//! FMI 2.0.

use std::fmt::Write as _;

use super::{BEFORE_VARIABLES, LIBRARY, about, escaped, kind, range, start, units};
use crate::car::Car;
use crate::variables::{Causality, Variable};

pub(super) fn description(car: &Car, variables: &[Variable], token: &str) -> String {
    let (name, about) = (escaped(&car.name), about(car));
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{token}\"\n  description=\"{about}\"\n  \
         generationTool=\"gripd {version}\" variableNamingConvention=\"structured\" numberOfEventIndicators=\"0\">\n  \
         <CoSimulation modelIdentifier=\"{LIBRARY}\" canHandleVariableCommunicationStepSize=\"true\" \
         canInterpolateInputs=\"true\" canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\"/>\n"
    );
    text.push_str(&units(variables));
    text.push_str(BEFORE_VARIABLES);
    let mut outputs = String::new();
    for (reference, variable) in variables.iter().enumerate() {
        let kind = kind(variable.causality);
        let (start, range) = (start(variable), range(variable));
        let typed = if variable.is_switch() {
            format!("<Boolean{start}/>")
        } else {
            format!("<Real unit=\"{}\"{range}{start}/>", variable.unit)
        };
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {kind}>{typed}\
             </ScalarVariable>",
            escaped(&variable.name),
            escaped(&variable.description)
        );
        if variable.causality == Causality::Output {
            // Counted from one.
            let _ = writeln!(outputs, "      <Unknown index=\"{}\"/>", reference + 1);
        }
    }
    let _ = write!(
        text,
        "  </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n{outputs}    </Outputs>\n    \
         <InitialUnknowns>\n{outputs}    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n"
    );
    text
}

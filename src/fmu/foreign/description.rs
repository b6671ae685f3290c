//! What an FMU says of itself.

use roxmltree::{Document, Node};

use crate::Version;

/// Types of variables, as far as they can be set or asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Kind {
    /// Real, Float64.
    Real,
    /// Float32.
    Single,
    /// Integer, Int32.
    Integer,
    /// Boolean.
    Switch,
}

/// What a variable is for, as far as that matters to who runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It is to be given.
    Input,
    /// It comes out.
    Output,
    /// It may be set before the start.
    Parameter,
    /// Something else that can be asked for.
    Other,
}

/// A scalar variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalar {
    /// Its name.
    pub name: String,
    /// How it is called over the border.
    pub reference: u32,
    /// Its type.
    pub kind: Kind,
    /// What it is for.
    pub role: Role,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// Where it starts.
    pub start: Option<f64>,
    /// Its smallest and largest value, where they are told.
    pub range: (Option<f64>, Option<f64>),
}

/// An FMU for co-simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The version of FMI.
    pub version: Version,
    /// The model's name.
    pub name: String,
    /// What the library wants to hear.
    pub token: String,
    /// The library's name, without its ending.
    pub identifier: String,
    /// Inputs may be given with their rates.
    pub takes_rates: bool,
    /// The step that it asks for, s.
    pub step_s: Option<f64>,
    /// Variables that are no arrays and of a type that can be used.
    pub variables: Vec<Scalar>,
}

impl Description {
    /// Reads `modelDescription.xml`.
    ///
    /// # Errors
    /// What is wrong with it, or why an FMU of its kind cannot be run.
    pub fn parse(text: &str) -> Result<Self, String> {
        let document = Document::parse(text).map_err(|error| error.to_string())?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(format!("the root is <{}>, not <fmiModelDescription>", root.tag_name().name()));
        }
        let version = match root.attribute("fmiVersion").unwrap_or_default() {
            version if version.starts_with("2.") => Version::Two,
            version if version.starts_with("3.") => Version::Three,
            version => return Err(format!("FMI `{version}` cannot be run; export it as FMI 2.0 or 3.0")),
        };
        let child = |name: &str| root.children().find(|node| node.has_tag_name(name));
        let simulation = child("CoSimulation")
            .ok_or("it is for model exchange only; export it for co-simulation, with a solver of its own")?;
        if simulation.attribute("needsExecutionTool") == Some("true") {
            return Err("it needs the program that made it to run beside it; export it as stand-alone".into());
        }
        let token = match version {
            Version::Two => "guid",
            Version::Three => "instantiationToken",
        };
        let needed = |node: Node<'_, '_>, name: &str| {
            node.attribute(name)
                .map(str::to_owned)
                .ok_or_else(|| format!("<{}> has no attribute {name}", node.tag_name().name()))
        };
        let identifier = needed(simulation, "modelIdentifier")?;
        // It becomes the name of a file.
        if identifier.is_empty()
            || !identifier.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'))
        {
            return Err(format!("the modelIdentifier `{identifier}` is no name of a library"));
        }
        let experiment = child("DefaultExperiment").and_then(|node| number(node, "stepSize"));
        let fixed = number(simulation, "fixedInternalStepSize");
        let types: Vec<_> = child("TypeDefinitions").into_iter().flat_map(|node| node.children()).collect();
        let variables = child("ModelVariables").ok_or("there are no <ModelVariables>")?;
        let variables = variables.children().filter(Node::is_element);
        let variables: Vec<_> = match version {
            Version::Two => variables.filter_map(|node| of_two(node, &types)).collect(),
            Version::Three => variables.filter_map(|node| of_three(node, &types)).collect(),
        };
        Ok(Self {
            version,
            name: needed(root, "modelName")?,
            token: needed(root, token)?,
            identifier,
            takes_rates: version == Version::Two
                && simulation.attribute("canInterpolateInputs") == Some("true"),
            step_s: fixed.or(experiment).filter(|step| *step > 0.0),
            variables,
        })
    }

    /// The variable of this name.
    pub fn named(&self, name: &str) -> Option<&Scalar> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// Names like one that is not there, or some of a role, to say what could have been meant.
    pub fn like(&self, name: &str, role: Role) -> String {
        let lower = name.to_lowercase();
        let is_like = |variable: &&Scalar| {
            let other = variable.name.to_lowercase();
            other.contains(&lower) || lower.contains(&other)
        };
        let mut names: Vec<_> = self.variables.iter().filter(is_like).map(|v| v.name.as_str()).collect();
        if names.is_empty() {
            names = self.variables.iter().filter(|v| v.role == role).map(|v| v.name.as_str()).collect();
        }
        let more = names.len() > MOST_NAMES;
        names.truncate(MOST_NAMES);
        match (names.is_empty(), more) {
            (true, _) => "it has none that could be meant".into(),
            (false, false) => format!("it has {}", names.join(", ")),
            (false, true) => format!("it has {}, …", names.join(", ")),
        }
    }
}

/// So many names fit into a message.
const MOST_NAMES: usize = 12;

fn number(node: Node<'_, '_>, name: &str) -> Option<f64> {
    node.attribute(name)?.trim().parse::<f64>().ok().filter(|number| number.is_finite())
}

fn start(node: Node<'_, '_>) -> Option<f64> {
    match node.attribute("start")?.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        text => text.parse().ok(),
    }
}

fn role(node: Node<'_, '_>) -> Role {
    match (node.attribute("causality"), node.attribute("variability")) {
        (Some("input"), _) => Role::Input,
        (Some("output"), _) => Role::Output,
        (Some("parameter"), Some("fixed" | "tunable") | None) => Role::Parameter,
        _ => Role::Other,
    }
}

/// A variable with the attributes of its type: in FMI 3.0 its own element, in FMI 2.0 one within.
fn scalar(
    node: Node<'_, '_>,
    typed: Node<'_, '_>,
    kind: Kind,
    declared: Option<Node<'_, '_>>,
) -> Option<Scalar> {
    let either = |name: &str| typed.attribute(name).or_else(|| declared?.attribute(name));
    let bound = |name: &str| either(name)?.trim().parse().ok();
    Some(Scalar {
        name: node.attribute("name")?.to_owned(),
        reference: node.attribute("valueReference")?.trim().parse().ok()?,
        kind,
        role: role(node),
        unit: either("unit").unwrap_or_default().to_owned(),
        start: start(typed),
        range: (bound("min"), bound("max")),
    })
}

fn of_two(node: Node<'_, '_>, types: &[Node<'_, '_>]) -> Option<Scalar> {
    let typed = node
        .children()
        .find(|node| matches!(node.tag_name().name(), "Real" | "Integer" | "Boolean" | "Enumeration"))?;
    let kind = match typed.tag_name().name() {
        "Real" => Kind::Real,
        "Boolean" => Kind::Switch,
        _ => Kind::Integer,
    };
    let declared = typed.attribute("declaredType").and_then(|name| {
        let of_name = types.iter().find(|node| node.attribute("name") == Some(name))?;
        of_name.children().find(|node| node.is_element())
    });
    scalar(node, typed, kind, declared)
}

fn of_three(node: Node<'_, '_>, types: &[Node<'_, '_>]) -> Option<Scalar> {
    let kind = match node.tag_name().name() {
        "Float64" => Kind::Real,
        "Float32" => Kind::Single,
        "Int32" => Kind::Integer,
        "Boolean" => Kind::Switch,
        _ => return None,
    };
    // An array.
    if node.children().any(|node| node.has_tag_name("Dimension")) {
        return None;
    }
    let declared = node
        .attribute("declaredType")
        .and_then(|name| types.iter().find(|node| node.attribute("name") == Some(name)).copied());
    scalar(node, node, kind, declared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::car::{Car, Part};
    use crate::description::description;
    use physics::model::Vehicle;

    #[test]
    fn what_is_written_is_read() {
        let car = Car { name: "a <car>".into(), part: Part::Car, vehicle: Vehicle::thesis(), effect: vec![] };
        for version in [Version::Two, Version::Three] {
            let read = Description::parse(&description(&car, version).unwrap()).unwrap();
            assert_eq!((read.version, read.name.as_str()), (version, "a <car>"));
            assert_eq!((read.step_s, read.identifier.as_str()), (Some(1e-3), "gripd"));
            let mass = read.named("vehicle.mass_kg").unwrap();
            assert_eq!((mass.role, mass.unit.as_str(), mass.start), (Role::Parameter, "kg", Some(1700.0)));
            assert_eq!(read.named("yaw_rate").unwrap().role, Role::Output);
            assert_eq!(read.named("holds_speed").unwrap().kind, Kind::Switch);
            assert_eq!(read.takes_rates, version == Version::Two);
            assert!(read.like("Yaw_Rate_1", Role::Output).contains("yaw_rate"));
        }
    }

    #[test]
    fn what_cannot_be_run_is_said() {
        let of = |body: &str| Description::parse(body).unwrap_err();
        for (body, expected) in [
            ("<html/>", "<html>"),
            ("no xml", "unknown token"),
            ("<fmiModelDescription fmiVersion='1.0'/>", "FMI `1.0`"),
            (
                "<fmiModelDescription fmiVersion='2.0'><ModelExchange/></fmiModelDescription>",
                "model exchange",
            ),
            (
                "<fmiModelDescription fmiVersion='2.0'><CoSimulation modelIdentifier='../x'/></fmiModelDescription>",
                "`../x`",
            ),
            (
                "<fmiModelDescription fmiVersion='2.0'><CoSimulation needsExecutionTool='true'/></fmiModelDescription>",
                "stand-alone",
            ),
            (
                "<fmiModelDescription fmiVersion='3.0'><CoSimulation modelIdentifier='x'/></fmiModelDescription>",
                "<ModelVariables>",
            ),
            (
                "<fmiModelDescription fmiVersion='3.0' modelName='x'><CoSimulation modelIdentifier='x'/>\
                 <ModelVariables/></fmiModelDescription>",
                "instantiationToken",
            ),
        ] {
            assert!(of(body).contains(expected), "{body}: {}", of(body));
        }
    }

    #[test]
    fn units_come_from_declared_types_too() {
        let text = "<fmiModelDescription fmiVersion='2.0' modelName='m' guid='g'><CoSimulation modelIdentifier='x'/>\
                    <TypeDefinitions><SimpleType name='Angle'><Real unit='deg' max='720'/></SimpleType></TypeDefinitions>\
                    <ModelVariables><ScalarVariable name='a' valueReference='7' causality='input'>\
                    <Real declaredType='Angle' start='1'/></ScalarVariable></ModelVariables></fmiModelDescription>";
        let read = Description::parse(text).unwrap();
        let variable = read.named("a").unwrap();
        assert_eq!((variable.reference, variable.unit.as_str()), (7, "deg"));
        assert_eq!((variable.range, variable.start), ((None, Some(720.0)), Some(1.0)));
    }
}

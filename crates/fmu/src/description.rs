//! What `modelDescription.xml` says, of either version of the standard.

use crate::FmuError;
use crate::unit::unit;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// The version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// A real variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// The number by which the FMU knows it.
    pub reference: u32,
    /// Its unit in Lacuna's spelling; empty where none is said.
    pub unit: String,
    /// Its value before anything is set; 0 where none is said.
    pub start: f64,
    /// The least value that it may have.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

/// A continuous state z.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The state itself.
    pub variable: Variable,
    /// The number of its derivative.
    pub derivative: u32,
}

/// What is evaluated, in the FMU's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The version of the standard.
    pub version: Version,
    /// Name of the model.
    pub name: String,
    /// Continuous states z.
    pub states: Vec<State>,
    /// Inputs u.
    pub inputs: Vec<Variable>,
    /// Outputs y.
    pub outputs: Vec<Variable>,
    /// Parameters p that may be set.
    pub parameters: Vec<Variable>,
    /// Whether it has derivatives of its own, by states and inputs.
    pub has_derivatives: bool,
    /// Whether a process holds one instance at most.
    pub once: bool,
    /// Name of the shared library.
    pub(crate) identifier: String,
    /// What the library is told, so that it can tell another description from its own.
    pub(crate) token: String,
}

/// A variable of any type, as the text has it.
struct Raw<'a> {
    node: Node<'a, 'a>,
    /// Where its numbers stand: the node itself, or its type in FMI 2.
    real: Option<Node<'a, 'a>>,
    kind: &'a str,
}

impl<'a> Raw<'a> {
    fn attribute(&self, name: &str) -> &'a str {
        self.node.attribute(name).unwrap_or_default()
    }

    fn is(&self, causality: &str) -> bool {
        self.attribute("causality") == causality
    }
}

struct Reader<'a> {
    root: Node<'a, 'a>,
    version: Version,
    variables: Vec<Raw<'a>>,
    /// Types by their names.
    types: HashMap<&'a str, Node<'a, 'a>>,
}

impl Description {
    /// Read `modelDescription.xml`.
    pub(crate) fn read(text: &str) -> Result<Self, FmuError> {
        let text = text.trim_start_matches('\u{feff}');
        let document = Document::parse(text).map_err(|e| FmuError::Description {
            line: Some(e.pos().row),
            message: e.to_string(),
        })?;
        Reader::new(document.root_element())?.read()
    }
}

impl<'a> Reader<'a> {
    fn new(root: Node<'a, 'a>) -> Result<Self, FmuError> {
        if !root.has_tag_name("fmiModelDescription") {
            let name = root.tag_name().name();
            return Err(wrong(root, format!("expected <fmiModelDescription>, found <{name}>")));
        }
        let version = match root.attribute("fmiVersion").unwrap_or_default() {
            v if v.starts_with("2.") => Version::Two,
            v if v.starts_with("3.") => Version::Three,
            other => {
                return Err(FmuError::unsupported(format!(
                    "is of FMI '{other}'; FMI 2.0 and 3.0 are supported: export it again"
                )));
            }
        };
        let listed = child(root, "ModelVariables").into_iter().flat_map(elements);
        let variables = listed.map(|node| Self::variable(node, version)).collect();
        let types = child(root, "TypeDefinitions").into_iter().flat_map(elements);
        let types = types.filter_map(|t| Some((t.attribute("name")?, t))).collect();
        Ok(Self { root, version, variables, types })
    }

    fn variable(node: Node<'a, 'a>, version: Version) -> Raw<'a> {
        let typed = match version {
            Version::Two => elements(node).find(|n| !n.has_tag_name("Annotations")),
            Version::Three => Some(node),
        };
        let kind = typed.map_or("nothing", |n| n.tag_name().name());
        let is_real = kind == "Real" || kind == "Float64";
        Raw { node, real: typed.filter(|_| is_real), kind }
    }

    fn read(&self) -> Result<Description, FmuError> {
        let Some(exchange) = child(self.root, "ModelExchange") else {
            let instead = match child(self.root, "CoSimulation") {
                Some(_) => {
                    "is for co-simulation alone, which advances by steps of its own and cannot be \
                    asked for derivatives"
                }
                None => "is not for model exchange",
            };
            return Err(FmuError::unsupported(format!("{instead}: export it for model exchange")));
        };
        let yes = |name: &str| matches!(exchange.attribute(name), Some("true" | "1"));
        if yes("needsExecutionTool") {
            let what = "needs the tool that exported it to run: export it so that it stands alone";
            return Err(FmuError::unsupported(what));
        }
        let states = self.states()?;
        self.check_events()?;
        if states.is_empty() {
            let what = "has no continuous states: nothing moves that derivatives say";
            return Err(FmuError::unsupported(what));
        }
        let is_input = |raw: &&Raw<'_>| raw.is("input");
        let inputs = self.variables.iter().filter(is_input).map(|raw| self.real(raw, "an input"));
        let is_output = |raw: &&Raw<'_>| raw.is("output") && self.is_scalar(raw);
        let is_parameter = |raw: &&Raw<'_>| raw.is("parameter") && self.is_scalar(raw);
        let real = |raw: &Raw<'_>| self.real(raw, "a variable");
        let (token, derivatives) = match self.version {
            Version::Two => ("guid", "providesDirectionalDerivative"),
            Version::Three => ("instantiationToken", "providesDirectionalDerivatives"),
        };
        Ok(Description {
            version: self.version,
            name: self.root.attribute("modelName").unwrap_or_default().to_owned(),
            states,
            inputs: inputs.collect::<Result<_, _>>()?,
            outputs: self.variables.iter().filter(is_output).map(real).collect::<Result<_, _>>()?,
            parameters: self
                .variables
                .iter()
                .filter(is_parameter)
                .map(real)
                .collect::<Result<_, _>>()?,
            has_derivatives: yes(derivatives),
            once: yes("canBeInstantiatedOnlyOncePerProcess"),
            identifier: required(exchange, "modelIdentifier")?.to_owned(),
            token: required(self.root, token)?.to_owned(),
        })
    }

    /// What happens at instants: none of it is supported.
    fn check_events(&self) -> Result<(), FmuError> {
        let structure = child(self.root, "ModelStructure");
        let listed = |name: &'static str| {
            structure.into_iter().flat_map(elements).filter(move |n| n.has_tag_name(name))
        };
        let indicators = match self.version {
            Version::Two => {
                self.root.attribute("numberOfEventIndicators").unwrap_or("0").trim().to_owned()
            }
            Version::Three => listed("EventIndicator").count().to_string(),
        };
        if indicators != "0" {
            return Err(FmuError::unsupported(format!(
                "has {indicators} event indicators: at state events it changes its equations, which is not \
                 supported; write what switches smoothly, or (Modelica) with noEvent, and export it again"
            )));
        }
        let discrete = match self.version {
            Version::Two => listed("DiscreteStates").flat_map(elements).count(),
            Version::Three => {
                self.variables.iter().filter(|v| v.node.has_attribute("previous")).count()
            }
        };
        if discrete > 0 {
            return Err(FmuError::unsupported(format!(
                "has {discrete} discrete states, which change at events: not supported"
            )));
        }
        match self.variables.iter().find(|v| v.kind == "Clock") {
            Some(clock) => Err(FmuError::unsupported(format!(
                "has a clock, '{}', at whose ticks it changes: not supported",
                clock.attribute("name")
            ))),
            None => Ok(()),
        }
    }

    /// States in the order of derivatives.
    fn states(&self) -> Result<Vec<State>, FmuError> {
        let Some(structure) = child(self.root, "ModelStructure") else {
            return Err(wrong(self.root, "<ModelStructure> is missing".to_owned()));
        };
        let derivatives: Vec<&Raw<'_>> = match self.version {
            Version::Two => child(structure, "Derivatives")
                .into_iter()
                .flat_map(elements)
                .map(|n| self.by_index(n, "index"))
                .collect::<Result<_, _>>()?,
            Version::Three => elements(structure)
                .filter(|n| n.has_tag_name("ContinuousStateDerivative"))
                .map(|n| self.by_reference(n, "valueReference"))
                .collect::<Result<_, _>>()?,
        };
        let state = |derivative: &Raw<'_>| {
            let own = self.real(derivative, "a derivative")?;
            let node = derivative.real.unwrap_or(derivative.node);
            let of = match self.version {
                Version::Two => self.by_index(node, "derivative")?,
                Version::Three => self.by_reference(node, "derivative")?,
            };
            Ok(State { variable: self.real(of, "a state")?, derivative: own.reference })
        };
        derivatives.into_iter().map(state).collect()
    }

    /// The variable that an attribute means by its place in the list, from 1.
    fn by_index(&self, node: Node<'_, '_>, attribute: &str) -> Result<&Raw<'a>, FmuError> {
        let text = required(node, attribute)?;
        let index = text.trim().parse::<usize>().ok().and_then(|k| k.checked_sub(1));
        index.and_then(|k| self.variables.get(k)).ok_or_else(|| {
            wrong(node, format!("{attribute} = \"{text}\": there is no such variable"))
        })
    }

    /// The variable that an attribute means by its reference.
    fn by_reference(&self, node: Node<'_, '_>, attribute: &str) -> Result<&Raw<'a>, FmuError> {
        let text = required(node, attribute)?;
        let meant = |raw: &&Raw<'_>| raw.attribute("valueReference").trim() == text.trim();
        self.variables.iter().find(meant).ok_or_else(|| {
            wrong(node, format!("{attribute} = \"{text}\": there is no such variable"))
        })
    }

    /// Whether it is one real number.
    fn is_scalar(&self, raw: &Raw<'_>) -> bool {
        raw.real.is_some() && child(raw.node, "Dimension").is_none()
    }

    fn real(&self, raw: &Raw<'_>, what: &str) -> Result<Variable, FmuError> {
        let name = required(raw.node, "name")?.to_owned();
        let Some(node) = raw.real else {
            return Err(FmuError::unsupported(format!(
                "has {what} '{name}' of type {}; only real numbers (FMI 2 Real, FMI 3 Float64) are supported",
                raw.kind
            )));
        };
        if !self.is_scalar(raw) {
            let what = format!("has {what} '{name}' that is an array; only scalars are supported");
            return Err(FmuError::unsupported(what));
        }
        let reference = required(raw.node, "valueReference")?;
        let reference = reference.trim().parse().map_err(|_| {
            wrong(raw.node, format!("valueReference = \"{reference}\" is no number of 32 bits"))
        })?;
        let written = self.typed(node, "unit").unwrap_or_default();
        let number = |attribute: &str, default: f64| match self.typed(node, attribute) {
            None => Ok(default),
            Some(text) => text.trim().parse::<f64>().map_err(|_| {
                wrong(node, format!("{attribute} = \"{text}\" of '{name}' is no number"))
            }),
        };
        Ok(Variable {
            reference,
            unit: unit(written, child(self.root, "UnitDefinitions")),
            start: number("start", 0.0)?,
            min: number("min", f64::NEG_INFINITY)?,
            max: number("max", f64::INFINITY)?,
            name,
        })
    }

    /// An attribute of a variable, or of its declared type.
    fn typed(&self, node: Node<'a, 'a>, attribute: &str) -> Option<&'a str> {
        node.attribute(attribute).or_else(|| {
            let declared = *self.types.get(node.attribute("declaredType")?)?;
            let inner = elements(declared).find(|n| n.has_tag_name("Real"));
            inner.unwrap_or(declared).attribute(attribute)
        })
    }
}

fn elements<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(Node::is_element)
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|n| n.has_tag_name(name))
}

fn required<'a>(node: Node<'a, '_>, attribute: &str) -> Result<&'a str, FmuError> {
    node.attribute(attribute)
        .ok_or_else(|| wrong(node, format!("<{}> has no {attribute}", node.tag_name().name())))
}

fn wrong(node: Node<'_, '_>, message: String) -> FmuError {
    let line = node.document().text_pos_at(node.range().start).row;
    FmuError::Description { line: Some(line), message }
}

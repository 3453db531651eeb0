//! What the comparison says: as JSON, in words, as a page.

use super::functions::{Entry, Functions, Of};
use super::laws::{Differing, Law};
use super::{Place, Side};
use crate::charts::{Axis, Band, Colour, Figure, Line, Rug, Style};
use crate::files::write_together;
use crate::identification::Columns;
use crate::report::{DifferencePage, difference_page, number};
use crate::table::{Table, number as short};
use serde::Serialize;
use std::error::Error;
use std::io;
use std::path::Path;

/// Marks of where the states are.
const MARKS: usize = 40;

/// What of two sets of recordings differs.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    schema: u32,
    simulated: Vec<String>,
    recorded: Vec<String>,
    #[serde(flatten)]
    columns: Columns,
    /// `force` in the units of the inputs, or `acceleration` (of order 1 `rate`).
    drift_as: &'static str,
    states: States,
    /// `no_mismatch`, `missing_physics`, `not_separable` or `unexplained`.
    pub verdict: &'static str,
    says: Vec<String>,
    functions: Vec<Function>,
    /// The laws that tell the difference of the drift.
    pub findings: Vec<Law>,
    notes: Vec<String>,
    #[serde(skip)]
    figures: Vec<Figure>,
}

/// At how many states functions are compared.
#[derive(Clone, Debug, Serialize)]
struct States {
    compared: usize,
    /// Share of those visited at which one side is not known.
    left_out: f64,
}

/// One function of both sides.
#[derive(Clone, Debug, Serialize)]
struct Function {
    name: String,
    kind: &'static str,
    channel: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<String>,
    #[serde(flatten)]
    place: Place,
}

impl Difference {
    /// Compare what was identified.
    ///
    /// # Errors
    /// Sides that know their functions at no common states.
    pub fn of(
        simulated: &Side,
        recorded: &Side,
        columns: &Columns,
    ) -> Result<Self, Box<dyn Error>> {
        let all = Functions::of([simulated, recorded], columns)?;
        let place = |e: &Entry| Place::of(e, &all.states, &columns.arguments);
        let functions: Vec<Function> = all
            .entries
            .iter()
            .map(|e| Function { place: place(e), ..Function::named(e.of, columns, all.as_forces) })
            .collect();
        let differing = |(e, f): (&Entry, &Function)| match e.of {
            Of::Drift(i) if f.place.differs => {
                let (name, n) = (&columns.channels[i], columns.channels.len());
                let states = &all.states[..];
                Differing { entry: e, name, place: (i, n), order: columns.order, states }.named()
            }
            _ => vec![],
        };
        let findings: Vec<Law> = all.entries.iter().zip(&functions).flat_map(differing).collect();
        let sided = |side: &Side, which: &str| -> Vec<String> {
            side.notes.iter().map(|note| format!("{which}: {note}")).collect()
        };
        let mut difference = Self {
            schema: 1,
            simulated: simulated.names.clone(),
            recorded: recorded.names.clone(),
            drift_as: match (all.as_forces, columns.order) {
                (true, _) => "force",
                (false, 1) => "rate",
                (false, _) => "acceleration",
            },
            states: States { compared: all.states.len(), left_out: all.left_out },
            verdict: verdict(&functions, &findings),
            says: vec![],
            figures: figures(&all, &functions, &findings, columns),
            functions,
            findings,
            notes: [
                columns.notes.clone(),
                sided(simulated, "simulated"),
                sided(recorded, "recorded"),
            ]
            .concat(),
            columns: columns.clone(),
        };
        difference.says = difference.sentences();
        Ok(difference)
    }

    /// Whether anything differs.
    #[must_use]
    pub fn is_mismatch(&self) -> bool {
        self.functions.iter().any(|f| f.place.differs)
    }

    /// What difference.json holds.
    ///
    /// # Errors
    /// None: these are numbers and names.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }

    /// The sentences, the functions as a table, and notes.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out: String = self.says.iter().map(|s| format!("{s}\n")).collect();
        let mut table = Table::new(&Self::HEAD);
        self.rows().into_iter().for_each(|row| table.row(row));
        out += &format!("\n{}", table.text());
        out += &format!("  {}\n", self.about());
        self.notes.iter().for_each(|note| out += &format!("note: {note}\n"));
        out
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> String {
        difference_page(&DifferencePage {
            simulated: self.simulated.join(", "),
            recorded: self.recorded.join(", "),
            says: self.says.clone(),
            about: self.about(),
            head: Self::HEAD.map(str::to_owned).to_vec(),
            rows: self.rows(),
            figures: self.figures.clone(),
            notes: self.notes.clone(),
        })
    }

    /// Write difference.json and difference.html to a folder.
    ///
    /// # Errors
    /// The underlying error, with the path.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let (data, html) = (folder.join("difference.json"), folder.join("difference.html"));
        write_together(&[(&data, &self.json()?), (&html, &self.page())])
    }

    const HEAD: [&'static str; 6] =
        ["function", "simulated", "difference", "its std", "times", "differs over"];

    fn rows(&self) -> Vec<Vec<String>> {
        let row = |f: &Function| {
            let p = &f.place;
            let over = match (p.differs, &p.depends_on[..]) {
                (false, _) => "does not differ".to_owned(),
                (true, []) if p.constant > 0.5 => "a constant".to_owned(),
                (true, []) => "several variables".to_owned(),
                (true, some) => some.join(", "),
            };
            let rms = [p.simulated_rms, p.difference_rms, p.std_rms, p.significance];
            [vec![f.name.clone()], rms.map(short).to_vec(), vec![over]].concat()
        };
        self.functions.iter().map(row).collect()
    }

    fn about(&self) -> String {
        format!(
            "Root mean squares over {} states that both know ({} of those visited left out); times: of the standard \
             deviation.",
            self.states.compared,
            number::percent(self.states.left_out)
        )
    }

    fn sentences(&self) -> Vec<String> {
        let mut says: Vec<String> = self.findings.iter().map(|law| self.says_of(law)).collect();
        let differs = |kind: &str| -> Vec<&str> {
            let some = self.functions.iter().filter(|f| f.kind == kind && f.place.differs);
            some.map(|f| &*f.name).collect()
        };
        let (drift, effectiveness) = (differs("drift"), differs("effectiveness"));
        if drift.is_empty() && effectiveness.is_empty() {
            return vec![
                "The recordings do not differ from the simulated ones by more than chance."
                    .to_owned(),
            ];
        }
        let untold: Vec<&str> = (self.functions.iter())
            .filter(|f| f.kind == "drift" && f.place.differs)
            .filter(|f| self.findings.iter().all(|law| law.channel != f.channel))
            .map(|f| &*f.name)
            .collect();
        if !untold.is_empty() {
            says.push(format!(
                "{}: no law of the catalogue that depends on the channel's own motion tells the difference.",
                untold.join(", ")
            ));
        }
        if !effectiveness.is_empty() {
            says.push(format!(
                "{}: another inertia and another gain of the actuator look the same here, and cannot be separated from \
                 what else grows with them.",
                effectiveness.join(", ")
            ));
        }
        says.push(
            "Without a model calibration and physics cannot always be separated: a law that the simulator lacks and one \
             that it has with another size look the same."
                .to_owned(),
        );
        says
    }

    fn says_of(&self, law: &Law) -> String {
        let physical = law.parameters.iter().map(|(name, (value, std))| {
            let name = name.replace('_', " ");
            match std {
                Some(std) => format!("{name} {}", number::with_std(*value, *std, "")),
                None => format!("{name} about {}", short(*value)),
            }
        });
        let who = match law.in_the_simulator {
            true => "the simulator has too much",
            false => "the recordings have more",
        };
        format!(
            "On {} {who} {}: {} (as {}; probability {}).",
            law.channel,
            law.words,
            physical.collect::<Vec<_>>().join(", "),
            match self.drift_as {
                "force" => "a force, in the units of the inputs",
                "rate" => "a rate",
                _ => "an acceleration",
            },
            number::percent(law.probability)
        )
    }
}

impl Function {
    fn named(of: Of, columns: &Columns, as_forces: bool) -> Self {
        let channel = |i: usize| columns.channels[i].clone();
        let (name, kind, channel, other) = match of {
            Of::Drift(i) if as_forces => {
                (format!("force on {}", channel(i)), "drift", channel(i), None)
            }
            Of::Drift(i) => (format!("drift of {}", channel(i)), "drift", channel(i), None),
            Of::Effectiveness(i, j) if as_forces => {
                let name = match i == j {
                    true => format!("inertia of {}", channel(i)),
                    false => format!("inertia between {} and {}", channel(i), channel(j)),
                };
                (name, "effectiveness", channel(i), Some(channel(j)))
            }
            Of::Effectiveness(i, j) => {
                let input = columns.inputs[j].clone();
                (
                    format!("effect of {input} on {}", channel(i)),
                    "effectiveness",
                    channel(i),
                    Some(input),
                )
            }
        };
        let place = Place::default();
        Self { name, kind, channel, other, place }
    }
}

fn verdict(functions: &[Function], findings: &[Law]) -> &'static str {
    let differs = |kind: &str| functions.iter().any(|f| f.kind == kind && f.place.differs);
    match (differs("effectiveness"), differs("drift"), findings.is_empty()) {
        (true, ..) => "not_separable",
        (false, false, _) => "no_mismatch",
        (false, true, false) => "missing_physics",
        (false, true, true) => "unexplained",
    }
}

/// The differences of what differs, over the variable that tells most of each.
fn figures(
    all: &Functions,
    functions: &[Function],
    findings: &[Law],
    columns: &Columns,
) -> Vec<Figure> {
    let differing = all.entries.iter().zip(functions).filter(|(_, f)| f.place.differs);
    let figure = |(entry, f): (&Entry, &Function)| {
        let variable = &f.place.explained_by.first()?.variable;
        let i = columns.arguments.iter().position(|a| a == variable)?;
        let mut order: Vec<usize> = (0..all.states.len()).collect();
        order.sort_by(|&a, &b| all.states[a][i].total_cmp(&all.states[b][i]));
        let difference = entry.difference();
        let at = |k: usize| all.states[k][i];
        let mut lines = vec![Line::new(
            "recorded less simulated",
            Colour::Ink,
            Style::Dots,
            order.iter().map(|&k| (at(k), difference[k])).collect(),
        )];
        // The last law's force is that of all of the channel.
        let law = findings.iter().rfind(|law| law.channel == f.channel && f.kind == "drift");
        lines.extend(law.map(|law| {
            let points = order.iter().map(|&k| (at(k), law.force[k])).collect();
            Line::new("laws named", Colour::Blue, Style::Rings, points)
        }));
        let edges = order.iter().map(|&k| (at(k), -2.0 * entry.std[k], 2.0 * entry.std[k]));
        let every = (order.len() / MARKS).max(1);
        Some(Figure {
            description: format!("Difference of the {} over {variable}", f.name),
            bands: vec![Band {
                label: "chance: ± 2 standard deviations".into(),
                colour: Colour::Green,
                edges: edges.collect(),
            }],
            lines,
            rug: Some(Rug {
                label: "states (quantiles)".into(),
                at: order.iter().step_by(every).map(|&k| at(k)).collect(),
            }),
            ..Figure::new(Axis::linear(variable, ""), Axis::linear(&f.name, ""))
        })
    };
    differing.filter_map(figure).collect()
}

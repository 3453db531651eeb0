//! Which columns are time, inputs and channels, where the user does not say.

use crate::recordings::{Recording, RecordingError, RecordingSource};
use serde::Serialize;
use std::error::Error;

/// Names of the time column, in the order in which they are looked for.
const TIME: [&str; 4] = ["t", "time", "t_s", "time_s"];
/// Beginnings of the names of inputs, before a number, an underscore or the end.
const INPUT: [&str; 11] =
    ["u", "tau", "F", "force", "torque", "v_in", "i_cmd", "input", "cmd", "command", "voltage_in"];

/// What the user says of the columns; what is empty or `None` is told by their names.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Column of time in seconds.
    pub time: Option<String>,
    /// Columns of the coordinates.
    pub channels: Vec<String>,
    /// Columns of the inputs.
    pub inputs: Vec<String>,
    /// Order s of the dynamics.
    pub order: Option<u8>,
    /// Columns and their units.
    pub units: Vec<ColumnUnit>,
}

/// The unit of a column.
#[derive(Clone, Debug)]
pub struct ColumnUnit {
    /// The column.
    pub column: String,
    /// Its unit, as written.
    pub unit: String,
}

impl Asked {
    /// The column of time of a file, and a note where it is taken for want of a better.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn time_of(
        &self,
        source: &RecordingSource,
    ) -> Result<(String, Vec<String>), RecordingError> {
        let mut notes = Vec::new();
        let time = match &self.time {
            Some(time) => time.clone(),
            None => time_column(source, &mut notes)?,
        };
        Ok((time, notes))
    }
}

/// What each column is used for.
#[derive(Clone, Debug, Serialize)]
pub struct Columns {
    /// Column of time.
    pub time: String,
    /// Order s of the dynamics.
    pub order: usize,
    /// Coordinates whose `order`-th derivative is learned.
    pub channels: Vec<String>,
    /// Columns that measure their velocities, where there are any.
    pub velocities: Vec<Option<String>>,
    /// Columns of the inputs.
    pub inputs: Vec<String>,
    /// Arguments of f and g.
    pub arguments: Vec<String>,
    /// What was assumed, in sentences.
    #[serde(skip)]
    pub notes: Vec<String>,
}

impl Columns {
    /// Choose among the columns of a recording whose column of time is known.
    ///
    /// # Errors
    /// Columns that are not there, or are none of what is needed.
    pub fn choose(
        a: &Asked,
        first: &Recording,
        time: String,
        notes: Vec<String>,
    ) -> Result<Self, Box<dyn Error>> {
        let with_unit = a.units.iter().map(|u| &u.column);
        for name in a.inputs.iter().chain(&a.channels).chain(with_unit) {
            first.column(name)?;
        }
        let names: Vec<String> = first.columns.iter().map(|c| c.name.clone()).collect();
        let inputs = match &a.inputs[..] {
            [] => {
                let found: Vec<String> = names
                    .iter()
                    .filter(|n| looks_like_input(n) && !a.channels.contains(n))
                    .cloned()
                    .collect();
                if found.is_empty() {
                    return Err(no_inputs(&first.name, &names).into());
                }
                found
            }
            given => given.to_vec(),
        };
        let rest: Vec<String> = names.iter().filter(|n| !inputs.contains(n)).cloned().collect();
        let chosen = if a.channels.is_empty() { rest.clone() } else { a.channels.clone() };
        if let Some(name) = chosen.iter().find(|n| inputs.contains(n)) {
            return Err(format!("column '{name}' is both a channel and an input").into());
        }
        if chosen.is_empty() {
            return Err(format!(
                "{}: no column is left for the channels; time is '{time}', the inputs are {}; say \
                 otherwise by --inputs and --channels",
                first.name,
                inputs.join(", ")
            )
            .into());
        }
        Ok(Self::of(time, inputs, &chosen, &rest, a.order, notes))
    }

    fn of(
        time: String,
        inputs: Vec<String>,
        chosen: &[String],
        rest: &[String],
        order: Option<u8>,
        notes: Vec<String>,
    ) -> Self {
        let velocity = |of: &String| rest.iter().find(|name| is_velocity(name, of));
        let is_rate = |name: &&String| chosen.iter().any(|of| is_velocity(name, of));
        let positions: Vec<String> = chosen.iter().filter(|n| !is_rate(n)).cloned().collect();
        let whole_state = positions.iter().all(|q| velocity(q).is_some_and(|v| chosen.contains(v)));
        let order = order.map_or(if whole_state { 1 } else { 2 }, usize::from);
        let channels = if order == 1 { chosen.to_vec() } else { positions };
        let velocities: Vec<Option<String>> =
            channels.iter().map(|q| velocity(q).cloned()).collect();
        let mut arguments = channels.clone();
        if order == 2 {
            let name =
                |(q, v): (&String, &Option<String>)| v.clone().unwrap_or_else(|| format!("d{q}"));
            arguments.extend(channels.iter().zip(&velocities).map(name));
        }
        Self { time, order, channels, velocities, inputs, arguments, notes }
    }
}

fn time_column(
    source: &RecordingSource,
    notes: &mut Vec<String>,
) -> Result<String, RecordingError> {
    let available = match crate::recordings::read(source, TIME[0]) {
        Err(RecordingError::NoTimeColumn { available, .. }) => available,
        Err(other) => return Err(other),
        Ok(_) => return Ok(TIME[0].to_owned()),
    };
    let named = TIME.iter().find_map(|t| available.iter().find(|a| a.eq_ignore_ascii_case(t)));
    if let Some(name) = named {
        return Ok(name.clone());
    }
    let first = available[0].clone();
    notes.push(format!(
        "the first column '{first}' is taken for time in seconds (--time says otherwise)"
    ));
    Ok(first)
}

/// `u`, `u1`, `u_V`, `tau1_cmd`, `F_N` but not `unit` or `force plate`.
fn looks_like_input(name: &str) -> bool {
    INPUT.iter().any(|stem| {
        name.strip_prefix(stem).is_some_and(|rest| {
            let rest = rest.trim_start_matches(|c: char| c.is_ascii_digit());
            rest.is_empty() || rest.starts_with(['_', '[', '('])
        })
    })
}

/// Whether `name` is the velocity of `of`: dq, dq_rad_s, q_dot, v_q.
fn is_velocity(name: &str, of: &str) -> bool {
    let rate = name.strip_prefix('d').and_then(|rest| rest.strip_prefix(of));
    let rate = rate.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
    rate || name.strip_suffix("_dot") == Some(of) || name.strip_prefix("v_") == Some(of)
}

fn no_inputs(recording: &str, names: &[String]) -> String {
    format!(
        "{recording}: no column has the name of an input (u, tau, F, force, torque, v_in, i_cmd ...); \
         name the inputs by --inputs; the columns are: {}",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strings(names: &[&str]) -> Vec<String> {
        names.iter().map(|&n| n.to_owned()).collect()
    }

    fn columns(chosen: &[&str], rest: &[&str], order: Option<u8>) -> Columns {
        let (chosen, rest) = (strings(chosen), strings(rest));
        Columns::of("t".into(), strings(&["u"]), &chosen, &rest, order, vec![])
    }

    #[test]
    fn inputs_are_known_by_their_names() {
        for name in ["u", "u1", "u_V", "tau", "tau2_cmd_Nm", "F_N", "F", "force", "torque[Nm]"] {
            assert!(looks_like_input(name), "{name}");
        }
        for name in ["unit", "upper", "Fx", "taught", "forceps", "q", "y_V", "du"] {
            assert!(!looks_like_input(name), "{name}");
        }
    }

    #[test]
    fn a_whole_state_is_of_first_order() {
        let c = columns(&["q1", "q2", "dq1", "dq2"], &["q1", "q2", "dq1", "dq2"], None);
        assert_eq!((c.order, c.arguments), (1, strings(&["q1", "q2", "dq1", "dq2"])));
        let c = columns(&["q_rad", "dq_rad_s"], &["q_rad", "dq_rad_s"], None);
        assert_eq!(c.order, 1);
    }

    #[test]
    fn positions_are_of_second_order_with_the_velocities_that_exist() {
        let c = columns(&["q1", "q2", "dq1"], &["q1", "q2", "dq1"], None);
        assert_eq!((c.order, c.channels), (2, strings(&["q1", "q2"])));
        assert_eq!(c.velocities, [Some("dq1".to_owned()), None]);
        assert_eq!(c.arguments, strings(&["q1", "q2", "dq1", "dq2"]));
        // Only the position is asked for, and its velocity helps.
        let c = columns(&["q"], &["q", "q_dot", "temperature"], None);
        assert_eq!((c.order, c.velocities), (2, vec![Some("q_dot".to_owned())]));
    }

    #[test]
    fn an_order_that_is_given_is_kept() {
        assert_eq!(columns(&["h1", "h2"], &["h1", "h2"], Some(1)).arguments, ["h1", "h2"]);
        let c = columns(&["q", "dq"], &["q", "dq"], Some(2));
        assert_eq!((c.order, c.channels), (2, strings(&["q"])));
    }
}

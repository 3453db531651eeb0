//! What the user says of the columns of recordings where no model does.

use clap::{Args, ValueEnum};
use lacuna::identification::{Asked, ColumnUnit};
use lacuna::occupation::InputPath;
use lacuna::recordings::Unit;

#[derive(Args)]
pub struct ColumnArguments {
    /// Columns of the coordinates, separated by commas; without, all but time and inputs
    #[arg(long, value_delimiter = ',')]
    channels: Vec<String>,
    /// Columns of the inputs; without, those named u, tau, F, force, torque, v_in, i_cmd ... with
    /// or without a number or _suffix
    #[arg(long, value_delimiter = ',')]
    inputs: Vec<String>,
    /// Column of time in seconds; without, t, time, t_s or time_s, else the first column
    #[arg(long)]
    time: Option<String>,
    /// Order of the dynamics; without, 2, or 1 where every channel's velocity (dq, q_dot, v_q) is
    /// a column too
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    order: Option<u8>,
    /// Units of columns, COLUMN=UNIT separated by commas; angles (rad, deg) that were recorded within one
    /// turn are made continuous
    #[arg(long, value_name = "COLUMN=UNIT", value_delimiter = ',', value_parser = column_unit)]
    units: Vec<ColumnUnit>,
    /// What the inputs do between samples; without, zero-order
    #[arg(long, value_enum)]
    input_hold: Option<Hold>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Hold {
    ZeroOrder,
    Linear,
    Smooth,
}

fn column_unit(text: &str) -> Result<ColumnUnit, String> {
    let (column, unit) =
        text.split_once('=').ok_or_else(|| format!("expected COLUMN=UNIT, found '{text}'"))?;
    Unit::parse(unit).map_err(|e| e.to_string())?;
    Ok(ColumnUnit { column: column.to_owned(), unit: unit.to_owned() })
}

impl ColumnArguments {
    pub fn asked(&self) -> Asked {
        Asked {
            time: self.time.clone(),
            channels: self.channels.clone(),
            inputs: self.inputs.clone(),
            order: self.order,
            units: self.units.clone(),
        }
    }

    pub fn input_path(&self) -> InputPath {
        match self.input_hold {
            None | Some(Hold::ZeroOrder) => InputPath::Held,
            Some(Hold::Linear) => InputPath::Linear,
            Some(Hold::Smooth) => InputPath::Smooth,
        }
    }

    /// Whether anything is said.
    pub fn are_said(&self) -> bool {
        let lists = self.channels.is_empty() && self.inputs.is_empty() && self.units.is_empty();
        !lists || self.time.is_some() || self.order.is_some() || self.input_hold.is_some()
    }
}

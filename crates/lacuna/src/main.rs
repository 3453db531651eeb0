//! The `lacuna` command.

// `println!` panics where nobody reads: see `say`.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod commands;
mod interrupt;
mod output;
mod say;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// Finds the physics that a simulator leaves out.
#[derive(Parser)]
#[command(version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The model file of a robot, to be edited, from its URDF or MJCF and a recording
    Init(commands::init::Arguments),
    /// What is in the recordings, do they fit the model, is the excitation rich enough
    Check(commands::check::Arguments),
    /// Run the model on a recording's inputs; error per channel
    Simulate(commands::simulate::Arguments),
    /// Two models against the same recordings: which is closer, channel by channel
    Compare(commands::compare::Arguments),
    /// Find the physics that the model leaves out
    Diagnose(commands::diagnose::Arguments),
    /// Many machines with one model: diagnose each, and find those that are unlike the others
    Fleet(commands::fleet::Arguments),
    /// Without a model: drift and control effectiveness by occupation-kernel regression
    Identify(commands::identify::Arguments),
    /// An identified model for real-time control: compact, on a box, with a measured error bound
    Compile(commands::compile::Arguments),
    /// An identified or compiled model as one source file in Rust or C
    Export(commands::export::Arguments),
    /// What the command calls itself for, to evaluate an FMU in a process of its own
    #[command(hide = true)]
    EvaluateFmu(commands::evaluate_fmu::Arguments),
    /// Conceal an effect in made-up recordings, diagnose them, and unseal it
    Demo(commands::demo::Arguments),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    interrupt::exit_when_interrupted();
    commands::evaluate_fmu::name_this_program();
    let result = match arguments.command {
        Command::Init(a) => commands::init::run(&a),
        Command::Check(a) => commands::check::run(&a),
        Command::Simulate(a) => commands::simulate::run(&a),
        Command::Compare(a) => commands::compare::run(&a),
        Command::Diagnose(a) => commands::diagnose::run(&a),
        Command::Fleet(a) => commands::fleet::run(&a),
        Command::Identify(a) => commands::identify::run(&a),
        Command::Compile(a) => commands::compile::run(&a),
        Command::Export(a) => commands::export::run(&a),
        Command::EvaluateFmu(a) => commands::evaluate_fmu::run(&a),
        Command::Demo(a) => commands::demo::run(&a),
    };
    result.unwrap_or_else(|error| {
        // The exit code tells those who have closed standard error.
        let _ = writeln!(std::io::stderr(), "lacuna: {error}");
        ExitCode::from(2)
    })
}

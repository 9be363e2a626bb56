//! The list of commands.

use clap::{Parser, Subcommand};

use crate::arguments::JsonOutput;
use crate::commands::{
    add, bring_up, calibrate, check, compare, demo, design, diagnose, effects, exam, generate,
    identify, lab, mutate, new, prove, record, remove, report, simulate,
};
use crate::failure::Failure;
use crate::report::Report;

/// From measurements of a reaction-wheel pendulum to a verified fixed-point controller.
#[derive(Parser)]
#[command(
    version,
    about,
    propagate_version = true,
    arg_required_else_help = true
)]
pub struct Cli {
    /// Show every row of long tables
    #[arg(long, global = true)]
    pub all: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Subcommand)]
pub enum Command {
    /// Run the whole chain on a bench that ships inside the program
    Demo(demo::Arguments),
    /// Begin a bench folder from CSV logs: write a bench.toml with a reason for every choice
    New(new::Arguments),
    /// Check the data of a bench before anything is fitted: units, signs, clipping, held bodies
    Check(check::Arguments),
    /// Record a log of the bench from the firmware's serial line
    Record(record::Arguments),
    /// Fit the base model and the effects that model.toml already has; write model.toml
    Identify(identify::Arguments),
    /// Show the model against the measurements, and where it fails
    Compare(compare::Arguments),
    /// Put an effect into model.toml and refit
    Add(add::Arguments),
    /// Take an effect out of model.toml and refit
    Remove(remove::Arguments),
    /// Find the physical effects that the model lacks: verdict, suspects, and where the model fails
    Diagnose(diagnose::Arguments),
    /// List the library of effects, or explain one: equation, parameters, what to look for
    Effects(effects::Arguments),
    /// Calibrate sensors, mounting, converters and centre of mass from recordings
    Calibrate(calibrate::Arguments),
    /// Find which way is positive: sign and axis of every sensor and of the motor, from recordings
    BringUp(bring_up::Arguments),
    /// Design the controller: linear model, poles, controllability, gains and margins
    Design(design::Arguments),
    /// Simulate the emitted law on the nonlinear bench, with disturbances
    Simulate(simulate::Arguments),
    /// Write the controller in fixed point, as a no_std Rust crate or a C99 library
    Generate(generate::Arguments),
    /// Prove the claims about an emitted crate from its files alone
    Prove(prove::Arguments),
    /// Damage an emitted crate in many small ways and show which engine notices
    Mutate(mutate::Arguments),
    /// Compare, diagnose, design and prove in the browser, on a page for this machine alone
    Lab(lab::Arguments),
    /// Write everything about a bench into one HTML file
    Report(report::Arguments),
    /// Mark the diagnosis in a blind exam, on benches with a hidden effect
    Exam(exam::Arguments),
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<Report, Failure> {
        match self {
            Command::Demo(arguments) => demo::run(arguments),
            Command::New(arguments) => new::run(arguments),
            Command::Check(arguments) => check::run(arguments),
            Command::Record(arguments) => record::run(arguments),
            Command::Identify(arguments) => identify::run(arguments),
            Command::Compare(arguments) => compare::run(arguments),
            Command::Add(arguments) => add::run(arguments),
            Command::Remove(arguments) => remove::run(arguments),
            Command::Diagnose(arguments) => diagnose::run(arguments),
            Command::Effects(arguments) => effects::run(arguments),
            Command::Calibrate(arguments) => calibrate::run(arguments),
            Command::BringUp(arguments) => bring_up::run(arguments),
            Command::Design(arguments) => design::run(arguments),
            Command::Simulate(arguments) => simulate::run(arguments),
            Command::Generate(arguments) => generate::run(arguments),
            Command::Prove(arguments) => prove::run(arguments),
            Command::Mutate(arguments) => mutate::run(arguments),
            Command::Lab(arguments) => lab::run(arguments),
            Command::Report(arguments) => report::run(arguments),
            Command::Exam(arguments) => exam::run(arguments),
        }
    }

    /// The place to which the command's result is written.
    pub fn output(&self) -> &JsonOutput {
        match self {
            Command::Demo(arguments) => &arguments.output,
            Command::New(arguments) => &arguments.output,
            Command::Check(arguments) => &arguments.output,
            Command::Record(arguments) => &arguments.output,
            Command::Identify(arguments) => &arguments.output,
            Command::Compare(arguments) => &arguments.output,
            Command::Add(arguments) => &arguments.output,
            Command::Remove(arguments) => &arguments.output,
            Command::Diagnose(arguments) => &arguments.output,
            Command::Effects(arguments) => &arguments.output,
            Command::Calibrate(arguments) => &arguments.output,
            Command::BringUp(arguments) => &arguments.output,
            Command::Design(arguments) => &arguments.output,
            Command::Simulate(arguments) => &arguments.output,
            Command::Generate(arguments) => &arguments.output,
            Command::Prove(arguments) => &arguments.output,
            Command::Mutate(arguments) => &arguments.output,
            // The lab writes no JSON: its result is the page.
            Command::Lab(_) => &JsonOutput { json: None },
            Command::Report(arguments) => &arguments.output,
            Command::Exam(arguments) => &arguments.output,
        }
    }
}

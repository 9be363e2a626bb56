//! `flywheel design MODEL`

use std::path::PathBuf;

use design::wheel_sizing::chart;
use design::{
    ChartPoint, Design, ExtremeCheck, Margins, Pole, PoleUncertainty, Sizing, UncertainParameters,
    UncertainPole, pole_uncertainty,
};
use figures::{Line, Panel, Plane, PoleSet, Quantity, Role};
use plant::{GRAVITY_TORQUE, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};
use serde::Serialize;

use crate::cli::Output;
use crate::failure::Failure;
use crate::model_design::ModelDesign;
use crate::report::Report;
use crate::report::json;
use crate::report::numbers::{complex, significant, with_uncertainty};
use crate::report::table::{Align, Table};

/// Parameter sets drawn to see what their uncertainty does to the poles.
const DRAWN_SETS: usize = 1000;
/// Seed of that draw.
const SEED: u64 = 1;
/// Drawn sets whose poles the figure shows.
const SHOWN_SETS: usize = 200;
/// Wheels that are looked at, relative to the bench's own.
const WHEEL_FACTORS: [f64; 3] = [0.5, 1.0, 2.0];
/// Top speeds of the wheel in the table of sizes.
const TABLED_SPEEDS_RAD_S: [f64; 5] = [50.0, 100.0, 200.0, 400.0, 700.0];

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Folder for the figure [default: out beside MODEL]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct DesignJson {
    model: String,
    effects: Vec<&'static str>,
    parameters: Vec<json::Parameter>,
    sample_time_s: f64,
    state_weights: [f64; 3],
    current_weight: f64,
    current_limit_a: f64,
    #[serde(rename = "A")]
    a: [[f64; 3]; 3],
    #[serde(rename = "B")]
    b: [f64; 3],
    #[serde(rename = "Ad")]
    ad: [[f64; 3]; 3],
    #[serde(rename = "Bd")]
    bd: [f64; 3],
    gains: [f64; 3],
    /// 1/s.
    open_loop_poles: Vec<[f64; 2]>,
    /// Eigenvalues of Ad − Bd K.
    closed_loop_poles: Vec<[f64; 2]>,
    /// Their continuous equivalents ln(λ)/T, 1/s.
    closed_loop_poles_per_s: Vec<[f64; 2]>,
    pole_uncertainty: Option<UncertaintyJson>,
    controllability_rank: usize,
    controllability_condition: f64,
    observability_rank: usize,
    observability_condition: f64,
    observability_rank_of_sensor: Vec<(&'static str, usize)>,
    recovery_angle_rad: f64,
    dare_residual: f64,
    margins: MarginsJson,
    wheel_speed_per_angle_bias: f64,
    friction_extremes: Option<[ExtremeJson; 2]>,
    /// The swing that dry friction keeps up around upright; null where there is none.
    hunting: Option<HuntingJson>,
    least_pushes: Vec<PushJson>,
    wheel_sizing: Vec<SizingJson>,
    figures: Vec<PathBuf>,
}

#[derive(Serialize)]
struct UncertaintyJson {
    /// Whether the model states how the errors of its parameters hang together; else they count as
    /// independent.
    correlated: bool,
    /// [standard deviation of the real part, of the imaginary part], 1/s.
    open_loop_std: Vec<[f64; 2]>,
    closed_loop_std_per_s: Vec<[f64; 2]>,
    drawn: usize,
    impossible: usize,
    unstable: usize,
    worst_spectral_radius: f64,
}

#[derive(Serialize)]
struct MarginsJson {
    least_gain_factor: f64,
    largest_gain_factor: f64,
    phase_margin_rad: f64,
    delay_margin_s: f64,
    modulus_margin: f64,
}

impl MarginsJson {
    fn of(margins: &Margins) -> MarginsJson {
        MarginsJson {
            least_gain_factor: margins.least_gain_factor,
            largest_gain_factor: margins.largest_gain_factor,
            phase_margin_rad: margins.phase_margin_rad,
            delay_margin_s: margins.delay_margin_s,
            modulus_margin: margins.modulus_margin,
        }
    }
}

#[derive(Serialize)]
struct ExtremeJson {
    coulomb_friction: &'static str,
    closed_loop_poles_per_s: Vec<[f64; 2]>,
    spectral_radius: f64,
    stable: bool,
    /// Null where the loop is unstable.
    margins: Option<MarginsJson>,
}

#[derive(Serialize)]
struct HuntingJson {
    angle_rad: f64,
    rate_rad_s: f64,
    frequency_rad_s: f64,
}

/// One wheel at one top speed.
#[derive(Serialize)]
struct SizingJson {
    wheel_inertia: f64,
    wheel_speed_rad_s: f64,
    wheel_energy_j: f64,
    recoverable_angle_rad: f64,
    recovered_energy_j: f64,
}

#[derive(Serialize)]
struct PushJson {
    angle_rad: f64,
    energy_j: f64,
    duration_s: f64,
    wheel_speed_rad_s: f64,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let designed = ModelDesign::new(&arguments.model)?;
    let in_file = |error: design::DesignError| Failure::in_file(&arguments.model, error);
    let uncertainty = uncertainty(&designed).map_err(in_file)?;
    let sizing = sizing(&designed);
    let pushes = least_pushes(&sizing, designed.design.recovery_angle_rad).map_err(in_file)?;

    let folder = arguments.out.clone().unwrap_or_else(|| {
        let beside = arguments.model.parent();
        beside.map_or_else(|| PathBuf::from("out"), |folder| folder.join("out"))
    });
    let figures = vec![folder.join("poles.svg"), folder.join("wheel-sizing.svg")];
    figures::write_svg(&figures[0], &pole_figure(&designed, uncertainty.as_ref()))?;
    figures::write_svg(&figures[1], &sizing_figure(&designed, &sizing)?)?;

    let sizes = chart(&sizing, &wheels(&sizing), &TABLED_SPEEDS_RAD_S).map_err(in_file)?;
    let text = text(&designed, uncertainty.as_ref(), &pushes, &sizes, &figures);
    let json = json(&designed, uncertainty.as_ref(), pushes, &sizes, figures);
    Report::new(text, &json)
}

/// What the parameters' standard errors and their correlations do to the poles; none where the file states no errors.
fn uncertainty(designed: &ModelDesign) -> Result<Option<PoleUncertainty>, design::DesignError> {
    let infos = designed.model.parameters();
    let parameters: Vec<(&str, f64, f64)> = infos
        .iter()
        .zip(&designed.values)
        .map(|(info, &value)| {
            let parameter = designed.file.parameter(info.name);
            (
                info.name,
                value,
                parameter.and_then(|p| p.std).unwrap_or(0.0),
            )
        })
        .collect();
    if parameters.iter().all(|(_, _, std)| *std == 0.0) {
        return Ok(None);
    }
    pole_uncertainty(
        &match &designed.file.correlation {
            Some(known) => UncertainParameters::correlated(&parameters, |a, b| known.between(a, b)),
            None => UncertainParameters::independent(&parameters),
        },
        &|values| designed.linearise(values),
        &designed.design.gains,
        designed.wishes.sample_time_s,
        DRAWN_SETS,
        SEED,
    )
    .map(Some)
}

fn sizing(designed: &ModelDesign) -> Sizing {
    let values = &designed.values;
    Sizing {
        total_inertia: values[TOTAL_INERTIA],
        wheel_inertia: values[WHEEL_INERTIA],
        gravity_torque: values[GRAVITY_TORQUE],
        largest_torque: values[TORQUE_CONSTANT] * designed.wishes.current_limit_a,
    }
}

/// Inertias of the wheels that are looked at, in kg m².
fn wheels(sizing: &Sizing) -> [f64; 3] {
    WHEEL_FACTORS.map(|factor| factor * sizing.wheel_inertia)
}

/// What it takes to come up from rest at a third, two thirds and nine tenths of the largest angle.
fn least_pushes(sizing: &Sizing, largest_rad: f64) -> Result<Vec<PushJson>, design::DesignError> {
    let mut pushes = Vec::new();
    for share in [1.0 / 3.0, 2.0 / 3.0, 0.9] {
        let angle_rad = share * largest_rad;
        if let Some(push) = sizing.least_push(angle_rad)? {
            pushes.push(PushJson {
                angle_rad,
                energy_j: push.energy_j,
                duration_s: push.duration_s,
                wheel_speed_rad_s: push.wheel_speed_rad_s,
            });
        }
    }
    Ok(pushes)
}

fn json(
    designed: &ModelDesign,
    uncertainty: Option<&PoleUncertainty>,
    least_pushes: Vec<PushJson>,
    sizing: &[ChartPoint],
    figures: Vec<PathBuf>,
) -> DesignJson {
    let design = &designed.design;
    let pairs = |poles: &[Pole]| poles.iter().map(|p| [p.value.re, p.value.im]).collect();
    let stds = |poles: &[UncertainPole]| poles.iter().map(|p| [p.std_re, p.std_im]).collect();
    DesignJson {
        model: designed.name(),
        effects: designed.model.effects().iter().map(|e| e.name()).collect(),
        parameters: designed
            .file
            .parameters
            .iter()
            .map(|parameter| json::Parameter {
                name: parameter.name.clone(),
                value: parameter.value,
                std: parameter.std,
                unit: parameter.unit.clone(),
            })
            .collect(),
        sample_time_s: designed.wishes.sample_time_s,
        state_weights: designed.wishes.state_weights,
        current_weight: designed.wishes.current_weight,
        current_limit_a: designed.wishes.current_limit_a,
        a: matrix(|row, column| design.model.state[(row, column)]),
        b: [0, 1, 2].map(|row| design.model.input[row]),
        ad: matrix(|row, column| design.discrete.state[(row, column)]),
        bd: [0, 1, 2].map(|row| design.discrete.input[row]),
        gains: [0, 1, 2].map(|index| design.gains[index]),
        open_loop_poles: pairs(&design.open_loop_poles),
        closed_loop_poles: pairs(&design.closed_loop_poles),
        closed_loop_poles_per_s: design
            .closed_loop_poles_per_s()
            .iter()
            .map(|pole| [pole.re, pole.im])
            .collect(),
        pole_uncertainty: uncertainty.map(|found| UncertaintyJson {
            correlated: designed.file.correlation.is_some(),
            open_loop_std: stds(&found.open_loop),
            closed_loop_std_per_s: stds(&found.closed_loop),
            drawn: found.samples,
            impossible: found.impossible,
            unstable: found.unstable,
            worst_spectral_radius: found.worst_spectral_radius,
        }),
        controllability_rank: design.controllability.rank,
        controllability_condition: design.controllability.condition,
        observability_rank: design.observability.rank,
        observability_condition: design.observability.condition,
        observability_rank_of_sensor: design
            .observability_of_sensor
            .iter()
            .map(|(sensor, rank)| (*sensor, rank.rank))
            .collect(),
        recovery_angle_rad: design.recovery_angle_rad,
        dare_residual: design.dare_residual(),
        margins: MarginsJson::of(&design.margins),
        wheel_speed_per_angle_bias: design.wheel_speed_per_angle_bias,
        friction_extremes: design.friction.as_ref().map(|check| {
            [("none", &check.none), ("all", &check.all)].map(|(name, extreme)| ExtremeJson {
                coulomb_friction: name,
                closed_loop_poles_per_s: extreme
                    .closed_loop_poles_per_s
                    .iter()
                    .map(|pole| [pole.re, pole.im])
                    .collect(),
                spectral_radius: extreme.spectral_radius,
                stable: extreme.is_stable(),
                margins: extreme.margins.as_ref().map(MarginsJson::of),
            })
        }),
        hunting: design
            .friction
            .as_ref()
            .and_then(|check| check.hunting)
            .map(|swing| HuntingJson {
                angle_rad: swing.angle_rad,
                rate_rad_s: swing.rate_rad_s,
                frequency_rad_s: swing.frequency_rad_s,
            }),
        least_pushes,
        wheel_sizing: sizing
            .iter()
            .map(|point| SizingJson {
                wheel_inertia: point.wheel_inertia,
                wheel_speed_rad_s: point.wheel_speed_rad_s,
                wheel_energy_j: point.wheel_energy_j,
                recoverable_angle_rad: point.recoverable_angle_rad,
                recovered_energy_j: point.recovered_energy_j,
            })
            .collect(),
        figures,
    }
}

fn matrix(entry: impl Fn(usize, usize) -> f64) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| entry(row, column)))
}

fn text(
    designed: &ModelDesign,
    uncertainty: Option<&PoleUncertainty>,
    pushes: &[PushJson],
    sizes: &[ChartPoint],
    figures: &[PathBuf],
) -> String {
    let wishes = &designed.wishes;
    let effects: Vec<&str> = designed.model.effects().iter().map(|e| e.name()).collect();
    let mut text = format!(
        "{}: {}\nSample time {} s, weights of angle, rate, wheel speed ({}), of the current {}, limit {} A\n",
        designed.name(),
        effects.join(", "),
        wishes.sample_time_s,
        wishes
            .state_weights
            .map(|weight| significant(weight, 6))
            .join(", "),
        significant(wishes.current_weight, 6),
        wishes.current_limit_a,
    );
    text.push_str(&match wishes.friction_linearisation_speed_rad_s {
        Some(speed) => format!("Coulomb friction of the pivot enters as μ / {speed} rad/s\n"),
        None => "Coulomb friction is not in the linear model\n".to_owned(),
    });
    text.push_str(&linear_model_text(&designed.design));
    text.push_str(&poles_text(designed, uncertainty));
    text.push_str(&loop_text(&designed.design));
    text.push_str(&friction_text(&designed.design));
    text.push_str(&pushes_text(pushes));
    text.push_str(&sizes_text(sizes));
    text.push_str("\nFigures\n");
    for path in figures {
        text.push_str(&format!("  {}\n", path.display()));
    }
    text
}

fn linear_model_text(design: &Design) -> String {
    let mut table = Table::without_head(&[
        Align::Left,
        Align::Right,
        Align::Right,
        Align::Right,
        Align::Right,
    ]);
    let states = ["angle", "rate", "wheel speed"];
    for (row, state) in states.iter().enumerate() {
        let mut cells = vec![format!("d/dt {state} =")];
        for (column, state) in states.iter().enumerate() {
            let entry = significant(design.model.state[(row, column)], 6);
            cells.push(format!("{entry} {state}"));
        }
        cells.push(format!(
            "{} current",
            significant(design.model.input[row], 6)
        ));
        table.row(cells);
    }
    let gains = [0, 1, 2].map(|index| significant(design.gains[index], 9));
    let units = ["A/rad", "A s/rad", "A s/rad"];
    let mut law = Table::without_head(&[Align::Left, Align::Right, Align::Left]);
    for ((state, gain), unit) in states.iter().zip(gains).zip(units) {
        law.row([(*state).to_owned(), gain, unit.to_owned()]);
    }
    format!(
        "\nLinear model about upright (SI units)\n{}\nGains K of u = −K x\n{}",
        table.text(),
        law.text()
    )
}

fn poles_text(designed: &ModelDesign, uncertainty: Option<&PoleUncertainty>) -> String {
    let design = &designed.design;
    let mut table = Table::new(&[
        ("loop", Align::Left),
        ("pole", Align::Left),
        ("1/s ± standard error", Align::Left),
        ("moved most by", Align::Left),
    ]);
    // The parameter whose standard error alone moves the pole farthest.
    let culprit = |pole: Option<&UncertainPole>| -> String {
        pole.and_then(|pole| {
            pole.per_parameter
                .iter()
                .filter(|(_, moves)| moves.norm() > 0.0)
                .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
        })
        .map_or(String::new(), |(name, _)| name.clone())
    };
    let with_error = |value: [f64; 2], pole: Option<&UncertainPole>| match pole {
        None => complex(value[0], value[1]),
        Some(pole) if value[1] == 0.0 => with_uncertainty(value[0], Some(pole.std_re)),
        Some(pole) => format!(
            "{}, {}j",
            with_uncertainty(value[0], Some(pole.std_re)),
            format_args!("({})", with_uncertainty(value[1], Some(pole.std_im)))
        ),
    };
    for (index, pole) in design.open_loop_poles.iter().enumerate() {
        let value = [pole.value.re, pole.value.im];
        let uncertain = uncertainty.and_then(|found| found.open_loop.get(index));
        table.row([
            "open".to_owned(),
            String::new(),
            with_error(value, uncertain),
            culprit(uncertain),
        ]);
    }
    let equivalents = design.closed_loop_poles_per_s();
    for (index, (pole, equivalent)) in design.closed_loop_poles.iter().zip(equivalents).enumerate()
    {
        let uncertain = uncertainty.and_then(|found| found.closed_loop.get(index));
        table.row([
            "closed".to_owned(),
            complex(pole.value.re, pole.value.im),
            with_error([equivalent.re, equivalent.im], uncertain),
            culprit(uncertain),
        ]);
    }
    let mut text = format!(
        "\nPoles (closed loop: sampled, and what they are in 1/s)\n{}",
        table.text()
    );
    if let Some(found) = uncertainty {
        text.push_str(match &designed.file.correlation {
            Some(_) => "  the errors of the parameters hang together as [correlation] says\n",
            None => "  the model has no [correlation]: the errors count as independent\n",
        });
        text.push_str(&format!(
            "  {} of {} parameter sets drawn within their standard errors leave the loop stable\n",
            found.samples - found.unstable - found.impossible,
            found.samples
        ));
    }
    text
}

fn loop_text(design: &Design) -> String {
    let margins = &design.margins;
    let degrees = |radians: f64| format!("{}°", significant(radians.to_degrees(), 4));
    let mut table = Table::without_head(&[Align::Left, Align::Left]);
    let rank = |rank: &design::StructuralRank| {
        format!(
            "rank {} of {}, condition {}",
            rank.rank,
            rank.states,
            significant(rank.condition, 3)
        )
    };
    table.row(["controllability", &rank(&design.controllability)]);
    table.row(["observability, all sensors", &rank(&design.observability)]);
    for (sensor, of_sensor) in &design.observability_of_sensor {
        table.row([format!("observability, {sensor} alone"), rank(of_sensor)]);
    }
    table.row([
        "gain margin".to_owned(),
        format!(
            "factor {} to {}",
            significant(margins.least_gain_factor, 3),
            significant(margins.largest_gain_factor, 3)
        ),
    ]);
    table.row(["phase margin".to_owned(), degrees(margins.phase_margin_rad)]);
    table.row([
        "delay margin".to_owned(),
        format!(
            "{} ms beyond the hold",
            significant(1e3 * margins.delay_margin_s, 3)
        ),
    ]);
    table.row([
        "modulus margin".to_owned(),
        significant(margins.modulus_margin, 3),
    ]);
    table.row([
        "largest angle at the limit".to_owned(),
        degrees(design.recovery_angle_rad),
    ]);
    table.row([
        "angle bias of 1°".to_owned(),
        format!(
            "the wheel settles at {} rad/s",
            significant(design.wheel_speed_per_angle_bias * 1_f64.to_radians(), 3)
        ),
    ]);
    table.row([
        "Riccati equation".to_owned(),
        format!(
            "relative residual {}",
            significant(design.dare_residual(), 2)
        ),
    ]);
    format!("\nThe loop\n{}", table.text())
}

fn friction_text(design: &Design) -> String {
    let Some(check) = &design.friction else {
        return String::new();
    };
    let mut table = Table::new(&[
        ("Coulomb friction", Align::Left),
        ("closed-loop poles in 1/s", Align::Left),
        ("", Align::Left),
        ("phase margin", Align::Right),
        ("delay margin", Align::Right),
    ]);
    let row = |name: &str, extreme: &ExtremeCheck| {
        let poles: Vec<String> = extreme
            .closed_loop_poles_per_s
            .iter()
            .map(|pole| complex(pole.re, pole.im))
            .collect();
        let verdict = if extreme.is_stable() {
            "stable"
        } else {
            "unstable"
        };
        let margin = |value: &dyn Fn(&Margins) -> String| {
            extreme.margins.as_ref().map_or("none".to_owned(), value)
        };
        [
            name.to_owned(),
            poles.join(",  "),
            verdict.to_owned(),
            margin(&|m| format!("{:.1}°", m.phase_margin_rad.to_degrees())),
            margin(&|m| format!("{} ms", significant(1e3 * m.delay_margin_s, 3))),
        ]
    };
    table.row(row("none", &check.none));
    table.row(row("all of it, as damping", &check.all));
    let hunting = match &check.hunting {
        None => "  dry friction keeps up no swing around upright".to_owned(),
        Some(swing) => format!(
            "  dry friction keeps up a swing of ±{}° at {} Hz around upright (describing function)",
            significant(swing.angle_rad.to_degrees(), 2),
            significant(swing.frequency_rad_s / std::f64::consts::TAU, 2)
        ),
    };
    format!(
        "\nThe same gains at both extremes of Coulomb friction\n{}{hunting}\n",
        table.text()
    )
}

/// Largest recoverable angle, by the wheel's inertia (rows) and top speed (columns).
fn sizes_text(sizes: &[ChartPoint]) -> String {
    let speeds: Vec<String> = TABLED_SPEEDS_RAD_S
        .iter()
        .map(|speed| format!("{speed} rad/s"))
        .collect();
    let mut heads = vec![("wheel inertia", Align::Left)];
    heads.extend(speeds.iter().map(|speed| (speed.as_str(), Align::Right)));
    let mut table = Table::new(&heads);
    for (wheel, factor) in sizes.chunks(TABLED_SPEEDS_RAD_S.len()).zip(WHEEL_FACTORS) {
        let Some(first) = wheel.first() else {
            continue;
        };
        let mut row = vec![format!(
            "{} kg m2 (× {factor})",
            significant(first.wheel_inertia, 3)
        )];
        row.extend(wheel.iter().map(|point| {
            format!(
                "{:.2}°, {} mJ",
                point.recoverable_angle_rad.to_degrees(),
                significant(1e3 * point.recovered_energy_j, 2)
            )
        }));
        table.row(row);
    }
    format!(
        "\nAngle and energy that a wheel recovers, by its top speed\n{}",
        table.text()
    )
}

fn pushes_text(pushes: &[PushJson]) -> String {
    let mut table = Table::new(&[
        ("from rest at", Align::Right),
        ("energy", Align::Right),
        ("full current for", Align::Right),
        ("the wheel gains", Align::Right),
    ]);
    for push in pushes {
        table.row([
            format!("{:.2}°", push.angle_rad.to_degrees()),
            format!("{} mJ", significant(1e3 * push.energy_j, 3)),
            format!("{} ms", significant(1e3 * push.duration_s, 3)),
            format!("{} rad/s", significant(push.wheel_speed_rad_s, 3)),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!("\nThe least that brings the body up\n{}", table.text())
}

fn pole_figure(designed: &ModelDesign, uncertainty: Option<&PoleUncertainty>) -> String {
    let design = &designed.design;
    let open: Vec<(f64, f64)> = design
        .open_loop_poles
        .iter()
        .map(|pole| (pole.value.re, pole.value.im))
        .collect();
    let closed: Vec<(f64, f64)> = design
        .closed_loop_poles_per_s()
        .iter()
        .map(|pole| (pole.re, pole.im))
        .collect();
    let drawn = |poles: &[nalgebra::Complex<f64>]| -> Vec<(f64, f64)> {
        let shown = poles.iter().take(SHOWN_SETS * 3);
        shown.map(|pole| (pole.re, pole.im)).collect()
    };
    let clouds = uncertainty.map_or_else(Default::default, |found| {
        [
            drawn(&found.open_loop_drawn),
            drawn(&found.closed_loop_drawn),
        ]
    });
    let subtitle = match uncertainty {
        Some(found) => format!(
            "{} of {} parameter sets within their standard errors are stable",
            found.samples - found.unstable - found.impossible,
            found.samples
        ),
        None => "The model states no standard errors".to_owned(),
    };
    figures::poles(&figures::Poles {
        title: &format!("{}: poles without and with the controller", designed.name()),
        subtitle: &subtitle,
        plane: Plane::Continuous,
        sets: &[
            PoleSet {
                name: "open loop",
                role: Role::Residual,
                poles: &open,
                cloud: &clouds[0],
            },
            PoleSet {
                name: "closed loop",
                role: Role::Model,
                poles: &closed,
                cloud: &clouds[1],
            },
        ],
    })
}

/// Largest recoverable angle against the wheel's top speed, for three wheels (thesis, figure 2.2).
fn sizing_figure(designed: &ModelDesign, sizing: &Sizing) -> Result<String, Failure> {
    let speeds: Vec<f64> = (1..=70).map(|step| 10.0 * f64::from(step)).collect();
    let inertias = wheels(sizing);
    let points = chart(sizing, &inertias, &speeds)
        .map_err(|error| Failure::in_file(designed.file.path(), error))?;
    let names = inertias.map(|inertia| format!("wheel of {} kg m2", significant(inertia, 3)));
    let roles = [Role::Other(0), Role::Model, Role::Other(1)];
    let column = |value: &dyn Fn(&design::ChartPoint) -> f64| -> Vec<Vec<f64>> {
        points
            .chunks(speeds.len())
            .map(|wheel| wheel.iter().map(value).collect())
            .collect()
    };
    let angles = column(&|point| point.recoverable_angle_rad.to_degrees());
    let recovered = column(&|point| point.recovered_energy_j);
    let energies = column(&|point| point.wheel_energy_j);
    let angle_lines = lines(&names, &roles, &speeds, &angles);
    let recovered_lines = lines(&names, &roles, &speeds, &recovered);
    let energy_lines = lines(&names, &roles, &speeds, &energies);
    let limit = designed.design.recovery_angle_rad.to_degrees();
    Ok(figures::series(&figures::Series {
        title: &format!("{}: what the wheel can recover", designed.name()),
        subtitle: "Largest angle at rest from which the body comes up, by the wheel's top speed",
        x: Quantity {
            name: "top speed of the wheel",
            unit: "rad/s",
        },
        panels: &[
            Panel {
                quantity: Quantity {
                    name: "recoverable angle",
                    unit: "°",
                },
                lines: &angle_lines,
                limits: &[figures::Limit {
                    value: limit,
                    name: "current limit",
                }],
                note: "",
            },
            Panel {
                quantity: Quantity {
                    name: "energy to recover",
                    unit: "J",
                },
                lines: &recovered_lines,
                limits: &[],
                note: "what the body lacks at that angle",
            },
            Panel {
                quantity: Quantity {
                    name: "energy in the wheel",
                    unit: "J",
                },
                lines: &energy_lines,
                limits: &[],
                note: "",
            },
        ],
        ..Default::default()
    })?)
}

fn lines<'a>(
    names: &'a [String],
    roles: &[Role],
    x: &'a [f64],
    series: &'a [Vec<f64>],
) -> Vec<Line<'a>> {
    names
        .iter()
        .zip(roles)
        .zip(series)
        .map(|((name, &role), y)| Line { name, role, x, y })
        .collect()
}

//! `certificate.json` of the emitted crate: the claims, with all numbers that are needed to check them again from the
//! emitted source alone.
//!
//! Real numbers are decimal strings, and the decimal is the exact value. Bounds are exact where they have at most
//! [`BOUND_DIGITS`] digits and otherwise rounded up in the last of them.

use serde::Serialize;

use crate::claims::ClaimId;
use crate::emit::certificate_hardware::Hardware;
use crate::emit::{control_rs, single_line};
use crate::exact::{ShortestDecimal, outward};
use crate::file::{EmittedFile, MARK};
use crate::held_voltage::HeldInput;
use crate::ir::IntegerLaw;
use crate::modes::Modes;
use crate::monitor::{MonitorNumbers, MonitorSpec};
use crate::spec::ModuleSpec;

/// Version of the layout below. It is raised when a field changes its meaning.
pub const FORMAT_VERSION: u32 = 5;

/// Significant digits of a bound.
const BOUND_DIGITS: u32 = 40;

/// The contents of `certificate.json`.
#[derive(Debug, Serialize)]
struct Certificate<'a> {
    generator: &'static str,
    format_version: u32,
    model: &'a str,
    /// Emitted files whose text the claims are about.
    files: Vec<&'a str>,
    sample_time_s: String,
    parameters: Vec<Parameter<'a>>,
    /// Correlations of the parameters' errors, if they are known.
    correlation: Option<Correlation<'a>>,
    weights: Weights,
    plant: Plant,
    /// K of u = −K x.
    gains: [String; 3],
    drive: Drive,
    hardware: Hardware,
    /// Unit per count according to the part or the statement, without the calibration.
    accelerometer_m_s2_per_count: Option<String>,
    /// Fresh samples of the gyroscope a second.
    gyro_rate_hz: Option<String>,
    /// Sentences about the properties of sensors and drive that the bench does not state.
    assumed: Vec<String>,
    inputs: Vec<Input<'a>>,
    output: Output,
    constants: Vec<Constant<'a>>,
    bounds: Bounds,
    claims: Vec<Claim>,
    /// The observer of the angle's bias, where the module has one.
    bias_observer: Option<Observer>,
    /// Bounds of the closed loop for all time, where they have been computed.
    closed_loop: Option<serde_json::Value>,
    /// For each mode of the loop, the row of the coordinate that decays by itself; `None` if the loop has no such
    /// modes.
    modes: Option<[[String; 3]; 3]>,
    /// The monitor, where the module has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    monitor: Option<Monitor>,
}

#[derive(Debug, Serialize)]
struct Parameter<'a> {
    name: &'a str,
    value: String,
    std: Option<String>,
    unit: &'a str,
}

#[derive(Debug, Serialize)]
struct Correlation<'a> {
    parameters: &'a [String],
    matrix: Vec<Vec<String>>,
}

#[derive(Debug, Serialize)]
struct Weights {
    state: [String; 3],
    current: String,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "PascalCase")]
struct Plant {
    a: [[String; 3]; 3],
    b: [String; 3],
    ad: [[String; 3]; 3],
    bd: [String; 3],
}

#[derive(Debug, Serialize)]
struct Drive {
    bits: u32,
    duty_zero: u16,
    duty_low: u16,
    duty_high: u16,
    amperes_per_count: String,
    /// Largest current in A that the drive gives in both directions.
    #[serde(rename = "current_range_A")]
    current_range_a: String,
    /// Further numbers of a voltage drive.
    voltage: Option<Voltage>,
}

/// A voltage drive: V = R u + k_e w for the current u (A) and the wheel speed w (rad/s), limited to ± the supply
/// voltage.
#[derive(Debug, Serialize)]
struct Voltage {
    volts_per_count: String,
    #[serde(rename = "supply_V")]
    supply_v: String,
    #[serde(rename = "winding_Ohm")]
    winding_ohm: String,
    #[serde(rename = "back_emf_V_s")]
    back_emf_v_s: String,
    /// The linear model, sampled with V/R held over a step.
    #[serde(rename = "Ad")]
    ad: [[String; 3]; 3],
    #[serde(rename = "Bd")]
    bd: [String; 3],
}

/// An argument of `control`.
#[derive(Debug, Serialize)]
struct Input<'a> {
    argument: &'a str,
    #[serde(rename = "type")]
    type_name: &'a str,
    fixed: String,
    fraction_bits: u32,
    range: &'a str,
    unit: &'a str,
}

/// The result of `control`.
#[derive(Debug, Serialize)]
struct Output {
    #[serde(rename = "type")]
    type_name: &'static str,
    fixed: String,
    fraction_bits: u32,
    unit: &'static str,
}

/// A constant of the emitted source and where it stands: `real` ≈ `raw` / 2^`fraction_bits`.
#[derive(Debug, Serialize)]
struct Constant<'a> {
    name: &'a str,
    file: &'static str,
    line: Option<usize>,
    /// The field of this file whose number became the constant.
    from: String,
    real: &'a str,
    raw: i64,
    fraction_bits: u32,
    unit: &'a str,
    /// The claims that depend on it.
    claims: Vec<ClaimId>,
}

#[derive(Debug, Serialize)]
struct Bounds {
    product_fraction_bits: u32,
    shift: u32,
    #[serde(rename = "rounding_A")]
    rounding: String,
    #[serde(rename = "real_gains_A")]
    real_gains: String,
    #[serde(rename = "state_rounding_A")]
    state_rounding: String,
}

/// Numbers of the observer, in rad per unit of each state and per A.
#[derive(Debug, Serialize)]
struct Observer {
    decay: String,
    direct: [String; 3],
    from_states: [String; 3],
    from_current: String,
    limit_rad: String,
}

/// The numbers behind the monitor's words, apart from the model.
#[derive(Debug, Serialize)]
struct Monitor {
    /// rad, rad/s, rad/s.
    noise_std: [String; 3],
    push_rad_s: String,
    wheel_limit_rad_s: String,
    body_limit_rad_s: String,
}

impl Monitor {
    fn of(told: &MonitorSpec, found: &MonitorNumbers) -> Monitor {
        let number = |value: f64| ShortestDecimal::new(value).text;
        Monitor {
            noise_std: told.noise_std.map(number),
            push_rad_s: number(found.push_rad_s),
            wheel_limit_rad_s: number(found.wheel_limit_rad_s),
            body_limit_rad_s: number(found.body_limit_rad_s),
        }
    }
}

#[derive(Debug, Serialize)]
struct Claim {
    id: ClaimId,
    statement: &'static str,
    domain: &'static str,
    #[serde(rename = "bound_A", skip_serializing_if = "Option::is_none")]
    bound: Option<String>,
}

/// The numbers that were computed for the module in addition to its law.
pub struct Found<'a> {
    /// The specification of the monitor and its numbers, if the module has one.
    pub monitor: Option<(&'a MonitorSpec, &'a MonitorNumbers)>,
    /// The modes of the loop.
    pub modes: Option<&'a Modes>,
    /// Bounds of the closed loop for all time.
    pub closed_loop: Option<serde_json::Value>,
}

/// Emits `certificate.json` for the `sources` emitted so far.
pub fn file(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    found: Found<'_>,
    sources: &[EmittedFile],
) -> EmittedFile {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let held = HeldInput::of(spec);
    let certificate = Certificate {
        generator: MARK,
        format_version: FORMAT_VERSION,
        model: &spec.model_name,
        files: sources.iter().map(|source| source.path.as_str()).collect(),
        sample_time_s: number(spec.sample_time_s),
        parameters: spec
            .parameters
            .iter()
            .map(|parameter| Parameter {
                name: &parameter.name,
                value: number(parameter.value),
                std: parameter.std.map(number),
                unit: &parameter.unit,
            })
            .collect(),
        correlation: spec.correlation.as_ref().map(|known| Correlation {
            parameters: &known.parameters,
            matrix: known
                .matrix
                .iter()
                .map(|row| row.iter().map(|entry| number(*entry)).collect())
                .collect(),
        }),
        weights: Weights {
            state: spec.state_weights.map(number),
            current: number(spec.current_weight),
        },
        plant: Plant {
            a: spec.a.map(|row| row.map(number)),
            b: spec.b.map(number),
            ad: spec.ad.map(|row| row.map(number)),
            bd: spec.bd.map(number),
        },
        gains: spec.gains.map(number),
        drive: Drive {
            bits: spec.drive.bits,
            duty_zero: spec.drive.duty_zero,
            duty_low: spec.drive.duty_low,
            duty_high: spec.drive.duty_high,
            amperes_per_count: number(spec.drive.amperes_per_count),
            current_range_a: number(spec.drive.current_range_a()),
            voltage: spec.drive.voltage.map(|drive| Voltage {
                ad: held.ad.map(|row| row.map(number)),
                bd: held.bd.map(number),
                volts_per_count: number(drive.volts_per_count),
                supply_v: number(drive.supply_v),
                winding_ohm: number(drive.winding_ohm),
                back_emf_v_s: number(drive.back_emf_v_s),
            }),
        },
        hardware: Hardware::of(spec),
        accelerometer_m_s2_per_count: spec.hardware.accelerometer_m_s2_per_count.map(number),
        gyro_rate_hz: spec.hardware.gyro_rate_hz.map(number),
        assumed: spec.assumed.iter().map(|text| single_line(text)).collect(),
        inputs: law
            .terms
            .iter()
            .map(|term| Input {
                argument: term.input.argument,
                type_name: term.input.type_name,
                fixed: term.input.format.type_name(),
                fraction_bits: term.input.format.fraction_bits,
                range: &term.input.range.text,
                unit: term.input.unit,
            })
            .collect(),
        output: Output {
            type_name: "Current",
            fixed: law.current.type_name(),
            fraction_bits: law.current.fraction_bits,
            unit: "A",
        },
        constants: constants(law, sources),
        bounds: Bounds {
            product_fraction_bits: law.product_fraction_bits,
            shift: law.shift,
            rounding: outward(&law.bounds.rounding, BOUND_DIGITS),
            real_gains: outward(&law.bounds.real_gains, BOUND_DIGITS),
            state_rounding: outward(&law.bounds.state_rounding, BOUND_DIGITS),
        },
        claims: ClaimId::ALL.map(|id| claim(id, law)).into(),
        bias_observer: spec
            .hardware
            .bias_observer
            .as_ref()
            .map(|observer| Observer {
                decay: number(observer.decay),
                direct: observer.direct.map(number),
                from_states: observer.from_states.map(number),
                from_current: number(observer.from_current),
                limit_rad: number(observer.limit_rad),
            }),
        closed_loop: found.closed_loop,
        modes: found
            .modes
            .map(|modes| modes.rows.map(|row| row.map(number))),
        monitor: found.monitor.map(|(told, found)| Monitor::of(told, found)),
    };
    let mut contents =
        serde_json::to_string_pretty(&certificate).expect("strings and integers serialise");
    contents.push('\n');
    EmittedFile {
        path: "certificate.json".to_owned(),
        contents,
    }
}

fn claim(id: ClaimId, law: &IntegerLaw) -> Claim {
    let bound = match id {
        ClaimId::ControlAccurate => Some(&law.bounds.rounding),
        ClaimId::ControlAccurateRealGains => Some(&law.bounds.real_gains),
        ClaimId::ControlTotal | ClaimId::ClosedLoopStable => None,
    };
    Claim {
        id,
        statement: id.statement(),
        domain: id.domain(),
        bound: bound.map(|bound| outward(bound, BOUND_DIGITS)),
    }
}

fn constants<'a>(law: &'a IntegerLaw, sources: &[EmittedFile]) -> Vec<Constant<'a>> {
    let source = sources
        .iter()
        .find(|source| source.path == control_rs::PATH);
    let line = |name: &str| {
        let start = format!("pub const {name}:");
        source.and_then(|source| {
            source
                .contents
                .lines()
                .position(|line| line.starts_with(&start))
                .map(|index| index + 1)
        })
    };
    let gains = law.terms.iter().enumerate().map(|(index, term)| Constant {
        name: term.gain.constant,
        file: control_rs::PATH,
        line: line(term.gain.constant),
        from: format!("-gains[{index}]"),
        real: &term.gain.real.text,
        raw: term.gain.raw.into(),
        fraction_bits: term.gain.fraction_bits,
        unit: term.gain.unit,
        claims: ClaimId::ALL.into(),
    });
    let limit = Constant {
        name: "CURRENT_LIMIT",
        file: control_rs::PATH,
        line: line("CURRENT_LIMIT"),
        from: "current_limit".to_owned(),
        real: &law.limit.text,
        raw: law.limit_raw.into(),
        fraction_bits: law.current.fraction_bits,
        unit: "A",
        // The linear loop has no limit of the current.
        claims: ClaimId::ALL
            .into_iter()
            .filter(|claim| *claim != ClaimId::ClosedLoopStable)
            .collect(),
    };
    gains.chain([limit]).collect()
}

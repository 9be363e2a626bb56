//! `flywheel simulate MODEL`

use std::path::{Path, PathBuf};

use attitude::AttitudeSpec;
use bench_files::Bench;
use checker::certificate::Certificate;
use codegen::ModuleSpec;
use figures::{Line, Panel, Quantity, Role};
use identify::{PushModel, Record};
use nalgebra::Matrix3;
use plant::{Kind, Plant};
use serde::Serialize;
use simulate::attitude_filters::compare_filters;
use simulate::linear_validity::{compare_free_swing, compare_spin_up, largest_linear_amplitude};
use simulate::overlay::MeasuredLog;
use simulate::scenario::Scale;
use simulate::{
    Actuator, ClosedLoop, ExactLaw, InterpretedController, InterpretedLaw, Motion, Push, RawLoop,
    RawSensors, Scenario, Sensors, SimulateError, Trace, Transient, effects_on_transient,
    largest_recoverable_angle, overlay, region_of_attraction,
};

use crate::bench_folder::file_name;
use crate::cli::Output;
use crate::failure::Failure;
use crate::model_design::ModelDesign;
use crate::module_spec::module_spec;
use crate::progress::while_doing;
use crate::report::Report;
use crate::report::numbers::{significant, with_prefix};
use crate::report::table::{Align, Table};
use crate::spin_linearity::{SpinLinearity, SpinUpJson};
use crate::swing_linearity::{PERIODS, SwingLinearity, SwingLinearityJson};

/// Starts on each boundary of the region of attraction.
const STARTS: usize = 600;
/// Resolution of its size, the certificate's ellipsoid having 1.
const SIZE_RESOLUTION: f64 = 0.02;
/// Resolution of the bisection for the largest recoverable angle, rad: a hundredth of a degree.
const ANGLE_RESOLUTION_RAD: f64 = 1.745e-4;
/// An angle that counts as a swing, as a share of the largest angle that the current allows.
const SWING_SHARE: f64 = 0.02;
/// Start of the swing on which the attitude filters are compared, rad from hanging: 60°.
const SWING_START_RAD: f64 = std::f64::consts::FRAC_PI_3;
/// Where the sensor sits there, m.
const SENSOR_FROM_PIVOT_M: f64 = 0.05;
/// Length of the swing, s.
const SWING_S: f64 = 20.0;
/// Error at which the linear model counts as no longer good.
const LINEAR_SHARE: f64 = 0.05;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Overlay the free swings and balance logs of this bench
    #[arg(long)]
    pub bench: Option<PathBuf>,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for figures and tables [default: out beside MODEL]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct SimulateJson {
    model: String,
    gains: [f64; 3],
    seed: u64,
    runs: Vec<RunJson>,
    raw_counts: RawCountsJson,
    recovery: RecoveryJson,
    /// Where the certificate states an ellipsoid to enlarge.
    attraction: Option<AttractionJson>,
    attitude_filters: Vec<FilterJson>,
    effects: Vec<EffectsJson>,
    linear_model: LinearJson,
    /// The measured free swings of the bench, where one was named and has any.
    measured_swings: Option<SwingLinearityJson>,
    /// The measured spin-ups of the bench; empty where none was named or has any.
    measured_spin_ups: Vec<SpinUpJson>,
    overlays: Vec<OverlayJson>,
    files: Vec<PathBuf>,
}

#[derive(Serialize)]
struct RunJson {
    scenario: &'static str,
    about: &'static str,
    fell: bool,
    largest_angle_rad: f64,
    largest_wheel_speed_rad_s: f64,
    largest_current_a: f64,
    settling_s: f64,
    /// Largest differences between the emitted and the exact law.
    difference_angle_rad: f64,
    difference_current_a: f64,
}

/// The half minute through raw counts and duty, with the emitted attitude filter.
#[derive(Serialize)]
struct RawCountsJson {
    fell: bool,
    largest_angle_rad: f64,
    largest_wheel_speed_rad_s: f64,
    largest_current_a: f64,
    /// RMS of the filter's angle against the true one.
    angle_error_rad: f64,
}

#[derive(Serialize)]
struct FilterJson {
    filter: &'static str,
    /// RMS of its angle against the true one over the swing.
    error_rad: f64,
}

#[derive(Serialize)]
struct AttractionJson {
    /// Largest size of the certificate's ellipsoid of which every start came back.
    size: f64,
    lost_size: f64,
    /// rad, rad/s, rad/s.
    lost: [f64; 3],
    extents: [f64; 3],
    starts: usize,
}

#[derive(Serialize)]
struct RecoveryJson {
    emitted_law_rad: f64,
    exact_law_rad: f64,
    /// asin(τ u_max/G).
    limit_rad: f64,
    resolution_rad: f64,
}

#[derive(Serialize)]
struct EffectsJson {
    /// Effects beyond viscous friction.
    effects: Vec<&'static str>,
    swings: usize,
    overshoot_rad: f64,
    settling_s: f64,
    residual_rad: f64,
    fell: bool,
}

#[derive(Serialize)]
struct LinearJson {
    share: f64,
    /// Amplitude up to which ten periods of the linear free swing follow the nonlinear one.
    good_up_to_amplitude_rad: f64,
    /// [amplitude in rad, error over the first period].
    free_swing_error: Vec<[f64; 2]>,
    spin_up_good_up_to_rad_s: Option<f64>,
}

#[derive(Serialize)]
struct OverlayJson {
    experiment: String,
    pushes: usize,
    /// By channel: RMS difference, standard deviation measured and simulated.
    channels: Vec<OverlayChannelJson>,
}

#[derive(Serialize)]
struct OverlayChannelJson {
    channel: &'static str,
    rms_difference: f64,
    measured_std: f64,
    simulated_std: f64,
}

/// A model with its laws and its plant.
struct Work<'a> {
    designed: &'a ModelDesign,
    plant: &'a Plant<f64>,
    scale: Scale,
    seed: u64,
    out: PathBuf,
    exact: ExactLaw,
    emitted: InterpretedLaw,
    controller: InterpretedController,
    /// The sensors that the module believes in, with what a calibration leaves.
    sensors: RawSensors,
    spec: ModuleSpec,
    /// P of the set in which no command saturates, where the certificate states one.
    ellipsoid: Option<Matrix3<f64>>,
    files: Vec<PathBuf>,
    text: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let bench = arguments.bench.as_deref().map(Bench::load).transpose()?;
    let designed = ModelDesign::new(&arguments.model)?;
    let in_file = |error: SimulateError| Failure::in_file(&arguments.model, error);
    let gains = [0, 1, 2].map(|index| designed.design.gains[index]);
    let limit_a = designed.wishes.current_limit_a;
    let plant = Plant::new(&designed.model, &designed.values, Kind::Balance);
    let spec = module_spec(&designed)?;
    let (module, ellipsoid) = emitted_module(&spec, &arguments.model)?;
    let mut work = Work {
        plant: &plant,
        scale: Scale::new(&designed.values, limit_a).map_err(in_file)?,
        seed: arguments.seed,
        out: out_folder(arguments),
        exact: ExactLaw {
            gains: designed.design.gains,
            limit_a,
        },
        emitted: InterpretedLaw::new(&module)
            .map_err(|error| Failure::in_file(&arguments.model, error))?,
        controller: InterpretedController::new(&module)
            .map_err(|error| Failure::in_file(&arguments.model, error))?,
        sensors: sensors_of(&spec).map_err(in_file)?,
        spec,
        ellipsoid,
        files: Vec::new(),
        text: format!(
            "{}: the emitted law, run word for word from its source, on the nonlinear bench\n",
            designed.name()
        ),
        designed: &designed,
    };
    let json = while_doing("simulating", || -> Result<SimulateJson, Failure> {
        let runs = work.scenarios()?;
        let raw_counts = work.raw_counts()?;
        let recovery = work.recovery()?;
        let attraction = work.attraction()?;
        let attitude_filters = work.attitude_filters()?;
        let effects = work.effects()?;
        let linear_model = work.linear_model()?;
        let (measured_swings, measured_spin_ups, overlays) = match &bench {
            Some(bench) => (
                work.measured_swings(bench)?,
                work.measured_spin_ups(bench)?,
                work.overlays(bench)?,
            ),
            None => (None, Vec::new(), Vec::new()),
        };
        Ok(SimulateJson {
            model: work.designed.name(),
            gains,
            seed: work.seed,
            runs,
            raw_counts,
            recovery,
            attraction,
            attitude_filters,
            effects,
            linear_model,
            measured_swings,
            measured_spin_ups,
            overlays,
            files: work.files.clone(),
        })
    })?;
    work.text.push_str("\nFigures and tables\n");
    for path in &work.files {
        work.text.push_str(&format!("  {}\n", path.display()));
    }
    Report::new(work.text, &json)
}

fn out_folder(arguments: &Arguments) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| {
        let beside = arguments.model.parent();
        beside.map_or_else(|| PathBuf::from("out"), |folder| folder.join("out"))
    })
}

/// The source that `generate` would emit, and P of the ellipsoid in its certificate.
fn emitted_module(
    spec: &ModuleSpec,
    model: &Path,
) -> Result<(checker::Module, Option<Matrix3<f64>>), Failure> {
    let emitted = codegen::generate(spec).map_err(|refusal| Failure::in_file(model, refusal))?;
    let sources: Vec<(&str, &str)> = emitted
        .files
        .iter()
        .filter(|file| file.path.ends_with(".rs"))
        .map(|file| (file.path.as_str(), file.contents.as_str()))
        .collect();
    let module = checker::Module::parse(&sources)
        .map_err(|error| Failure::in_file(model, format!("the emitted source: {error}")))?;
    let mut texts = emitted.files.iter();
    let certificate = texts
        .find(|file| file.path == "certificate.json")
        .map(|file| Certificate::parse(&file.contents))
        .transpose()
        .map_err(|error| Failure::in_file(model, format!("the emitted {error}")))?;
    let ellipsoid = certificate.and_then(|certificate| {
        let rows = certificate.closed_loop?.ellipsoid;
        // Every decimal of the certificate is a number.
        let entry = |row: usize, column: usize| rows[row][column].to_string().parse();
        Some(Matrix3::from_fn(|row, column| {
            entry(row, column).unwrap_or(f64::NAN)
        }))
    });
    Ok((module, ellipsoid))
}

/// Sensors and drive that the module's constants describe rightly, but for what a calibration
/// leaves.
fn sensors_of(spec: &ModuleSpec) -> Result<RawSensors, SimulateError> {
    Ok(RawSensors {
        wheel_speed_per_count: spec.hardware.wheel_speed_per_count,
        wheel_speed_at_zero: spec.hardware.wheel_speed_at_zero,
        duty_zero: spec.drive.duty_zero,
        current_per_count_a: spec.drive.current_range_a / f64::from(spec.drive.counts()),
        ..RawSensors::calibrated_by(&spec.hardware.attitude)?
    })
}

impl<'a> Work<'a> {
    fn bench(&self) -> ClosedLoop<'a> {
        ClosedLoop {
            motion: Motion::Nonlinear(self.plant),
            sensors: Sensors::of_the_thesis(),
            actuator: Actuator::OF_THE_THESIS,
            sample_time_s: self.designed.wishes.sample_time_s,
            computation_s: 0.0,
            pushes: Vec::new(),
            seed: self.seed,
        }
    }

    fn failure(&self) -> impl Fn(SimulateError) -> Failure + use<> {
        let file = self.designed.file.path().to_path_buf();
        move |error| Failure::in_file(&file, error)
    }

    /// The angle that counts as a swing.
    fn threshold_rad(&self) -> f64 {
        SWING_SHARE * self.scale.holding_angle_rad()
    }

    fn write_figure(&mut self, name: &str, svg: &str) -> Result<(), Failure> {
        let path = self.out.join(format!("{name}.svg"));
        figures::write_svg(&path, svg)?;
        self.files.push(path);
        Ok(())
    }

    fn write_table(&mut self, name: &str, trace: &Trace) -> Result<(), Failure> {
        self.write_columns(name, &trace.columns())
    }

    /// Columns of one length with their names.
    fn write_columns<N: AsRef<str>>(
        &mut self,
        name: &str,
        columns: &[(N, &[f64])],
    ) -> Result<(), Failure> {
        let path = self.out.join(format!("{name}.csv"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        let broken = |error: csv::Error| Failure::in_file(&path, error);
        writer
            .write_record(columns.iter().map(|(name, _)| name.as_ref()))
            .map_err(broken)?;
        let rows = columns.iter().map(|(_, values)| values.len()).min();
        for row in 0..rows.unwrap_or(0) {
            let cells = columns.iter().map(|(_, values)| values[row].to_string());
            writer.write_record(cells).map_err(broken)?;
        }
        let bytes = writer
            .into_inner()
            .map_err(|error| Failure::in_file(&path, error))?;
        bench_files::write_atomically(&path, &bytes)?;
        self.files.push(path);
        Ok(())
    }

    /// Transient, disturbance, half a minute: the emitted law beside the exact one.
    fn scenarios(&mut self) -> Result<Vec<RunJson>, Failure> {
        let mut table = Table::new(&[
            ("run", Align::Left),
            ("largest angle", Align::Right),
            ("wheel", Align::Right),
            ("current", Align::Right),
            ("settles after", Align::Right),
            ("emitted − exact", Align::Right),
            ("", Align::Left),
        ]);
        let mut runs = Vec::new();
        for scenario in Scenario::all(&self.scale) {
            let bench = self.bench();
            let (mut exact, mut emitted) = (self.exact.clone(), self.emitted.clone());
            let traces = scenario
                .run(&bench, &mut [&mut exact, &mut emitted])
                .map_err(self.failure())?;
            let [exact, emitted] = &traces[..] else {
                return Err(Failure::new("a scenario ran another number of laws"));
            };
            let transient = Transient::of(emitted, self.threshold_rad());
            let difference = emitted.deviation(exact);
            let largest = emitted
                .angle_rad
                .iter()
                .fold(0.0_f64, |m, angle| m.max(angle.abs()));
            table.row([
                scenario.name.to_owned(),
                format!("{:.2}°", largest.to_degrees()),
                format!("{} rad/s", significant(transient.wheel_speed_rad_s, 3)),
                format!("{} A", significant(transient.current_a, 3)),
                format!("{} s", significant(transient.settling_s, 3)),
                with_prefix(difference.angle_rad, "rad"),
                if transient.fell { "FELL" } else { "" }.to_owned(),
            ]);
            runs.push(RunJson {
                scenario: scenario.name,
                about: scenario.about,
                fell: transient.fell,
                largest_angle_rad: largest,
                largest_wheel_speed_rad_s: transient.wheel_speed_rad_s,
                largest_current_a: transient.current_a,
                settling_s: transient.settling_s,
                difference_angle_rad: difference.angle_rad,
                difference_current_a: difference.current_a,
            });
            let svg = self.scenario_figure(&scenario, exact, emitted)?;
            self.write_figure(&format!("simulate-{}", scenario.name), &svg)?;
            self.write_table(&format!("simulate-{}", scenario.name), emitted)?;
        }
        self.text
            .push_str(&format!("\nRuns of the emitted law\n{}", table.text()));
        Ok(runs)
    }

    fn scenario_figure(
        &self,
        scenario: &Scenario,
        exact: &Trace,
        emitted: &Trace,
    ) -> Result<String, Failure> {
        let degrees = |trace: &Trace| -> Vec<f64> {
            trace.angle_rad.iter().map(|a| a.to_degrees()).collect()
        };
        let angles = [degrees(exact), degrees(emitted)];
        let lines = |exact_y, emitted_y| {
            [
                Line {
                    name: "exact law",
                    role: Role::Float,
                    x: &exact.time_s,
                    y: exact_y,
                },
                Line {
                    name: "emitted fixed-point law",
                    role: Role::FixedPoint,
                    x: &emitted.time_s,
                    y: emitted_y,
                },
            ]
        };
        let angle: [Line; 2] = lines(&angles[0], &angles[1]);
        let wheel: [Line; 2] = lines(&exact.wheel_speed_rad_s, &emitted.wheel_speed_rad_s);
        let current: [Line; 2] = lines(&exact.current_a, &emitted.current_a);
        let labels: Vec<String> = scenario
            .pushes
            .iter()
            .map(|push| with_prefix(push.impulse(), "N m s"))
            .collect();
        let markers: Vec<figures::Marker> = scenario
            .pushes
            .iter()
            .zip(&labels)
            .map(|(push, label)| figures::Marker {
                at: push.time_s,
                label,
            })
            .collect();
        let limit = self.designed.wishes.current_limit_a;
        let limits = [limit, -limit].map(|value| figures::Limit {
            value,
            name: "limit",
        });
        let panel = |name, unit, lines, limits| Panel {
            quantity: Quantity { name, unit },
            lines,
            limits,
            note: "",
        };
        Ok(figures::series(&figures::Series {
            title: &format!("{}: {}", self.designed.name(), scenario.about),
            subtitle: "Nonlinear bench with all effects of its model, sensor noise and steps",
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &[
                panel("angle from upright", "°", &angle, &[]),
                panel("wheel speed", "rad/s", &wheel, &[]),
                panel("current", "A", &current, &limits),
            ],
            markers: &markers,
            ..Default::default()
        })?)
    }

    /// The half minute with pushes through raw counts: sensors' noise, bias and steps, emitted
    /// attitude filter and law, duty.
    fn raw_counts(&mut self) -> Result<RawCountsJson, Failure> {
        let failure = self.failure();
        let scenario = Scenario::half_minute(&self.scale);
        let on = RawLoop {
            drive_limit_a: self.spec.drive.current_range_a,
            sample_time_s: self.spec.sample_time_s,
            pushes: scenario.pushes,
            ..RawLoop::new(self.plant, self.sensors, self.seed)
        };
        let start_rad = simulate::sensors::from_upright_rad(scenario.start.angle_rad);
        let trace = on
            .run(start_rad, scenario.duration_s, &mut self.controller, false)
            .map_err(failure)?;
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let errors = trace.angle_rad.iter().zip(&trace.measured_angle_rad);
        let squares: f64 = errors.map(|(truth, told)| (truth - told).powi(2)).sum();
        let json = RawCountsJson {
            fell: trace.fell_at_s.is_some(),
            largest_angle_rad: largest(&trace.angle_rad),
            largest_wheel_speed_rad_s: largest(&trace.wheel_speed_rad_s),
            largest_current_a: largest(&trace.current_a),
            angle_error_rad: (squares / trace.len() as f64).sqrt(),
        };
        self.text.push_str(&format!(
            "\nThe half minute from raw counts to duty, with the emitted attitude filter\n  {}, at most {:.2}°, wheel {} rad/s, {} A; the filter's angle is off by {:.3}° RMS\n",
            if json.fell { "FELL" } else { "stays up" },
            json.largest_angle_rad.to_degrees(),
            significant(json.largest_wheel_speed_rad_s, 3),
            significant(json.largest_current_a, 3),
            json.angle_error_rad.to_degrees(),
        ));
        self.write_table("simulate-raw-counts", &trace)?;
        Ok(json)
    }

    /// The ways to an angle on one free swing (thesis figure 3.3).
    fn attitude_filters(&mut self) -> Result<Vec<FilterJson>, Failure> {
        // On the pivot an accelerometer alone would do; off it, it feels the swing. A model that
        // does not say where the sensor sits gets one that is off it.
        let stated = self.spec.hardware.attitude.lever_arm_m;
        let lever_arm_m = if stated == [0.0; 2] {
            [SENSOR_FROM_PIVOT_M, 0.0]
        } else {
            stated
        };
        let attitude = AttitudeSpec {
            sample_time_s: self.spec.sample_time_s,
            lever_arm_m,
            ..self.spec.hardware.attitude
        };
        let sensors = RawSensors {
            lever_arm_m,
            ..self.sensors
        };
        let found = compare_filters(
            &self.designed.model,
            &self.designed.values,
            &sensors,
            &attitude,
            SWING_START_RAD,
            SWING_S,
            self.seed,
        )
        .map_err(self.failure())?;
        let degrees = |values: &[f64]| -> Vec<f64> {
            values.iter().map(|value| value.to_degrees()).collect()
        };
        let estimates: Vec<(&str, Role, Vec<f64>, Vec<f64>)> = found
            .estimates()
            .into_iter()
            .enumerate()
            .map(|(index, (name, angle))| {
                let errors = angle.iter().zip(&found.truth_rad);
                let errors = errors.map(|(angle, truth)| (angle - truth).to_degrees());
                (name, Role::Other(index), degrees(angle), errors.collect())
            })
            .collect();
        let line = |name, role, y| Line {
            name,
            role,
            x: &found.time_s,
            y,
        };
        let truth = degrees(&found.truth_rad);
        let mut angles = vec![line("truth", Role::Measurement, &truth[..])];
        let mut errors = Vec::new();
        // The accelerometer alone would hide the others; its error stands in the text.
        for (name, role, angle, error) in estimates.iter().skip(1) {
            angles.push(line(name, *role, angle));
            errors.push(line(name, *role, error));
        }
        let panel = |name, lines| Panel {
            quantity: Quantity { name, unit: "°" },
            lines,
            limits: &[],
            note: "",
        };
        let svg = figures::series(&figures::Series {
            title: &format!("{}: ways to the angle", self.designed.name()),
            subtitle: &format!(
                "One simulated free swing, the same raw counts for all; sensor {} mm off the pivot, \
                 for which Madgwick's filter corrects",
                significant(1e3 * lever_arm_m[0].hypot(lever_arm_m[1]), 3)
            ),
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &[
                panel("angle from hanging", &angles),
                panel("error", &errors),
            ],
            ..Default::default()
        })?;
        self.write_figure("simulate-attitude-filters", &svg)?;
        self.text
            .push_str("\nWays to the angle, RMS error over a free swing from 60°\n");
        let mut json = Vec::new();
        for (filter, angle) in found.estimates() {
            let error_rad = found.rms_error_rad(angle);
            self.text
                .push_str(&format!("  {filter}: {:.3}°\n", error_rad.to_degrees()));
            json.push(FilterJson { filter, error_rad });
        }
        Ok(json)
    }

    /// The largest angle that both laws recover from, by bisection.
    fn recovery(&mut self) -> Result<RecoveryJson, Failure> {
        let bench = ClosedLoop {
            sensors: Sensors::PERFECT,
            ..self.bench()
        };
        let scale = self.scale;
        let emitted =
            largest_recoverable_angle(&bench, &scale, &mut self.emitted, ANGLE_RESOLUTION_RAD)
                .map_err(self.failure())?;
        let exact =
            largest_recoverable_angle(&bench, &scale, &mut self.exact, ANGLE_RESOLUTION_RAD)
                .map_err(self.failure())?;
        self.text.push_str(&format!(
            "\nLargest angle recovered from rest, without sensor noise\n  emitted law {:.2}°, exact law {:.2}°, asin(τ u_max/G) = {:.2}°\n",
            emitted.recovered_rad.to_degrees(),
            exact.recovered_rad.to_degrees(),
            emitted.limit_rad.to_degrees(),
        ));
        Ok(RecoveryJson {
            emitted_law_rad: emitted.recovered_rad,
            exact_law_rad: exact.recovered_rad,
            limit_rad: emitted.limit_rad,
            resolution_rad: ANGLE_RESOLUTION_RAD,
        })
    }

    /// The largest ellipsoid of starts that the emitted law brings back, noise and all.
    fn attraction(&mut self) -> Result<Option<AttractionJson>, Failure> {
        let Some(shape) = self.ellipsoid else {
            return Ok(None);
        };
        let found = region_of_attraction(
            &self.bench(),
            &self.scale,
            &mut self.emitted,
            &shape,
            STARTS,
            SIZE_RESOLUTION,
        )
        .map_err(self.failure())?;
        let [angle, rate, speed] = found.extents;
        let lost = found.lost;
        self.text.push_str(&format!(
            "\nRegion of attraction, {} starts all over the boundary, with the sensors' noise\n  all return from {:.2} of the certificate's ellipsoid (up to {:.1}°, {} rad/s, wheel {} rad/s)\n  one is lost from {:.2} of it: {:.1}°, {} rad/s, wheel {} rad/s\n",
            found.starts,
            found.size,
            angle.to_degrees(),
            significant(rate, 3),
            significant(speed, 3),
            found.lost_size,
            lost[0].to_degrees(),
            significant(lost[1], 3),
            significant(lost[2], 3),
        ));
        Ok(Some(AttractionJson {
            size: found.size,
            lost_size: found.lost_size,
            lost,
            extents: found.extents,
            starts: found.starts,
        }))
    }

    /// What each effect of the model does to the transient.
    fn effects(&mut self) -> Result<Vec<EffectsJson>, Failure> {
        let found = effects_on_transient(
            &self.designed.model,
            &self.designed.values,
            &self.bench(),
            &Scenario::transient(&self.scale),
            &mut self.emitted.clone(),
            self.threshold_rad(),
        )
        .map_err(self.failure())?;
        let mut table = Table::new(&[
            ("beyond viscous friction", Align::Left),
            ("swings", Align::Right),
            ("overshoot", Align::Right),
            ("settles after", Align::Right),
            ("what stays (RMS)", Align::Right),
        ]);
        let mut effects = Vec::new();
        for part in &found {
            let names: Vec<&'static str> = part.effects.iter().map(|e| e.name()).collect();
            let transient = &part.transient;
            table.row([
                if names.is_empty() {
                    "nothing".to_owned()
                } else {
                    names.join(", ")
                },
                transient.swings.to_string(),
                format!("{:.3}°", transient.overshoot_rad.to_degrees()),
                format!("{} s", significant(transient.settling_s, 3)),
                with_prefix(transient.residual_rad, "rad"),
            ]);
            effects.push(EffectsJson {
                effects: names,
                swings: transient.swings,
                overshoot_rad: transient.overshoot_rad,
                settling_s: transient.settling_s,
                residual_rad: transient.residual_rad,
                fell: transient.fell,
            });
        }
        self.text.push_str(&format!(
            "\nThe transient with the effects of the model\n{}",
            table.text()
        ));
        Ok(effects)
    }

    /// How far the linear model can be trusted.
    fn linear_model(&mut self) -> Result<LinearJson, Failure> {
        let (model, values) = (&self.designed.model, &self.designed.values);
        let failure = self.failure();
        let good_up_to_amplitude_rad =
            largest_linear_amplitude(model, values, PERIODS, LINEAR_SHARE).map_err(&failure)?;
        let swings = [20.0_f64, 60.0]
            .map(|degrees| compare_free_swing(model, values, degrees.to_radians(), 6.0));
        let [small, large] = swings;
        let (small, large) = (small.map_err(&failure)?, large.map_err(&failure)?);
        let current_a = 0.5 * self.designed.wishes.current_limit_a;
        let spin_up =
            compare_spin_up(model, values, current_a, 5.0, LINEAR_SHARE).map_err(&failure)?;
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let spin_up_text = match spin_up.good_up_to_rad_s {
            Some(speed) => format!("up to {} rad/s", significant(speed, 3)),
            None => "over the whole run".to_owned(),
        };
        self.text.push_str(&format!(
            "\nThe linear model\n  ten periods of a free swing within {} of the nonlinear one up to {:.1}° (same terms)\n  error over the first period: {} from 20°, {} from 60°\n  spin-up with {} A within {}: {spin_up_text}\n",
            percent(LINEAR_SHARE),
            good_up_to_amplitude_rad.to_degrees(),
            percent(small.error_over_first_period),
            percent(large.error_over_first_period),
            significant(current_a, 3),
            percent(LINEAR_SHARE),
        ));

        let degrees = |radians: &[f64]| -> Vec<f64> {
            radians.iter().map(|angle| angle.to_degrees()).collect()
        };
        let series =
            [&small, &large].map(|swing| (degrees(&swing.whole_rad), degrees(&swing.linear_rad)));
        let lines = |time_s, whole, linear| {
            [
                Line {
                    name: "nonlinear model",
                    role: Role::Model,
                    x: time_s,
                    y: whole,
                },
                Line {
                    name: "linear model",
                    role: Role::Other(0),
                    x: time_s,
                    y: linear,
                },
            ]
        };
        let from_small: [Line; 2] = lines(&small.time_s, &series[0].0, &series[0].1);
        let from_large: [Line; 2] = lines(&large.time_s, &series[1].0, &series[1].1);
        let speeds: [Line; 2] = lines(&spin_up.time_s, &spin_up.whole_rad_s, &spin_up.linear_rad_s);
        let panel = |name, unit, lines| Panel {
            quantity: Quantity { name, unit },
            lines,
            limits: &[],
            note: "",
        };
        let svg = figures::series(&figures::Series {
            title: &format!("{}: where the linear model stops", self.designed.name()),
            subtitle: "Free swings from 20° and 60°, and a spin-up with the body clamped",
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &[
                panel("angle from 20°", "°", &from_small),
                panel("angle from 60°", "°", &from_large),
                panel("wheel speed", "rad/s", &speeds),
            ],
            ..Default::default()
        })?;
        let json = LinearJson {
            share: LINEAR_SHARE,
            good_up_to_amplitude_rad,
            free_swing_error: [&small, &large]
                .map(|swing| [swing.amplitude_rad, swing.error_over_first_period])
                .to_vec(),
            spin_up_good_up_to_rad_s: spin_up.good_up_to_rad_s,
        };
        self.write_figure("simulate-linear-model", &svg)?;
        for (name, swing) in [("20deg", &small), ("60deg", &large)] {
            self.write_columns(
                &format!("simulate-free-swing-{name}"),
                &[
                    ("time_s", &swing.time_s[..]),
                    ("nonlinear_angle_rad", &swing.whole_rad),
                    ("linear_angle_rad", &swing.linear_rad),
                ],
            )?;
        }
        self.write_columns(
            "simulate-spin-up",
            &[
                ("time_s", &spin_up.time_s[..]),
                ("nonlinear_wheel_speed_rad_s", &spin_up.whole_rad_s),
                ("linear_wheel_speed_rad_s", &spin_up.linear_rad_s),
            ],
        )?;
        Ok(json)
    }

    /// The nonlinear and the linear model over each measured free swing of a bench.
    fn measured_swings(&mut self, bench: &Bench) -> Result<Option<SwingLinearityJson>, Failure> {
        let found = SwingLinearity::of(bench, self.designed).map_err(self.failure())?;
        if found.is_empty() {
            return Ok(None);
        }
        self.text.push_str(&found.text());
        let svg = found.figure(&self.designed.name())?;
        self.write_figure("simulate-measured-free-swings", &svg)?;
        for (name, columns) in found.columns() {
            self.write_columns(&format!("simulate-over-{}", file_name(name)), &columns)?;
        }
        Ok(Some(found.json()))
    }

    /// The nonlinear and the linear model over each measured spin-up of a bench.
    fn measured_spin_ups(&mut self, bench: &Bench) -> Result<Vec<SpinUpJson>, Failure> {
        let found = SpinLinearity::of(bench, self.designed).map_err(self.failure())?;
        if found.is_empty() {
            return Ok(vec![]);
        }
        self.text.push_str(&found.text());
        let svg = found.figure(&self.designed.name())?;
        self.write_figure("simulate-measured-spin-ups", &svg)?;
        for (name, columns) in found.columns() {
            self.write_columns(&format!("simulate-over-{}", file_name(name)), &columns)?;
        }
        Ok(found.json())
    }

    /// The simulated loop over each balance log of a bench, with the pushes found in it.
    fn overlays(&mut self, bench: &Bench) -> Result<Vec<OverlayJson>, Failure> {
        let push_model = PushModel::of(&self.designed.model, &self.designed.values);
        let balance = bench
            .experiments
            .iter()
            .filter(|experiment| experiment.kind == Kind::Balance);
        let mut overlays = Vec::new();
        for experiment in balance {
            let log = &experiment.log;
            let Some(angle_rad) = log.angle_rad.as_deref() else {
                continue;
            };
            let pushes: Vec<Push> =
                identify::find_pushes(&Record::from_experiment(experiment), &push_model)
                    .iter()
                    .map(|push| Push::of_impulse(push.time_s, push.impulse_nms, push.peak_nm))
                    .collect();
            let loop_with_pushes = ClosedLoop {
                pushes: pushes.clone(),
                ..self.bench()
            };
            let measured = MeasuredLog {
                time_s: &log.time_s,
                angle_rad,
                rate_rad_s: log.rate_rad_s.as_deref(),
                wheel_speed_rad_s: log.wheel_speed_rad_s.as_deref(),
                current_a: log.current_a.as_deref(),
            };
            // The bench's own controller recorded the log.
            let mut own = match bench.controller {
                Some(own) => ExactLaw {
                    gains: own.gains.into(),
                    limit_a: own.current_limit_a,
                },
                None => self.exact.clone(),
            };
            let found = overlay(&measured, &loop_with_pushes, &mut own).map_err(self.failure())?;
            let mut table = Table::new(&[
                ("channel", Align::Left),
                ("RMS of the difference", Align::Right),
                ("measured σ", Align::Right),
                ("simulated σ", Align::Right),
            ]);
            for channel in &found.channels {
                table.row([
                    channel.name.to_owned(),
                    significant(channel.rms_difference, 3),
                    significant(channel.measured_std, 3),
                    significant(channel.simulated_std, 3),
                ]);
            }
            self.text.push_str(&format!(
                "\nSimulated over measured: {} ({} pushes found in the log; SI units)\n{}",
                experiment.name,
                pushes.len(),
                table.text()
            ));
            let svg = overlay_figure(&self.designed.name(), &experiment.name, &found)?;
            let name = format!("simulate-over-{}", file_name(&experiment.name));
            self.write_figure(&name, &svg)?;
            let mut columns: Vec<(String, &[f64])> = vec![("time_s".to_owned(), &found.time_s)];
            for channel in &found.channels {
                columns.push((format!("measured_{}", channel.name), &channel.measured));
                columns.push((format!("simulated_{}", channel.name), &channel.simulated));
            }
            self.write_columns(&name, &columns)?;
            overlays.push(OverlayJson {
                experiment: experiment.name.clone(),
                pushes: pushes.len(),
                channels: found
                    .channels
                    .iter()
                    .map(|channel| OverlayChannelJson {
                        channel: channel.name,
                        rms_difference: channel.rms_difference,
                        measured_std: channel.measured_std,
                        simulated_std: channel.simulated_std,
                    })
                    .collect(),
            });
        }
        Ok(overlays)
    }
}

fn overlay_figure(
    model: &str,
    experiment: &str,
    found: &simulate::Overlay,
) -> Result<String, Failure> {
    let quantity = |name: &str| match name {
        "angle" => ("angle from upright", "rad"),
        "rate" => ("rate", "rad/s"),
        "wheel_speed" => ("wheel speed", "rad/s"),
        _ => ("current", "A"),
    };
    let lines: Vec<[Line; 2]> = found
        .channels
        .iter()
        .map(|channel| {
            [
                Line {
                    name: "measurement",
                    role: Role::Measurement,
                    x: &found.time_s,
                    y: &channel.measured,
                },
                Line {
                    name: "simulation",
                    role: Role::Model,
                    x: &found.time_s,
                    y: &channel.simulated,
                },
            ]
        })
        .collect();
    let panels: Vec<Panel> = found
        .channels
        .iter()
        .zip(&lines)
        .map(|(channel, lines)| {
            let (name, unit) = quantity(channel.name);
            Panel {
                quantity: Quantity { name, unit },
                lines,
                limits: &[],
                note: "",
            }
        })
        .collect();
    Ok(figures::series(&figures::Series {
        title: &format!("{model}: simulated loop over the log \"{experiment}\""),
        subtitle: "Noise differs from sample to sample, so size and shape compare, not samples",
        x: Quantity {
            name: "time",
            unit: "s",
        },
        panels: &panels,
        ..Default::default()
    })?)
}

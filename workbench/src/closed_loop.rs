//! A designed controller on the nonlinear bench.

use attitude::AttitudeSpec;
use bench_files::Bench;
use codegen::ModuleSpec;
use identify::{Progress, PushModel, Record};
use nalgebra::Matrix3;
use plant::{Kind, Plant};
use serde::{Deserialize, Serialize};
use simulate::attitude_filters::{FilterComparison, compare_filters};
use simulate::linear_validity::{
    SpinUpComparison, SwingComparison, compare_free_swing, compare_spin_up,
    largest_linear_amplitude,
};
use simulate::overlay::MeasuredLog;
use simulate::scenario::Scale;
use simulate::{
    Actuator, ClosedLoop, ExactLaw, InterpretedController, InterpretedLaw, LoggedLoop, LoopTrace,
    Motion, Push, RawLoop, RawSensors, Scenario, Sensors, SimulateError, Transient,
    effects_on_transient, largest_recoverable_angle, overlay, region_of_attraction,
};

use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::measured_linearity::{MeasuredSwings, PERIODS, SpinUpLinearity, SwingLinearity};
use crate::named;
use crate::session::with_changes;
use crate::simulated_sensors::sensors_of;

/// Number of starts on each boundary in the search for the region of attraction.
const STARTS: usize = 600;
/// Resolution of the size of that region; the certificate's ellipsoid has size 1.
const SIZE_RESOLUTION: f64 = 0.02;
/// Resolution of the bisection for the largest recoverable angle, rad: a hundredth of a degree.
const ANGLE_RESOLUTION_RAD: f64 = 1.745e-4;
/// Angle that counts as a swing, as a share of the largest angle that the current allows.
const SWING_SHARE: f64 = 0.02;
/// Start of the swing on which the attitude filters are compared, rad from hanging: 60°.
const SWING_START_RAD: f64 = std::f64::consts::FRAC_PI_3;
/// Distance of the sensor from the pivot in that swing, m.
const SENSOR_FROM_PIVOT_M: f64 = 0.05;
/// Length of the swing, s.
const SWING_S: f64 = 20.0;
/// Largest relative error with which the linear model counts as valid.
const LINEAR_SHARE: f64 = 0.05;

/// The emitted law, executed from its source, on the nonlinear bench with all effects of
/// its model: the result of [`ControlDesign::simulate`](crate::ControlDesign::simulate).
///
/// The JSON does not contain the curves; [`SimulationReport::files`] returns them as figures and tables.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SimulationReport {
    /// The model.
    pub model: String,
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Largest current in either direction.
    pub current_limit_a: f64,
    /// Properties of sensors and drive that the model does not state, and that the simulation takes from the
    /// bench of the thesis; sentences.
    pub assumed: Vec<String>,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Transient, disturbance, half a minute with pushes.
    pub runs: Vec<LoopRun>,
    /// The half minute, simulated from raw counts to duty.
    pub raw_counts: RawCountsRun,
    /// The largest angle from which the loop recovers.
    pub recovery: RecoveryAngles,
    /// The region of attraction, if the certificate states an ellipsoid to enlarge.
    pub attraction: Option<AttractionRegion>,
    /// The methods for the angle, on one free swing.
    pub attitude_filters: Vec<FilterError>,
    /// The transient with each effect of the model.
    pub effects: Vec<EffectOnTransient>,
    /// Where the linear model is valid.
    pub linear_model: LinearRangeReport,
    /// Both models compared with the measured free swings, if a bench was given and has any.
    pub measured_swings: Option<MeasuredSwings>,
    /// Both models compared with the measured spin-ups of the bench.
    pub measured_spin_ups: Vec<SpinUpLinearity>,
    /// The simulated loop compared with the balance logs of the bench.
    pub overlays: Vec<LoopOverlay>,
    /// The attitude filters on the swing.
    #[serde(skip)]
    pub filters: Option<FilterRun>,
}

/// One run of the emitted law, compared with the exact one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopRun {
    /// Its name.
    pub scenario: String,
    /// What happens in it, in one sentence.
    pub about: String,
    /// Whether the body fell.
    pub fell: bool,
    /// Largest angle from upright.
    pub largest_angle_rad: f64,
    /// Largest speed of the wheel.
    pub largest_wheel_speed_rad_s: f64,
    /// Largest current.
    pub largest_current_a: f64,
    /// Time at which the body was last beyond 2 % of the largest angle.
    pub settling_s: f64,
    /// Largest difference of the angle between the emitted and the exact law.
    pub difference_angle_rad: f64,
    /// The same of the current.
    pub difference_current_a: f64,
    /// The pushes on the body: time (s) and impulse (N m s).
    #[serde(skip)]
    pub pushes: Vec<(f64, f64)>,
    /// The run under the exact law in floating point.
    #[serde(skip)]
    pub exact: LoopTrace,
    /// The run under the emitted law.
    #[serde(skip)]
    pub emitted: LoopTrace,
}

/// The half minute from raw counts to duty, with the emitted attitude filter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RawCountsRun {
    /// Whether the body fell.
    pub fell: bool,
    /// Largest angle from upright.
    pub largest_angle_rad: f64,
    /// Largest speed of the wheel.
    pub largest_wheel_speed_rad_s: f64,
    /// Largest current.
    pub largest_current_a: f64,
    /// Root mean square error of the filter's angle.
    pub angle_error_rad: f64,
    /// The run.
    #[serde(skip)]
    pub trace: LoopTrace,
}

/// Largest angles from rest, without sensor noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecoveryAngles {
    /// Under the emitted law.
    pub emitted_law_rad: f64,
    /// Under the exact law.
    pub exact_law_rad: f64,
    /// asin(τ u_max/G).
    pub limit_rad: f64,
    /// Resolution of these angles.
    pub resolution_rad: f64,
}

/// The largest ellipsoid of starts from which the emitted law returns, with sensor noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttractionRegion {
    /// Largest size, relative to the certificate's ellipsoid, with return from every start.
    pub size: f64,
    /// Smallest size with a start without return.
    pub lost_size: f64,
    /// That start: rad, rad/s, rad/s.
    pub lost: [f64; 3],
    /// Largest angle, rate and wheel speed of the set: rad, rad/s, rad/s.
    pub extents: [f64; 3],
    /// Starts on each boundary.
    pub starts: usize,
}

/// The error of an attitude filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilterError {
    /// The filter.
    pub filter: String,
    /// Root mean square error of its angle over the swing.
    pub error_rad: f64,
}

/// The attitude filters on one swing.
#[derive(Clone, Debug)]
pub struct FilterRun {
    /// Position of the sensor, along body x and y.
    pub lever_arm_m: [f64; 2],
    /// Truth and estimates.
    pub found: FilterComparison,
}

/// The influence of effects beyond viscous friction on the transient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectOnTransient {
    /// The effects; none for the base model.
    pub effects: Vec<String>,
    /// Number of swings to the other side.
    pub swings: usize,
    /// Largest angle on the side opposite to the start.
    pub overshoot_rad: f64,
    /// Time at which the body was last beyond the threshold.
    pub settling_s: f64,
    /// Root mean square of the angle over the last quarter.
    pub residual_rad: f64,
    /// Whether the body fell.
    pub fell: bool,
}

/// Where the linear model is valid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LinearRangeReport {
    /// Largest relative error with which it counts as valid.
    pub share: f64,
    /// Amplitude up to which ten periods of the linear free swing follow the nonlinear one.
    pub good_up_to_amplitude_rad: f64,
    /// Amplitude in rad and error over the first period, of two swings.
    pub free_swing_error: Vec<[f64; 2]>,
    /// Current of the spin-up.
    pub spin_up_current_a: f64,
    /// Speed up to which the linear spin-up follows; `None` if it follows during the whole run.
    pub spin_up_good_up_to_rad_s: Option<f64>,
    /// The two swings.
    #[serde(skip)]
    pub swings: Vec<SwingComparison>,
    /// The spin-up.
    #[serde(skip)]
    pub spin_up: Option<SpinUpComparison>,
}

/// The simulated loop compared with a measured balance log, with the pushes that were found in the log.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopOverlay {
    /// The experiment.
    pub experiment: String,
    /// Number of pushes.
    pub pushes: usize,
    /// Its channels.
    pub channels: Vec<OverlayStatistics>,
    /// The curves.
    #[serde(skip)]
    pub found: Option<LoggedLoop>,
}

/// A channel of an overlay in numbers; SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverlayStatistics {
    /// angle, rate, wheel_speed or current.
    pub channel: String,
    /// Root mean square of the difference.
    #[serde(with = "named::gap")]
    pub rms_difference: f64,
    /// Standard deviation of the measurement.
    #[serde(with = "named::gap")]
    pub measured_std: f64,
    /// Standard deviation of the simulation.
    #[serde(with = "named::gap")]
    pub simulated_std: f64,
}

/// The settings of a simulation.
#[derive(Clone, Copy, Debug)]
pub struct SimulationSettings<'a> {
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// A bench whose free swings, spin-ups and balance logs are compared with the simulations.
    pub bench: Option<&'a Bench>,
    /// Parameters of the simulated bench that differ from those of the model, by name, in the units of
    /// the model. The controller is still the one designed for the model.
    pub parameters: &'a [(&'a str, f64)],
}

impl Default for SimulationSettings<'_> {
    fn default() -> Self {
        SimulationSettings {
            seed: 1,
            bench: None,
            parameters: &[],
        }
    }
}

impl ControlDesign {
    /// Executes the emitted law from its source on the nonlinear bench. Takes about a second.
    ///
    /// # Errors
    /// [`Error::Simulate`]; [`Error::UnknownParameter`]; those of [`ControlDesign::generate`];
    /// [`Error::Cancelled`].
    pub fn simulate(
        &self,
        settings: &SimulationSettings,
        progress: &Progress,
    ) -> Result<SimulationReport, Error> {
        progress.check()?;
        (progress.say)("simulating");
        let values = with_changes(self.model(), self.values(), settings.parameters)?;
        let plant = Plant::new(self.model(), &values, Kind::Balance);
        let mut laws = Laws::new(self, &plant, &values, settings.seed)?;
        let assumed = laws.spec.assumed.clone();
        let runs = laws.scenarios()?;
        progress.check()?;
        let raw_counts = laws.raw_counts()?;
        let recovery = laws.recovery()?;
        progress.check()?;
        let attraction = laws.attraction()?;
        progress.check()?;
        let filters = laws.attitude_filters()?;
        let effects = laws.effects()?;
        let linear_model = laws.linear_model()?;
        progress.check()?;
        let (measured_swings, measured_spin_ups, overlays) = match settings.bench {
            Some(bench) => (
                SwingLinearity::of_bench(bench, self)?,
                SpinUpLinearity::of_bench(bench, self)?,
                laws.overlays(bench)?,
            ),
            None => (None, Vec::new(), Vec::new()),
        };
        progress.check()?;
        Ok(SimulationReport {
            model: self.name().to_owned(),
            gains: self.gains(),
            current_limit_a: self.wishes().current_limit_a,
            assumed,
            seed: settings.seed,
            runs,
            raw_counts,
            recovery,
            attraction,
            attitude_filters: filters
                .found
                .estimates()
                .into_iter()
                .map(|(filter, angle)| FilterError {
                    filter: filter.to_owned(),
                    error_rad: filters.found.rms_error_rad(angle),
                })
                .collect(),
            effects,
            linear_model,
            measured_swings,
            measured_spin_ups,
            overlays,
            filters: Some(filters),
        })
    }

    pub(crate) fn simulate_error(&self, source: SimulateError) -> Error {
        Error::Simulate {
            model: self.path(),
            source,
        }
    }
}

/// A model with its laws and its plant.
struct Laws<'a> {
    designed: &'a ControlDesign,
    plant: &'a Plant<f64>,
    /// The parameters of the plant.
    values: &'a [f64],
    scale: Scale,
    seed: u64,
    exact: ExactLaw,
    emitted: InterpretedLaw,
    controller: InterpretedController,
    /// The sensors that the module's constants describe, with the bias that remains after a calibration.
    sensors: RawSensors,
    spec: ModuleSpec,
    /// P of the set in which no command saturates, if the certificate states one.
    ellipsoid: Option<Matrix3<f64>>,
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, v| most.max(v.abs()))
}

impl<'a> Laws<'a> {
    fn new(
        designed: &'a ControlDesign,
        plant: &'a Plant<f64>,
        values: &'a [f64],
        seed: u64,
    ) -> Result<Laws<'a>, Error> {
        let failed = |source| designed.simulate_error(source);
        let unreadable = |error: &dyn std::fmt::Display| Error::Emitted {
            model: designed.path(),
            reason: format!("source: {error}"),
        };
        let limit_a = designed.wishes().current_limit_a;
        // The simulation always needs sensors and uses a preset for them; a controller for a real motor must not.
        let hardware = designed.hardware_for_simulation()?;
        let spec = designed.module_spec_with(hardware.clone())?;
        let generated = designed.generate_with(hardware)?;
        let module = generated.module(&designed.path())?;
        Ok(Laws {
            plant,
            values,
            scale: Scale::new(designed.values(), limit_a).map_err(failed)?,
            seed,
            exact: ExactLaw {
                gains: designed.design().gains,
                limit_a,
            },
            emitted: InterpretedLaw::new(&module).map_err(|error| unreadable(&error))?,
            controller: InterpretedController::new(&module).map_err(|error| unreadable(&error))?,
            sensors: sensors_of(&spec).map_err(failed)?,
            spec,
            ellipsoid: generated.ellipsoid(&designed.path())?,
            designed,
        })
    }

    fn bench(&self) -> ClosedLoop<'a> {
        ClosedLoop {
            motion: Motion::Nonlinear(self.plant),
            sensors: Sensors::of_the_thesis(),
            actuator: Actuator::OF_THE_THESIS,
            sample_time_s: self.designed.wishes().sample_time_s,
            computation_s: 0.0,
            pushes: Vec::new(),
            seed: self.seed,
        }
    }

    fn failure(&self) -> impl Fn(SimulateError) -> Error + use<'a> {
        let designed = self.designed;
        move |source| designed.simulate_error(source)
    }

    /// The angle that counts as a swing.
    fn threshold_rad(&self) -> f64 {
        SWING_SHARE * self.scale.holding_angle_rad()
    }

    /// Transient, disturbance and half a minute: the emitted law compared with the exact one.
    fn scenarios(&self) -> Result<Vec<LoopRun>, Error> {
        let mut runs = Vec::new();
        for scenario in Scenario::all(&self.scale) {
            let (mut exact, mut emitted) = (self.exact.clone(), self.emitted.clone());
            let traces = scenario
                .run(&self.bench(), &mut [&mut exact, &mut emitted])
                .map_err(self.failure())?;
            // One trace per law, in the order of the laws.
            let mut traces = traces.into_iter();
            let (exact, emitted) = (
                traces.next().unwrap_or_default(),
                traces.next().unwrap_or_default(),
            );
            let transient = Transient::of(&emitted, self.threshold_rad());
            let difference = emitted.deviation(&exact);
            let pushes = scenario.pushes.iter();
            runs.push(LoopRun {
                scenario: scenario.name.to_owned(),
                about: scenario.about.to_owned(),
                fell: transient.fell,
                largest_angle_rad: largest(&emitted.angle_rad),
                largest_wheel_speed_rad_s: transient.wheel_speed_rad_s,
                largest_current_a: transient.current_a,
                settling_s: transient.settling_s,
                difference_angle_rad: difference.angle_rad,
                difference_current_a: difference.current_a,
                pushes: pushes.map(|push| (push.time_s, push.impulse())).collect(),
                exact,
                emitted,
            });
        }
        Ok(runs)
    }

    /// The half minute with pushes, from raw counts to duty: the sensors' noise, bias and quantisation, the emitted
    /// attitude filter and law.
    fn raw_counts(&mut self) -> Result<RawCountsRun, Error> {
        let failure = self.failure();
        let scenario = Scenario::half_minute(&self.scale);
        let on = RawLoop {
            drive_limit_a: self.spec.drive.current_range_a(),
            sample_time_s: self.spec.sample_time_s,
            pushes: scenario.pushes,
            ..RawLoop::new(self.plant, self.sensors, self.seed)
        };
        let start_rad = simulate::sensors::from_upright_rad(scenario.start.angle_rad);
        let trace = on
            .run(start_rad, scenario.duration_s, &mut self.controller, false)
            .map_err(failure)?;
        let errors = trace.angle_rad.iter().zip(&trace.measured_angle_rad);
        let squares: f64 = errors.map(|(truth, told)| (truth - told).powi(2)).sum();
        Ok(RawCountsRun {
            fell: trace.fell_at_s.is_some(),
            largest_angle_rad: largest(&trace.angle_rad),
            largest_wheel_speed_rad_s: largest(&trace.wheel_speed_rad_s),
            largest_current_a: largest(&trace.current_a),
            angle_error_rad: (squares / trace.len() as f64).sqrt(),
            trace,
        })
    }

    /// The methods for the angle on one free swing (thesis figure 3.3).
    fn attitude_filters(&self) -> Result<FilterRun, Error> {
        // On the pivot, an accelerometer alone would be enough; away from it, it measures the swing's acceleration. If the
        // model does not state the sensor's position, one away from the pivot is used.
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
            self.designed.model(),
            self.values,
            &sensors,
            &attitude,
            SWING_START_RAD,
            SWING_S,
            self.seed,
        )
        .map_err(self.failure())?;
        Ok(FilterRun { lever_arm_m, found })
    }

    /// The largest angles from which the two laws recover, by bisection.
    fn recovery(&mut self) -> Result<RecoveryAngles, Error> {
        let failure = self.failure();
        let bench = ClosedLoop {
            sensors: Sensors::PERFECT,
            ..self.bench()
        };
        let scale = self.scale;
        let emitted =
            largest_recoverable_angle(&bench, &scale, &mut self.emitted, ANGLE_RESOLUTION_RAD)
                .map_err(&failure)?;
        let exact =
            largest_recoverable_angle(&bench, &scale, &mut self.exact, ANGLE_RESOLUTION_RAD)
                .map_err(&failure)?;
        Ok(RecoveryAngles {
            emitted_law_rad: emitted.recovered_rad,
            exact_law_rad: exact.recovered_rad,
            limit_rad: emitted.limit_rad,
            resolution_rad: ANGLE_RESOLUTION_RAD,
        })
    }

    fn attraction(&mut self) -> Result<Option<AttractionRegion>, Error> {
        let Some(shape) = self.ellipsoid else {
            return Ok(None);
        };
        let failure = self.failure();
        let bench = self.bench();
        let found = region_of_attraction(
            &bench,
            &self.scale,
            &mut self.emitted,
            &shape,
            STARTS,
            SIZE_RESOLUTION,
        )
        .map_err(failure)?;
        Ok(Some(AttractionRegion {
            size: found.size,
            lost_size: found.lost_size,
            lost: found.lost,
            extents: found.extents,
            starts: found.starts,
        }))
    }

    /// The influence of each effect of the model on the transient.
    fn effects(&self) -> Result<Vec<EffectOnTransient>, Error> {
        let found = effects_on_transient(
            self.designed.model(),
            self.values,
            &self.bench(),
            &Scenario::transient(&self.scale),
            &mut self.emitted.clone(),
            self.threshold_rad(),
        )
        .map_err(self.failure())?;
        Ok(found
            .iter()
            .map(|part| EffectOnTransient {
                effects: part
                    .effects
                    .iter()
                    .map(|effect| effect.name().to_owned())
                    .collect(),
                swings: part.transient.swings,
                overshoot_rad: part.transient.overshoot_rad,
                settling_s: part.transient.settling_s,
                residual_rad: part.transient.residual_rad,
                fell: part.transient.fell,
            })
            .collect())
    }

    /// Where the linear model is valid.
    fn linear_model(&self) -> Result<LinearRangeReport, Error> {
        let (model, values) = (self.designed.model(), self.designed.values());
        let failure = self.failure();
        let good_up_to_amplitude_rad =
            largest_linear_amplitude(model, values, PERIODS, LINEAR_SHARE).map_err(&failure)?;
        let swings = [20.0_f64, 60.0]
            .map(|degrees| compare_free_swing(model, values, degrees.to_radians(), 6.0))
            .into_iter()
            .collect::<Result<Vec<SwingComparison>, SimulateError>>()
            .map_err(&failure)?;
        let current_a = 0.5 * self.designed.wishes().current_limit_a;
        let spin_up =
            compare_spin_up(model, values, current_a, 5.0, LINEAR_SHARE).map_err(&failure)?;
        Ok(LinearRangeReport {
            share: LINEAR_SHARE,
            good_up_to_amplitude_rad,
            free_swing_error: swings
                .iter()
                .map(|swing| [swing.amplitude_rad, swing.error_over_first_period])
                .collect(),
            spin_up_current_a: current_a,
            spin_up_good_up_to_rad_s: spin_up.good_up_to_rad_s,
            swings,
            spin_up: Some(spin_up),
        })
    }

    /// The simulated loop compared with each balance log of a bench, with the pushes found in it.
    fn overlays(&self, bench: &Bench) -> Result<Vec<LoopOverlay>, Error> {
        let push_model = PushModel::of(self.designed.model(), self.designed.values());
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
            let count = pushes.len();
            let loop_with_pushes = ClosedLoop {
                pushes,
                ..self.bench()
            };
            let measured = MeasuredLog {
                time_s: &log.time_s,
                angle_rad,
                rate_rad_s: log.rate_rad_s.as_deref(),
                wheel_speed_rad_s: log.wheel_speed_rad_s.as_deref(),
                current_a: log.current_a.as_deref(),
            };
            // The bench's own controller recorded the log, so it is used here.
            let mut own = match bench.controller {
                Some(own) => ExactLaw {
                    gains: own.gains.into(),
                    limit_a: own.current_limit_a,
                },
                None => self.exact.clone(),
            };
            let found = overlay(&measured, &loop_with_pushes, &mut own).map_err(self.failure())?;
            overlays.push(LoopOverlay {
                experiment: experiment.name.clone(),
                pushes: count,
                channels: found
                    .channels
                    .iter()
                    .map(|channel| OverlayStatistics {
                        channel: channel.name.to_owned(),
                        rms_difference: channel.rms_difference,
                        measured_std: channel.measured_std,
                        simulated_std: channel.simulated_std,
                    })
                    .collect(),
                found: Some(found),
            });
        }
        Ok(overlays)
    }
}

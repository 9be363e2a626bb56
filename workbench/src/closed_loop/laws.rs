//! The runs of a designed controller on the nonlinear bench.

use attitude::AttitudeSpec;
use bench_files::Bench;
use codegen::ModuleSpec;
use identify::{Progress, PushModel, Record};
use nalgebra::Matrix3;
use plant::{Kind, Plant};
use simulate::attitude_filters::compare_filters;
use simulate::linear_validity::{
    SwingComparison, compare_free_swing, compare_spin_up, largest_linear_amplitude,
};
use simulate::overlay::MeasuredLog;
use simulate::scenario::Scale;
use simulate::{
    ClosedLoop, ExactLaw, InterpretedController, InterpretedLaw, Motion, Paced, Push, RawLoop,
    RawSensors, Scenario, SensorPace, Sensors, SimulateError, Transient, effects_on_transient,
    largest_recoverable_angle, overlay, region_of_attraction,
};

use super::report::{
    AttractionRegion, EffectOnTransient, FilterError, FilterRun, LinearRangeReport, LoopOverlay,
    LoopRun, OverlayStatistics, RawCountsRun, RecoveryAngles, SimulationReport,
};
use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::measured_linearity::{PERIODS, SpinUpLinearity, SwingLinearity};
use crate::predictor::with_changes;
use crate::simulated_drive::{actuator_of, supplied};
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
        let drive = self.drive_for_simulation();
        let (model, supplied) = supplied(self.model(), &values, &drive);
        let plant = Plant::new(&model, &supplied, Kind::Balance);
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
    /// The matrix P of the certificate's ellipsoid xᵀ P x ≤ 1, in which no command saturates, if it has one.
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
        let generated = designed.generate_for(hardware)?;
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
            actuator: actuator_of(&self.spec.drive),
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

    /// Rates and filters of the inertial sensors: rates by [hardware], filters by the model's effects.
    fn sensor_pace(&self) -> SensorPace {
        let hardware = self.designed.file().hardware.as_ref();
        let accelerometer = hardware.and_then(|hardware| hardware.accelerometer.as_ref());
        let or_every = |rate_hz: Option<f64>| rate_hz.unwrap_or(f64::INFINITY);
        SensorPace {
            gyro_rate_hz: or_every(self.spec.hardware.gyro_rate_hz),
            accel_rate_hz: or_every(accelerometer.and_then(|sensor| sensor.rate_hz)),
            gyro_lag_s: self.plant.sensor_times_s(plant::Output::Rate).0,
            ..SensorPace::EVERY_SAMPLE
        }
    }

    /// The half minute with pushes, from raw counts to duty: the sensors' noise, bias, quantisation and pace, the
    /// emitted attitude filter and law.
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
        let mut controller = Paced::new(
            self.controller.clone(),
            self.sensor_pace(),
            self.spec.sample_time_s,
            self.seed,
        );
        let trace = on
            .run(start_rad, scenario.duration_s, &mut controller, false)
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
        // On the pivot, an accelerometer alone would be enough; away from it, it measures the swing's acceleration. If
        // the model does not state the sensor's position, one away from the pivot is used.
        let thesis = AttitudeSpec::thesis();
        let own = self.spec.hardware.attitude().unwrap_or(&thesis);
        let stated = own.lever_arm_m;
        let lever_arm_m = if stated == [0.0; 2] {
            [SENSOR_FROM_PIVOT_M, 0.0]
        } else {
            stated
        };
        let attitude = AttitudeSpec {
            sample_time_s: self.spec.sample_time_s,
            lever_arm_m,
            ..*own
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

//! What the generator is told about a model: the one place where model.toml becomes a
//! [`ModuleSpec`].

use attitude::SensorLine;
use bench_files::Calibration;
use calibrate::{Calibrated, Mounting, SensorCalibration};
use codegen::hardware::{BiasObserverSpec, HardwareSpec};
use codegen::spec::{ModelParameter, ModuleSpec, PhysicalRanges, PwmDrive};
use design::BiasObserver;
use nalgebra::{Matrix3, Vector3};
use simulate::Sensors;

use crate::control_design::ControlDesign;
use crate::error::Error;

/// The estimate of the angle's bias stays within ± this, rad: 5.7°. More is no bias that a sensor
/// has after calibration, and at it the loop still has nearly two thirds of its current limit's angle.
const BIAS_LIMIT_RAD: f64 = 0.1;

impl ControlDesign {
    /// What the generator is told. Ranges are those of the thesis bench, and so are sensors and drive
    /// where they are not calibrated.
    ///
    /// # Errors
    /// [`Error::Design`]: an observer of the angle's bias that the model cannot carry.
    pub fn module_spec(&self) -> Result<ModuleSpec, Error> {
        let design = self.design();
        let wishes = self.wishes();
        let calibration = &self.file().calibration.unwrap_or_default();
        let rows = |value: &dyn Fn(usize, usize) -> f64| {
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| value(row, column)))
        };
        let hardware = HardwareSpec {
            bias_observer: bias_observer(self)?,
            ..hardware(calibration)
        };
        Ok(ModuleSpec {
            model_name: self.name().to_owned(),
            gains: [0, 1, 2].map(|index| design.gains[index]),
            current_limit_a: wishes.current_limit_a,
            sample_time_s: wishes.sample_time_s,
            ranges: PhysicalRanges::THESIS_BENCH,
            drive: drive(calibration),
            hardware,
            parameters: self
                .file()
                .parameters
                .iter()
                .map(|parameter| ModelParameter {
                    name: parameter.name.clone(),
                    value: parameter.value,
                    std: parameter.std,
                    unit: parameter.unit.clone(),
                })
                .collect(),
            state_weights: wishes.state_weights,
            current_weight: wishes.current_weight,
            a: rows(&|row, column| design.model.state[(row, column)]),
            b: [0, 1, 2].map(|row| design.model.input[row]),
            ad: rows(&|row, column| design.discrete.state[(row, column)]),
            bd: [0, 1, 2].map(|row| design.discrete.input[row]),
            closed_loop: None,
        })
    }
}

/// The observer that `bias_time_constant` asks for. Of the sensors' noise only the ratios count;
/// they are those of the simulated sensors.
fn bias_observer(designed: &ControlDesign) -> Result<Option<BiasObserverSpec>, Error> {
    let wishes = designed.wishes();
    let Some(time_constant_s) = wishes.bias_time_constant_s else {
        return Ok(None);
    };
    let sensors = Sensors::of_the_thesis();
    let noise = Vector3::new(
        sensors.angle.noise_std,
        sensors.rate.noise_std,
        sensors.wheel_speed.noise_std,
    );
    let observer = BiasObserver::new(
        &designed.design().model,
        wishes.sample_time_s,
        time_constant_s,
        &noise,
    )
    .map_err(|source| designed.design_error(source))?;
    Ok(Some(BiasObserverSpec {
        decay: observer.decay,
        direct: observer.direct.into(),
        from_states: observer.from_measurement.into(),
        from_current: observer.from_current,
        limit_rad: BIAS_LIMIT_RAD,
    }))
}

/// The sensors of the thesis bench, with the calibrated ones in their places.
fn hardware(calibration: &Calibration) -> HardwareSpec {
    let thesis = HardwareSpec::thesis_bench();
    let accelerometer = calibration.accelerometer.as_ref().map(sensor);
    let gyroscope = calibration.gyroscope.as_ref().map(sensor);
    let magnetometer = calibration.magnetometer.as_ref().map(sensor);
    let mounting = calibration.mounting.map(|mounting| Mounting {
        axis: mounting.axis.into(),
        axis_std_rad: mounting.axis_std_rad,
        alignment: calibrate::alignment(&mounting.axis.into()),
        angle_rad: mounting.angle_rad,
        angle_std_rad: mounting.angle_std_rad,
    });
    let attitude = calibrate::attitude_spec(
        &thesis.attitude,
        &Calibrated {
            accelerometer: accelerometer.as_ref(),
            gyroscope: gyroscope.as_ref(),
            magnetometer: magnetometer.as_ref(),
            mounting: mounting.as_ref(),
            lever_arm_m: calibration.lever_arm.map(|arm| arm.position_m),
            beta_rad_s: calibration.beta_rad_s,
        },
    );
    let wheel_speed = calibration.wheel_speed;
    HardwareSpec {
        attitude,
        wheel_speed_per_count: wheel_speed.map_or(thesis.wheel_speed_per_count, |line| line.slope),
        wheel_speed_at_zero: wheel_speed.map_or(thesis.wheel_speed_at_zero, |line| line.offset),
        ..thesis
    }
}

/// A sensor as `calibrate` has it.
fn sensor(found: &bench_files::StoredSensorCalibration) -> SensorCalibration {
    SensorCalibration {
        line: SensorLine {
            bias_counts: found.bias_counts.into(),
            matrix: Matrix3::from_fn(|row, column| found.matrix[row][column]),
        },
        bias_std: found.bias_std.into(),
        matrix_std: Matrix3::from_fn(|row, column| found.matrix_std[row][column]),
    }
}

/// The drive of the thesis bench, its line as calibrated: the largest duty stays, and the current
/// that it stands for follows.
fn drive(calibration: &Calibration) -> PwmDrive {
    let thesis = PwmDrive::THESIS_BENCH;
    let Some(line) = calibration.duty else {
        return thesis;
    };
    let duty_zero = line.offset.round().clamp(0.0, f64::from(thesis.duty_max)) as u16;
    PwmDrive {
        current_range_a: f64::from(thesis.duty_max - duty_zero) / line.slope,
        duty_zero,
        ..thesis
    }
}

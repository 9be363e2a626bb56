//! The sensors and the drive of the simulation, made from the constants of an emitted module.

use attitude::AttitudeSpec;
use codegen::ModuleSpec;
use codegen::hardware::WheelSensor;
use simulate::{EncoderOutput, RawSensors, SimulateError, VoltageOutput, WheelOutput};

/// Sensors and drive that the module's constants describe correctly, except for the bias that remains after a
/// calibration.
pub(crate) fn sensors_of(spec: &ModuleSpec) -> Result<RawSensors, SimulateError> {
    let hardware = &spec.hardware;
    // With an encoder on the pivot, no inertial sensor is read.
    let thesis = AttitudeSpec::thesis();
    let attitude = hardware.attitude().unwrap_or(&thesis);
    let body = hardware.body_encoder().map(|body| EncoderOutput {
        counts_per_turn: body.encoder.counts_per_turn,
        bits: body.encoder.bits,
        zero_count: f64::from(body.zero),
    });
    Ok(RawSensors {
        body,
        wheel: match &hardware.wheel {
            WheelSensor::Converter => WheelOutput::Converter(4095),
            WheelSensor::Driver => WheelOutput::Driver,
            WheelSensor::Encoder(encoder) => WheelOutput::Encoder(EncoderOutput {
                counts_per_turn: encoder.counts_per_turn,
                bits: encoder.bits,
                zero_count: 0.0,
            }),
        },
        wheel_speed_per_count: hardware.wheel_speed_per_count,
        wheel_speed_at_zero: hardware.wheel_speed_at_zero,
        duty_zero: spec.drive.duty_zero,
        current_per_count_a: spec.drive.amperes_per_count,
        voltage: spec.drive.voltage.map(|drive| VoltageOutput {
            volts_per_count: drive.volts_per_count,
            winding_ohm: drive.winding_ohm,
            back_emf_v_s: drive.back_emf_v_s,
        }),
        ..RawSensors::calibrated_by(attitude)?
    })
}

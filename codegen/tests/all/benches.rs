//! The bench of the thesis with other sensors of the wheel's speed and another drive.

use codegen::hardware::{EncoderSpec, WheelSensor};
use codegen::spec::{ModuleSpec, PhysicalRanges, VoltageDrive};

use crate::thesis;

/// A driver's word in tenths of a revolution a minute, to 735 rad/s.
pub fn with_driver() -> ModuleSpec {
    let mut spec = thesis::spec();
    let hardware = &mut spec.hardware;
    hardware.wheel = WheelSensor::Driver;
    (hardware.wheel_speed_per_count, hardware.wheel_speed_at_zero) = (0.1047198, 0.0);
    (hardware.wheel_low, hardware.wheel_high) = (-7018, 7018);
    spec.ranges = PhysicalRanges::of(&spec.hardware);
    spec
}

/// An encoder with 4096 counts a turn on the wheel; its turn over this many steps is the speed.
pub fn with_wheel_encoder(window: u32) -> ModuleSpec {
    let mut spec = thesis::spec();
    let encoder = EncoderSpec {
        counts_per_turn: 4096.0,
        bits: 12,
        window,
    };
    let hardware = &mut spec.hardware;
    hardware.wheel = WheelSensor::Encoder(encoder);
    hardware.wheel_speed_per_count = encoder.rad_s_per_count(spec.sample_time_s);
    hardware.wheel_speed_at_zero = 0.0;
    hardware.wheel_high = (735.0 / hardware.wheel_speed_per_count) as i32;
    hardware.wheel_low = -hardware.wheel_high;
    spec.ranges = PhysicalRanges::of(&spec.hardware);
    spec
}

/// The same with a voltage drive of 24 V at a winding of 2.3 Ohm.
pub fn with_voltage(mut spec: ModuleSpec) -> ModuleSpec {
    let drive = VoltageDrive {
        volts_per_count: 24.0 / 32_767.0,
        supply_v: 24.0,
        winding_ohm: 2.3,
        back_emf_v_s: 0.0335,
    };
    spec.drive.voltage = Some(drive);
    spec.drive.amperes_per_count = drive.volts_per_count / drive.winding_ohm;
    (spec.drive.duty_low, spec.drive.duty_high) = (1, 65_535);
    spec
}

/// Each of them, and all together.
pub fn all() -> [ModuleSpec; 5] {
    [
        thesis::spec(),
        with_driver(),
        with_wheel_encoder(8),
        with_voltage(thesis::spec()),
        with_voltage(with_wheel_encoder(16)),
    ]
}

//! The bench of the thesis with other sensors of the wheel's speed and another drive.

use codegen::hardware::{BodyEncoder, BodySensor, EncoderSpec, WheelSensor};
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

/// An encoder with 4096 counts a turn on the pivot in place of gyroscope and accelerometer: it counts backwards, 773 with
/// the body upright.
pub fn with_body_encoder(mut spec: ModuleSpec) -> ModuleSpec {
    let encoder = EncoderSpec {
        counts_per_turn: -4096.0,
        bits: 12,
        window: 14,
    };
    let hardware = &mut spec.hardware;
    hardware.body = BodySensor::Encoder(BodyEncoder {
        encoder,
        zero: 773,
        largest_rate_rad_s: 34.906_585,
    });
    (hardware.gyro_rate_hz, hardware.accelerometer_m_s2_per_count) = (None, None);
    spec.ranges = PhysicalRanges::of(&spec.hardware);
    spec
}

/// The benches with an encoder on the pivot.
pub fn with_body_encoders() -> [ModuleSpec; 3] {
    [
        with_body_encoder(thesis::spec()),
        with_body_encoder(with_voltage(with_driver())),
        with_body_encoder(with_wheel_encoder(8)),
    ]
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

/// A crate with an encoder on the pivot has nothing of a filter, and the parts of its wheel and its drive.
#[test]
fn a_body_with_an_encoder_has_no_attitude() {
    for spec in with_body_encoders() {
        let emitted = codegen::generate(&spec).expect("an emitted crate");
        let controller = emitted.file("src/controller.rs").expect("a controller");
        assert!(controller.contains("pub body_count: u16,"));
        for text in ["gyro", "ttitude", "bias", "cfg("] {
            assert!(!controller.contains(text), "{text}");
        }
        let library = emitted.file("src/lib.rs").expect("a library");
        assert!(!library.contains("Attitude"));
        for module in ["attitude", "filter", "madgwick", "root", "bias_observer"] {
            assert!(emitted.file(&format!("src/{module}.rs")).is_none());
        }
        assert!(emitted.file("verify/src/proofs_attitude.rs").is_none());
        for file in ["Cargo.toml", "src/proofs_step.rs", "src/proofs_encoder.rs"] {
            assert!(emitted.file(&format!("verify/{file}")).is_some(), "{file}");
        }
        assert!(
            emitted
                .file("certificate.json")
                .expect("one")
                .contains("\"body_encoder\"")
        );
    }
}

/// Two texts state what the numbers of a status mean: they are the same.
#[test]
fn both_supervisors_number_the_status_alike() {
    use codegen::helpers::{body_supervisor::Status as Body, supervisor::Status};
    let own = [
        Body::NotAligned,
        Body::Ready,
        Body::Running,
        Body::TrippedAngle,
        Body::TrippedFrozen,
        Body::TrippedClipped,
        Body::TrippedWheelSpeed,
        Body::TrippedAccelerometer,
        Body::TrippedCurrent,
        Body::TrippedFault,
    ];
    let other = [
        Status::NotAligned,
        Status::Ready,
        Status::Running,
        Status::TrippedAngle,
        Status::TrippedFrozen,
        Status::TrippedClipped,
        Status::TrippedWheelSpeed,
        Status::TrippedAccelerometer,
        Status::TrippedCurrent,
        Status::TrippedFault,
    ];
    for (value, (own, other)) in own.into_iter().zip(other).enumerate() {
        assert_eq!((own as usize, other as usize), (value, value));
        assert_eq!(format!("{own:?}"), format!("{other:?}"));
    }
}

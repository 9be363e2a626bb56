//! Emitted laws run from their source: that of the thesis bench against the compiled one, and that
//! of another bench through the whole chain from parameters to closed loop.

use crate::bench::{exact_law, plain_loop};
use crate::compiled::CompiledLaw;
use checker::Module;
use codegen::ModuleSpec;
use codegen::hardware::HardwareSpec;
use codegen::spec::{PhysicalRanges, PwmDrive};
use design::{Design, Settings, Weights};
use nalgebra::Vector3;
use plant::{Kind, Model, Plant, linearise};
use proptest::prelude::*;
use simulate::scenario::Scale;
use simulate::{ExactLaw, InterpretedLaw, Law, Measured, Motion, Scenario, Sensor, Sensors};
use std::path::Path;
use std::sync::LazyLock;

/// The law of the committed crate, read once.
fn committed() -> InterpretedLaw {
    static LAW: LazyLock<InterpretedLaw> = LazyLock::new(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
        InterpretedLaw::new(&Module::read(&folder).unwrap()).unwrap()
    });
    LAW.clone()
}

proptest! {
    #[test]
    fn source_and_compiled_code_agree_to_the_bit(
        angle_rad in -4.5..4.5_f64,
        rate_rad_s in -80.0..80.0_f64,
        wheel_speed_rad_s in -1500.0..1500.0_f64,
    ) {
        let measured = Measured { angle_rad, rate_rad_s, wheel_speed_rad_s };
        let from_source = committed().command_a(&measured).unwrap();
        prop_assert_eq!(from_source, CompiledLaw.command_a(&measured).unwrap());
    }
}

#[test]
fn half_a_minute_from_source_is_half_a_minute_compiled() {
    let plant = crate::bench::bench(true);
    let scale = Scale::new(&crate::bench::BASE, 2.0).unwrap();
    let traces = Scenario::half_minute(&scale)
        .run(
            &plain_loop(Motion::Nonlinear(&plant)),
            &mut [&mut committed(), &mut CompiledLaw, &mut exact_law()],
        )
        .unwrap();
    assert_eq!(traces[0], traces[1]);
    assert_ne!(traces[0], traces[2]);
}

/// A bench twice as heavy, sampled half as often, with other weights.
#[test]
fn a_law_emitted_for_another_bench_balances_it() {
    let values = [5.1e-3, 3.0e-4, 0.41, 0.053, 4e-5, 2e-5];
    let limit_a = 2.5;
    let model = Model::base();
    let linear = linearise(&model, &values, std::f64::consts::PI, None).unwrap();
    let weights = Weights {
        state: Vector3::new(40.0, 0.3, 1e-3),
        current: 0.7,
    };
    let settings = Settings {
        sample_time_s: 2e-3,
        weights,
        current_limit_a: limit_a,
        friction_extremes: None,
    };
    let design = Design::new(&linear, &settings).unwrap();
    let row = |row: usize| [0, 1, 2].map(|column| linear.state[(row, column)]);
    let sampled_row = |row: usize| [0, 1, 2].map(|column| design.discrete.state[(row, column)]);
    let spec = ModuleSpec {
        model_name: "another bench".to_owned(),
        gains: design.gains.into(),
        current_limit_a: limit_a,
        sample_time_s: settings.sample_time_s,
        ranges: PhysicalRanges::of(&HardwareSpec::thesis_bench()),
        drive: PwmDrive {
            amperes_per_count: 3.0 / 26_214.0,
            ..PwmDrive::THESIS_BENCH
        },
        hardware: HardwareSpec::thesis_bench(),
        assumed: Vec::new(),
        parameters: vec![],
        correlation: None,
        state_weights: weights.state.into(),
        current_weight: weights.current,
        a: [row(0), row(1), row(2)],
        b: linear.input.into(),
        ad: [sampled_row(0), sampled_row(1), sampled_row(2)],
        bd: [0, 1, 2].map(|row| design.discrete.input[row]),
        closed_loop: None,
    };
    let emitted = codegen::generate(&spec).unwrap();
    let sources: Vec<(&str, &str)> = emitted.sources().collect();
    let mut from_source = InterpretedLaw::new(&Module::parse(&sources).unwrap()).unwrap();
    let mut exact = ExactLaw {
        gains: design.gains,
        limit_a,
    };

    let plant = Plant::new(&model, &values, Kind::Balance);
    let mut on = plain_loop(Motion::Nonlinear(&plant));
    on.sample_time_s = settings.sample_time_s;
    on.actuator.limit_a = 3.0;
    let scale = Scale::new(&values, limit_a).unwrap();
    let traces = Scenario::half_minute(&scale)
        .run(&on, &mut [&mut from_source, &mut exact])
        .unwrap();
    assert_eq!(traces[0].fell_at_s, None);
    // The allowed deviation is a hundredth of the sensors' noise on the thesis bench.
    let deviation = traces[0].deviation(&traces[1]);
    let noise = Sensors::of_the_thesis();
    let hidden = |sensor: Sensor| 0.01 * sensor.noise_std;
    assert!(deviation.angle_rad < hidden(noise.angle), "{deviation:?}");
    assert!(deviation.rate_rad_s < hidden(noise.rate), "{deviation:?}");
    assert!(
        deviation.wheel_speed_rad_s < hidden(noise.wheel_speed),
        "{deviation:?}"
    );
}

#[test]
fn a_crate_without_the_law_is_refused() {
    let other = Module::parse(&[(
        "src/lib.rs",
        "#![no_std]\n#![forbid(unsafe_code)]\npub fn other(a: i32) -> i32 { a }\n",
    )])
    .unwrap();
    let failure = InterpretedLaw::new(&other).unwrap_err();
    assert!(failure.to_string().contains("no function `control`"));
    let wrong = Module::parse(&[(
        "src/lib.rs",
        "#![no_std]\n#![forbid(unsafe_code)]\npub fn control(a: i32) -> i32 { a }\n",
    )])
    .unwrap();
    assert!(InterpretedLaw::new(&wrong).is_err());
}

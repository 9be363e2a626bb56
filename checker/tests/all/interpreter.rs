//! The interpreter against the compiled crate, bit for bit.

use std::path::Path;

use checker::{Machine, Module};
use fixed::types::I2F30;
use generated::control::{Angle, Rate, WheelSpeed, control};
use generated::filter::{START, align, headed, step_imu};
use generated::{Attitude, Controller, Current, Sample};
use proptest::prelude::*;

fn module() -> Module {
    Module::read(Path::new("../generated")).unwrap_or_else(|error| panic!("{error}"))
}

fn extremes() -> Vec<i32> {
    let mut words = vec![0, i32::MIN, i32::MIN + 1, i32::MAX, i32::MAX - 1];
    for power in [0, 1, 15, 24, 29, 30] {
        let word = 1_i32 << power;
        words.extend([word, -word, word - 1, 1 - word]);
    }
    words
}

#[test]
fn the_control_law_on_extreme_words() {
    let module = module();
    let mut machine = Machine::new(module.function("control").unwrap());
    for angle in extremes() {
        for rate in extremes() {
            for speed in extremes() {
                let command = control(
                    Angle::from_bits(angle),
                    Rate::from_bits(rate),
                    WheelSpeed::from_bits(speed),
                );
                let words = [angle, rate, speed].map(i128::from);
                assert_eq!(
                    machine.call(&words).unwrap(),
                    [i128::from(command.to_bits())]
                );
            }
        }
    }
}

/// Words of an array.
fn words<T: Copy + Into<i128>>(values: impl IntoIterator<Item = T>) -> Vec<i128> {
    values.into_iter().map(Into::into).collect()
}

/// The variants of `Status`, in the order of their values.
const STATUSES: [&str; 10] = [
    "NotAligned",
    "Ready",
    "Running",
    "TrippedAngle",
    "TrippedFrozen",
    "TrippedClipped",
    "TrippedWheelSpeed",
    "TrippedAccelerometer",
    "TrippedCurrent",
    "TrippedFault",
];

/// The words of the whole controller, from its `Debug` form: numbers, booleans and the status in
/// order.
fn state_words(value: &impl std::fmt::Debug) -> Vec<i128> {
    let text = format!("{value:?}");
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-' || c == '_'))
        .filter_map(|token| match token {
            "true" => Some(1),
            "false" => Some(0),
            other => match STATUSES.iter().position(|status| *status == other) {
                Some(value) => Some(value as i128),
                None => other.parse().ok(),
            },
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    #[test]
    fn the_control_law_on_random_words(
        words in prop::array::uniform3(any::<i32>()), shifts in prop::array::uniform3(0_u32..31),
    ) {
        thread_local! {
            static MODULE: &'static Module = Box::leak(Box::new(module()));
        }
        let module = MODULE.with(|module| *module);
        let mut machine = Machine::new(module.function("control").unwrap());
        let [a, r, w] = [0, 1, 2].map(|i| words[i] >> shifts[i]);
        let command =
            control(Angle::from_bits(a), Rate::from_bits(r), WheelSpeed::from_bits(w));
        let result = machine.call(&[a, r, w].map(i128::from)).unwrap();
        prop_assert_eq!(result, [i128::from(command.to_bits())]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Long random runs of filter and controller, each state compared word by word.
    #[test]
    fn the_controller_on_random_samples(
        samples in prop::collection::vec(
            (
                prop::array::uniform3(any::<i16>()),
                prop::array::uniform3(any::<i16>()),
                prop::option::of(prop::array::uniform3(any::<i16>())),
                any::<u16>(),
                0_u32..16,
                any::<bool>(),
            ),
            100,
        ),
    ) {
        let module = module();
        let mut step = Machine::new(module.function("Controller::step").unwrap());
        let mut controller = Controller::new();
        let mut state = Machine::new(module.function("Controller::new").unwrap())
            .call(&[])
            .unwrap()
            .to_vec();
        prop_assert_eq!(&state, &state_words(&controller));
        for (gyro, accel, mag, wheel_adc, shift, is_armed) in samples {
            // Small readings as often as large ones.
            let gyro = gyro.map(|count| count >> shift);
            let accel = accel.map(|count| count >> (shift / 3));
            let name = if is_armed { "Controller::arm" } else { "Controller::disarm" };
            if is_armed {
                controller.arm();
            } else {
                controller.disarm();
            }
            let result = Machine::new(module.function(name).unwrap()).call(&state).unwrap().to_vec();
            // `arm` also says whether it did.
            state = result[usize::from(is_armed)..].to_vec();

            let duty = controller.step(&Sample { gyro, accel, mag, wheel_adc });
            let mut arguments = state.clone();
            arguments.extend(words(gyro));
            arguments.extend(words(accel));
            arguments.push(i128::from(mag.is_some()));
            arguments.extend(words(mag.unwrap_or_default()));
            arguments.push(wheel_adc.into());
            let result = step.call(&arguments).unwrap();
            prop_assert_eq!(result[0], i128::from(duty.0));
            state = result[1..].to_vec();
            prop_assert_eq!(&state, &state_words(&controller));
        }
    }

    /// Single steps of the filter from the start: six axes, the heading and the alignment.
    #[test]
    fn single_filter_steps(
        gyro in prop::array::uniform3(any::<i16>()),
        accel in prop::array::uniform3(any::<i16>()),
        mag in prop::array::uniform3(any::<i16>()),
    ) {
        let module = module();
        let filter = module.constant("constants", "FILTER").unwrap();
        let constants = generated::constants::FILTER;
        let start = module.constant("filter", "START").unwrap();
        prop_assert_eq!(start, state_words(&START));

        let mut arguments = start.to_vec();
        arguments.extend(words(gyro));
        arguments.extend(words(accel));
        arguments.extend(filter);
        let mut machine = Machine::new(module.function("step_imu").unwrap());
        let expected = state_words(&step_imu(&START, gyro, accel, &constants));
        prop_assert_eq!(machine.call(&arguments).unwrap(), expected);

        let mut arguments = start.to_vec();
        arguments.extend(words(mag));
        arguments.extend(filter);
        let mut machine = Machine::new(module.function("headed").unwrap());
        let expected = state_words(&headed(&START, mag, &constants));
        prop_assert_eq!(machine.call(&arguments).unwrap(), expected);

        let mut arguments = start.to_vec();
        arguments.extend(words(accel));
        arguments.extend(filter);
        let mut machine = Machine::new(module.function("align").unwrap());
        let expected = state_words(&align(&START, accel, &constants));
        prop_assert_eq!(machine.call(&arguments).unwrap(), expected);
    }
}

/// Fixed-point results are their bits.
#[test]
fn the_quaternion_of_a_new_filter_is_one() {
    let module = module();
    let state = Machine::new(module.function("Attitude::new").unwrap())
        .call(&[])
        .unwrap()
        .to_vec();
    let mut machine = Machine::new(module.function("Attitude::quaternion").unwrap());
    let compiled = Attitude::new().quaternion().map(I2F30::to_bits);
    assert_eq!(machine.call(&state).unwrap(), words(compiled));
}

/// Half a minute of the loop at 1 kHz takes well under a second; no time is asserted.
#[test]
fn thirty_thousand_steps() {
    let module = module();
    let mut machine = Machine::new(module.function("control").unwrap());
    let mut word = 12_345_i32;
    for _ in 0..30_000 {
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let arguments = [
            word >> 6,
            word.rotate_left(9) >> 8,
            word.rotate_left(17) >> 4,
        ];
        let command = control(
            Angle::from_bits(arguments[0]),
            Rate::from_bits(arguments[1]),
            WheelSpeed::from_bits(arguments[2]),
        );
        let result = machine.call(&arguments.map(i128::from)).unwrap();
        assert_eq!(Current::from_bits(result[0] as i32), command);
    }
}

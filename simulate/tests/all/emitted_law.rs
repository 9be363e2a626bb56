//! Half a minute of the emitted fixed-point law beside the exact one.

use crate::bench::{BASE, bench, exact_law, gains, plain_loop};
use crate::compiled::CompiledLaw;
use design::zero_order_hold::zero_order_hold;
use nalgebra::DMatrix;
use plant::{LinearModel, Plant, linearise};
use simulate::scenario::Scale;
use simulate::{
    Actuator, ClosedLoop, Deviation, LinearMotion, LoopTrace, Motion, Scenario, Sensor, Sensors,
};

/// The documented error of the emitted law within its ranges: 5.95e-8 A from rounding gains and
/// sum, 5.98e-8 A from rounding the state.
const LAW_ERROR_A: f64 = 5.95e-8 + 5.98e-8;

fn linear_motion() -> LinearMotion {
    let (model, values) = crate::bench::model(false);
    LinearMotion {
        model: linearise(&model, &values, std::f64::consts::PI, None).unwrap(),
        per_push: 1.0 / (BASE[0] - BASE[1]),
    }
}

fn half_minute(on: &ClosedLoop<'_>) -> [LoopTrace; 2] {
    let scale = Scale::new(&BASE, 2.0).unwrap();
    Scenario::half_minute(&scale)
        .run(on, &mut [&mut exact_law(), &mut CompiledLaw])
        .unwrap()
        .try_into()
        .unwrap()
}

/// How much each state of the sampled loop can move per ampere of disturbance of the current,
/// whatever the disturbance: Σ |(Ad − Bd K)ᵏ Bd|, the norm that belongs to bounded signals.
fn largest_gain(model: &LinearModel) -> [f64; 3] {
    let a = DMatrix::from_fn(3, 3, |row, column| model.state[(row, column)]);
    let b = DMatrix::from_fn(3, 1, |row, _| model.input[row]);
    let hold = zero_order_hold(&a, &b, crate::bench::SAMPLE_TIME_S).unwrap();
    let closed = &hold.state - &hold.input * DMatrix::from_row_slice(1, 3, gains().as_slice());
    let mut response = hold.input;
    let mut sums = [0.0; 3];
    for _ in 0..20_000 {
        for (sum, response) in sums.iter_mut().zip(response.iter()) {
            *sum += response.abs();
        }
        response = &closed * response;
    }
    sums
}

fn assert_within(deviation: &Deviation, allowed: [f64; 3]) {
    let found = [
        deviation.angle_rad,
        deviation.rate_rad_s,
        deviation.wheel_speed_rad_s,
    ];
    for (found, allowed) in found.into_iter().zip(allowed) {
        assert!(found <= allowed, "{deviation:?}, allowed {allowed:e}");
    }
}

#[test]
fn on_the_linear_plant_the_difference_keeps_its_proved_bound() {
    let motion = linear_motion();
    let [exact, emitted] = half_minute(&plain_loop(Motion::Linear(&motion)));
    // Below the limit, so that the loop is linear and the bound holds.
    assert!(exact.current_a.iter().all(|current| current.abs() < 1.99));
    let deviation = exact.deviation(&emitted);
    let allowed = largest_gain(&motion.model).map(|gain| gain * LAW_ERROR_A);
    assert_within(&deviation, allowed);
    // A deviation of zero would mean that the same law was run twice.
    assert!(deviation.current_a > 1e-9);
}

#[test]
fn with_steps_in_sensors_and_drive_a_flipped_count_is_all_that_differs() {
    let motion = linear_motion();
    let mut on = plain_loop(Motion::Linear(&motion));
    on.sensors = Sensors::of_the_thesis();
    on.actuator = Actuator::OF_THE_THESIS;
    let [exact, emitted] = half_minute(&on);
    let steps = gains()[1].abs() * on.sensors.rate.step
        + gains()[2].abs() * on.sensors.wheel_speed.step
        + on.actuator.step_a;
    let allowed = largest_gain(&motion.model).map(|gain| gain * (LAW_ERROR_A + steps));
    assert_within(&exact.deviation(&emitted), allowed);
}

/// On the nonlinear plant the difference stays below a hundredth of what the sensors' noise hides,
/// with and without dry friction.
#[test]
fn on_the_nonlinear_plant_no_sensor_could_tell_the_laws_apart() {
    let noise = Sensors::of_the_thesis();
    for with_coulomb in [false, true] {
        let plant: Plant<f64> = bench(with_coulomb);
        let [exact, emitted] = half_minute(&plain_loop(Motion::Nonlinear(&plant)));
        assert_eq!(exact.len(), 30_001);
        assert_eq!(exact.fell_at_s.or(emitted.fell_at_s), None);
        let allowed = [noise.angle, noise.rate, noise.wheel_speed]
            .map(|sensor: Sensor| 0.01 * sensor.noise_std);
        assert_within(&exact.deviation(&emitted), allowed);
    }
}

#[test]
fn both_laws_balance_with_the_hardware_of_the_thesis() {
    for with_coulomb in [false, true] {
        let plant = bench(with_coulomb);
        let mut on = plain_loop(Motion::Nonlinear(&plant));
        on.sensors = Sensors::of_the_thesis();
        on.actuator = Actuator::OF_THE_THESIS;
        for trace in half_minute(&on) {
            assert_eq!(trace.fell_at_s, None);
            // Every push is answered: two seconds later the body is upright again.
            for (time_s, angle) in trace.time_s.iter().zip(&trace.angle_rad) {
                let calm = [7.0..9.8, 12.0..14.8, 17.0..19.8, 24.0..25.8, 28.0..30.0]
                    .iter()
                    .any(|range| range.contains(time_s));
                assert!(!calm || angle.abs() < 0.01, "{angle} at {time_s}");
            }
        }
    }
}

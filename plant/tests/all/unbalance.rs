//! The unbalance of the wheel, compared with the equations that follow from its energy.

use plant::{Current, EffectId, Kind, Model, Plant, State};

use crate::VALUES;

const UNBALANCE: [f64; 4] = [4e-4, 0.7, 0.085, 9.81];

fn plant(kind: Kind, friction: bool) -> Plant<f64> {
    let model = Model::base().with(EffectId::WheelUnbalance);
    let mut values = VALUES.to_vec();
    if !friction {
        values[4] = 0.0;
        values[5] = 0.0;
    }
    let at = model.range_of(EffectId::WheelUnbalance).expect("added");
    values.splice(at.start..at.start, UNBALANCE);
    Plant::new(&model, &values, kind)
}

/// Kinetic and potential energy in J of body, wheel and the mass beside the wheel's axis. The velocity of this mass is
/// the sum of k α̇, the velocity of the axis, and r (α̇ + φ̇) about the axis; the angle between the two is χ. The
/// terms with r² are part of j_w.
fn energy(state: &State<f64>) -> f64 {
    let [p, phase, k, g] = UNBALANCE;
    let (rate, speed) = (state.rate_rad_s, state.wheel_speed_rad_s);
    let side = state.wheel_angle_rad + phase;
    let [total, wheel, gravity, _] = [VALUES[0], VALUES[1], VALUES[2], VALUES[3]];
    0.5 * total * rate * rate + wheel * rate * speed + 0.5 * wheel * speed * speed
        - gravity * state.angle_rad.cos()
        + p * k * rate * (rate + speed) * side.cos()
        - p * g * (state.angle_rad + side).cos()
}

#[test]
fn without_friction_the_energy_stays() {
    let plant = plant(Kind::Driven, false);
    let start = State {
        angle_rad: 0.9,
        rate_rad_s: 1.0,
        wheel_speed_rad_s: 40.0,
        ..State::rest()
    };
    let time_s: Vec<f64> = (0..4000).map(|k| k as f64 * 1e-3).collect();
    let mut energies = vec![];
    let mut speeds = vec![];
    plant.run(
        start,
        &time_s,
        0..4000,
        Current::Held(0.0),
        None,
        |_, _, state| {
            energies.push(energy(state));
            speeds.push(state.wheel_speed_rad_s);
        },
    );
    let largest = energies
        .iter()
        .map(|e| (e - energies[0]).abs())
        .fold(0.0, f64::max);
    assert!(largest < 1e-6 * energies[0].abs().max(0.1), "{largest}");
    // The unbalance is large enough to matter: it changes the wheel's speed by more than 5 rad/s.
    let spread = speeds
        .iter()
        .fold(0.0f64, |m, speed| m.max((speed - 40.0).abs()));
    assert!(spread > 5.0, "{spread}");
}

/// With the body clamped a slow wheel swings about the angle at which its heavy side hangs down, with the frequency
/// √(p g/j_w) of a small oscillation.
#[test]
fn a_slow_wheel_is_a_pendulum() {
    let plant = plant(Kind::SpinUp, false);
    let start = State {
        wheel_angle_rad: -UNBALANCE[1] + 0.01,
        ..State::rest()
    };
    let period_s = std::f64::consts::TAU * (VALUES[1] / (UNBALANCE[0] * UNBALANCE[3])).sqrt();
    let steps = 1000;
    let time_s: Vec<f64> = (0..=steps)
        .map(|k| k as f64 * period_s / steps as f64)
        .collect();
    let mut angles = vec![];
    let current = Current::Held(0.0);
    plant.run(
        start,
        &time_s,
        0..steps + 1,
        current,
        None,
        |_, _, state| {
            angles.push(state.wheel_angle_rad + UNBALANCE[1]);
        },
    );
    assert!(
        (angles[steps / 2] + 0.01).abs() < 1e-6,
        "{}",
        angles[steps / 2]
    );
    assert!((angles[steps] - 0.01).abs() < 1e-6, "{}", angles[steps]);
}

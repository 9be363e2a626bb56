//! The motion against closed forms.

use plant::{Current, EffectId, Hold, Input, Kind, Model, Plant, State};

use crate::{VALUES, swing};

/// Period of a pendulum: 4 K(sin(α₀/2))/ω₀, with K by the arithmetic-geometric mean
/// (Abramowitz & Stegun 17.6.3).
fn period_s(angle_rad: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * angle_rad).cos());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    2.0 * std::f64::consts::PI / ((VALUES[2] / VALUES[0]).sqrt() * a)
}

#[test]
fn a_swing_without_friction_has_the_period_of_the_elliptic_integral_and_keeps_its_energy() {
    let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], 0.0, 0.0];
    let plant = Plant::new(&Model::base(), &values, Kind::FreeSwing);
    for angle in [0.1, 0.9, 2.5] {
        let period = period_s(angle);
        let steps = 400;
        let end = swing(&plant, angle, period / steps as f64, steps)[steps];
        assert!((end.angle_rad - angle).abs() < 1e-6 * angle, "{angle}");
        assert!(end.rate_rad_s.abs() < 1e-4, "{angle} {}", end.rate_rad_s);
    }
}

#[test]
fn a_locked_swing_is_the_free_one_with_an_infinitely_sluggish_wheel() {
    // With a locked wheel, the inertia of the swing is Θ. A free wheel without friction keeps its absolute speed, so
    // that the inertia of the swing is Θ − j_w.
    let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], 0.0, 0.0];
    let free = Plant::new(&Model::base(), &values, Kind::Driven);
    let end = swing(&free, 0.4, 1e-3, 1000)[1000];
    assert!((end.wheel_speed_rad_s + end.rate_rad_s).abs() < 1e-9);
    let lighter = [values[0] - values[1], 1e-9, values[2], values[3], 0.0, 0.0];
    let locked = Plant::new(&Model::base(), &lighter, Kind::FreeSwing);
    let same = swing(&locked, 0.4, 1e-3, 1000)[1000];
    assert!((end.angle_rad - same.angle_rad).abs() < 1e-9);
}

#[test]
fn a_spin_up_follows_its_exponential() {
    let plant = Plant::new(&Model::base(), &VALUES, Kind::SpinUp);
    let time_s: Vec<f64> = (0..1501).map(|k| k as f64 * 0.004).collect();
    let input = Input::new(&time_s, &vec![0.4; time_s.len()], Hold::Zero);
    let mut worst: f64 = 0.0;
    plant.run(
        State::rest(),
        &time_s,
        0..time_s.len(),
        Current::Recorded(&input),
        None,
        |k, reading, _| {
            let (j, r) = (VALUES[1], VALUES[5]);
            let exact = 0.0335 * 0.4 / r * (1.0 - (-r / j * time_s[k]).exp());
            worst = worst.max((reading.wheel_speed_rad_s - exact).abs());
        },
    );
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn dry_friction_takes_four_mu_over_g_of_the_amplitude_in_every_cycle() {
    let model = Model::with_effects(&[EffectId::BodyCoulombFriction]);
    let mu = 1e-3;
    let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], mu];
    let plant = Plant::new(&model, &values, Kind::FreeSwing);
    let states = swing(&plant, 0.1, 0.004, 5000);
    let maxima: Vec<f64> = states
        .windows(3)
        .filter(|w| w[1].angle_rad > w[0].angle_rad && w[1].angle_rad >= w[2].angle_rad)
        .map(|w| w[1].angle_rad)
        .collect();
    let loss = 4.0 * mu / VALUES[2];
    for pair in maxima.windows(2).take_while(|pair| pair[1] > 3.0 * loss) {
        assert!(((pair[0] - pair[1]) / loss - 1.0).abs() < 0.03, "{pair:?}");
    }
    assert!(maxima.len() > 4);
}

#[test]
fn presliding_friction_starts_as_a_spring_and_ends_as_dry_friction() {
    let (mu, sigma) = (4e-4, 0.02);
    let model = Model::base().with(EffectId::BodyPreslidingFriction);
    let values = [&VALUES[..], &[mu, sigma]].concat();
    let plant = Plant::new(&model, &values, Kind::FreeSwing);
    let distance_rad = plant.memory_distance_rad().expect("a contact that bends");
    assert!((distance_rad - mu / sigma).abs() < 1e-15);
    let small = plant.remember(0.0, 1e-6);
    assert!((small / (sigma * 1e-6) - 1.0).abs() < 1e-3);
    assert!((plant.remember(0.0, 1.0) - mu).abs() < 1e-12);
    assert!((plant.remember(mu, -1.0) + mu).abs() < 1e-12);
    // Two half displacements are one whole displacement: the solution is exact.
    let twice = plant.remember(plant.remember(1e-4, 0.01), 0.01);
    assert!((twice - plant.remember(1e-4, 0.02)).abs() < 1e-15);
}

/// With the parameters of its stated limit, an effect has the torque of the effect that it replaces.
#[test]
fn the_limit_of_a_refinement_is_what_it_refines() {
    let refinements = EffectId::ALL
        .iter()
        .filter(|effect| effect.info().limit.is_some());
    for &effect in refinements.clone() {
        let info = effect.info();
        let simpler = EffectId::from_name(info.replaces[0]).expect("an effect");
        let mut own: Vec<f64> = info.parameters.iter().map(|one| one.plausible.1).collect();
        let (one, other) = info.limit.expect("filtered");
        own[one] = own[other];
        let of = |effect: EffectId, own: &[f64], rate: f64| {
            let values = [&VALUES[..], own].concat();
            let plant = Plant::new(&Model::base().with(effect), &values, Kind::FreeSwing);
            let state = State {
                rate_rad_s: rate,
                ..State::rest()
            };
            plant.derivative(&state, 0.0, 0.0).0
        };
        for rate in [-3.0, -0.01, 0.0, 0.3, 5.0] {
            let (a, b) = (
                of(effect, &own, rate),
                of(simpler, &own[other..=other], rate),
            );
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{}: {a} {b}", info.name);
        }
    }
    assert!(refinements.count() > 0);
}

//! Linear against nonlinear, overlays, transients.

use crate::bench::{BASE, bench, exact_law, plain_loop};
use nalgebra::Matrix3;
use plant::{EffectId, Model};
use simulate::linear_validity::{
    MeasuredPeriod, MeasuredSpinUp, MeasuredSwing, compare_free_swing, compare_spin_up,
    largest_linear_amplitude, linear_range, over_measurement, spin_up_over_measurement,
};
use simulate::overlay::MeasuredLog;
use simulate::scenario::Scale;
use simulate::{
    Actuator, ClosedLoop, Motion, Push, Scenario, Sensors, Transient, effects_on_transient,
    overlay, region_of_attraction,
};
use std::f64::consts::{PI, TAU};

/// Without friction the nonlinear swing is late by 2πn A²/16 after n periods, so that the error of
/// the linear one is that phase, on average over the run: amplitude·φ_n/√6 (root mean square of a
/// sine times a ramp).
#[test]
fn small_swings_drift_as_the_period_formula_says() {
    let values = [BASE[0], BASE[1], BASE[2], BASE[3], 0.0, 0.0];
    for degrees in [5.0_f64, 10.0] {
        let amplitude = degrees.to_radians();
        let period = TAU * (BASE[0] / BASE[2]).sqrt();
        let swing = compare_free_swing(&Model::base(), &values, amplitude, period).unwrap();
        assert!((swing.linear_period_s - period).abs() < 1e-9);
        let longer = 1.0 + amplitude.powi(2) / 16.0;
        let first = swing.first_period_s.unwrap();
        assert!((first / period - longer).abs() < 1e-4, "{first}");
        let expected = TAU * amplitude.powi(2) / 16.0 / 6.0_f64.sqrt();
        let ratio = swing.error_over_first_period / expected;
        // The cubic term also distorts the sine, which the formula leaves out.
        assert!((0.75..1.25).contains(&ratio), "{ratio} at {degrees}");
        assert_eq!(
            swing.error_over_first_period,
            swing.geometric_error_over_first_period
        );
    }
}

#[test]
fn the_linear_model_is_good_at_20_degrees_and_not_at_60() {
    let (model, values) = crate::bench::model(true);
    let error = |degrees: f64| {
        let swing = compare_free_swing(&model, &values, degrees.to_radians(), 5.0).unwrap();
        swing.geometric_error_over_first_period
    };
    assert!(error(20.0) < 0.05 && error(60.0) > 0.15);
    let once = largest_linear_amplitude(&model, &values, 1, 0.05).unwrap();
    let often = largest_linear_amplitude(&model, &values, 10, 0.05).unwrap();
    assert!(once > 20.0_f64.to_radians() && once < 60.0_f64.to_radians());
    // The phase adds up over the periods and grows with the square of the amplitude.
    let ratio = once / often;
    assert!((ratio - 10.0_f64.sqrt()).abs() < 0.2 * ratio, "{ratio}");
    // The error at the amplitude found is the requested 0.05.
    let at = compare_free_swing(&model, &values, once, 1.0).unwrap();
    assert!((at.geometric_error_over_first_period - 0.05).abs() < 1e-3);
}

/// The period of a pendulum exceeds that of small swings by 1 % at 22.81385° (2 K(sin A/2)/π = 1.01,
/// Abramowitz & Stegun 17.3.1, solved for A apart from this program).
#[test]
fn measured_periods_leave_the_linear_one_where_the_elliptic_integral_says() {
    let values = [BASE[0], BASE[1], BASE[2], BASE[3], 0.0, 0.0];
    let period = TAU * (BASE[0] / BASE[2]).sqrt();
    let nodes = 2000;
    // The midpoint rule converges exponentially on a whole period of the integrand.
    let elliptic = |amplitude: f64| -> f64 {
        let k = (0.5 * amplitude).sin();
        (0..nodes)
            .map(|node| (f64::from(node) + 0.5) * 0.5 * PI / f64::from(nodes))
            .map(|theta| 1.0 / (1.0 - (k * theta.sin()).powi(2)).sqrt())
            .sum::<f64>()
            / f64::from(nodes)
    };
    let mut periods: Vec<MeasuredPeriod> = (1..=600)
        .map(|tenth| (f64::from(tenth) * 0.1).to_radians())
        .map(|amplitude_rad| MeasuredPeriod {
            amplitude_rad,
            period_s: period * elliptic(amplitude_rad),
            std_s: 1e-4 * period,
        })
        .collect();
    let range =
        |periods: &[MeasuredPeriod]| linear_range(&Model::base(), &values, periods, 0.01).unwrap();
    let found = range(&periods).unwrap();
    assert!((found.linear_period_s - period).abs() < 1e-9);
    let (from, to) = found.good_rad.unwrap();
    assert!((from.to_degrees() - 0.1).abs() < 1e-9);
    let limit = 22.813_85_f64;
    assert!(to.to_degrees() <= limit && to.to_degrees() > limit - 0.1);
    let off = found.off_from_rad.unwrap().to_degrees();
    assert!((off - to.to_degrees() - 0.1).abs() < 1e-9);
    assert_eq!(range(&periods[..200]).unwrap().off_from_rad, None);
    assert!((found.measured_rad.1.to_degrees() - 60.0).abs() < 1e-9);
    // A period that is not known to 1 % says nothing.
    periods.push(MeasuredPeriod {
        amplitude_rad: 0.1,
        period_s: 9.0 * period,
        std_s: 0.02 * period,
    });
    assert_eq!(range(&periods), Some(found));
    assert_eq!(range(&periods[600..]), None);
    // Another pendulum: nowhere.
    let slow: Vec<MeasuredPeriod> = periods[..600]
        .iter()
        .map(|at| MeasuredPeriod {
            period_s: 1.1 * at.period_s,
            ..*at
        })
        .collect();
    assert_eq!(range(&slow).unwrap().good_rad, None);
}

/// Small swings about a rest that a cable pulls aside, read by a sensor with an offset: linear and
/// nonlinear model must both lie on the measurement. From 60° the linear one must not.
#[test]
fn both_models_start_where_the_measured_swing_does() {
    let model = Model::base().with(EffectId::BodyCableSpring);
    let position = |name| model.position_of(name).unwrap();
    let mut values = vec![0.0; model.parameter_count()];
    for info in model.parameters() {
        if let Some(base) = Model::base().position_of(info.name) {
            values[position(info.name)] = BASE[base];
        }
    }
    values[position("cable_stiffness")] = 0.2 * BASE[2];
    values[position("cable_rest_angle")] = 0.12;
    let offset = 0.05;
    let time_s: Vec<f64> = (0..2000).map(|k| 3.0 + f64::from(k) * 4e-3).collect();
    let errors = |start: [f64; 2]| {
        let plant = plant::Plant::new(&model, &values, plant::Kind::FreeSwing);
        let mut state = plant::State {
            angle_rad: start[0],
            rate_rad_s: start[1],
            ..plant::State::rest()
        };
        let drive = plant::Drive {
            current_a: 0.0,
            push: [0.0; 3],
        };
        let angle_rad: Vec<f64> = time_s
            .iter()
            .map(|_| {
                let read = state.angle_rad + offset;
                state = plant.step(&state, &drive, 4e-3);
                read
            })
            .collect();
        let swing = MeasuredSwing {
            time_s: &time_s,
            angle_rad: &angle_rad,
            whole_rad: &angle_rad,
            start,
        };
        let over = over_measurement(&model, &values, &swing, 10).unwrap();
        assert_eq!((over.time_s[0], over.whole_error), (0.0, 0.0));
        assert!(over.time_s.len() < time_s.len());
        (over.amplitude_rad, over.linear_error)
    };
    // The linear model rests at 0.2·0.12/1.2 = 0.02 rad, so that a start at 0.03 rad has an amplitude of 0.01 rad.
    let (amplitude, error) = errors([0.03, 0.0]);
    assert!((amplitude - 0.01).abs() < 1e-6, "{amplitude}");
    assert!(error < 0.02, "{error}");
    // From the rest with a rate it is the same swing, a quarter of a period on.
    let omega = (1.2 * BASE[2] / BASE[0]).sqrt();
    let (amplitude, error) = errors([0.02, 0.01 * omega]);
    assert!((amplitude - 0.01).abs() < 1e-5, "{amplitude}");
    assert!(error < 0.02, "{error}");
    assert!(errors([60.0_f64.to_radians(), 0.0]).1 > 0.5);
}

#[test]
fn a_viscous_spin_up_is_linear_and_a_saturating_motor_is_not() {
    let linear = compare_spin_up(&Model::base(), &BASE, 1.0, 20.0, 0.05).unwrap();
    assert_eq!(linear.good_up_to_rad_s, None);
    // φ̇ = (τ u/r_w)(1 − exp(−r_w t/j_w)).
    let rate = BASE[5] / BASE[1];
    for (time, speed) in linear.time_s.iter().zip(&linear.linear_rad_s) {
        let exact = BASE[3] / BASE[5] * (1.0 - (-rate * time).exp());
        assert!((speed - exact).abs() < 1e-6 * (1.0 + exact));
    }
    let model = Model::base().with(EffectId::WheelQuadraticDrag);
    let mut values = BASE.to_vec();
    let drag = 1e-8;
    values.push(drag);
    let bent = compare_spin_up(&model, &values, 1.0, 20.0, 0.05).unwrap();
    // Until the drag takes 5 % of the work: between a twentieth of the torque at that instant and
    // a few times that, as the error is the drag's average over the run-up.
    let instant = (0.05 * BASE[3] / drag).sqrt();
    let good = bent.good_up_to_rad_s.unwrap();
    assert!(good > instant && good < 3.0 * instant, "{good} {instant}");
}

/// A coast-down with dry friction μ_w: φ̇ + μ_w/r_w decays as exp(−r_w t/j_w). The linear model has the
/// viscous part alone, so that it is off by μ_w/r_w (1 − exp(−r_w t/j_w)).
#[test]
fn dry_friction_takes_the_linear_coast_down_off_as_the_closed_form_says() {
    let model = Model::base().with(EffectId::WheelCoulombFriction);
    let dry = 6e-4;
    let values: Vec<f64> = BASE.iter().copied().chain([dry]).collect();
    let (rate, start, floor) = (BASE[5] / BASE[1], 300.0, dry / BASE[5]);
    let time_s: Vec<f64> = (0..1000).map(|k| 2.0 + f64::from(k) * 4e-3).collect();
    let decay = |t: f64| (-rate * (t - 2.0)).exp();
    let whole: Vec<f64> = time_s
        .iter()
        .map(|t| (start + floor) * decay(*t) - floor)
        .collect();
    let current = vec![0.0; time_s.len()];
    let mut measured = whole.clone();
    measured[7] = f64::NAN;
    let over = spin_up_over_measurement(
        &model,
        &values,
        &MeasuredSpinUp {
            time_s: &time_s,
            wheel_speed_rad_s: &measured,
            current_a: &current,
            whole_rad_s: &whole,
        },
    )
    .unwrap();
    assert_eq!(
        (over.time_s[0], over.whole_error, over.largest_rad_s),
        (0.0, 0.0, start)
    );
    let mut squares = 0.0;
    for (index, (t, linear)) in time_s.iter().zip(&over.linear_rad_s).enumerate() {
        let off = floor * (1.0 - decay(*t));
        assert!((linear - whole[index] - off).abs() < 1e-9 * start);
        squares += if index == 7 { 0.0 } else { off * off };
    }
    let expected = (squares / 999.0).sqrt() / start;
    assert!(
        (over.linear_error / expected - 1.0).abs() < 1e-9,
        "{expected}"
    );
    let short = MeasuredSpinUp {
        time_s: &time_s,
        wheel_speed_rad_s: &measured[1..],
        current_a: &current,
        whole_rad_s: &whole,
    };
    assert!(spin_up_over_measurement(&model, &values, &short).is_err());
}

/// A set of starts that all come back keeps doing so a little smaller and from other starts; a larger
/// drive brings back more; the start that was lost is lost.
#[test]
fn the_region_of_attraction_is_one_and_grows_with_the_drive() {
    let plant = bench(true);
    let on = ClosedLoop {
        sensors: Sensors::of_the_thesis(),
        ..plain_loop(Motion::Nonlinear(&plant))
    };
    let scale = Scale::new(&BASE, 2.0).unwrap();
    // Of the size of the angle that the motor can hold, and speeds that go with it.
    let shape = Matrix3::new(250.0, 20.0, 0.44, 20.0, 1.7, 0.038, 0.44, 0.038, 1.4e-3);
    let region = |limit_a: f64, starts: usize| {
        let mut law = exact_law();
        law.limit_a = limit_a;
        region_of_attraction(&on, &scale, &mut law, &shape, starts, 0.02).unwrap()
    };
    let found = region(2.0, 200);
    assert!(
        found.size > 1.0 && found.lost_size - found.size <= 0.02,
        "{found:?}"
    );
    assert!(region(2.0, 97).lost_size > 0.9 * found.size);
    assert!(region(1.0, 200).size < 0.7 * found.size);
    let [angle, rate, speed] = found.lost;
    let start = plant::State {
        angle_rad: PI + angle,
        rate_rad_s: rate,
        wheel_speed_rad_s: speed,
        ..plant::State::rest()
    };
    let trace = on.run(&start, 10.0, &mut exact_law(), true).unwrap();
    assert!(trace.fell_at_s.is_some(), "{found:?}");
    let flat = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0);
    assert!(region_of_attraction(&on, &scale, &mut exact_law(), &flat, 10, 0.1).is_err());
}

#[test]
fn an_overlay_with_the_true_bench_fits_and_with_a_wrong_one_does_not() {
    let plant = bench(true);
    let mut on = plain_loop(Motion::Nonlinear(&plant));
    on.sensors = Sensors::of_the_thesis();
    on.actuator = Actuator::OF_THE_THESIS;
    let start_s = 3.0;
    let true_pushes = vec![Push::new(4.0, 0.03, 0.05), Push::new(8.0, -0.02, 0.05)];
    on.pushes = true_pushes.clone();
    // The "measurement": another seed, and a log whose clock starts at 3 s.
    on.seed = 77;
    let measured = on
        .run(
            &simulate::closed_loop::at_rest(0.05),
            12.0,
            &mut exact_law(),
            false,
        )
        .unwrap();
    let shifted: Vec<f64> = measured.time_s.iter().map(|time| time + start_s).collect();
    let angle: Vec<f64> = measured
        .measured_angle_rad
        .iter()
        .map(|angle| angle + PI)
        .collect();
    let log = MeasuredLog {
        time_s: &shifted,
        angle_rad: &angle,
        rate_rad_s: Some(&measured.measured_rate_rad_s),
        wheel_speed_rad_s: Some(&measured.measured_wheel_speed_rad_s),
        current_a: None,
    };
    on.seed = 1;
    on.pushes = true_pushes
        .iter()
        .map(|push| Push {
            time_s: push.time_s + start_s,
            ..*push
        })
        .collect();
    let with = overlay(&log, &on, &mut exact_law()).unwrap();
    let names: Vec<_> = with.channels.iter().map(|channel| channel.name).collect();
    assert_eq!(names, ["angle", "rate", "wheel_speed"]);
    for channel in &with.channels {
        let noise = match channel.name {
            "angle" => on.sensors.angle.noise_std,
            "rate" => on.sensors.rate.noise_std,
            _ => on.sensors.wheel_speed.noise_std,
        };
        // Two independent noises, and what they make the loop do.
        assert!(
            channel.rms_difference < 3.0 * noise,
            "{} {}",
            channel.name,
            channel.rms_difference
        );
        assert!((channel.simulated_std / channel.measured_std - 1.0).abs() < 0.1);
    }
    on.pushes.clear();
    let without = overlay(&log, &on, &mut exact_law()).unwrap();
    assert!(without.channels[0].rms_difference > 2.0 * with.channels[0].rms_difference);
}

#[test]
fn transients_are_measured_as_defined() {
    let plant = bench(false);
    let scale = Scale::new(&BASE, 2.0).unwrap();
    let scenario = Scenario::transient(&scale);
    let on = plain_loop(Motion::Nonlinear(&plant));
    let mut law = exact_law();
    let trace = scenario.run(&on, &mut [&mut law]).unwrap().remove(0);
    let start = trace.angle_rad[0];
    let transient = Transient::of(&trace, 0.02 * start);
    assert!(!transient.fell);
    assert_eq!(transient.swings, 1);
    assert!(transient.overshoot_rad > 0.0 && transient.overshoot_rad < start);
    let after = trace
        .time_s
        .iter()
        .zip(&trace.angle_rad)
        .filter(|(time, _)| **time > transient.settling_s);
    for (_, angle) in after {
        assert!(angle.abs() <= 0.02 * start);
    }
}

#[test]
fn effects_act_on_the_transient_each_and_all() {
    // A late and slow motor takes damping away; the delay margin of the loop is 45 ms.
    let model = Model::base()
        .with(EffectId::BodyCoulombFriction)
        .with(EffectId::InputDelay)
        .with(EffectId::MotorLag);
    let values: Vec<f64> = model
        .parameters()
        .iter()
        .zip(0..)
        .map(|(info, index)| match info.name {
            "body_coulomb_torque" => crate::bench::COULOMB_TORQUE,
            "input_delay" => 0.010,
            "motor_lag" => 0.012,
            _ => BASE[index],
        })
        .collect();
    let scale = Scale::new(&values, 2.0).unwrap();
    let scenario = Scenario::transient(&scale);
    let placeholder = bench(false);
    let on: ClosedLoop<'_> = plain_loop(Motion::Nonlinear(&placeholder));
    let runs = effects_on_transient(
        &model,
        &values,
        &on,
        &scenario,
        &mut exact_law(),
        0.02 * scale.holding_angle_rad(),
    )
    .unwrap();
    assert_eq!(runs.len(), 5);
    assert!(runs[0].effects.is_empty());
    assert_eq!(runs[4].effects.len(), 3);
    let overshoot: Vec<f64> = runs.iter().map(|run| run.transient.overshoot_rad).collect();
    let of = |effect: EffectId| {
        runs.iter()
            .position(|run| run.effects == [effect])
            .map(|index| overshoot[index])
            .unwrap()
    };
    assert!(of(EffectId::InputDelay) > overshoot[0]);
    assert!(of(EffectId::MotorLag) > overshoot[0]);
    // Together they cost more than each alone.
    assert!(overshoot[4] > of(EffectId::InputDelay));
}

/// Within five per cent of the delay margin the loop rings at the margin's frequency: at least an
/// oscillation more than without delay. Started so gently that the current limit does not decide.
#[test]
fn a_delay_near_the_margin_makes_the_loop_ring() {
    let plant = bench(false);
    let (model, values) = crate::bench::model(false);
    let linear = plant::linearise(&model, &values, PI, None).unwrap();
    let a = nalgebra::DMatrix::from_fn(3, 3, |row, column| linear.state[(row, column)]);
    let b = nalgebra::DMatrix::from_fn(3, 1, |row, _| linear.input[row]);
    let margins = design::margins::margins(
        &a,
        &b,
        &design::LinearController::state_feedback(&crate::bench::gains()),
        crate::bench::SAMPLE_TIME_S,
    )
    .unwrap();
    let start = 0.01;
    let run = |computation_s: f64| {
        let mut on = plain_loop(Motion::Nonlinear(&plant));
        on.computation_s = computation_s;
        on.run(
            &simulate::closed_loop::at_rest(start),
            5.0,
            &mut exact_law(),
            false,
        )
        .unwrap()
    };
    let prompt = Transient::of(&run(0.0), 0.02 * start);
    let late = run(0.95 * margins.delay_margin_s);
    let ringing = Transient::of(&late, 0.02 * start);
    assert_eq!(prompt.swings, 1);
    assert!(ringing.swings >= prompt.swings + 2, "{ringing:?}");
    // Half a period from swing to swing.
    let crossings: Vec<f64> = late
        .time_s
        .windows(2)
        .zip(late.angle_rad.windows(2))
        .filter(|(_, angle)| angle[0] * angle[1] < 0.0)
        .map(|(time, _)| time[0])
        .take(6)
        .collect();
    let half_period_s = (crossings[5] - crossings[1]) / 4.0;
    let frequency = PI / half_period_s;
    assert!(
        (frequency / margins.delay_frequency_rad_s - 1.0).abs() < 0.1,
        "{frequency} against {margins:?}"
    );
}

/// A dry pivot makes the loop hunt; the design predicts how far by the describing function of the
/// friction, which takes the swing for a sine (good to some ten per cent).
#[test]
fn a_dry_pivot_hunts_as_far_as_the_design_predicts() {
    let model = Model::base().with(EffectId::BodyCoulombFriction);
    for torque in [3e-3, 6e-3] {
        let mut values = BASE.to_vec();
        values.push(torque);
        let speed = 0.01;
        let extremes = design::FrictionExtremes {
            none: plant::linearise(&model, &values, PI, None).unwrap(),
            all: plant::linearise(&model, &values, PI, Some(speed)).unwrap(),
            smoothing_speed_rad_s: speed,
        };
        let predicted = design::friction_check(&extremes, &crate::bench::gains(), 1e-3)
            .unwrap()
            .hunting
            .unwrap();
        let plant = plant::Plant::new(&model, &values, plant::Kind::Balance);
        let trace = plain_loop(Motion::Nonlinear(&plant))
            .run(
                &simulate::closed_loop::at_rest(0.02),
                60.0,
                &mut exact_law(),
                false,
            )
            .unwrap();
        let late = &trace.angle_rad[trace.len() / 2..];
        let amplitude = late.iter().map(|angle| angle.abs()).fold(0.0, f64::max);
        let crossings = late
            .windows(2)
            .filter(|pair| pair[0] * pair[1] < 0.0)
            .count();
        let frequency = PI * crossings as f64 / (late.len() as f64 * 1e-3);
        eprintln!("{torque}: {amplitude} {frequency} {predicted:?}");
        assert!((amplitude / predicted.angle_rad - 1.0).abs() < 0.3);
        assert!((frequency / predicted.frequency_rad_s - 1.0).abs() < 0.3);
    }
}

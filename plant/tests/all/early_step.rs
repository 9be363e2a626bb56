//! A command that changes between two samples of the log, against the same command recorded when it changed.

use plant::{Current, Dual, EarlyStep, EffectId, Hold, Input, Kind, Model, Plant, Scalar, State};

use crate::VALUES;

/// Interval of the log, s.
const STEP_S: f64 = 0.005;
/// The sample that shows the step, and by how much it came earlier, in units of a hundredth of the interval.
const SAMPLE: usize = 40;
const EARLIER: usize = 37;
const BEFORE_A: f64 = -0.4;
const AFTER_A: f64 = 1.1;

/// The model with a lag or a delay of its motor, or none.
fn models() -> Vec<(Model, Vec<f64>)> {
    let base = Model::base();
    let with = |effect, own: f64| (base.with(effect), [&VALUES[..], &[own]].concat());
    vec![
        (base.clone(), VALUES.to_vec()),
        with(EffectId::MotorLag, 0.011),
        with(EffectId::InputDelay, 0.0131),
        with(EffectId::MotorSaturation, 0.9),
    ]
}

/// Angle, rate and wheel speed of a driven run at every sample of the log.
fn outputs<S: Scalar>(
    model: &Model,
    values: &[S],
    input: &Input,
    (time_s, early): (&[f64], Vec<EarlyStep<S>>),
) -> Vec<[S; 3]> {
    let plant = Plant::new(model, values, Kind::Driven).with_early_steps(early);
    let start = State {
        angle_rad: S::constant(0.2),
        current_a: S::constant(BEFORE_A),
        ..State::rest()
    };
    let current = Current::Recorded(input);
    let mut out = vec![];
    plant.run(start, time_s, 0..time_s.len(), current, None, |_, r, _| {
        out.push([r.angle_rad, r.rate_rad_s, r.wheel_speed_rad_s]);
    });
    out
}

fn early<S: Scalar>(earlier_s: S) -> Vec<EarlyStep<S>> {
    vec![EarlyStep {
        sample_s: SAMPLE as f64 * STEP_S,
        change_a: AFTER_A - BEFORE_A,
        earlier_s,
    }]
}

fn log() -> (Vec<f64>, Input) {
    let time_s: Vec<f64> = (0..=120).map(|k| k as f64 * STEP_S).collect();
    let command = |k: usize| if k < SAMPLE { BEFORE_A } else { AFTER_A };
    let current_a: Vec<f64> = (0..=120).map(command).collect();
    let input = Input::new(&time_s, &current_a, Hold::Zero);
    (time_s, input)
}

#[test]
fn the_motion_is_that_of_the_command_when_it_changed() {
    let (time_s, input) = log();
    let earlier_s = EARLIER as f64 * STEP_S / 100.0;
    // The same command, recorded a hundred times as often.
    let fine_s: Vec<f64> = (0..=12_000).map(|k| k as f64 * STEP_S / 100.0).collect();
    let change = SAMPLE * 100 - EARLIER;
    let command = |k: usize| if k < change { BEFORE_A } else { AFTER_A };
    let fine_a: Vec<f64> = (0..=12_000).map(command).collect();
    let fine = Input::new(&fine_s, &fine_a, Hold::Zero);
    for (model, values) in models() {
        let effects = model.effects();
        let truth = outputs(&model, &values, &fine, (&fine_s, vec![]));
        let moved = outputs(&model, &values, &input, (&time_s, early(earlier_s)));
        let still = outputs(&model, &values, &input, (&time_s, vec![]));
        let mut far = 0.0f64;
        for (k, (moved, still)) in moved.iter().zip(&still).enumerate() {
            let truth = &truth[100 * k];
            for output in 0..3 {
                // Within the interval of the step the angle keeps an error of Δτ/D h²/8.
                let scale = [0.3, 3.0, 100.0][output];
                let error = (moved[output] - truth[output]).abs();
                assert!(
                    error < 5e-4 * scale,
                    "{effects:?} sample {k} output {output}: {} {}",
                    moved[output],
                    truth[output]
                );
                far = far.max((still[output] - truth[output]).abs() / scale);
            }
        }
        assert!(
            far > 5e-3,
            "{effects:?}: the step's time hardly matters: {far}"
        );
    }
}

#[test]
fn the_derivative_is_that_of_the_motion() {
    let (time_s, input) = log();
    for (model, values) in models() {
        // Behind a stage that is no straight line, the derivative has the stage's slope at the new command.
        if model.effects().contains(&EffectId::MotorSaturation) {
            continue;
        }
        for share in [0.3, -0.2] {
            let earlier_s = share * STEP_S;
            let duals: Vec<Dual<1>> = values.iter().map(|&v| Dual::constant(v)).collect();
            let step = early(Dual::<1>::variable(earlier_s, 0));
            let exact = outputs(&model, &duals, &input, (&time_s, step));
            let h = 1e-6;
            let run = |moved_s: f64| {
                let step = early(earlier_s + moved_s);
                outputs(&model, &values, &input, (&time_s, step))
            };
            let (up, down) = (run(h), run(-h));
            for (k, exact) in exact.iter().enumerate() {
                for output in 0..3 {
                    let difference = (up[k][output] - down[k][output]) / (2.0 * h);
                    let error = (exact[output].derivatives[0] - difference).abs();
                    // The derivative spreads the charge over the rest of the interval, so it comes up to half an interval
                    // late: its angle by half an interval of the rate's, and so on. At the end of that interval, a lag of
                    // the motor still shows half of it.
                    let near = (SAMPLE..SAMPLE + 4).contains(&k);
                    let floor = if near {
                        [0.06, 2.0, 30.0]
                    } else {
                        [0.06, 0.4, 4.0]
                    }[output];
                    assert!(
                        error < 2e-3 * difference.abs() + floor,
                        "{:?} share {share} sample {k} output {output}: {} {difference}",
                        model.effects(),
                        exact[output].derivatives[0]
                    );
                }
            }
        }
    }
}

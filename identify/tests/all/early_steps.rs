//! Commands that changed between two rows of a log: the parameters are those of the bench, within their standard errors,
//! and a log whose commands changed with its rows is left as it is.

use crate::common::parameter;
use crate::simulated::{Experiment, NOISE, Physics, VALUES, simulate, spin_up};
use identify::{FitProblem, Output, Record, identify};
use plant::{EffectId, Kind, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A controller's cycle, s; the log has every fifth.
const CYCLE_S: f64 = 0.001;
const EVERY: usize = 5;

/// Noise of a good encoder's speed, rad/s.
const SPEED_NOISE: f64 = 0.1;

/// The bench with a command that nothing disturbs.
fn physics() -> Physics<'static> {
    let [angle, rate, ..] = NOISE;
    Physics {
        noise: [angle, rate, SPEED_NOISE, 0.0],
        ..Physics::base()
    }
}

/// A log of every fifth cycle, beginning with the cycle `first`.
fn logged(experiment: &Experiment, first: usize, seed: u64) -> Record {
    let dense = simulate(&physics(), experiment, &mut ChaCha8Rng::seed_from_u64(seed));
    let pick = |series: &[f64]| -> Vec<f64> {
        series.iter().copied().skip(first).step_by(EVERY).collect()
    };
    let outputs = Output::ALL.map(|output| dense.channel(output).map(|c| pick(&c.samples)));
    Record::new(
        &dense.name,
        dense.kind,
        pick(&dense.time_s),
        outputs,
        Some(pick(&dense.current_a)),
        false,
    )
}

/// Steps of the command every 1.5 s, at instants that lie at all places between the rows.
fn steps(t: f64) -> f64 {
    let level = ((t + 1e-9) / 1.501) as usize;
    [1.0, -0.6, 1.8, 0.2, -1.6, 1.2, -0.2][level % 7]
}

fn experiments(step_s: f64) -> [Experiment<'static>; 2] {
    [
        Experiment {
            step_s,
            ..spin_up("steps", &steps, 12.0)
        },
        Experiment {
            step_s,
            kind: Kind::Driven,
            ..spin_up("driven", &steps, 12.0)
        },
    ]
}

fn fit(record: Record, effects: &[EffectId]) -> identify::Identification {
    let known = [None, None, Some(VALUES[2]), Some(VALUES[3])];
    let problem =
        FitProblem::from_records(vec![record], known, Default::default()).expect("a record");
    let base = Model::base();
    let model = effects.iter().fold(base, |model, &one| model.with(one));
    identify(&problem, &model, None).expect("a fit")
}

#[test]
fn the_inertia_is_right_where_commands_changed_between_the_rows() {
    let (mut squares, mut count, mut blind) = (0.0, 0, 0.0f64);
    for seed in 0..10 {
        for experiment in experiments(CYCLE_S) {
            let record = logged(&experiment, 3, seed);
            let times = record.step_times.expect("the motion shows the instants");
            // The sixth step comes 2 cycles before its row, and so on: half an interval on average.
            assert!(
                (0.001..0.004).contains(&times.earlier_s),
                "seed {seed}: {times:?}"
            );
            assert_eq!(record.unknown_steps.len(), 7, "seed {seed}");
            let observations = record.observations() as f64;
            // A part of a log takes over what the whole one knows of its steps.
            let mut as_recorded = record.slice(0..record.len());
            as_recorded.unknown_steps.clear();
            let found = fit(record, &[]);
            let (value, std) = parameter(&found, "wheel_inertia");
            let off = (value - VALUES[1]) / std;
            assert!(off.abs() < 5.0, "seed {seed} {}: {off}", experiment.name);
            squares += off * off;
            count += 1;
            // What remains is noise, whose standard deviation the log tells to a tenth.
            let misfit = found.fit.minimum.cost / observations;
            assert!(
                (misfit - 1.0).abs() < 0.25,
                "seed {seed} {}: {misfit}",
                experiment.name
            );
            let found = fit(as_recorded, &[]);
            blind = blind.max(found.fit.minimum.cost / observations);
        }
    }
    let spread: f64 = squares / f64::from(count);
    // χ² of 20 values, whose mean is within 0.3 and 2.2 in all but one case in 10⁴.
    assert!((0.3..2.2).contains(&spread), "{spread}");
    // The test would show nothing if the instants did not matter.
    assert!(blind > 2.0, "{blind}");
}

#[test]
fn commands_that_change_with_the_rows_stay_as_recorded() {
    for seed in 0..20 {
        for experiment in experiments(CYCLE_S * EVERY as f64) {
            let record = simulate(
                &physics(),
                &experiment,
                &mut ChaCha8Rng::seed_from_u64(seed),
            );
            assert_eq!(record.step_times, None, "seed {seed} {}", experiment.name);
            assert!(record.unknown_steps.is_empty());
        }
    }
}

/// A delay makes all steps late alike. It is an effect of the motor, and stays one.
#[test]
fn a_delay_of_the_motor_is_found_beside_unknown_instants() {
    let late = |t: f64| steps(t - 0.02);
    for seed in 0..5 {
        let experiment = Experiment {
            step_s: CYCLE_S,
            ..spin_up("steps", &late, 12.0)
        };
        // The command was recorded 20 cycles before it acted.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let dense = simulate(&physics(), &experiment, &mut rng);
        let thin = |series: &[f64]| series.iter().copied().skip(3).step_by(EVERY).collect();
        let time_s: Vec<f64> = thin(&dense.time_s);
        let command: Vec<f64> = time_s.iter().map(|&t| steps(t)).collect();
        let speed = dense.channel(Output::WheelSpeed).map(|c| thin(&c.samples));
        let outputs = [None, None, speed];
        let record = Record::new("steps", Kind::SpinUp, time_s, outputs, Some(command), false);
        assert!(!record.unknown_steps.is_empty(), "seed {seed}");
        let found = fit(record, &[EffectId::InputDelay]);
        let (delay_s, std_s) = parameter(&found, "input_delay");
        // Seven instants that are unknown within 5 ms leave the delay open to 5 ms/√(12 · 7).
        assert!(std_s < 0.001, "seed {seed}: {std_s}");
        assert!(
            (delay_s - 0.02).abs() < 3.0 * std_s.max(0.000_55),
            "seed {seed}: {delay_s} ± {std_s}"
        );
    }
}

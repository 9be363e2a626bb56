//! The experiments of a bench of the exam, and their simulated logs.

use std::collections::VecDeque;
use std::ops::Range;

use plant::Kind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::true_motion::{Beginning, HiddenPush, TrueMotion};
use crate::truth::Truth;

/// Standard deviations of the sensors' noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelNoise {
    /// For angle (rad), rate (rad/s) and wheel speed (rad/s).
    pub std: [f64; 3],
}

/// The current during an experiment.
#[derive(Clone, Debug)]
pub enum DriveProgram {
    /// No current; the body is released.
    None,
    /// Current in A from 0.2 s on.
    Step(f64),
    /// A square wave of this current in A, one second each way.
    Square(f64),
    /// u = −K (α − π, α̇, φ̇), clipped, with pushes that no column records.
    Balanced {
        /// K in A/rad, A s/rad, A s/rad.
        gains: [f64; 3],
        /// Largest current in A.
        limit_a: f64,
        /// The pushes.
        pushes: Vec<HiddenPush>,
    },
}

/// The plan of one experiment.
#[derive(Clone, Debug)]
pub struct ExperimentPlan {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// Body angle at the start, rad.
    pub angle_rad: f64,
    /// Wheel speed at the start, rad/s.
    pub wheel_speed_rad_s: f64,
    /// The current.
    pub driving: DriveProgram,
    /// Length in s.
    pub duration_s: f64,
    /// Time between samples in s.
    pub sample_s: f64,
}

/// A log of the exam: the sensors' readings with and without noise.
#[derive(Clone, Debug)]
pub struct ExamLog {
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// Angle (rad), rate (rad/s) and wheel speed (rad/s) with noise.
    pub measured: [Vec<f64>; 3],
    /// The same readings without noise.
    pub clean: [Vec<f64>; 3],
    /// Commanded current, A.
    pub current_a: Vec<f64>,
}

/// A balancing body that is farther from upright than this, in rad, has fallen; the log ends there.
const FALLEN_RAD: f64 = 0.4;

/// Simulates the experiment on the true bench. `seed` determines the noise.
pub fn record(truth: &Truth, plan: &ExperimentPlan, noise: &ChannelNoise, seed: u64) -> ExamLog {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut motion = TrueMotion::new(truth, plan.kind, plan.angle_rad, plan.wheel_speed_rad_s);
    let delay_s = motion.delay_s();
    let samples = (plan.duration_s / plan.sample_s) as usize + 1;
    let whole = (delay_s / plan.sample_s).floor();
    let fraction_s = delay_s - whole * plan.sample_s;
    // The command that acts is `whole` samples old. For the first `fraction_s` of the interval, the command before it
    // still acts.
    let mut history: VecDeque<f64> = VecDeque::from(vec![f64::NAN; whole as usize + 2]);
    let mut log = ExamLog {
        time_s: vec![],
        measured: [vec![], vec![], vec![]],
        clean: [vec![], vec![], vec![]],
        current_a: vec![],
    };
    for k in 0..samples {
        let time_s = k as f64 * plan.sample_s;
        let clean = motion.reading();
        let measured: [f64; 3] = std::array::from_fn(|index| {
            let e: f64 = StandardNormal.sample(&mut rng);
            clean[index] + noise.std[index] * e
        });
        let command_a = match &plan.driving {
            DriveProgram::None => 0.0,
            DriveProgram::Step(current_a) => {
                if time_s < 0.2 - 1e-9 {
                    0.0
                } else {
                    *current_a
                }
            }
            DriveProgram::Square(current_a) => {
                if (time_s + 1e-9).rem_euclid(2.0) < 1.0 {
                    *current_a
                } else {
                    -current_a
                }
            }
            DriveProgram::Balanced { gains, limit_a, .. } => {
                let error = [measured[0] - std::f64::consts::PI, measured[1], measured[2]];
                let wanted: f64 = gains
                    .iter()
                    .zip(error)
                    .map(|(gain, error)| -gain * error)
                    .sum();
                wanted.clamp(-limit_a, *limit_a)
            }
        };
        if plan.kind == Kind::Balance && (clean[0] - std::f64::consts::PI).abs() > FALLEN_RAD {
            break;
        }
        log.time_s.push(time_s);
        log.current_a.push(command_a);
        for index in 0..3 {
            log.measured[index].push(measured[index]);
            log.clean[index].push(clean[index]);
        }
        // Before the log, the first command is held.
        for value in history.iter_mut().filter(|value| value.is_nan()) {
            *value = command_a;
        }
        history.push_front(command_a);
        history.truncate(whole as usize + 2);
        let (before_a, after_a) = (history[whole as usize + 1], history[whole as usize]);
        let pushes: &[HiddenPush] = match &plan.driving {
            DriveProgram::Balanced { pushes, .. } => pushes,
            _ => &[],
        };
        motion.advance(
            time_s + plan.sample_s,
            plan.sample_s,
            (before_a, time_s + fraction_s, after_a),
            pushes,
        );
    }
    log
}

/// Whether a log is long enough to be kept. A balance log is not if the body fell within two seconds.
pub fn is_usable(plan: &ExperimentPlan, log: &ExamLog) -> bool {
    log.time_s.len() as f64 * plan.sample_s > 2.0
        && log.clean.iter().flatten().all(|value| value.is_finite())
}

/// The readings (angle, rate, wheel speed) at each sample of a part of a log, under its recorded command, but from
/// another start or with other terms. They are only to be compared with another replay.
pub fn replay(
    truth: &Truth,
    kind: Kind,
    (time_s, current_a): (&[f64], &[f64]),
    samples: Range<usize>,
    from: &Beginning,
) -> Vec<[f64; 3]> {
    let mut motion = TrueMotion::of_differences(truth, kind, from);
    let delay_s = motion.delay_s();
    let mut readings = Vec::with_capacity(samples.len());
    for k in samples.clone() {
        readings.push(motion.reading());
        if k + 1 < samples.end {
            let sample_s = time_s[k + 1] - time_s[k];
            let whole = (delay_s / sample_s).floor();
            let fraction_s = delay_s - whole * sample_s;
            // Before the log, the first command is held.
            let command_a = |back: usize| current_a[k.saturating_sub(back)];
            let back = whole as usize;
            let commands = (command_a(back + 1), time_s[k] + fraction_s, command_a(back));
            motion.advance(time_s[k + 1], sample_s, commands, &[]);
        }
    }
    readings
}

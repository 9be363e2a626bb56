//! The experiment that would separate explanations that tie.
//!
//! Every experiment of a short list is simulated with both fitted models. Their separation is the root mean square
//! difference of their outputs in units of the sensors' noise. The experiment with the largest separation is
//! proposed.

use identify::{FitProblem, Output, Record};
use plant::{Current, Hold, Input, Kind, Plant, State};

use crate::candidate::Candidate;

/// An experiment that could be made.
struct Proposal {
    words: String,
    kind: Kind,
    angle_rad: f64,
    wheel_speed_rad_s: f64,
    current: fn(f64, f64) -> f64,
    amplitude_a: f64,
    duration_s: f64,
}

/// Sampling interval of the simulated logs, s.
const STEP_S: f64 = 0.004;
/// Noise standard deviation assumed for a sensor that the bench does not have: angle 1 mrad, rate 5 mrad/s,
/// wheel speed 0.5 rad/s. A modest encoder and gyroscope reach these values.
const USUAL_NOISE: [f64; 3] = [1e-3, 5e-3, 0.5];

fn proposals(problem: &FitProblem) -> Vec<Proposal> {
    let mut list = vec![];
    for degrees in [3.0, 10.0, 20.0, 50.0, 90.0] {
        list.push(Proposal {
            words: format!("a free swing released at {degrees}°"),
            kind: Kind::FreeSwing,
            angle_rad: f64::to_radians(degrees),
            wheel_speed_rad_s: 0.0,
            current: |_, _| 0.0,
            amplitude_a: 0.0,
            duration_s: 30.0,
        });
    }
    let largest = problem
        .records
        .iter()
        .flat_map(|record| &record.current_a)
        .fold(0.0, |largest: f64, current| largest.max(current.abs()));
    let largest = if largest > 0.0 { largest } else { 1.0 };
    for share in [-0.3, -0.6, -1.0, 0.3, 0.6, 1.0] {
        let current = share * largest;
        let direction = if share < 0.0 { "reversed " } else { "" };
        list.push(Proposal {
            words: format!("a {direction}spin-up at {current:.2} A with the body clamped"),
            kind: Kind::SpinUp,
            angle_rad: 0.0,
            wheel_speed_rad_s: 0.0,
            current: |_, amplitude| amplitude,
            amplitude_a: current,
            duration_s: 5.0,
        });
    }
    for speed in [150.0, -150.0] {
        list.push(Proposal {
            words: format!("a coast-down from {speed} rad/s to standstill"),
            kind: Kind::SpinUp,
            angle_rad: 0.0,
            wheel_speed_rad_s: speed,
            current: |_, _| 0.0,
            amplitude_a: 0.0,
            duration_s: 30.0,
        });
    }
    list.push(Proposal {
        words: format!(
            "a run with the body hanging free and a square wave of ±{:.2} A, 1 s each way",
            0.5 * largest
        ),
        kind: Kind::Driven,
        angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        current: |time, amplitude| {
            if time.rem_euclid(2.0) < 1.0 {
                amplitude
            } else {
                -amplitude
            }
        },
        amplitude_a: 0.5 * largest,
        duration_s: 20.0,
    });
    list
}

/// The largest root mean square difference between the outputs of two models, in units of noise, and the channel
/// in which it occurs.
fn separation(
    problem: &FitProblem,
    proposal: &Proposal,
    a: &Candidate,
    b: &Candidate,
) -> (f64, Output) {
    let steps = (proposal.duration_s / STEP_S) as usize;
    let time_s: Vec<f64> = (0..steps).map(|k| k as f64 * STEP_S).collect();
    let current: Vec<f64> = time_s
        .iter()
        .map(|&time| (proposal.current)(time, proposal.amplitude_a))
        .collect();
    let input = Input::new(&time_s, &current, Hold::Zero);
    let answer = |candidate: &Candidate| -> Vec<[f64; 3]> {
        let plant = Plant::new(&candidate.model, &candidate.minimum.values, proposal.kind);
        let start = State {
            angle_rad: proposal.angle_rad,
            wheel_speed_rad_s: proposal.wheel_speed_rad_s,
            ..State::rest()
        };
        let mut out = vec![];
        plant.run(
            start,
            &time_s,
            0..steps,
            Current::Recorded(&input),
            None,
            |_, reading, _| {
                out.push([
                    reading.angle_rad,
                    reading.rate_rad_s,
                    reading.wheel_speed_rad_s,
                ])
            },
        );
        out
    };
    let (first, second) = (answer(a), answer(b));
    let mut best = (0.0, Output::Angle);
    for (index, output) in Output::ALL.into_iter().enumerate() {
        let measured = match proposal.kind {
            Kind::FreeSwing => output != Output::WheelSpeed,
            Kind::SpinUp => output == Output::WheelSpeed,
            _ => true,
        };
        let has = |record: &&Record| record.channel(output).is_some();
        let Some(noise) = problem
            .records
            .iter()
            .find(has)
            .and_then(|record| record.channel(output))
            .map(|channel| channel.noise_std)
            .or(Some(USUAL_NOISE[index]))
            .filter(|_| measured)
        else {
            continue;
        };
        let square: f64 = first
            .iter()
            .zip(&second)
            .map(|(x, y)| ((x[index] - y[index]) / noise).powi(2))
            .sum::<f64>()
            / steps.max(1) as f64;
        if square.is_finite() && square.sqrt() > best.0 {
            best = (square.sqrt(), output);
        }
    }
    best
}

/// Proposes, in one sentence, the experiment with the largest separation of two explanations.
pub fn propose(problem: &FitProblem, a: &Candidate, b: &Candidate) -> String {
    let best = proposals(problem)
        .into_iter()
        .map(|proposal| (separation(problem, &proposal, a, b), proposal))
        .max_by(|x, y| x.0.0.total_cmp(&y.0.0));
    match best {
        Some(((size, output), proposal)) if size > 0.5 => format!(
            "Record {}: the {} predicted by the two explanations differs by {:.1} times the noise \
             of the sensor (rms).",
            proposal.words,
            output.name().replace('_', " "),
            size
        ),
        _ => "None of the usual experiments would separate the two explanations; a quieter sensor \
              is needed."
            .to_owned(),
    }
}

//! The experiment that would separate explanations that tie.
//!
//! Every experiment of a short list is simulated with both fitted models. Their separation is the root mean square
//! difference of their outputs in units of the sensors' noise. The experiment with the largest separation is
//! proposed.

use bench_files::numbers::significant;
use identify::{FitProblem, Output, Record};
use plant::{Current, Hold, Input, Kind, Model, Plant, State};

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

/// The experiment that settles a tie, as a recipe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    /// The experiment in few words.
    pub experiment: String,
    /// What to do, step by step; sentences.
    pub steps: Vec<String>,
    /// The channel that tells the explanations apart: angle, rate or wheel_speed.
    pub channel: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Root mean square difference of both answers, in units of the sensor's noise.
    pub difference_over_noise: f64,
    /// Times of the imagined log, s.
    pub time_s: Vec<f64>,
    /// What the channel would show by each explanation, in their order.
    pub answers: Vec<Vec<f64>>,
}

/// What is proposed where explanations tie.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NextExperiment {
    /// One sentence.
    pub sentence: String,
    /// The same in full, where an experiment of the list tells the explanations apart.
    pub recipe: Option<Recipe>,
}

/// Points of an imagined log that a recipe keeps.
const RECIPE_POINTS: usize = 600;

/// Sampling of the imagined logs in s.
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

/// One of the explanations: a model with its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Explanation<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its parameter vector, SI.
    pub values: &'a [f64],
}

impl Candidate {
    fn explanation(&self) -> Explanation<'_> {
        Explanation {
            model: &self.model,
            values: &self.minimum.values,
        }
    }
}

/// What a model's angle, rate and wheel speed would be in an imagined experiment, and the times.
fn imagined(proposal: &Proposal, one: Explanation) -> (Vec<f64>, Vec<[f64; 3]>) {
    let steps = (proposal.duration_s / STEP_S) as usize;
    let time_s: Vec<f64> = (0..steps).map(|k| k as f64 * STEP_S).collect();
    let current: Vec<f64> = time_s
        .iter()
        .map(|&time| (proposal.current)(time, proposal.amplitude_a))
        .collect();
    let input = Input::new(&time_s, &current, Hold::Zero);
    let plant = Plant::new(one.model, one.values, proposal.kind);
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
    (time_s, out)
}

/// Root mean square difference of two models' answers in units of noise, with the channel that
/// shows it best.
fn separation(
    problem: &FitProblem,
    proposal: &Proposal,
    a: Explanation,
    b: Explanation,
) -> (f64, Output) {
    let ((time_s, first), (_, second)) = (imagined(proposal, a), imagined(proposal, b));
    let steps = time_s.len();
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

/// The experiment that best separates the first two of the candidates that tie, as [`tell_apart`].
pub fn propose(problem: &FitProblem, ties: &[&Candidate]) -> NextExperiment {
    let ties: Vec<Explanation> = ties.iter().map(|tie| tie.explanation()).collect();
    tell_apart(problem, &ties)
}

/// The experiment that best separates the first two explanations, by how much, and what each of the explanations
/// would show in it. The noise of the sensors and the largest current are those of the problem's records.
pub fn tell_apart(problem: &FitProblem, ties: &[Explanation]) -> NextExperiment {
    let [a, b, ..] = *ties else {
        return NextExperiment::default();
    };
    let best = proposals(problem)
        .into_iter()
        .map(|proposal| (separation(problem, &proposal, a, b), proposal))
        .max_by(|x, y| x.0.0.total_cmp(&y.0.0));
    match best {
        Some(((size, output), proposal)) if size > 0.5 => NextExperiment {
            sentence: format!(
                "Record {}: the {} predicted by the two explanations differs by {} times the noise \
                 of the sensor (rms).",
                proposal.words,
                output.name().replace('_', " "),
                significant(size, 2)
            ),
            recipe: Some(recipe(&proposal, output, size, ties)),
        },
        _ => NextExperiment {
            sentence: "None of the usual experiments would separate the two explanations; a quieter sensor \
                       is needed."
                .to_owned(),
            recipe: None,
        },
    }
}

fn recipe(proposal: &Proposal, output: Output, size: f64, ties: &[Explanation]) -> Recipe {
    let index = Output::ALL
        .iter()
        .position(|one| *one == output)
        .unwrap_or(0);
    let all: Vec<_> = ties.iter().map(|&tie| imagined(proposal, tie)).collect();
    let time_s = all.first().map_or(vec![], |(time_s, _)| time_s.clone());
    let stride = time_s.len().div_ceil(RECIPE_POINTS).max(1);
    let thin = |values: Vec<f64>| values.into_iter().step_by(stride).collect();
    let channel = |readings: &[[f64; 3]]| thin(readings.iter().map(|one| one[index]).collect());
    Recipe {
        experiment: proposal.words.clone(),
        steps: proposal.steps(output),
        channel: output.name(),
        unit: if output == Output::Angle {
            "rad"
        } else {
            "rad/s"
        },
        difference_over_noise: size,
        answers: all.iter().map(|(_, readings)| channel(readings)).collect(),
        time_s: thin(time_s),
    }
}

impl Proposal {
    /// What to do at the bench.
    fn steps(&self, output: Output) -> Vec<String> {
        let mut steps: Vec<String> = match self.kind {
            Kind::FreeSwing => vec![
                "Lock the wheel to the body, and switch the motor off.".to_owned(),
                format!(
                    "Hold the body at {:.0}° from hanging, and let it go without a push.",
                    self.angle_rad.to_degrees()
                ),
            ],
            Kind::SpinUp if self.amplitude_a == 0.0 => vec![
                "Clamp the body, so that only the wheel turns.".to_owned(),
                format!(
                    "Bring the wheel to {:.0} rad/s, and switch the current off.",
                    self.wheel_speed_rad_s
                ),
            ],
            Kind::SpinUp => vec![
                "Clamp the body, so that only the wheel turns.".to_owned(),
                format!(
                    "With the wheel at rest, switch {:.2} A on and hold it.",
                    self.amplitude_a
                ),
            ],
            Kind::Driven | Kind::Balance => vec![
                "Leave the body hanging free and the wheel unlocked, both at rest.".to_owned(),
                format!(
                    "Command {:.2} A and {:.2} A in turn, one second each.",
                    self.amplitude_a, -self.amplitude_a
                ),
            ],
        };
        steps.push(format!(
            "Log the {} (and all other channels) for {:.0} s, every {:.0} ms or faster.",
            output.name().replace('_', " "),
            self.duration_s,
            1e3 * STEP_S
        ));
        steps.push(format!(
            "Add the log to bench.toml as kind = \"{}\", and diagnose again.",
            self.kind.name()
        ));
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recipe names times, sizes and the kind of its log.
    #[test]
    fn a_recipe_can_be_followed() {
        let proposal = Proposal {
            words: "a free swing released at 20°".to_owned(),
            kind: Kind::FreeSwing,
            angle_rad: 20_f64.to_radians(),
            wheel_speed_rad_s: 0.0,
            current: |_, _| 0.0,
            amplitude_a: 0.0,
            duration_s: 30.0,
        };
        let steps = proposal.steps(Output::Angle).join(" ");
        for part in [
            "Lock the wheel",
            "20°",
            "angle",
            "30 s",
            "4 ms",
            "kind = \"free-swing\"",
        ] {
            assert!(steps.contains(part), "{part}: {steps}");
        }
    }
}

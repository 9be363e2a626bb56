//! The draw: the bench that belongs to a seed.
//!
//! Seeds below a million hide the effects of the exam's first list. Higher seeds also hide those of a second list
//! (the lags and delays of sensors, among others), and from two million on those of a third. The suspects are the same
//! for all seeds. Below a million, forty seeds are a round. In every round each effect of the list is hidden once alone
//! and once in one of nine pairs,
//! each of the eight outsiders is hidden once, one effect is hidden and removed from the suspects, and four benches
//! hide nothing. Everything else (parameters, experiments, noise, sizes, shapes) is drawn from the seed alone, and
//! never depends on the diagnosis.
//!
//! The size of a hidden term is log-uniform from 1 to 30. It is the root mean square of its trace after the base model
//! has been refitted, in the channel with the largest trace, in units of that channel's noise. An outsider counts only
//! if no small combination of suspects explains its trace to less than three times the noise (`combinations`). It is
//! drawn again until it counts (with a size from 3 to 30).
//!
//! | file | job |
//! |---|---|
//! | `dice` | random draws that several files use |
//! | `question` | the question of a seed |
//! | `experiments` | the pendulum, its sensors, its experiments |
//! | `shape` | the shape of a hidden term |
//! | `size` | the logs, and the amplitude that gives a size |
//! | `combinations` | the part of a trace that no small combination of suspects can explain |

mod combinations;
mod dice;
mod experiments;
mod question;
mod shape;
mod size;

use identify::FitProblem;
use plant::{EffectId, Output, Role};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub use question::{Question, ROUND, SENSOR_SEEDS, WHEEL_SEEDS, effects, effects_of, question};

use self::combinations::left_by_combinations;
use self::dice::log_uniform;
use self::experiments::{ExperimentNeeds, draw_experiments, draw_noise, draw_truth};
use self::shape::{
    TermShape, is_plausible, pivot_to_wheel_m, place, shape_of_effect, shape_of_outsider,
};
use self::size::{base_fit, make, sized};
use crate::bench_plan::ChannelNoise;
use crate::truth::{StatedTorque, Truth};

/// An outsider counts if every small combination of suspects leaves at least this much of its trace, in units of noise.
pub const LEFT_BY_SUSPECTS: f64 = 3.0;
/// Range of the drawn sizes, in units of noise.
pub const SIZES: (f64, f64) = (1.0, 30.0);
/// Number of further draws for a bench if its hidden terms cannot reach the drawn size, or an
/// outsider does not count.
const REDRAWS: u64 = 20;

/// A bench of the exam, with its answer.
#[derive(Clone, Debug)]
pub struct ExamBench {
    /// The seed.
    pub seed: u64,
    /// The question.
    pub question: Question,
    /// The true parameters and hidden terms.
    pub truth: Truth,
    /// The logs, ready for the fit.
    pub problem: FitProblem,
    /// Size of each hidden term alone, in units of noise.
    pub sizes: Vec<f64>,
    /// Noise of the sensors.
    pub noise: ChannelNoise,
    /// The suspects.
    pub suspects: Vec<EffectId>,
}

/// The bench of a seed; `None` if no draw gave hidden terms of the drawn size.
pub fn draw(seed: u64) -> Option<ExamBench> {
    let question = question(seed);
    (0..REDRAWS).find_map(|attempt| attempt_draw(seed, attempt, question.clone(), None))
}

/// A bench with one hidden effect that is not part of this program; it is a suspect beside those of the library. The
/// exam needs its equation a second time. `None` if no draw of this seed has the drawn size.
pub fn draw_stated(seed: u64, effect: EffectId, torque: &StatedTorque) -> Option<ExamBench> {
    let question = Question::One(effect);
    (0..REDRAWS).find_map(|attempt| attempt_draw(seed, attempt, question.clone(), Some(torque)))
}

/// The equipment that a question needs.
fn needs(question: &Question) -> ExperimentNeeds {
    let hidden = question.hidden();
    let any = |holds: fn(EffectId) -> bool| hidden.iter().any(|&effect| holds(effect));
    ExperimentNeeds {
        // A delay of the angle is visible only beside a measured rate.
        rate: any(|effect| {
            let info = effect.info();
            info.senses == Some(Output::Rate)
                || (info.senses == Some(Output::Angle) && info.sensor_timing.is_some())
        }),
        motor: any(|effect| {
            let info = effect.info();
            matches!(info.role, Role::Wheel | Role::Motor)
                || info.senses == Some(Output::WheelSpeed)
        }) || matches!(question, Question::Outside(outsider) if outsider.needs_a_motor()),
    }
}

fn attempt_draw(
    seed: u64,
    attempt: u64,
    question: Question,
    stated: Option<&StatedTorque>,
) -> Option<ExamBench> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1009).wrapping_add(attempt));
    let base = draw_truth(&mut rng);
    let noise = draw_noise(&mut rng);
    let mut choice = draw_experiments(&mut rng, &base, needs(&question));
    if seed >= SENSOR_SEEDS {
        choice.measured.gravity = Some(9.81);
        choice.measured.pivot_to_wheel = Some(pivot_to_wheel_m(base.base[0]));
    }
    let place = place(&base, choice.top);
    let shapes: Vec<TermShape> = match &question {
        Question::Outside(outsider) => vec![shape_of_outsider(&mut rng, *outsider, &base)],
        _ => question
            .hidden()
            .iter()
            .map(|&effect| shape_of_effect(&mut rng, effect, &place, stated))
            .collect(),
    };
    let (smallest, largest) = SIZES;
    let smallest = if question.is_outside() {
        LEFT_BY_SUSPECTS
    } else {
        smallest
    };
    let mut terms = vec![];
    let mut sizes = vec![];
    for shape in &shapes {
        let wanted = log_uniform(&mut rng, smallest, largest);
        let (term, size) = sized(&base, &choice, &noise, seed, shape, wanted)?;
        if !is_plausible(&term) {
            return None;
        }
        terms.push(term);
        sizes.push(size);
    }
    let truth = base.with(terms);
    let made = make(&truth, &choice, &noise, seed)?;
    let mut suspects = effects();
    if stated.is_some() {
        suspects.extend(question.hidden());
    }
    if let Question::Withheld(effect) = &question {
        suspects.retain(|suspect| suspect != effect);
    }
    if question.is_outside() {
        let fit = base_fit(&made.clean, &truth)?;
        // Only effects of the seed's list count as rivals, so that effects which were added later do not change the
        // outsiders.
        let of_list = effects_of(seed);
        let mut rivals = suspects.clone();
        rivals.retain(|suspect| of_list.contains(suspect) || stated.is_some());
        if left_by_combinations(&made.clean, &fit, &rivals, &place)? < LEFT_BY_SUSPECTS {
            return None;
        }
    }
    Some(ExamBench {
        seed,
        question,
        truth,
        problem: made.noisy,
        sizes,
        noise,
        suspects,
    })
}

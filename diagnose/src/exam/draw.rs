//! The draw: which bench a seed stands for.
//!
//! Forty seeds make a round. In every round each of the 18 effects of the library is hidden once
//! alone and once in one of nine pairs, each of the eight outsiders is hidden once, one effect of
//! the library is hidden and taken out of the suspects, and four benches hide nothing. Everything
//! else (parameters, experiments, noise, sizes, shapes) is drawn from the seed alone.
//!
//! The size of a hidden term is log-uniform from 1 to 30: the root mean square of what is left of
//! its trace, after the base model is refitted, in the channel that it hits worst, in units of that
//! channel's noise. An outsider counts only if the best combination that the suspects offer still
//! leaves three times the noise, and is drawn again until it does (its size from 3 to 30).

use std::f64::consts::{PI, TAU};

use bench_files::Known;
use design::{Weights, discrete_regulator};
use identify::{Effort, Record, Setup, final_windows, identify, refit, traces};
use nalgebra::Vector3;
use plant::{EffectId, Kind, Model, linearise};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::bench_plan::{
    Driving, ExamLog, ExperimentPlan, SensorNoise, is_usable, record, with_hidden,
};
use super::true_motion::Push;
use super::truth::{Hidden, Outsider, Truth};
use crate::candidate::Candidate;
use crate::search::search;

/// Seeds in a round.
pub const ROUND: u64 = 40;
/// An outsider counts if this is left, in units of noise, by the best combination of suspects.
pub const LEFT_BY_THE_BEST: f64 = 3.0;
/// Sizes that are drawn, in units of noise.
pub const SIZES: (f64, f64) = (1.0, 30.0);
/// Times that a bench is drawn again if its hidden terms cannot have the size that was drawn, or an
/// outsider does not count.
const REDRAWS: u64 = 20;

/// What kind of question a bench asks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question {
    /// Nothing is hidden.
    Nothing,
    /// One effect.
    One(EffectId),
    /// Two effects.
    Two(EffectId, EffectId),
    /// A term of nobody's library.
    Outside(Outsider),
    /// An effect of the library that is no suspect.
    Withheld(EffectId),
}

/// A bench with its answer.
#[derive(Clone, Debug)]
pub struct ExamBench {
    /// The seed.
    pub seed: u64,
    /// What is asked.
    pub question: Question,
    /// The truth.
    pub truth: Truth,
    /// The logs, ready for the fit.
    pub setup: Setup,
    /// Size of each hidden term alone, in units of noise.
    pub sizes: Vec<f64>,
    /// Noise of the sensors.
    pub noise: SensorNoise,
    /// The suspects.
    pub suspects: Vec<EffectId>,
}

/// The effects that may hide: all of the library but the two of the base model.
pub fn effects() -> Vec<EffectId> {
    EffectId::ALL
        .iter()
        .copied()
        .filter(|&effect| !Model::base().has(effect))
        .collect()
}

/// Two effects can hide together if neither replaces the other.
fn go_together(a: EffectId, b: EffectId) -> bool {
    let model = Model::base().with(a).with(b);
    model.has(a) && model.has(b)
}

/// The question of a seed.
pub fn question(seed: u64) -> Question {
    let effects = effects();
    let slot = (seed % ROUND) as usize;
    let mut rng = ChaCha8Rng::seed_from_u64(0x0b5e_55ed ^ (seed / ROUND));
    if let Some(&effect) = effects.get(slot) {
        return Question::One(effect);
    }
    let slot = slot - effects.len();
    if let Some(&outsider) = Outsider::ALL.get(slot) {
        return Question::Outside(outsider);
    }
    match slot - Outsider::ALL.len() {
        0 => Question::Withheld(effects[(seed / ROUND) as usize % effects.len()]),
        1..=4 => Question::Nothing,
        pair => {
            // The matching of the round: shuffled until every pair can hide together.
            let mut order = effects;
            loop {
                for last in (1..order.len()).rev() {
                    order.swap(last, rng.random_range(0..=last));
                }
                if order.chunks(2).all(|two| go_together(two[0], two[1])) {
                    break;
                }
            }
            let at = 2 * ((pair - 5) % (order.len() / 2));
            Question::Two(order[at], order[at + 1])
        }
    }
}

fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    (rng.random_range(low.ln()..high.ln())).exp()
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// Base parameters of a bench of this family: a body of 0.4 to 2 times the thesis' inertia that
/// swings at 1 to 2.2 Hz.
fn draw_truth(rng: &mut ChaCha8Rng) -> Truth {
    let total = log_uniform(rng, 1e-3, 5e-3);
    let wheel = total * log_uniform(rng, 0.04, 0.12);
    let omega = TAU * rng.random_range(1.0..2.2);
    Truth {
        base: [
            total,
            wheel,
            total * omega * omega,
            rng.random_range(0.02..0.06),
        ],
        body_viscous: total * log_uniform(rng, 5e-3, 0.1),
        wheel_viscous: wheel * log_uniform(rng, 0.03, 0.3),
        hidden: vec![],
    }
}

fn draw_noise(rng: &mut ChaCha8Rng) -> SensorNoise {
    SensorNoise {
        std: [
            log_uniform(rng, 3e-4, 3e-3),
            log_uniform(rng, 1e-3, 1e-2),
            log_uniform(rng, 0.1, 1.0),
        ],
    }
}

/// Which experiments there are.
struct Choice {
    plans: Vec<ExperimentPlan>,
    has_rate: bool,
    known: [Option<f64>; 4],
    /// Largest current of a spin-up (A) and wheel speed that it reaches (rad/s).
    top: (f64, f64),
}

fn draw_experiments(rng: &mut ChaCha8Rng, truth: &Truth, hidden: &[EffectId]) -> Choice {
    let [_, wheel, gravity, torque] = truth.base;
    let roles: Vec<plant::Role> = hidden.iter().map(|effect| effect.info().role).collect();
    let needs_rate = hidden
        .iter()
        .any(|effect| matches!(effect, EffectId::GyroBias | EffectId::GyroScale));
    let needs_wheel = roles
        .iter()
        .any(|role| matches!(role, plant::Role::Wheel | plant::Role::Motor));
    let sample_s = [0.004, 0.005, 0.008][rng.random_range(0..3)];
    let mut plans = vec![];
    let small = rng.random_range(0.2..0.45);
    let large = rng.random_range(0.6..1.1);
    let swing = |angle_rad: f64| ExperimentPlan {
        name: format!("free swing {:.0} deg", angle_rad.to_degrees()),
        kind: Kind::FreeSwing,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving: Driving::None,
        duration_s: 16.0,
        sample_s,
    };
    plans.push(swing(large));
    if rng.random_bool(0.75) {
        plans.push(swing(small));
    }
    // A bench without a motor, one time in eight.
    let swings_only = rng.random_bool(0.125) && !needs_wheel;
    let speed = rng.random_range(300.0..700.0);
    let duration_s = 3.0;
    let decay = truth.wheel_viscous / wheel;
    let top_a = speed * truth.wheel_viscous / torque / (1.0 - (-decay * duration_s).exp());
    if !swings_only {
        let shares: &[f64] = match rng.random_range(0..4) {
            0 => &[0.3, 0.6, 1.0],
            _ => &[0.25, 0.5, 1.0, -0.7],
        };
        for &share in shares {
            plans.push(ExperimentPlan {
                name: format!("spin-up {:.3} A", share * top_a),
                kind: Kind::SpinUp,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.0,
                driving: Driving::Step(share * top_a),
                duration_s,
                sample_s,
            });
        }
        if rng.random_bool(0.6) {
            plans.push(ExperimentPlan {
                name: "coast-down".to_owned(),
                kind: Kind::SpinUp,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.5 * speed,
                driving: Driving::None,
                duration_s: 10.0,
                sample_s,
            });
        }
        let limit_a = gravity * rng.random_range(0.2..0.35) / torque;
        if rng.random_bool(0.7)
            && let Some(gains) = gains(truth, 0.004, limit_a)
        {
            let count = rng.random_range(0..=2);
            let pushes = (0..count)
                .map(|index| Push {
                    time_s: 2.0 + 3.0 * index as f64 + rng.random_range(0.0..1.0),
                    peak_nm: sign(rng) * gravity * rng.random_range(0.05..0.15),
                    width_s: 0.05,
                })
                .collect();
            plans.push(ExperimentPlan {
                name: "balance".to_owned(),
                kind: Kind::Balance,
                angle_rad: PI + rng.random_range(-0.06..0.06),
                wheel_speed_rad_s: 0.0,
                driving: Driving::Balanced {
                    gains,
                    limit_a,
                    pushes,
                },
                duration_s: 8.0,
                sample_s: 0.004,
            });
        }
        if rng.random_bool(0.25) {
            plans.push(ExperimentPlan {
                name: "driven".to_owned(),
                kind: Kind::Driven,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.0,
                driving: Driving::Square(0.3 * gravity / torque * 0.5),
                duration_s: 10.0,
                sample_s,
            });
        }
    }
    let mut known = [None; 4];
    match rng.random_range(0..5) {
        0 => known[plant::GRAVITY_TORQUE] = Some(gravity),
        _ => {
            known[plant::GRAVITY_TORQUE] = Some(gravity);
            known[plant::TORQUE_CONSTANT] = Some(torque);
        }
    }
    Choice {
        plans,
        has_rate: needs_rate || rng.random_bool(0.7),
        known,
        top: (top_a, speed),
    }
}

/// The thesis' weights, scaled to the current that this bench needs.
fn gains(truth: &Truth, sample_s: f64, limit_a: f64) -> Option<[f64; 3]> {
    let values = [
        truth.base[0],
        truth.base[1],
        truth.base[2],
        truth.base[3],
        truth.body_viscous,
        truth.wheel_viscous,
    ];
    let model = linearise(&Model::base(), &values, PI, None).ok()?;
    // The thesis' bench is limited to 2 A.
    let scale = (limit_a / 2.0).powi(2);
    let weights = Weights {
        state: Vector3::new(25.0, 0.5, 5e-4) * scale,
        current: 1.0,
    };
    let regulator = discrete_regulator(&model, &weights, sample_s).ok()?;
    Some([regulator.gains[0], regulator.gains[1], regulator.gains[2]])
}

/// A hidden term whose amplitude is still open: the numbers for an amplitude `s`, and a first guess
/// for s.
struct Shape {
    make: Box<dyn Fn(f64) -> Hidden + Send>,
    guess: f64,
}

fn shape_of_effect(
    rng: &mut ChaCha8Rng,
    effect: EffectId,
    truth: &Truth,
    top: (f64, f64),
) -> Shape {
    let [total, wheel, gravity, torque] = truth.base;
    let (top_a, top_speed) = top;
    let side = sign(rng);
    let shape = rng.random_range(0.0..1.0f64);
    let between = |low: f64, high: f64| low * (high / low).powf(shape);
    let second = rng.random_range(-1.0..1.0f64);
    type Make = Box<dyn Fn(f64) -> [f64; 3] + Send>;
    let one = |factor: f64| -> Make { Box::new(move |s| [factor * s, 0.0, 0.0]) };
    let (make, guess): (Make, f64) = match effect {
        EffectId::BodyCoulombFriction => (one(gravity), 1e-3),
        EffectId::BodyStribeckFriction => {
            let (ratio, speed) = (2.0 + second, between(0.05, 1.0));
            let make = move |s: f64| [gravity * s, gravity * s * ratio, speed];
            (Box::new(make), 1e-3)
        }
        EffectId::BodyPreslidingFriction => {
            let way = between(3e-3, 0.05);
            (
                Box::new(move |s: f64| [gravity * s, gravity * s / way, 0.0]),
                1e-3,
            )
        }
        EffectId::BodyQuadraticDrag => (one(total), 1e-2),
        EffectId::BodyCableSpring => (Box::new(move |s: f64| [gravity * s, second, 0.0]), 1e-2),
        EffectId::BodySofteningSpring => (one(gravity), 1e-2),
        EffectId::WheelCoulombFriction => (one(torque * top_a), 1e-2),
        EffectId::WheelQuadraticDrag => (one(torque * top_a / (top_speed * top_speed)), 1e-2),
        EffectId::WheelCogging => {
            let orders = [1.0, 2.0, 4.0, 6.0, 7.0, 8.0, 12.0, 16.0, 24.0, 36.0];
            let order = orders[(shape * orders.len() as f64) as usize];
            let make = move |s: f64| [torque * top_a * s, order, PI * second];
            (Box::new(make), 0.05)
        }
        EffectId::InputDelay => (one(1.0), 5e-3),
        EffectId::MotorLag => (one(1.0), 5e-3),
        EffectId::BackEmfLimit => {
            // The limit sets in at the share 1/(1 + s) of the highest speed at the highest current.
            let resistance = between(0.3, 3.0) * torque * top_speed / top_a.max(1e-9);
            let make = move |s: f64| {
                let speed = top_speed / (1.0 + s);
                [resistance * top_a + torque * speed, resistance, 0.0]
            };
            (Box::new(make), 0.1)
        }
        EffectId::MotorDeadZone => (one(top_a), 1e-2),
        EffectId::CurrentOffset => (one(side * top_a), 1e-2),
        EffectId::MotorSaturation => (
            // To lowest order the torque is short by (i/i_s)²/2.
            Box::new(move |s: f64| [top_a / s.sqrt(), 0.0, 0.0]),
            0.05,
        ),
        EffectId::AngleOffset => (one(side), 5e-3),
        EffectId::GyroScale => (one(side), 1e-2),
        EffectId::GyroBias => (one(side), 1e-2),
        EffectId::BodyViscousFriction | EffectId::WheelViscousFriction => (one(wheel), 1e-2),
    };
    Shape {
        make: Box::new(move |s| Hidden::Library(effect, make(s))),
        guess,
    }
}

fn shape_of_outsider(rng: &mut ChaCha8Rng, outsider: Outsider, truth: &Truth) -> Shape {
    let gravity = truth.base[2];
    let uniform = |rng: &mut ChaCha8Rng, low: f64, high: f64| rng.random_range(low..high);
    let (factor, p1, p2, guess) = match outsider {
        Outsider::MagnetNearAnAngle => {
            let place = sign(rng) * uniform(rng, 0.05, 0.3);
            (gravity, place, uniform(rng, 0.03, 0.08), 1e-2)
        }
        Outsider::FrictionThatGrows => (gravity, 0.0, 0.0, 1e-2),
        Outsider::RubbingBeyondAnAngle => (gravity, uniform(rng, 0.1, 0.3), 0.0, 1e-2),
        Outsider::VibrationOfTheBase => (
            gravity,
            TAU * uniform(rng, 2.5, 7.0),
            uniform(rng, 0.0, TAU),
            1e-2,
        ),
        Outsider::SoftStop => (gravity, uniform(rng, 0.1, 0.3), 0.0, 1e-2),
        Outsider::WheelDragThatGrows => (truth.wheel_viscous, 0.0, 0.0, 0.1),
        Outsider::SupplyThatSags => (1.0, uniform(rng, 0.5, 2.0), 0.0, 1e-2),
        Outsider::UnevenEncoder => (1.0, uniform(rng, 0.0, TAU), 0.0, 1e-3),
    };
    Shape {
        make: Box::new(move |s| Hidden::Outsider(outsider, [factor * s, p1, p2])),
        guess,
    }
}

/// Whether the numbers of a library effect lie where its description says that they lie on benches
/// of this size. The knee of a saturation goes with the currents of the bench, whatever they are.
fn is_plausible(hidden: &Hidden) -> bool {
    match hidden {
        Hidden::Library(EffectId::MotorSaturation, _) | Hidden::Outsider(..) => true,
        Hidden::Library(effect, p) => {
            effect.info().parameters.iter().zip(p).all(|(info, value)| {
                let (low, high) = info.plausible;
                // The size that is drawn decides how small an amplitude is.
                value.abs() <= high.abs().max(low.abs())
            })
        }
    }
}

/// A seed's logs as the fit sees them, with the noise that was really put in and without it.
struct Made {
    /// What the exam hands out.
    noisy: Setup,
    /// The same without noise; the channels keep the noise as their scale.
    clean: Setup,
}

fn make(truth: &Truth, choice: &Choice, noise: &SensorNoise, seed: u64) -> Option<Made> {
    let mut records = vec![];
    let mut logs: Vec<ExamLog> = vec![];
    for (index, plan) in choice.plans.iter().enumerate() {
        let log = record(
            truth,
            plan,
            noise,
            seed.wrapping_mul(64).wrapping_add(index as u64),
        );
        if !is_usable(plan, &log) {
            continue;
        }
        let outputs = [
            Some(log.measured[0].clone()),
            choice.has_rate.then(|| log.measured[1].clone()),
            Some(log.measured[2].clone()),
        ];
        records.push(Record::new(
            &plan.name,
            plan.kind,
            log.time_s.clone(),
            outputs,
            Some(log.current_a.clone()),
            false,
        ));
        logs.push(log);
    }
    let noisy = Setup::from_records(records, choice.known, Known::default()).ok()?;
    let mut clean = noisy.clone();
    for (record, log) in clean.records.iter_mut().zip(&logs) {
        for channel in &mut record.channels {
            let index = channel.output as usize;
            channel.samples = log.clean[index].clone();
            channel.noise_std = noise.std[index];
            channel.quantum = None;
        }
    }
    Some(Made { noisy, clean })
}

/// Largest root mean square error over all series in units of noise.
fn worst(records: &[&Record], traces: &[Vec<identify::Trace>]) -> f64 {
    records
        .iter()
        .zip(traces)
        .flat_map(|(record, traces)| {
            record
                .channels
                .iter()
                .zip(traces)
                .map(|(channel, trace)| trace.rmse / channel.noise_std)
        })
        .fold(0.0, f64::max)
}

/// What is left of the hidden terms' trace after the base model is refitted, in units of noise.
fn size_of(clean: &Setup, truth: &Truth) -> Option<f64> {
    let records = clean.all_records();
    let model = Model::base();
    let [a, b, c, d] = truth.base;
    let mut values = vec![a, b, c, d, truth.body_viscous, truth.wheel_viscous];
    for (value, known) in values.iter_mut().zip(clean.known) {
        *value = known.unwrap_or(*value);
    }
    let windows = records
        .iter()
        .map(|record| final_windows(record, &values))
        .collect();
    let effort = Effort {
        evaluations: 15,
        tolerance: 1e-3,
        ..Effort::FULL
    };
    let minimum = refit(
        &records,
        &model,
        values,
        windows,
        &clean.free(&model),
        effort,
    );
    if !minimum.cost.is_finite() {
        return None;
    }
    let traces: Vec<Vec<identify::Trace>> = records
        .iter()
        .zip(&minimum.windows)
        .map(|(record, windows)| traces(record, windows, &model, &minimum.values))
        .collect();
    Some(worst(&records, &traces))
}

/// The amplitude at which a term has the size that was drawn: a secant in the logarithms.
fn sized(
    truth: &Truth,
    choice: &Choice,
    noise: &SensorNoise,
    seed: u64,
    shape: &Shape,
    wanted: f64,
) -> Option<(Hidden, f64)> {
    const ROUNDS: usize = 8;
    // Beyond this from the guess no bench is meant any more; a lag of nanoseconds would take the
    // simulation hours.
    const FARTHEST: f64 = 1e4;
    let mut s = shape.guess;
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..ROUNDS {
        if (s / shape.guess).ln().abs() > FARTHEST.ln() {
            return None;
        }
        let hidden = (shape.make)(s);
        let there = with_hidden(truth, vec![hidden]);
        let found = make(&there, choice, noise, seed).and_then(|made| size_of(&made.clean, &there));
        let Some(found) = found.filter(|found| found.is_finite() && *found > 0.0) else {
            s *= 0.1;
            continue;
        };
        if (found / wanted).ln().abs() < 0.1 {
            return Some((hidden, found));
        }
        let slope = match before {
            Some((s0, found0)) if (s / s0).ln().abs() > 1e-6 => {
                ((found / found0).ln() / (s / s0).ln()).clamp(0.5, 3.0)
            }
            _ => 1.0,
        };
        before = Some((s, found));
        s *= ((wanted / found).ln() / slope).clamp(-4.0, 4.0).exp();
    }
    None
}

/// What the best combination of suspects leaves of an outsider, in units of noise: the search of
/// the diagnosis on the logs without noise, over everything that it tried.
fn left_by_the_best(clean: &Setup, suspects: &[EffectId]) -> Option<f64> {
    let base = Model::base();
    let found = identify(clean, &base, None).ok()?;
    let records = clean.all_records();
    let start = Candidate::new(clean, &records, vec![], base, found.fit.minimum, None);
    let tried = search(clean, start, suspects, &|_| {});
    tried
        .pool
        .iter()
        .map(|candidate| worst(&records, &candidate.traces))
        .min_by(f64::total_cmp)
}

/// The bench of a seed; `None` if no draw gave hidden terms of the size that was wanted.
pub fn draw(seed: u64) -> Option<ExamBench> {
    (0..REDRAWS).find_map(|attempt| attempt_draw(seed, attempt))
}

fn attempt_draw(seed: u64, attempt: u64) -> Option<ExamBench> {
    let question = question(seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1009).wrapping_add(attempt));
    let base = draw_truth(&mut rng);
    let noise = draw_noise(&mut rng);
    let hidden: Vec<EffectId> = match &question {
        Question::Nothing => vec![],
        Question::One(effect) | Question::Withheld(effect) => vec![*effect],
        Question::Two(a, b) => vec![*a, *b],
        // The outsiders of the wheel need its experiments as the wheel's drag does.
        Question::Outside(Outsider::WheelDragThatGrows | Outsider::SupplyThatSags) => {
            vec![EffectId::WheelQuadraticDrag]
        }
        Question::Outside(_) => vec![],
    };
    let choice = draw_experiments(&mut rng, &base, &hidden);
    let shapes: Vec<Shape> = match &question {
        Question::Outside(outsider) => vec![shape_of_outsider(&mut rng, *outsider, &base)],
        _ => hidden
            .iter()
            .map(|&effect| shape_of_effect(&mut rng, effect, &base, choice.top))
            .collect(),
    };
    let outside = matches!(question, Question::Outside(_) | Question::Withheld(_));
    let (smallest, largest) = SIZES;
    let smallest = if outside { LEFT_BY_THE_BEST } else { smallest };
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
    let truth = with_hidden(&base, terms);
    let made = make(&truth, &choice, &noise, seed)?;
    let withheld: Vec<EffectId> = match &question {
        Question::Withheld(effect) => vec![*effect],
        _ => vec![],
    };
    let suspects: Vec<EffectId> = effects()
        .into_iter()
        .filter(|effect| !withheld.contains(effect))
        .collect();
    if outside && left_by_the_best(&made.clean, &suspects)? < LEFT_BY_THE_BEST {
        return None;
    }
    Some(ExamBench {
        seed,
        question,
        truth,
        setup: made.noisy,
        sizes,
        noise,
        suspects,
    })
}

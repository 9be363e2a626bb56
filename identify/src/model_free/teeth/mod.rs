//! Teeth of the motor, found in dense logs without a model of the bench: the order of a torque that repeats with the
//! wheel's angle, and the wheel's angle relative to the teeth.
//!
//! A torque −a sin(nφ + ψ) on a wheel of inertia j changes its speed by −(a/j) ∫ sin(nφ + ψ) dt. Over a quarter of a
//! second everything else that acts on a wheel is nearly a parabola in its speed, beside the charge that flowed. What
//! these two leave is projected on ∫cos nφ dt and ∫sin nφ dt, with φ as measured. This is linear, and it holds also where
//! the teeth change the motion of the wheel a lot.
//!
//! The measured angle is the integral of a noisy speed and walks away from the true one: by a hundredth of a radian in a
//! quarter of a second, by more than a tooth over a log. The phase is therefore followed from piece to piece as a hidden
//! Markov chain whose step is that walk (Rabiner, Proc. IEEE 77 (1989)). This tells neighbouring orders apart: the phase
//! of a wrong order runs away with the wheel.
//!
//! The evidence is a likelihood ratio against "no teeth", averaged over all orders and a grid of amplitudes. Where there
//! are no teeth, its expectation is one; so it exceeds 1/p with a probability of at most p (Markov's inequality).
//!
//! | file | job |
//! |---|---|
//! | `piece` | a quarter of a second, projected on teeth of a given order |
//! | `chain` | the phase from piece to piece, and the evidence for an order |

mod chain;
mod piece;

use std::f64::consts::{PI, TAU};

use parallel::parallel_map;

use self::chain::{Belief, Chain, log_sum_exp};
use self::piece::{HIGHEST_ORDER, Piece};
use crate::records::{BALANCE_WINDOW_S, Output, Record, blocks, means};

/// Shortest interval between samples, s, that a search uses; denser logs are averaged to it. Order 60 is then seen up to
/// 30 rad/s; a faster wheel has a ripple below the noise of its sensor.
const SHORTEST_STEP_S: f64 = 1e-3;
/// Logarithm of the evidence from which on teeth are found: by chance alone in at most one bench of 10⁵.
const FOUND: f64 = 11.5;
/// Logarithm of the odds of the order against all others: one wrong order in a thousand.
const KNOWN_ORDER: f64 = 6.9;
/// As [`KNOWN_ORDER`], where samples are so far apart that a high order is taken for a low one while the wheel turns
/// evenly. Judgement: such a mistake reached 3 in simulated logs, and orders truly there exceeded 100.
const KNOWN_AMONG_ALIASES: f64 = 20.0;
/// Walk of a measured wheel angle, rad²/s: it has none, but mounting and rounding are not perfect.
const WALK_OF_MEASURED: f64 = 1e-6;

/// What a log says of its wheel.
struct WheelLog {
    time_s: Vec<f64>,
    /// Speed against the stand, where the body's rate is measured, too; else against the body. rad/s.
    speed_rad_s: Vec<f64>,
    noise_std: f64,
    angle_rad: Vec<f64>,
    /// Variance by which the error of the angle grows per second, rad²/s.
    walk: f64,
    charge: Option<Vec<f64>>,
}

impl WheelLog {
    /// `None` for a log without the speed of a moving wheel.
    fn of(record: &Record) -> Option<WheelLog> {
        let wheel = record.channel(Output::WheelSpeed)?;
        let n = record.len();
        if record.kind == plant::Kind::FreeSwing || n < 2 {
            return None;
        }
        let interval_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
        let rate = record.channel(Output::Rate);
        let speed: Vec<f64> = match rate {
            Some(rate) => {
                let pairs = wheel.samples.iter().zip(&rate.samples);
                pairs.map(|(wheel, body)| wheel + body).collect()
            }
            None => wheel.samples.clone(),
        };
        let noise_std = rate.map_or(wheel.noise_std, |rate| {
            wheel.noise_std.hypot(rate.noise_std)
        });
        let block = ((SHORTEST_STEP_S / interval_s) as usize).max(1);
        let blocks = blocks(n, block);
        let is_measured = record.wheel_angle_noise_rad().is_some();
        Some(WheelLog {
            time_s: means(&record.time_s, &blocks),
            speed_rad_s: means(&speed, &blocks),
            noise_std: noise_std / (block as f64).sqrt(),
            angle_rad: means(record.wheel_angles(), &blocks),
            walk: if is_measured {
                WALK_OF_MEASURED
            } else {
                wheel.noise_std.powi(2) * interval_s
            },
            charge: record.charge().map(|charge| means(&charge, &blocks)),
        })
    }
}

/// Teeth that logs show.
#[derive(Clone, Debug)]
pub(crate) struct Teeth {
    /// Number of teeth in one turn.
    pub(crate) order: f64,
    /// Torque over the wheel's inertia, rad/s².
    pub(crate) per_inertia: f64,
    /// Phase ψ of the torque −a sin(nφ + ψ), rad, where the first log begins that shows teeth. Every log begins at a phase
    /// of its own; [`Teeth::correction`] brings its angles to this one.
    pub(crate) phase_rad: f64,
    /// Logarithm of the evidence.
    pub(crate) log_evidence: f64,
    /// For every log, the places where its phase is known, in the order of time.
    places: Vec<Vec<Place>>,
    /// For every log, the variance per second of the walk of its angle, rad²/s.
    walks: Vec<f64>,
}

/// The phase of the teeth at one time of a log.
#[derive(Clone, Copy, Debug)]
struct Place {
    time_s: f64,
    phase_rad: f64,
    std_rad: f64,
    expected: f64,
}

/// By how much the wheel's angle of a log differs from the measured one, up to whole teeth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correction {
    /// To be added to the measured angle, rad.
    pub(crate) angle_rad: f64,
    /// Standard deviation of the corrected angle, rad.
    pub(crate) std_rad: f64,
}

impl Teeth {
    /// The correction of a log's angle at one time; `None` for a log that shows no teeth.
    pub(crate) fn correction(&self, log: usize, time_s: f64) -> Option<Correction> {
        let places = self.places.get(log)?;
        let next = places.partition_point(|place| place.time_s < time_s);
        let before = next.checked_sub(1).map(|at| places[at]);
        let (one, other) = match (before, places.get(next)) {
            (Some(one), Some(&other)) => (one, other),
            (Some(only), None) => (only, only),
            (None, Some(&only)) => (only, only),
            (None, None) => return None,
        };
        let away = |place: &Place| (place.time_s - time_s).abs();
        let span_s = other.time_s - one.time_s;
        let share = if span_s > 0.0 {
            (time_s - one.time_s) / span_s
        } else {
            0.0
        };
        let phase = one.phase_rad + share * wrapped(other.phase_rad - one.phase_rad);
        let walk = self.walks[log];
        let variance = |place: &Place| (place.std_rad / self.order).powi(2) + walk * away(place);
        Some(Correction {
            angle_rad: wrapped(phase - self.phase_rad) / self.order,
            std_rad: variance(&one).min(variance(&other)).sqrt(),
        })
    }

    /// The gain in log likelihood that these teeth promise in a stretch of a log.
    pub(crate) fn expected(&self, log: usize, from_s: f64, until_s: f64) -> f64 {
        let places = self.places.get(log).into_iter().flatten();
        let inside = places.filter(|place| (from_s..=until_s).contains(&place.time_s));
        inside.map(|place| place.expected).sum()
    }
}

/// The same angle within ±π.
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - TAU * (angle_rad / TAU).round()
}

/// Finds teeth in these logs; `None` if they show none, or not of which order.
///
/// First only pieces count in which no order is taken for another; then, if these do not suffice, all.
pub(crate) fn find_teeth(records: &[Record]) -> Option<Teeth> {
    let logs: Vec<Option<WheelLog>> = parallel_map(records, WheelLog::of);
    let pieces_of = logs
        .iter()
        .enumerate()
        .filter_map(|(index, log)| Some((index, log.as_ref()?)));
    let pieces: Vec<Piece> = parallel_map(pieces_of, |(index, log)| pieces(index, log))
        .into_iter()
        .flatten()
        .collect();
    [(true, KNOWN_ORDER), (false, KNOWN_AMONG_ALIASES)]
        .into_iter()
        .find_map(|(alone, odds)| {
            let orders: Vec<(f64, f64)> = parallel_map(1..=HIGHEST_ORDER, |order| {
                Chain::new(&pieces, order as f64, alone).evidence()
            });
            let all: Vec<f64> = orders.iter().map(|one| one.0).collect();
            let best = (0..HIGHEST_ORDER).max_by(|&x, &y| all[x].total_cmp(&all[y]))?;
            let mut others = all.clone();
            others.remove(best);
            let log_evidence = log_sum_exp(&all) - (HIGHEST_ORDER as f64).ln();
            let is_known = all[best] - log_sum_exp(&others) > odds;
            let order = (best + 1) as f64;
            (log_evidence > FOUND && is_known).then(|| {
                let chain = Chain::new(&pieces, order, alone);
                followed(&chain, &logs, order, orders[best].1, log_evidence)
            })
        })
}

/// The log in pieces of a quarter of a second.
fn pieces(index: usize, log: &WheelLog) -> Vec<Piece> {
    let mut pieces = vec![];
    let mut start = 0;
    while start < log.time_s.len() {
        let limit = log.time_s[start] + BALANCE_WINDOW_S;
        let end = start + log.time_s[start..].partition_point(|&time| time < limit);
        // A log whose times are not finite ends here.
        let end = end.max(start + 1);
        pieces.extend(Piece::of(log, index, start..end));
        start = end;
    }
    pieces
}

/// The teeth of an order, with their phase in every piece.
fn followed(
    chain: &Chain,
    logs: &[Option<WheelLog>],
    order: f64,
    amplitude: f64,
    log_evidence: f64,
) -> Teeth {
    let (per_inertia, beliefs) = chain.refined(amplitude);
    let mut places: Vec<Vec<Place>> = vec![vec![]; logs.len()];
    for (window, belief) in chain.windows.iter().zip(&beliefs) {
        let (phase_rad, std_rad) = mean_phase(belief, &chain.phases);
        places[window.log].push(Place {
            time_s: window.centre_s,
            phase_rad,
            std_rad,
            expected: per_inertia * per_inertia * window.expected(),
        });
    }
    let first = places.iter().find_map(|places| places.first());
    Teeth {
        order,
        per_inertia,
        phase_rad: first.map_or(0.0, |first| first.phase_rad),
        log_evidence,
        walks: logs
            .iter()
            .map(|log| log.as_ref().map_or(0.0, |log| log.walk))
            .collect(),
        places,
    }
}

/// Circular mean and standard deviation, rad (Mardia & Jupp, Directional Statistics (2000), ch. 2).
fn mean_phase(belief: &Belief, phases: &[(f64, f64)]) -> (f64, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    for (weight, (sin, cos)) in belief.iter().zip(phases) {
        x += weight * cos;
        y += weight * sin;
    }
    let length = x.hypot(y).clamp(f64::MIN_POSITIVE, 1.0);
    // The phases of the chain are so far apart that less is not known.
    let least = TAU / phases.len() as f64 / 12f64.sqrt();
    let std_rad = (-2.0 * length.ln()).sqrt();
    (y.atan2(x), std_rad.clamp(least, PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::Kind;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const INERTIA: f64 = 1.36e-4;
    const NOISE: f64 = 0.6;

    /// A wheel under a current that changes its sign every second, with teeth of this torque in N m, order and phase, and
    /// dry friction; its speed with noise, at `step_s`. Midpoint rule with steps of at most 0.2 ms.
    fn log(teeth: [f64; 3], current_a: f64, step_s: f64, dice: &mut ChaCha8Rng) -> Record {
        let [torque, order, phase] = teeth;
        let parts = (step_s / 2e-4).ceil().max(1.0);
        let part_s = step_s / parts;
        let (mut speed, mut angle) = (0.0f64, 0.0f64);
        let (mut times, mut speeds, mut currents) = (vec![], vec![], vec![]);
        for k in 0..40_000 {
            let time_s = f64::from(k) * step_s;
            let sign = if (time_s as usize).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            let current = sign * current_a;
            let noise: f64 = dice.sample(StandardNormal);
            times.push(time_s);
            speeds.push(speed + NOISE * noise);
            currents.push(current);
            let acceleration = |speed: f64, angle: f64| {
                let friction = 1.75e-5 * speed + 3e-4 * (speed / 0.5).tanh();
                (0.0335 * current - friction - torque * (order * angle + phase).sin()) / INERTIA
            };
            for _ in 0..parts as usize {
                let first = acceleration(speed, angle);
                let half = 0.5 * part_s;
                let (middle, there) = (speed + half * first, angle + half * speed);
                speed += part_s * acceleration(middle, there);
                angle += part_s * middle;
            }
        }
        let outputs = [None, None, Some(speeds)];
        Record::new("x", Kind::SpinUp, times, outputs, Some(currents), false)
    }

    fn logs(teeth: [f64; 3], step_s: f64, seed: u64) -> Vec<Record> {
        let mut dice = ChaCha8Rng::seed_from_u64(seed);
        let currents = [0.12, 0.3, 0.6];
        currents
            .map(|current| log(teeth, current, step_s, &mut dice))
            .into()
    }

    /// Orders from 3 to 51, torques and phases drawn by lot; the torque comes within a tenth. The samples are close enough
    /// to follow the teeth of a wheel of 60 rad/s: with fewer, the teeth of a high order pass between two samples.
    #[test]
    fn orders_are_found_and_their_torque() {
        let mut dice = ChaCha8Rng::seed_from_u64(17);
        for seed in 0..8 {
            let order = f64::from(dice.random_range(3..52));
            let teeth = [
                2e-3 + 1e-3 * dice.random::<f64>(),
                order,
                TAU * dice.random::<f64>(),
            ];
            // Half a tooth in a sample: order · speed · step = π.
            let widest_s = PI / (order * 60.0);
            let steps_s = [2e-3, 1e-3, 5e-4].into_iter();
            let step_s = steps_s.filter(|step| *step <= widest_s).fold(0.0, f64::max);
            let found = find_teeth(&logs(teeth, step_s, seed as u64));
            let found = found.unwrap_or_else(|| panic!("seed {seed}, {teeth:?}, {step_s}"));
            assert_eq!(found.order, order, "seed {seed}");
            let torque = found.per_inertia * INERTIA;
            assert!(
                (torque / teeth[0] - 1.0).abs() < 0.1,
                "seed {seed}: {torque} {teeth:?}"
            );
        }
    }

    /// The corrected angle is the true one up to whole teeth, also where the log is long.
    #[test]
    fn the_angle_is_corrected_to_the_teeth() {
        let teeth = [2.5e-3, 12.0, 0.7];
        let mut dice = ChaCha8Rng::seed_from_u64(3);
        let record = log(teeth, 0.12, 1e-3, &mut dice);
        let found = find_teeth(std::slice::from_ref(&record)).expect("teeth");
        let mut seen = 0;
        for place in &found.places[0] {
            let correction = found.correction(0, place.time_s).expect("a log with teeth");
            assert!(correction.angle_rad.abs() <= PI / found.order);
            if place.expected > 20.0 {
                assert!(correction.std_rad * found.order < 0.5, "{correction:?}");
                seen += 1;
            }
        }
        assert!(seen > 0, "no piece of the log shows its teeth well");
        // The first teeth are seen some seconds after the log begins; until then the measured angle has walked.
        let first = &found.places[0][0];
        let walked_rad = found.order * (found.walks[0] * first.time_s).sqrt();
        let (off, std) = (
            wrapped(found.phase_rad - teeth[2]),
            walked_rad.hypot(first.std_rad),
        );
        assert!(
            off.abs() < 4.0 * std,
            "off by {off}, standard deviation {std}"
        );
    }

    #[test]
    fn no_teeth_are_found_where_there_are_none() {
        for seed in 0..6 {
            let step_s = [1e-3, 2e-3][seed % 2];
            let found = find_teeth(&logs([0.0, 1.0, 0.0], step_s, seed as u64));
            assert!(found.is_none(), "seed {seed}: {found:?}");
        }
    }
}

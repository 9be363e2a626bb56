//! A start for the fit of a user's own effect, of which only the formula is known.
//!
//! A torque that acts in a narrow range of angles is not found by a descent that begins elsewhere, least of all over
//! whole logs. But the torque that a model lacks follows without simulation
//! ([`crate::residuals::residual_torque`]), and for a given shape it is linear in the effect's amplitude. Shapes
//! are therefore drawn over their range with low discrepancy (Weyl's sequence; Niederreiter, *Random Number Generation
//! and Quasi-Monte Carlo Methods*, 1992, ch. 3). For each shape, the amplitude follows by least squares, together with
//! corrections of gravity and friction. The shape that explains the most is the start.

use nalgebra::{DMatrix, DVector};
use plant::{EffectId, Instant, Model, Role, Smoothing};

use crate::fit::Minimum;
use crate::records::{Bump, Record};
use crate::residuals::{MeasuredMotion, TorqueOn, half_bump, residual_torque};

/// Number of shapes drawn; with two shape parameters, one draw per cell of a 20 × 20 grid.
const DRAWS: usize = 400;
/// Number of bumps compared per log.
const BUMPS: usize = 300;
/// Factor by which a bump is narrower than usual, so that narrow torques are not smoothed away.
const NARROW: usize = 3;
/// A shape parameter without bounds is drawn within this factor of its start.
const RATIO: f64 = 5.0;

/// The missing torque of one log, and the motion during which it acted.
struct Lacking {
    motion: MeasuredMotion,
    centres: Vec<usize>,
    weights: Vec<Vec<f64>>,
    torque: Vec<f64>,
    half: usize,
}

/// A torque that depends on the motion.
type Term<'t> = dyn Fn(&Instant<f64>) -> f64 + 't;

/// The start that the logs suggest for the effect, beside a fit of `from`; `None` if they suggest none.
pub fn shaped_start(
    records: &[&Record],
    from: &Model,
    minimum: &Minimum,
    effect: EffectId,
    stated: &[f64],
) -> Option<Vec<f64>> {
    let info = effect.info();
    let on: &[TorqueOn] = match info.role {
        Role::Body => &[TorqueOn::Body, TorqueOn::BodyByCommand],
        Role::Wheel => &[TorqueOn::Wheel],
        Role::Motor | Role::Sensor => return None,
    };
    let absent = info.absent?;
    let amplitude = (0..absent.len()).find(|&k| absent[k] == 0.0)?;
    let shapes: Vec<usize> = (0..absent.len()).filter(|&k| k != amplitude).collect();
    let lacking: Vec<Lacking> = records
        .iter()
        .filter_map(|record| lacking(record, from, &minimum.values, on))
        .collect();
    let observations: usize = lacking.iter().map(|one| one.torque.len()).sum();
    if shapes.is_empty() || observations < 10 * absent.len() {
        return None;
    }
    let mut best: Option<(f64, Vec<f64>)> = None;
    for draw in 0..DRAWS {
        let mut p = stated.to_vec();
        for (index, &shape) in shapes.iter().enumerate() {
            let (low, high) = info.parameters[shape].bounds;
            let share = weyl(draw, index);
            p[shape] = if low.is_finite() && high.is_finite() {
                low + share * (high - low)
            } else {
                (p[shape] * RATIO.powf(2.0 * share - 1.0)).clamp(low, high)
            };
        }
        let unit = p[amplitude];
        if let Some((gain, factor)) = explained(&lacking, effect, &p) {
            let (low, high) = info.parameters[amplitude].bounds;
            let found = factor * unit;
            let is_better = best.as_ref().is_none_or(|(most, _)| gain > *most);
            if is_better && (low..=high).contains(&found) {
                p[amplitude] = found;
                best = Some((gain, p));
            }
        }
    }
    best.map(|(_, start)| start)
}

/// The fractional part of k √p, one prime for each dimension.
fn weyl(draw: usize, dimension: usize) -> f64 {
    const PRIMES: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];
    ((draw + 1) as f64 * PRIMES[dimension % PRIMES.len()].sqrt()).fract()
}

fn lacking(record: &Record, from: &Model, values: &[f64], on: &[TorqueOn]) -> Option<Lacking> {
    if record.len() < 16 {
        return None;
    }
    let usual = half_bump(record, values);
    let motion = MeasuredMotion::new(record, &[], from, values, usual)?;
    let half = (usual / NARROW).max(4);
    let stride = (record.len() / BUMPS).max(half / 2).max(1);
    let found = on.iter().find_map(|&on| {
        residual_torque(
            record,
            &record.weight,
            &motion,
            from,
            values,
            on,
            (half, stride),
        )
    })?;
    // Every log is weighted by its own noise.
    let scale = 1.0 / found.noise_std_nm.max(f64::MIN_POSITIVE);
    let scaled = |values: Vec<f64>| values.iter().map(|value| value * scale).collect();
    let bumps = found.centres.iter();
    let weights = bumps.map(|&centre| Bump::around(&record.time_s, centre, half).intervals);
    Some(Lacking {
        motion,
        weights: weights.map(scaled).collect(),
        torque: scaled(found.torque_nm),
        centres: found.centres,
        half,
    })
}

impl Lacking {
    /// The mean of `term` over every bump.
    fn averages(&self, term: impl Fn(&Instant<f64>) -> f64) -> Vec<f64> {
        let bumps = self.centres.iter().zip(&self.weights);
        bumps
            .map(|(&centre, weights)| {
                let states = &self.motion.state[centre - self.half..centre + self.half];
                let terms = weights.iter().zip(states).map(|(weight, state)| {
                    weight
                        * term(&Instant {
                            angle_rad: state.angle_rad,
                            rate_rad_s: state.rate_rad_s,
                            wheel_angle_rad: state.wheel_angle_rad,
                            wheel_speed_rad_s: state.wheel_speed_rad_s,
                            current_a: state.current_a,
                            memory: 0.0,
                        })
                });
                terms.sum()
            })
            .collect()
    }
}

/// The fall of the missing torque's sum of squares with the best multiple of the effect with these parameters, fitted
/// together with gravity and friction, and that multiple.
fn explained(lacking: &[Lacking], effect: EffectId, p: &[f64]) -> Option<(f64, f64)> {
    let v0 = Smoothing::SIMULATION;
    let terms: [&Term; 5] = [
        // Library torques are positive against the motion.
        &|at| -effect.torque(p, at, &v0),
        &|at| at.angle_rad.sin(),
        &|at| at.rate_rad_s,
        &|at| (at.rate_rad_s / v0.body_rad_s).tanh(),
        &|at| at.wheel_speed_rad_s,
    ];
    let columns: Vec<Vec<f64>> = terms
        .iter()
        .map(|term| lacking.iter().flat_map(|one| one.averages(term)).collect())
        .collect();
    let torque: Vec<f64> = lacking
        .iter()
        .flat_map(|one| one.torque.iter().copied())
        .collect();
    let used: Vec<&Vec<f64>> = columns
        .iter()
        .filter(|column| column.iter().any(|value| value.abs() > 0.0))
        .collect();
    if used.is_empty() || !std::ptr::eq(used[0], &columns[0]) {
        return None;
    }
    let left_over = |columns: &[&Vec<f64>]| -> Option<(f64, f64)> {
        let matrix = DMatrix::from_fn(torque.len(), columns.len(), |row, column| {
            columns[column][row]
        });
        let right = DVector::from_column_slice(&torque);
        if columns.is_empty() {
            return Some((right.norm_squared(), 0.0));
        }
        let found = (matrix.transpose() * &matrix).try_inverse()? * matrix.transpose() * &right;
        Some(((right - matrix * &found).norm_squared(), found[0]))
    };
    let (with, factor) = left_over(&used)?;
    let (without, _) = left_over(&used[1..])?;
    let gain = without - with;
    (gain.is_finite() && factor.is_finite()).then_some((gain, factor))
}

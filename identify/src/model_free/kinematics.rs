//! The measured rate against the measured angle, without any model of the motion.
//!
//! A gyroscope with scale error s and bias b measures r = (1 + s) α̇ + b. Multiplied by a bump ψ that
//! vanishes at both ends of a short interval and integrated by parts,
//!
//!   ∫ ψ r dt = −(1 + s) ∫ ψ̇ α dt + b ∫ ψ dt
//!
//! holds for the measured angle itself: no noise is differentiated (Shinbrot, Trans. ASME 79 (1957)).
//! No torque enters. An effect that a model of the motion lacks can therefore not look like a fault of the gyroscope
//! here. Standard errors are those of least squares with the observed scatter of the rows.

use nalgebra::{DMatrix, DVector};

use crate::records::{BUMP_S, Output, Record, bumps};

/// The faults of the gyroscope, by comparison with the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateAgainstAngle {
    /// Scale error s, dimensionless.
    pub scale_error: f64,
    /// Its standard error.
    pub scale_error_std: f64,
    /// Bias b in rad/s.
    pub bias_rad_s: f64,
    /// Its standard error in rad/s.
    pub bias_std_rad_s: f64,
}

/// Compares rate and angle in all records that measure both; `None` if there are too few samples or the body hardly
/// moves.
pub fn rate_against_angle(records: &[&Record]) -> Option<RateAgainstAngle> {
    let (mut left, mut right) = (vec![], vec![]);
    for record in records {
        let (Some(angle), Some(rate)) =
            (record.channel(Output::Angle), record.channel(Output::Rate))
        else {
            continue;
        };
        bumps(record, BUMP_S, |bump| {
            let row = [
                -bump.integral(&angle.samples, 1),
                bump.area(),
                bump.integral(&rate.samples, 0),
            ];
            if row.iter().all(|value| value.is_finite()) {
                left.extend_from_slice(&row[..2]);
                right.push(row[2] - row[0]);
            }
        });
    }
    let rows = right.len();
    if rows < MOST_UNKNOWNS * 2 {
        return None;
    }
    let left = DMatrix::from_row_slice(rows, MOST_UNKNOWNS, &left);
    let right = DVector::from_vec(right);
    let inverse = (left.transpose() * &left).try_inverse()?;
    let found = &inverse * left.transpose() * &right;
    let scatter = (&right - &left * &found).norm_squared() / (rows - MOST_UNKNOWNS) as f64;
    // Neighbouring bumps overlap by half, so only half as many rows are independent.
    let variance = inverse.diagonal() * scatter * 2.0;
    let std = variance.map(f64::sqrt);
    std.iter()
        .all(|std| std.is_finite())
        .then_some(RateAgainstAngle {
            scale_error: found[0],
            scale_error_std: std[0],
            bias_rad_s: found[1],
            bias_std_rad_s: std[1],
        })
}

/// Number of unknowns: scale error and bias.
const MOST_UNKNOWNS: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use plant::{Current, Kind, Model, Plant, State};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// A swing under a torque that no model has, seen by a gyroscope with these faults.
    fn swing(scale_error: f64, bias_rad_s: f64, seed: u64) -> Record {
        let values = [2.3e-3, 1.4e-4, 0.245, 0.0335, 2e-5, 1.75e-5];
        let time_s: Vec<f64> = (0..2500).map(|k| k as f64 * 0.004).collect();
        let plant = Plant::new(&Model::base(), &values, Kind::FreeSwing);
        let start = State {
            angle_rad: 0.5,
            ..State::rest()
        };
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |std: f64| -> f64 {
            let sample: f64 = StandardNormal.sample(&mut rng);
            std * sample
        };
        let (mut angle, mut rate) = (vec![], vec![]);
        let push = |time_s: f64| 0.02 * (17.0 * time_s).sin();
        plant.run(
            start,
            &time_s,
            0..time_s.len(),
            Current::Held(0.0),
            Some(&push),
            |_, reading, _| {
                angle.push(reading.angle_rad + noise(1e-3));
                rate.push((1.0 + scale_error) * reading.rate_rad_s + bias_rad_s + noise(5e-3));
            },
        );
        let outputs = [Some(angle), Some(rate), None];
        Record::new("swing", Kind::FreeSwing, time_s, outputs, None, false)
    }

    #[test]
    fn a_gyroscope_is_judged_by_the_angle_whatever_moves_the_body() {
        let (mut covered, mut tries) = (0, 0);
        for seed in 0..40 {
            for (scale_error, bias) in [(0.0, 0.0), (0.03, -0.02)] {
                let record = swing(scale_error, bias, seed);
                let found = rate_against_angle(&[&record]).expect("both are measured");
                assert!(found.scale_error_std < 2e-3, "seed {seed}: {found:?}");
                let scale_off = (found.scale_error - scale_error) / found.scale_error_std;
                let bias_off = (found.bias_rad_s - bias) / found.bias_std_rad_s;
                assert!(scale_off.abs() < 5.0 && bias_off.abs() < 5.0, "seed {seed}");
                covered += usize::from(scale_off.abs() < 2.0) + usize::from(bias_off.abs() < 2.0);
                tries += 2;
            }
        }
        // 95.4 % of 160, less three binomial standard deviations.
        assert!(covered * 100 > tries * 90, "{covered} of {tries}");
    }

    #[test]
    fn nothing_is_said_without_both_channels() {
        let record = swing(0.0, 0.0, 1);
        let outputs = [Some(record.channels[0].samples.clone()), None, None];
        let alone = Record::new("x", Kind::FreeSwing, record.time_s, outputs, None, false);
        assert_eq!(rate_against_angle(&[&alone]), None);
    }
}

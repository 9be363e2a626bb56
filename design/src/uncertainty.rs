//! The effect of the parameters' uncertainty on the poles.
//!
//! First order: with J = ∂λ/∂p from the pole's sensitivity ([`crate::poles`]) and the parameters'
//! covariance C, the covariance of (Re λ, Im λ) is J C Jᵀ. Sampled: parameters are drawn from the
//! normal distribution with that covariance, and every loop is computed again. This also shows
//! curvature, merging poles and loss of stability. The gains are always those of the nominal design.
//!
//! Discrete poles are given as their continuous equivalents ln(λ)/T in 1/s, which can be
//! compared with the bench.

use crate::error::DesignError;
use crate::matrix::{check_finite, check_shape, of_model, symmetric};
use crate::poles::{eigenvalues, matched, poles};
use crate::zero_order_hold::zero_order_hold;
use nalgebra::{Complex, DMatrix, DVector, RowVector3, SymmetricEigen};
use plant::LinearModel;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Builds the linear model from parameter values in the order of
/// [`UncertainParameters::names`]; the message says what is wrong with them.
pub type ModelOfParameters<'a> = &'a dyn Fn(&[f64]) -> Result<LinearModel, String>;

/// Parameters with their uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct UncertainParameters {
    /// Names, as in model.toml.
    pub names: Vec<String>,
    /// Values in SI units.
    pub values: Vec<f64>,
    /// Covariance of the values (n×n), in products of their units.
    pub covariance: DMatrix<f64>,
}

impl UncertainParameters {
    /// Parameters with standard deviations and no correlation: (name, value, std) each.
    pub fn independent(parameters: &[(&str, f64, f64)]) -> Self {
        let variances = parameters.iter().map(|(_, _, std)| std * std);
        UncertainParameters {
            names: parameters
                .iter()
                .map(|(name, _, _)| (*name).to_owned())
                .collect(),
            values: parameters.iter().map(|(_, value, _)| *value).collect(),
            covariance: DMatrix::from_diagonal(&DVector::from_iterator(
                parameters.len(),
                variances,
            )),
        }
    }

    /// Parameters with standard deviations, (name, value, std) each, and the correlation of the
    /// errors of every two of them, by name.
    pub fn correlated(
        parameters: &[(&str, f64, f64)],
        correlation: impl Fn(&str, &str) -> f64,
    ) -> Self {
        let mut all = UncertainParameters::independent(parameters);
        for (row, (a, _, std_a)) in parameters.iter().enumerate() {
            for (column, (b, _, std_b)) in parameters.iter().enumerate() {
                if row != column {
                    all.covariance[(row, column)] = correlation(a, b) * std_a * std_b;
                }
            }
        }
        all
    }

    fn check(&self) -> Result<(), DesignError> {
        let count = self.values.len();
        check_shape(
            "the covariance of the parameters",
            &self.covariance,
            count,
            count,
        )?;
        check_finite("the covariance of the parameters", &self.covariance)?;
        for index in 0..count {
            if self.covariance[(index, index)] < 0.0 {
                return Err(DesignError::NotPositive {
                    what: "a variance of a parameter",
                    value: self.covariance[(index, index)],
                });
            }
        }
        Ok(())
    }

    fn std(&self, index: usize) -> f64 {
        self.covariance[(index, index)].sqrt()
    }

    /// Parameter sets drawn from the normal distribution with these values and this covariance.
    ///
    /// # Errors
    /// A covariance of the wrong shape, with a negative variance or an entry that is not finite.
    pub fn draws(&self, samples: usize, seed: u64) -> Result<Vec<Vec<f64>>, DesignError> {
        self.check()?;
        let root = self.square_root();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let count = self.values.len();
        let draw = |_| {
            let standard = DVector::from_fn(count, |_, _| StandardNormal.sample(&mut random));
            let change: DVector<f64> = &root * standard;
            let pairs = self.values.iter().zip(change.iter());
            pairs.map(|(value, change)| value + change).collect()
        };
        Ok((0..samples).map(draw).collect())
    }

    /// A matrix S with S Sᵀ = C, also for a semidefinite C. The correlations are decomposed, not
    /// the covariance, whose rounding would drown parameters with small numbers.
    fn square_root(&self) -> DMatrix<f64> {
        let count = self.values.len();
        let stds: Vec<f64> = (0..count).map(|index| self.std(index)).collect();
        let correlation = DMatrix::from_fn(count, count, |row, column| {
            let product = stds[row] * stds[column];
            if product > 0.0 {
                self.covariance[(row, column)] / product
            } else {
                0.0
            }
        });
        let eigen = SymmetricEigen::new(symmetric(&correlation));
        let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let mut root = eigen.eigenvectors * DMatrix::from_diagonal(&roots);
        for (mut row, std) in root.row_iter_mut().zip(stds) {
            row *= std;
        }
        root
    }
}

/// One pole with its uncertainty; all numbers are in 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct UncertainPole {
    /// The pole of the nominal model.
    pub value: Complex<f64>,
    /// Standard deviation of the real part, first order.
    pub std_re: f64,
    /// Standard deviation of the imaginary part, first order.
    pub std_im: f64,
    /// For every parameter: the change of the pole if that parameter alone changes by one standard deviation.
    pub per_parameter: Vec<(String, Complex<f64>)>,
    /// Standard deviation of the real part over the drawn parameters.
    pub sampled_std_re: f64,
    /// Standard deviation of the imaginary part over the drawn parameters.
    pub sampled_std_im: f64,
}

/// The poles with their uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct PoleUncertainty {
    /// Poles of A.
    pub open_loop: Vec<UncertainPole>,
    /// Continuous equivalents of the poles of the sampled loop.
    pub closed_loop: Vec<UncertainPole>,
    /// Poles of A for every drawn set that gives a model.
    pub open_loop_drawn: Vec<Complex<f64>>,
    /// Continuous equivalents of the sampled loop's poles for the same sets.
    pub closed_loop_drawn: Vec<Complex<f64>>,
    /// Number of drawn parameter sets.
    pub samples: usize,
    /// Number of sets that give no model (for example, with a negative inertia).
    pub impossible: usize,
    /// Number of sets for which the loop is unstable.
    pub unstable: usize,
    /// Largest pole modulus of the sampled loop over all sets.
    pub worst_spectral_radius: f64,
}

/// Poles of the open loop, and of the loop with `gains` sampled at `sample_time_s`, with `samples`
/// parameter sets drawn from `seed`.
///
/// # Errors
/// [`DesignError::Model`] if the nominal parameters give no model; a covariance of the wrong
/// shape or with a negative variance; entries that are not finite.
pub fn pole_uncertainty(
    parameters: &UncertainParameters,
    model: ModelOfParameters<'_>,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
    samples: usize,
    seed: u64,
) -> Result<PoleUncertainty, DesignError> {
    parameters.check()?;
    let build = |values: &[f64]| -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
        let linear = model(values).map_err(|message| DesignError::Model { message })?;
        let (a, b) = of_model(&linear)?;
        let hold = zero_order_hold(&a, &b, sample_time_s)?;
        let gain = DMatrix::from_fn(1, 3, |_, column| gains[column]);
        Ok((a, hold.state - hold.input * gain))
    };
    let (a, closed) = build(&parameters.values)?;
    let nominal_open = poles(&a)?;
    let nominal_closed = poles(&closed)?;
    let in_seconds = |pole: Complex<f64>| pole.ln() / sample_time_s;

    // First order: central differences over a thousandth of a standard deviation.
    let count = parameters.values.len();
    let mut open_rates = vec![vec![Complex::from(0.0); count]; nominal_open.len()];
    let mut closed_rates = vec![vec![Complex::from(0.0); count]; nominal_closed.len()];
    for index in 0..count {
        let step = 1e-3 * parameters.std(index);
        if step == 0.0 {
            continue;
        }
        let mut values = parameters.values.clone();
        values[index] = parameters.values[index] + step;
        let (a_up, closed_up) = build(&values)?;
        values[index] = parameters.values[index] - step;
        let (a_down, closed_down) = build(&values)?;
        let a_rate = (a_up - a_down) / (2.0 * step);
        let closed_rate = (closed_up - closed_down) / (2.0 * step);
        for (pole, rates) in nominal_open.iter().zip(&mut open_rates) {
            rates[index] = pole.movement(&a_rate);
        }
        for (pole, rates) in nominal_closed.iter().zip(&mut closed_rates) {
            rates[index] = pole.movement(&closed_rate) / (pole.value * sample_time_s);
        }
    }

    // Sampled.
    let open_values: Vec<_> = nominal_open.iter().map(|pole| pole.value).collect();
    let closed_values: Vec<_> = nominal_closed.iter().map(|pole| pole.value).collect();
    let mut open_spread = Spread::new(open_values.len());
    let mut closed_spread = Spread::new(closed_values.len());
    let (mut impossible, mut unstable) = (0, 0);
    let mut worst_spectral_radius = 0.0_f64;
    let (mut open_loop_drawn, mut closed_loop_drawn) = (Vec::new(), Vec::new());
    for values in parameters.draws(samples, seed)? {
        let Ok((a, closed)) = build(&values) else {
            impossible += 1;
            continue;
        };
        let closed = eigenvalues(&closed)?;
        let radius = closed.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        worst_spectral_radius = worst_spectral_radius.max(radius);
        if radius >= 1.0 {
            unstable += 1;
        }
        let open = matched(&open_values, eigenvalues(&a)?);
        open_loop_drawn.extend(&open);
        open_spread.add(open);
        let closed: Vec<Complex<f64>> = matched(&closed_values, closed)
            .into_iter()
            .map(in_seconds)
            .collect();
        closed_loop_drawn.extend(&closed);
        closed_spread.add(closed);
    }

    let assemble = |values: Vec<Complex<f64>>, rates: Vec<Vec<Complex<f64>>>, spread: Spread| {
        values
            .into_iter()
            .zip(rates)
            .zip(spread.std())
            .map(|((value, rates), (sampled_std_re, sampled_std_im))| {
                let variance = |part: fn(&Complex<f64>) -> f64| {
                    let row = DVector::from_iterator(count, rates.iter().map(part));
                    (row.transpose() * &parameters.covariance * row)[0]
                };
                UncertainPole {
                    value,
                    std_re: variance(|rate| rate.re).max(0.0).sqrt(),
                    std_im: variance(|rate| rate.im).max(0.0).sqrt(),
                    per_parameter: parameters
                        .names
                        .iter()
                        .cloned()
                        .zip((0..count).map(|index| rates[index] * parameters.std(index)))
                        .collect(),
                    sampled_std_re,
                    sampled_std_im,
                }
            })
            .collect()
    };
    Ok(PoleUncertainty {
        closed_loop: assemble(
            closed_values.iter().copied().map(in_seconds).collect(),
            closed_rates,
            closed_spread,
        ),
        open_loop: assemble(open_values, open_rates, open_spread),
        open_loop_drawn,
        closed_loop_drawn,
        samples,
        impossible,
        unstable,
        worst_spectral_radius,
    })
}

/// Running mean and variance of every pole (B. Welford, Technometrics 4(3), 1962).
struct Spread {
    count: f64,
    mean: Vec<Complex<f64>>,
    squares: Vec<(f64, f64)>,
}

impl Spread {
    fn new(poles: usize) -> Self {
        Spread {
            count: 0.0,
            mean: vec![Complex::from(0.0); poles],
            squares: vec![(0.0, 0.0); poles],
        }
    }

    fn add(&mut self, poles: Vec<Complex<f64>>) {
        self.count += 1.0;
        for ((pole, mean), squares) in poles.into_iter().zip(&mut self.mean).zip(&mut self.squares)
        {
            let before = pole - *mean;
            *mean += before / self.count;
            let after = pole - *mean;
            squares.0 += before.re * after.re;
            squares.1 += before.im * after.im;
        }
    }

    /// Standard deviations of real and imaginary part; NaN from fewer than two samples.
    fn std(&self) -> Vec<(f64, f64)> {
        let freedom = self.count - 1.0;
        self.squares
            .iter()
            .map(|(re, im)| {
                if freedom > 0.0 {
                    ((re / freedom).sqrt(), (im / freedom).sqrt())
                } else {
                    (f64::NAN, f64::NAN)
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;

    const NAMES: [&str; 6] = [
        "total_inertia",
        "wheel_inertia",
        "gravity_torque",
        "torque_constant",
        "body_viscous_friction",
        "wheel_viscous_friction",
    ];

    fn parameters(relative: f64) -> UncertainParameters {
        let list: Vec<_> = NAMES
            .iter()
            .zip(thesis::PARAMETERS)
            .map(|(name, value)| (*name, value, relative * value))
            .collect();
        UncertainParameters::independent(&list)
    }

    fn model(values: &[f64]) -> Result<LinearModel, String> {
        let values: [f64; 6] = values.try_into().map_err(|_| "six parameters".to_owned())?;
        if values[0] <= values[1] {
            return Err("the wheel cannot have all the inertia".to_owned());
        }
        Ok(thesis::model_of(values))
    }

    fn study(parameters: &UncertainParameters, samples: usize) -> PoleUncertainty {
        let seed = 20;
        pole_uncertainty(
            parameters,
            &model,
            &thesis::golden_gains(),
            1e-3,
            samples,
            seed,
        )
        .unwrap()
    }

    #[test]
    fn first_order_and_sampled_agree_where_the_uncertainty_is_small() {
        let samples = 4000;
        let study = study(&parameters(1e-3), samples);
        assert_eq!((study.impossible, study.unstable), (0, 0));
        for pole in study.open_loop.iter().chain(&study.closed_loop) {
            // The relative standard error of a standard deviation is 1/√(2n); four of those.
            let allowed = 4.0 / (2.0 * samples as f64).sqrt();
            let ratio = pole.sampled_std_re / pole.std_re;
            assert!((ratio - 1.0).abs() < allowed, "{pole:?}");
        }
    }

    #[test]
    fn open_loop_poles_scale_as_gravity_over_inertia_says() {
        // Without friction the unstable pole is √(G/D): half a per cent per per cent of G.
        let mut bench = thesis::PARAMETERS;
        bench[4] = 0.0;
        bench[5] = 0.0;
        let gravity =
            UncertainParameters::independent(&[("gravity_torque", bench[2], 0.01 * bench[2])]);
        let model = move |values: &[f64]| {
            let mut bench = bench;
            bench[2] = values[0];
            Ok(thesis::model_of(bench))
        };
        let study =
            pole_uncertainty(&gravity, &model, &thesis::golden_gains(), 1e-3, 2, 1).unwrap();
        let unstable = &study.open_loop[2];
        let golden = (bench[2] / (bench[0] - bench[1])).sqrt();
        assert!((unstable.value.re - golden).abs() < 1e-9);
        assert!((unstable.std_re - 0.005 * golden).abs() < 1e-6 * golden);
    }

    #[test]
    fn a_covariance_counts_as_a_whole() {
        // G and Θ, j_w all scaled by one and the same unknown factor cancel in the open loop.
        let mut parameters = parameters(0.0);
        let scale = DVector::from_column_slice(&thesis::PARAMETERS) * 0.02;
        parameters.covariance = &scale * scale.transpose();
        let study = study(&parameters, 500);
        for pole in &study.open_loop {
            // The square root of a matrix of rank one has only half the digits of a double.
            let alone: f64 = pole.per_parameter.iter().map(|(_, by)| by.norm()).sum();
            assert!(pole.std_re < 1e-6 * alone && pole.sampled_std_re < 1e-6 * alone);
            assert!(alone > 1e-4 * pole.value.norm());
        }
    }

    #[test]
    fn correlated_errors_cancel_in_a_quotient() {
        // Without friction and with a light wheel the unstable pole is √(G/Θ), and
        // (σ/λ)² = (g² + h² − 2 ρ g h)/4 with the relative errors g of G and h of Θ.
        let (inertia, gravity) = (2.3e-3, 0.245);
        let (h, g) = (0.01, 0.012);
        let list = [
            ("total_inertia", inertia, h * inertia),
            ("gravity_torque", gravity, g * gravity),
        ];
        let model = |values: &[f64]| {
            let mut bench = thesis::PARAMETERS;
            bench[0] = values[0] + bench[1];
            bench[2] = values[1];
            (bench[4], bench[5]) = (0.0, 0.0);
            Ok(thesis::model_of(bench))
        };
        let samples = 4000;
        for rho in [-0.5, 0.0, 0.9, 0.999] {
            let parameters = UncertainParameters::correlated(&list, |_, _| rho);
            let gains = thesis::golden_gains();
            let study = pole_uncertainty(&parameters, &model, &gains, 1e-3, samples, 3).unwrap();
            let golden = 0.5 * (g * g + h * h - 2.0 * rho * g * h).sqrt();
            let pole = &study.open_loop[2];
            let first_order = pole.std_re / pole.value.re;
            assert!((first_order / golden - 1.0).abs() < 1e-5, "{rho}: {pole:?}");
            // Allowed are four standard errors of a sampled standard deviation, plus 1 % for the curvature.
            let allowed = 4.0 / (2.0 * samples as f64).sqrt() + 0.01;
            let ratio = pole.sampled_std_re / pole.std_re;
            assert!((ratio - 1.0).abs() < allowed, "{rho}: {pole:?}");
        }
    }

    #[test]
    fn a_hopeless_uncertainty_shows_as_lost_loops() {
        let study = study(&parameters(0.6), 300);
        assert!(study.unstable > 0 && study.impossible > 0);
        assert!(study.worst_spectral_radius > 1.0);
    }

    #[test]
    fn bad_covariances_are_named() {
        let mut wrong = parameters(0.01);
        wrong.covariance = DMatrix::identity(2, 2);
        let gains = thesis::golden_gains();
        assert!(matches!(
            pole_uncertainty(&wrong, &model, &gains, 1e-3, 1, 1),
            Err(DesignError::WrongShape { .. })
        ));
    }
}

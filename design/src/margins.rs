//! The robustness of the loop: gain, phase, delay and modulus margins.
//!
//! The loop is opened at the plant's input, and considered at the samples, z = e^{jωT}:
//!
//! ```text
//! L(z) = −(Cc (zI − Ac)⁻¹ Bc + Dc) (zI − Ad)⁻¹ Bd
//! ```
//!
//! *Gain margin*: the factors g for which 1 + g L has no zero on the circle, i.e. −1/g lies between
//! the neighbouring crossings of L with the negative real axis. *Phase margin*: the smallest rotation of
//! L that moves it onto −1 where |L| = 1. *Modulus margin*: min |1 + L| = 1/max |S|.
//! *Delay margin*: a delay by a fraction of a sample is no mere rotation of L, because the
//! hold then switches between samples. The rotation divided by ω therefore only starts Newton's method on the
//! exact condition 1 + L_δ(e^{jωT}) = 0 for δ and ω. L_δ is the loop with the plant sampled with its delay
//! ([`crate::zero_order_hold::zero_order_hold_delayed`]).

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::late::{LatePlant, Lateness, resolvent};
use crate::matrix::check_positive;
use crate::poles::{eigenvalues, spectral_radius};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};

/// Number of frequencies before refinement. Loops with few states cross an axis a few times. Neighbouring
/// frequencies differ by about 1 %.
const GRID: usize = 1200;

/// The margins within which the loop stays stable.
#[derive(Clone, Debug, PartialEq)]
pub struct Margins {
    /// Smallest factor on the gains with which the loop is stable. It is below one, and above zero if the
    /// pendulum needs feedback.
    pub least_gain_factor: f64,
    /// Largest factor on the gains with which the loop is stable.
    pub largest_gain_factor: f64,
    /// Phase margin in rad; infinite if |L| is never 1.
    pub phase_margin_rad: f64,
    /// Frequency in rad/s at which |L| = 1 with that phase margin.
    pub crossover_rad_s: f64,
    /// Largest delay in s, in addition to the hold, with which the loop is stable.
    pub delay_margin_s: f64,
    /// Frequency in rad/s of the oscillation that begins at that delay.
    pub delay_frequency_rad_s: f64,
    /// min |1 + L|: the reciprocal of the peak of the sensitivity.
    pub modulus_margin: f64,
    /// Frequency in rad/s of that minimum.
    pub modulus_frequency_rad_s: f64,
}

/// The margins of `controller` around ẋ = A x + B u (A n×n, B n×1) sampled at `sample_time_s`.
///
/// # Errors
/// [`DesignError::UnstableLoop`] if the loop is unstable; wrong shapes.
pub fn margins(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    controller: &LinearController,
    sample_time_s: f64,
) -> Result<Margins, DesignError> {
    margins_with_delay(a, b, controller, sample_time_s, 0.0)
}

/// The margins of a loop whose current reaches the plant `delay_s` (s) late. The delay margin is a further delay, in
/// addition to `delay_s`.
///
/// # Errors
/// [`DesignError::UnstableLoop`] if the loop is unstable; wrong shapes; a negative delay.
pub fn margins_with_delay(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    controller: &LinearController,
    sample_time_s: f64,
    delay_s: f64,
) -> Result<Margins, DesignError> {
    let lateness = Lateness::of_current(delay_s);
    late_margins(a, b, controller, sample_time_s, &lateness)
}

/// The margins of a loop with late current and late sensors. The delay margin is a further delay of the current.
///
/// # Errors
/// [`DesignError::UnstableLoop`] if the loop is unstable; wrong shapes; a negative delay.
pub fn late_margins(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    controller: &LinearController,
    sample_time_s: f64,
    lateness: &Lateness,
) -> Result<Margins, DesignError> {
    let open = OpenLoop::new(a, b, controller, sample_time_s, lateness)?;
    let closed = controller.late_closed_loop(a, b, sample_time_s, lateness)?;
    let radius = spectral_radius(&closed)?;
    if radius >= 1.0 {
        return Err(DesignError::UnstableLoop {
            loop_name: "for which margins were requested",
            spectral_radius: radius,
            cure: "design gains for this model",
        });
    }
    let nyquist = PI / sample_time_s;
    // From well below the slowest motion up to half the sampling rate.
    let slowest = eigenvalues(a)?
        .iter()
        .map(|mode| mode.norm())
        .filter(|rate| *rate > nyquist * 1e-9)
        .fold(nyquist, f64::min)
        * 1e-3;
    let ratio = (nyquist / slowest).powf(1.0 / (GRID - 1) as f64);
    let grid: Vec<(f64, Complex<f64>)> = (0..GRID)
        .map(|index| slowest * ratio.powi(index as i32))
        .map(|frequency| frequency.min(nyquist))
        .filter_map(|frequency| Some((frequency, open.at(frequency)?)))
        .collect();

    // L is real at both ends of the half circle.
    let mut negative_crossings: Vec<f64> = [0.0, nyquist]
        .into_iter()
        .filter_map(|frequency| open.at(frequency))
        .map(|value| value.re)
        .collect();
    negative_crossings.extend(
        open.roots(&grid, |value| value.im)
            .into_iter()
            .filter_map(|frequency| open.at(frequency))
            .map(|value| value.re),
    );
    let factors = negative_crossings
        .into_iter()
        .filter(|real| *real < 0.0)
        .map(|real| -1.0 / real);
    let (mut least_gain_factor, mut largest_gain_factor) = (0.0_f64, f64::INFINITY);
    for factor in factors {
        if factor < 1.0 {
            least_gain_factor = least_gain_factor.max(factor);
        } else {
            largest_gain_factor = largest_gain_factor.min(factor);
        }
    }

    let (mut phase_margin_rad, mut crossover_rad_s) = (f64::INFINITY, f64::NAN);
    let (mut delay_margin_s, mut delay_frequency_rad_s) = (f64::INFINITY, f64::NAN);
    for frequency in open.roots(&grid, |value| value.norm().ln()) {
        let Some(value) = open.at(frequency) else {
            continue;
        };
        // The phase lead of −L relative to 1; a lag of that size moves L onto −1.
        let lead = (-value).arg();
        if lead.abs() < phase_margin_rad {
            phase_margin_rad = lead.abs();
            crossover_rad_s = frequency;
        }
        let own_s = lateness.current_s;
        let guess = own_s + lead.rem_euclid(TAU) / frequency;
        let (delay, oscillation) = open.critical_delay(guess, frequency);
        if delay - own_s < delay_margin_s {
            delay_margin_s = delay - own_s;
            delay_frequency_rad_s = oscillation;
        }
    }

    let (modulus_frequency_rad_s, modulus_margin) = open.smallest_return_difference(&grid);
    Ok(Margins {
        least_gain_factor,
        largest_gain_factor,
        phase_margin_rad,
        crossover_rad_s,
        delay_margin_s,
        delay_frequency_rad_s,
        modulus_margin,
        modulus_frequency_rad_s,
    })
}

/// L(z) and the loop with delays.
pub(crate) struct OpenLoop<'a> {
    a: &'a DMatrix<f64>,
    b: &'a DMatrix<f64>,
    lateness: Lateness,
    /// The plant with the delays and filters of the loop.
    plant: LatePlant,
    controller: &'a LinearController,
    sample_time_s: f64,
}

impl<'a> OpenLoop<'a> {
    /// The loop whose current and sensors are late.
    pub(crate) fn new(
        a: &'a DMatrix<f64>,
        b: &'a DMatrix<f64>,
        controller: &'a LinearController,
        sample_time_s: f64,
        lateness: &Lateness,
    ) -> Result<OpenLoop<'a>, DesignError> {
        check_positive("the sample time in s", sample_time_s)?;
        Ok(OpenLoop {
            a,
            b,
            lateness: *lateness,
            plant: LatePlant::new(a, b, sample_time_s, lateness)?,
            controller,
            sample_time_s,
        })
    }

    /// L at a frequency in rad/s; `None` at a pole.
    pub(crate) fn at(&self, frequency: f64) -> Option<Complex<f64>> {
        self.through_plant(&self.plant, frequency)
    }

    /// −(Cc (zI − Ac)⁻¹ Bc + Dc) times the response of the sensors of `plant` to the current.
    fn through_plant(&self, plant: &LatePlant, frequency: f64) -> Option<Complex<f64>> {
        let z = Complex::from_polar(1.0, frequency * self.sample_time_s);
        let shown = plant.transfer(z)?;
        let measured = self.controller.measurement.map(Complex::from) * &shown;
        let inner = resolvent(&self.controller.state, z, &measured)?;
        let output = self.controller.output.map(Complex::from) * inner
            + self.controller.feedthrough.map(Complex::from) * shown;
        let value = -output[0];
        (value.re.is_finite() && value.im.is_finite()).then_some(value)
    }

    /// 1 + L_δ.
    fn return_difference(&self, delay_s: f64, frequency: f64) -> Option<Complex<f64>> {
        let lateness = Lateness {
            current_s: delay_s,
            ..self.lateness
        };
        let plant = LatePlant::new(self.a, self.b, self.sample_time_s, &lateness).ok()?;
        Some(self.through_plant(&plant, frequency)? + 1.0)
    }

    /// Newton's method on 1 + L_δ(e^{jωT}) = 0 from a guess of (δ, ω); returns the guess if it fails.
    fn critical_delay(&self, delay_s: f64, frequency: f64) -> (f64, f64) {
        let (mut delay, mut omega) = (delay_s, frequency);
        for _ in 0..50 {
            let (step_delay, step_omega) = (1e-6 * delay.max(1e-9), 1e-6 * omega);
            let (Some(here), Some(later), Some(faster)) = (
                self.return_difference(delay, omega),
                self.return_difference(delay + step_delay, omega),
                self.return_difference(delay, omega + step_omega),
            ) else {
                break;
            };
            let by_delay = (later - here) / step_delay;
            let by_omega = (faster - here) / step_omega;
            let determinant = by_delay.re * by_omega.im - by_delay.im * by_omega.re;
            if determinant == 0.0 || !determinant.is_finite() {
                break;
            }
            let change_delay = (here.re * by_omega.im - here.im * by_omega.re) / determinant;
            let change_omega = (by_delay.re * here.im - by_delay.im * here.re) / determinant;
            // Steps are limited, so that the method finds the root near the guess and no other.
            delay -= change_delay.clamp(-0.2 * delay, 0.2 * delay);
            omega -= change_omega.clamp(-0.2 * omega, 0.2 * omega);
            if change_delay.abs() < 1e-12 * delay && change_omega.abs() < 1e-12 * omega {
                break;
            }
        }
        match self.return_difference(delay, omega) {
            Some(left) if left.norm() < 1e-8 => (delay, omega),
            _ => (delay_s, frequency),
        }
    }

    /// The frequencies at which `measure` of L changes its sign along the grid, refined by bisection.
    fn roots(
        &self,
        grid: &[(f64, Complex<f64>)],
        measure: impl Fn(Complex<f64>) -> f64,
    ) -> Vec<f64> {
        let mut roots = Vec::new();
        for pair in grid.windows(2) {
            let (mut low, mut high) = (pair[0].0, pair[1].0);
            let below = measure(pair[0].1) < 0.0;
            if (measure(pair[1].1) < 0.0) == below {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match self.at(middle) {
                    Some(value) if (measure(value) < 0.0) == below => low = middle,
                    Some(_) => high = middle,
                    None => break,
                }
            }
            roots.push(0.5 * (low + high));
        }
        roots
    }

    /// (frequency, |1 + L|) at the minimum of |1 + L|: the best point of the grid, refined by golden-section search.
    fn smallest_return_difference(&self, grid: &[(f64, Complex<f64>)]) -> (f64, f64) {
        let size = |value: Complex<f64>| (value + 1.0).norm();
        let Some(best) = (0..grid.len())
            .min_by(|left, right| size(grid[*left].1).total_cmp(&size(grid[*right].1)))
        else {
            return (f64::NAN, f64::NAN);
        };
        let mut low = grid[best.saturating_sub(1)].0;
        let mut high = grid[(best + 1).min(grid.len() - 1)].0;
        let at = |frequency: f64| self.at(frequency).map_or(f64::INFINITY, size);
        const SECTION: f64 = 0.618_033_988_749_894_9;
        for _ in 0..60 {
            let left = high - SECTION * (high - low);
            let right = low + SECTION * (high - low);
            if at(left) < at(right) {
                high = right;
            } else {
                low = left;
            }
        }
        let frequency = 0.5 * (low + high);
        let refined = at(frequency);
        let coarse = size(grid[best].1);
        if refined < coarse {
            (frequency, refined)
        } else {
            (grid[best].0, coarse)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::{Weights, discrete_regulator};
    use crate::matrix::of_model;
    use crate::thesis;
    use crate::zero_order_hold::zero_order_hold;
    use nalgebra::{RowVector3, Vector3};
    use proptest::prelude::*;

    fn radius(
        parts: (&DMatrix<f64>, &DMatrix<f64>),
        gains: &RowVector3<f64>,
        sample_time_s: f64,
        delay_s: f64,
    ) -> f64 {
        let closed = LinearController::state_feedback(gains)
            .closed_loop_with_delay(parts.0, parts.1, sample_time_s, delay_s)
            .unwrap();
        spectral_radius(&closed).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]
        /// For benches and weights of every kind, and for optimal and other gains, stability is lost exactly at the
        /// margins.
        #[test]
        fn stability_ends_exactly_at_the_margins(
            scale in prop::array::uniform6(-0.7..0.7_f64),
            weight in prop::array::uniform3(-1.0..1.0_f64),
            sample_time_s in 0.5e-3..10e-3_f64,
            detuned in prop::array::uniform3(0.6..1.6_f64),
        ) {
            let mut parameters = thesis::PARAMETERS;
            for (parameter, scale) in parameters.iter_mut().zip(scale) {
                *parameter *= scale.exp();
            }
            let model = thesis::model_of(parameters);
            let weights = Weights {
                state: Vector3::new(
                    25.0 * 10_f64.powf(weight[0]),
                    0.5 * 10_f64.powf(weight[1]),
                    5e-4 * 10_f64.powf(weight[2]),
                ),
                current: 1.0,
            };
            let optimal = discrete_regulator(&model, &weights, sample_time_s).unwrap().gains;
            let gains = optimal.component_mul(&RowVector3::from(detuned));
            let (a, b) = of_model(&model).unwrap();
            prop_assume!(radius((&a, &b), &gains, sample_time_s, 0.0) < 0.9999);
            let controller = LinearController::state_feedback(&gains);
            let margins = margins(&a, &b, &controller, sample_time_s).unwrap();

            let with_gain = |factor: f64| radius((&a, &b), &(gains * factor), sample_time_s, 0.0);
            let (least, largest) = (margins.least_gain_factor, margins.largest_gain_factor);
            prop_assert!(least > 0.0 && largest.is_finite());
            prop_assert!(with_gain(least * 0.999) > 1.0 && with_gain(least * 1.001) < 1.0);
            prop_assert!(with_gain(largest * 1.001) > 1.0 && with_gain(largest * 0.999) < 1.0);

            let with_delay = |delay: f64| radius((&a, &b), &gains, sample_time_s, delay);
            let delay = margins.delay_margin_s;
            prop_assert!(with_delay(delay * 0.999) < 1.0, "unstable just before {delay}");
            prop_assert!(with_delay(delay * 1.001) > 1.0, "stable just after {delay}");
            for part in 1..20 {
                let shorter = delay * f64::from(part) / 20.0;
                prop_assert!(with_delay(shorter) < 1.0, "unstable at {shorter} < {delay}");
            }

            // A turn of the phase margin and a change of the gain both stay outside the disc of
            // the modulus margin around −1.
            let modulus = margins.modulus_margin;
            prop_assert!(modulus <= 2.0 * (margins.phase_margin_rad / 2.0).sin() + 1e-9);
            prop_assert!(modulus <= 1.0 / least - 1.0 + 1e-9);
            prop_assert!(modulus <= 1.0 - 1.0 / largest + 1e-9);
        }
    }

    /// The continuous regulator has at least 60° and tolerates half its gains (B. Anderson and
    /// J. Moore, "Optimal Control", section 5.4); the sampled one comes close at 1 ms.
    #[test]
    fn thesis_bench_has_nearly_the_margins_of_a_continuous_regulator() {
        let controller = LinearController::state_feedback(&thesis::golden_gains());
        let margins = margins(&thesis::a(), &thesis::b(), &controller, 1e-3).unwrap();
        assert!(margins.phase_margin_rad.to_degrees() > 58.0);
        assert!(margins.least_gain_factor < 0.52);
        assert!(margins.largest_gain_factor > 10.0);
        assert!(margins.modulus_margin > 0.95);
        // A delay turns L by ω δ; at 1 ms the hold makes little difference to that.
        let turn = margins.phase_margin_rad / margins.crossover_rad_s;
        assert!(
            (margins.delay_margin_s - turn).abs() < 0.02 * turn,
            "{margins:?}"
        );
    }

    #[test]
    fn an_unstable_loop_has_no_margins() {
        let controller = LinearController::state_feedback(&RowVector3::new(1.0, 0.0, 0.0));
        assert!(matches!(
            margins(&thesis::a(), &thesis::b(), &controller, 1e-3),
            Err(DesignError::UnstableLoop { .. })
        ));
    }

    #[test]
    fn a_scalar_loop_in_closed_form() {
        // x⁺ = a x + b u from ẋ = x + u, u = −k x: stable for |a − g b k| < 1.
        let one = DMatrix::from_element(1, 1, 1.0);
        let sample_time_s = 0.1;
        let hold = zero_order_hold(&one, &one, sample_time_s).unwrap();
        let controller = LinearController {
            state: DMatrix::zeros(0, 0),
            measurement: DMatrix::zeros(0, 1),
            output: DMatrix::zeros(1, 0),
            feedthrough: DMatrix::from_element(1, 1, -2.0),
        };
        let margins = margins(&one, &one, &controller, sample_time_s).unwrap();
        let (a, b) = (hold.state[0], hold.input[0]);
        assert!((margins.least_gain_factor - (a - 1.0) / (2.0 * b)).abs() < 1e-12);
        assert!((margins.largest_gain_factor - (a + 1.0) / (2.0 * b)).abs() < 1e-12);
    }
}

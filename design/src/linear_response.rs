//! The answer of the loop to a torque on the body, a lasting one (a step) or a short one (a push), and its range under
//! the uncertainty of the parameters.
//!
//! The linear loop, x⁺ = M x + Ed d with the torque d held from sample to sample, is exact at the samples. The gains
//! stay those of the nominal design while the parameters are drawn anew, as in [`crate::uncertainty`], because the law
//! is not adapted to a bench that differs from its model.

use nalgebra::{DMatrix, DVector, RowVector3, Vector3};
use plant::LinearModel;

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::matrix::{check_finite, check_positive, from_vector3, of_model};
use crate::uncertainty::UncertainParameters;
use crate::zero_order_hold::zero_order_hold;

/// The torque that acts on the body from time zero on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DisturbanceTorque {
    /// A constant torque, N m.
    Step(f64),
    /// A torque over one sample, with this impulse, N m s.
    Push(f64),
}

/// The linear plant of a parameter set, and how a torque on the body enters it: ẋ = A x + B u + E d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainLoop {
    /// A and B.
    pub model: LinearModel,
    /// E (3×1), units of row per N m and second.
    pub torque_input: Vector3<f64>,
}

/// The loop at sample times.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LinearResponse {
    /// Time since the torque began, s.
    pub time_s: Vec<f64>,
    /// Angle from upright, rad.
    pub angle_rad: Vec<f64>,
    /// Wheel speed, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Commanded current, A, without the drive's limit. Where it exceeds that limit, the response does not hold.
    pub current_a: Vec<f64>,
}

/// The middle 95 % of the responses with the drawn parameter sets, at every time of the response.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Band {
    /// 2.5 % of the responses lie below.
    pub low: Vec<f64>,
    /// 2.5 % of the responses lie above.
    pub high: Vec<f64>,
}

/// A response with its bands under the uncertainty of the parameters.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct BandedResponse {
    /// The response of the nominal parameters.
    pub nominal: LinearResponse,
    /// The band of the angle, rad.
    pub angle_band: Band,
    /// The band of the wheel speed, rad/s.
    pub wheel_speed_band: Band,
    /// The band of the current, A.
    pub current_band: Band,
    /// Number of drawn parameter sets behind the bands; sets that give no pendulum are not counted.
    pub sets: usize,
}

/// Share of the responses below the band, and the equal share above it.
const OUTSIDE: f64 = 0.025;

/// The loop of u = −`gains` x around `plant`, at about `points` sample times over `duration_s`, with the current
/// `delay_s` late.
///
/// # Errors
/// Numbers that are not finite or not positive.
pub fn linear_response(
    plant: &UncertainLoop,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
    delay_s: f64,
    disturbance: DisturbanceTorque,
    duration_s: f64,
    points: usize,
) -> Result<LinearResponse, DesignError> {
    check_positive("the duration in s", duration_s)?;
    let (a, b) = of_model(&plant.model)?;
    let torque_input = from_vector3(&plant.torque_input);
    check_finite("the torque's input matrix E", &torque_input)?;
    let held = zero_order_hold(&a, &torque_input, sample_time_s)?.input;
    let controller = LinearController::state_feedback(gains);
    let closed = controller.closed_loop_with_delay(&a, &b, sample_time_s, delay_s)?;
    let states = closed.nrows();

    // The torque is one more, constant state, so that a power of the matrix is the exact step over several samples.
    let mut whole = DMatrix::zeros(states + 1, states + 1);
    whole.view_mut((0, 0), (states, states)).copy_from(&closed);
    whole.view_mut((0, states), (3, 1)).copy_from(&held);
    whole[(states, states)] = 1.0;
    let mut state = DVector::zeros(states + 1);
    let first = match disturbance {
        DisturbanceTorque::Step(torque) => {
            state[states] = torque;
            0
        }
        DisturbanceTorque::Push(impulse) => {
            let after = &held * (impulse / sample_time_s);
            state.rows_mut(0, 3).copy_from(&after.column(0));
            1
        }
    };
    let steps = (duration_s / sample_time_s).ceil().max(1.0);
    let stride = (steps / points.max(1) as f64).ceil().max(1.0);
    let leap = power(&whole, stride as u32);
    let mut response = LinearResponse::default();
    let mut sample = f64::from(first);
    if first == 1 {
        response.push(0.0, &DVector::zeros(3), gains);
    }
    while sample <= steps {
        response.push(sample * sample_time_s, &state, gains);
        state = &leap * state;
        sample += stride;
    }
    Ok(response)
}

impl LinearResponse {
    fn push(&mut self, time_s: f64, state: &DVector<f64>, gains: &RowVector3<f64>) {
        self.time_s.push(time_s);
        self.angle_rad.push(state[0]);
        self.wheel_speed_rad_s.push(state[2]);
        let current: f64 = (0..3).map(|index| -gains[index] * state[index]).sum();
        self.current_a.push(current);
    }
}

/// matrix^exponent by squaring.
fn power(matrix: &DMatrix<f64>, exponent: u32) -> DMatrix<f64> {
    let mut result = DMatrix::identity(matrix.nrows(), matrix.nrows());
    let (mut square, mut rest) = (matrix.clone(), exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result = &result * &square;
        }
        rest >>= 1;
        if rest > 0 {
            square = &square * &square;
        }
    }
    result
}

/// The settings of a response, beside its plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseSettings {
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Delay of the current at the plant, s.
    pub delay_s: f64,
    /// Duration of the response, s.
    pub duration_s: f64,
    /// Approximate number of times at which the response is computed.
    pub points: usize,
}

/// The response of [`linear_response`] with the bands of the parameter sets in `drawn`. Sets whose loop cannot be
/// computed are left out; if none is left, the bands are empty.
///
/// # Errors
/// Numbers of the nominal plant or of `settings` that are not finite or not positive.
pub fn banded_response(
    nominal: &UncertainLoop,
    drawn: &[UncertainLoop],
    gains: &RowVector3<f64>,
    settings: &ResponseSettings,
    disturbance: DisturbanceTorque,
) -> Result<BandedResponse, DesignError> {
    let of = |plant: &UncertainLoop| {
        linear_response(
            plant,
            gains,
            settings.sample_time_s,
            settings.delay_s,
            disturbance,
            settings.duration_s,
            settings.points,
        )
    };
    let nominal = of(nominal)?;
    let all: Vec<LinearResponse> = drawn.iter().filter_map(|plant| of(plant).ok()).collect();
    let band = |part: fn(&LinearResponse) -> &Vec<f64>| band_of(&all, part);
    Ok(BandedResponse {
        angle_band: band(|one| &one.angle_rad),
        wheel_speed_band: band(|one| &one.wheel_speed_rad_s),
        current_band: band(|one| &one.current_a),
        sets: all.len(),
        nominal,
    })
}

fn band_of(all: &[LinearResponse], part: fn(&LinearResponse) -> &Vec<f64>) -> Band {
    let Some(first) = all.first() else {
        return Band::default();
    };
    let mut band = Band::default();
    for index in 0..part(first).len() {
        let mut values: Vec<f64> = all.iter().map(|one| part(one)[index]).collect();
        values.sort_by(f64::total_cmp);
        band.low.push(quantile(&values, OUTSIDE));
        band.high.push(quantile(&values, 1.0 - OUTSIDE));
    }
    band
}

/// A quantile of sorted values, linear between them (Hyndman and Fan's definition 7).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let below = at.floor();
    let (low, high) = (sorted[below as usize], sorted[at.ceil() as usize]);
    low + (high - low) * (at - below)
}

/// The plants of `samples` parameter sets that are drawn from the distribution of `parameters`. Sets for which
/// `plant_of` returns `None` are left out.
///
/// # Errors
/// A matrix that is not a covariance.
pub fn drawn_plants(
    parameters: &UncertainParameters,
    plant_of: &dyn Fn(&[f64]) -> Option<UncertainLoop>,
    samples: usize,
    seed: u64,
) -> Result<Vec<UncertainLoop>, DesignError> {
    let sets = parameters.draws(samples, seed)?;
    Ok(sets.iter().filter_map(|values| plant_of(values)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;

    /// (Θ, j_w, G, …) of the thesis with a torque on the body: E = (0, 1/D, −1/D).
    fn plant(parameters: [f64; 6]) -> UncertainLoop {
        let d = parameters[0] - parameters[1];
        UncertainLoop {
            model: thesis::model_of(parameters),
            torque_input: Vector3::new(0.0, 1.0 / d, -1.0 / d),
        }
    }

    fn response(
        plant: &UncertainLoop,
        disturbance: DisturbanceTorque,
        delay_s: f64,
        duration_s: f64,
    ) -> LinearResponse {
        linear_response(
            plant,
            &thesis::golden_gains(),
            1e-3,
            delay_s,
            disturbance,
            duration_s,
            400,
        )
        .unwrap()
    }

    /// Under a constant torque d the loop rests at the angle −d/G: at rest the motor's torque equals the friction of
    /// the wheel, and the sum of both equations of motion is G α = −d.
    #[test]
    fn a_steady_torque_is_held_by_gravity() {
        let plant = plant(thesis::PARAMETERS);
        let found = response(&plant, DisturbanceTorque::Step(0.01), 0.0, 8.0);
        let last = found.angle_rad.len() - 1;
        let (angle, wheel, current) = (
            found.angle_rad[last],
            found.wheel_speed_rad_s[last],
            found.current_a[last],
        );
        // ẋ = 0 row by row.
        let (a, b, e) = (plant.model.state, plant.model.input, plant.torque_input);
        for row in [1, 2] {
            let terms = [
                a[(row, 0)] * angle,
                a[(row, 2)] * wheel,
                b[row] * current,
                e[row] * 0.01,
            ];
            let largest = terms.iter().map(|term| term.abs()).fold(0.0, f64::max);
            assert!(
                terms.iter().sum::<f64>().abs() < 1e-6 * largest,
                "{terms:?}"
            );
        }
        let golden = -0.01 / thesis::PARAMETERS[2];
        assert!((angle / golden - 1.0).abs() < 1e-4, "{angle} {golden}");
    }

    /// A push changes the body's rate by its impulse divided by D at once, and its response is the time derivative of
    /// the response to a step.
    #[test]
    fn a_push_is_the_change_of_a_step() {
        let plant = plant(thesis::PARAMETERS);
        for delay_s in [0.0, 0.7e-3, 2.2e-3] {
            let fine = |disturbance| {
                linear_response(
                    &plant,
                    &thesis::golden_gains(),
                    1e-3,
                    delay_s,
                    disturbance,
                    0.3,
                    400,
                )
                .unwrap()
            };
            let push = fine(DisturbanceTorque::Push(1e-3));
            let step = fine(DisturbanceTorque::Step(1.0));
            // Both responses are given at the samples 0, 1, 2, …
            for k in 1..200 {
                let change = step.angle_rad[k] - step.angle_rad[k - 1];
                assert!((push.angle_rad[k] - change).abs() < 1e-9, "{delay_s} {k}");
            }
        }
    }

    /// If only the torque input is uncertain, by a normal factor, the band is ±1.96 σ wide.
    #[test]
    fn a_band_is_what_was_drawn() {
        let nominal = plant(thesis::PARAMETERS);
        let parameters = UncertainParameters::independent(&[("factor", 1.0, 0.1)]);
        let of = |values: &[f64]| {
            Some(UncertainLoop {
                torque_input: nominal.torque_input * values[0],
                ..nominal
            })
        };
        let seed = 7;
        let drawn = drawn_plants(&parameters, &of, 4000, seed).unwrap();
        let settings = ResponseSettings {
            sample_time_s: 1e-3,
            delay_s: 0.0,
            duration_s: 1.0,
            points: 50,
        };
        let found = banded_response(
            &nominal,
            &drawn,
            &thesis::golden_gains(),
            &settings,
            DisturbanceTorque::Step(0.01),
        )
        .unwrap();
        assert_eq!(found.sets, 4000);
        for (k, angle) in found.nominal.angle_rad.iter().enumerate().skip(1) {
            let half = 0.5 * (found.angle_band.high[k] - found.angle_band.low[k]);
            // The standard error of this quantile is √(p(1−p)/n)/φ(1.96) σ ≈ 0.042 σ; four of them.
            assert!(
                (half / angle.abs() - 0.196).abs() < 0.017,
                "seed {seed}, {k}: {half} {angle}"
            );
        }
    }

    /// A common factor c of all inertias and torques leaves A and B alone and divides E by c: where the errors are
    /// wholly correlated the band is 1.96 times their relative size at every time; where they are independent it stays
    /// wide where the answer passes through zero.
    #[test]
    fn correlations_count() {
        let names = ["a", "b", "c", "d", "e", "f"];
        let relative = 0.02;
        let pairs = names.iter().zip(thesis::PARAMETERS);
        let list: Vec<(&str, f64, f64)> = pairs
            .map(|(name, value)| (*name, value, relative * value))
            .collect();
        let of = |values: &[f64]| Some(plant(values.try_into().ok()?));
        let settings = ResponseSettings {
            sample_time_s: 1e-3,
            delay_s: 0.0,
            duration_s: 1.0,
            points: 200,
        };
        let seed = 3;
        let widest = |rho: f64| {
            let parameters = UncertainParameters::correlated(&list, |_, _| rho);
            let drawn = drawn_plants(&parameters, &of, 2000, seed).unwrap();
            let found = banded_response(
                &plant(thesis::PARAMETERS),
                &drawn,
                &thesis::golden_gains(),
                &settings,
                DisturbanceTorque::Push(1e-4),
            )
            .unwrap();
            let band = found.angle_band;
            let all = found
                .nominal
                .angle_rad
                .iter()
                .zip(band.low.iter().zip(&band.high));
            let ratios = all
                .skip(1)
                .map(|(angle, (low, high))| 0.5 * (high - low) / angle.abs());
            ratios.fold((f64::INFINITY, 0.0_f64), |(least, most), ratio| {
                (least.min(ratio), most.max(ratio))
            })
        };
        let golden = 1.96 * relative;
        let (least, most) = widest(1.0);
        // Four standard errors of the quantile from 2000 draws, 0.060 σ each, and a per cent of curvature.
        let allowed = 0.25 * relative;
        assert!(
            (least - golden).abs() < allowed && (most - golden).abs() < allowed,
            "seed {seed}: {least} {most}"
        );
        let (_, most) = widest(0.0);
        assert!(most > 2.0 * golden, "seed {seed}: {most}");
    }

    #[test]
    fn nonsense_is_named() {
        let plant = plant(thesis::PARAMETERS);
        let gains = thesis::golden_gains();
        let step = DisturbanceTorque::Step(0.01);
        assert!(linear_response(&plant, &gains, 0.0, 0.0, step, 1.0, 10).is_err());
        assert!(linear_response(&plant, &gains, 1e-3, 0.0, step, -1.0, 10).is_err());
        let mut broken = plant;
        broken.torque_input[1] = f64::NAN;
        assert!(linear_response(&broken, &gains, 1e-3, 0.0, step, 1.0, 10).is_err());
    }
}

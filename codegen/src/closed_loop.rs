//! Finds the certificate of the closed loop: an invariant ellipsoid and the bounds that follow.
//!
//! The checker's `closed_loop` explains why the numbers prove the claim, and checks them in exact arithmetic with
//! separate code. This file only has to find them, so ordinary floating point is sufficient. Every bound is rounded up
//! by more than the floating-point error.
//!
//! **Ellipsoid.** For F = Ad − Bd K and a γ between the spectral radius of F and 1, the solution of Fᵀ P F − γ² P =
//! −(Kᵀ K + ε S), with a diagonal S that makes the states comparable, gives a set that F maps into γ times itself. The
//! weight Kᵀ K shapes it along the strip |K x| ≤ limit. The set is scaled until a command or a state reaches its limit.
//! The limit of the angle is the one at which the largest current just holds the body against gravity, |B₂| L/A₂₁,
//! because no loop returns from beyond it. With a voltage drive the loop is that of the held voltage
//! ([`crate::held_voltage`]), and the set also stays where the supply does not clip. An encoder on the wheel shows the
//! mean speed over its window, which is half a window late; this is a further perturbation. γ and ε are chosen for the
//! largest volume that the perturbations cannot leave.

use nalgebra::{DMatrix, DVector, Matrix3, RowVector3, Vector3};
use num_traits::ToPrimitive;
use serde::Serialize;

use crate::exact::{ShortestDecimal, outward, parse};
use crate::hardware::WheelSensor;
use crate::held_voltage::HeldInput;
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;

/// Rounding up by this share covers the floating-point error.
const MARGIN: f64 = 1e-10;

/// Number of rounds in which bounds that depend on each other converge.
const ROUNDS: usize = 40;

/// Significant digits of a bound.
const DIGITS: u32 = 12;

#[derive(Serialize)]
struct Certificate {
    ellipsoid: [[String; 3]; 3],
    contraction: String,
    extents: [String; 3],
    #[serde(rename = "command_A")]
    command: String,
    sensor_steps: [String; 3],
    #[serde(rename = "wheel_acceleration_rad_s2")]
    wheel_acceleration: Option<String>,
    perturbation_share: String,
    terms: u32,
    #[serde(rename = "rest_A")]
    rest: String,
    cases: Vec<Case>,
}

#[derive(Serialize)]
struct Case {
    name: &'static str,
    #[serde(rename = "perturbation_A")]
    perturbation: String,
    states: [String; 3],
    #[serde(rename = "command_A")]
    command: String,
}

/// The loop in floating point.
struct Loop {
    f: Matrix3<f64>,
    input: Vector3<f64>,
    /// K.
    gains: RowVector3<f64>,
    /// N, the emitted gains, about −K.
    emitted: RowVector3<f64>,
    /// κ e₃ᵀ, which a voltage drive adds to the gains; zero for a current drive.
    back_emf: RowVector3<f64>,
    /// N + K.
    gain_error: RowVector3<f64>,
    limit: f64,
    /// Largest held input |w| that the supply allows, in A ([`crate::held_voltage::HeldInput::reach_a`]); infinite for
    /// a current drive.
    reach: f64,
    /// A and B of the loop whose input is the quantity that the drive holds: current, or voltage over resistance.
    a: Matrix3<f64>,
    b: Vector3<f64>,
    sample_time_s: f64,
    /// Half the window of an encoder on the wheel (s); zero without one.
    half_window_s: f64,
    half_unit: f64,
    ranges: Vector3<f64>,
    half_words: Vector3<f64>,
    half_sensors: Vector3<f64>,
}

impl Loop {
    /// Largest perturbation of the held command, if the states are wrong by at most `steps`.
    fn noise(&self, steps: &Vector3<f64>) -> f64 {
        ((self.emitted + self.back_emf).abs() * steps)[0] + self.half_unit
    }

    /// Largest error (rad/s) of the speed over the encoder's window, if the wheel accelerates by at most `acceleration`
    /// (rad/s²).
    fn lag(&self, acceleration: f64) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.half_window_s * acceleration)
    }

    /// A bound of the wheel's acceleration (rad/s²) in the set, if the states are wrong by at most `steps` and by the
    /// lag that this acceleration causes. `None` if there is no bound. Without an encoder on the wheel the result is
    /// zero, because no lag depends on it. The checker's `window_lag` explains why the bound holds.
    fn wheel_acceleration(&self, p: &Matrix3<f64>, steps: &Vector3<f64>) -> Option<f64> {
        if self.half_window_s == 0.0 {
            return Some(0.0);
        }
        let held = self.emitted + self.back_emf;
        let extents = Vector3::from_fn(|i, _| {
            let mut row = RowVector3::zeros();
            row[i] = 1.0;
            dual_norm(p, &row)
        });
        let at_sample = dual_norm(p, &(self.a.row(2) + held * self.b[2]));
        let sine = |angle: f64| self.a[(1, 0)].abs() * angle.powi(3) / 6.0;
        let mut found = at_sample;
        for _ in 0..ROUNDS {
            let noise = self.noise(&(steps + self.lag(found)));
            let current = dual_norm(p, &held) + noise;
            let mut b = extents;
            for _ in 0..ROUNDS {
                let sines = Vector3::new(0.0, 1.0, 1.0) * sine(b[0]);
                let change = self.a.abs() * b + self.b.abs() * current + sines;
                b = extents + change * self.sample_time_s;
            }
            let drift = (self.a.row(2).abs() * (b - extents))[0] + sine(b[0]);
            let next = (at_sample + self.b[2].abs() * noise + drift) * (1.0 + 1e-6);
            if next <= found {
                return Some(found);
            }
            found = next * (1.0 + 1e-9);
        }
        None
    }

    /// The factor by which the set xᵀ P x ≤ 1 may be enlarged until a command or the supply reaches its limit, if the
    /// measured states are wrong by at most `steps`.
    fn room(&self, p: &Matrix3<f64>, steps: &Vector3<f64>) -> f64 {
        let reach = |row: RowVector3<f64>| dual_norm(p, &row);
        let of_current = (self.emitted.abs() * steps)[0] + self.half_unit;
        let largest = reach(self.gains).max(reach(self.emitted));
        let held = reach(self.gains - self.back_emf).max(reach(self.emitted + self.back_emf));
        let of_supply = (self.reach - self.noise(steps)) / held;
        ((self.limit - of_current) / largest).min(of_supply)
    }
}

/// The certificate for `spec`, as JSON; `None` if no ellipsoid was found that the perturbations
/// cannot leave.
pub fn certify(spec: &ModuleSpec, law: &IntegerLaw) -> Option<serde_json::Value> {
    let sensor_steps = sensor_steps(spec)?;
    let unit = |bits: u32| 2f64.powi(-(bits as i32));
    let half_words = Vector3::from_fn(|i, _| 0.5 * unit(law.terms[i].input.format.fraction_bits));
    let gains = RowVector3::from_row_slice(&spec.gains);
    let held = HeldInput::of(spec);
    let encoder = match &spec.hardware.wheel {
        WheelSensor::Encoder(encoder) => Some(encoder),
        _ => None,
    };
    // The turn of an encoder over its window is the difference of two counts, each off by half a count.
    let shares = Vector3::new(0.5, 0.5, if encoder.is_some() { 1.0 } else { 0.5 });
    let input = Vector3::from_column_slice(&held.bd);
    let ad = Matrix3::from_fn(|i, j| held.ad[i][j]);
    let back_emf = RowVector3::new(0.0, 0.0, held.back_emf);
    let problem = Loop {
        f: ad - input * (gains - back_emf),
        back_emf,
        reach: held.reach_a,
        a: Matrix3::from_fn(|i, j| {
            let braked = if j == 2 {
                spec.b[i] * held.back_emf
            } else {
                0.0
            };
            spec.a[i][j] - braked
        }),
        b: Vector3::from_column_slice(&spec.b),
        sample_time_s: spec.sample_time_s,
        half_window_s: encoder.map_or(0.0, |encoder| {
            0.5 * f64::from(encoder.window) * spec.sample_time_s
        }),
        input,
        gains,
        emitted: RowVector3::from_fn(|_, i| {
            let gain = &law.terms[i].gain;
            f64::from(gain.raw) * unit(gain.fraction_bits)
        }),
        gain_error: RowVector3::from_fn(|_, i| {
            law.terms[i].gain.error.to_f64().unwrap_or_default()
        }),
        limit: f64::from(law.limit_raw) * unit(law.current.fraction_bits),
        half_unit: 0.5 * unit(law.current.fraction_bits),
        ranges: Vector3::new(
            spec.ranges.angle_rad.min(holdable_angle(spec)),
            spec.ranges.rate_rad_s,
            spec.ranges.wheel_speed_rad_s,
        ),
        half_words,
        half_sensors: half_words + Vector3::from_column_slice(&sensor_steps).component_mul(&shares),
    };
    let (p, gamma) = largest_ellipsoid(&problem)?;
    let acceleration = problem.wheel_acceleration(&p, &problem.half_sensors)?;
    Some(stated(&problem, &p, gamma, sensor_steps, acceleration))
}

/// The angle at which the largest current just holds the body in the linear model; infinite if the body does
/// not fall.
fn holdable_angle(spec: &ModuleSpec) -> f64 {
    let (fall, push) = (spec.a[1][0], spec.b[1]);
    if fall > 0.0 {
        push.abs() * spec.current_limit_a / fall
    } else {
        f64::INFINITY
    }
}

/// The size of one step of a reading: for the accelerometer as an angle against gravity, for the gyroscope as a rate about the
/// pivot axis, for the converter as a speed. A left-justified word moves by more than a count.
fn sensor_steps(spec: &ModuleSpec) -> Option<[f64; 3]> {
    let attitude = spec.hardware.attitude()?;
    let rows = |matrix: &nalgebra::Matrix3<f64>, row: usize| {
        matrix.row(row).iter().map(|entry| entry.abs()).sum::<f64>()
    };
    let accel = rows(&attitude.accel.matrix, 0).max(rows(&attitude.accel.matrix, 1));
    Some([
        step_of(attitude.accel_clip) * accel / attitude.gravity_m_s2,
        step_of(attitude.gyro_clip) * rows(&attitude.gyro.matrix, 2),
        spec.hardware.wheel_speed_per_count.abs(),
    ])
}

/// The step of a sensor's words in counts: the largest power of two that divides every count at which it clips.
fn step_of(clips: [i32; 3]) -> f64 {
    let zeros = clips.iter().filter(|clip| **clip != 0);
    let shift = zeros.map(|clip| clip.trailing_zeros()).min().unwrap_or(0);
    2f64.powi(shift as i32)
}

/// Searches γ and ε; P and γ of the ellipsoid with the largest volume.
fn largest_ellipsoid(problem: &Loop) -> Option<(Matrix3<f64>, f64)> {
    let radius = problem
        .f
        .complex_eigenvalues()
        .iter()
        .map(|value| value.norm())
        .fold(0.0, f64::max);
    let mut best: Option<(Matrix3<f64>, f64, f64)> = None;
    // A γ nearer to 1 needs more terms in a bound. The search goes at most half of the way from the spectral radius to
    // 1.
    for step in 1..=20 {
        let gamma = radius + (1.0 - radius) * f64::from(step) / 40.0;
        for exponent in -16..=4 {
            let epsilon = 10f64.powf(f64::from(exponent) / 4.0);
            let Some(p) = ellipsoid(problem, gamma, epsilon) else {
                continue;
            };
            let volume = 1.0 / p.determinant().sqrt();
            if volume.is_finite() && best.as_ref().is_none_or(|(_, _, other)| volume > *other) {
                best = Some((p, gamma, volume));
            }
        }
    }
    best.map(|(p, gamma, _)| (p, gamma))
}

/// The scaled solution of the Lyapunov equation, if the perturbations cannot leave it.
fn ellipsoid(problem: &Loop, gamma: f64, epsilon: f64) -> Option<Matrix3<f64>> {
    // S weighs each state by the square of its gain, and so by its part of the command. The ranges would not make the
    // states comparable: rate and wheel speed rarely come near the ends of theirs.
    let scale = problem.gains.transpose().map(|gain| gain * gain);
    let weight =
        problem.gains.transpose() * problem.gains + Matrix3::from_diagonal(&scale) * epsilon;
    let p = lyapunov(&(problem.f / gamma), &(weight / (gamma * gamma)))?;
    let reach = |row: &RowVector3<f64>| dual_norm(&p, row);
    let growth = |steps: &Vector3<f64>| {
        let mut growth = problem.room(&p, steps);
        for i in 0..3 {
            let mut row = RowVector3::zeros();
            row[i] = 1.0;
            growth = growth.min((problem.ranges[i] - steps[i]) / reach(&row));
        }
        growth * (1.0 - 1e-6)
    };
    let mut steps = problem.half_sensors;
    let mut found = growth(&steps);
    if problem.half_window_s > 0.0 {
        // In a larger set the wheel accelerates more, and the measured wheel speed lags further behind the true one.
        for _ in 0..ROUNDS {
            let scaled = p / (found * found);
            let acceleration = problem.wheel_acceleration(&scaled, &problem.half_sensors)?;
            steps = problem.half_sensors + problem.lag(acceleration);
            let next = growth(&steps);
            let is_settled = (next - found).abs() <= 1e-9 * found;
            found = next;
            if is_settled {
                break;
            }
        }
        found *= 1.0 - 1e-6;
    }
    let (growth, noise) = (found, problem.noise(&steps));
    let p = p / (growth * growth);
    let input_norm = (problem.input.transpose() * p * problem.input)[0].sqrt();
    let is_invariant = input_norm * noise <= (1.0 - gamma) * (1.0 - 1e-6);
    (growth > 0.0 && is_invariant).then_some(p)
}

/// P with Mᵀ P M − P = −Q.
fn lyapunov(m: &Matrix3<f64>, q: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    // Column-major: vec(Mᵀ P M) = (Mᵀ ⊗ Mᵀ) vec P.
    let transposed = m.transpose();
    let system = DMatrix::identity(9, 9) - transposed.kronecker(&transposed);
    let right = DVector::from_column_slice(q.as_slice());
    let solution = system.lu().solve(&right)?;
    let p = Matrix3::from_column_slice(solution.as_slice());
    let p = (p + p.transpose()) * 0.5;
    p.cholesky().map(|_| p)
}

fn stated(
    problem: &Loop,
    p: &Matrix3<f64>,
    gamma: f64,
    sensor_steps: [f64; 3],
    acceleration: f64,
) -> serde_json::Value {
    // From here on, the printed matrix is used; its decimals are exactly these doubles.
    let reach = |row: &RowVector3<f64>| dual_norm(p, row);
    let unit = |i: usize| {
        let mut row = RowVector3::zeros();
        row[i] = 1.0;
        row
    };
    let rows = [unit(0), unit(1), unit(2), problem.gains];
    let input_norm = (problem.input.transpose() * p * problem.input)[0].sqrt();
    // With this number of terms, the remainder of the series is below the rounding of the bounds.
    let terms = (1e-14_f64.ln() / gamma.ln()).ceil().max(1.0) as u32;
    let power = gamma.powf(f64::from(terms));
    let geometric = input_norm * power / (1.0 - gamma);
    let case = |name, steps: &Vector3<f64>| {
        let noise = problem.noise(steps);
        let worst = rows.map(|row| worst_difference(problem, p, &row, noise, terms, gamma));
        Case {
            name,
            perturbation: up(noise),
            states: [0, 1, 2].map(|i| up(worst[i])),
            command: up(worst[3]),
        }
    };
    let number = |value: f64| ShortestDecimal::new(value).text;
    let lag = problem.lag(acceleration);
    let certificate = Certificate {
        ellipsoid: [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(p[(i, j)]))),
        contraction: number(gamma),
        extents: [0, 1, 2].map(|i| up(reach(&rows[i]))),
        command: up(reach(&rows[3])),
        sensor_steps: sensor_steps.map(number),
        wheel_acceleration: (acceleration > 0.0).then(|| number(acceleration)),
        perturbation_share: up(
            input_norm * problem.noise(&(problem.half_sensors + lag)) / (1.0 - gamma)
        ),
        terms,
        rest: up(reach(&rows[3]) * geometric),
        cases: vec![
            case("words", &(problem.half_words + lag)),
            case("sensors", &(problem.half_sensors + lag)),
        ],
    };
    serde_json::to_value(certificate).expect("strings and integers serialise")
}

/// √(r P⁻¹ rᵀ), by Cholesky's factors, which keep their precision when P is thin.
fn dual_norm(p: &Matrix3<f64>, row: &RowVector3<f64>) -> f64 {
    p.cholesky()
        .and_then(|factors| factors.l().solve_lower_triangular(&row.transpose()))
        .map_or(f64::INFINITY, |solved| solved.norm())
}

/// The largest |C e| at any time: max over k of V Σ_{j<k} |C F̂ʲ Bd| + ‖C F̂ᵏ − C Fᵏ‖*.
fn worst_difference(
    problem: &Loop,
    p: &Matrix3<f64>,
    row: &RowVector3<f64>,
    noise: f64,
    terms: u32,
    gamma: f64,
) -> f64 {
    let power = gamma.powf(f64::from(terms));
    let shift = problem.input * problem.gain_error;
    let quantised = problem.f + shift;
    let (mut exact, mut with_quantised) = (*row, *row);
    let mut difference = RowVector3::zeros();
    let mut sum = 0.0;
    let mut worst = 0.0_f64;
    for _ in 0..terms {
        sum += (with_quantised * problem.input)[0].abs();
        // C F̂ᵏ⁺¹ − C Fᵏ⁺¹ without cancellation.
        difference = difference * quantised + exact * shift;
        exact *= problem.f;
        with_quantised *= quantised;
        worst = worst.max(noise * sum + dual_norm(p, &difference));
    }
    let reach = dual_norm(p, row);
    let input_norm = (problem.input.transpose() * p * problem.input)[0].sqrt();
    let rest = reach * input_norm * power / (1.0 - gamma);
    worst.max(noise * (sum + rest) + 2.0 * reach * power)
}

/// A bound as text, rounded up.
fn up(value: f64) -> String {
    let text = ShortestDecimal::new(value * (1.0 + MARGIN)).text;
    parse(&text).map_or(text, |exact| outward(&exact, DIGITS))
}

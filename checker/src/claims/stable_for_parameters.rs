//! Stability of the sampled loop with the emitted gains: of the stated matrices, and of every
//! parameter vector that identification allows.
//!
//! **Criterion.** With t = T/2 and δ = (z − 1)/T, z = (1 + w t)/(1 − w t) maps the left half plane
//! of w onto the inside of the unit circle, and δ = w/(1 − w t). A characteristic polynomial
//! δ³ + a δ² + b δ + c becomes h₃ w³ + h₂ w² + h₁ w + h₀ with
//!
//! h₃ = 1 − a t + b t² − c t³,  h₂ = a − 2 b t + 3 c t²,  h₁ = b − 3 c t,  h₀ = c,
//!
//! and all roots lie in the left half plane exactly if all four are positive and h₂ h₁ > h₃ h₀
//! (Hurwitz). Working in δ instead of z keeps what matters, z − 1, from drowning in 1.
//!
//! **Region.** Each parameter lies within ±√χ² standard errors, χ² the 95 % quantile for as many
//! degrees of freedom as there are parameters. This box contains the 95 % ellipsoid whatever the
//! correlations are (the ellipsoid's projection on an axis is that interval). It is halved until
//! the criterion holds on every part in outward-rounded intervals.
//!
//! **Model.** In coordinates (angle, rate, absolute wheel speed ψ = α̇ + φ̇), D = Θ − j_w,
//!
//! D α̈ = G α − d α̇ − τ u + r_w (ψ − α̇),   j_w ψ̇ = τ u − r_w (ψ − α̇).
//!
//! Whatever the stated A has beyond its parameters (linearised dry friction, springs) is taken
//! from A itself: of G as a constant, of d in proportion to the Coulomb torque.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::closed_loop_for_all_time::loops;
use crate::claims::control_law::ControlLaw;
use crate::exact::enclosure::Enclosure;
use crate::exact::matrices::{Matrix, Vector, apply, product};
use crate::exact::rational::{half, integer, power, root_above, rounded_up};

/// 95 % quantiles of χ² for 1 to 10 degrees of freedom, rounded up in the third decimal.
const CHI_SQUARED_95: [&str; 10] = [
    "3.842", "5.992", "7.815", "9.488", "11.071", "12.592", "14.068", "15.508", "16.919", "18.308",
];

/// How often boxes are halved before the sweep gives up.
const BOXES: usize = 4_000;

/// Terms of the series of the matrix exponential.
const TERMS: u32 = 80;

/// Checks that Ad and Bd are A and B, sampled with a zero-order hold at the stated time.
///
/// # Errors
/// A sentence that names the entry.
pub fn check_sampling(certificate: &Certificate) -> Result<(), String> {
    let t = &certificate.sample_time_s.value;
    if !t.is_positive() {
        return Err("the sample time is not positive".to_owned());
    }
    let a = matrix(&certificate.plant.a);
    let b = vector(&certificate.plant.b);
    let scaled: Matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| &a[i][j] * t));
    let norm = scaled
        .iter()
        .map(|row| row.iter().map(Signed::abs).sum::<BigRational>())
        .max()
        .unwrap_or_default();
    if norm > integer(8) {
        return Err("the sample time is too long for the model: |A| T is above 8".to_owned());
    }
    // The first row of the model is kinematics: the rate is the angle's derivative.
    let first = [&a[0][0], &a[0][1], &a[0][2], &b[0]];
    if first.map(|entry| entry.clone()) != [0, 1, 0, 0].map(integer) {
        return Err("the first row of A and B is not (0, 1, 0) and 0".to_owned());
    }
    // Σ (A T)^k/k! and T Σ (A T)^k/(k + 1)! B, until what is left is below 1e-30.
    let mut left = BigRational::one();
    let zero = || BigRational::zero();
    let one = BigRational::one();
    let mut term: Matrix =
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { one.clone() } else { zero() }));
    let mut ad: Matrix = [0, 1, 2].map(|_| [0, 1, 2].map(|_| zero()));
    let mut bd: Vector = [0, 1, 2].map(|_| zero());
    for k in 0..TERMS {
        let input = apply(&term, &b);
        let order = integer(i128::from(k) + 1);
        for i in 0..3 {
            for (sum, entry) in ad[i].iter_mut().zip(&term[i]) {
                *sum += entry;
            }
            bd[i] += &input[i] * t / &order;
        }
        left = left * &norm / &order;
        if left < power(10, -30) && order > &norm * integer(2) {
            break;
        }
        let next = product(&term, &scaled);
        term = next.map(|row| row.map(|entry| entry / &order));
    }
    let close = |what: String, stated: &BigRational, exact: &BigRational| {
        let allowed = exact.abs() * power(10, -12) + power(10, -20);
        if (stated - exact).abs() <= allowed {
            Ok(())
        } else {
            Err(format!(
                "{what} is stated as {}, sampling gives {}",
                rounded_up(stated, 12),
                rounded_up(exact, 12)
            ))
        }
    };
    let stated = &certificate.plant;
    for i in 0..3 {
        for (j, (entry, exact)) in stated.ad[i].iter().zip(&ad[i]).enumerate() {
            close(format!("Ad[{i}][{j}]"), &entry.value, exact)?;
        }
        close(format!("Bd[{i}]"), &stated.bd[i].value, &bd[i])?;
    }
    Ok(())
}

/// Checks that the loop Ad + Bd N with the emitted gains is asymptotically stable.
///
/// # Errors
/// A sentence.
pub fn check_stable(certificate: &Certificate, law: &ControlLaw) -> Result<(), String> {
    let t = &certificate.sample_time_s.value;
    let (_, quantised) = loops(certificate, law);
    let delta = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let identity = integer(i128::from(i == j));
            Enclosure::point(&((&quantised[i][j] - identity) / t))
        })
    });
    match judged(&delta, t) {
        Verdict::Stable => Ok(()),
        _ => Err("Ad + Bd N has an eigenvalue on or outside the unit circle".to_owned()),
    }
}

/// What is known of a box of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Stable,
    Unstable,
    Undecided,
}

/// Hurwitz' criterion for the δ-form of a loop.
fn judged(m: &[[Enclosure; 3]; 3], sample_time: &BigRational) -> Verdict {
    let t = Enclosure::point(&(sample_time * half()));
    let minor = |i: usize, j: usize| &(&m[i][i] * &m[j][j]) - &(&m[i][j] * &m[j][i]);
    let a = -&(&(&m[0][0] + &m[1][1]) + &m[2][2]);
    let b = &(&minor(0, 1) + &minor(0, 2)) + &minor(1, 2);
    let cofactor = |i: usize, j: usize| &(&m[1][i] * &m[2][j]) - &(&m[1][j] * &m[2][i]);
    let determinant = &(&(&m[0][0] * &cofactor(1, 2)) - &(&m[0][1] * &cofactor(0, 2)))
        + &(&m[0][2] * &cofactor(0, 1));
    let c = -&determinant;

    let t2 = &t * &t;
    let t3 = &t2 * &t;
    let two = Enclosure::point(&integer(2));
    let three = Enclosure::point(&integer(3));
    let h3 = &(&(&Enclosure::point(&integer(1)) - &(&a * &t)) + &(&b * &t2)) - &(&c * &t3);
    let h2 = &(&a - &(&(&two * &b) * &t)) + &(&(&three * &c) * &t2);
    let h1 = &b - &(&(&three * &c) * &t);
    let cross = &(&h2 * &h1) - &(&h3 * &c);
    let all = [&h3, &h2, &h1, &c, &cross];
    if all.iter().all(|value| value.is_positive()) {
        Verdict::Stable
    } else if all.iter().any(|value| value.is_negative()) {
        Verdict::Unstable
    } else {
        Verdict::Undecided
    }
}

/// The parameters on which the linear model depends.
const NAMES: [&str; 7] = [
    "total_inertia",
    "wheel_inertia",
    "gravity_torque",
    "torque_constant",
    "body_viscous_friction",
    "wheel_viscous_friction",
    "body_coulomb_torque",
];

/// How far the loop is known to be stable.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterRegion {
    /// Parameters that are uncertain, and by how much (± in their units), as text.
    pub uncertain: Vec<(String, String)>,
    /// Boxes that were looked at.
    pub boxes: usize,
}

/// Why stability over the region is not shown.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionFailure {
    /// The certificate does not say enough.
    NotStated(String),
    /// It does not hold, or could not be decided.
    Fails(String),
}

/// Shows that the loop with the emitted gains is stable for every parameter vector of the region.
///
/// # Errors
/// [`RegionFailure`].
pub fn check_region(
    certificate: &Certificate,
    law: &ControlLaw,
) -> Result<ParameterRegion, RegionFailure> {
    let parameter = |name: &str| certificate.parameters.iter().find(|p| p.name == name);
    let mut values = Vec::new();
    let mut errors = Vec::new();
    for name in NAMES {
        match parameter(name) {
            Some(found) => {
                values.push(found.value.value.clone());
                let std = found.std.as_ref().map(|std| std.value.abs());
                errors.push(std.unwrap_or_default());
            }
            // Without it there is no dry friction; every model has the others.
            None if name == "body_coulomb_torque" => {
                values.push(BigRational::zero());
                errors.push(BigRational::zero());
            }
            None => {
                return Err(RegionFailure::NotStated(format!(
                    "the certificate does not state the parameter {name}"
                )));
            }
        }
    }
    let count = certificate.parameters.len();
    let Some(quantile) = CHI_SQUARED_95
        .get(count.saturating_sub(1))
        .and_then(|text| crate::exact::rational::decimal(text))
    else {
        return Err(RegionFailure::NotStated(format!(
            "{count} parameters; the quantile is known for up to 10"
        )));
    };
    let factor = root_above(&quantile)
        .ok_or_else(|| RegionFailure::Fails("a negative quantile".to_owned()))?;
    let radii: Vec<BigRational> = errors.iter().map(|error| error * &factor).collect();

    let model = Model::new(certificate, law, &values).map_err(RegionFailure::Fails)?;
    let uncertain = NAMES
        .iter()
        .zip(&radii)
        .filter(|(_, radius)| !radius.is_zero())
        .map(|(name, radius)| ((*name).to_owned(), rounded_up(radius, 3)))
        .collect();

    let whole: Vec<(BigRational, BigRational)> = values
        .iter()
        .zip(&radii)
        .map(|(value, radius)| (value - radius, value + radius))
        .collect();
    // Where the loop is unstable at all, it mostly is so in a corner.
    let named = |vector: &[(BigRational, BigRational)]| {
        let list: Vec<_> = NAMES
            .iter()
            .zip(vector)
            .map(|(name, (value, _))| format!("{name} = {}", rounded_up(value, 6)))
            .collect();
        list.join(", ")
    };
    for corner in 0..1_usize << NAMES.len() {
        let is_new = radii
            .iter()
            .enumerate()
            .all(|(index, radius)| !radius.is_zero() || corner >> index & 1 == 0);
        let vector: Vec<_> = whole
            .iter()
            .enumerate()
            .map(|(index, (low, high))| {
                let end = if corner >> index & 1 == 0 { low } else { high };
                (end.clone(), end.clone())
            })
            .collect();
        if is_new && model.judge(&vector) == Verdict::Unstable {
            return Err(RegionFailure::Fails(format!(
                "the loop is unstable for {}",
                named(&vector)
            )));
        }
    }
    let mut pending = std::collections::VecDeque::from([whole]);
    let mut boxes = 0;
    while let Some(part) = pending.pop_front() {
        boxes += 1;
        if model.judge(&part) == Verdict::Stable {
            continue;
        }
        let middle: Vec<(BigRational, BigRational)> = part
            .iter()
            .map(|(low, high)| {
                let middle = (low + high) * half();
                (middle.clone(), middle)
            })
            .collect();
        if model.judge(&middle) == Verdict::Unstable {
            return Err(RegionFailure::Fails(format!(
                "the loop is unstable for {}",
                named(&middle)
            )));
        }
        if boxes >= BOXES {
            return Err(RegionFailure::Fails(format!(
                "not decided after {BOXES} boxes, near {}",
                named(&middle)
            )));
        }
        // Halve the parameter whose interval is widest against its own value.
        let widest = (0..part.len())
            .filter(|i| part[*i].0 != part[*i].1)
            .max_by_key(|i| {
                let (low, high) = &part[*i];
                (high - low) / (high.abs() + low.abs())
            });
        let Some(index) = widest else {
            return Err(RegionFailure::Fails(format!(
                "not decided for {}",
                named(&middle)
            )));
        };
        let mut lower = part.clone();
        lower[index].1 = middle[index].0.clone();
        let mut upper = part;
        upper[index].0 = middle[index].0.clone();
        pending.push_back(lower);
        pending.push_back(upper);
    }
    Ok(ParameterRegion { uncertain, boxes })
}

/// The linear model as a function of its parameters.
struct Model {
    sample_time: BigRational,
    gains: Vector,
    /// Part of G α that no parameter states (springs).
    extra_gravity: BigRational,
    /// Part of d that no parameter states.
    extra_friction: BigRational,
    /// d per Coulomb torque: 1/ι.
    dry_slope: BigRational,
}

impl Model {
    fn new(
        certificate: &Certificate,
        law: &ControlLaw,
        values: &[BigRational],
    ) -> Result<Model, String> {
        let a = matrix(&certificate.plant.a);
        let b = vector(&certificate.plant.b);
        let [
            theta,
            wheel,
            gravity,
            torque,
            viscous,
            wheel_viscous,
            coulomb,
        ] = values
        else {
            return Err("seven parameters are expected".to_owned());
        };
        let d = theta - wheel;
        if !d.is_positive() || !wheel.is_positive() {
            return Err("the inertias must satisfy total > wheel > 0".to_owned());
        }
        // What of A and B follows from the parameters alone must agree with them.
        let checks = [
            ("B[1]", &b[1], -torque / &d),
            ("B[2]", &b[2], theta * torque / (wheel * &d)),
            ("A[1][2]", &a[1][2], wheel_viscous / &d),
            ("A[2][2]", &a[2][2], -(theta * wheel_viscous) / (wheel * &d)),
            ("A[2][0]", &a[2][0], -a[1][0].clone()),
            ("A[2][1]", &a[2][1], -a[1][1].clone()),
        ];
        for (name, stated, derived) in checks {
            // The printed matrix of the thesis has six digits.
            if (stated - &derived).abs() > derived.abs() * power(10, -5) {
                return Err(format!(
                    "{name} is stated as {}, the parameters give {}",
                    rounded_up(stated, 7),
                    rounded_up(&derived, 7)
                ));
            }
        }
        let friction = -&a[1][1] * &d - viscous;
        let (dry_slope, extra_friction) = if coulomb.is_positive() && friction.is_positive() {
            (&friction / coulomb, BigRational::zero())
        } else {
            (BigRational::zero(), friction)
        };
        Ok(Model {
            sample_time: certificate.sample_time_s.value.clone(),
            gains: law.gains.clone(),
            extra_gravity: &a[1][0] * &d - gravity,
            extra_friction,
            dry_slope,
        })
    }

    fn judge(&self, part: &[(BigRational, BigRational)]) -> Verdict {
        let p: Vec<Enclosure> = part
            .iter()
            .map(|(low, high)| Enclosure::new(low, high))
            .collect();
        let point = Enclosure::point;
        let (Some(over_d), Some(over_wheel)) = ((&p[0] - &p[1]).reciprocal(), p[1].reciprocal())
        else {
            return Verdict::Undecided;
        };
        let gravity = &(&p[2] + &point(&self.extra_gravity)) * &over_d;
        let friction = &(&(&p[4] + &point(&self.extra_friction))
            + &(&p[6] * &point(&self.dry_slope)))
            * &over_d;
        let (drag, wheel_drag) = (&p[5] * &over_d, &p[5] * &over_wheel);
        let (push, wheel_push) = (&p[3] * &over_d, &p[3] * &over_wheel);
        let zero = Enclosure::zero;
        let one = || point(&integer(1));
        let a = [
            [zero(), one(), zero()],
            [gravity, -&(&friction + &drag), drag.clone()],
            [zero(), wheel_drag.clone(), -&wheel_drag],
        ];
        let b = [zero(), -&push, wheel_push];

        // (exp(A T) − 1)/T = Σ A^k T^(k−1)/k!, and the same acting on B.
        let multiply = |x: &[[Enclosure; 3]; 3], y: &[[Enclosure; 3]; 3]| {
            [0, 1, 2].map(|i| {
                [0, 1, 2].map(|j| {
                    &(&(&x[i][0] * &y[0][j]) + &(&x[i][1] * &y[1][j])) + &(&x[i][2] * &y[2][j])
                })
            })
        };
        let mut series = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { one() } else { zero() }));
        let mut term = series.clone();
        for k in 2..=40 {
            let step = point(&(&self.sample_time / integer(k)));
            let next = multiply(&term, &a);
            term = next.map(|row| row.map(|entry| &entry * &step));
            for i in 0..3 {
                for j in 0..3 {
                    series[i][j] = &series[i][j] + &term[i][j];
                }
            }
        }
        // With x = |A| T ≤ 4, what is left after 40 terms is below x^40/41! e^x < 1e-20.
        let rest = power(10, -20);
        let widening = Enclosure::new(&-rest.clone(), &rest);
        let four = point(&integer(4));
        for row in &a {
            let sum = row
                .iter()
                .fold(zero(), |sum, entry| &sum + &entry.magnitude());
            if !(&four - &(&sum * &point(&self.sample_time))).is_positive() {
                return Verdict::Undecided;
            }
        }
        let series = series.map(|row| row.map(|entry| &entry + &widening));
        let sampled = multiply(&series, &a);
        let input: Vec<Enclosure> = series
            .iter()
            .map(|row| &(&(&row[0] * &b[0]) + &(&row[1] * &b[1])) + &(&row[2] * &b[2]))
            .collect();
        // u = N₁ α + N₂ α̇ + N₃ (ψ − α̇)
        let n = [
            point(&self.gains[0]),
            point(&(&self.gains[1] - &self.gains[2])),
            point(&self.gains[2]),
        ];
        let closed = [0, 1, 2].map(|i| [0, 1, 2].map(|j| &sampled[i][j] + &(&input[i] * &n[j])));
        judged(&closed, &self.sample_time)
    }
}

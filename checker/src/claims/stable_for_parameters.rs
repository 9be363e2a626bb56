//! Claim `stable-for-parameters`: the loop with the emitted gains is stable for every parameter vector
//! that identification allows, by the criterion of [`crate::claims::closed_loop_stable`].
//!
//! **Region.** Each parameter that the loop depends on lies within ±√χ² standard errors. χ² is the 95 %
//! quantile with as many degrees of freedom as there are uncertain parameters among them. This box contains
//! their 95 % ellipsoid for all correlations, because the projection of the ellipsoid on an axis is that interval. The box
//! is halved until the criterion holds on every part in outward-rounded intervals.
//!
//! **Model.** In coordinates (angle, rate, absolute wheel speed ψ = α̇ + φ̇), D = Θ − j_w,
//!
//! D α̈ = G α − d α̇ − τ u + r_w (ψ − α̇),   j_w ψ̇ = τ u − r_w (ψ − α̇).
//!
//! Terms of the stated A that do not follow from the parameters (linearised dry friction, springs) are taken
//! from A itself: the part of G as a constant, the part of d in proportion to the Coulomb torque.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::closed_loop_stable::{Stability, judged};
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::enclosure::Enclosure;
use crate::exact::matrices::Vector;
use crate::exact::rational::{half, integer, power, root_above, rounded_up};

/// 95 % quantiles of χ² for 1 to 7 degrees of freedom, rounded up in the third decimal.
const CHI_SQUARED_95: [&str; 7] = [
    "3.842", "5.992", "7.815", "9.488", "11.071", "12.592", "14.068",
];

/// How often boxes are halved before the sweep gives up.
const BOXES: usize = 4_000;

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

/// What comes of the claim.
pub fn by_exact_arithmetic(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    match check_region(certificate, law) {
        Ok(region) if region.uncertain.is_empty() => ClaimOutcome::Proved(
            "no standard error is stated: the parameters themselves".to_owned(),
        ),
        Ok(region) => {
            let list: Vec<_> = region
                .uncertain
                .iter()
                .map(|(name, radius)| format!("{name} ± {radius}"))
                .collect();
            ClaimOutcome::Proved(format!("{} in {} boxes", list.join(", "), region.boxes))
        }
        Err(RegionFailure::NotStated(why)) => ClaimOutcome::NotRun(why),
        Err(RegionFailure::Fails(why)) => ClaimOutcome::Failed(why),
    }
}

/// Shows that the loop with the emitted gains is stable for every parameter vector of the region.
///
/// # Errors
/// [`RegionFailure`].
pub fn check_region(
    certificate: &Certificate,
    law: &EmittedLaw,
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
    // The ellipsoid of those that the loop depends on: what the others are does not matter to it, and
    // its projection has as many degrees of freedom.
    let count = errors.iter().filter(|error| !error.is_zero()).count();
    let quantile = CHI_SQUARED_95
        .get(count.saturating_sub(1))
        .and_then(|text| crate::exact::rational::decimal(text))
        .ok_or_else(|| RegionFailure::Fails(format!("no quantile for {count} parameters")))?;
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
        if is_new && model.judge(&vector) == Stability::Unstable {
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
        if model.judge(&part) == Stability::Stable {
            continue;
        }
        let middle: Vec<(BigRational, BigRational)> = part
            .iter()
            .map(|(low, high)| {
                let middle = (low + high) * half();
                (middle.clone(), middle)
            })
            .collect();
        if model.judge(&middle) == Stability::Unstable {
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
        law: &EmittedLaw,
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

    fn judge(&self, part: &[(BigRational, BigRational)]) -> Stability {
        let p: Vec<Enclosure> = part
            .iter()
            .map(|(low, high)| Enclosure::new(low, high))
            .collect();
        let point = Enclosure::point;
        let (Some(over_d), Some(over_wheel)) = ((&p[0] - &p[1]).reciprocal(), p[1].reciprocal())
        else {
            return Stability::Undecided;
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
                return Stability::Undecided;
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

//! Claim `stable-for-parameters`: the loop with the emitted gains is stable for every parameter vector
//! that identification allows, by the criterion of [`crate::claims::closed_loop_stable`].
//!
//! **Region.** The 95 % ellipsoid of the stated standard errors and correlations, or, where no correlations are stated, the box
//! around it ([`crate::claims::parameter_region`]). In its own coordinates it is halved until
//! the criterion holds on every part in outward-rounded intervals, by the slopes over the part ([`crate::exact::slopes`]), and along
//! the coordinate that moves the number in doubt the most. Parts beyond the ellipsoid are left out. If the largest number of
//! halvings is reached first, the claim is neither proved nor refuted.
//!
//! **Model.** In coordinates (angle, rate, absolute wheel speed ψ = α̇ + φ̇), D = Θ − j_w,
//!
//! D α̈ = G α − d α̇ − τ u + r_w (ψ − α̇),   j_w ψ̇ = τ u − r_w (ψ − α̇).
//!
//! A voltage drive holds w = V/R = N x + κ φ̇ with the κ of the certificate, and the motor brakes its wheel with τ²/R: then
//! r_w + τ²/R stands for r_w. R is exact, and the motor's back-EMF is its torque constant, whatever that is.
//!
//! Terms of the stated A that do not follow from the parameters (linearised dry friction, springs) are taken
//! from A itself: the part of G as a constant, the part of d in proportion to the Coulomb torque.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::closed_loop_stable::{Stability, criterion, judged, verdict_of};
use crate::claims::control_law::EmittedLaw;
use crate::claims::held_loop::{back_emf, held_gains};
use crate::claims::outcome::ClaimOutcome;
use crate::claims::parameter_region::{Part, Region};
use crate::exact::enclosure::Enclosure;
use crate::exact::matrices::Vector;
use crate::exact::rational::{half, integer, power, rounded_up};
use crate::exact::slopes::{Number, Slopes};

/// Largest number of halvings; after them the claim is left open.
const BOXES: usize = 4_000;

/// How many parameters the linear model depends on.
const COUNT: usize = 7;

/// The parameters on which the linear model depends.
const NAMES: [&str; COUNT] = [
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
    /// Whether their correlations are stated, so that the region is the ellipsoid and not the box around it.
    pub is_correlated: bool,
    /// Boxes that were looked at.
    pub boxes: usize,
}

/// Why stability over the region is not shown.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionFailure {
    /// The certificate does not say enough.
    NotStated(String),
    /// It does not hold.
    Fails(String),
    /// It could not be decided.
    Undecided(String),
}

/// The outcome of the claim.
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
            let correlated = match region.is_correlated {
                true => ", correlated as stated,",
                false => "",
            };
            ClaimOutcome::Proved(format!(
                "{}{correlated} in {} boxes",
                list.join(", "),
                region.boxes
            ))
        }
        Err(RegionFailure::NotStated(why) | RegionFailure::Undecided(why)) => {
            ClaimOutcome::NotRun(why)
        }
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
    let model = Model::new(certificate, law, &values).map_err(RegionFailure::Fails)?;
    // The ellipsoid of the parameters on which the loop depends; it does not depend on the others.
    let region = Region::of(certificate, &NAMES, values, &errors).map_err(RegionFailure::Fails)?;
    let uncertain = NAMES
        .iter()
        .zip(&region.radii)
        .filter(|(_, radius)| !radius.is_zero())
        .map(|(name, radius)| ((*name).to_owned(), rounded_up(radius, 3)))
        .collect();

    let named = |z: &[BigRational]| {
        let list: Vec<_> = NAMES
            .iter()
            .zip(region.at(z))
            .map(|(name, value)| format!("{name} = {}", rounded_up(&value, 6)))
            .collect();
        list.join(", ")
    };
    let unstable_at =
        |z: &[BigRational]| RegionFailure::Fails(format!("the loop is unstable for {}", named(z)));
    let is_unstable = |z: &[BigRational]| model.judge(&region.at(z)) == Stability::Unstable;
    // Where the loop is unstable at all, it mostly is so in a corner.
    if let Some(corner) = region.corners().iter().find(|z| is_unstable(z)) {
        return Err(unstable_at(corner));
    }
    let mut pending = std::collections::VecDeque::from([region.whole()]);
    let mut boxes = 0;
    while let Some(part) = pending.pop_front() {
        if region.is_outside(&part) {
            continue;
        }
        boxes += 1;
        let (stability, widest) = model.judge_part(&region, &part);
        if stability == Stability::Stable {
            continue;
        }
        let middle: Vec<BigRational> = part
            .iter()
            .map(|(low, high)| (low + high) * half())
            .collect();
        if region.holds(&middle) && is_unstable(&middle) {
            return Err(unstable_at(&middle));
        }
        let (Some(index), true) = (widest, boxes < BOXES) else {
            return Err(RegionFailure::Undecided(format!(
                "not decided after {boxes} boxes, near {}",
                named(&middle)
            )));
        };
        let mut lower = part.clone();
        lower[index].1.clone_from(&middle[index]);
        let mut upper = part;
        upper[index].0.clone_from(&middle[index]);
        pending.push_back(lower);
        pending.push_back(upper);
    }
    Ok(ParameterRegion {
        uncertain,
        is_correlated: region.is_ball,
        boxes,
    })
}

/// The linear model as a function of its parameters.
struct Model {
    sample_time: BigRational,
    /// Of what the drive holds.
    gains: Vector,
    /// 1/R of a voltage drive (1/Ohm); zero for a current drive.
    conductance: BigRational,
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
        // The entries of A and B that follow from the parameters alone must agree with them.
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
            gains: held_gains(&law.gains, &back_emf(certificate)),
            conductance: match &certificate.drive.voltage {
                Some(voltage) if voltage.winding_ohm.value.is_positive() => {
                    voltage.winding_ohm.value.recip()
                }
                _ => BigRational::zero(),
            },
            extra_gravity: &a[1][0] * &d - gravity,
            extra_friction,
            dry_slope,
        })
    }

    /// At one vector.
    fn judge(&self, p: &[BigRational]) -> Stability {
        let p: Vec<Enclosure> = p.iter().map(Enclosure::point).collect();
        self.closed(&p).map_or(Stability::Undecided, |closed| {
            judged(&closed, &self.sample_time)
        })
    }

    /// By slopes over the part of a region; and the coordinate whose interval moves the number in doubt the most.
    fn judge_part(&self, region: &Region, part: &Part) -> (Stability, Option<usize>) {
        let wide = || (0..part.len()).filter(|i| part[*i].0 != part[*i].1);
        let by_width = wide().max_by_key(|i| &part[*i].1 - &part[*i].0);
        let z: Vec<Slopes<COUNT>> = part
            .iter()
            .enumerate()
            .map(|(index, (low, high))| Slopes::parameter(index, Enclosure::new(low, high)))
            .collect();
        let over: Vec<Slopes<COUNT>> = region
            .values
            .iter()
            .zip(&region.directions)
            .map(|(value, row)| {
                let moves = row.iter().zip(&z).filter(|(entry, _)| !entry.is_zero());
                moves.fold(Slopes::constant(value), |sum, (entry, z)| {
                    sum.plus(&Slopes::constant(entry).times(z))
                })
            })
            .collect();
        let middles: Vec<BigRational> = part
            .iter()
            .map(|(low, high)| (low + high) * half())
            .collect();
        let middle: Vec<Enclosure> = region.at(&middles).iter().map(Enclosure::point).collect();
        let (Some(closed), Some(at_middle)) = (self.closed(&over), self.closed(&middle)) else {
            return (Stability::Undecided, by_width);
        };
        let over = criterion(&closed, &self.sample_time);
        let at_middle = criterion(&at_middle, &self.sample_time);
        let steps: Vec<Enclosure> = part
            .iter()
            .zip(&middles)
            .map(|((low, high), middle)| Enclosure::new(&(low - middle), &(high - middle)))
            .collect();
        let found: Vec<Enclosure> = over
            .iter()
            .zip(&at_middle)
            .map(|(over, at_middle)| {
                let mut value = at_middle.clone();
                for (slope, step) in over.slopes.iter().zip(&steps) {
                    value = &value + &(slope * step);
                }
                // Both hold the number.
                value.common(&over.value).unwrap_or(value)
            })
            .collect();
        // A part may reach beyond the region: what is unstable all over it is shown at a point of the region alone.
        let stability = verdict_of(&found.iter().collect::<Vec<_>>());
        let doubtful = found.iter().position(|value| !value.is_positive());
        let moved = doubtful.and_then(|index| {
            wide().max_by_key(|i| (&over[index].slopes[*i] * &steps[*i]).largest())
        });
        (stability, moved.or(by_width))
    }

    /// The closed loop in the form (F − 1)/T.
    fn closed<R: Number>(&self, p: &[R]) -> Option<[[R; 3]; 3]> {
        let point = R::constant;
        let over_d = p[0].minus(&p[1]).over()?;
        let over_wheel = p[1].over()?;
        let gravity = p[2].plus(&point(&self.extra_gravity)).times(&over_d);
        let friction = p[4]
            .plus(&point(&self.extra_friction))
            .plus(&p[6].times(&point(&self.dry_slope)))
            .times(&over_d);
        // The back-EMF brakes the wheel against the body, as friction between them does.
        let braking = p[3].times(&p[3]).times(&point(&self.conductance));
        let between = p[5].plus(&braking);
        let (drag, wheel_drag) = (between.times(&over_d), between.times(&over_wheel));
        let (push, wheel_push) = (p[3].times(&over_d), p[3].times(&over_wheel));
        let a = [
            [R::nothing(), R::one(), R::nothing()],
            [gravity, friction.plus(&drag).negated(), drag.clone()],
            [R::nothing(), wheel_drag.clone(), wheel_drag.negated()],
        ];
        let b = [R::nothing(), push.negated(), wheel_push];

        // |A| T, which says how many terms are enough.
        let mut norm = Enclosure::zero();
        for row in &a {
            let sum = row.iter().fold(Enclosure::zero(), |sum, entry| {
                &sum + &entry.range().magnitude()
            });
            let sum = &sum * &Enclosure::point(&self.sample_time);
            if sum.largest() > norm.largest() {
                norm = sum;
            }
        }
        let unit = BigRational::from(norm.largest()) * crate::exact::rational::power_of_two(-192);
        if unit > integer(4) {
            return None;
        }
        // (exp(A T) − 1)/T = Σ A^k T^(k−1)/k!, and the same acting on B.
        let multiply = |x: &[[R; 3]; 3], y: &[[R; 3]; 3]| {
            [0, 1, 2].map(|i| {
                [0, 1, 2].map(|j| {
                    x[i][0]
                        .times(&y[0][j])
                        .plus(&x[i][1].times(&y[1][j]))
                        .plus(&x[i][2].times(&y[2][j]))
                })
            })
        };
        let mut series =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { R::one() } else { R::nothing() }));
        let mut term = series.clone();
        // x^k/(k + 1)! e^x bounds what is left after the k-th; e^4 < 55.
        let mut left = integer(55);
        for k in 2..=60 {
            let step = point(&(&self.sample_time / integer(k)));
            let next = multiply(&term, &a);
            term = next.map(|row| row.map(|entry| entry.times(&step)));
            for i in 0..3 {
                for j in 0..3 {
                    series[i][j] = series[i][j].plus(&term[i][j]);
                }
            }
            left = left * &unit / integer(k);
            if left < power(10, -20) {
                break;
            }
        }
        if left >= power(10, -20) {
            return None;
        }
        let rest = power(10, -20);
        let widening = Enclosure::new(&-rest.clone(), &rest);
        let series = series.map(|row| row.map(|entry| entry.widened(&widening)));
        let sampled = multiply(&series, &a);
        let input: Vec<R> = series
            .iter()
            .map(|row| {
                row[0]
                    .times(&b[0])
                    .plus(&row[1].times(&b[1]))
                    .plus(&row[2].times(&b[2]))
            })
            .collect();
        // u = N₁ α + N₂ α̇ + N₃ (ψ − α̇)
        let n = [
            point(&self.gains[0]),
            point(&(&self.gains[1] - &self.gains[2])),
            point(&self.gains[2]),
        ];
        Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| sampled[i][j].plus(&input[i].times(&n[j])))))
    }
}

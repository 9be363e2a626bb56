//! The linear model as a function of its parameters, for claim `stable-for-parameters`.
//!
//! In coordinates (angle, rate, absolute wheel speed ψ = α̇ + φ̇), D = Θ − j_w,
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
use crate::claims::held_loop::{HeldLoop, back_emf, held_gains};
use crate::claims::loop_as_shipped::small_gain::PlantOff;
use crate::claims::parameter_region::{Part, Region};
use crate::exact::enclosure::Enclosure;
use crate::exact::matrices::Vector;
use crate::exact::rational::{half, integer, power, power_of_two, rounded_up};
use crate::exact::slopes::{Number, Slopes};

/// How many parameters the linear model depends on.
pub(crate) const COUNT: usize = 7;

/// The parameters on which the linear model depends.
pub(crate) const NAMES: [&str; COUNT] = [
    "total_inertia",
    "wheel_inertia",
    "gravity_torque",
    "torque_constant",
    "body_viscous_friction",
    "wheel_viscous_friction",
    "body_coulomb_torque",
];

/// α̈ = gravity α − friction α̇ + drag φ̇ − push w and ψ̈ = −wheel drag φ̇ + wheel push w, with what the drive holds, w.
struct Accelerations<R> {
    gravity: R,
    friction: R,
    drag: R,
    push: R,
    wheel_drag: R,
    wheel_push: R,
}

/// The state of an observer in the loop. It does not depend on the parameters.
struct ObserverPart {
    /// From the state to what the drive holds (A/rad).
    held: BigRational,
    /// From the states of the plant into the next one.
    into: Vector,
    /// Of the state itself, less 1.
    change: BigRational,
}

/// The linear model as a function of its parameters.
pub(crate) struct Model {
    sample_time: BigRational,
    /// Of what the drive holds: what a reading of each state does to it at once.
    gains: Vector,
    /// Of an observer of the angle's bias.
    observer: Option<ObserverPart>,
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
    /// That of a certificate with these values.
    ///
    /// # Errors
    /// A sentence, where A and B do not follow from the values.
    pub(crate) fn new(
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
            gains: held_gains(&law.of_readings(), &back_emf(certificate)),
            observer: law.observer.as_ref().map(|observer| ObserverPart {
                held: -&law.gains[0],
                into: observer.into_state(&law.gains),
                change: observer.own_decay(&law.gains) - integer(1),
            }),
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
    pub(crate) fn judge(&self, p: &[BigRational]) -> Stability {
        let p: Vec<Enclosure> = p.iter().map(Enclosure::point).collect();
        self.closed(&p).map_or(Stability::Undecided, |closed| {
            judged(&closed, &self.sample_time)
        })
    }

    /// By slopes over the part of a region; and the coordinate whose interval moves the number in doubt the most.
    pub(crate) fn judge_part(&self, region: &Region, part: &Part) -> (Stability, Option<usize>) {
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

    /// What multiplies angle, rate, wheel speed and held current in the torques on the body, without signs.
    fn torques<R: Number>(&self, p: &[R]) -> [R; 4] {
        let point = R::constant;
        // The back-EMF brakes the wheel against the body, as friction between them does.
        let braking = p[3].times(&p[3]).times(&point(&self.conductance));
        [
            p[2].plus(&point(&self.extra_gravity)),
            p[4].plus(&point(&self.extra_friction))
                .plus(&p[6].times(&point(&self.dry_slope))),
            p[5].plus(&braking),
            p[3].clone(),
        ]
    }

    /// The entries of A and B; `None` where an inertia may be zero.
    fn accelerations<R: Number>(&self, p: &[R]) -> Option<Accelerations<R>> {
        let over_d = p[0].minus(&p[1]).over()?;
        let over_wheel = p[1].over()?;
        let [gravity, friction, between, torque] = self.torques(p);
        Some(Accelerations {
            gravity: gravity.times(&over_d),
            friction: friction.times(&over_d),
            drag: between.times(&over_d),
            push: torque.times(&over_d),
            wheel_drag: between.times(&over_wheel),
            wheel_push: torque.times(&over_wheel),
        })
    }

    /// How far the accelerations are from those of the certificate, for all vectors of the box around the region.
    pub(crate) fn off(&self, certificate: &Certificate, region: &Region) -> Option<PlantOff> {
        let both = region.values.iter().zip(&region.radii);
        let p: Vec<Enclosure> = both
            .map(|(value, radius)| Enclosure::new(&(value - radius), &(value + radius)))
            .collect();
        let d = &region.values[0] - &region.values[1];
        // Another inertia of the body scales its acceleration.
        let scale = &Enclosure::point(&d) * &(&p[0] - &p[1]).reciprocal()?;
        let torques = self.torques(&p);
        let over_d = Enclosure::point(&d.recip());
        let over_wheel = p[1].reciprocal()?;
        let stated = HeldLoop::of(certificate);
        let [_, body, wheel] = &stated.a;
        let size =
            |off: &Enclosure| BigRational::from(off.magnitude().largest()) * power_of_two(-192);
        let off = |found: Enclosure, stated: &BigRational| &found - &Enclosure::point(stated);
        let of_body = |index: usize, sign: i128, stated: &BigRational| {
            let sign = Enclosure::point(&integer(sign));
            let found = &(&torques[index] * &over_d) * &sign;
            size(&(&off(found, stated) * &scale))
        };
        // ψ̈ is the sum of both rows.
        let own = |j: usize| &wheel[j] + &body[j];
        let nothing = Enclosure::zero;
        Some(PlantOff {
            scale: size(&off(scale.clone(), &integer(1))),
            body: [
                of_body(0, 1, &body[0]),
                of_body(1, -1, &body[1]),
                of_body(2, 1, &body[2]),
                of_body(3, -1, &stated.b[1]),
            ],
            wheel: [
                size(&off(nothing(), &own(0))),
                size(&off(nothing(), &own(1))),
                size(&off(-&(&torques[2] * &over_wheel), &own(2))),
                size(&off(
                    &torques[3] * &over_wheel,
                    &(&stated.b[2] + &stated.b[1]),
                )),
            ],
        })
    }

    /// The closed loop in the form (F − 1)/T.
    fn closed<R: Number>(&self, p: &[R]) -> Option<Vec<Vec<R>>> {
        let point = R::constant;
        let Accelerations {
            gravity,
            friction,
            drag,
            push,
            wheel_drag,
            wheel_push,
        } = self.accelerations(p)?;
        let a = [
            [R::nothing(), R::one(), R::nothing()],
            [gravity, friction.plus(&drag).negated(), drag],
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
        let unit = BigRational::from(norm.largest()) * power_of_two(-192);
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
        let of_own_speed = |row: &Vector| [row[0].clone(), &row[1] - &row[2], row[2].clone()];
        let n = of_own_speed(&self.gains).map(|entry| point(&entry));
        let mut closed: Vec<Vec<R>> = (0..3)
            .map(|i| {
                let row = (0..3).map(|j| sampled[i][j].plus(&input[i].times(&n[j])));
                row.collect()
            })
            .collect();
        if let Some(observer) = &self.observer {
            for (row, input) in closed.iter_mut().zip(&input) {
                row.push(input.times(&point(&observer.held)));
            }
            let [angle, rate, speed] = of_own_speed(&observer.into);
            let row = [angle, rate, speed, observer.change.clone()];
            closed.push(
                row.map(|entry| point(&(entry / &self.sample_time)))
                    .to_vec(),
            );
        }
        Some(closed)
    }
}

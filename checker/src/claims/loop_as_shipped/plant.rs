//! The pendulum with viscous friction, sampled, under the emitted gains, for one delay. Its states z are those of [`Layout`].

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::held_loop::{HeldLoop, back_emf, braked, check_back_emf, held_gains, reach};
use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::layout::{Layout, PLANT, SquareGrid};
use crate::exact::grid::{BITS, Grid, above, exactly, on_grid, times};
use crate::exact::rational::{integer, power};

/// Delays whose loops are examined, in eighths of a sample: the middles of the four quarters of a sample.
pub const DELAYS: [i128; 4] = [1, 3, 5, 7];

/// Largest deviation of a delay from one of [`DELAYS`], as a share of a sample.
fn delay_off() -> BigRational {
    BigRational::new(1.into(), 8.into())
}

/// Number of terms of the exponential series. For |A| T ≤ 8 the remainder after them is less than 2⁻¹⁴⁴.
const TERMS: i128 = 120;

/// Terms of exp(A σ) v whose responses are added up one by one.
pub const PARTS: usize = 3;

/// Terms after the first [`PARTS`] that are bounded by their size; all later terms together are far smaller.
const LATER: usize = 12;

/// Parameters that enter A and B.
const OF_THE_MODEL: [&str; 6] = [
    "total_inertia",
    "wheel_inertia",
    "gravity_torque",
    "torque_constant",
    "body_viscous_friction",
    "wheel_viscous_friction",
];

/// Names of the torques that make up the body's dry friction. The friction is never larger than the larger of the two.
const ON_THE_BODY: [&str; 2] = ["body_coulomb_torque", "body_breakaway_torque"];

/// Names of the torques between body and wheel: those that make up the dry friction, which is never larger than the
/// larger of the two, and the cogging, which adds to it.
const ON_THE_WHEEL: [&str; 3] = [
    "wheel_coulomb_torque",
    "wheel_breakaway_torque",
    "cogging_torque",
];

/// Parameters that make the error of the current (A); the errors are added up.
const OF_THE_CURRENT: [&str; 2] = ["dead_zone", "current_offset"];

/// Parameters that change the shape of one of these torques, but not its size.
const SHAPES: [&str; 5] = [
    "body_stribeck_speed",
    "wheel_stribeck_speed",
    "body_presliding_stiffness",
    "cogging_order",
    "cogging_phase",
];

/// Quantities that a report derives from other parameters and from masses and lengths. They are in no equation of
/// motion.
const DERIVED: [&str; 1] = ["body_inertia"];

/// What moves, before it is sampled; the fields of [`Loop`] of the same names.
struct Bench {
    gravity: BigRational,
    a: [[BigRational; 3]; 3],
    b: [BigRational; 3],
    dry: BigRational,
    wheel_dry: BigRational,
    current_off: BigRational,
    delay_off: BigRational,
    /// B, e and e_w.
    directions: [[BigRational; 3]; 3],
}

/// The effect of an error of 1 in one sample.
#[derive(Clone, Debug)]
pub struct Reading {
    /// On what the drive holds, at once, of either sign (A).
    pub held: BigRational,
    /// On the current that the law asks for, at once, of either sign (A).
    pub asked: BigRational,
    /// On z, from the next sample on.
    pub column: Vec<Grid>,
}

/// One loop.
#[derive(Clone, Debug)]
pub struct Loop {
    /// Sample time (s).
    pub t: BigRational,
    /// g = G/D (1/s²).
    pub gravity: BigRational,
    /// A, viscous friction alone; with a voltage drive, that of the held voltage ([`crate::claims::held_loop`]).
    pub a: [[BigRational; 3]; 3],
    /// B.
    pub b: [BigRational; 3],
    /// Which states z has.
    pub layout: Layout,
    /// The row that gives the held current from z: N, plus the back-EMF's share if the drive sets a voltage.
    pub held: Vec<BigRational>,
    /// The current that the law asks for: N of z.
    pub asked: Vec<BigRational>,
    /// Largest command (A).
    pub limit: BigRational,
    /// Largest input that the drive holds (A): the current limit, or the supply voltage over the winding's resistance.
    pub reach: BigRational,
    /// Whether the supply voltage is a separate condition.
    pub has_supply: bool,
    /// Largest dry friction of the body over D (rad/s²).
    pub dry: BigRational,
    /// Largest dry torque between body and wheel (N m).
    pub wheel_dry: BigRational,
    /// The largest error of the current from the drive's dead zone and offset (A).
    pub current_off: BigRational,
    /// Largest deviation of the delay from this loop's, as a share of a sample.
    pub delay_off: BigRational,
    /// What one sample shows or computes wrong, as inputs of their own. An encoder on the pivot: its reading (rad).
    /// An observer of the angle's bias: the readings of angle, rate and wheel speed, the command (A), and the
    /// observer's state (rad); it knows the command with all errors. Otherwise none.
    pub readings: Vec<Reading>,
    /// ℓ of the observer; zero without one.
    pub direct: [BigRational; 3],
    /// The row that gives the estimated bias from z; zero without an observer.
    pub estimate: Vec<BigRational>,
    /// F on the grid.
    pub f: SquareGrid,
    /// Terms A^k v T^k/k! on the grid, of B, e and e_w, as columns of z.
    pub inputs: [[Vec<Grid>; PARTS]; 3],
    /// A bound on every entry of all later terms together, for B, e and e_w.
    pub later: [BigRational; 3],
    /// The largest entry of e_w.
    pub on_wheel: BigRational,
}

impl Loop {
    /// The loop with a delay of `eighths` of a sample.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of(
        certificate: &Certificate,
        law: &EmittedLaw,
        eighths: i128,
    ) -> Result<Loop, NoBounds> {
        let known = |name: &str| {
            [
                &OF_THE_MODEL[..],
                &ON_THE_BODY,
                &ON_THE_WHEEL,
                &OF_THE_CURRENT,
                &SHAPES,
                &DERIVED,
            ]
            .iter()
            .any(|list| list.contains(&name))
        };
        for parameter in &certificate.parameters {
            if !known(&parameter.name) {
                return Err(NoBounds::NotShown(format!(
                    "the argument does not hold the effect of the parameter {}",
                    parameter.name
                )));
            }
        }
        let find = |name: &str| {
            let found = certificate.parameters.iter().find(|p| p.name == name);
            found.map(|p| p.value.value.clone())
        };
        let need = |name: &str| {
            find(name).ok_or_else(|| {
                NoBounds::Unphysical(format!(
                    "the certificate does not state the parameter {name}"
                ))
            })
        };
        let size = |name: &str| find(name).unwrap_or_default().abs();
        let sum = |names: &[&str]| names.iter().map(|name| size(name)).sum::<BigRational>();

        let (theta, wheel) = (need("total_inertia")?, need("wheel_inertia")?);
        let d = &theta - &wheel;
        if !d.is_positive() || !wheel.is_positive() {
            return Err(NoBounds::Unphysical(
                "the inertias must satisfy total > wheel > 0".to_owned(),
            ));
        }
        let gravity = need("gravity_torque")? / &d;
        let torque = need("torque_constant")?;
        if !gravity.is_positive() || !torque.is_positive() {
            return Err(NoBounds::Unphysical(
                "gravity torque and torque constant are not positive".to_owned(),
            ));
        }
        for name in ["body_viscous_friction", "wheel_viscous_friction"] {
            if find(name).is_some_and(|value| value.is_negative()) {
                return Err(NoBounds::Unphysical(format!("{name} is negative")));
            }
        }
        let body = size("body_viscous_friction") / &d;
        let (drag, spin) = (
            size("wheel_viscous_friction") / &d,
            size("wheel_viscous_friction") * &theta / (&wheel * &d),
        );
        let zero = BigRational::zero;
        let a = [
            [zero(), integer(1), zero()],
            [gravity.clone(), -body.clone(), drag],
            [-gravity.clone(), body, -spin],
        ];
        let lever = &theta / (&wheel * &d);
        let b = [zero(), -&torque / &d, &torque * &lever];
        is_gravity_of_the_model(certificate, &gravity)?;
        check_back_emf(certificate).map_err(NoBounds::Unphysical)?;
        let body_dry = size(ON_THE_BODY[0]).max(size(ON_THE_BODY[1]));
        let wheel_dry = size(ON_THE_WHEEL[0]).max(size(ON_THE_WHEEL[1])) + size(ON_THE_WHEEL[2]);
        let bench = Bench {
            gravity,
            a: braked(&a, &b, &back_emf(certificate)),
            dry: body_dry / &d,
            wheel_dry,
            current_off: sum(&OF_THE_CURRENT),
            delay_off: delay_off(),
            directions: [
                b.clone(),
                [zero(), integer(1), integer(-1)],
                [zero(), integer(1) / &d, -lever],
            ],
            b,
        };
        Loop::with(certificate, law, bench, eighths)
    }

    /// The linear model as it is stated, its current without delay, dry friction and offset; gravity is that of A.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn as_stated(certificate: &Certificate, law: &EmittedLaw) -> Result<Loop, NoBounds> {
        let zero = BigRational::zero;
        Loop::stated_with(certificate, law, [zero(), zero(), zero()])
    }

    /// As [`Loop::as_stated`], with an acceleration of the wheel's own speed ψ = α̇ + φ̇ (rad/s²) as the third input.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn with_wheel_input(certificate: &Certificate, law: &EmittedLaw) -> Result<Loop, NoBounds> {
        let zero = BigRational::zero;
        Loop::stated_with(certificate, law, [zero(), zero(), integer(1)])
    }

    fn stated_with(
        certificate: &Certificate,
        law: &EmittedLaw,
        third: [BigRational; 3],
    ) -> Result<Loop, NoBounds> {
        let zero = BigRational::zero;
        let held = HeldLoop::of(certificate);
        let bench = Bench {
            gravity: held.a[1][0].clone(),
            dry: zero(),
            wheel_dry: zero(),
            current_off: zero(),
            delay_off: zero(),
            directions: [held.b.clone(), [zero(), integer(1), integer(-1)], third],
            a: held.a,
            b: held.b,
        };
        Loop::with(certificate, law, bench, 0)
    }

    /// The loop of a bench with a delay of `eighths` of a sample.
    fn with(
        certificate: &Certificate,
        law: &EmittedLaw,
        bench: Bench,
        eighths: i128,
    ) -> Result<Loop, NoBounds> {
        let Bench { a, b, .. } = &bench;
        let back_emf = back_emf(certificate);
        let t = certificate.sample_time_s.value.clone();
        if !t.is_positive() {
            return Err(NoBounds::Unphysical(
                "the sample time is not positive".to_owned(),
            ));
        }
        let late = &t * integer(eighths) / integer(8);
        let (ad, whole) = sampled(a, b, &t)?;
        // The effect of the new command in the rest of the sample, after the delay.
        let (_, new) = sampled(a, b, &(&t - late))?;
        let layout = Layout::of(certificate)?;
        if law.observer.is_some() != layout.observer().is_some() {
            return Err(NoBounds::Unphysical(
                "source and certificate do not agree on an observer of the angle's bias".to_owned(),
            ));
        }
        let of_readings = law.of_readings();
        let held_readings = held_gains(&of_readings, &back_emf);
        let of_observer = -&law.gains[0];
        let held = layout.row(&held_readings, &of_observer, &t);
        let asked = layout.row(&of_readings, &of_observer, &t);
        let (zero, one) = (BigRational::zero(), integer(1));
        let sample = |held: &BigRational, asked: &BigRational, into: &BigRational| Reading {
            held: held.abs(),
            asked: asked.abs(),
            column: layout.reading(&new, held, into),
        };
        let mut readings = Vec::new();
        let mut own = None;
        let (direct, estimate) = match &law.observer {
            Some(observer) => {
                let into = observer.into_state(&law.gains);
                for i in 0..3 {
                    readings.push(sample(&held_readings[i], &of_readings[i], &into[i]));
                }
                readings.push(sample(&one, &one, &observer.from_current));
                readings.push(sample(&zero, &zero, &one));
                own = Some(layout.row(&into, &observer.own_decay(&law.gains), &t));
                (
                    observer.direct.clone(),
                    layout.row(&observer.direct, &one, &t),
                )
            }
            None => (
                [0, 1, 2].map(|_| zero.clone()),
                vec![zero.clone(); layout.order()],
            ),
        };
        if !layout.angles().is_empty() {
            // The back-EMF's share does not depend on the angle.
            readings.push(sample(&held[0], &held[0], &zero));
        }
        let f = layout.closed(&ad, &whole, &new, &held, own.as_deref());

        // With the wheel's angle, whose rate is the wheel's speed.
        let sums = a.iter().map(|row| row.iter().map(Signed::abs).sum());
        let norm = sums.chain([integer(1)]).max().unwrap_or_default() * &t;
        if norm >= integer(1) {
            return Err(NoBounds::NotShown(
                "the sample time is too long for the argument: |A| T is above 1".to_owned(),
            ));
        }
        // Σ_{k ≥ n} x^k/k! ≤ x^n/n! · 1/(1 − x) for x < 1.
        let mut rest = integer(1) / (integer(1) - &norm);
        for k in 1..=LATER {
            rest = rest * &norm / integer(k as i128);
        }
        let mut inputs: [[Vec<Grid>; PARTS]; 3] = Default::default();
        let mut later: [BigRational; 3] = Default::default();
        for (index, v) in bench.directions.iter().enumerate() {
            let largest = |v: &[BigRational]| v.iter().map(Signed::abs).max().unwrap_or_default();
            later[index] = &rest * largest(v);
            let [angle, rate, speed] = v.clone();
            let mut term = [angle, rate, speed, BigRational::zero()];
            for k in 0..LATER {
                match inputs[index].get_mut(k) {
                    Some(part) => *part = layout.column(&term.each_ref().map(on_grid)),
                    None => later[index] += largest(&term),
                }
                term = [0, 1, 2, 3].map(|i| {
                    let sum: BigRational = match a.get(i) {
                        Some(row) => row.iter().zip(&term).map(|(x, y)| x * y).sum(),
                        None => term[2].clone(),
                    };
                    sum * &t / integer(k as i128 + 1)
                });
            }
        }
        let later = later.map(|sum| exactly(&above(&sum)));
        let [_, _, wheel_direction] = &bench.directions;
        let on_wheel = wheel_direction
            .iter()
            .map(Signed::abs)
            .max()
            .unwrap_or_default();
        Ok(Loop {
            reach: reach(certificate).unwrap_or_else(|| law.limit.clone()),
            has_supply: certificate.drive.voltage.is_some(),
            limit: law.limit.clone(),
            t,
            layout,
            held,
            asked,
            readings,
            direct,
            estimate,
            f,
            inputs,
            later,
            on_wheel,
            gravity: bench.gravity,
            a: bench.a,
            b: bench.b,
            dry: bench.dry,
            wheel_dry: bench.wheel_dry,
            current_off: bench.current_off,
            delay_off: bench.delay_off,
        })
    }
}

/// The stated A falls with the gravity of the parameters; a spring would need another argument.
fn is_gravity_of_the_model(
    certificate: &Certificate,
    gravity: &BigRational,
) -> Result<(), NoBounds> {
    let stated = &certificate.plant.a[1][0].value;
    if (stated - gravity).abs() <= gravity * power(10, -5) {
        Ok(())
    } else {
        Err(NoBounds::Unphysical(format!(
            "A[1][0] is {}, the parameters make it {}",
            crate::exact::rational::rounded_up(stated, 7),
            crate::exact::rational::rounded_up(gravity, 7)
        )))
    }
}

/// exp(A t) and ∫ exp(A s) B ds over 0 ≤ s ≤ t, on the grid, with the wheel's angle as the last state.
fn sampled(
    a: &[[BigRational; 3]; 3],
    b: &[BigRational; 3],
    t: &BigRational,
) -> Result<([[Grid; PLANT]; PLANT], [Grid; PLANT]), NoBounds> {
    const SIZE: usize = PLANT + 1;
    // Columns of (A 0 B; e₃ᵀ 0 0; 0 0 0) t.
    let mut m = vec![vec![Grid::zero(); SIZE]; SIZE];
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = on_grid(&(&a[i][j] * t));
        }
        m[i][PLANT] = on_grid(&(&b[i] * t));
    }
    m[3][2] = on_grid(t);
    let too_long = m.iter().any(|row| {
        let sum: BigInt = row.iter().map(Signed::abs).sum();
        sum > BigInt::from(8) << BITS
    });
    if too_long {
        return Err(NoBounds::NotShown(
            "the sample time is too long for the series".to_owned(),
        ));
    }
    let one = BigInt::from(1) << BITS;
    let mut term = vec![vec![Grid::zero(); SIZE]; SIZE];
    for (i, row) in term.iter_mut().enumerate() {
        row[i].clone_from(&one);
    }
    let mut total = term.clone();
    for k in 1..=TERMS {
        term = product(&term, &m);
        for entry in term.iter_mut().flatten() {
            *entry = &*entry / k;
        }
        for (sum, entry) in total.iter_mut().flatten().zip(term.iter().flatten()) {
            *sum += entry;
        }
    }
    let ad = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| total[i][j].clone()));
    let bd = [0, 1, 2, 3].map(|i| total[i][PLANT].clone());
    Ok((ad, bd))
}

/// a · b on the grid.
pub fn product(a: &SquareGrid, b: &SquareGrid) -> SquareGrid {
    a.iter()
        .map(|row| {
            let mut found = vec![Grid::zero(); b.len()];
            for (entry, other) in row.iter().zip(b).filter(|(entry, _)| !entry.is_zero()) {
                for (sum, x) in found.iter_mut().zip(other).filter(|(_, x)| !x.is_zero()) {
                    *sum += times(entry, x);
                }
            }
            found
        })
        .collect()
}

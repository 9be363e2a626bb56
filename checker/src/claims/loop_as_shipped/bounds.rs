//! Bounds that reproduce themselves from one step to the next, and the largest start for which such bounds exist.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::claims::emitted_observer::EmittedObserver;
use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::carried::ROWS;
use crate::claims::loop_as_shipped::errors::SensorErrors;
use crate::claims::loop_as_shipped::inertial::MotionBounds;
use crate::claims::loop_as_shipped::plant::Loop;
use crate::claims::loop_as_shipped::responses::{
    ACCELERATIONS, ASKED, CHANGE, ESTIMATE, HELD, Responses,
};
use crate::exact::rational::{half, integer, power_of_two, short_above as up};

/// Number of rounds in which bounds are enlarged until they reproduce themselves.
const ROUNDS: usize = 200;
/// Halvings of the start.
const HALVINGS: usize = 24;
/// Largest start that is looked at (rad).
const LARGEST_START: i128 = 1;

/// Bounds that hold at every step.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Angle, rate and wheel speed (rad, rad/s, rad/s), between samples too.
    pub states: [BigRational; 3],
    /// The command, errors included (A).
    pub command: BigRational,
    /// Error of the shown angle: of the filter, or of a reading of an encoder on the pivot (rad).
    pub angle: BigRational,
    /// The estimated bias of the angle; zero without an observer (rad).
    pub estimate: BigRational,
    rows: [BigRational; ROWS],
}

/// Why bounds do not close.
enum Open {
    /// A command may reach the limit, or a state the end of its range. A smaller start may still work.
    TooLarge(String),
    /// They grow without end.
    Grows(String),
}

impl Open {
    fn why(self) -> String {
        match self {
            Open::TooLarge(why) | Open::Grows(why) => why,
        }
    }
}

/// The quantities that make a bound grow. Each is rounded up to few digits.
struct Growth {
    t: BigRational,
    gravity: BigRational,
    /// |A|.
    a: [[BigRational; 3]; 3],
    /// |B|.
    b: [BigRational; 3],
    dry: BigRational,
    /// The largest change of angle, rate and wheel speed by a dry torque on the wheel; that of the angle is zero.
    lever: [BigRational; 3],
}

impl Growth {
    fn of(model: &Loop) -> Growth {
        let size = |value: &BigRational| up(value.abs());
        Growth {
            t: up(model.t.clone()),
            gravity: size(&model.gravity),
            a: model.a.each_ref().map(|row| row.each_ref().map(size)),
            b: model.b.each_ref().map(size),
            dry: up(model.dry.clone()),
            // e_w of the plant: zero, 1/D, Θ/(j_w D), which is the acceleration by a current divided by the torque
            // constant.
            lever: [0, 1, 2].map(|i| {
                up(model.wheel_dry.clone() * &model.on_wheel * integer(i128::from(i > 0)))
            }),
        }
    }
}

/// States between samples.
struct Between {
    states: [BigRational; 3],
    motion: MotionBounds,
    /// g |sin α − α| (rad/s²).
    sine: BigRational,
}

/// From the bounds at the samples to bounds between them. As long as the states stay within `b`, the rows of the model
/// bound their change in one sample. If that change cannot reach `b`, the states never leave `b`.
fn between(growth: &Growth, rows: &[BigRational; ROWS], current: &BigRational) -> Option<Between> {
    let sine = |angle: &BigRational| up(&growth.gravity * angle * angle * angle / integer(6));
    let mut b: [BigRational; 3] = [0, 1, 2].map(|i| rows[i].clone());
    for _ in 0..ROUNDS {
        let outer = sine(&b[0]);
        let reached: [BigRational; 3] = [0, 1, 2].map(|i| {
            let mut rate = &growth.b[i] * current + &growth.lever[i];
            for (entry, bound) in growth.a[i].iter().zip(&b) {
                rate += entry * bound;
            }
            if i > 0 {
                rate += &growth.dry + &outer;
            }
            &rows[i] + up(&growth.t * rate)
        });
        if reached.iter().zip(&b).all(|(new, old)| new < old) {
            // The acceleration at the sample, and its change by angle, rate and wheel speed until the next sample.
            let mut drift = BigRational::zero();
            for j in 0..3 {
                drift += &growth.a[1][j] * (&b[j] - &rows[j]);
            }
            let at_sample = ACCELERATIONS.iter().map(|row| &rows[*row]).max()?;
            // With a delay the current was commanded one sample earlier, which adds one change of the current.
            let acceleration = up(at_sample + drift + &growth.dry + &outer + &growth.lever[1]);
            return Some(Between {
                motion: MotionBounds {
                    acceleration,
                    rate: b[1].clone(),
                },
                sine: outer,
                states: b,
            });
        }
        b = reached.map(|value| up(value * (integer(1) + power_of_two(-20)) + power_of_two(-60)));
    }
    None
}

/// The bounds at the next step that follow from bounds that held until now.
struct Following {
    rows: [BigRational; ROWS],
    between: Between,
    /// All errors of the current that the drive holds (A).
    noise: BigRational,
    /// The current that the law requests, errors included (A).
    asked: BigRational,
    /// The estimated bias of the angle, errors included (rad).
    estimate: BigRational,
}

/// What the inputs of one sample with these sizes do to the held current at once (A).
fn at_once(model: &Loop, sizes: &[BigRational]) -> BigRational {
    let both = model.readings.iter().zip(sizes);
    up(both.map(|(reading, size)| &reading.held * size).sum())
}

/// What they do to the current that the law asks for (A).
fn asked_at_once(model: &Loop, sizes: &[BigRational]) -> BigRational {
    let both = model.readings.iter().zip(sizes);
    both.map(|(reading, size)| &reading.asked * size).sum()
}

/// What they do to a row over all time.
fn of_readings(responses: &Responses, sizes: &[BigRational], row: usize) -> BigRational {
    let both = responses.readings.iter().zip(sizes);
    both.map(|(sums, size)| &sums[row] * size).sum()
}

/// The motion between samples, and the errors that follow from it.
struct Settled {
    between: Between,
    /// The error of the held current, without the immediate effect of the inputs of one sample, which the loop
    /// contains itself (A).
    noise: BigRational,
    /// The sizes of these inputs.
    sizes: Vec<BigRational>,
    /// Their immediate effect on the held current (A).
    at_once: BigRational,
}

/// Bounds of the motion between samples while the drive holds at most `current`.
fn settled(
    model: &Loop,
    growth: &Growth,
    errors: &SensorErrors,
    rows: &[BigRational; ROWS],
    current: &BigRational,
) -> Result<Settled, Open> {
    let mut between = between(growth, rows, current)
        .ok_or_else(|| Open::Grows("the motion between two samples does not settle".to_owned()))?;
    // The acceleration depends on the errors of the current, which depend on the acceleration.
    let plain = between.motion.acceleration.clone();
    let too_large = |open: NoBounds| Open::TooLarge(open.to_string());
    let (mut noise, mut of_sample) = (BigRational::zero(), BigRational::zero());
    for _ in 0..ROUNDS {
        between.motion.acceleration = up(&plain + &growth.b[1] * (&noise + &of_sample));
        let next = errors.held(&between.motion).map_err(too_large)? + &model.current_off;
        let sizes = errors.of_sample(&between.motion).map_err(too_large)?;
        let next_of_sample = at_once(model, &sizes);
        if next <= noise && next_of_sample <= of_sample {
            return Ok(Settled {
                between,
                noise,
                sizes,
                at_once: of_sample,
            });
        }
        let enlarged = |value: BigRational| up(value * (integer(1) + power_of_two(-30)));
        (noise, of_sample) = (enlarged(next), enlarged(next_of_sample));
    }
    Err(Open::TooLarge(
        "the age of the gyroscope's readings feeds on itself".to_owned(),
    ))
}

/// `start` is the angle at rest; `None` once nothing is left of the start and of the errors before it.
fn following(
    model: &Loop,
    responses: &Responses,
    errors: &SensorErrors,
    rows: &[BigRational; ROWS],
    start: Option<&BigRational>,
) -> Result<Following, Open> {
    // First the held current is bounded by the end of the drive and its errors. This gives a second bound, the
    // requested current with its error, and the smaller of the two counts.
    let growth = Growth::of(model);
    let end = up(&model.reach + &model.current_off + &errors.rounding);
    let first = settled(model, &growth, errors, rows, &end)?;
    let held = &rows[HELD] + first.noise + first.at_once;
    let Settled {
        between,
        noise,
        sizes,
        at_once,
    } = settled(model, &growth, errors, rows, &end.min(held))?;
    let body = &growth.dry + &between.sine;
    let late = &model.delay_off * (&rows[CHANGE] + &at_once);
    let of_estimate = errors.estimate(&model.direct, &sizes);
    let none = BigRational::zero();
    let (start, before) = match start {
        Some(start) => (start, before_start(errors, &of_estimate)),
        None => (&none, none.clone()),
    };
    let first = &model.delay_off * &responses.first_change * start;
    let rows: [BigRational; ROWS] = std::array::from_fn(|row| {
        up(start * &responses.start[row]
            + &responses.sums[0][row] * (&noise + &late)
            + &responses.sums[1][row] * &body
            + &responses.sums[2][row] * &model.wheel_dry
            + of_readings(responses, &sizes, row)
            + &responses.before[row] * &before
            + &responses.kick[row] * &first)
    });
    let of_law = errors
        .asked(&between.motion)
        .map_err(|open| Open::TooLarge(open.to_string()))?;
    Ok(Following {
        asked: &rows[ASKED] + of_law + asked_at_once(model, &sizes),
        estimate: &rows[ESTIMATE] + of_estimate,
        rows,
        between,
        noise: noise + at_once,
    })
}

/// The size of the errors before the start: of the encoder on the pivot at rest, or of the state of an observer that
/// waits, which is as wrong as the estimate, and rounded (rad).
fn before_start(errors: &SensorErrors, of_estimate: &BigRational) -> BigRational {
    match &errors.observer {
        Some(_) => of_estimate + EmittedObserver::state_rounding(),
        None => errors.at_rest.clone(),
    }
}

/// Bound of the observer's state z = b̂ − ℓᵀ y, for a bound of the estimate, and of the states with their errors.
fn state_of_observer(
    model: &Loop,
    estimate: &BigRational,
    states: &[BigRational; 3],
    of_estimate: &BigRational,
) -> BigRational {
    let of_states = model.direct.iter().zip(states);
    let sum: BigRational = of_states.map(|(entry, bound)| entry.abs() * bound).sum();
    estimate + sum + of_estimate
}

impl Bounds {
    /// Bound of the state of an observer with this ℓ (rad).
    #[must_use]
    pub fn state_of_observer(&self, model: &Loop) -> BigRational {
        let of_estimate = &self.estimate - &self.rows[ESTIMATE];
        state_of_observer(model, &self.estimate, &self.states, &of_estimate)
    }

    /// Bounds from rest at any angle up to `start`.
    ///
    /// # Errors
    /// [`NoBounds::NotShown`].
    pub fn from_rest(
        model: &Loop,
        responses: &Responses,
        errors: &SensorErrors,
        start: &BigRational,
    ) -> Result<Bounds, NoBounds> {
        closing(model, responses, errors, start).map_err(|open| NoBounds::NotShown(open.why()))
    }

    /// The larger of each.
    #[must_use]
    pub fn larger(self, other: Bounds) -> Bounds {
        let mut all = self;
        for (own, theirs) in all.states.iter_mut().zip(other.states) {
            *own = own.clone().max(theirs);
        }
        for (own, theirs) in all.rows.iter_mut().zip(other.rows) {
            *own = own.clone().max(theirs);
        }
        all.command = all.command.max(other.command);
        all.angle = all.angle.max(other.angle);
        all.estimate = all.estimate.max(other.estimate);
        all
    }
}

/// By how much another loop would go on in a different way from the same state, in every step.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// Of the held current (A).
    pub held: BigRational,
    /// Of the next state of an observer of the angle's bias (rad).
    pub state: BigRational,
}

/// Bounds of the difference between two loops from equal starts, at the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Of angle, rate and wheel speed (rad, rad/s, rad/s).
    pub states: [BigRational; 3],
    /// Of the current that the law asks for (A).
    pub command: BigRational,
}

impl Difference {
    /// The difference to a loop without any error, whose numbers are besides other ones. The body is shown by an
    /// encoder on the pivot, or directly.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of(
        model: &Loop,
        responses: &Responses,
        errors: &SensorErrors,
        apart: &Apart,
    ) -> Result<Difference, NoBounds> {
        // The errors of such sensors do not depend on the motion.
        let still = MotionBounds::still();
        let noise = errors.held(&still)? + &apart.held;
        let mut sizes = errors.of_sample(&still)?;
        let before = before_start(errors, &errors.estimate(&model.direct, &sizes));
        let at_once = asked_at_once(model, &sizes);
        if let (Some(_), Some(of_state)) = (&errors.observer, sizes.last_mut()) {
            *of_state += &apart.state;
        }
        let row = |row: usize| {
            up(&responses.sums[0][row] * &noise
                + of_readings(responses, &sizes, row)
                + &responses.before[row] * &before)
        };
        Ok(Difference {
            states: [row(0), row(1), row(2)],
            command: up(row(ASKED) + errors.asked(&still)? + at_once + &apart.held),
        })
    }
}

fn closing(
    model: &Loop,
    responses: &Responses,
    errors: &SensorErrors,
    start: &BigRational,
) -> Result<Bounds, Open> {
    let mut rows: [BigRational; ROWS] = std::array::from_fn(|row| {
        up(start * &responses.start[row] + &responses.before[row] * &errors.at_rest)
    });
    for _ in 0..ROUNDS {
        let next = following(model, responses, errors, &rows, Some(start))?;
        let command = next.asked.clone();
        if command >= model.limit {
            return Err(Open::TooLarge("the command may reach its limit".to_owned()));
        }
        if model.has_supply && &next.rows[HELD] + &next.noise >= model.reach {
            return Err(Open::TooLarge(
                "the voltage may reach the end of the supply".to_owned(),
            ));
        }
        if let Some(observer) = &errors.observer {
            let of_estimate = &next.estimate - &next.rows[ESTIMATE];
            let state =
                state_of_observer(model, &next.estimate, &next.between.states, &of_estimate);
            if next.estimate >= observer.limit || state >= EmittedObserver::state_range() {
                return Err(Open::TooLarge(
                    "the estimated bias of the angle may come to its limit".to_owned(),
                ));
            }
        }
        let leans = &next.between.states[0] * model.gravity.clone();
        if leans >= model.b[1].abs() * &model.limit {
            return Err(Open::TooLarge(
                "the body may lean further than the current holds it".to_owned(),
            ));
        }
        let [angle, rate, speed] = &next.between.states;
        if let Some(why) = errors.beyond(angle, rate, &next.between.motion) {
            return Err(Open::TooLarge(why.to_owned()));
        }
        if speed + &errors.wheel_speed >= errors.wheel_range {
            return Err(Open::TooLarge(
                "the wheel's sensor may come to the end of its range".to_owned(),
            ));
        }
        if next.rows.iter().zip(&rows).all(|(new, old)| new <= old) {
            let angle = errors
                .angle(&next.between.motion)
                .map_err(|open| Open::TooLarge(open.to_string()))?;
            return Ok(Bounds {
                states: next.between.states,
                command,
                angle,
                estimate: next.estimate,
                rows,
            });
        }
        rows = std::array::from_fn(|row| {
            let larger = next.rows[row].clone().max(rows[row].clone());
            up(larger * (integer(1) + power_of_two(-12)))
        });
    }
    Err(Open::Grows("the bounds grow without end".to_owned()))
}

/// The largest start at rest for which bounds close, to one part in 2²⁴ of a radian.
///
/// # Errors
/// [`NoBounds::NotShown`] where there are none even from upright.
pub fn largest_start(
    model: &Loop,
    responses: &Responses,
    errors: &SensorErrors,
) -> Result<BigRational, NoBounds> {
    closing(model, responses, errors, &BigRational::zero())
        .map_err(|open| NoBounds::NotShown(format!("even from upright {}", open.why())))?;
    let (mut low, mut high) = (BigRational::zero(), integer(LARGEST_START));
    for _ in 0..HALVINGS {
        let middle = (&low + &high) * half();
        if closing(model, responses, errors, &middle).is_ok() {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}

/// The bounds that every motion in `bounds` finally reaches and does not leave: the next bounds, computed again and
/// again without the influence of the start.
///
/// # Errors
/// [`NoBounds::NotShown`].
pub fn kept_up(
    model: &Loop,
    responses: &Responses,
    errors: &SensorErrors,
    bounds: &Bounds,
) -> Result<Bounds, NoBounds> {
    let not_shown = |open: Open| NoBounds::NotShown(open.why());
    let mut kept = bounds.clone();
    for _ in 0..ROUNDS {
        let next = following(model, responses, errors, &kept.rows, None).map_err(not_shown)?;
        let settles = next
            .rows
            .iter()
            .zip(&kept.rows)
            .all(|(new, old)| new * (integer(1) + power_of_two(-12)) >= *old);
        let rows = std::array::from_fn(|row| next.rows[row].clone().min(kept.rows[row].clone()));
        kept = Bounds {
            command: next.asked,
            angle: errors.angle(&next.between.motion)?,
            estimate: next.estimate,
            states: next.between.states,
            rows,
        };
        if settles {
            break;
        }
    }
    Ok(kept)
}

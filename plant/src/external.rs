//! Effects that are defined while the program runs: by a user's file, by a curve that was learned, or by another
//! crate.
//!
//! Such an effect computes with plain numbers and returns its partial derivatives. The chain rule carries them over
//! to the number type of the model, so the integrator needs no further compilation.
//! [`EffectId::of`] makes such an effect from any type that implements the ordinary [`Effect`].

use std::any::type_name;
use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::marker::PhantomData;
use std::sync::{Mutex, PoisonError};

use crate::effect::{Effect, EffectInfo, Instant, Role, Smoothing};
use crate::{BASE_PARAMETERS, Dual, EffectId, Output, Reading, Scalar};

/// Partial derivatives of the result of an external effect, with respect to all its inputs. All are 0 when
/// the effect is called; the effect writes those that are not.
#[derive(Debug)]
pub struct Partials<'a> {
    /// With respect to the members of the instant.
    pub at: Instant<f64>,
    /// With respect to the current in A.
    pub current_a: f64,
    /// With respect to the torque constant in N m/A.
    pub torque_constant: f64,
    /// With respect to the members of the reading.
    pub reading: Reading<f64>,
    /// With respect to each parameter.
    pub p: &'a mut [f64],
}

/// The equations of an effect for plain numbers. An effect implements those that its [`Role`] requires, as
/// in [`Effect`]; `p` holds its parameters in SI units, and the derivatives are written to `partials`.
///
/// Derivatives must be exact: with wrong ones, a fit ends away from the minimum.
pub trait ExternalEffect: Send + Sync {
    /// Torque in N m against the motion of body or wheel (roles `Body` and `Wheel`). The torque depends on the
    /// instant alone; [`Instant::memory`] is 0.
    fn torque(
        &self,
        _p: &[f64],
        _at: &Instant<f64>,
        _v0: &Smoothing,
        _partials: &mut Partials,
    ) -> f64 {
        0.0
    }

    /// A static stage of the motor chain: input current in A to output current in A (role `Motor`). The stages of the
    /// library come before it.
    fn current(
        &self,
        _p: &[f64],
        current_a: f64,
        _at: &Instant<f64>,
        _torque_constant: f64,
        partials: &mut Partials,
    ) -> f64 {
        partials.current_a = 1.0;
        current_a
    }

    /// The reading of the sensor that the effect distorts ([`EffectInfo::senses`]), from the undistorted readings of all
    /// sensors (role `Sensor`).
    fn measured(
        &self,
        _p: &[f64],
        output: Output,
        reading: &Reading<f64>,
        partials: &mut Partials,
    ) -> f64 {
        *output.part_of(&mut partials.reading) = 1.0;
        output.of(reading)
    }
}

/// An external effect as it is defined.
pub struct Definition {
    /// The description. Its references must live as long as the program (`String::leak`, `Vec::leak`).
    pub info: EffectInfo,
    /// The equations.
    pub equations: Box<dyn ExternalEffect>,
}

impl Definition {
    /// The definition of a type that implements the ordinary [`Effect`].
    pub fn of<E: Effect + Send + Sync + 'static>() -> Definition {
        Definition {
            info: E::INFO,
            equations: Box::new(Adapted::<E>(PhantomData)),
        }
    }
}

/// The reason why an external effect cannot be defined.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExternalError {
    /// The library has an effect of this name.
    #[error("the library already has an effect called {name}")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// The description contradicts itself.
    #[error("the description of the effect {name} is not valid: {what}")]
    Incomplete {
        /// The name.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
}

/// An effect that was defined while the program runs. Equal definitions are the same effect.
#[derive(Clone, Copy)]
pub struct External(&'static Registered);

struct Registered {
    content: String,
    definition: Definition,
}

impl Registered {
    fn key(&self) -> (&str, &str) {
        (self.definition.info.name, &self.content)
    }
}

impl std::fmt::Debug for External {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "External({})", self.info().name)
    }
}

impl PartialEq for External {
    fn eq(&self, other: &External) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for External {}

impl Hash for External {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.key().hash(state);
    }
}

impl PartialOrd for External {
    fn partial_cmp(&self, other: &External) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Ordered by name and content, so that the order does not depend on which was defined first.
impl Ord for External {
    fn cmp(&self, other: &External) -> Ordering {
        self.0.key().cmp(&other.0.key())
    }
}

/// All external effects so far. An entry lives as long as the program, so that an [`EffectId`] stays a
/// plain value. The same content is entered only once.
static REGISTRY: Mutex<Vec<&'static Registered>> = Mutex::new(vec![]);

impl EffectId {
    /// The effect that `content` defines. The content must hold everything on which the definition depends (the text
    /// of its file). `define` is called only for content that is new, so the memory that it leaks is leaked only once.
    ///
    /// # Errors
    /// If the library has an effect with this name, or the description is not valid.
    pub fn external(
        content: &str,
        define: impl FnOnce() -> Definition,
    ) -> Result<EffectId, ExternalError> {
        let mut registry = REGISTRY.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = registry.iter().find(|known| known.content == content) {
            return Ok(EffectId::External(External(known)));
        }
        let definition = define();
        check(&definition.info)?;
        let entry: &'static Registered = Box::leak(Box::new(Registered {
            content: content.to_owned(),
            definition,
        }));
        registry.push(entry);
        Ok(EffectId::External(External(entry)))
    }

    /// An external effect from a type that implements the ordinary [`Effect`], in any crate.
    ///
    /// # Errors
    /// As [`EffectId::external`].
    pub fn of<E: Effect + Send + Sync + 'static>() -> Result<EffectId, ExternalError> {
        EffectId::external(type_name::<E>(), Definition::of::<E>)
    }
}

fn check(info: &EffectInfo) -> Result<(), ExternalError> {
    let name = info.name.to_owned();
    if EffectId::from_name(info.name).is_some() {
        return Err(ExternalError::NameTaken { name });
    }
    let count = info.parameters.len();
    let sets = || info.starts.iter().chain(info.absent.iter());
    let names: Vec<&str> = info.parameters.iter().map(|one| one.name).collect();
    let is_twice = |name: &&str| names.iter().filter(|other| *other == name).count() > 1;
    let is_base = |name: &&str| BASE_PARAMETERS.iter().any(|base| base.name == *name);
    let what = if info.name.is_empty() {
        "it has no name"
    } else if count == 0 {
        "it has no parameter"
    } else if names.iter().any(|name| is_twice(name) || is_base(name)) {
        "two of its parameters have the same name, or one has the name of a base parameter"
    } else if info.starts.is_empty() {
        "it states no start values for a fit"
    } else if sets().any(|set| set.len() != count) {
        "a set of start values does not have one value per parameter"
    } else if info.shows_in.is_empty() {
        "it states no experiment in which it is visible"
    } else if info.memory.is_some() || info.timing.is_some() || info.sensor_timing.is_some() {
        "only effects of the library may have memory, lag or delay"
    } else if (info.role == Role::Sensor) != info.senses.is_some() {
        "an effect on a sensor must state which sensor it distorts, and no other effect may state one"
    } else {
        return Ok(());
    };
    Err(ExternalError::Incomplete { name, what })
}

/// Number of parameters up to which an evaluation needs no heap allocation.
const FEW_PARAMETERS: usize = 16;

/// The instant without its derivatives.
fn plain<S: Scalar>(at: &Instant<S>) -> Instant<f64> {
    Instant {
        angle_rad: at.angle_rad.value(),
        rate_rad_s: at.rate_rad_s.value(),
        wheel_angle_rad: at.wheel_angle_rad.value(),
        wheel_speed_rad_s: at.wheel_speed_rad_s.value(),
        current_a: at.current_a.value(),
        memory: at.memory.value(),
    }
}

const NO_INSTANT: Instant<f64> = Instant {
    angle_rad: 0.0,
    rate_rad_s: 0.0,
    wheel_angle_rad: 0.0,
    wheel_speed_rad_s: 0.0,
    current_a: 0.0,
    memory: 0.0,
};

const NO_READING: Reading<f64> = Reading {
    angle_rad: 0.0,
    rate_rad_s: 0.0,
    wheel_speed_rad_s: 0.0,
};

/// Receives an input and the partial derivative with respect to it.
type Pair<'a, S> = dyn FnMut(S, f64) + 'a;

/// Calls `evaluate` with the values of the parameters and extends its result by the chain rule:
/// df = Σ ∂f/∂x dx over the parameters and over the further inputs. `pairs` passes each of these inputs
/// with its partial derivative.
fn lifted<S: Scalar>(
    p: &[S],
    evaluate: &mut dyn FnMut(&[f64], &mut Partials) -> f64,
    pairs: &dyn Fn(&Partials, &mut Pair<S>),
) -> S {
    let mut stack = [0.0; 2 * FEW_PARAMETERS];
    let mut heap = vec![];
    let room: &mut [f64] = if p.len() <= FEW_PARAMETERS {
        &mut stack[..2 * p.len()]
    } else {
        heap.resize(2 * p.len(), 0.0);
        &mut heap
    };
    let (values, slopes) = room.split_at_mut(p.len());
    for (value, parameter) in values.iter_mut().zip(p) {
        *value = parameter.value();
    }
    let mut partials = Partials {
        at: NO_INSTANT,
        current_a: 0.0,
        torque_constant: 0.0,
        reading: NO_READING,
        p: slopes,
    };
    let value = evaluate(values, &mut partials);
    let mut result = S::constant(value);
    let mut add = |input: S, slope: f64| {
        if slope != 0.0 {
            result += input.chain(0.0, slope);
        }
    };
    pairs(&partials, &mut add);
    for (&parameter, &slope) in p.iter().zip(partials.p.iter()) {
        add(parameter, slope);
    }
    result
}

/// The members of the instant with their partial derivatives.
fn of_instant<S: Scalar>(at: &Instant<S>, partials: &Partials, add: &mut Pair<S>) {
    add(at.angle_rad, partials.at.angle_rad);
    add(at.rate_rad_s, partials.at.rate_rad_s);
    add(at.wheel_angle_rad, partials.at.wheel_angle_rad);
    add(at.wheel_speed_rad_s, partials.at.wheel_speed_rad_s);
    add(at.current_a, partials.at.current_a);
}

// Not inlined, so that built-in effects have no cost from them.
impl External {
    /// The description.
    pub(crate) fn info(self) -> &'static EffectInfo {
        &self.0.definition.info
    }

    fn equations(self) -> &'static dyn ExternalEffect {
        self.0.definition.equations.as_ref()
    }

    /// [`Effect::torque`].
    #[inline(never)]
    pub(crate) fn torque<S: Scalar>(self, p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        let values = plain(at);
        lifted(
            p,
            &mut |p, partials| self.equations().torque(p, &values, v0, partials),
            &|partials, add| of_instant(at, partials, add),
        )
    }

    /// [`Effect::current`].
    #[inline(never)]
    pub(crate) fn current<S: Scalar>(
        self,
        p: &[S],
        current_a: S,
        at: &Instant<S>,
        torque_constant: S,
    ) -> S {
        let values = plain(at);
        let (current, constant) = (current_a.value(), torque_constant.value());
        lifted(
            p,
            &mut |p, partials| {
                let equations = self.equations();
                equations.current(p, current, &values, constant, partials)
            },
            &|partials, add| {
                of_instant(at, partials, add);
                add(current_a, partials.current_a);
                add(torque_constant, partials.torque_constant);
            },
        )
    }

    /// [`Effect::distort`].
    #[inline(never)]
    pub(crate) fn distort<S: Scalar>(self, p: &[S], reading: &mut Reading<S>) {
        let Some(output) = self.info().senses else {
            return;
        };
        let before = *reading;
        let values = Reading {
            angle_rad: before.angle_rad.value(),
            rate_rad_s: before.rate_rad_s.value(),
            wheel_speed_rad_s: before.wheel_speed_rad_s.value(),
        };
        *output.part_of(reading) = lifted(
            p,
            &mut |p, partials| self.equations().measured(p, output, &values, partials),
            &|partials, add| {
                for output in Output::ALL {
                    add(output.of(&before), output.of(&partials.reading));
                }
            },
        );
    }
}

/// An ordinary [`Effect`] as an external one: its equations, with derivatives from dual numbers.
struct Adapted<E>(PhantomData<E>);

/// Number of variables that are differentiated in one pass.
const AT_ONCE: usize = 8;
type Numbers = Dual<AT_ONCE>;
/// Makes a variable out of a value and its index.
type Variable<'a> = dyn Fn(f64, usize) -> Numbers + 'a;

/// Calls `evaluate` as often as needed to differentiate with respect to `count` variables. `variable(value, index)` is
/// the variable with this index, and `each` receives the index and the derivative. Returns the value.
fn differentiated(
    count: usize,
    evaluate: &mut dyn FnMut(&Variable) -> Numbers,
    each: &mut dyn FnMut(usize, f64),
) -> f64 {
    let mut value = 0.0;
    for first in (0..count).step_by(AT_ONCE) {
        let variable = |value: f64, index: usize| {
            // An index outside of this pass gives a constant.
            Numbers::variable(value, index.checked_sub(first).unwrap_or(AT_ONCE))
        };
        let result = evaluate(&variable);
        value = result.value;
        let last = AT_ONCE.min(count - first);
        for (lane, &derivative) in result.derivatives[..last].iter().enumerate() {
            each(first + lane, derivative);
        }
    }
    value
}

/// The parameters as variables, after `before` others.
fn parameters(p: &[f64], before: usize, variable: &Variable) -> Vec<Numbers> {
    p.iter()
        .enumerate()
        .map(|(index, &value)| variable(value, before + index))
        .collect()
}

/// Number of the variables of an instant.
const OF_INSTANT: usize = 5;

/// The instant as the first variables.
fn instant(at: &Instant<f64>, variable: &Variable) -> Instant<Numbers> {
    Instant {
        angle_rad: variable(at.angle_rad, 0),
        rate_rad_s: variable(at.rate_rad_s, 1),
        wheel_angle_rad: variable(at.wheel_angle_rad, 2),
        wheel_speed_rad_s: variable(at.wheel_speed_rad_s, 3),
        current_a: variable(at.current_a, 4),
        memory: Numbers::constant(at.memory),
    }
}

/// The place for the derivative with respect to a member of the instant; `None` for a higher index.
fn slope_of_instant(at: &mut Instant<f64>, index: usize) -> Option<&mut f64> {
    match index {
        0 => Some(&mut at.angle_rad),
        1 => Some(&mut at.rate_rad_s),
        2 => Some(&mut at.wheel_angle_rad),
        3 => Some(&mut at.wheel_speed_rad_s),
        4 => Some(&mut at.current_a),
        _ => None,
    }
}

impl<E: Effect + Send + Sync> ExternalEffect for Adapted<E> {
    fn torque(&self, p: &[f64], at: &Instant<f64>, v0: &Smoothing, partials: &mut Partials) -> f64 {
        const BEFORE: usize = OF_INSTANT;
        differentiated(
            BEFORE + p.len(),
            &mut |variable| E::torque(&parameters(p, BEFORE, variable), &instant(at, variable), v0),
            &mut |index, slope| match slope_of_instant(&mut partials.at, index) {
                Some(place) => *place = slope,
                None => partials.p[index - BEFORE] = slope,
            },
        )
    }

    fn current(
        &self,
        p: &[f64],
        current_a: f64,
        at: &Instant<f64>,
        torque_constant: f64,
        partials: &mut Partials,
    ) -> f64 {
        const CURRENT: usize = OF_INSTANT;
        const TORQUE_CONSTANT: usize = CURRENT + 1;
        const BEFORE: usize = TORQUE_CONSTANT + 1;
        differentiated(
            BEFORE + p.len(),
            &mut |variable| {
                E::current(
                    &parameters(p, BEFORE, variable),
                    variable(current_a, CURRENT),
                    &instant(at, variable),
                    variable(torque_constant, TORQUE_CONSTANT),
                )
            },
            &mut |index, slope| match (index, slope_of_instant(&mut partials.at, index)) {
                (_, Some(place)) => *place = slope,
                (CURRENT, _) => partials.current_a = slope,
                (TORQUE_CONSTANT, _) => partials.torque_constant = slope,
                _ => partials.p[index - BEFORE] = slope,
            },
        )
    }

    fn measured(
        &self,
        p: &[f64],
        output: Output,
        reading: &Reading<f64>,
        partials: &mut Partials,
    ) -> f64 {
        let before = Output::ALL.len();
        differentiated(
            before + p.len(),
            &mut |variable| {
                let mut distorted = Reading {
                    angle_rad: variable(reading.angle_rad, 0),
                    rate_rad_s: variable(reading.rate_rad_s, 1),
                    wheel_speed_rad_s: variable(reading.wheel_speed_rad_s, 2),
                };
                E::distort(&parameters(p, before, variable), &mut distorted);
                output.of(&distorted)
            },
            &mut |index, slope| match Output::ALL.get(index) {
                Some(&output) => *output.part_of(&mut partials.reading) = slope,
                None => partials.p[index - before] = slope,
            },
        )
    }
}

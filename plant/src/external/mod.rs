//! Effects that are defined while the program runs: by a user's file, by a curve that was learned, or by another
//! crate.
//!
//! Such an effect computes with plain numbers and returns its partial derivatives. The chain rule carries them over
//! to the number type of the model, so the integrator needs no further compilation.
//! [`EffectId::of`] makes such an effect from any type that implements the ordinary [`Effect`].

mod adapted;
mod lifted;

use std::any::type_name;
use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::marker::PhantomData;
use std::sync::{Mutex, PoisonError};

use crate::effect::{Effect, EffectInfo, Instant, Role, Smoothing};
use crate::{BASE_PARAMETERS, EffectId, Output, Reading};
use adapted::Adapted;

/// Partial derivatives of the result of an external effect, with respect to all its inputs. All are 0 when
/// the effect is called; the effect writes those that are not.
#[derive(Debug)]
pub struct Partials<'a> {
    /// Derivatives with respect to the members of the instant.
    pub at: Instant<f64>,
    /// Derivative with respect to the current in A.
    pub current_a: f64,
    /// Derivative with respect to the torque constant in N m/A.
    pub torque_constant: f64,
    /// Derivatives with respect to the members of the reading.
    pub reading: Reading<f64>,
    /// Derivatives with respect to the parameters.
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

    /// The reading of the sensor that the effect distorts ([`EffectInfo::senses`]), from the undistorted readings of
    /// all sensors (role `Sensor`).
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
    #[error("the library already has an effect called {name}; choose another name")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// The description contradicts itself.
    #[error("the description of the effect {name} is not valid: {what}")]
    Incomplete {
        /// The name.
        name: String,
        /// The mistake, in words.
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

impl External {
    /// The description.
    pub(crate) fn info(self) -> &'static EffectInfo {
        &self.0.definition.info
    }

    fn equations(self) -> &'static dyn ExternalEffect {
        self.0.definition.equations.as_ref()
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
    /// If the library has an effect with this name, or the description is not valid.
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

//! The library of effects: one file each, and the list of them.

use crate::effect::{Effect, EffectInfo, Instant, Role, Smoothing, Unbalance};
use crate::external::External;
use crate::per_log::PerLog;
use crate::{Reading, Scalar};

/// The equation of an effect if it has the requested role. The role is a constant, so a loop over the
/// terms of the body contains no code for those of the wheel.
macro_rules! of_role {
    ($effect:path, $role:pat, $equation:ident($($argument:expr),*), $otherwise:expr) => {
        match <$effect as Effect>::INFO.role {
            $role => <$effect as Effect>::$equation($($argument),*),
            _ => $otherwise,
        }
    };
}

/// Declares the modules and the enum of their effects. The order of the list is the order in
/// which terms are evaluated (which matters in the motor chain and for the sensors) and reported.
macro_rules! effects {
    ($($module:ident :: $effect:ident),* $(,)?) => {
        $(mod $module;)*

        /// An effect: one of the library, or one that was defined while the program runs.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum EffectId {
            $(
                #[doc = concat!("See the file `effects/", stringify!($module), ".rs`.")]
                $effect,
            )*
            /// One that was defined while the program runs ([`EffectId::external`]).
            External(External),
            /// One of the library made for the logs of a bench ([`EffectId::for_logs`]).
            PerLog(PerLog),
        }

        impl EffectId {
            /// Every effect of the library, in the order in which terms are evaluated.
            // An external effect comes after all of them.
            pub const ALL: &'static [EffectId] = &[$(EffectId::$effect),*];

            /// The description of the effect.
            pub fn info(self) -> &'static EffectInfo {
                match self {
                    $(EffectId::$effect => {
                        const INFO: EffectInfo = <$module::$effect as Effect>::INFO;
                        &INFO
                    })*
                    EffectId::External(external) => external.info(),
                    EffectId::PerLog(made) => made.info(),
                }
            }

            /// [`Effect::torque`] of an effect that acts on the body.
            #[inline(always)]
            pub(crate) fn torque_on_body<S: Scalar>(self, p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
                match self {
                    $(EffectId::$effect => of_role!($module::$effect, Role::Body, torque(p, at, v0), S::zero()),)*
                    EffectId::External(external) => external.torque(p, at, v0),
                    EffectId::PerLog(_) => S::zero(),
                }
            }

            /// [`Effect::torque`] of an effect that acts on the wheel.
            #[inline(always)]
            pub(crate) fn torque_on_wheel<S: Scalar>(self, p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
                match self {
                    $(EffectId::$effect => of_role!($module::$effect, Role::Wheel, torque(p, at, v0), S::zero()),)*
                    EffectId::External(external) => external.torque(p, at, v0),
                    EffectId::PerLog(_) => S::zero(),
                }
            }

            /// [`Effect::unbalance`]; `None` if the effect is no unbalance of the wheel.
            #[inline(always)]
            pub(crate) fn unbalance<S: Scalar>(self, p: &[S], at: &Instant<S>) -> Option<Unbalance<S>> {
                match self {
                    $(EffectId::$effect if <$module::$effect as Effect>::INFO.is_unbalance => {
                        Some(<$module::$effect as Effect>::unbalance(p, at))
                    })*
                    _ => None,
                }
            }

            /// [`Effect::remember`].
            #[inline(always)]
            pub(crate) fn remember<S: Scalar>(self, p: &[S], memory: S, displacement_rad: S) -> S {
                match self {
                    $(EffectId::$effect => $module::$effect::remember(p, memory, displacement_rad),)*
                    EffectId::External(_) | EffectId::PerLog(_) => memory,
                }
            }

            /// [`Effect::current`].
            #[inline(always)]
            pub fn current<S: Scalar>(self, p: &[S], current_a: S, at: &Instant<S>, torque_constant: S) -> S {
                match self {
                    $(EffectId::$effect => $module::$effect::current(p, current_a, at, torque_constant),)*
                    EffectId::External(external) => external.current(p, current_a, at, torque_constant),
                    EffectId::PerLog(_) => current_a,
                }
            }

            /// [`Effect::lag_s`].
            #[inline(always)]
            pub(crate) fn lag_s<S: Scalar>(self, p: &[S]) -> Option<S> {
                match self {
                    $(EffectId::$effect => $module::$effect::lag_s(p),)*
                    EffectId::External(_) | EffectId::PerLog(_) => None,
                }
            }

            /// [`Effect::delay_s`].
            #[inline(always)]
            pub(crate) fn delay_s<S: Scalar>(self, p: &[S]) -> Option<S> {
                match self {
                    $(EffectId::$effect => $module::$effect::delay_s(p),)*
                    EffectId::External(_) | EffectId::PerLog(_) => None,
                }
            }

            /// [`Effect::distort`].
            #[inline(always)]
            pub fn distort<S: Scalar>(self, p: &[S], reading: &mut Reading<S>) {
                match self {
                    $(EffectId::$effect => $module::$effect::distort(p, reading),)*
                    EffectId::External(external) => external.distort(p, reading),
                    // In each log, the library effect behind this one is evaluated with the parameter of that log
                    // ([`crate::Plant::for_log`]).
                    EffectId::PerLog(_) => {}
                }
            }
        }
    };
}

effects! {
    body_viscous_friction::BodyViscousFriction,
    wheel_viscous_friction::WheelViscousFriction,
    body_coulomb_friction::BodyCoulombFriction,
    body_stribeck_friction::BodyStribeckFriction,
    body_presliding_friction::BodyPreslidingFriction,
    body_quadratic_drag::BodyQuadraticDrag,
    body_cable_spring::BodyCableSpring,
    body_softening_spring::BodySofteningSpring,
    wheel_coulomb_friction::WheelCoulombFriction,
    wheel_stribeck_friction::WheelStribeckFriction,
    wheel_quadratic_drag::WheelQuadraticDrag,
    wheel_cogging::WheelCogging,
    wheel_unbalance::WheelUnbalance,
    input_delay::InputDelay,
    motor_lag::MotorLag,
    back_emf_limit::BackEmfLimit,
    motor_dead_zone::MotorDeadZone,
    current_offset::CurrentOffset,
    motor_saturation::MotorSaturation,
    angle_eccentricity::AngleEccentricity,
    angle_offset::AngleOffset,
    angle_zero::AngleZero,
    gyro_scale::GyroScale,
    gyro_bias::GyroBias,
    rate_lag::RateLag,
    wheel_speed_lag::WheelSpeedLag,
    angle_delay::AngleDelay,
    rate_delay::RateDelay,
    wheel_speed_delay::WheelSpeedDelay,
}

impl EffectId {
    /// The effect of the library with this name, if it has one.
    pub fn from_name(name: &str) -> Option<EffectId> {
        EffectId::ALL
            .iter()
            .copied()
            .find(|effect| effect.info().name == name)
    }

    /// The name in model.toml, on the command line and in every report.
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// Whether a limit is reached: the motor stage with the parameters `p` changes this current in A at
    /// this wheel speed in rad/s. `torque_constant` is in N m/A.
    pub fn is_reached(
        self,
        p: &[f64],
        current_a: f64,
        wheel_speed_rad_s: f64,
        torque_constant: f64,
    ) -> bool {
        let at = Instant {
            angle_rad: 0.0,
            rate_rad_s: 0.0,
            wheel_angle_rad: 0.0,
            wheel_speed_rad_s,
            current_a: 0.0,
            memory: 0.0,
        };
        self.current(p, current_a, &at, torque_constant) != current_a
    }

    /// [`Effect::torque`] for body or wheel, whichever the effect acts on: torque against the motion in N m.
    pub fn torque<S: Scalar>(self, p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        match self.info().role {
            Role::Body => self.torque_on_body(p, at, v0),
            Role::Wheel => self.torque_on_wheel(p, at, v0),
            Role::Motor | Role::Sensor => S::zero(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::EffectId;

    #[test]
    fn what_is_confused_with_an_effect_exists_and_says_so_too() {
        for effect in EffectId::ALL {
            for other in effect.info().confused_with {
                let other = EffectId::from_name(other).unwrap_or_else(|| panic!("{other}"));
                let back = other.info().confused_with;
                assert!(
                    back.contains(&effect.name()),
                    "{} and {}",
                    effect.name(),
                    other.name()
                );
            }
        }
    }

    #[test]
    fn every_effect_explains_itself() {
        for info in EffectId::ALL.iter().map(|effect| effect.info()) {
            for text in [info.equation, info.meaning, info.source, info.fingerprint] {
                assert!(!text.is_empty(), "{}", info.name);
            }
            assert!(!info.shows_in.is_empty(), "{}", info.name);
        }
    }
}

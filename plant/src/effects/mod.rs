//! The library of effects: one file each, and the list of them.

use crate::Scalar;
use crate::effect::{Effect, EffectInfo, Instant, MAX_PARAMETERS, Reading, Smoothing};

/// Declares the modules and the enum that stands for them. The order of the list is the order in
/// which terms are evaluated (it matters in the motor chain and for the sensors) and reported.
macro_rules! effects {
    ($($module:ident :: $effect:ident),* $(,)?) => {
        $(mod $module;)*

        /// An effect of the library.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum EffectId {
            $(
                #[doc = concat!("See the file `effects/", stringify!($module), ".rs`.")]
                $effect,
            )*
        }

        impl EffectId {
            /// Every effect, in the order in which terms are evaluated.
            pub const ALL: &'static [EffectId] = &[$(EffectId::$effect),*];

            /// The description of the effect.
            pub fn info(self) -> &'static EffectInfo {
                match self {
                    $(EffectId::$effect => {
                        const INFO: EffectInfo = <$module::$effect as Effect>::INFO;
                        &INFO
                    })*
                }
            }

            /// [`Effect::torque`].
            #[inline(always)]
            pub(crate) fn torque<S: Scalar>(self, p: &[S; MAX_PARAMETERS], at: &Instant<S>, v0: &Smoothing) -> S {
                match self { $(EffectId::$effect => $module::$effect::torque(p, at, v0),)* }
            }

            /// [`Effect::remember`].
            #[inline(always)]
            pub(crate) fn remember<S: Scalar>(self, p: &[S; MAX_PARAMETERS], memory: S, displacement_rad: S) -> S {
                match self { $(EffectId::$effect => $module::$effect::remember(p, memory, displacement_rad),)* }
            }

            /// [`Effect::current`].
            #[inline(always)]
            pub(crate) fn current<S: Scalar>(self, p: &[S; MAX_PARAMETERS], current_a: S, at: &Instant<S>, torque_constant: S) -> S {
                match self { $(EffectId::$effect => $module::$effect::current(p, current_a, at, torque_constant),)* }
            }

            /// [`Effect::lag_s`].
            #[inline(always)]
            pub(crate) fn lag_s<S: Scalar>(self, p: &[S; MAX_PARAMETERS]) -> Option<S> {
                match self { $(EffectId::$effect => $module::$effect::lag_s(p),)* }
            }

            /// [`Effect::delay_s`].
            #[inline(always)]
            pub(crate) fn delay_s<S: Scalar>(self, p: &[S; MAX_PARAMETERS]) -> Option<S> {
                match self { $(EffectId::$effect => $module::$effect::delay_s(p),)* }
            }

            /// [`Effect::distort`].
            #[inline(always)]
            pub(crate) fn distort<S: Scalar>(self, p: &[S; MAX_PARAMETERS], reading: &mut Reading<S>) {
                match self { $(EffectId::$effect => $module::$effect::distort(p, reading),)* }
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
    wheel_quadratic_drag::WheelQuadraticDrag,
    wheel_cogging::WheelCogging,
    input_delay::InputDelay,
    motor_lag::MotorLag,
    back_emf_limit::BackEmfLimit,
    motor_dead_zone::MotorDeadZone,
    current_offset::CurrentOffset,
    motor_saturation::MotorSaturation,
    angle_offset::AngleOffset,
    gyro_scale::GyroScale,
    gyro_bias::GyroBias,
}

impl EffectId {
    /// The effect with this name in the contract, if the library has it.
    pub fn from_name(name: &str) -> Option<EffectId> {
        EffectId::ALL
            .iter()
            .copied()
            .find(|effect| effect.info().name == name)
    }

    /// The name in the contract.
    pub fn name(self) -> &'static str {
        self.info().name
    }
}

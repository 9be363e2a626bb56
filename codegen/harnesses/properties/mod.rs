//! One module for each part of the emitted crate.

#[cfg(not(body_encoder))]
pub mod attitude;
pub mod control;
#[cfg(any(body_encoder, wheel_encoder))]
pub mod encoder;
#[cfg(not(any(body_encoder, wheel_encoder, voltage_drive)))]
pub mod modes;
pub mod step;
pub mod supervisor;

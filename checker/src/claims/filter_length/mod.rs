//! Claim `filter-length`: the quaternion norm stays within 1 ± 2⁻¹¹ (squared); [`check`] has the
//! argument.

pub mod algebra;
pub mod aligned;
pub mod check;
pub mod choices;
pub mod correction;
pub mod inverse_root;
pub mod normalised;
pub mod sources;
pub mod turned;

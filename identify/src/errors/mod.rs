//! The uncertainty of a fit, and contradictions between its sources.
//!
//! | file | job |
//! |---|---|
//! | `spectral`, `covariance` | standard errors that account for correlated residuals |
//! | `estimate` | a minimum with its standard errors |
//! | `contradiction` | experiments and known values that cannot all be right |
//! | `without_value` | parameters that the logs determine only together with others |
//! | `body_inertia` | whether masses and lengths agree with the identified inertia |

mod body_inertia;
mod contradiction;
mod covariance;
mod estimate;
mod spectral;
mod without_value;

pub use body_inertia::{body_inertia, body_inertia_contradiction};
pub use contradiction::{Contradiction, Side, contradictions};
pub use covariance::{pseudo_inverse, stuck};
pub use estimate::{Fit, finish};
pub use without_value::{WithoutValue, without_value};

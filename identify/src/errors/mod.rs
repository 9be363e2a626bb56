//! How sure a fit is, and where its sources disagree.
//!
//! | file | job |
//! |---|---|
//! | `spectral`, `covariance` | standard errors that account for correlated residuals |
//! | `estimate` | a minimum with them |
//! | `contradiction` | experiments and knowns that cannot all be right |
//! | `body_inertia` | what masses and lengths say against the inertia that was found |

mod body_inertia;
mod contradiction;
mod covariance;
mod estimate;
mod spectral;

pub use body_inertia::{body_inertia, body_inertia_contradiction};
pub use contradiction::{Contradiction, Side, contradictions};
pub use covariance::{pseudo_inverse, stuck};
pub use estimate::{Fit, finish};

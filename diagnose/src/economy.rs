//! The numbers that only save computing time or limit the length of a list. A more patient choice of any of
//! them would make the search slower without changing how it decides. The numbers that decide a verdict stand
//! in `thresholds.rs`.

/// Samples per period of the pendulum at which the search reads the logs. One sample every tenth of a radian of
/// phase is about one integration step.
pub const SAMPLES_PER_PERIOD: f64 = 63.0;
/// Largest number of times that a search is repeated because its result changes how the logs should be read.
pub const MOST_REVISIONS: usize = 2;
/// Largest number of effects that one diagnosis adds.
pub const MOST_EFFECTS: usize = 4;
/// Number of candidates that each round extends further. More than one, because the best single effect need not
/// be part of the best pair.
pub const BEAM: usize = 2;
/// Number of best candidates whose fits must have converged before they are compared.
pub const FINISHED: usize = 3;
/// Largest number of suspects that are fitted in one round. The score test ranks them first.
pub const MOST_FITS: usize = 8;
/// Largest number of suspects in the report.
pub const MOST_SUSPECTS: usize = 6;

/// Structured remainder, in units of the sensor's noise, up to which a free-running simulation is close enough
/// to the measurement for its sensitivities to be used.
pub const NEAR: f64 = 5.0;
/// Number of samples in every series from which on a starting model that leaves no structure needs no search. An effect
/// must lower the error of a series by 0.2 of its noise (`least_trace`). So much structure, if it lasts for 16 samples,
/// stands out by eight standard deviations from this many samples ([`identify::structure`], with the uncertainty of
/// the noise): it would have been seen.
pub const CONCLUSIVE_SAMPLES: usize = 8_000;
/// Length, in periods, of the short windows in which effects are scored where the free run drifts away from
/// the log.
pub const WINDOW_PERIODS: f64 = 3.0;

/// Largest number of nuisance parameters (such as the start of the motion) of one window.
pub const MOST_LOCALS: usize = 6;
/// Largest number of starting points from which one suspect is fitted.
pub const MOST_STARTS: usize = 2;
/// Zero offset b of the angle, in rad, above which a fit that assumes no offset is useless as a starting point.
/// At 0.1 rad, the first-order expansion of sin(α + b) in b is wrong by half a percent.
pub const LARGE_ZERO_RAD: f64 = 0.1;
/// A suspect is not fitted if its promised gain is less than this share of the best suspect's, and no other suspect
/// refines it.
pub const LEAST_SHARE: f64 = 0.1;
/// Where one effect contains another, the simpler one is tried first if it promises at least this share of the
/// larger one's gain.
pub const SIMPLER_SHARE: f64 = 0.9;

/// If the fit in short windows lowers the cost by more than this share, and the fit over the whole logs does not
/// lower it at all, the whole logs are fitted again from scratch.
pub const MUCH: f64 = 0.1;
/// Once a fit has reached this share of the gain that another start promises, that start is not fitted.
pub const KEPT_SHARE: f64 = 0.9;
/// A fit plainly misses something if its cost exceeds the cost expected of noise alone by this factor.
pub const STILL_MISSES: f64 = 2.0;

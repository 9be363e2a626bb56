//! The numbers that only save time, or bound the length of a list: with more patience in each of them the
//! search would do the same work more slowly. What decides a verdict stands in `thresholds.rs`.

/// Samples in a period of the pendulum with which effects are searched for: a tenth of a radian of its
/// oscillation, about one step of the integration, lies between two of them.
pub const SAMPLES_PER_PERIOD: f64 = 63.0;
/// Most times that a search is repeated because its result shows the logs in another light.
pub const MOST_REVISIONS: usize = 2;
/// Most effects that are added in one diagnosis.
pub const MOST_EFFECTS: usize = 4;
/// How many sets are extended further in each round: the best first step need not belong to the
/// best pair.
pub const BEAM: usize = 2;
/// How many of the best candidates must have reached their minimum before they are compared.
pub const FINISHED: usize = 3;
/// Most suspects that are fitted in one round; the score test has sorted out the others.
pub const MOST_FITS: usize = 8;
/// Most suspects that are reported.
pub const MOST_SUSPECTS: usize = 6;

/// Structured remainder, in units of noise, up to which a free run is close enough to the
/// measurement for its sensitivities to mean something.
pub const NEAR: f64 = 5.0;
/// Periods in the short windows in which effects are scored where the free run has drifted away.
pub const WINDOW_PERIODS: f64 = 3.0;

/// Most unknowns that a window has of its own.
pub const MOST_LOCALS: usize = 6;
/// Most starts of one suspect that are fitted.
pub const MOST_STARTS: usize = 2;
/// A shifted zero of the angle beyond which a fit that does not know of it tells nothing: to first
/// order sin(α + b) is then wrong by half a percent.
pub const LARGE_ZERO_RAD: f64 = 0.1;
/// A suspect that promises less than this share of the best one's gain is not fitted.
pub const LEAST_SHARE: f64 = 0.1;
/// An effect goes before one that contains it if it promises at least this share of its gain.
pub const SIMPLER_SHARE: f64 = 0.9;

/// Share of the cost in short windows whose gain makes a fit over the whole logs that brings nothing
/// worth a second schedule from short windows to long ones.
pub const MUCH: f64 = 0.1;
/// A fit that brings this share of what another start promises makes that start needless.
pub const KEPT_SHARE: f64 = 0.9;
/// Cost, in that of the noise alone, above which a fit plainly misses something.
pub const STILL_MISSES: f64 = 2.0;

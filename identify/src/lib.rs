//! Identification: from logs to parameters with their uncertainty.
//!
//! Each module uses only those above it in this table.
//!
//! | room | job |
//! |---|---|
//! | `progress` | progress messages of long work, and its cancellation |
//! | `records` | logs as the fit uses them: channels with their noise, the current, windows; the weak form |
//! | `model_free` | results without a model: how a swing decays, the rate compared with the angle, the teeth of a motor |
//! | `fit` | from a first guess to the minimum: windows with exact derivatives, least squares, score test |
//! | `residuals` | the residual of a model: noise or structure, the missing torque, pushes, where the model fails |
//! | `bench` | a whole bench: which parameters are known, which are free, in which units |
//! | `errors` | standard errors under correlated residuals; contradictions between experiments and known values |
//! | `first_fit` | the fit of the base model, from several starts where one is not enough |
//! | `shape_search` | where the fit of an effect from outside may begin |
//! | `learned` | the missing torque as a curve, and its fit together with everything else |
//! | `extension` | from the minimum of a model to that of a larger one |
//! | `identification`, `statements` | the complete result for a bench, with all statements about it |
//! | `neighbour` | a fit that also starts from the minimum of a model with an effect more or less |

mod bench;
mod errors;
mod extension;
mod first_fit;
mod fit;
mod fourier;
mod identification;
mod learned;
mod model_free;
mod neighbour;
mod progress;
mod records;
mod residuals;
mod shape_search;
mod statements;

pub use bench::{FitProblem, HELD_START, IdentifyError, SPARSE_COMMANDS, commands_per_row};
pub use errors::{
    Contradiction, Fit, Side, WithoutValue, body_inertia, body_inertia_contradiction,
    contradictions, finish, pseudo_inverse, stuck, without_value,
};
pub use extension::{carry_over, extend};
pub use fit::{
    CoggingStart, Effort, KnownScore, MAX_UNKNOWNS, Minimum, NoBetterThanMean, Nuisance,
    Observation, Outcome, PredictedSeries, Ratios, RecordScore, ScoreStep, ScoreTest, Unknowns,
    Window, WindowNormal, acts, base_values, cogging_start, cost, cost_of_means, failed_series,
    final_windows, fit_from_scratch, fit_windowed, guessed, is_of_wheel, joined, minimise, normal,
    normal_observed, ratios, refit, relevant, score_test, settled, simulate, traces,
    traces_that_count,
};
pub use identification::{
    Identification, describe, fit_until, identify, identify_until, open_inertia, refuse_failed,
    with_curves,
};
pub use learned::{CurvePoint, MissingCurve, best_missing_curve, missing_curve};
pub use model_free::{
    AtAmplitude, DecayLaw, Estimate, FreeDecay, HeldStart, RateAgainstAngle, decay, held_start,
    rate_against_angle,
};
pub use neighbour::fit_from_neighbour;
pub use progress::{Cancelled, Progress};
pub use records::{
    BALANCE_WINDOW_S, Output, Record, RecordedChannel, RecordedCurrent, StepTimes, UnknownStep,
    WeakForm, angle_samples, bumps, input_noise_std, noise_std, resolution,
};
pub use residuals::{
    BreakdownBin, Coordinate, CorrelationTest, Discrepancy, ExplainedTorque, FailureMap,
    FailureRegion, FoundPush, LAGS, MeasuredMotion, NoisySeries, PushModel, ResidualBreakdown,
    ResidualKind, ResidualStructure, ResidualTorque, SIGNIFICANT, TorqueOn, autocorrelation,
    breakdown, cross_correlation, effective_samples, find_pushes, half_bump, leave_out,
    residual_torque, residual_torques, structure, without_rounding,
};
pub use shape_search::shaped_start;
pub use statements::left_open;

//! The result of a breakdown: bins of a residual over a coordinate, and the regions where a model fails.

use super::super::residual_torque::TorqueOn;
use super::coordinate::Coordinate;

/// The residual that is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResidualKind {
    /// The torque that the model lacks, N m.
    ResidualTorque,
    /// Measured minus free-running simulation, in the unit of the channel.
    Output,
}

/// One bin of a breakdown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreakdownBin {
    /// Lower edge in the unit of the coordinate.
    pub from: f64,
    /// Upper edge.
    pub to: f64,
    /// Number of values in the bin. For a torque, it is a number of bumps: a bump that passes through several bins
    /// counts in each of them with its share.
    pub count: f64,
    /// Mean residual in the bin, in the unit of the residual.
    pub mean: f64,
    /// Standard error of the mean. It accounts for overlapping bumps, and for the residual that the coordinate does not
    /// explain.
    pub mean_std: f64,
    /// The part that changes its sign with the speed (positive along the motion), in the same unit; NaN if not fitted.
    pub along_motion: f64,
    /// Standard error of [`BreakdownBin::along_motion`].
    pub along_motion_std: f64,
    /// Share of the bin in this record's squared error above the noise, from 0 to 1. The shares of a torque add up to the
    /// explained share, those of an output to 1.
    pub share: f64,
}

/// One residual of one record, over one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualBreakdown {
    /// The experiment's name.
    pub experiment: String,
    /// The channel, as in "experiment/channel".
    pub channel: &'static str,
    /// Which residual.
    pub quantity: ResidualKind,
    /// The coordinate.
    pub coordinate: Coordinate,
    /// Standard deviation of the noise of one value, in the unit of the residual.
    pub noise_std: f64,
    /// The bins in rising order, without gaps.
    pub bins: Vec<BreakdownBin>,
}

/// A region of a coordinate in which the model fails.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureRegion {
    /// The experiment's name.
    pub experiment: String,
    /// The channel, as in "experiment/channel".
    pub channel: &'static str,
    /// The residual in which it was found.
    pub quantity: ResidualKind,
    /// The coordinate in which the region is given.
    pub coordinate: Coordinate,
    /// Lower end in the unit of the coordinate.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// The stretches of the log's time in which the coordinate lies in the region: first and last instant, s, in
    /// rising order.
    pub stretches_s: Vec<[f64; 2]>,
    /// Share of this record's squared error above the noise that lies in the region, from 0 to 1.
    pub share_of_error: f64,
    /// Squared error above the noise in the region, in units of the squared noise of one value.
    pub size: f64,
    /// Whether the residual is larger than noise explains.
    pub is_significant: bool,
}

/// How much of a missing torque one coordinate explains, over all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplainedTorque {
    /// The missing torque.
    pub on: TorqueOn,
    /// The coordinate.
    pub coordinate: Coordinate,
    /// Explained share of the squared torque above the noise, from 0 to 1; 0 if not significant.
    pub share: f64,
    /// Significance in standard deviations: explained sum of squares against that of noise alone.
    pub significance: f64,
}

/// The complete result of a breakdown.
#[derive(Clone, Debug, Default)]
pub struct FailureMap {
    /// Every residual over every coordinate.
    pub breakdowns: Vec<ResidualBreakdown>,
    /// How much of each missing torque each coordinate explains.
    pub explained: Vec<ExplainedTorque>,
    /// The regions in which the model fails, the most significant first; never empty if there is a sample.
    pub regions: Vec<FailureRegion>,
}

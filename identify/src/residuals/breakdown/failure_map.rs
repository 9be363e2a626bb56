//! What a breakdown says: bins of a residual over a coordinate, and the places where a model fails.

use super::super::residual_torque::TorqueOn;
use super::coordinate::Coordinate;

/// What is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResidualKind {
    /// The torque that the model lacks, N m.
    ResidualTorque,
    /// Measured − free run, in the unit of the channel.
    Output,
}

/// One bin of a breakdown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreakdownBin {
    /// Lower edge in the unit of the coordinate.
    pub from: f64,
    /// Upper edge.
    pub to: f64,
    /// Number of values in it (of bumps, for a torque: a bump that passes through several bins counts
    /// in each with its part).
    pub count: f64,
    /// Mean residual in the bin, in its own unit.
    pub mean: f64,
    /// Standard error of the mean; it accounts for overlapping bumps and for what the coordinate
    /// leaves unexplained.
    pub mean_std: f64,
    /// The part that changes its sign with the speed (positive along the motion), in the same unit;
    /// NaN where it is not asked for.
    pub along_motion: f64,
    /// Standard error of [`BreakdownBin::along_motion`].
    pub along_motion_std: f64,
    /// Its share of this record's squared error above the noise, in percent of 1; the shares of a
    /// torque add up to what the coordinate explains, those of an output to 1.
    pub share: f64,
}

/// One residual of one record over one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualBreakdown {
    /// The experiment's name.
    pub experiment: String,
    /// The channel's part of "experiment/channel".
    pub channel: &'static str,
    /// Which residual.
    pub quantity: ResidualKind,
    /// Over which coordinate.
    pub coordinate: Coordinate,
    /// Standard deviation of the noise of one value, in the unit of the residual.
    pub noise_std: f64,
    /// The bins in rising order, without gaps.
    pub bins: Vec<BreakdownBin>,
}

/// A place where the model fails.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureRegion {
    /// The experiment's name.
    pub experiment: String,
    /// The channel's part of "experiment/channel".
    pub channel: &'static str,
    /// In which residual it was seen.
    pub quantity: ResidualKind,
    /// The coordinate in which the place is given.
    pub coordinate: Coordinate,
    /// Lower end in the unit of the coordinate.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Share of this record's squared error above the noise that lies in it, 0 to 1.
    pub share_of_error: f64,
    /// Squared error above the noise in it, in units of the noise of one value.
    pub size: f64,
    /// Whether there is anything beyond noise at all.
    pub is_significant: bool,
}

/// How much of the missing torque a coordinate explains, over all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplainedTorque {
    /// Which torque.
    pub on: TorqueOn,
    /// By which coordinate.
    pub coordinate: Coordinate,
    /// Share of the squared torque above the noise, 0 to 1; 0 where it is not significant.
    pub share: f64,
    /// In standard deviations of what noise alone would seem to show.
    pub significance: f64,
}

/// Everything about where a model fails.
#[derive(Clone, Debug, Default)]
pub struct FailureMap {
    /// Every residual over every coordinate.
    pub breakdowns: Vec<ResidualBreakdown>,
    /// How much of each missing torque each coordinate explains.
    pub explained: Vec<ExplainedTorque>,
    /// The places where the model fails, the plainest first; never empty if there is a sample.
    pub regions: Vec<FailureRegion>,
}

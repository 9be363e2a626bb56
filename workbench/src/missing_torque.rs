//! The torque that a model lacks, as a curve.

use identify::MissingCurve;
use plant::{LearnedCoordinate, Role};
use serde::{Deserialize, Serialize};

use crate::session::Session;

/// The torque that a model lacks, over the coordinate that describes it best.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingTorque {
    /// angle, rate, wheel_speed or wheel_angle.
    pub coordinate: String,
    /// SI unit of the coordinate.
    pub unit: String,
    /// The body on which the torque acts: "body" or "wheel".
    pub acts_on: String,
    /// SI unit of the torque; "N m per kg m2" where the scale of the torques is not known.
    pub torque_unit: String,
    /// The experiments that show it.
    pub experiments: Vec<String>,
    /// Share of the missing torque, beyond the noise, that the curve predicts in experiments from which it was not
    /// learned, 0 to 1.
    pub share: f64,
    /// The curve, by increasing coordinate.
    pub points: Vec<TorquePoint>,
    /// The command that adds the curve to the model.
    pub command: String,
}

/// A point of a torque curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorquePoint {
    /// The coordinate, SI.
    pub at: f64,
    /// The torque in [`MissingTorque::torque_unit`], positive towards positive angles.
    pub torque: f64,
    /// Standard error of the torque, in the same unit.
    pub std: f64,
}

impl MissingTorque {
    pub(crate) fn new(session: &Session, curve: &MissingCurve) -> MissingTorque {
        let coordinate = curve.coordinate;
        let problem = session.problem();
        let (acts_on, is_known) = match coordinate.role() {
            Role::Wheel => ("wheel", problem.wheel_scale_known),
            _ => ("body", problem.body_scale_known),
        };
        let points = curve.points().into_iter().map(|point| TorquePoint {
            at: point.at,
            torque: point.torque_nm,
            std: point.std_nm,
        });
        MissingTorque {
            coordinate: coordinate.name().to_owned(),
            unit: coordinate.unit().to_owned(),
            acts_on: acts_on.to_owned(),
            torque_unit: if is_known { "N m" } else { "N m per kg m2" }.to_owned(),
            experiments: curve.experiments.clone(),
            share: curve.share,
            points: points.collect(),
            command: format!(
                "flywheel add --learned {} --bench {}",
                coordinate.name(),
                session.place().display()
            ),
        }
    }

    /// Two sentences: the coordinate that describes the missing torque best, and the effect of adding the curve.
    pub fn sentence(&self) -> String {
        let coordinate = LearnedCoordinate::from_name(&self.coordinate);
        let words = coordinate.map_or("the coordinate", LearnedCoordinate::words);
        format!(
            "The missing torque is described best as a torque on the {} over {words}: a curve predicts {:.0} % of \
             it. This learned curve can be added to the model; the error falls, but a curve explains nothing.",
            self.acts_on,
            100.0 * self.share
        )
    }
}

//! The missing torque as a curve.

use plant::LearnedCoordinate;

use crate::missing_torque::MissingTorque;
use crate::words::spoken;

impl MissingTorque {
    /// The curve with its band.
    pub fn drawing(&self, bench: &str) -> String {
        let points: Vec<figures::TorqueCurvePoint> = self
            .points
            .iter()
            .map(|point| figures::TorqueCurvePoint {
                at: point.at,
                value: point.torque,
                std: point.std,
            })
            .collect();
        let words = LearnedCoordinate::from_name(&self.coordinate)
            .map_or("the coordinate", LearnedCoordinate::words);
        figures::torque_curve(&figures::TorqueCurve {
            title: &format!("{bench}: the torque that the model lacks, over {words}"),
            subtitle: &format!(
                "Torque on the {}, positive towards positive angles; from {}. `{}` adds it to the model.",
                self.acts_on,
                crate::words::set(self.experiments.iter().map(String::as_str)),
                self.command
            ),
            coordinate: figures::Quantity {
                name: spoken(&self.coordinate),
                unit: &self.unit,
            },
            torque: figures::Quantity {
                name: "missing torque",
                unit: &self.torque_unit,
            },
            points: &points,
        })
    }
}

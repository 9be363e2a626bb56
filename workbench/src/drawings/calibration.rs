//! The magnetometer's samples before and after its calibration.

use crate::calibration::SensorCalibrationReport;
use crate::numbers::significant;
use crate::output_file::OutputFile;

impl SensorCalibrationReport {
    /// The samples on the sphere, where a magnetometer was recorded.
    pub fn drawings(&self) -> Vec<OutputFile> {
        let figures = self.magnetometer_points.iter().map(|points| {
            figures::sphere(&figures::Sphere {
                title: "Magnetometer before and after calibration",
                subtitle: &format!(
                    "Length varies by {} % before and {} % after; {:.0} % of all directions covered",
                    significant(100.0 * points.spread_before, 3),
                    significant(100.0 * points.spread_after, 3),
                    100.0 * points.coverage
                ),
                before: &points.before,
                before_unit: "counts",
                after: &points.after_ut,
                after_unit: "µT",
                radius: points.field_ut,
            })
        });
        figures
            .map(|svg| OutputFile::svg("magnetometer", svg))
            .collect()
    }
}

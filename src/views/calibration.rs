//! A calibration in tables.

use workbench::numbers::{significant, with_uncertainty};
use workbench::{CalibratedLine, CalibratedSensor, LeverArmReport, SensorCalibrationReport};

use crate::report::table::{Align, Table};

/// The text without the list of files.
pub fn text(report: &SensorCalibrationReport) -> String {
    let mut text = String::new();
    for (name, found) in [
        ("Accelerometer", &report.accelerometer),
        ("Gyroscope", &report.gyroscope),
        ("Magnetometer", &report.magnetometer),
    ] {
        if let Some(found) = found {
            text.push_str(&sensor(name, found));
        }
    }
    if let Some(mounting) = &report.mounting {
        text.push_str(&format!(
            "\nMounting\n  pivot axis in the sensor's frame ({}) ± {} rad\n  angle from the body's axis to the sensor's x axis {} rad\n",
            mounting
                .axis
                .map(|component| significant(component, 5))
                .join(", "),
            significant(mounting.axis_std_rad, 2),
            with_uncertainty(mounting.angle_rad, Some(mounting.angle_std_rad)),
        ));
    }
    if let Some(arm) = &report.lever_arm {
        text.push_str(&lever_arm(arm));
    }
    text.push_str(&lines(report));
    if let Some(centre) = &report.centre_of_mass {
        text.push_str(&format!(
            "\nCentre of mass from {} plumb lines that cross at {}°\n  pivot_to_com = {} m (put it under [known] in bench.toml for the gravity torque)\n",
            centre.residuals_m.len(),
            significant(centre.crossing_angle_rad.to_degrees(), 3),
            with_uncertainty(centre.pivot_to_com_m, Some(centre.pivot_to_com_std_m)),
        ));
    }
    for warning in &report.warnings {
        text.push_str(&format!("\nWarning: {warning}\n"));
    }
    text
}

fn lever_arm(arm: &LeverArmReport) -> String {
    let millimetres = |position: [f64; 2], std: [f64; 2]| {
        [0, 1]
            .map(|axis| with_uncertainty(1e3 * position[axis], Some(1e3 * std[axis])))
            .join(", ")
    };
    let mut text =
        "\nAccelerometer from the pivot axis, along x and y of the aligned sensor\n".to_owned();
    if let (Some(position), Some(std)) = (arm.stated_m, arm.stated_std_m) {
        text.push_str(&format!("  as stated: {} mm\n", millimetres(position, std)));
    }
    if let Some(found) = &arm.from_swing {
        text.push_str(&format!(
            "  from the swing: {} mm; residual {} m/s2; scale error of the gyroscope {} %\n",
            millimetres(found.position_m, found.position_std_m),
            significant(found.residual_std_m_s2, 3),
            with_uncertainty(
                100.0 * found.gyro_scale_error,
                Some(100.0 * found.gyro_scale_error_std)
            ),
        ));
    }
    text
}

fn lines(report: &SensorCalibrationReport) -> String {
    let mut table = Table::new(&[
        ("line", Align::Left),
        ("slope", Align::Left),
        ("at zero", Align::Left),
        ("scatter", Align::Right),
    ]);
    let mut add = |name: &str, line: &Option<CalibratedLine>| {
        if let Some(line) = line {
            table.row([
                name.to_owned(),
                with_uncertainty(line.slope, Some(line.slope_std)),
                with_uncertainty(line.offset, Some(line.offset_std)),
                significant(line.residual_std, 3),
            ]);
        }
    };
    add(
        "wheel speed (rad/s) over converter counts",
        &report.wheel_speed,
    );
    add("duty (counts) over current (A)", &report.current);
    if table.is_empty() {
        return String::new();
    }
    format!("\nConverters\n{}", table.text())
}

fn sensor(name: &str, sensor: &CalibratedSensor) -> String {
    let mut table = Table::new(&[
        ("axis", Align::Left),
        ("bias in counts", Align::Left),
        ("x", Align::Left),
        ("y", Align::Left),
        ("z", Align::Left),
    ]);
    for (row, axis) in ["x", "y", "z"].iter().enumerate() {
        let entry = |column: usize| {
            let std = sensor.matrix_std[row][column];
            with_uncertainty(sensor.matrix[row][column], (std > 0.0).then_some(std))
        };
        table.row([
            (*axis).to_owned(),
            with_uncertainty(sensor.bias_counts[row], Some(sensor.bias_std[row])),
            entry(0),
            entry(1),
            entry(2),
        ]);
    }
    let quality: Vec<String> = sensor
        .quality
        .iter()
        .map(|(what, value)| format!("{} {}", what.replace('_', " "), significant(*value, 3)))
        .collect();
    format!(
        "\n{name}: value in {} = matrix (counts − bias)\n{}  {}\n",
        sensor.unit_per_count,
        table.text(),
        quality.join(", ")
    )
}

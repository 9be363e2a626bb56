//! Signs and axes in tables.

use workbench::BringUpReport;
use workbench::numbers::significant;

/// The whole text: signs, axes, contradictions.
pub fn text(report: &BringUpReport) -> String {
    let sign = |found: Option<i8>, meaning: &str| match found {
        Some(1) => format!("+   {meaning}"),
        Some(_) => format!("-   {meaning}, reversed"),
        None => "not shown".to_owned(),
    };
    let mut text = "Signs\n".to_owned();
    let signs = &report.signs;
    for (name, found, meaning) in [
        (
            "gyroscope",
            signs.gyroscope,
            "its axis along the pivot reads positive for a turn towards positive angles",
        ),
        (
            "accelerometer",
            signs.accelerometer,
            "its axis along the body points from the pivot to the centre of mass",
        ),
        (
            "angle",
            signs.angle,
            "the encoder's counts rise with the angle",
        ),
        (
            "wheel speed",
            signs.wheel_speed,
            "the word rises with the speed",
        ),
        ("drive", signs.drive, "a larger duty drives forward"),
    ] {
        text.push_str(&format!("  {name:<14} {}\n", sign(found, meaning)));
    }
    text.push_str("\nAxes: the body axis that each sensor axis shows\n");
    for (name, axes) in [
        ("gyroscope", &report.axes.gyroscope),
        ("accelerometer", &report.axes.accelerometer),
    ] {
        let shown = match axes {
            Some(axes) => format!("axes = [\"{}\"]", axes.join("\", \"")),
            None => "not shown, or not along the body's".to_owned(),
        };
        text.push_str(&format!("  {name:<14} {shown}\n"));
    }
    if let Some(off) = report.off_axes_rad {
        text.push_str(&format!(
            "  the accelerometer is turned by {}° from these axes\n",
            significant(off.to_degrees(), 2)
        ));
    }
    if report.contradictions.is_empty() {
        text.push_str("\nNothing contradicts bench.toml\n");
        return text;
    }
    text.push_str("\nContradictions\n");
    for found in &report.contradictions {
        text.push_str(&format!("  {}: {}\n", found.recording, found.sentence));
        let mend = match &found.value {
            Some(value) => format!("{} = {value}", found.key),
            None => format!("{} (record it again)", found.key),
        };
        text.push_str(&format!("    mend: {mend}\n"));
    }
    text
}

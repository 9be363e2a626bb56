//! From raw counts to a calibration.

use super::*;

/// Raw counts of a made-up sensor: the calibration finds bias and scale within four of its own
/// standard errors, writes them beside the model and leaves the model alone.
#[test]
fn calibration_from_raw_counts() {
    let folder = tempfile::tempdir().expect("folder");
    let write = |name: &str, text: String| {
        fs::write(folder.path().join(name), text).expect("write");
    };
    let bias = [41.3, -24.6, 9.8];
    let per_g = [4101.0, 4090.0, 4087.0];
    let mut poses = Vec::new();
    let mut seed = 0;
    let mut count = |value: f64| {
        seed += 1;
        // Two uniform numbers: near enough to a sensor's noise, of 4 counts.
        let noise = 9.8 * (bench::noise(2 * seed) + bench::noise(2 * seed + 1));
        (value + noise).round() as i16
    };
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut text = "ax,ay,az\n".to_owned();
            for _ in 0..500 {
                let mut cells = Vec::new();
                for k in 0..3 {
                    let g = if k == axis { sign } else { 0.0 };
                    cells.push(count(bias[k] + per_g[k] * g).to_string());
                }
                text.push_str(&(cells.join(",") + "\n"));
            }
            let name = format!("pose{}.csv", poses.len());
            write(&name, text);
            poses.push(format!("{name:?}"));
        }
    }
    let mut still = "gx,gy,gz\n".to_owned();
    for _ in 0..2000 {
        still.push_str(&format!("{},{},{}\n", count(12.3), count(-7.9), count(0.4)));
    }
    write("still.csv", still);
    // Swung by hand, 8 s: the angle from hanging is cos(5 t).
    let arm = [0.06, -0.02];
    let scale = 1.0908308e-3;
    let mut swing = "gx,gy,gz,ax,ay,az\n".to_owned();
    let mut hanging = "ax,ay,az\n".to_owned();
    for k in 0..8000 {
        let time = 1e-3 * f64::from(k);
        let angle = (5.0 * time).cos();
        let (rate, acceleration) = (-5.0 * (5.0 * time).sin(), -25.0 * angle);
        let force = [
            -9.81 * angle.cos() - acceleration * arm[1] - rate * rate * arm[0],
            9.81 * angle.sin() + acceleration * arm[0] - rate * rate * arm[1],
        ];
        swing.push_str(&format!(
            "{},{},{},{},{},{}\n",
            count(12.3),
            count(-7.9),
            count(0.4 + rate / scale),
            count(bias[0] + per_g[0] * force[0] / 9.81),
            count(bias[1] + per_g[1] * force[1] / 9.81),
            count(bias[2])
        ));
        if k % 4 == 0 {
            let cells = [bias[0] - per_g[0], bias[1], bias[2]].map(&mut count);
            hanging.push_str(&format!("{},{},{}\n", cells[0], cells[1], cells[2]));
        }
    }
    write("swing.csv", swing);
    write("hanging.csv", hanging);
    let mut converter = "adc_count,wheel_speed_rad_s\n".to_owned();
    for adc in (0..1600).step_by(100) {
        let speed = 0.8933732 * f64::from(adc) - 690.574 + bench::noise(adc as usize);
        converter.push_str(&format!("{adc},{speed:.4}\n"));
    }
    write("converter.csv", converter);
    write(
        "bench.toml",
        format!(
            "[known]\ngravity = 9.81\n[calibration]\naccelerometer = [{}]\n\
             gyroscope = \"still.csv\"\ngyroscope_scale = 1.0908308e-3\nsample_time = 0.001\n\
             swing = \"swing.csv\"\nhanging = \"hanging.csv\"\n\
             wheel_speed = \"converter.csv\"\n[calibration.plumb_lines]\npivot = [0.0, 0.0]\n\
             std = 0.0005\nlines = [[[0.1, 0.0], [0.0, -0.08]], [[-0.1, 0.0], [0.0, -0.08]]]\n",
            poses.join(", ")
        ),
    );
    let model = folder.path().join("model.toml");
    fs::copy(models().join("thesis-4.4.toml"), &model).expect("copy");
    let bench = folder.path().to_str().expect("path");
    let before = json_of([
        "generate",
        model.to_str().expect("path"),
        "--out",
        bench,
        "--json",
        "-",
    ]);

    let found = json_of(["calibrate", bench, "--json", "-"]);
    let within = |value: &Value, std: &Value, truth: f64| {
        let (value, std) = (value.as_f64().expect("value"), std.as_f64().expect("std"));
        assert!(
            std > 0.0 && (value - truth).abs() < 4.0 * std,
            "{value} ± {std}, truth {truth}"
        );
    };
    let sensor = &found["accelerometer"];
    for k in 0..3 {
        within(&sensor["bias_counts"][k], &sensor["bias_std"][k], bias[k]);
        within(
            &sensor["matrix"][k][k],
            &sensor["matrix_std"][k][k],
            9.81 / per_g[k],
        );
        let rest = [12.3, -7.9, 0.4][k];
        within(
            &found["gyroscope"]["bias_counts"][k],
            &found["gyroscope"]["bias_std"][k],
            rest,
        );
    }
    let lever = &found["lever_arm"];
    for (k, truth) in arm.into_iter().enumerate() {
        within(&lever["position_m"][k], &lever["position_std_m"][k], truth);
    }
    let of_swing = &lever["from_swing"];
    within(
        &of_swing["gyro_scale_error"],
        &of_swing["gyro_scale_error_std"],
        0.0,
    );
    let line = &found["wheel_speed"];
    within(&line["slope"], &line["slope_std"], 0.8933732);
    within(&line["offset"], &line["offset_std"], -690.574);
    let centre = &found["centre_of_mass"];
    within(
        &centre["pivot_to_com_m"],
        &centre["pivot_to_com_std_m"],
        0.08,
    );

    let text = fs::read_to_string(&model).expect("model.toml");
    for part in [
        "[calibration.accelerometer]",
        "[calibration.wheel_speed]",
        "[calibration.lever_arm]",
        "[parameters.pivot_to_com]",
        "# Matrix 4.4",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let after = json_of([
        "generate",
        model.to_str().expect("path"),
        "--out",
        bench,
        "--json",
        "-",
    ]);
    assert_eq!(before["gains"], after["gains"], "the law is another matter");
    let changed = after["changed"].to_string();
    assert!(
        changed.contains("constants.rs"),
        "sensor words follow the calibration: {changed}"
    );

    refused(["identify", bench], &["bench.toml:1:1", "no experiment"]);
    write("bench.toml", "[bench]\nname = \"x\"\n".to_owned());
    refused(
        ["calibrate", bench],
        &["bench.toml:1:1", "lacks \"calibration\""],
    );
}

//! `check`, `new` and `effects`, on files that are written here.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{bench::noise, done, flywheel, json_of, refused, stderr, stdout};

/// A free swing with angle and rate in these units, and a little noise.
fn swing(angle_unit: f64, rate_unit: f64) -> String {
    swing_under(0.6, |_| 0.0, (angle_unit, rate_unit))
}

/// A free swing from this angle, under a torque over the angle beside gravity and viscous friction; torques as
/// accelerations, 1/s².
fn swing_under(
    start_rad: f64,
    torque: impl Fn(f64) -> f64,
    (angle_unit, rate_unit): (f64, f64),
) -> String {
    let mut text = "time_s,angle_rad,rate_rad_s\n".to_owned();
    let (mut angle, mut rate) = (start_rad, 0.0_f64);
    for sample in 0..2000 {
        let seen = (angle + 1e-3 * noise(sample)) * angle_unit;
        let turning = (rate + 5e-3 * noise(sample + 7)) * rate_unit;
        text.push_str(&format!(
            "{:.3},{seen:.6},{turning:.6}\n",
            0.005 * sample as f64
        ));
        for _ in 0..200 {
            rate -= 2.5e-5 * (100.0 * angle.sin() + 0.05 * rate - torque(angle));
            angle += 2.5e-5 * rate;
        }
    }
    text
}

/// A spin-up with 0.3 A; the speed in this unit.
fn spin_up(unit: f64) -> String {
    let mut text = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
    for sample in 0..400 {
        let time = 0.01 * sample as f64;
        let speed = 800.0 * (1.0 - (-0.1 * time).exp()) + 0.5 * noise(sample);
        text.push_str(&format!("{time:.2},{:.4},0.3\n", speed * unit));
    }
    text
}

fn write_bench(folder: &Path, rate_unit: f64, more: &str) {
    fs::write(folder.join("swing.csv"), swing(1.0, rate_unit)).expect("written");
    fs::write(folder.join("spin.csv"), spin_up(1.0)).expect("written");
    let toml = format!(
        "[known]\ngravity_torque = 0.23\ntorque_constant = 0.033\n\n[[experiment]]\nname = \"swing\"\nkind = \
         \"free-swing\"\nfile = \"swing.csv\"\n{more}\n[[experiment]]\nname = \"spin\"\nkind = \"spin-up\"\nfile \
         = \"spin.csv\"\n"
    );
    fs::write(folder.join("bench.toml"), toml).expect("written");
}

#[test]
fn data_that_would_make_a_wrong_model_are_refused_by_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().to_str().expect("a name");
    write_bench(folder.path(), 1.0, "");
    let text = done(["check", bench]);
    assert!(text.contains("2 experiments, 2400 samples"), "{text}");
    assert!(text.contains("Nothing is wrong"), "{text}");

    write_bench(folder.path(), 57.29578, "");
    let parts = [
        "bench.toml:6",
        "swing/rate",
        "57.3 times",
        "units = { rate = \"deg/s\" }",
        "accept",
    ];
    for command in ["identify", "diagnose"] {
        refused([command, bench], &parts);
        assert!(!folder.path().join("model.toml").exists());
    }
    let output = flywheel(["check", bench, "--json", "-"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let json: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let finding = &json["findings"][0];
    assert_eq!(finding["experiment"], "swing");
    assert_eq!(finding["channel"], "rate");
    assert_eq!(finding["finding"], "rate-factor");
    assert_eq!(finding["severity"], "refuse");
    assert!((finding["factor"].as_f64().expect("a number") - 57.296).abs() < 0.001);

    // Accepted it is a warning, which every report has at its top.
    write_bench(folder.path(), 57.29578, "accept = [\"rate-factor\"]");
    assert!(done(["check", bench]).contains("0 refusals, 1 warning"));
    let json = json_of(["identify", bench, "--json", "-"]);
    assert_eq!(json["findings"][0]["severity"], "warn");
}

/// A folder that cannot be written to is found before the work, names do no harm to a terminal, and a signal that
/// never changes has no percents.
#[test]
fn words_and_numbers_that_a_person_can_use() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().to_str().expect("a name");
    write_bench(folder.path(), 1.0, "");
    let file = folder.path().join("swing.csv");
    let inside = file.join("out");
    refused(
        [
            "diagnose".as_ref(),
            bench.as_ref(),
            "--out".as_ref(),
            inside.as_os_str(),
        ],
        &["swing.csv"],
    );
    assert!(!folder.path().join("model.toml").exists());

    let toml = fs::read_to_string(folder.path().join("bench.toml")).expect("read");
    let toml = toml.replace("name = \"swing\"", "name = \"swing\\u001b[31m\"");
    let toml = format!(
        "{toml}[[experiment]]\nname = \"still\"\nkind = \"spin-up\"\nfile = \"still.csv\"\n"
    );
    fs::write(folder.path().join("bench.toml"), toml).expect("written");
    let mut still = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
    for row in 0..200 {
        still.push_str(&format!("{:.2},0,0\n", 0.01 * row as f64));
    }
    fs::write(folder.path().join("still.csv"), still).expect("written");
    let text = done(["identify", bench]);
    assert!(!text.contains('\u{1b}'), "{text}");
    assert!(!text.contains("NaN"), "{text}");
    // A number has at most four digits, and its exponent.
    let longest = text
        .split(|c: char| !(c.is_ascii_digit() || c == '.'))
        .map(str::len)
        .max();
    assert!(longest < Some(12), "{text}");
    let is_of_table = |line: &&str| line.starts_with("  ") && !line.starts_with("  -");
    assert!(
        text.lines()
            .filter(is_of_table)
            .all(|line| line.chars().count() <= 100),
        "{text}"
    );
}

#[test]
fn files_without_a_bench_become_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| {
        folder
            .path()
            .join(name)
            .to_str()
            .expect("a name")
            .to_owned()
    };
    // As a spreadsheet would save them: degrees, milliseconds, decimal commas, rpm.
    let german = |text: String, header: &str| {
        let body = text
            .split_once('\n')
            .expect("a header")
            .1
            .replace(',', ";")
            .replace('.', ",");
        format!("{header}\n{body}")
    };
    let swing = german(
        swing(57.29578, 57.29578),
        "Zeit [s];Winkel [°];Drehrate [°/s]",
    );
    fs::write(place("swing.csv"), swing).expect("written");
    fs::write(
        place("spin.csv"),
        german(spin_up(9.5493), "t_s;wheel_rpm;current_A"),
    )
    .expect("written");
    let bench = place("bench");
    let text = done(["new", &bench, &place("swing.csv"), &place("spin.csv")]);
    assert!(text.contains("free-swing"), "{text}");
    let toml = fs::read_to_string(folder.path().join("bench/bench.toml")).expect("written");
    for part in [
        "kind = \"free-swing\"",
        "kind = \"spin-up\"",
        "units = { angle = \"deg\", rate = \"deg/s\" }",
        "units = { wheel_speed = \"rpm\" }",
        "# gravity_torque",
        "# [hardware.gyroscope]",
        "accept ",
    ] {
        assert!(toml.contains(part), "{part} is not in\n{toml}");
    }
    assert!(done(["check", &bench]).contains("Nothing is wrong"));
    // What is there is left alone.
    refused(
        ["new", &bench, &place("spin.csv")],
        &["a bench exists already"],
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("bench/bench.toml")).expect("still"),
        toml
    );
}

/// A log that no bench.toml mends is refused with its place, and no folder is left behind.
#[test]
fn a_log_with_a_fault_begins_no_bench() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let good = swing(1.0, 1.0);
    let row_50 = good.lines().nth(49).expect("a long log");
    let with = |row: &str| good.replacen(row_50, row, 1);
    let again = good.lines().nth(9).expect("a long log");
    let cases = [
        (
            with("0.240,abc,0.1"),
            "log.csv:50: column \"angle_rad\": \"abc\" is not a number",
        ),
        (with("0.240,0.1"), "log.csv:50: this line has 2 cells"),
        (
            with(again),
            "log.csv:50: column \"time_s\": time goes backwards",
        ),
        ("time_s,angle_rad\n".to_owned(), "log.csv: "),
        (
            "dear diary\nnothing\nto see\n".to_owned(),
            "no column of the file holds numbers",
        ),
        (String::new(), "the file is empty"),
    ];
    for (text, expected) in cases {
        fs::write(place("log.csv"), text).expect("written");
        refused(["new", &place("bench"), &place("log.csv")], &[expected]);
        assert!(!folder.path().join("bench").exists(), "{expected}");
    }
    // What is only undecided stands in a bench.toml with the question: at what was the current held?
    let rows =
        (0..200).map(|k| format!("{},{}\n", 0.01 * f64::from(k), 20.0 - 0.05 * f64::from(k)));
    let coast_down = format!("time_s,wheel_speed_rad_s\n{}", rows.collect::<String>());
    fs::write(place("log.csv"), coast_down).expect("written");
    let text = done(["new", &place("bench"), &place("log.csv")]);
    assert!(text.contains("TO DECIDE"), "{text}");
}

#[test]
fn units_that_no_name_tells_are_found_by_the_motion() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| {
        folder
            .path()
            .join(name)
            .to_str()
            .expect("a name")
            .to_owned()
    };
    let swing = swing(57.29578, 57.29578).replace("time_s,angle_rad,rate_rad_s", "t,theta,gyro");
    fs::write(place("swing.csv"), swing).expect("written");
    done(["new", &place("bench"), &place("swing.csv")]);
    let toml = fs::read_to_string(folder.path().join("bench/bench.toml")).expect("written");
    assert!(
        toml.contains("units = { angle = \"deg\", rate = \"deg/s\" }"),
        "{toml}"
    );
}

/// A magnet beside the pivot: no effect of the library, but one that a user can write down.
#[test]
fn an_effect_of_ones_own_takes_part_like_a_built_in_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().to_str().expect("a name");
    write_bench(folder.path(), 1.0, "");
    let magnet = |angle: f64| {
        let z = (angle - 0.15) / 0.12;
        1.5 * z * (-z * z).exp()
    };
    let log = swing_under(0.5, magnet, (1.0, 1.0));
    fs::write(folder.path().join("swing.csv"), log).expect("written");
    fs::create_dir(folder.path().join("effects")).expect("a folder");
    let effect = "role = \"body\"\ntorque = \"a*z*exp(-z^2)\"\nz = \"(angle - centre)/width\"\nfingerprint = \"a \
                  bump at one angle\"\n[parameters.a]\nunit = \"N m\"\nstart = 1e-3\n[parameters.centre]\nunit = \
                  \"rad\"\nstart = [0.1, 0.2]\nbounds = [-0.5, 0.5]\n[parameters.width]\nunit = \"rad\"\nstart = \
                  0.1\nbounds = [0.01, 0.5]\n";
    fs::write(folder.path().join("effects/magnet.toml"), effect).expect("written");

    done(["identify", bench]);
    let json = json_of(["add", "own:magnet", "--bench", bench, "--json", "-"]);
    let rmse = |value: &Value| value["swing/angle"].as_f64().expect("an error");
    // The noise is uniform over 1 mrad.
    let noise = 1e-3 / 12_f64.sqrt();
    assert!(
        rmse(&json["rmse_before"]) > 3.0 * noise,
        "{}",
        json["rmse_before"]
    );
    assert!(rmse(&json["rmse"]) < 1.1 * noise, "{}", json["rmse"]);
    let found = json["parameters"].as_array().expect("parameters").iter();
    let value = |name: &str| {
        let mut all = found.clone();
        let one = all.find(|parameter| parameter["name"] == name).expect(name);
        one["value"].as_f64().expect("a number")
    };
    assert!((value("magnet_centre") - 0.15).abs() < 5e-3);
    assert!((value("magnet_width") - 0.12).abs() < 5e-3);
    // Θ is 0.23/100 kg m².
    assert!((value("magnet_a") / (1.5 * 2.3e-3) - 1.0).abs() < 0.05);

    // The model stands alone: it brings the effect along.
    let alone = tempfile::tempdir().expect("a folder");
    let model = alone.path().join("model.toml");
    fs::copy(folder.path().join("model.toml"), &model).expect("copied");
    assert!(
        fs::read_to_string(&model)
            .expect("read")
            .contains("[own.magnet]")
    );
    done(["design".as_ref(), model.as_os_str()]);
    // A suspect like those of the library.
    fs::remove_file(folder.path().join("model.toml")).expect("removed");
    let json = json_of(["diagnose", bench, "--json", "-"]);
    assert_eq!(
        json["suspects"][0]["effect"], "own:magnet",
        "{}",
        json["suspects"]
    );
    refused(
        ["add", "own:magnets", "--bench", bench],
        &["own:magnets", "own:magnet"],
    );
}

/// An effect that has no torque where the logs have been is named with the place, and the logs are not blamed.
#[test]
fn an_effect_without_a_finite_torque_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().to_str().expect("a name");
    write_bench(folder.path(), 1.0, "");
    fs::create_dir(folder.path().join("effects")).expect("a folder");
    done(["identify", bench]);
    for torque in ["a*ln(rate)", "a/(angle - angle)", "a*sqrt(-1)"] {
        let effect = format!(
            "role = \"body\"\ntorque = \"{torque}\"\nfingerprint = \"none\"\n[parameters.a]\nunit = \"N m\"\nstart = \
             1e-4\n"
        );
        fs::write(folder.path().join("effects/wrong.toml"), effect).expect("written");
        let output = flywheel(["add", "own:wrong", "--bench", bench]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let named = "own:wrong gives no finite torque where experiment \"swing\" has been: angle ";
        assert!(message.contains(named), "{torque}: {message}");
    }
}

#[test]
fn effects_are_listed_and_explained() {
    let text = done(["effects"]);
    assert!(text.contains("body-coulomb-friction"), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );
    let text = done(["effects", "motor-lag"]);
    for part in [
        "motor_lag",
        "What to look for",
        "What it is confused with",
        "input-delay, in ",
        "told apart by a run with the body hanging free",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    let json = json_of(["effects", "--json", "-"]);
    assert_eq!(
        json.as_array().map(Vec::len),
        Some(plant::EffectId::ALL.len())
    );
    let help = done(["add", "--help"]);
    assert!(help.contains("wheel-cogging"), "{help}");
}

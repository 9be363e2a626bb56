//! Columns, units, signs, windows: what a log means in SI.

use std::f64::consts::{PI, TAU};

use crate::common::{Folder, csv, one};
use bench_files::{Bench, Channel, CurrentMeaning, Experiment, Note};
use plant::Kind;

fn load(toml: &str, log: &str) -> Experiment {
    let folder = Folder::bench(toml, log);
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    bench.experiments.into_iter().next().expect("one")
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= 1e-12 * e.abs().max(1.0), "{f} is not {e}");
    }
}

#[test]
fn standard_names_need_nothing_else() {
    let log = csv(
        "time_s,angle_rad,rate_rad_s,wheel_speed_rad_s,current_A",
        6,
        |i| {
            format!(
                "{},{},0.5,-3,{}",
                0.1 * i as f64,
                3.1 + 0.01 * i as f64,
                0.2
            )
        },
    );
    let experiment = load(&one("balance", ""), &log);
    assert_eq!(experiment.kind, Kind::Balance);
    assert_eq!(experiment.current_meaning, CurrentMeaning::Command);
    assert_eq!(experiment.log.len(), 6);
    assert_eq!(experiment.report.rows_in_file, 6);
    assert!(
        experiment.report.notes.is_empty(),
        "{:?}",
        experiment.report
    );
    for channel in Channel::ALL {
        // The wheel's angle is not in the file: its speed is.
        let samples = (channel != Channel::WheelAngle).then_some(6);
        assert_eq!(experiment.log.channel(channel).map(<[f64]>::len), samples);
    }
    assert_eq!(experiment.log.wheel_speed_rad_s, Some(vec![-3.0; 6]));
}

/// Every unit against its definition: a full turn, an hour, an ampere.
#[test]
fn units_are_what_they_say() {
    let cases = [
        ("free-swing", "time", "s", 3600.0, 3600.0),
        ("free-swing", "time", "ms", 3_600_000.0, 3600.0),
        ("free-swing", "time", "us", 3_600_000_000.0, 3600.0),
        ("free-swing", "time", "ns", 3_600_000_000_000.0, 3600.0),
        ("driven", "angle", "rad", TAU, TAU),
        ("driven", "angle", "mrad", 1000.0 * TAU, TAU),
        ("driven", "angle", "deg", 360.0, TAU),
        ("driven", "angle", "rev", 1.0, TAU),
        ("driven", "rate", "deg/s", 360.0, TAU),
        ("driven", "rate", "rad/s", TAU, TAU),
        ("driven", "rate", "mrad/s", 1000.0 * TAU, TAU),
        ("driven", "rate", "rpm", 60.0, TAU),
        ("driven", "wheel_speed", "rpm", 60.0, TAU),
        ("driven", "wheel_speed", "deg/s", 360.0, TAU),
        ("driven", "wheel_speed", "rev/s", 1.0, TAU),
        ("driven", "current", "A", 1.5, 1.5),
        ("driven", "current", "mA", 1500.0, 1.5),
    ];
    for (kind, key, unit, raw, si) in cases {
        // The value of interest stands in the last line, so that time may be any of them.
        let channel = Channel::from_key(key).expect("a channel");
        let header = Channel::ALL.map(Channel::standard_name).join(",");
        let log = csv(&header, 6, |i| {
            Channel::ALL
                .map(|c| match (c == channel, c) {
                    (true, _) => (raw * (i + 1) as f64 / 6.0).to_string(),
                    (false, Channel::Time) => format!("{i}"),
                    _ => "0".to_string(),
                })
                .join(",")
        });
        let experiment = load(
            &one(kind, &format!("units = {{ {key} = \"{unit}\" }}")),
            &log,
        );
        let samples = experiment.log.channel(channel).expect("the channel");
        assert_near(&samples[5..], &[si]);
    }
}

#[test]
fn sign_and_offset_act_on_si() {
    let log = csv("t,pend,amps", 6, |i| {
        format!("{},{},{}", i * 10, 90 * (i % 2), 500)
    });
    let more = "columns = { time = \"t\", angle = \"pend\", current = \"amps\" }\n\
                units = { time = \"ms\", angle = \"deg\", current = \"mA\" }\n\
                sign = { angle = -1, current = -1 }\n\
                offset = { angle = 1.0, current = 0.1, time = 5.0 }\n\
                current_meaning = \"measured\"";
    let experiment = load(&one("driven", more), &log);
    let log = &experiment.log;
    assert_near(&log.time_s, &[5.0, 5.01, 5.02, 5.03, 5.04, 5.05]);
    let swung = 1.0 - PI / 2.0;
    assert_near(
        log.angle_rad.as_deref().expect("angle"),
        &[1.0, swung, 1.0, swung, 1.0, swung],
    );
    assert_near(log.current_a.as_deref().expect("current"), &[-0.4; 6]);
    assert_eq!(experiment.current_meaning, CurrentMeaning::Measured);
}

#[test]
fn a_sign_that_is_a_factor_is_used_and_reported() {
    let log = csv("time_s,angle_rad", 6, |i| format!("{i},0.2"));
    let experiment = load(&one("free-swing", "sign = { angle = 0.5 }"), &log);
    assert_near(
        experiment.log.angle_rad.as_deref().expect("angle"),
        &[0.1; 6],
    );
    assert_eq!(
        experiment.report.notes,
        [Note::SignIsAFactor {
            channel: Channel::Angle,
            factor: 0.5
        }]
    );
}

#[test]
fn a_command_without_unit_is_taken_as_it_is_and_said() {
    let log = csv("time_s,wheel_speed_rad_s,u", 6, |i| format!("{i},{i},0.5"));
    let keys = "columns = { current = \"u\" }\nunits = { current = \"1\" }";
    let experiment = load(&one("spin-up", keys), &log);
    assert_eq!(experiment.log.current_a, Some(vec![0.5; 6]));
    assert_eq!(experiment.report.notes, [Note::NormalisedCommand]);
}

#[test]
fn a_held_current_becomes_a_column() {
    let log = csv("time_s,wheel_speed_rad_s", 6, |i| format!("{i},{i}"));
    let held = load(&one("spin-up", "constants = { current = 0.6 }"), &log);
    assert_eq!(held.log.current_a, Some(vec![0.6; 6]));
    assert!(held.report.notes.is_empty());
    let unknown = load(&one("spin-up", ""), &log);
    assert_eq!(unknown.log.current_a, None);
    assert_eq!(unknown.report.notes, [Note::CurrentNotRecorded]);
}

#[test]
fn a_window_includes_its_ends_and_hides_what_is_outside() {
    // A hand-held start without angle: no number there, but not in the window either.
    let log = csv("time_s,angle_rad,comment", 20, |i| {
        let angle = if i < 5 {
            "held".to_string()
        } else {
            format!("0.{i}")
        };
        format!("{},{angle},free text", i as f64 / 10.0)
    });
    let experiment = load(&one("free-swing", "from = 0.5\nuntil = 1.5"), &log);
    assert_eq!(experiment.log.time_s.first(), Some(&0.5));
    assert_eq!(experiment.log.time_s.last(), Some(&1.5));
    assert_eq!(experiment.log.len(), 11);
    assert_eq!(experiment.report.rows_in_file, 20);
}

#[test]
fn irregular_times_are_kept_and_repeated_ones_averaged() {
    let times = [0.0, 0.1, 0.1, 0.25, 0.3, 0.3, 0.3, 0.7, 0.8];
    let log = csv("time_s,angle_rad", times.len(), |i| {
        format!("{},{}", times[i], i)
    });
    let experiment = load(&one("free-swing", "sign = { angle = 0.01 }"), &log);
    assert_near(&experiment.log.time_s, &[0.0, 0.1, 0.25, 0.3, 0.7, 0.8]);
    assert_near(
        experiment.log.angle_rad.as_deref().expect("angle"),
        &[0.0, 0.015, 0.03, 0.05, 0.07, 0.08],
    );
    assert!(
        experiment
            .report
            .notes
            .contains(&Note::MergedRows { count: 3 })
    );
}

#[test]
fn a_pause_is_reported() {
    let log = csv("time_s,angle_rad", 40, |i| {
        format!("{},0.1", i as f64 * 0.01 + if i < 20 { 0.0 } else { 3.0 })
    });
    let experiment = load(&one("free-swing", ""), &log);
    let [Note::Gap { from_s, to_s }] = experiment.report.notes[..] else {
        panic!("{:?}", experiment.report.notes)
    };
    assert_near(&[from_s, to_s], &[0.19, 3.2]);
}

/// Semicolons, tabs, quotation marks, blanks, CRLF, a byte order mark, comments: one log.
#[test]
fn dialects_of_csv() {
    let dialects = [
        "time_s,angle_rad\n0,0.1\n1,0.2\n2,0.1\n3,0.2\n4,0.1\n",
        "time_s;angle_rad\n0;0.1\n1;0.2\n2;0.1\n3;0.2\n4;0.1",
        "time_s\tangle_rad\n0\t0.1\n1\t0.2\n2\t0.1\n3\t0.2\n4\t0.1\n",
        "\"time_s\",\"angle_rad\"\n\"0\",\"0.1\"\n1,0.2\n2,0.1\n3,0.2\n4,0.1\n",
        " time_s , angle_rad \r\n 0 , 0.1 \r\n1,0.2\r\n2,0.1\r\n3,0.2\r\n4,0.1\r\n",
        "\u{feff}time_s,angle_rad\n0,0.1\n1,0.2\n2,0.1\n3,0.2\n4,0.1\n",
        "# rig 3, monday; a, b; c; d\n\ntime_s,angle_rad\n0,1e-1\n\n1,+0.2\n# pause\n2,.1\n3,0.20\n4,0.1\n\n",
    ];
    for text in dialects {
        let log = load(&one("free-swing", ""), text).log;
        assert_eq!(log.time_s, [0.0, 1.0, 2.0, 3.0, 4.0], "{text}");
        assert_eq!(log.angle_rad, Some(vec![0.1, 0.2, 0.1, 0.2, 0.1]), "{text}");
    }
}

/// A sensor within one turn, read while the bench stands upright, flips between π and −π.
#[test]
fn an_angle_that_wraps_is_unwrapped() {
    let truth: Vec<f64> = (0..200)
        .map(|i| PI + 0.05 * (0.1 * i as f64).sin())
        .collect();
    let log = csv("time_s,angle_rad,current_A", truth.len(), |i| {
        let wrapped = truth[i].sin().atan2(truth[i].cos());
        format!("{},{wrapped},0", i as f64 * 0.01)
    });
    let experiment = load(&one("balance", ""), &log);
    assert_near(experiment.log.angle_rad.as_deref().expect("angle"), &truth);
    assert!(matches!(
        experiment.report.notes[..],
        [Note::AngleUnwrapped { .. }]
    ));

    // The same from below: all of it a turn too low.
    let log = csv("time_s,angle_rad,current_A", truth.len(), |i| {
        format!("{},{},0", i as f64 * 0.01, truth[i] - TAU)
    });
    let experiment = load(&one("balance", ""), &log);
    assert_near(experiment.log.angle_rad.as_deref().expect("angle"), &truth);
    assert_eq!(
        experiment.report.notes,
        [Note::AngleTurned { added_rad: TAU }]
    );
}

/// One mark on the wheel: a line a turn, or a count of turns read at even times. The steps by whole turns are the motion.
#[test]
fn a_count_of_turns_is_no_sensor_of_one_turn() {
    let more = "units = { wheel_angle = \"rev\" }\ncolumns = { wheel_angle = \"turns\" }\nconstants = { current = 0.0 }";
    let a_line_a_turn = csv("time_s,turns", 60, |i| {
        format!("{},{i}", 0.4 * i as f64 + 0.002 * (i * i) as f64)
    });
    let at_even_times = csv("time_s,turns", 300, |i| {
        let time = 0.1 * i as f64;
        format!("{time},{}", (2.5 * time - 0.03 * time * time).floor())
    });
    for (log, turns) in [(a_line_a_turn, 59.0), (at_even_times, 47.0)] {
        let experiment = load(&one("spin-up", more), &log);
        let angle = experiment.log.wheel_angle_rad.expect("an angle");
        let turned = (angle[angle.len() - 1] - angle[0]) / TAU;
        assert!((turned - turns).abs() < 1e-9, "{turned} {turns}");
    }
}

/// Columns that a kind has no use for stay in the file, whatever they hold.
#[test]
fn useless_columns_are_left_alone() {
    let log = csv("time_s,angle_rad,current_A,note", 6, |i| {
        format!("{i},0.1,off,x")
    });
    let experiment = load(&one("free-swing", ""), &log);
    assert_eq!(experiment.log.current_a, None);
}

#[test]
fn a_bench_is_a_folder_or_its_file() {
    let log = csv("time_s,angle_rad", 6, |i| format!("{i},0.1"));
    let toml = "[bench]\nname = \"b\"\n[controller]\ngains = [-24, -2.1, -0.02]\ncurrent_limit = 2\nsample_time = 0.001\n"
        .to_string() + &one("free-swing", "");
    let folder = Folder::bench(&toml, &log);
    let from_folder = Bench::load(folder.path()).expect("folder");
    let from_file = Bench::load(&folder.path().join("bench.toml")).expect("file");
    assert_eq!(from_folder, from_file);
    assert_eq!(from_folder.name, "b");
    assert_eq!(from_folder.folder, folder.path());
    let controller = from_folder.controller.expect("controller");
    assert_eq!(controller.gains, [-24.0, -2.1, -0.02]);
    assert_eq!(
        (controller.current_limit_a, controller.sample_time_s),
        (2.0, 0.001)
    );
    assert!(from_folder.experiment("one").is_some());
}

#[test]
fn gravity_torque_from_masses_and_from_its_own_measurement() {
    let log = csv("time_s,angle_rad", 6, |i| format!("{i},0.1"));
    let known = |text: &str| {
        let folder = Folder::bench(&format!("[known]\n{text}\n{}", one("free-swing", "")), &log);
        Bench::load(folder.path()).expect("loads")
    };
    let masses = "gravity = 9.81\nbody_mass = 0.2\nwheel_mass = 0.10604\npivot_to_wheel = 0.085\npivot_to_com = 0.079886";
    // physics.md: G = 0.245158 N m
    let torque = known(masses).known.gravity_torque().expect("known");
    assert!((torque - 0.245158).abs() < 5e-7, "{torque}");

    let bench = known(&format!("{masses}\ngravity_torque = 0.25"));
    assert_eq!(bench.known.gravity_torque(), Ok(0.25));
    assert_eq!(bench.notes.len(), 1);
    assert!(bench.notes[0].contains("0.25 N m") && bench.notes[0].contains("0.2452 N m"));
    // The contract's example: the same number, rounded.
    assert!(
        known(&format!("{masses}\ngravity_torque = 0.2451"))
            .notes
            .is_empty()
    );

    let missing = known("gravity = 9.81\nbody_mass = 0.2\nwheel_mass = 0.1")
        .known
        .gravity_torque();
    assert_eq!(
        missing.expect_err("lengths").missing,
        ["pivot_to_wheel", "pivot_to_com"]
    );
    assert!(
        known("")
            .known
            .gravity_torque()
            .expect_err("all")
            .to_string()
            .contains("gravity,")
    );
}

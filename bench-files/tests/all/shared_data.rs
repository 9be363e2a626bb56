//! Measurements and simulated benches of others.

use bench_files::{Bench, CurrentMeaning};
use plant::Kind;

use crate::common::{Folder, recordings};

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn all_simulated_benches_load() {
    let mut benches = 0;
    for entry in std::fs::read_dir(recordings("hidden")).expect("list") {
        let folder = entry.expect("entry").path();
        if !folder.is_dir() {
            continue;
        }
        benches += 1;
        let bench = Bench::load(&folder).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            Some(bench.name.as_str()),
            folder.file_name().and_then(|n| n.to_str())
        );
        assert!(bench.notes.is_empty());
        // The masses and lengths are the thesis': G = 0.245158 N m.
        let torque = bench.known.gravity_torque().expect("masses and lengths");
        assert!((torque - 0.245158).abs() < 5e-7);
        for experiment in &bench.experiments {
            let name = format!("{}: {}", bench.name, experiment.name);
            assert_eq!(
                experiment.report.notes,
                [],
                "{name}: simulated without drop-outs"
            );
            assert_eq!(experiment.current_meaning, CurrentMeaning::Command);
            let log = &experiment.log;
            let step_s = if experiment.kind == Kind::Balance {
                0.001
            } else {
                0.004
            };
            for pair in log.time_s.windows(2) {
                assert!((pair[1] - pair[0] - step_s).abs() < 1e-9, "{name}");
            }
            match experiment.kind {
                Kind::SpinUp => {
                    assert!(log.wheel_speed_rad_s.is_some() && log.current_a.is_some());
                    assert!(log.angle_rad.is_none(), "{name}");
                }
                Kind::FreeSwing => {
                    assert!(log.angle_rad.is_some() && log.rate_rad_s.is_some());
                    assert!(log.current_a.is_none(), "{name}");
                }
                Kind::Balance => {
                    assert!(bench.controller.is_some(), "{name}");
                    assert!(log.angle_rad.is_some() && log.current_a.is_some(), "{name}");
                }
                Kind::Driven => panic!("{name}: there is none"),
            }
        }
    }
    assert_eq!(benches, 7);
}

/// The real recordings, with the mapping that each needs: file, kind, entries, samples, notes.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn all_real_logs_load() {
    let tud = "columns = { time = \"t_s\", angle = \"pend_rad\", wheel_speed = \"wheel_rad_s\", current = \"current_A\" }\n";
    let tud_up = format!("{tud}offset = {{ angle = 3.14159265 }}");
    let cases = [
        (
            "orig_freeswing_reibung",
            "free-swing",
            "columns = { time = \"t_s\" }",
            1545,
            0,
        ),
        (
            "orig_flywheel_spinup",
            "spin-up",
            "columns = { time = \"t_s\", wheel_speed = \"omega_rad_s\" }",
            18,
            1,
        ),
        (
            "bookip_cdip_freeswing_1kHz",
            "free-swing",
            "columns = { time = \"t_s\" }\nfrom = 8.0",
            112_001,
            0,
        ),
        (
            "aau_cubli_freeswing_00",
            "free-swing",
            "columns = { time = \"t_s\", angle = \"angle_rad_from_pot_scale\" }\noffset = { angle = -0.72 }",
            2000,
            0,
        ),
        (
            "tud_rwp_freeswing_A_20Hz",
            "free-swing",
            "columns = { time = \"t_s\", angle = \"pend_rad\" }",
            1001,
            0,
        ),
        ("tud_rwp_wheel_step_20Hz", "driven", tud, 1001, 1),
        ("tud_rwp_wheel_square_20Hz", "driven", tud, 1001, 1),
        ("tud_rwp_chirp_20Hz", "driven", tud, 2001, 0),
        ("tud_rwp_balance_LQR_20Hz", "balance", &tud_up, 1201, 0),
    ];
    for (name, kind, entries, samples, notes) in cases {
        let folder = Folder::new();
        let file = recordings(&format!("real/{name}.csv"))
            .display()
            .to_string();
        folder.write(
            "bench.toml",
            format!(
                "[[experiment]]\nname = \"{name}\"\nkind = \"{kind}\"\nfile = {file:?}\n{entries}\n"
            )
            .as_bytes(),
        );
        let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
        let experiment = &bench.experiments[0];
        assert_eq!(experiment.log.len(), samples, "{name}");
        assert_eq!(
            experiment.report.notes.len(),
            notes,
            "{name}: {:?}",
            experiment.report.notes
        );
    }
}

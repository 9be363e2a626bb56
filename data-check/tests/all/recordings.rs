//! Recordings of real rigs, as they are mapped rightly: none is refused.

use std::path::{Path, PathBuf};

use bench_files::Bench;
use data_check::{Finding, Severity, check};

fn recordings(path: &str) -> PathBuf {
    Path::new(env!("FLYWHEEL_RECORDINGS")).join(path)
}

fn findings(folder: &Path) -> Vec<Finding> {
    check(&Bench::load(folder).unwrap_or_else(|error| panic!("{error}")))
}

/// Refusals, and warnings that the recording does not deserve.
fn assert_none_is_refused(name: &str, found: &[Finding], deserved: &[&str]) {
    for finding in found {
        println!("{name}: {finding:?}");
        assert_eq!(finding.severity, Severity::Warn, "{name}: {finding:?}");
        assert!(
            deserved.contains(&finding.finding.name()),
            "{name}: {finding:?}"
        );
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn no_simulated_bench_has_a_finding() {
    for entry in std::fs::read_dir(recordings("hidden")).expect("list") {
        let folder = entry.expect("entry").path();
        if folder.is_dir() {
            assert_none_is_refused(&folder.display().to_string(), &findings(&folder), &[]);
        }
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn no_recording_is_refused() {
    for name in ["wheel-coast-down", "video-pendulum"] {
        let folder = recordings(&format!("real2/{name}"));
        assert_none_is_refused(name, &findings(&folder), &[]);
    }
    let tud = "columns = { time = \"t_s\", angle = \"pend_rad\", wheel_speed = \"wheel_rad_s\", current = \"current_A\" }\n";
    let tud_up = format!("{tud}offset = {{ angle = 3.14159265 }}");
    let cubli = "columns = { time = \"t_s\", angle = \"angle_rad_from_pot_scale\" }\noffset = { angle = -0.72 }";
    let cases: [(&str, &str, &str, &[&str]); 9] = [
        (
            "orig_freeswing_reibung",
            "free-swing",
            "columns = { time = \"t_s\" }",
            &[],
        ),
        (
            "orig_flywheel_spinup",
            "spin-up",
            "columns = { time = \"t_s\", wheel_speed = \"omega_rad_s\" }",
            &[],
        ),
        (
            "bookip_cdip_freeswing_1kHz",
            "free-swing",
            "columns = { time = \"t_s\" }\nfrom = 8.0",
            &[],
        ),
        ("aau_cubli_freeswing_00", "free-swing", cubli, &[]),
        (
            "tud_rwp_freeswing_A_20Hz",
            "free-swing",
            "columns = { time = \"t_s\", angle = \"pend_rad\" }",
            // Its README: hand-held at the start. Its angle goes 0.349 rad from 0.25 to 0.3 s, and 0.1 rad in each of the
            // steps beside: the logger lost samples.
            &["hand", "held-start", "jump"],
        ),
        // Likewise 0.05 rad at 1.25 s beside 0.02 rad; and 0.07 rad at 11.65 s beside 0.02 rad.
        ("tud_rwp_wheel_step_20Hz", "driven", tud, &["jump"]),
        ("tud_rwp_wheel_square_20Hz", "driven", tud, &["jump"]),
        // Even stamps, and the noise of the wheel's speed grows with its slope in differences of every order.
        ("tud_rwp_chirp_20Hz", "driven", tud, &["time-stamps"]),
        ("tud_rwp_balance_LQR_20Hz", "balance", &tud_up, &[]),
    ];
    for (name, kind, entries, deserved) in cases {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = recordings(&format!("real/{name}.csv"))
            .display()
            .to_string();
        std::fs::write(
            folder.path().join("bench.toml"),
            format!(
                "[[experiment]]\nname = \"{name}\"\nkind = \"{kind}\"\nfile = {file:?}\n{entries}\n"
            ),
        )
        .expect("write");
        let found = findings(folder.path());
        assert_none_is_refused(name, &found, deserved);
        let says = |wanted: &str| found.iter().any(|one| one.finding.name() == wanted);
        assert_eq!(
            says("jump"),
            deserved.contains(&"jump"),
            "{name}: {found:?}"
        );
    }
}

/// A recording that was held until 8 s, used from its beginning; and a log of a hanging body as a spin-up.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn recordings_that_are_mapped_wrongly_are_refused() {
    let cases = [
        (
            "bookip_cdip_freeswing_1kHz",
            "free-swing",
            "columns = { time = \"t_s\" }",
            "held-start",
        ),
        (
            "tud_rwp_wheel_square_20Hz",
            "spin-up",
            "columns = { time = \"t_s\", angle = \"pend_rad\", wheel_speed = \"wheel_rad_s\", current = \"current_A\" }",
            "body-moves",
        ),
    ];
    for (name, kind, entries, expected) in cases {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = recordings(&format!("real/{name}.csv"))
            .display()
            .to_string();
        std::fs::write(
            folder.path().join("bench.toml"),
            format!(
                "[[experiment]]\nname = \"{name}\"\nkind = \"{kind}\"\nfile = {file:?}\n{entries}\n"
            ),
        )
        .expect("write");
        let found = findings(folder.path());
        assert!(
            found
                .iter()
                .any(|finding| finding.finding.name() == expected
                    && finding.severity == Severity::Refuse),
            "{name}: {found:?}"
        );
    }
}

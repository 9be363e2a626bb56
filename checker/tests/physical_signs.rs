//! Documents and words that contradict physics are noticed.

use std::path::Path;

use checker::Module;
use checker::certificate::reader::Certificate;
use checker::claims::physical_signs::check;
use checker::prove::Emitted;

/// What the claim says where a piece of a file is another.
fn said(path: &str, from: &str, to: &str, certificate: &str) -> Option<String> {
    let emitted = Emitted::read(Path::new("../generated")).expect("the committed crate");
    let sources: Vec<(String, String)> = emitted
        .sources
        .iter()
        .map(|(file, text)| {
            let is_it = file == path;
            assert!(!is_it || text.contains(from), "{path} has no `{from}`");
            let text = if is_it {
                text.replacen(from, to, 1)
            } else {
                text.clone()
            };
            (file.clone(), text)
        })
        .collect();
    let sources: Vec<_> = sources
        .iter()
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    let module = Module::parse(&sources).expect("it still parses");
    check(
        &Certificate::parse(certificate).expect("a certificate"),
        &module,
    )
    .err()
}

fn certificate() -> String {
    std::fs::read_to_string("../generated/certificate.json").expect("the certificate")
}

#[test]
fn the_committed_crate_pushes_the_right_way() {
    assert_eq!(said("src/lib.rs", "", "", &certificate()), None);
}

#[test]
fn what_contradicts_physics_is_said() {
    let constants = "src/constants.rs";
    let gyro = "0.001090830782496456, 0, 0, 0, 0.001090830782496456, 0, 0, 0, 0.001090830782496456";
    let accel = "0.00239420166015625, 0, 0, 0, 0.00239420166015625, 0, 0, 0, 0.00239420166015625";
    let mirrored = |row: &str| format!("-{row}");
    let cases = [
        (constants, gyro, mirrored(gyro), "left-handed"),
        (constants, accel, mirrored(accel), "left-handed"),
        (
            constants,
            accel,
            accel.replace("0.0023", "0.0046"),
            "gravity would read",
        ),
        (constants, accel, accel.replace("0.0023", "0.00002"), "m/s2"),
        (
            constants,
            "lever arm (0, 0) m",
            "lever arm (2, 0) m".to_owned(),
            "from the pivot",
        ),
        // Words that turn the wrong way: the drive, the gyroscope about the pivot, the law.
        (
            constants,
            "scale: 780_891_229,",
            "scale: -780_891_229,".to_owned(),
            "pushes the body on",
        ),
        (
            constants,
            "z: [0, 0, 1_228_166_276]",
            "z: [0, 0, -1_228_166_276]".to_owned(),
            "speeds the body up",
        ),
        (
            constants,
            "y: [0, 1_073_741_824, 0]",
            "y: [0, -1_073_741_824, 0]".to_owned(),
            "pushes the body on",
        ),
    ];
    for (path, from, to, wanted) in cases {
        let found =
            said(path, from, &to, &certificate()).unwrap_or_else(|| panic!("{to}: nothing"));
        assert!(found.contains(wanted), "{to}: {found}");
    }
    let motor = certificate().replace("\"0.0335\"", "\"-0.0335\"");
    let found = said("src/lib.rs", "", "", &motor).expect("a reversed motor");
    assert!(found.contains("torque_constant"), "{found}");
}

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

/// The certificate with the numbers at these places of it others.
fn altered(places: &[(&str, &str)]) -> String {
    let mut whole: serde_json::Value = serde_json::from_str(&certificate()).expect("JSON");
    for (place, number) in places {
        let found = whole.pointer_mut(place);
        *found.unwrap_or_else(|| panic!("no {place}")) = (*number).into();
    }
    whole.to_string()
}

#[test]
fn numbers_that_contradict_physics_are_said() {
    let accel = |number: &'static str| {
        [0, 1, 2].map(|k| (format!("/hardware/accelerometer/matrix/{k}/{k}"), number))
    };
    let (double, tiny) = (accel("0.0047884"), accel("0.00002394"));
    let pairs = |places: &[(String, &'static str); 3]| {
        let places: Vec<_> = places.iter().map(|(a, b)| (a.as_str(), *b)).collect();
        altered(&places)
    };
    let cases = [
        (
            altered(&[("/hardware/gyroscope/matrix/0/0", "-0.001090830782496456")]),
            "left-handed",
        ),
        (
            altered(&[("/hardware/accelerometer/matrix/1/1", "-0.00239420166015625")]),
            "left-handed",
        ),
        (pairs(&double), "gravity would read"),
        (pairs(&tiny), "gravity would read"),
        (
            altered(&[("/hardware/lever_arm_m/0", "2")]),
            "from the pivot",
        ),
    ];
    for (certificate, wanted) in cases {
        let found = said("src/lib.rs", "", "", &certificate);
        let found = found.unwrap_or_else(|| panic!("nothing for {wanted}"));
        assert!(found.contains(wanted), "{found}");
    }
    let motor = certificate().replace("\"0.0335\"", "\"-0.0335\"");
    let found = said("src/lib.rs", "", "", &motor).expect("a reversed motor");
    assert!(found.contains("torque_constant"), "{found}");
}

/// Words that turn the wrong way: the drive, the gyroscope about the pivot, an accelerometer's axis.
#[test]
fn words_that_push_the_wrong_way_are_said() {
    for (from, to, wanted) in [
        (
            "scale: 780_891_229,",
            "scale: -780_891_229,",
            "pushes the body on",
        ),
        (
            "z: [0, 0, 1_228_166_276]",
            "z: [0, 0, -1_228_166_276]",
            "speeds the body up",
        ),
        (
            "y: [0, 1_073_741_824, 0]",
            "y: [0, -1_073_741_824, 0]",
            "pushes the body on",
        ),
    ] {
        let found = said("src/constants.rs", from, to, &certificate());
        let found = found.unwrap_or_else(|| panic!("{to}: nothing"));
        assert!(found.contains(wanted), "{to}: {found}");
    }
}

//! Modules that are not emitted, with the reason.

use crate::thesis;

use codegen::claims::ClaimId;
use codegen::{ModuleSpec, Refusal, generate};

type Change = fn(&mut ModuleSpec);

#[test]
fn each_refusal_names_the_claim_and_the_cure() {
    // Change to the thesis bench; claim that fails; words that the message must contain.
    let cases: &[(Change, Option<ClaimId>, &[&str])] = &[
        (|s| s.gains[1] = f64::NAN, None, &["gain K2", "NaN"]),
        (|s| s.gains[0] = f64::INFINITY, None, &["gain K1", "inf"]),
        (
            |s| s.current_limit_a = f64::NAN,
            None,
            &["current limit", "NaN"],
        ),
        (
            |s| s.current_limit_a = 0.0,
            None,
            &["current limit", "greater than zero"],
        ),
        (|s| s.current_limit_a = -2.0, None, &["current limit", "-2"]),
        (|s| s.sample_time_s = 0.0, None, &["sample time"]),
        (
            |s| s.ranges.angle_rad = f64::INFINITY,
            None,
            &["angle range"],
        ),
        (|s| s.ranges.rate_rad_s = -1.0, None, &["rate range"]),
        (|s| s.current_weight = 0.0, None, &["current weight"]),
        (
            |s| s.drive.duty_high = s.drive.duty_zero,
            None,
            &["duty span"],
        ),
        (|s| s.a[1][2] = f64::NAN, None, &["entry of A"]),
        (|s| s.ad[1][2] = f64::NAN, None, &["entry of Ad"]),
        (|s| s.bd[2] = f64::NAN, None, &["entry of Bd"]),
        (
            |s| s.parameters[0].value = f64::NAN,
            None,
            &["parameter total_inertia"],
        ),
        (
            |s| s.parameters[0].std = Some(f64::INFINITY),
            None,
            &["standard error of total_inertia"],
        ),
        (
            |s| s.current_limit_a = 2.3,
            Some(ClaimId::ControlTotal),
            &[
                "control-total",
                "2.3 A",
                "drive's range of 2.2 A",
                "lower current_limit",
            ],
        ),
        (
            |s| s.current_limit_a = 1e-12,
            Some(ClaimId::ControlTotal),
            &["resolution", "raise current_limit"],
        ),
        (
            |s| s.ranges.wheel_speed_rad_s = 3e9,
            Some(ClaimId::ControlTotal),
            &["wheel speed range", "32-bit word", "smaller range"],
        ),
        (
            |s| s.gains[0] = -1e10,
            Some(ClaimId::ControlTotal),
            &["too large", "smaller gains"],
        ),
        (
            |s| s.gains[0] = f64::MAX,
            Some(ClaimId::ControlTotal),
            &["too large"],
        ),
        (
            |s| s.ranges.wheel_speed_rad_s = 2e9,
            Some(ClaimId::ControlAccurateRealGains),
            &["off by", "count of the drive", "smaller ranges"],
        ),
        (
            |s| s.gains = [0.0; 3],
            Some(ClaimId::ClosedLoopStable),
            &["all gains are zero"],
        ),
        (
            |s| s.gains = s.gains.map(|gain| -gain),
            Some(ClaimId::ClosedLoopStable),
            &["unstable", "design the gains"],
        ),
        (
            |s| s.gains = [-10.0, -1.0, 0.0],
            Some(ClaimId::ClosedLoopStable),
            &["unstable"],
        ),
    ];
    for (index, (change, claim, words)) in cases.iter().enumerate() {
        let mut spec = thesis::spec();
        change(&mut spec);
        let refusal: Refusal = generate(&spec).expect_err(&format!("case {index}"));
        let message = refusal.to_string();
        assert_eq!(refusal.claim(), *claim, "case {index}: {message}");
        if let Some(claim) = claim {
            assert!(message.contains(claim.as_str()), "case {index}: {message}");
        }
        for word in *words {
            assert!(
                message.contains(word),
                "case {index}: no {word:?} in {message}"
            );
        }
    }
}

#[test]
fn a_limit_equal_to_the_drives_range_is_accepted() {
    let mut spec = thesis::spec();
    spec.current_limit_a = 2.2;
    assert!(generate(&spec).is_ok());
}

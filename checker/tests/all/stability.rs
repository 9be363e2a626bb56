//! Stability over the region of parameters, against eigenvalues of sampled parameter vectors.

use std::path::Path;

use checker::Module;
use checker::certificate::reader::{Certificate, CertifiedCorrelation, StatedDecimal};
use checker::claims::closed_loop_stable::check_stable;
use checker::claims::control_law::EmittedLaw;
use checker::claims::sampling::check_sampling;
use checker::claims::stable_for_parameters::{RegionFailure, check_region};
use checker::exact::rational::decimal;
use num_traits::ToPrimitive;
use proptest::prelude::*;

/// Standard error of the scale of all torques, as a share.
const SCALE_ERROR: f64 = 0.15;

fn read() -> (Certificate, EmittedLaw) {
    let folder = Path::new("../generated");
    let module = Module::read(folder).unwrap();
    (
        Certificate::read(folder).unwrap(),
        EmittedLaw::read(&module).unwrap(),
    )
}

fn number(text: &str) -> StatedDecimal {
    StatedDecimal {
        text: text.to_owned(),
        value: decimal(text).unwrap(),
    }
}

/// Every parameter with a standard error of this share of its value.
fn uncertain(share: f64) -> (Certificate, EmittedLaw) {
    let (mut certificate, law) = read();
    for parameter in &mut certificate.parameters {
        let std = parameter.value.value.to_f64().unwrap() * share;
        parameter.std = Some(number(&format!("{std:e}")));
    }
    (certificate, law)
}

/// Whether the sampled loop of the model with these parameters is stable, by Euler steps of a
/// hundredth of the sample time and a large power of the loop's matrix.
fn is_stable(law: &EmittedLaw, parameters: [f64; 6], period: f64) -> bool {
    let [theta, wheel, gravity, torque, friction, drag] = parameters;
    let d = theta - wheel;
    let derivative = |x: [f64; 3], u: f64| {
        let body = (gravity * x[0] - friction * x[1] - torque * u + drag * x[2]) / d;
        [x[1], body, (torque * u - drag * x[2]) / wheel - body]
    };
    let gains = [0, 1, 2].map(|i| law.gains[i].to_f64().unwrap());
    let advance = |x: [f64; 3]| {
        let u = (0..3).map(|i| gains[i] * x[i]).sum();
        let mut x = x;
        for _ in 0..100 {
            let half = derivative(x, u);
            let middle = [0, 1, 2].map(|i| x[i] + 0.5 * period / 100.0 * half[i]);
            let slope = derivative(middle, u);
            x = [0, 1, 2].map(|i| x[i] + period / 100.0 * slope[i]);
        }
        x
    };
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(advance);
    let mut m = [0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i]));
    for _ in 0..22 {
        m = [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| m[i][k] * m[k][j]).sum()));
        let largest = m.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
        if largest > 1e60 {
            return false;
        }
    }
    m.iter().flatten().all(|entry| entry.abs() < 1.0)
}

/// Inertias, gravity torque, torque constant, and friction of body (dry friction at its slope included) and wheel.
pub fn nominal(certificate: &Certificate) -> [f64; 6] {
    let get = |name: &str| {
        let found = certificate.parameters.iter().find(|p| p.name == name);
        found.unwrap().value.value.to_f64().unwrap()
    };
    let (theta, wheel) = (get("total_inertia"), get("wheel_inertia"));
    let friction = -certificate.plant.a[1][1].value.to_f64().unwrap() * (theta - wheel);
    [
        theta,
        wheel,
        get("gravity_torque"),
        get("torque_constant"),
        friction,
        get("wheel_viscous_friction"),
    ]
}

#[test]
fn what_is_called_stable_is_stable() {
    let (certificate, law) = uncertain(0.005);
    let region = check_region(&certificate, &law).unwrap();
    assert_eq!(region.uncertain.len(), 7);
    let period = certificate.sample_time_s.value.to_f64().unwrap();
    let middle = nominal(&certificate);
    // Corners of the box: 3.75 standard errors for seven parameters.
    for corner in 0..64 {
        let mut parameters = middle;
        for (index, value) in parameters.iter_mut().enumerate() {
            let sign = if corner >> index & 1 == 1 { 1.0 } else { -1.0 };
            *value *= 1.0 + sign * 0.005 * 3.75;
        }
        assert!(is_stable(&law, parameters, period), "{parameters:?}");
    }
}

/// What is called unstable is unstable, and named.
#[test]
fn an_unstable_vector_is_named() {
    let (certificate, law) = uncertain(0.15);
    let Err(RegionFailure::Fails(why)) = check_region(&certificate, &law) else {
        panic!("a region with half the torque constant is not stable");
    };
    assert!(why.contains("unstable for total_inertia = "), "{why}");
    let value = |name: &str| -> f64 {
        let (_, rest) = why.split_once(&format!("{name} = ")).unwrap();
        rest.split(',').next().unwrap().trim().parse().unwrap()
    };
    let middle = nominal(&certificate);
    let coulomb = certificate
        .parameters
        .iter()
        .find(|p| p.name == "body_coulomb_torque");
    let mu = coulomb.unwrap().value.value.to_f64().unwrap();
    let viscous = 2.12e-5;
    let slope = (middle[4] - viscous) / mu;
    let parameters = [
        value("total_inertia"),
        value("wheel_inertia"),
        value("gravity_torque"),
        value("torque_constant"),
        value("body_viscous_friction") + slope * value("body_coulomb_torque"),
        value("wheel_viscous_friction"),
    ];
    assert!(!is_stable(&law, parameters, 0.001), "{why}");
}

/// Logs know every torque and inertia against each other, and the scale of all of them far worse: from a torque constant
/// of the data sheet. Over the box of such errors the loop is not stable. Over their ellipsoid it is, and every vector on
/// the ellipsoid's surface that is drawn here says so.
#[test]
fn correlations_take_the_corners_away() {
    let (mut certificate, law) = uncertain(SCALE_ERROR);
    assert!(check_region(&certificate, &law).is_err(), "the box");
    let rho = 0.9999;
    let names = certificate.parameters.iter().map(|p| p.name.clone());
    let names: Vec<String> = names.collect();
    let row = |i: usize| (0..names.len()).map(move |j| number(if i == j { "1" } else { "0.9999" }));
    let matrix = (0..names.len()).map(|i| row(i).collect()).collect();
    certificate.correlation = Some(CertifiedCorrelation {
        parameters: names,
        matrix,
    });
    let region = check_region(&certificate, &law).unwrap();
    assert!(region.is_correlated);
    println!("{} parts", region.boxes);
    let middle = nominal(&certificate);
    for part in 0..64_u32 {
        // Seven coordinates of one length: the scale, and the share of each parameter alone.
        let sign = |bit: u32| if part >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let each = 3.75 / 7_f64.sqrt();
        let mut parameters = middle;
        for (index, value) in parameters.iter_mut().enumerate() {
            let own = if index == 5 {
                1.0
            } else {
                sign(index as u32 + 1)
            };
            let error = f64::sqrt(rho) * sign(0) * each + f64::sqrt(1.0 - rho) * own * each;
            *value *= 1.0 + SCALE_ERROR * error;
        }
        assert!(is_stable(&law, parameters, 0.001), "{parameters:?}");
    }
}

/// Correlations of no errors are refused.
#[test]
fn impossible_correlations_are_refused() {
    let (mut certificate, law) = uncertain(0.001);
    let names = ["total_inertia", "wheel_inertia", "gravity_torque"];
    let row = |texts: [&str; 3]| texts.map(number).to_vec();
    certificate.correlation = Some(CertifiedCorrelation {
        parameters: names.map(str::to_owned).to_vec(),
        matrix: vec![
            row(["1", "0.9", "-0.9"]),
            row(["0.9", "1", "0.9"]),
            row(["-0.9", "0.9", "1"]),
        ],
    });
    let outcome = check_region(&certificate, &law);
    assert!(
        matches!(&outcome, Err(RegionFailure::Fails(why)) if why.contains("variance")),
        "{outcome:?}"
    );
}

#[test]
fn missing_parameters_are_said() {
    let (mut certificate, law) = read();
    certificate
        .parameters
        .retain(|p| p.name != "torque_constant");
    let Err(RegionFailure::NotStated(why)) = check_region(&certificate, &law) else {
        panic!("the torque constant is missing");
    };
    assert!(why.contains("torque_constant"));
}

#[test]
fn an_unstable_loop_is_found() {
    let (certificate, law) = read();
    check_stable(&certificate, &law).unwrap();
    // Too little, too much and backward.
    for factor in ["0.3", "200", "-1"] {
        let factor = decimal(factor).unwrap();
        let wrong = EmittedLaw {
            gains: law.gains.clone().map(|gain| gain * &factor),
            ..law.clone()
        };
        assert!(check_stable(&certificate, &wrong).is_err(), "{factor}");
    }
}

#[test]
fn a_wrong_sample_time_is_found() {
    let (mut certificate, _) = read();
    check_sampling(&certificate).unwrap();
    certificate.sample_time_s = number("0.0010001");
    assert!(check_sampling(&certificate).unwrap_err().contains("Ad["));
    certificate.sample_time_s = number("10");
    assert!(
        check_sampling(&certificate)
            .unwrap_err()
            .contains("too long")
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The criterion at single parameter vectors agrees with simulated powers.
    #[test]
    fn single_vectors(scales in prop::array::uniform6(0.6..1.6_f64)) {
        let (mut certificate, law) = read();
        let middle = nominal(&certificate);
        let p = [0, 1, 2, 3, 4, 5].map(|i| middle[i] * scales[i]);
        let d = p[0] - p[1];
        let text = |value: f64| number(&format!("{value:e}"));
        let names = ["total_inertia", "wheel_inertia", "gravity_torque", "torque_constant",
            "body_viscous_friction", "wheel_viscous_friction"];
        certificate.parameters.retain(|parameter| parameter.name != "body_coulomb_torque");
        for parameter in &mut certificate.parameters {
            let index = names.iter().position(|name| *name == parameter.name).unwrap();
            parameter.value = text(p[index]);
            parameter.std = None;
        }
        let (a0, a1, a2) = (p[2] / d, -p[4] / d, p[5] / d);
        certificate.plant.a = [
            ["0", "1", "0"].map(number),
            [text(a0), text(a1), text(a2)],
            [text(-a0), text(-a1), text(-p[0] * p[5] / (p[1] * d))],
        ];
        certificate.plant.b = [number("0"), text(-p[3] / d), text(p[0] * p[3] / (p[1] * d))];
        let found = check_region(&certificate, &law).is_ok();
        prop_assert_eq!(found, is_stable(&law, p, 0.001), "{:?}", p);
    }
}

//! The region of attraction against simulations of the pendulum that know nothing of the proof.

use std::path::Path;

use checker::Module;
use checker::certificate::reader::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::random::Random;
use checker::claims::{closed_loop_for_all_time, region_of_attraction};
use num_traits::ToPrimitive;

type V = [f64; 3];

fn read() -> (Certificate, EmittedLaw) {
    let folder = Path::new("../generated");
    let module = Module::read(folder).unwrap();
    let certificate = Certificate::read(folder).unwrap();
    let law = EmittedLaw::read(&module).unwrap();
    (certificate, law)
}

fn region(
    certificate: &Certificate,
    law: &EmittedLaw,
) -> Result<region_of_attraction::ProvedRegion, String> {
    let stated = certificate.closed_loop.as_ref().unwrap();
    let bounds = closed_loop_for_all_time::check(certificate, stated, law).unwrap();
    region_of_attraction::check(certificate, stated, &bounds, law).map_err(|why| why.to_string())
}

/// Points all over the unit sphere (Fibonacci's spiral).
fn directions(count: usize) -> impl Iterator<Item = V> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / count as f64;
        let (sine, cosine) = (golden * index as f64).sin_cos();
        let width = (1.0 - z * z).sqrt();
        [width * cosine, width * sine, z]
    })
}

#[test]
fn the_pendulum_returns_from_all_over_the_boundary_and_never_leaves() {
    let (certificate, law) = read();
    let found = region(&certificate, &law).unwrap();
    let stated = certificate.closed_loop.as_ref().unwrap();
    let number = |value: &num_rational::BigRational| value.to_f64().unwrap();
    let p = [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&stated.ellipsoid[i][j].value)));
    let norm = |x: V| {
        let square: f64 = (0..9).map(|k| x[k / 3] * p[k / 3][k % 3] * x[k % 3]).sum();
        square.sqrt()
    };
    let (outer, inner) = (number(&found.outer), number(&found.inner));
    let parameter = |name: &str| {
        let found = certificate.parameters.iter().find(|p| p.name == name);
        number(&found.unwrap().value.value)
    };
    let carried = parameter("total_inertia") - parameter("wheel_inertia");
    let gravity = parameter("gravity_torque") / carried;
    let a = [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&certificate.plant.a[i][j].value)));
    let b = [0, 1, 2].map(|i| number(&certificate.plant.b[i].value));
    let gains = [0, 1, 2].map(|i| number(&law.gains[i]));
    let limit = number(&law.limit);
    let steps = [0, 1, 2].map(|i| number(&stated.sensor_steps[i].value));
    let t = number(&certificate.sample_time_s.value);
    let rate = |x: V, current: f64| -> V {
        let beyond = gravity * (x[0].sin() - x[0]);
        let line = |i: usize| {
            let row: f64 = (0..3).map(|j| a[i][j] * x[j]).sum();
            row + b[i] * current
        };
        [line(0), line(1) + beyond, line(2) - beyond]
    };
    let moved = |x: V, k: V, h: f64| [0, 1, 2].map(|i| x[i] + h * k[i]);

    let seed = 41;
    let mut random = Random::new(seed);
    for direction in directions(300) {
        let mut x = direction.map(|x| x / norm(direction) * outer);
        let mut least = f64::INFINITY;
        for _ in 0..3_000 {
            // One of the two counts nearest to the value, chosen at random.
            let seen = [0, 1, 2].map(|i| {
                let side = random.choice(2) as f64 - 0.5;
                x[i] + side * steps[i]
            });
            let command: f64 = (0..3).map(|i| gains[i] * seen[i]).sum();
            assert!(command.abs() <= limit, "saturates at {x:?}");
            let k1 = rate(x, command);
            let k2 = rate(moved(x, k1, t / 2.0), command);
            let k3 = rate(moved(x, k2, t / 2.0), command);
            let k4 = rate(moved(x, k3, t), command);
            x = [0, 1, 2].map(|i| x[i] + t / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            let now = norm(x);
            assert!(
                now <= outer,
                "seed {seed}: left at {now} from {direction:?}"
            );
            assert!(
                least >= inner || now <= inner,
                "seed {seed}: {now} after {least}"
            );
            least = least.min(now);
        }
        assert!(least < inner, "seed {seed}: {least} from {direction:?}");
    }
}

#[test]
fn stronger_gravity_leaves_less_of_the_region_and_at_last_nothing() {
    let (certificate, law) = read();
    let whole = region(&certificate, &law).unwrap();
    let with_gravity = |tenths: i64| {
        let mut altered = certificate.clone();
        let factor = num_rational::BigRational::new(tenths.into(), 10.into());
        for row in [1, 2] {
            altered.plant.a[row][0].value *= &factor;
        }
        for parameter in &mut altered.parameters {
            if parameter.name == "gravity_torque" {
                parameter.value.value *= &factor;
            }
        }
        region(&altered, &law)
    };
    let less = with_gravity(43).unwrap();
    assert!(less.outer < whole.outer, "{less:?}");
    assert!(with_gravity(100_000).is_err());

    // The sine and the linear model have one gravity.
    let mut altered = certificate.clone();
    for parameter in &mut altered.parameters {
        if parameter.name == "gravity_torque" {
            parameter.value.value *= num_rational::BigRational::from_integer(2.into());
        }
    }
    let why = region(&altered, &law).unwrap_err();
    assert!(why.contains("gravity makes it"), "{why}");
}

#[test]
fn a_certificate_without_the_masses_shows_nothing() {
    let (mut certificate, law) = read();
    certificate.parameters.retain(|p| p.name != "wheel_inertia");
    let why = region(&certificate, &law).unwrap_err();
    assert!(why.contains("wheel_inertia"), "{why}");
}

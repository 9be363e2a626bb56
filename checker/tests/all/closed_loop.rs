//! The bound of the closed loop against an adversary, and against the emitted law itself.
//!
//! The adversary simulates both loops in double precision and chooses the start in the invariant
//! set and every perturbation; it does not know how the bound was computed.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::claims::closed_loop_for_all_time;
use checker::claims::control_law::EmittedLaw;
use checker::{Machine, Module};
use num_traits::ToPrimitive;
use proptest::prelude::*;

type V = [f64; 3];
type M = [V; 3];

struct Bench {
    certificate: Certificate,
    law: EmittedLaw,
    module: Module,
    /// Loop with real and with emitted gains.
    loops: [M; 2],
    bd: V,
    k: V,
    p: M,
}

fn bench() -> Bench {
    let folder = Path::new("../generated");
    let module = Module::read(folder).unwrap();
    let certificate = Certificate::read(folder).unwrap();
    let law = EmittedLaw::read(&module).unwrap();
    let (exact, quantised) = closed_loop_for_all_time::loops(&certificate, &law);
    let stated = certificate.closed_loop.as_ref().unwrap();
    let number = |value: &num_rational::BigRational| value.to_f64().unwrap();
    Bench {
        loops: [exact, quantised].map(|m| m.map(|row| row.map(|x| number(&x)))),
        bd: [0, 1, 2].map(|i| number(&certificate.plant.bd[i].value)),
        k: [0, 1, 2].map(|i| number(&certificate.gains[i].value)),
        p: [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&stated.ellipsoid[i][j].value))),
        certificate,
        law,
        module,
    }
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn apply(m: &M, v: V) -> V {
    m.map(|row| dot(row, v))
}

/// row · m
fn left(row: V, m: &M) -> V {
    [0, 1, 2].map(|j| (0..3).map(|i| row[i] * m[i][j]).sum())
}

/// m⁻¹ v by Cramer's rule.
fn solve(m: &M, v: V) -> V {
    let det = |m: &M| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    [0, 1, 2].map(|column| {
        let mut replaced = *m;
        for i in 0..3 {
            replaced[i][column] = v[i];
        }
        det(&replaced) / det(m)
    })
}

/// The largest |C e_k| that the adversary reaches at step `k`.
fn attacked(bench: &Bench, c: V, noise: f64, k: usize) -> f64 {
    // What a perturbation j steps before the end, and the start, do to C e.
    let (mut real, mut emitted) = (c, c);
    let mut weights = Vec::new();
    for _ in 0..k {
        weights.push(dot(emitted, bench.bd));
        real = left(real, &bench.loops[0]);
        emitted = left(emitted, &bench.loops[1]);
    }
    let difference = [0, 1, 2].map(|i| emitted[i] - real[i]);
    let direction = solve(&bench.p, difference);
    let length = dot(difference, direction).sqrt();
    let start = if length > 0.0 {
        direction.map(|x| x / length)
    } else {
        [0.0; 3]
    };

    let (mut x, mut x_real) = (start, start);
    for weight in weights.iter().rev() {
        let v = noise * weight.signum();
        let moved = apply(&bench.loops[1], x);
        x = [0, 1, 2].map(|i| moved[i] + bench.bd[i] * v);
        x_real = apply(&bench.loops[0], x_real);
        // The set is never left.
        assert!(dot(x, apply(&bench.p, x)) <= 1.0 + 1e-9);
    }
    dot(c, [0, 1, 2].map(|i| x[i] - x_real[i])).abs()
}

#[test]
fn the_bound_is_reached_within_15_percent_and_never_passed() {
    let bench = bench();
    let stated = bench.certificate.closed_loop.as_ref().unwrap();
    let bounds = closed_loop_for_all_time::check(&bench.certificate, stated, &bench.law).unwrap();
    for case in &bounds.cases {
        let noise = case.perturbation.to_f64().unwrap();
        let rows = [
            ([1.0, 0.0, 0.0], &case.states[0]),
            ([0.0, 1.0, 0.0], &case.states[1]),
            ([0.0, 0.0, 1.0], &case.states[2]),
            (bench.k, &case.command),
        ];
        for (c, bound) in rows {
            let bound = bound.to_f64().unwrap();
            let worst = [10, 30, 100, 200, 300, 500, 1000, 3000]
                .into_iter()
                .map(|k| attacked(&bench, c, noise, k))
                .fold(0.0, f64::max);
            eprintln!("{}: bound/adversary = {:.5}", case.name, bound / worst);
            assert!(
                worst <= bound * (1.0 + 1e-6),
                "{}: {worst} > {bound}",
                case.name
            );
            assert!(
                bound <= 1.15 * worst,
                "{}: {bound} against {worst}",
                case.name
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The emitted law itself in the loop, from random starts in the set, with sensors that round
    /// to their counts from a random phase.
    #[test]
    fn the_emitted_law_stays_within_the_bound(
        direction in prop::array::uniform3(-1.0..1.0_f64),
        phases in prop::array::uniform3(0.0..1.0_f64),
        with_sensors: bool,
    ) {
        thread_local! {
            static BENCH: &'static Bench = Box::leak(Box::new(bench()));
        }
        let bench = BENCH.with(|bench| *bench);
        let stated = bench.certificate.closed_loop.as_ref().unwrap();
        let case = &stated.cases[usize::from(with_sensors)];
        let number = |text: &str| text.parse::<f64>().unwrap();
        let mut machine = Machine::new(bench.module.function("control").unwrap());
        let length = dot(direction, apply(&bench.p, direction)).sqrt();
        let start = direction.map(|x| x / length);
        let (mut x, mut x_real) = (start, start);
        let ad = [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&bench.certificate.plant.ad[i][j].text)));
        for _ in 0..2_000 {
            let words = [0, 1, 2].map(|i| {
                let seen = if with_sensors {
                    let step = number(&stated.sensor_steps[i].text);
                    ((x[i] / step - phases[i]).round() + phases[i]) * step
                } else {
                    x[i]
                };
                (seen * 2f64.powi(bench.law.state_bits[i] as i32)).round() as i128
            });
            let command = machine.call(&words).unwrap()[0];
            let u = command as f64 * 2f64.powi(-(bench.law.current_bits as i32));
            prop_assert!(u.abs() < number(&bench.certificate.constants[3].real.text));
            let moved = apply(&ad, x);
            x = [0, 1, 2].map(|i| moved[i] + bench.bd[i] * u);
            x_real = apply(&bench.loops[0], x_real);
            for i in 0..3 {
                let bound = number(&case.states[i].text) * (1.0 + 1e-6) + 1e-13;
                prop_assert!((x[i] - x_real[i]).abs() <= bound);
            }
        }
    }
}

//! The loop with an observer of the angle's bias: what is proved of it, against loops that know nothing of the proof.

use std::path::Path;
use std::sync::OnceLock;

use checker::certificate::reader::Certificate;
use checker::claims::closed_loop_second;
use checker::claims::control_law::EmittedLaw;
use checker::claims::emitted_observer::EmittedObserver;
use checker::claims::loop_as_shipped::{self, NoBounds, ShippedLoop};
use checker::prove::{ClaimOutcome, Emitted};
use num_rational::BigRational;
use serde_json::{Value, json};

use crate::from_rest::{agree_from_rest, comes_to_the_inner_bounds, stay_together};
use crate::pivot::{self, parsed};
use crate::shipped::{Pendulum, Sensors, both_agree, real};

/// The observer of the angle's bias, stepped in the words that it computes.
#[derive(Clone, Copy)]
pub(crate) struct Observer {
    decay: f64,
    direct: [f64; 3],
    from_states: [f64; 3],
    from_current: f64,
    /// One over the unit of its state and over that of the estimate; infinite without rounding.
    units: [f64; 2],
    state: f64,
}

impl Observer {
    pub(crate) fn of(own: &EmittedObserver, is_rounded: bool) -> Observer {
        Observer {
            decay: real(&own.decay),
            direct: own.direct.each_ref().map(real),
            from_states: own.from_states.each_ref().map(real),
            from_current: real(&own.from_current),
            units: if is_rounded {
                [30, 29].map(|bits| 2.0_f64.powi(bits))
            } else {
                [f64::INFINITY; 2]
            },
            state: 0.0,
        }
    }

    fn rounded(value: f64, per_unit: f64) -> f64 {
        if per_unit.is_finite() {
            (value * per_unit).round() / per_unit
        } else {
            value
        }
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// Before the start it sees no bias.
    pub(crate) fn waits(&mut self, shown: [f64; 3]) {
        self.state = Observer::rounded(-Observer::dot(self.direct, shown), self.units[0]);
    }

    pub(crate) fn estimate(&self, shown: [f64; 3]) -> f64 {
        let bias = self.state + Observer::dot(self.direct, shown);
        Observer::rounded(bias, self.units[1]).clamp(-0.1, 0.1)
    }

    pub(crate) fn advance(&mut self, shown: [f64; 3], current: f64) {
        let next = self.decay * self.state
            + Observer::dot(self.from_states, shown)
            + self.from_current * current;
        self.state = Observer::rounded(next, self.units[0]);
    }
}

/// The committed module with the observer that the generator emits for a time constant of 1 s.
fn certificate() -> Value {
    let text = std::fs::read_to_string("../generated/certificate.json").unwrap();
    let mut found: Value = serde_json::from_str(&text).unwrap();
    found["bias_observer"] = json!({
        "decay": "0.999000499833375",
        "direct": ["-7.079915934012653e-5", "-0.008846348809886278", "3.9314574699658855e-7"],
        "from_states": ["0.0009995709303965354", "-1.226784083950376e-5", "7.1083077774364e-8"],
        "from_current": "-0.0001366662236574981",
        "limit_rad": "0.1",
    });
    found["closed_loop"] = Value::Null;
    found
}

/// Its words: products have 60 bits after the point, the states 29, 25 and 21, the current 29.
fn law() -> EmittedLaw {
    let number =
        |word: i64, bits: u32| BigRational::new(word.into(), (1_i64 << (60 - bits)).into());
    let of_states = |words: [i64; 3]| {
        let [angle, rate, speed] = words;
        [number(angle, 29), number(rate, 25), number(speed, 21)]
    };
    EmittedLaw {
        observer: Some(EmittedObserver {
            decay: number(1_072_668_619, 30),
            direct: of_states([-152_040, -303_958_231, 216_134]),
            from_states: of_states([2_146_562, -421_520, 39_078]),
            from_current: number(-293_488, 29),
        }),
        ..pivot::law()
    }
}

fn shown() -> &'static ShippedLoop {
    static SHOWN: OnceLock<ShippedLoop> = OnceLock::new();
    SHOWN.get_or_init(|| loop_as_shipped::check(&parsed(&certificate()), &law()).unwrap())
}

/// No run leaves the bounds, whatever the sensors do within their errors: a constant bias of all of them too.
#[test]
fn no_run_with_an_observer_leaves_the_bounds() {
    let (shown, law) = (shown(), law());
    let bench = Pendulum::of(&parsed(&certificate()), &law, shown);
    let start = real(&shown.start);
    println!("seed 43, from {start:.4} rad");
    let (mut largest, mut estimate) = ([0.0_f64; 4], 0.0_f64);
    for delay in [0.0, 0.5, 1.0] {
        for sensors in [Sensors::Round, Sensors::Draw, Sensors::Push, Sensors::Bias] {
            for share in [-1.0, 0.5, 1.0] {
                let seen = bench.run(share * start, delay, sensors, 4_000, 43);
                estimate = estimate.max(seen.estimate);
                for (largest, seen) in largest.iter_mut().zip(seen.whole) {
                    *largest = largest.max(seen);
                }
            }
        }
    }
    let bounds = shown.bounds.states.iter().chain([&shown.bounds.command]);
    for (index, bound) in bounds.enumerate() {
        println!("{index}: {:.3e} of {:.3e}", largest[index], real(bound));
        assert!(largest[index] <= real(bound), "quantity {index}");
        // The bound is of the size of the motion.
        assert!(largest[index] > 0.25 * real(bound), "quantity {index}");
    }
    let bound = real(&shown.bounds.estimate);
    println!("estimate: {estimate:.3e} of {bound:.3e}");
    assert!(estimate <= bound && estimate > 0.05 * bound);
}

#[test]
fn what_stays_with_an_observer_is_within_what_is_proved() {
    let shown = shown();
    let bench = Pendulum::of(&parsed(&certificate()), &law(), shown);
    bench.keeps_up_no_more_than_is_proved(shown, 20_000);
}

/// The emitted observer and the one in real numbers, and the region, of the stated linear model and of the pendulum.
#[test]
fn from_rest_with_an_observer() {
    let (certificate, law) = (parsed(&certificate()), law());
    stay_together(&certificate, &law);
    comes_to_the_inner_bounds(&certificate, &law);
}

fn emitted(certificate: &Value) -> Emitted {
    let mut emitted = Emitted::read(Path::new("../generated")).unwrap();
    emitted.certificate = certificate.to_string();
    emitted
}

/// The second checker finds the same of all four claims. It makes the words of the observer from its decimals.
#[test]
#[ignore = "run apart: ten seconds and more of Python"]
fn the_second_checker_agrees_with_an_observer() {
    let certificate = certificate();
    both_agree(&emitted(&certificate), shown());
    agree_from_rest(&emitted(&certificate), &parsed(&certificate), &law());
}

/// An observer that does not observe the stated plant is refused by the second checker alone; the first has it from
/// `hardware-words`, which compares every word.
#[test]
fn the_second_checker_refuses_a_falsified_observer() {
    for (place, value) in [
        ("decay", json!("0.9991")),
        ("decay", json!("1.0")),
        ("direct/0", json!("-7.08e-5")),
        ("direct/1", json!("0.008846348809886278")),
        ("from_states/1", json!("0")),
        ("from_states/2", json!("7.2e-8")),
        ("from_current", json!("0.0001366662236574981")),
    ] {
        let mut altered = certificate();
        *altered
            .pointer_mut(&format!("/bias_observer/{place}"))
            .unwrap() = value;
        let (for_all_time, region) = closed_loop_second::from_rest_by_python(&emitted(&altered));
        for outcome in [for_all_time, region] {
            match outcome {
                ClaimOutcome::Failed(why) => assert!(why.contains("observer"), "{place}: {why}"),
                ClaimOutcome::NotRun(why) if why.contains("python3 is not installed") => {}
                other => panic!("{place}: {other:?}"),
            }
        }
    }
}

fn outcome(change: impl Fn(&mut EmittedObserver)) -> Result<ShippedLoop, NoBounds> {
    let mut law = law();
    if let Some(observer) = &mut law.observer {
        change(observer);
    }
    loop_as_shipped::check(&parsed(&certificate()), &law)
}

/// An observer that amplifies, that believes the opposite, or of which source and certificate do not both speak, is not proved.
#[test]
fn a_damaged_observer_is_not_proved() {
    let not_shown = [
        outcome(|observer| observer.decay *= BigRational::new(1003.into(), 1000.into())),
        outcome(|observer| observer.from_current = -&observer.from_current),
        outcome(|observer| observer.direct[1] *= BigRational::from_integer(100.into())),
    ];
    for (index, outcome) in not_shown.into_iter().enumerate() {
        let start = outcome.map(|found| real(&found.start));
        assert!(
            matches!(start, Err(NoBounds::NotShown(_))),
            "{index}: {start:?}"
        );
    }
    let without = EmittedLaw {
        observer: None,
        ..law()
    };
    let outcomes = [
        loop_as_shipped::check(&parsed(&certificate()), &without),
        loop_as_shipped::check(
            &Certificate::read(Path::new("../generated")).unwrap(),
            &law(),
        ),
    ];
    for outcome in outcomes {
        let start = outcome.map(|found| real(&found.start));
        assert!(matches!(start, Err(NoBounds::Unphysical(_))), "{start:?}");
    }
}

/// The limit of the estimate bounds the start: beyond it the observer would no longer be linear.
#[test]
fn a_small_limit_of_the_estimate_proves_less() {
    let mut small = certificate();
    small["bias_observer"]["limit_rad"] = "0.012".into();
    let start = loop_as_shipped::check(&parsed(&small), &law()).map(|found| real(&found.start));
    println!("{start:?}");
    assert!(start.is_ok_and(|start| start < real(&shown().start)));
}

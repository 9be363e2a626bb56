//! The properties of a loop, its sweeps, and its export.

use std::path::Path;

use nalgebra::{Matrix3, RowVector3, Vector3};
use workbench::{
    BenchNoise, ControlDesign, DesignReport, ExpectationSettings, ExportLanguage, NamedLoop, Swept,
    loop_drawings, weights_of_excursions,
};

use crate::bench::{session, silent};

fn thesis() -> ControlDesign {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/thesis-4.4.toml");
    ControlDesign::read(&path).expect("a design")
}

/// The weights of the thesis are those of the excursions that they allow, and give its gains.
#[test]
fn weights_and_excursions_are_two_ways_to_say_one_thing() {
    let design = thesis();
    let found = design
        .expectations(&ExpectationSettings::default())
        .expect("a loop");
    let allowed = found.excursions;
    // 1/√25, 1/√0.5, 1/√5e-4.
    for (value, golden) in [
        (allowed.angle_rad, 0.2),
        (allowed.rate_rad_s, 2_f64.sqrt()),
        (allowed.wheel_speed_rad_s, 2000_f64.sqrt()),
        (allowed.current_a, 1.0),
    ] {
        assert!((value / golden - 1.0).abs() < 1e-12, "{value} {golden}");
    }
    let weights =
        weights_of_excursions([0.2, 2_f64.sqrt(), 2000_f64.sqrt(), 1.0]).expect("weights");
    for (weight, golden) in weights.iter().zip([25.0, 0.5, 5e-4, 1.0]) {
        assert!((weight / golden - 1.0).abs() < 1e-12);
    }
    assert!(weights_of_excursions([0.2, 1.0, 1.0, 0.0]).is_err());
}

/// The largest recoverable angle is a little below the angle at which the motor just holds the body. A delay reduces
/// every margin, and beyond the delay margin the loop is unstable.
#[test]
fn a_delay_costs_margin_and_angle() {
    let design = thesis();
    let limit_rad = design.report().expect("a report").recovery_angle_rad;
    let with = |delay_s: f64| {
        let settings = ExpectationSettings {
            delay_s,
            ..Default::default()
        };
        design.expectations(&settings).expect("a loop")
    };
    let (none, some) = (with(0.0), with(20e-3));
    let (angle, delayed) = (
        none.recoverable_angle_rad.expect("one"),
        some.recoverable_angle_rad.expect("one"),
    );
    assert!(
        angle <= limit_rad && angle > 0.6 * limit_rad,
        "{angle} {limit_rad}"
    );
    assert!(delayed < angle, "{delayed} {angle}");
    let (margins, less) = (none.margins.expect("some"), some.margins.expect("some"));
    assert!((margins.delay_margin_s - less.delay_margin_s - 20e-3).abs() < 1e-7);
    assert!(less.phase_margin_rad < margins.phase_margin_rad);
    let lost = with(1.05 * margins.delay_margin_s);
    assert!(!lost.stable && lost.margins.is_none() && lost.step.is_none());
    assert!(!lost.frequencies.is_empty(), "Bode's plot shows why");
}

/// A loop at its samples, x⁺ = (Ad − Bd K) x + Ed d, computed apart from the library.
struct ExactLoop {
    closed: Matrix3<f64>,
    torque_input: Vector3<f64>,
}

impl ExactLoop {
    /// Ed is the series Σ Aᵏ hᵏ⁺¹/(k+1)! E, of which twenty terms are exact for a sample time h far below the time
    /// constants of the pendulum.
    fn new(report: &DesignReport, torque_input: &Vector3<f64>) -> ExactLoop {
        let matrix = |rows: &[[f64; 3]; 3]| Matrix3::from_fn(|row, column| rows[row][column]);
        let (a, ad) = (matrix(&report.a), matrix(&report.ad));
        let mut term = torque_input * report.sample_time_s;
        let mut held = term;
        for k in 2..=20 {
            term = a * term * (report.sample_time_s / f64::from(k));
            held += term;
        }
        let gains = RowVector3::from(report.gains);
        ExactLoop {
            closed: ad - Vector3::from(report.bd) * gains,
            torque_input: held,
        }
    }

    fn next(&self, state: &Vector3<f64>, torque: f64) -> Vector3<f64> {
        self.closed * state + self.torque_input * torque
    }

    /// The largest term of the sum that gives the next angle.
    fn largest_term(&self, state: &Vector3<f64>) -> f64 {
        self.closed.row(0).component_mul(&state.transpose()).amax()
    }
}

/// The response to a constant torque d equals that of the exact loop at every sample, and ends at G α = −d, where
/// gravity balances the torque. The band of a model with errors contains the nominal response.
#[test]
fn answers_to_torques_have_bands() {
    let mut session = session();
    session.identify(&silent()).expect("a fit");
    let design = session.design().expect("a design");
    let settings = ExpectationSettings {
        noise: session.sensor_noise(),
        ..Default::default()
    };
    let found = design.expectations(&settings).expect("a loop");
    let step = found.step.as_ref().expect("an answer");
    let report = design.report().expect("a report");
    let parameter = |name: &str| {
        let model = session.model().expect("a model");
        model.parameter(name).expect("one").value
    };
    // The torque turns the body against the wheel: E = (0, 1/D, −1/D) with D = Θ − j_w.
    let free = parameter("total_inertia") - parameter("wheel_inertia");
    let torque_input = Vector3::new(0.0, 1.0 / free, -1.0 / free);
    let exact = ExactLoop::new(&report, &torque_input);
    let nominal = &step.curves.nominal;
    let (mut state, mut sample, mut largest_term) = (Vector3::zeros(), 0_u32, 0.0_f64);
    let mut differences: Vec<(u32, f64)> = vec![];
    for (time_s, angle) in nominal.time_s.iter().zip(&nominal.angle_rad) {
        while f64::from(sample) * report.sample_time_s < time_s - 0.5 * report.sample_time_s {
            largest_term = largest_term.max(exact.largest_term(&state));
            state = exact.next(&state, step.size);
            sample += 1;
        }
        differences.push((sample, (angle - state[0]).abs()));
    }
    // Every sample rounds the angle by at most a unit in the last place of each of its terms.
    for (sample, difference) in differences {
        let rounding = 8.0 * f64::from(sample.max(1)) * f64::EPSILON * largest_term;
        assert!(difference <= rounding, "{sample}: {difference} {rounding}");
    }
    // At rest, gravity alone balances the torque.
    for _ in 0..100_000 {
        state = exact.next(&state, step.size);
    }
    let at_rest = -step.size / parameter("gravity_torque");
    assert!((state[0] / at_rest - 1.0).abs() < 1e-9, "{state} {at_rest}");
    let [low, high] = step.largest_angle_band_rad.expect("a band");
    assert!(
        low <= step.largest_angle_rad && step.largest_angle_rad <= high && low < high,
        "{low} {high}"
    );
    let band = &step.curves.angle_band;
    for ((angle, low), high) in step
        .curves
        .nominal
        .angle_rad
        .iter()
        .zip(&band.low)
        .zip(&band.high)
    {
        assert!(low <= high && *low <= angle + 1e-12 && angle - 1e-12 <= *high);
    }
    // The log of the swing shows the noise of angle and rate, that of the spin-up the noise of the wheel speed.
    // Without a bench, the noise is assumed.
    let noise = found.noise.as_ref().expect("noise");
    let named = |index: usize, log: &str| noise.sources[index] == format!("log \"{log}\"");
    assert!(
        named(0, "swing") && named(1, "swing") && named(2, "spin-up"),
        "{noise:?}"
    );
    let assumed = design
        .expectations(&ExpectationSettings::default())
        .expect("a loop");
    let assumed = assumed.noise.expect("noise");
    assert!(
        assumed
            .sources
            .iter()
            .all(|source| source.contains("assumed")),
        "{assumed:?}"
    );
    assert_ne!(settings.noise, BenchNoise::default());
    let named = NamedLoop {
        name: "<one>",
        report: &report,
        expectations: &found,
    };
    let files = loop_drawings(
        "compare-",
        &[
            named,
            NamedLoop {
                name: "two",
                ..named
            },
        ],
    )
    .expect("figures");
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "compare-step-response.svg",
            "compare-push-response.svg",
            "compare-bode.svg",
            "compare-nyquist.svg",
            "compare-poles.svg"
        ]
    );
    assert!(
        files
            .iter()
            .all(|file| file.text.contains("&lt;one&gt;") && !file.text.contains("<one>"))
    );
}

/// In a sweep over the delay, the delay margin falls by the delay until the loop is unstable; the row then gives the
/// reason.
#[test]
fn a_sweep_ends_where_the_loop_does() {
    let design = thesis();
    let values: Vec<f64> = (0..12).map(|step| 6e-3 * f64::from(step)).collect();
    let sweep = design.sweep(Swept::Delay, &values, &ExpectationSettings::default());
    let first = sweep.rows[0].point.as_ref().expect("a loop");
    for row in &sweep.rows {
        match &row.point {
            Some(point) => {
                assert!(
                    (point.delay_margin_s + row.value - first.delay_margin_s).abs() < 1e-7,
                    "{row:?}"
                );
                assert_eq!(point.gains, first.gains);
            }
            None => assert!(
                row.value >= first.delay_margin_s && row.failure.contains("unstable"),
                "{row:?}"
            ),
        }
    }
    assert!(
        sweep.rows.iter().any(|row| row.point.is_none()),
        "{first:?}"
    );
    let table = sweep.table().expect("a table");
    assert_eq!(table.text.lines().count(), 13);
    assert!(
        sweep
            .drawing("thesis")
            .expect("a figure")
            .text
            .contains("</svg>")
    );
}

/// Every number of an export reads back as the same double.
#[test]
fn an_export_gives_the_numbers_back() {
    let design = thesis();
    let report = design.report().expect("a report");
    for language in [ExportLanguage::Python, ExportLanguage::Matlab] {
        let text = design.export(language).text;
        let matrix = |name: &str| -> Vec<f64> {
            let rest = text.split(&format!("\n{name} = ")).nth(1).expect(name);
            let rest = rest.trim_start_matches("np.array(");
            let end = rest.find(if language == ExportLanguage::Python {
                "])\n"
            } else {
                "];\n"
            });
            let inside = &rest[..end.expect("an end")];
            let numbers = inside.split(['[', ']', ',', ';', '\n', ' ']);
            numbers
                .filter(|part| !part.is_empty())
                .map(|part| part.parse().expect("a number"))
                .collect()
        };
        assert_eq!(matrix("A"), report.a.concat());
        assert_eq!(matrix("Bd"), report.bd);
        assert_eq!(matrix("K"), report.gains);
        assert_eq!(matrix("Q"), [25.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 5e-4]);
        assert!(text.contains("total_inertia") && text.contains("sample_time = 1e-3"));
    }
    assert_eq!(
        design.export(ExportLanguage::Python).name,
        "model_thesis_4_4.py"
    );
}

/// An export states the correlations of fitted parameters. That of a derived parameter follows from them, and zero
/// would be wrong.
#[test]
fn an_export_states_no_correlation_of_a_derived_parameter() {
    let mut text = String::from(
        "[correlation]\nparameters = [\"total_inertia\", \"wheel_inertia\"]\nmatrix = [[1.0, 0.25], [0.25, 1.0]]\n\
         [effects]\npresent = [\"body-viscous-friction\", \"wheel-viscous-friction\"]\n\
         [design]\nsample_time = 0.001\nstate_weights = [25.0, 0.5, 5e-4]\ncurrent_weight = 1.0\n\
         current_limit = 2.0\n",
    );
    for (name, value, std) in [
        ("total_inertia", 2.30344e-3, "std = 1e-6"),
        ("wheel_inertia", 1.36125e-4, "std = 1e-7"),
        ("gravity_torque", 0.245158, ""),
        ("torque_constant", 0.0335, ""),
        ("body_viscous_friction", 2.1e-5, ""),
        ("wheel_viscous_friction", 1.75204e-5, ""),
        ("body_inertia", 1.5e-4, "std = 1e-6"),
    ] {
        text.push_str(&format!("[parameters.{name}]\nvalue = {value:?}\n{std}\n"));
    }
    let file = bench_files::ModelFile::parse(&text, std::path::Path::new("model.toml"));
    let design = workbench::ControlDesign::of(file.expect("a model")).expect("a design");
    let python = design.export(ExportLanguage::Python).text;
    assert!(
        python.contains("correlation_of = [\"total_inertia\", \"wheel_inertia\"]\n"),
        "{python}"
    );
    assert!(python.contains("[2.5e-1, 1e0]"), "{python}");
    assert!(python.contains("\"body_inertia\": ("), "{python}");
}

/// The delays of the thesis' hardware, their effect on the margins, and the loops with other sample times.
#[test]
fn the_hardware_makes_the_loop_late() {
    let design = thesis();
    let found = design
        .late_loop(&ExpectationSettings::default())
        .expect("a loop");
    let late_s = |what: &str| -> f64 {
        let parts = found.parts.iter().filter(|part| part.what == what);
        parts.map(|part| part.late_s).sum()
    };
    // One sample of computation; readings of a gyroscope of 800 Hz are half of 1.25 ms old on the mean.
    for (what, wanted_s) in [
        ("the current", 1e-3),
        ("the rate", 0.625e-3),
        ("the angle", 0.625e-3),
    ] {
        assert!((late_s(what) - wanted_s).abs() < 1e-12, "{what}: {found:?}");
    }
    assert!((found.ahead_s - 1.625e-3).abs() < 1e-12);
    let law = found.law.as_ref().expect("a stable loop");
    let whole_s = design.report().expect("a report").margins.delay_margin_s;
    // The margin is reduced by more than the sample of computation, and by less than if every reading were 1.25 ms old.
    let lost_s = whole_s - law.margins.delay_margin_s;
    assert!(lost_s > 1e-3 && lost_s < 1e-3 + 1.25e-3, "{lost_s}");
    assert!(law.poles_per_s.iter().all(|pole| pole[0] < 0.0));

    // The loop with the predicting law has nearly the poles of the loop without delay. They differ a little, because
    // the law also predicts the wheel speed, whose sensor is not late.
    let predicting = found.predicting.as_ref().expect("a stable loop");
    let wanted = design.report().expect("a report").closed_loop_poles_per_s;
    for pole in &wanted {
        let near = predicting.poles_per_s.iter();
        let near = near.map(|other| (other[0] - pole[0]).hypot(other[1] - pole[1]));
        let size = pole[0].hypot(pole[1]);
        let nearest = near.fold(f64::INFINITY, f64::min);
        assert!(
            nearest < 0.02 * size,
            "{pole:?} off by {nearest}: {found:?}"
        );
    }

    let rows = &found.sample_times;
    assert!(
        rows.windows(2)
            .all(|pair| pair[0].sample_time_s < pair[1].sample_time_s)
    );
    let margins: Vec<f64> = rows
        .iter()
        .filter_map(|row| Some(row.law.as_ref()?.margins.modulus_margin))
        .collect();
    assert!(
        margins.len() > 5 && margins.windows(2).all(|pair| pair[1] < pair[0]),
        "{margins:?}"
    );
    // The design's own sample time is shorter than the interval of the gyroscope's readings, which its row states.
    assert!(rows[0].sample_time_s == 1e-3 && !rows[0].sensible && rows[0].why.contains("fresh"));
    assert!(rows[1].sample_time_s == 1.25e-3 && rows[1].sensible);
    let last = rows.last().expect("rows");
    assert!(!last.sensible && !last.why.is_empty());
}

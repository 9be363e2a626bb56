//! A clock that jitters: white noise that grows with the slope, and no missing effect.

use diagnose::Verdict;
use exam::{DriveProgram, ExamLog, Hidden};
use identify::{FitProblem, Record};
use plant::{EffectId, Kind, Model};
use rand::{RngExt, SeedableRng};

use crate::thesis_bench::{Planned, diagnosed, measured, truth};

const PLANNED: [Planned; 4] = [
    ("swing 20", Kind::FreeSwing, 0.35, DriveProgram::None),
    ("swing 52", Kind::FreeSwing, 0.9, DriveProgram::None),
    ("spin-up", Kind::SpinUp, 0.0, DriveProgram::Step(0.3)),
    ("reversed", Kind::SpinUp, 0.0, DriveProgram::Step(-0.5)),
];
/// Samples of the simulation between two of the log.
const FINE: usize = 10;

/// How the clock errs, in intervals of the log.
#[derive(Clone, Copy, Debug)]
enum Clock {
    /// Every sample is taken where its stamp says.
    Steady,
    /// The stamps are off by up to this much to either side.
    Stamps(f64),
    /// The samples are taken late by up to this much, and stamped evenly.
    Late(f64),
}

fn problem(hidden: Option<Hidden>, clock: Clock, seed: u64) -> FitProblem {
    let truth = truth(hidden);
    let mut dice = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let of = |((name, kind, ..), log): (&Planned, ExamLog)| {
        let count = log.time_s.len() / FINE - 1;
        let step_s = 0.001 * FINE as f64;
        let (mut at, mut time_s) = (vec![], vec![]);
        for k in 0..count {
            let [mut sample, mut stamp_s] = [(k * FINE) as f64, k as f64 * step_s];
            match clock {
                Clock::Steady => {}
                Clock::Stamps(share) => stamp_s += share * step_s * dice.random_range(-1.0..1.0),
                Clock::Late(share) => sample += share * FINE as f64 * dice.random_range(0.0..1.0),
            }
            at.push(sample.round() as usize);
            time_s.push(stamp_s);
        }
        let pick = |series: &Vec<f64>| at.iter().map(|&k| series[k]).collect::<Vec<f64>>();
        let outputs = log.measured.each_ref().map(|series| Some(pick(series)));
        let current = Some(pick(&log.current_a));
        Record::new(name, *kind, time_s, outputs, current, false)
    };
    let measured = measured(&truth, &PLANNED, [40.0, 0.001], 10 * seed);
    let records = measured.into_iter().map(of).collect();
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_records(records, known, Default::default()).expect("records")
}

#[test]
fn a_jittering_clock_is_no_missing_effect_and_hides_none() {
    let clocks = [
        (Clock::Steady, None),
        (Clock::Stamps(0.2), Some(0.2 / 3f64.sqrt())),
        (Clock::Late(0.5), Some(0.5 / 12f64.sqrt())),
    ];
    for (seed, (clock, jitter)) in (1..).zip(clocks) {
        let nothing = problem(None, clock, seed);
        for record in nothing.all_records() {
            let found = record.clock_jitter_s;
            eprintln!("{clock:?} seed {seed}, {}: jitter {found:?} s", record.name);
            if record.kind == Kind::FreeSwing {
                let expected_s = jitter.map(|share| 0.01 * share);
                assert_eq!(found.is_some(), expected_s.is_some());
                if let Some((found, expected)) = found.zip(expected_s) {
                    assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
                }
            }
        }
        let diagnosis = diagnosed(&nothing);
        assert_eq!(diagnosis.verdict, Verdict::NothingMissing, "{clock:?}");
        for (effect, size) in [
            (EffectId::BodyCoulombFriction, 3e-4),
            (EffectId::BodyQuadraticDrag, 2e-5),
        ] {
            let hidden = Hidden::Library(effect, vec![size]);
            let diagnosis = diagnosed(&problem(Some(hidden), clock, seed));
            let seen = (diagnosis.verdict, &diagnosis.certain);
            assert_eq!(
                seen,
                (Verdict::Explained, &Model::base().with(effect)),
                "{clock:?}, {effect:?}, seed {seed}"
            );
        }
    }
}

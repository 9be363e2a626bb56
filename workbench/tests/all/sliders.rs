//! Experiments simulated with other parameter values.

use workbench::{Error, ExperimentCurves, Output};

use crate::bench::{session, silent};

/// The simulated angle of the swing.
fn angle(curves: &[ExperimentCurves]) -> &[f64] {
    let swing = curves.iter().find(|curves| curves.experiment == "swing");
    let angle = swing.and_then(|swing| swing.channel(Output::Angle));
    &angle.expect("the swing's angle").simulated
}

#[test]
fn the_fitted_parameters_give_the_comparison() {
    let mut session = session();
    session.identify(&silent()).expect("a fit");
    let compared = session.compare(&silent()).expect("a comparison");
    let sliders = session.predictor(&silent()).expect("starts");
    let parameters = sliders.parameters();
    let same: Vec<(&str, f64)> = parameters
        .iter()
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    for changes in [&[][..], &same] {
        let curves = sliders.curves(changes).expect("curves");
        for (own, compared) in curves.iter().zip(&compared.curves) {
            for (own, compared) in own.channels.iter().zip(&compared.channels) {
                assert_eq!(own.simulated, compared.simulated);
            }
        }
        // The curves of one experiment alone are the same as among the others.
        for (index, compared) in compared.curves.iter().enumerate() {
            let own = sliders.curves_of(index, changes).expect("curves");
            let own = own.expect("there is this experiment");
            assert_eq!(own.experiment, compared.experiment);
            for (own, compared) in own.channels.iter().zip(&compared.channels) {
                assert_eq!(own.simulated, compared.simulated);
            }
        }
    }
    let beyond = sliders.curves_of(compared.curves.len(), &[]);
    assert!(beyond.expect("no error").is_none());
}

/// A pendulum without friction keeps its amplitude; gravity four times as large halves its period.
#[test]
fn curves_follow_the_parameters() {
    let mut session = session();
    session.identify(&silent()).expect("a fit");
    let sliders = session.predictor(&silent()).expect("starts");
    let still = sliders.curves(&[("body_viscous_friction", 0.0)]);
    let still = still.expect("curves");
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let angle_rad = angle(&still);
    let tenth = angle_rad.len() / 10;
    let (first, last) = (
        largest(&angle_rad[..tenth]),
        largest(&angle_rad[9 * tenth..]),
    );
    assert!((last / first - 1.0).abs() < 1e-3, "{first} {last}");

    let crossings = |curves: &[ExperimentCurves]| {
        let pairs = angle(curves).windows(2);
        pairs.filter(|pair| pair[0] * pair[1] < 0.0).count()
    };
    let gravity = sliders.parameters();
    let gravity = gravity.iter().find(|(name, _)| name == "gravity_torque");
    let gravity = gravity.expect("G").1;
    let heavy = sliders.curves(&[
        ("body_viscous_friction", 0.0),
        ("gravity_torque", 4.0 * gravity),
    ]);
    let ratio = crossings(&heavy.expect("curves")) as f64 / crossings(&still) as f64;
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");

    assert!(matches!(
        sliders.curves(&[("nonsense", 1.0)]),
        Err(Error::UnknownParameter { .. })
    ));
}

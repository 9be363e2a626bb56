//! Results in words, for text and figures alike.

use identify::ResidualKind;

use crate::comparison::FailurePlace;
use crate::numbers::{significant, with_uncertainty};
use crate::swing_decay::AmplitudeLaw;

/// A channel or a coordinate in words: `wheel_speed` is "wheel speed".
pub fn spoken(name: &str) -> &str {
    match name {
        "wheel_speed" => "wheel speed",
        "wheel_angle" => "wheel angle",
        other => other,
    }
}

/// A place in words: "angle 0.1 to 0.2 rad".
pub fn place(place: &FailurePlace) -> String {
    format!(
        "{} {} to {} {}",
        spoken(place.coordinate.name()),
        significant(place.from, 3),
        significant(place.to, 3),
        place.coordinate.unit()
    )
}

/// The residual in which a place was found, in words.
pub fn residual(quantity: ResidualKind) -> &'static str {
    match quantity {
        ResidualKind::ResidualTorque => "missing torque",
        ResidualKind::Output => "prediction error",
    }
}

/// Effects that act together: "body-coulomb-friction + gyro-bias".
pub fn set<'a>(effects: impl IntoIterator<Item = &'a str>) -> String {
    effects.into_iter().collect::<Vec<_>>().join(" + ")
}

/// The terms of a law for the amplitude: "C = 0.0123 ± 0.0004 rad/s".
pub fn amplitude_law(law: &AmplitudeLaw) -> String {
    let terms = law.terms().into_iter().map(|(symbol, unit, value, std)| {
        format!("{symbol} = {} {unit}", with_uncertainty(value, std))
    });
    terms.collect::<Vec<_>>().join(", ")
}

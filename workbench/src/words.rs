//! Results in words, for text and figures alike.

use identify::ResidualKind;

use crate::comparison::FailurePlace;
use crate::measured_linearity::MeasuredSwings;
use crate::numbers::{percent, significant, with_uncertainty};
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

/// One sentence on the range of amplitudes in which the linear model has the measured period.
pub fn linear_range(found: &MeasuredSwings) -> String {
    let degrees = |angle_rad: f64| format!("{:.1}°", angle_rad.to_degrees());
    let (Some(period_s), Some([least, most])) =
        (found.linear_period_s, found.measured_amplitudes_rad)
    else {
        return "no swing is long and clean enough to measure its period".to_owned();
    };
    let measured = format!("measured from {} to {}", degrees(least), degrees(most));
    let period = format!("{} s", significant(period_s, 4));
    let share = percent(found.period_share);
    match found.period_good_between_rad {
        None => format!(
            "at no amplitude is the period within {share} of the linear model's {period} ({measured})"
        ),
        Some([from, to]) => {
            let end = match found.period_off_from_rad {
                Some(off) => format!(", off from {} on", degrees(off)),
                None => String::new(),
            };
            format!(
                "the period is within {share} of the linear model's {period} from {} to {}{end} ({measured})",
                degrees(from),
                degrees(to)
            )
        }
    }
}

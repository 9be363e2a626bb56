//! `src/constants.rs` of the emitted crate where gyroscope and accelerometer show the body.

use attitude::AttitudeSpec;
use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::constants_parts::{array, field, line, stated, wheel_and_drive};
use crate::emit::{inner_docs, integer, outer_docs};
use crate::exact::ShortestDecimal;
use crate::hardware_words::{HardwareWords, InertialWords};
use crate::helpers::bias_observer::BiasObserver;
use crate::helpers::calibration::SensorLine;
use crate::helpers::filter::FilterConstants;
use crate::helpers::supervisor::Limits;
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;
use crate::supervisor;

/// The constants where gyroscope and accelerometer show the body.
pub(super) fn tokens(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
    attitude: &AttitudeSpec,
    own: &InertialWords,
) -> TokenStream {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let hardware = &spec.hardware;
    let docs = inner_docs(&[
        "Constants of this bench: sensors, mounting, converter and drive.",
        "",
        "Each word is the real number rounded once to the format stated at its field.",
        "",
        &stated(
            "Accelerometer by its part",
            hardware.accelerometer_m_s2_per_count.map(number),
            "m/s2 per count",
        ),
        &stated(
            "Fresh samples of the gyroscope",
            hardware.gyro_rate_hz.map(number),
            "a second",
        ),
        &format!("Timer of the drive: {} bits.", spec.drive.bits),
    ]);
    let filter_docs = outer_docs(&[
        format!(
            "Attitude filter at {} s with beta = {} rad/s.",
            number(spec.sample_time_s),
            number(attitude.beta_rad_s)
        ),
        format!(
            "Every correction has the same size: at rest the estimate ripples by up to 2 beta T = {:.2e} rad.",
            2.0 * attitude.beta_rad_s * spec.sample_time_s
        ),
        String::new(),
        format!(
            "Gravity {} m/s2, weakest usable field {} uT, lever arm ({}, {}) m.",
            number(attitude.gravity_m_s2),
            number(attitude.field_min_ut),
            number(attitude.lever_arm_m[0]),
            number(attitude.lever_arm_m[1])
        ),
        format!(
            "The gyroscope's drift is estimated with a time constant of {} s, up to {} rad/s.",
            number(attitude.drift_time_s),
            number(attitude.drift_limit_rad_s)
        ),
        String::new(),
        format!(
            "Ends of the ranges: accelerometer {} counts, magnetometer {} counts. Readings there are not used.",
            counts(attitude.accel_clip),
            counts(attitude.mag_clip)
        ),
        String::new(),
        "| sensor | bias (counts) | matrix, row by row |".to_owned(),
        "|---|---|---|".to_owned(),
        sensor_row("gyroscope, rad/s per count", &attitude.gyro),
        sensor_row("accelerometer, m/s2 per count", &attitude.accel),
        sensor_row("magnetometer, uT per count", &attitude.mag),
    ]);
    let filter = filter(&own.filter);
    let mounting_docs = outer_docs(&[format!(
        "Mounting angle {} rad, wrapped, in Q28.",
        number(attitude.mounting_angle_rad)
    )]);
    let mounting = integer(own.mounting_angle.into());
    let [angle, rate, _] = &law.terms;
    let angle_docs = outer_docs(&[format!(
        "From Q28 rad to the word of the angle ({}), before the shift.",
        angle.input.format.type_name()
    )]);
    let angle_max = integer(own.angle_max.into());
    let angle_factor = integer(own.angle_factor.into());
    let angle_shift = integer(own.angle_shift.into());
    let rate_docs = outer_docs(&[format!(
        "From half-angles a step in Q32 to the word of the rate ({}).",
        rate.input.format.type_name()
    )]);
    let rate_line = line(&own.rate);
    let (duty_type, wheel_and_drive) = wheel_and_drive(spec, law, words);
    let encoder_type = words
        .wheel_encoder
        .map(|_| quote!(encoder::EncoderNumbers,));
    let observer_docs = outer_docs(&match &hardware.bias_observer {
        None => vec!["No observer of the angle's bias: the estimate is zero.".to_owned()],
        Some(observer) => vec![
            format!(
                "Observer of the angle's bias with decay {} a step, within ±{} rad.",
                number(observer.decay),
                number(observer.limit_rad)
            ),
            String::new(),
            "The certificate states no ellipsoid of the loop with this observer: the checker shows that the loop is stable"
                .to_owned(),
            "(`bias-observer-stable`), and bounds it from starts at rest.".to_owned(),
        ],
    });
    let observer = bias_observer(&own.bias_observer);
    let limit_docs = outer_docs(&supervisor::documents(spec, attitude));
    let limits = limits(&own.limits);
    let micros = integer(words.sample_time_us.into());
    quote! {
        #docs
        use super::{
            bias_observer::BiasObserver, calibration::SensorLine, drift::DriftGain,
            #encoder_type
            filter::FilterConstants,
            lever_arm::LeverArm, line::Line, supervisor::Limits,
        };
        #duty_type
        /// Time between two steps in µs.
        pub const SAMPLE_TIME_US: u32 = #micros;
        #filter_docs
        pub const FILTER: FilterConstants = #filter;
        #mounting_docs
        pub const MOUNTING_ANGLE: i32 = #mounting;
        /// Largest angle whose word fits, less the largest bias, in Q28 rad.
        pub const ANGLE_MAX: i32 = #angle_max;
        #angle_docs
        pub const ANGLE_FACTOR: i32 = #angle_factor;
        /// Number of bits by which the word of the angle has fewer fraction bits than Q28.
        pub const ANGLE_SHIFT: u32 = #angle_shift;
        #rate_docs
        pub const RATE_LINE: Line = #rate_line;
        #wheel_and_drive
        #observer_docs
        pub const BIAS_OBSERVER: BiasObserver = #observer;
        #limit_docs
        pub const LIMITS: Limits = #limits;
    }
}

fn counts(clip: [i32; 3]) -> String {
    clip.map(|limit| limit.to_string()).join(", ")
}

fn sensor_row(what: &str, line: &attitude::SensorLine) -> String {
    let list = |values: Vec<f64>| {
        values
            .into_iter()
            .map(|value| ShortestDecimal::new(value).text)
            .collect::<Vec<_>>()
            .join(", ")
    };
    format!(
        "| {what} | {} | {} |",
        list(line.bias_counts.iter().copied().collect()),
        list(line.matrix.transpose().iter().copied().collect())
    )
}

fn filter(words: &FilterConstants) -> TokenStream {
    let gyro = sensor_line(&words.gyro);
    let accel = sensor_line(&words.accel);
    let mag = sensor_line(&words.mag);
    let gravity = integer(words.gravity_squared_min.into());
    let field = integer(words.field_squared_min.into());
    let centripetal = array(&words.lever_arm.centripetal);
    let tangential = array(&words.lever_arm.tangential);
    let beta = integer(words.beta.into());
    let accel_clip = array(&words.accel_clip);
    let mag_clip = array(&words.mag_clip);
    let drift_gain = integer(words.drift.gain.into());
    let drift_shift = integer(words.drift.shift.into());
    let drift_limit = integer(words.drift.limit.into());
    quote!(FilterConstants {
        gyro: #gyro,
        accel: #accel,
        mag: #mag,
        gravity_squared_min: #gravity,
        field_squared_min: #field,
        lever_arm: LeverArm { centripetal: #centripetal, tangential: #tangential },
        beta: #beta,
        accel_clip: #accel_clip,
        mag_clip: #mag_clip,
        drift: DriftGain { gain: #drift_gain, shift: #drift_shift, limit: #drift_limit },
    })
}

fn sensor_line(words: &SensorLine) -> TokenStream {
    let bias = array(&words.bias);
    let [x, y, z] = [words.x, words.y, words.z].map(|row| array(&row));
    let shift = integer(words.shift.into());
    let half_unit = integer(words.half_unit.into());
    quote!(SensorLine {
        bias: #bias,
        x: #x,
        y: #y,
        z: #z,
        shift: #shift,
        half_unit: #half_unit,
    })
}

fn bias_observer(words: &BiasObserver) -> TokenStream {
    let unit = integer(words.unit.into());
    let decay = integer(words.decay.into());
    let direct = array(&words.direct);
    let from_states = array(&words.from_states);
    let from_current = integer(words.from_current.into());
    let state_shift = integer(words.state_shift.into());
    let angle_shift = integer(words.angle_shift.into());
    let limit = integer(words.limit.into());
    quote!(BiasObserver {
        unit: #unit,
        decay: #decay,
        direct: #direct,
        from_states: #from_states,
        from_current: #from_current,
        state_shift: #state_shift,
        angle_shift: #angle_shift,
        limit: #limit,
    })
}

fn limits(words: &Limits) -> TokenStream {
    let fields = [
        ("angle_trip", words.angle_trip),
        ("angle_arm", words.angle_arm),
        ("rate_arm", words.rate_arm),
        ("window", words.window),
    ]
    .map(|(name, value)| field(name, value));
    let window_shift = integer(words.window_shift.into());
    let more = [
        ("gravity_low", words.gravity_low),
        ("gravity_high", words.gravity_high),
        ("agreement", words.agreement),
        ("quiet_turn", words.quiet_turn),
    ]
    .map(|(name, value)| field(name, value));
    let gyro_clip = array(&words.gyro_clip);
    let last = [
        ("wheel_low", words.wheel_low),
        ("wheel_high", words.wheel_high),
        ("wheel_steps", words.wheel_steps),
        ("clipped_steps", words.clipped_steps),
        ("frozen_steps", words.frozen_steps),
        ("rejected_steps", words.rejected_steps),
        ("saturated_steps", words.saturated_steps),
    ]
    .map(|(name, value)| field(name, value));
    quote!(Limits {
        #(#fields,)*
        window_shift: #window_shift,
        #(#more,)*
        gyro_clip: #gyro_clip,
        #(#last,)*
    })
}

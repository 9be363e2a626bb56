//! `src/constants.rs` of the emitted crate: the words of sensors, mounting, converter and drive.

use attitude::AttitudeSpec;
use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::{body_constants_rs, inner_docs, integer, outer_docs, print};
use crate::exact::ShortestDecimal;
use crate::file::EmittedFile;
use crate::hardware::{BodySensor, EncoderSpec, WheelSensor};
use crate::hardware_words::{BodyWords, DutyWords, HardwareWords, InertialWords};
use crate::helpers::bias_observer::BiasObserver;
use crate::helpers::calibration::SensorLine;
use crate::helpers::encoder::EncoderNumbers;
use crate::helpers::filter::FilterConstants;
use crate::helpers::line::Line;
use crate::helpers::plane::Plane;
use crate::helpers::supervisor::Limits;
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;
use crate::supervisor;

/// Emits `src/constants.rs`.
pub fn file(spec: &ModuleSpec, law: &IntegerLaw, words: &HardwareWords) -> EmittedFile {
    let tokens = match (&spec.hardware.body, &words.body) {
        (BodySensor::Inertial(attitude), BodyWords::Inertial(own)) => {
            inertial(spec, law, words, attitude, own)
        }
        (BodySensor::Encoder(body), BodyWords::Encoder(own)) => {
            body_constants_rs::tokens(spec, law, words, body, own)
        }
        // The words of a module are derived from its sensors.
        _ => TokenStream::new(),
    };
    EmittedFile {
        path: "src/constants.rs".to_owned(),
        contents: print(spec, tokens),
    }
}

/// The constants where gyroscope and accelerometer show the body.
fn inertial(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
    attitude: &AttitudeSpec,
    own: &InertialWords,
) -> TokenStream {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let hardware = &spec.hardware;
    let docs = inner_docs(&[
        "Numbers of this bench: sensors, mounting, converter and drive.",
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
            "The correction has one size: at rest the estimate ripples by up to 2 beta T = {:.2e} rad.",
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
            "The gyroscope's drift is followed within {} s, up to {} rad/s.",
            number(attitude.drift_time_s),
            number(attitude.drift_limit_rad_s)
        ),
        String::new(),
        format!(
            "Unknown at or beyond: accelerometer {} counts, magnetometer {} counts.",
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
    let wheel_docs = outer_docs(&[wheel_document(spec, law)]);
    let rate_line = line(&own.rate);
    let wheel_line = line(&words.wheel_speed);
    let (duty_type, duty) = duty(spec, law, words);
    let encoder_type = words
        .wheel_encoder
        .map(|_| quote!(encoder::EncoderNumbers,));
    let wheel_encoder = wheel_encoder(spec, words);
    let zero = integer(words.zero_current.into());
    let zero_docs = outer_docs(&zero_documents(spec));
    let observer_docs = outer_docs(&match &hardware.bias_observer {
        None => vec!["No observer of the angle's bias: the estimate is zero.".to_owned()],
        Some(observer) => vec![
            format!(
                "Observer of the angle's bias with decay {} a step, within ±{} rad.",
                number(observer.decay),
                number(observer.limit_rad)
            ),
            String::new(),
            "The certificate's claims about the closed loop are about `control` without it; the checker"
                .to_owned(),
            "shows that the loop with it is stable (`bias-observer-stable`).".to_owned(),
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
        /// Bits that the word of the angle has less than Q28.
        pub const ANGLE_SHIFT: u32 = #angle_shift;
        #rate_docs
        pub const RATE_LINE: Line = #rate_line;
        #wheel_docs
        pub const WHEEL_SPEED_LINE: Line = #wheel_line;
        #wheel_encoder
        #duty
        #zero_docs
        pub const ZERO_CURRENT: u16 = #zero;
        #observer_docs
        pub const BIAS_OBSERVER: BiasObserver = #observer;
        #limit_docs
        pub const LIMITS: Limits = #limits;
    }
}

/// What the words of the wheel's sensor mean.
pub(super) fn wheel_document(spec: &ModuleSpec, law: &IntegerLaw) -> String {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let hardware = &spec.hardware;
    format!(
        "From {} to the word of the wheel speed ({}): {} count + {} rad/s, within ±{} rad/s.",
        match hardware.wheel {
            WheelSensor::Converter => "counts",
            WheelSensor::Driver => "the driver's word",
            WheelSensor::Encoder(_) => "the counts that the encoder turned over its window",
        },
        law.terms[2].input.format.type_name(),
        number(hardware.wheel_speed_per_count),
        number(hardware.wheel_speed_at_zero),
        number(spec.ranges.wheel_speed_rad_s)
    )
}

/// The constant of the wheel's encoder, where there is one.
pub(super) fn wheel_encoder(spec: &ModuleSpec, words: &HardwareWords) -> Option<TokenStream> {
    let (WheelSensor::Encoder(stated), Some(numbers)) =
        (&spec.hardware.wheel, &words.wheel_encoder)
    else {
        return None;
    };
    let docs = outer_docs(&encoder_documents(
        "The wheel's encoder",
        "speed",
        stated,
        spec.sample_time_s,
        numbers,
    ));
    let numbers = encoder(numbers);
    Some(quote! {
        #docs
        pub const WHEEL_ENCODER: EncoderNumbers = #numbers;
    })
}

/// The duty's words, and the import of their type where it is another than that of other lines.
pub(super) fn duty(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
) -> (Option<TokenStream>, TokenStream) {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let current = law.current.type_name();
    match (&words.duty, &spec.drive.voltage) {
        (DutyWords::Plane(words), Some(voltage)) => {
            let docs = outer_docs(&[
                format!(
                    "From the words of the current ({current}) and of the wheel speed ({}) to the duty of the voltage",
                    law.terms[2].input.format.type_name()
                ),
                format!(
                    "{} Ohm u + {} V s/rad w: {} V per count, duty {} at 0 V, within the supply's ±{} V.",
                    number(voltage.winding_ohm),
                    number(voltage.back_emf_v_s),
                    number(voltage.volts_per_count),
                    spec.drive.duty_zero,
                    number(voltage.supply_v)
                ),
                "At its ends the supply is too low for the current, and less flows.".to_owned(),
            ]);
            let plane = plane(words);
            let tokens = quote! {
                #docs
                pub const DUTY_PLANE: Plane = #plane;
            };
            let import = quote! { use super::plane::Plane; };
            (Some(import), tokens)
        }
        (DutyWords::Line(words), _) => {
            let docs = outer_docs(&[format!(
                "From the word of the current ({current}) to the duty: {} A per count, duty {} at zero current.",
                number(spec.drive.amperes_per_count),
                spec.drive.duty_zero
            )]);
            let line = line(words);
            let tokens = quote! {
                #docs
                pub const DUTY_LINE: Line = #line;
            };
            (None, tokens)
        }
        (DutyWords::Plane(_), None) => (None, quote!()),
    }
}

/// The duty while the controller does not run.
pub(super) fn zero_documents(spec: &ModuleSpec) -> Vec<String> {
    let Some(voltage) = &spec.drive.voltage else {
        return vec!["Duty at zero current.".to_owned()];
    };
    let speed = spec.ranges.wheel_speed_rad_s;
    vec![
        "Duty while the controller does not run: 0 V, whatever any sensor says, so that nothing is fed to the motor."
            .to_owned(),
        "A bridge that stays on then shorts the winding, and the wheel brakes itself; at".to_owned(),
        format!(
            "{speed} rad/s a current of {:.2} A would begin to flow. A firmware that is to let the wheel run out",
            voltage.back_emf_v_s * speed / voltage.winding_ohm
        ),
        "switches the bridge off while `status()` is not `Running`.".to_owned(),
    ]
}

/// What the words of an encoder mean.
pub(super) fn encoder_documents(
    name: &str,
    shows: &str,
    encoder: &EncoderSpec,
    sample_time_s: f64,
    numbers: &EncoderNumbers,
) -> Vec<String> {
    vec![
        format!(
            "{name}: {} counts a turn, wrapping at {}; its turn over {} steps is the {shows},",
            ShortestDecimal::new(encoder.counts_per_turn).text,
            numbers.wrap,
            numbers.window
        ),
        format!(
            "which is {} s old. A step that turns by {} counts more than the one before is no motion.",
            ShortestDecimal::new(0.5 * f64::from(encoder.window) * sample_time_s).text,
            numbers.jump
        ),
    ]
}

pub(super) fn encoder(words: &EncoderNumbers) -> TokenStream {
    let wrap = integer(words.wrap.into());
    let window = integer(words.window.into());
    let jump = integer(words.jump.into());
    quote!(EncoderNumbers { wrap: #wrap, window: #window, jump: #jump })
}

fn plane(words: &Plane) -> TokenStream {
    let current = integer(words.current.into());
    let speed = integer(words.speed.into());
    let offset = integer(words.offset);
    let shift = integer(words.shift.into());
    let low = integer(words.low.into());
    let high = integer(words.high.into());
    quote!(Plane {
        current: #current, speed: #speed, offset: #offset, shift: #shift, low: #low, high: #high,
    })
}

fn stated(what: &str, value: Option<String>, unit: &str) -> String {
    match value {
        Some(value) => format!("{what}: {value} {unit}."),
        None => format!("{what}: not stated."),
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

pub(super) fn line(words: &Line) -> TokenStream {
    let scale = integer(words.scale.into());
    let offset = integer(words.offset);
    let shift = integer(words.shift.into());
    let low = integer(words.low.into());
    let high = integer(words.high.into());
    quote!(Line { scale: #scale, offset: #offset, shift: #shift, low: #low, high: #high })
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

/// `name: value` of a struct literal.
pub(super) fn field(name: &str, value: i32) -> TokenStream {
    let name = quote::format_ident!("{name}");
    let value = integer(value.into());
    quote!(#name: #value)
}

fn array(values: &[i32]) -> TokenStream {
    let values = values.iter().map(|&value| integer(value.into()));
    quote!([#(#values),*])
}

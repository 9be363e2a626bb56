//! The common parts of the effects that make a sensor late, by a delay or by a filter. Each of these effects adds its
//! own sensor, cause and fingerprint.

use crate::effect::{EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;

/// A sensor whose reading at time t is the measured quantity at t − δ.
pub(crate) const DELAYED: EffectInfo = EffectInfo {
    sensor_timing: Some(Timing::Delay),
    ..LATE
};

/// A sensor whose reading is the measured quantity behind a first-order low-pass filter.
pub(crate) const LAGGING: EffectInfo = EffectInfo {
    sensor_timing: Some(Timing::Lag),
    ..LATE
};

const LATE: EffectInfo = EffectInfo {
    role: Role::Sensor,
    // A slow tachometer averages over a turn or over a frame of its bus, a camera needs a few frames.
    physical: &[PhysicalRange {
        parameter: 0,
        over: None,
        range: (0.0, 0.5),
        reason: "no sensor with which a bench is logged shows the motion half a second late",
    }],
    starts: &[&[0.0]],
    absent: Some(&[0.0]),
    drawn_since: 1,
    hiding: Some(Hiding {
        parameters: |s, _| vec![s],
        first_guess: 5e-3,
        beyond_plausible: false,
    }),
    ..EffectInfo::PLAIN
};

/// The parameter δ of a sensor's delay, in s.
pub(crate) const fn delay(name: &'static str) -> ParameterInfo {
    ParameterInfo {
        name,
        meaning: "delay δ",
        bounds: (0.0, 1.0),
        ..TIME
    }
}

/// The parameter T of a sensor's filter, in s.
pub(crate) const fn time_constant(name: &'static str) -> ParameterInfo {
    ParameterInfo {
        name,
        meaning: "time constant T",
        bounds: (0.0, 10.0),
        ..TIME
    }
}

const TIME: ParameterInfo = ParameterInfo {
    name: "",
    unit: "s",
    meaning: "",
    plausible: (2e-4, 0.1),
    bounds: (0.0, f64::INFINITY),
    is_torque: false,
    logarithmic: false,
    is_whole: false,
};

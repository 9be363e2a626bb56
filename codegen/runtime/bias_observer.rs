//! Finds a constant bias of the measured angle, which would keep the wheel turning at rest.
//!
//! If the measured angle says that the body leans but the body does not fall, the difference is the
//! bias b. With y the measured state
//! (angle, rate, wheel speed) and u the current that was sent, the observer's one state z gives
//!
//! ```text
//! b = z + l y,   z' = decay z + m y + f u
//! ```
//!
//! (a reduced-order Luenberger observer; the constants come from the design). All products have the
//! same number of fraction bits. They are summed exactly in 64 bits and rounded once.

/// Constants of the observer. With all zero the estimate is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BiasObserver {
    /// The factor that brings z to the scale of the products: a power of two, or zero.
    pub unit: i32,
    /// Decay of z on the same scale.
    pub decay: i32,
    /// The vector l: from the words of the states to the estimate.
    pub direct: [i32; 3],
    /// The vector m: from the words of the states into z.
    pub from_states: [i32; 3],
    /// The factor f: from the word of the current into z.
    pub from_current: i32,
    /// Number of bits that rounding a sum of products to z (Q30 rad) removes, 1 to 62.
    pub state_shift: u32,
    /// Number of bits that rounding a sum of products to an angle removes, 1 to 62.
    pub angle_shift: u32,
    /// Largest estimate, in words of the angle.
    pub limit: i32,
}

/// Largest z in Q30 rad.
const STATE_MAX: i64 = 0x7fff_ffff;

/// The estimated bias in words of the angle, within the limit.
#[inline]
pub fn estimated_bias(z: i32, states: [i32; 3], observer: &BiasObserver) -> i32 {
    let sum = z as i64 * observer.unit as i64 + dot(states, observer.direct);
    let half = 1i64 << (observer.angle_shift - 1);
    let bias = (sum + half) >> observer.angle_shift;
    if bias < -(observer.limit as i64) {
        -observer.limit
    } else if bias > observer.limit as i64 {
        observer.limit
    } else {
        bias as i32
    }
}

/// The next z after `current` was sent.
#[inline]
pub fn advanced(z: i32, states: [i32; 3], current: i32, observer: &BiasObserver) -> i32 {
    let sum = z as i64 * observer.decay as i64
        + dot(states, observer.from_states)
        + current as i64 * observer.from_current as i64;
    rounded_state(sum, observer)
}

/// The z whose estimate is zero at these states. The observer keeps it until the motor is driven.
#[inline]
pub fn waiting(states: [i32; 3], observer: &BiasObserver) -> i32 {
    rounded_state(-dot(states, observer.direct), observer)
}

#[inline]
fn dot(states: [i32; 3], weights: [i32; 3]) -> i64 {
    states[0] as i64 * weights[0] as i64
        + states[1] as i64 * weights[1] as i64
        + states[2] as i64 * weights[2] as i64
}

#[inline]
fn rounded_state(sum: i64, observer: &BiasObserver) -> i32 {
    let half = 1i64 << (observer.state_shift - 1);
    let z = (sum + half) >> observer.state_shift;
    if z < -STATE_MAX {
        -STATE_MAX as i32
    } else if z > STATE_MAX {
        STATE_MAX as i32
    } else {
        z as i32
    }
}

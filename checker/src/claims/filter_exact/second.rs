//! The second implementation of the filter's functions, in exact integers.
//!
//! It is written from the documentation of each function: its formats, where it rounds, where it clamps, and
//! the coefficients. Its words are wide, so nothing overflows. Arguments that the source does not
//! accept are not tried.

/// A vector of words.
pub(crate) type Words = Vec<i128>;

pub(crate) const ONE: i128 = 1 << 30;

/// 1 + 2⁻¹² in Q30.
pub(crate) const COMPONENT_MAX: i128 = ONE + (1 << 18);

/// π in Q28, to the nearest; and 2π, π/2, π/4.
pub(crate) const PI: i128 = 843_314_857;

pub(crate) const TWO_PI: i128 = 1_686_629_713;

pub(crate) const HALF_PI: i128 = 421_657_428;

pub(crate) const QUARTER_PI: i128 = 210_828_714;

/// ⌊a b/2³²⌋.
pub(crate) fn high(a: i128, b: i128) -> i128 {
    (a * b) >> 32
}

/// s/2³² to the nearest, halves upward.
pub(crate) fn nearest(sum: i128) -> i128 {
    (sum + (1 << 31)) >> 32
}

/// Largest magnitude.
pub(crate) fn largest(v: &[i128]) -> i128 {
    v.iter().map(|x| x.abs()).max().unwrap_or(0)
}

/// c₀ − x (c₁ − x c₂), x in Q29, in the formats Q30, Q30 and Q33.
pub(crate) fn quadratic(x: i128, [c0, c1, c2]: [i128; 3]) -> i128 {
    c0 - 8 * high(x, c1 - high(x, c2))
}

/// The first guess of 2³⁰/√(n/2²⁸), by octave.
pub(crate) fn root_seed(n: i128) -> i128 {
    let is_lower = n < 1 << 29;
    quadratic(
        2 * n,
        if is_lower {
            [1_696_124_550, 784_383_764, 1_268_626_640]
        } else {
            [1_199_341_171, 277_321_538, 224_263_625]
        },
    )
}

/// y + y (1 − x y²)/2, the bracket within 1/32.
pub(crate) fn root_step(x: i128, y: i128) -> i128 {
    let bracket = (1 << 27) - high(x, 4 * high(y, y));
    y + high(y, 16 * bracket.clamp(-(1 << 22), 1 << 22))
}

/// 2³⁰/√(n/2²⁸) by so many Newton steps.
pub(crate) fn inverse_root(n: i128, steps: usize) -> i128 {
    (0..steps).fold(root_seed(n), |y, _| root_step(2 * n, y))
}

/// 2³⁰/√(n/2²⁶), n clamped to [2²⁶, 2³⁰).
pub(crate) fn inverse_length(n: i128, steps: usize) -> i128 {
    let n = n.clamp(1 << 26, ONE - 1);
    if n < 1 << 28 {
        inverse_root(4 * n, steps)
    } else {
        inverse_root(n, steps) >> 1
    }
}

/// 2²⁹/(n/2³⁰): a quadratic and two Newton steps.
pub(crate) fn reciprocal(n: i128) -> i128 {
    let seed = 2 * quadratic(n, [1_138_817_242, 780_903_358, 1_388_272_791]);
    (0..2).fold(seed, |r, _| reciprocal_step(n, r))
}

/// r + r (1 − n r), the bracket within 1/16.
pub(crate) fn reciprocal_step(n: i128, r: i128) -> i128 {
    let bracket = ((1 << 27) - high(n, r)).clamp(-(1 << 23), 1 << 23);
    r + high(r, 32 * bracket)
}

/// Coefficients of t¹³, t¹¹, … of the arc tangent.
pub(crate) const ARC_TANGENT: [i128; 7] = [
    468_103_215,
    -1_154_632_763,
    1_367_924_588,
    -1_136_735_515,
    850_739_211,
    -715_485_031,
    1_073_737_649,
];

/// atan(t) in Q28, t in Q31.
pub(crate) fn arc_tangent(t: i128) -> i128 {
    let square = 2 * high(t, t);
    let [first, rest @ ..] = ARC_TANGENT;
    let sum = rest.iter().fold(first, |sum, c| c + high(square, sum));
    (high(t, sum) + 1) >> 1
}

/// Doubled, at most so many times, until a component has reached 2²⁹.
pub(crate) fn scaled(v: &[i128], most: u32) -> Words {
    let mut v = v.to_vec();
    for _ in 0..most {
        if largest(&v) < 1 << 29 {
            v.iter_mut().for_each(|x| *x *= 2);
        }
    }
    v
}

pub(crate) fn arc_tangent2(y: i128, x: i128) -> i128 {
    let v = scaled(&[x, y], 31);
    let (width, height) = (v[0].abs(), v[1].abs());
    let inverse = reciprocal(width.max(height).clamp(1 << 29, ONE));
    let ratio = high(width.min(height), inverse).clamp(0, (1 << 27) - 1);
    let octant = arc_tangent(16 * ratio);
    let quadrant = if height > width {
        HALF_PI - octant
    } else {
        octant
    };
    let half = if v[0] < 0 { PI - quadrant } else { quadrant };
    if v[1] < 0 { -half } else { half }
}

pub(crate) fn wrapped(angle: i128) -> i128 {
    if angle > PI {
        angle - TWO_PI
    } else if angle < -PI {
        angle + TWO_PI
    } else {
        angle
    }
}

/// Angle of the horizontal share of the vertical, from halves of its components, less the
/// mounting's.
pub(crate) fn pivot_angle(q: &[i128], mounting: i128) -> i128 {
    let [w, x, y, z] = four(q);
    wrapped(arc_tangent2(nearest(-(w * x + y * z)), nearest(x * z - w * y)) - mounting)
}

/// Sum of the squares, each rounded down.
pub(crate) fn squares(v: &[i128]) -> i128 {
    v.iter().map(|x| high(*x, *x)).sum()
}

/// A direction in Q28.
pub(crate) fn unit(v: &[i128]) -> Words {
    let v = scaled(v, 15);
    let inverse = inverse_length(squares(&v), 2);
    v.iter().map(|x| 2 * nearest(x * inverse)).collect()
}

pub(crate) fn up(q: &[i128]) -> [i128; 3] {
    let [w, x, y, z] = four(q);
    [
        2 * nearest(x * z - w * y),
        2 * nearest(w * x + y * z),
        (1 << 28) - 2 * nearest(x * x + y * y),
    ]
}

pub(crate) fn four(v: &[i128]) -> [i128; 4] {
    [v[0], v[1], v[2], v[3]]
}

/// Direction and gain of a correction: none below `least`.
pub(crate) fn correction(gradient: &[i128], least: i128, beta: i128) -> Words {
    if largest(gradient) < least {
        return vec![0; 5];
    }
    let mut direction = scaled(gradient, 31);
    let quarters: i128 = direction.iter().map(|x| high(*x, *x) >> 2).sum();
    let inverse = inverse_length(4 * quarters.clamp(0, (1 << 28) - 1), 1);
    direction.push(high(inverse, beta));
    direction
}

pub(crate) fn correction_imu(q: &[i128], measured: &[i128], beta: i128) -> Words {
    let up = up(q);
    let [a, b, c] = [0, 1, 2].map(|i| up[i] - measured[i]);
    let [w, x, y, z] = four(q);
    let gradient = [
        x * b - y * a,
        z * a + w * b - 2 * x * c,
        z * b - w * a - 2 * y * c,
        x * a + y * b,
    ];
    correction(&gradient.map(nearest), 1 << 8, beta)
}

/// Half of the turn about the vertical towards north, within ±`limit`.
pub(crate) fn heading_turn(q: &[i128], field: &[i128], limit: i128) -> i128 {
    let [w, x, y, z] = four(q);
    let north = [
        (1 << 28) - 2 * (high(y, y) + high(z, z)),
        2 * (high(x, y) - high(w, z)),
        2 * (high(w, y) + high(x, z)),
    ];
    let west = [
        2 * (high(x, y) + high(w, z)),
        (1 << 28) - 2 * (high(x, x) + high(z, z)),
        2 * (high(y, z) - high(w, x)),
    ];
    let along = |axis: &[i128; 3]| {
        let sum: i128 = axis.iter().zip(field).map(|(a, f)| high(*a, *f)).sum();
        64 * sum.clamp(-(1 << 24), 1 << 24)
    };
    let (to_north, to_west) = (along(&north), along(&west));
    if 2 * (high(to_north, to_north) + high(to_west, to_west)) < 1 << 21 {
        return 0;
    }
    match (to_north > 0, to_west > 0) {
        (true, _) => (2 * (-to_west).clamp(-(1 << 25), 1 << 25)).clamp(-limit, limit),
        (false, true) => -limit,
        (false, false) => limit,
    }
}

/// A turn about the vertical by twice a half-angle.
pub(crate) fn turned_about_up(q: &[i128], half_angle: i128) -> Words {
    let turn = up(q).map(|up| nearest(16 * half_angle * up));
    turned(q, &turn, &[0; 5])
}

/// q (1 − ε/2 + 3ε²/8) with ‖q‖² = 1 + ε, ε within 1/8.
pub(crate) fn normalised(q: &[i128]) -> Words {
    let squared: i128 = q.iter().map(|x| high(*x, *x) >> 1).sum();
    let excess = 16 * (squared - (1 << 27)).clamp(-(1 << 24), 1 << 24);
    let square = high(excess, excess);
    let change = square + (square >> 1) - excess;
    q.iter()
        .map(|x| (x + nearest(x * change)).clamp(-COMPONENT_MAX, COMPONENT_MAX))
        .collect()
}

pub(crate) fn turned(q: &[i128], half_angle: &[i128], correction: &[i128]) -> Words {
    let [w, x, y, z] = four(q);
    let (a, b, c) = (half_angle[0], half_angle[1], half_angle[2]);
    let turn = [
        -x * a - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    ];
    let next: Words = (0..4)
        .map(|i| q[i] + nearest(turn[i] - correction[i] * correction[4]))
        .collect();
    normalised(&next)
}

/// The shortest turn that agrees with the vertical.
pub(crate) fn aligned(measured: &[i128]) -> Words {
    let turn = [(1 << 28) + measured[2], measured[1], -measured[0]];
    if largest(&turn) < 1 << 18 {
        return vec![0, ONE, 0, 0];
    }
    let mut q: Words = unit(&turn)
        .iter()
        .map(|x| 2 * (2 * x).clamp(-(1 << 29), 1 << 29))
        .collect();
    q.push(0);
    q
}

/// matrix · (raw − bias): bias, rows, shift and half unit as they stand in the source.
pub(crate) fn calibrated(raw: &[i128], line: &[i128]) -> Words {
    let counts: Words = (0..3).map(|i| (raw[i] << 15) - line[i]).collect();
    line[3..12]
        .chunks(3)
        .map(|row| {
            let sum: i128 = row.iter().zip(&counts).map(|(m, c)| high(*m, *c)).sum();
            (sum + line[13]) >> line[12]
        })
        .collect()
}

/// The vector part of q* ⊗ direction, times the gain: what the correction says of the rate.
pub(crate) fn rate_error(q: &[i128], correction: &[i128]) -> [i128; 3] {
    let (d, gain) = ([0, 1, 2, 3].map(|k| correction[k] >> 1), correction[4]);
    [0, 1, 2].map(|axis| {
        let (i, j, k) = (1 + axis, 1 + (axis + 1) % 3, 1 + (axis + 2) % 3);
        let sum = q[0] * d[i] - q[i] * d[0] - q[j] * d[k] + q[k] * d[j];
        high(nearest(sum), gain)
    })
}

/// Whether a count is at or beyond a limit of its range.
pub(crate) fn is_saturated(raw: &[i128], clip: &[i128]) -> bool {
    raw.iter()
        .zip(clip)
        .any(|(count, limit)| count.abs() >= *limit)
}

/// The words of `FilterConstants`, in its order.
pub(crate) struct Filter {
    pub(crate) words: Words,
}

impl Filter {
    pub(crate) const GRAVITY_MIN: usize = 42;
    pub(crate) const FIELD_MIN: usize = 43;

    pub(crate) fn gyro(&self) -> &[i128] {
        &self.words[..14]
    }

    pub(crate) fn accel(&self) -> &[i128] {
        &self.words[14..28]
    }

    pub(crate) fn mag(&self) -> &[i128] {
        &self.words[28..42]
    }

    pub(crate) fn beta(&self) -> i128 {
        self.words[48]
    }

    /// Gravity in the accelerometer's units: its reading less what the body's motion adds.
    pub(crate) fn gravity(&self, accel: &[i128], rate: i128, slow: i128) -> Words {
        let mut up = calibrated(accel, self.accel());
        let lever = &self.words[44..48];
        let (squared, excess) = (nearest(rate * rate), rate - slow);
        let limit = 1 << 29;
        up[0] += ((squared * lever[0] + excess * lever[3]) >> 16).clamp(-limit, limit);
        up[1] += ((squared * lever[1] - excess * lever[2]) >> 16).clamp(-limit, limit);
        up
    }

    pub(crate) fn shows_gravity(&self, accel: &[i128], up: &[i128]) -> bool {
        !is_saturated(accel, &self.words[49..52]) && squares(up) >= self.words[Self::GRAVITY_MIN]
    }

    /// A step that takes out and follows the drift: state and drift afterwards.
    pub(crate) fn tracked(
        &self,
        state: &[i128],
        drift: &[i128],
        gyro: &[i128],
        accel: &[i128],
    ) -> Words {
        let [gain, shift, limit] = [55, 56, 57].map(|at| self.words[at]);
        let turn: Words = calibrated(gyro, self.gyro())
            .iter()
            .zip(drift)
            .map(|(turn, drift)| (turn - (drift >> shift)).clamp(-(1 << 29), 1 << 29))
            .collect();
        let up = self.gravity(accel, turn[2], state[5]);
        let q = &state[..4];
        let correction = if self.shows_gravity(accel, &up) {
            correction_imu(q, &unit(&up), self.beta())
        } else {
            vec![0; 5]
        };
        let mut next = turned(q, &turn, &correction);
        next.extend([turn[2], (state[5] >> 1) + (turn[2] >> 1)]);
        for (drift, error) in drift.iter().zip(rate_error(q, &correction)) {
            next.push((drift + ((error * gain) >> 23)).clamp(-limit, limit));
        }
        next
    }

    /// State: quaternion, rate, slow rate; the drift is not followed.
    pub(crate) fn step(&self, state: &[i128], gyro: &[i128], accel: &[i128]) -> Words {
        let turn = calibrated(gyro, self.gyro());
        let up = self.gravity(accel, turn[2], state[5]);
        let q = &state[..4];
        let correction = if self.shows_gravity(accel, &up) {
            correction_imu(q, &unit(&up), self.beta())
        } else {
            vec![0; 5]
        };
        let mut next = turned(q, &turn, &correction);
        next.extend([turn[2], (state[5] >> 1) + (turn[2] >> 1)]);
        next
    }

    /// The state after the magnetometer has turned it, by at most 2 β T.
    pub(crate) fn headed(&self, state: &[i128], mag: &[i128]) -> Words {
        let field = calibrated(mag, self.mag());
        let mut next = state.to_vec();
        if !is_saturated(mag, &self.words[52..55]) && squares(&field) >= self.words[Self::FIELD_MIN]
        {
            let half = heading_turn(&state[..4], &unit(&field), self.beta() >> 3);
            next.splice(..4, turned_about_up(&state[..4], half));
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words stand for what they are said to.
    #[test]
    fn words_stand_for_their_numbers() {
        let q28 = 2f64.powi(28);
        let pi = std::f64::consts::PI * q28;
        for (word, real) in [
            (PI, pi),
            (TWO_PI, 2.0 * pi),
            (HALF_PI, pi / 2.0),
            (QUARTER_PI, pi / 4.0),
        ] {
            assert!((word as f64 - real).abs() <= 0.5, "{word}");
        }
        for n in [1 << 28, 400_000_000, (1 << 29) - 1, 1 << 29, ONE - 1] {
            let real = 2f64.powi(30) / (n as f64 / q28).sqrt();
            assert!((inverse_root(n, 2) as f64 - real).abs() <= 8.5, "{n}");
        }
        for t in [0, 1 << 20, 1 << 30, i128::from(i32::MAX)] {
            let real = (t as f64 / 2f64.powi(31)).atan() * q28;
            assert!((arc_tangent(t) as f64 - real).abs() <= 3e-7 * q28, "{t}");
        }
        for (y, x) in [(0, -5), (7, 7), (-3, 1), (1 << 30, -(1 << 30))] {
            let real = (y as f64).atan2(x as f64) * q28;
            assert!((arc_tangent2(y, x) as f64 - real).abs() <= 4.5e-7 * q28);
        }
        assert_eq!(scaled(&[3, -1], 31), [3 << 28, -(1 << 28)]);
        assert_eq!(scaled(&[0, 0], 31), [0, 0]);
        assert_eq!(normalised(&[ONE, 0, 0, 0]), [ONE, 0, 0, 0]);
    }
}

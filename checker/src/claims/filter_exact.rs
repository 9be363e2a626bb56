//! The filter's functions a second time, in exact integers, and runs of the source against them.
//!
//! Written from the documents of each function: its formats, where it rounds, where it clamps, and
//! the coefficients. Words here are wide, so nothing overflows; an argument that the source may
//! not be given is not tried. [`crate::claims::filter_accurate`] shows that the equations are the right ones,
//! to within a tolerance; this shows that the source computes just these words, so that a damage
//! below the tolerance is noticed as well.

use crate::claims::filter_accurate::Random;
use crate::domains::machine::Machine;
use crate::language::module::Module;

/// A vector of words.
type Words = Vec<i128>;

const ONE: i128 = 1 << 30;
/// 1 + 2⁻¹² in Q30.
const COMPONENT_MAX: i128 = ONE + (1 << 18);
/// π in Q28, to the nearest; and 2π, π/2, π/4.
const PI: i128 = 843_314_857;
const TWO_PI: i128 = 1_686_629_713;
const HALF_PI: i128 = 421_657_428;
const QUARTER_PI: i128 = 210_828_714;

/// ⌊a b/2³²⌋.
fn high(a: i128, b: i128) -> i128 {
    (a * b) >> 32
}

/// s/2³² to the nearest, halves upward.
fn nearest(sum: i128) -> i128 {
    (sum + (1 << 31)) >> 32
}

/// Largest magnitude.
fn largest(v: &[i128]) -> i128 {
    v.iter().map(|x| x.abs()).max().unwrap_or(0)
}

/// c₀ − x (c₁ − x c₂), x in Q29, in the formats Q30, Q30 and Q33.
fn quadratic(x: i128, [c0, c1, c2]: [i128; 3]) -> i128 {
    c0 - 8 * high(x, c1 - high(x, c2))
}

/// The first guess of 2³⁰/√(n/2²⁸), by octave.
fn root_seed(n: i128) -> i128 {
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
fn root_step(x: i128, y: i128) -> i128 {
    let bracket = (1 << 27) - high(x, 4 * high(y, y));
    y + high(y, 16 * bracket.clamp(-(1 << 22), 1 << 22))
}

/// 2³⁰/√(n/2²⁸) by so many Newton steps.
fn inverse_root(n: i128, steps: usize) -> i128 {
    (0..steps).fold(root_seed(n), |y, _| root_step(2 * n, y))
}

/// 2³⁰/√(n/2²⁶), n clamped to [2²⁶, 2³⁰).
fn inverse_length(n: i128, steps: usize) -> i128 {
    let n = n.clamp(1 << 26, ONE - 1);
    if n < 1 << 28 {
        inverse_root(4 * n, steps)
    } else {
        inverse_root(n, steps) >> 1
    }
}

/// √n in Q30, n clamped to [2²², 2³⁰): scaled by fours into the upper two octaves.
fn square_root(n: i128) -> i128 {
    let mut n = n.clamp(1 << 22, ONE - 1);
    let mut halvings = 0;
    while n < 1 << 28 {
        n *= 4;
        halvings += 1;
    }
    let root = high(2 * n, inverse_root(n, 2)).clamp(0, 1 << 28);
    (4 * root) >> halvings
}

/// 2²⁹/(n/2³⁰): a quadratic and two Newton steps.
fn reciprocal(n: i128) -> i128 {
    let seed = 2 * quadratic(n, [1_138_817_242, 780_903_358, 1_388_272_791]);
    (0..2).fold(seed, |r, _| reciprocal_step(n, r))
}

/// r + r (1 − n r), the bracket within 1/16.
fn reciprocal_step(n: i128, r: i128) -> i128 {
    let bracket = ((1 << 27) - high(n, r)).clamp(-(1 << 23), 1 << 23);
    r + high(r, 32 * bracket)
}

/// Coefficients of t¹³, t¹¹, … of the arc tangent.
const ARC_TANGENT: [i128; 7] = [
    468_103_215,
    -1_154_632_763,
    1_367_924_588,
    -1_136_735_515,
    850_739_211,
    -715_485_031,
    1_073_737_649,
];

/// atan(t) in Q28, t in Q31.
fn arc_tangent(t: i128) -> i128 {
    let square = 2 * high(t, t);
    let [first, rest @ ..] = ARC_TANGENT;
    let sum = rest.iter().fold(first, |sum, c| c + high(square, sum));
    (high(t, sum) + 1) >> 1
}

/// Doubled, at most so many times, until a component has reached 2²⁹.
fn scaled(v: &[i128], most: u32) -> Words {
    let mut v = v.to_vec();
    for _ in 0..most {
        if largest(&v) < 1 << 29 {
            v.iter_mut().for_each(|x| *x *= 2);
        }
    }
    v
}

fn arc_tangent2(y: i128, x: i128) -> i128 {
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

fn wrapped(angle: i128) -> i128 {
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
fn pivot_angle(q: &[i128], mounting: i128) -> i128 {
    let [w, x, y, z] = four(q);
    wrapped(arc_tangent2(nearest(-(w * x + y * z)), nearest(x * z - w * y)) - mounting)
}

/// Sum of the squares, each rounded down.
fn squares(v: &[i128]) -> i128 {
    v.iter().map(|x| high(*x, *x)).sum()
}

/// A direction in Q28.
fn unit(v: &[i128]) -> Words {
    let v = scaled(v, 15);
    let inverse = inverse_length(squares(&v), 2);
    v.iter().map(|x| 2 * nearest(x * inverse)).collect()
}

fn up(q: &[i128]) -> [i128; 3] {
    let [w, x, y, z] = four(q);
    [
        2 * nearest(x * z - w * y),
        2 * nearest(w * x + y * z),
        (1 << 28) - 2 * nearest(x * x + y * y),
    ]
}

fn four(v: &[i128]) -> [i128; 4] {
    [v[0], v[1], v[2], v[3]]
}

/// Direction and gain of a correction: none below `least`.
fn correction(gradient: &[i128], least: i128, beta: i128) -> Words {
    if largest(gradient) < least {
        return vec![0; 5];
    }
    let mut direction = scaled(gradient, 31);
    let quarters: i128 = direction.iter().map(|x| high(*x, *x) >> 2).sum();
    let inverse = inverse_length(4 * quarters.clamp(0, (1 << 28) - 1), 1);
    direction.push(high(inverse, beta));
    direction
}

fn correction_imu(q: &[i128], measured: &[i128], beta: i128) -> Words {
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

fn correction_marg(q: &[i128], measured: &[i128], field: &[i128], beta: i128) -> Words {
    let [w, x, y, z] = four(q);
    let up = up(q);
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
    let (to_north, to_west, to_up) = (along(&north), along(&west), along(&up));
    let squared = 2 * (high(to_north, to_north) + high(to_west, to_west));
    if squared < 1 << 21 {
        return correction_imu(q, measured, beta);
    }
    let horizontal = square_root(2 * squared.clamp(0, (1 << 29) - 1));
    let error =
        [0, 1, 2].map(|i| high(horizontal, north[i]) + high(to_up, up[i]) - (field[i] >> 2));
    // What meets the vertical's Jacobian, and what meets that of north.
    let v = [0, 1, 2].map(|i| ((up[i] - measured[i]) >> 2) + 4 * high(to_up, error[i]));
    let n = error.map(|error| 4 * high(horizontal, error));
    let gradient = [
        high(y, n[2] - v[0]) + high(x, v[1]) - high(z, n[1]),
        high(z, v[0] + n[2]) + high(w, v[1]) - 2 * high(x, v[2]) + high(y, n[1]),
        high(w, n[2] - v[0]) + high(z, v[1]) - 2 * high(y, v[2] + n[0]) + high(x, n[1]),
        high(x, v[0] + n[2]) + high(y, v[1]) - 2 * high(z, n[0]) - high(w, n[1]),
    ];
    correction(&gradient, 1 << 6, beta)
}

/// q (1 − ε/2 + 3ε²/8) with ‖q‖² = 1 + ε, ε within 1/8.
fn normalised(q: &[i128]) -> Words {
    let squared: i128 = q.iter().map(|x| high(*x, *x) >> 1).sum();
    let excess = 16 * (squared - (1 << 27)).clamp(-(1 << 24), 1 << 24);
    let square = high(excess, excess);
    let change = square + (square >> 1) - excess;
    q.iter()
        .map(|x| (x + nearest(x * change)).clamp(-COMPONENT_MAX, COMPONENT_MAX))
        .collect()
}

fn turned(q: &[i128], half_angle: &[i128], correction: &[i128]) -> Words {
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
fn aligned(measured: &[i128]) -> Words {
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
fn calibrated(raw: &[i128], line: &[i128]) -> Words {
    let counts: Words = (0..3).map(|i| (raw[i] << 15) - line[i]).collect();
    line[3..12]
        .chunks(3)
        .map(|row| {
            let sum: i128 = row.iter().zip(&counts).map(|(m, c)| high(*m, *c)).sum();
            (sum + line[13]) >> line[12]
        })
        .collect()
}

/// The words of `FilterConstants`, in its order.
struct Filter {
    words: Words,
}

impl Filter {
    const GRAVITY_MIN: usize = 42;
    const FIELD_MIN: usize = 43;

    fn gyro(&self) -> &[i128] {
        &self.words[..14]
    }

    fn accel(&self) -> &[i128] {
        &self.words[14..28]
    }

    fn mag(&self) -> &[i128] {
        &self.words[28..42]
    }

    fn beta(&self) -> i128 {
        self.words[48]
    }

    /// Gravity in the accelerometer's units: its reading less what the body's motion adds.
    fn gravity(&self, accel: &[i128], rate: i128, slow: i128) -> Words {
        let mut up = calibrated(accel, self.accel());
        let lever = &self.words[44..48];
        let (squared, excess) = (nearest(rate * rate), rate - slow);
        let limit = 1 << 29;
        up[0] += ((squared * lever[0] + excess * lever[3]) >> 16).clamp(-limit, limit);
        up[1] += ((squared * lever[1] - excess * lever[2]) >> 16).clamp(-limit, limit);
        up
    }

    fn shows_gravity(&self, accel: &[i128], up: &[i128]) -> bool {
        !is_saturated(accel) && squares(up) >= self.words[Self::GRAVITY_MIN]
    }

    /// State: quaternion, rate, slow rate. Without a magnetometer its share is left out.
    fn step(&self, state: &[i128], gyro: &[i128], accel: &[i128], mag: Option<&[i128]>) -> Words {
        let turn = calibrated(gyro, self.gyro());
        let up = self.gravity(accel, turn[2], state[5]);
        let q = &state[..4];
        let field = mag
            .filter(|mag| !is_saturated(mag))
            .map(|mag| calibrated(mag, self.mag()))
            .filter(|field| squares(field) >= self.words[Self::FIELD_MIN]);
        let correction = match field {
            _ if !self.shows_gravity(accel, &up) => vec![0; 5],
            None => correction_imu(q, &unit(&up), self.beta()),
            Some(field) => correction_marg(q, &unit(&up), &unit(&field), self.beta()),
        };
        let mut next = turned(q, &turn, &correction);
        next.extend([turn[2], (state[5] >> 1) + (turn[2] >> 1)]);
        next
    }
}

/// Whether a count is at a limit of its range.
fn is_saturated(raw: &[i128]) -> bool {
    raw.iter().any(|count| [-32_768, 32_767].contains(count))
}

/// Random words that favour the places where pieces meet.
pub(crate) struct Draw(Random);

impl Draw {
    /// From a seed other than zero.
    pub(crate) fn new(seed: u64) -> Draw {
        Draw(Random::new(seed))
    }

    /// As [`Draw::within`], and now and then one of `corners` or a neighbour of it.
    pub(crate) fn at_corners(&mut self, low: i128, high: i128, corners: &[i128]) -> i128 {
        if corners.is_empty() || self.0.choice(3) > 0 {
            return self.within(low, high);
        }
        let corner = corners[self.0.choice(corners.len() as u64) as usize];
        (corner + self.0.choice(3) as i128 - 1).clamp(low, high)
    }

    /// A word within [low, high]: any, a small one, an end, a power of two or its neighbour.
    fn within(&mut self, low: i128, high: i128) -> i128 {
        let any = low + (self.0.unit() * (high - low + 1) as f64) as i128;
        let word = match self.0.choice(8) {
            0 => 1_i128 << self.0.choice(31),
            1 => -(1_i128 << self.0.choice(31)),
            2 => (1_i128 << self.0.choice(31)) + self.0.choice(3) as i128 - 1,
            3 => (1 - self.0.choice(3) as i128) - (1_i128 << self.0.choice(31)),
            4 => any >> self.0.choice(31),
            5 => [low, high, low + 1, high - 1][self.0.choice(4) as usize],
            _ => any,
        };
        word.clamp(low, high)
    }

    fn vector(&mut self, length: usize, limit: i128) -> Words {
        // Short vectors as well as long ones.
        let limit = if self.0.choice(3) == 0 {
            (limit >> self.0.choice(30)).max(1)
        } else {
            limit
        };
        (0..length).map(|_| self.within(-limit, limit)).collect()
    }

    /// A vector whose largest component is a power of two or a neighbour of one.
    fn at_power(&mut self, length: usize, most: u64) -> Words {
        let power = 1_i128 << self.0.choice(most);
        let mut v: Words = (0..length).map(|_| self.within(-power, power)).collect();
        let sign = 1 - 2 * self.0.choice(2) as i128;
        v[self.0.choice(length as u64) as usize] = sign * (power + self.0.choice(3) as i128 - 1);
        v
    }

    /// Any calibration of a sensor: bias, matrix, shift, half a unit.
    fn sensor_line(&mut self) -> Words {
        let mut line = self.vector(3, 1 << 28);
        line.extend(self.vector(9, 1 << 29));
        line.push(self.0.choice(17) as i128);
        line.push(self.within(0, 1 << 16));
        line
    }

    /// A vector of about this length, as every step after the first has.
    fn of_length(&mut self, length: usize, norm: f64) -> Words {
        let v: Vec<f64> = (0..length).map(|_| 2.0 * self.0.unit() - 1.0).collect();
        let own = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
        v.iter().map(|x| (x / own * norm).round() as i128).collect()
    }

    /// A quaternion: mostly near unit length, sometimes of any.
    fn quaternion(&mut self) -> Words {
        if self.0.choice(4) == 0 {
            self.vector(4, COMPONENT_MAX)
        } else {
            self.of_length(4, ONE as f64)
        }
    }

    /// What [`unit`] may give.
    fn direction(&mut self) -> Words {
        if self.0.choice(4) == 0 {
            self.vector(3, 5 << 27)
        } else {
            self.of_length(3, (1 << 28) as f64)
        }
    }
}

/// Runs every function of the filter against this file.
///
/// # Errors
/// The first arguments for which a word differs.
pub fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    constants(module)?;
    let mut draw = Draw::new(seed);
    let same = |name: &str, arguments: &[i128], wanted: &[i128]| {
        let program = module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))?;
        let mut machine = Machine::new(program);
        let found = machine
            .call(arguments)
            .map_err(|trap| format!("{name}: {trap}"))?;
        if found == wanted {
            Ok(())
        } else {
            Err(format!(
                "{name} of {arguments:?} is {found:?}, not {wanted:?}"
            ))
        }
    };
    // Where pieces of one argument can meet, in any case.
    let powers = (0..31).flat_map(|bits| [-1, 0, 1].map(|step| (1_i128 << bits) + step));
    for n in powers.filter(|n| (0..=i32::MAX.into()).contains(n)) {
        same("inverse_length", &[n], &[inverse_length(n, 2)])?;
        same("coarse_inverse_length", &[n], &[inverse_length(n, 1)])?;
        same("square_root_q30", &[n], &[square_root(n)])?;
        same("arc_tangent_q31", &[n], &[arc_tangent(n)])?;
        if (1 << 28..ONE).contains(&n) {
            same("inverse_root_q30", &[n], &[inverse_root(n, 2)])?;
            same("coarse_inverse_root_q30", &[n], &[inverse_root(n, 1)])?;
        }
        if (1 << 29..=ONE).contains(&n) {
            same("reciprocal_q29", &[n], &[reciprocal(n)])?;
        }
    }
    for _ in 0..cases {
        let n = draw.within(1 << 28, ONE - 1);
        same("seed", &[n], &[root_seed(n)])?;
        same("inverse_root_q30", &[n], &[inverse_root(n, 2)])?;
        same("coarse_inverse_root_q30", &[n], &[inverse_root(n, 1)])?;
        let y = draw.within(0, 0x4c00_0000);
        same("root::refined", &[2 * n, y], &[root_step(2 * n, y)])?;
        let n = draw.within(i32::MIN.into(), i32::MAX.into());
        same("inverse_length", &[n], &[inverse_length(n, 2)])?;
        same("coarse_inverse_length", &[n], &[inverse_length(n, 1)])?;
        same("square_root_q30", &[n], &[square_root(n)])?;

        let n = draw.within(1 << 29, ONE);
        same("reciprocal_q29", &[n], &[reciprocal(n)])?;
        let r = draw.within(-0x0c00_0000, 0x5a00_0000);
        same("arc_tangent::refined", &[n, r], &[reciprocal_step(n, r)])?;
        let t = draw.within(0, i32::MAX.into());
        same("arc_tangent_q31", &[t], &[arc_tangent(t)])?;
        let v = draw.vector(2, ONE);
        same("arc_tangent2", &v, &[arc_tangent2(v[0], v[1])])?;
        same("scaled_up2", &v, &scaled(&v, 31))?;
        let near = [PI, -PI, TWO_PI, -TWO_PI][draw.0.choice(4) as usize];
        let near = (near + draw.0.choice(5) as i128 - 2).clamp(-2 * PI, 2 * PI);
        for angle in [near, draw.within(-2 * PI, 2 * PI)] {
            same("wrapped", &[angle], &[wrapped(angle)])?;
        }
        let v = draw.vector(3, ONE);
        same("scaled_up3", &v, &scaled(&v, 15))?;
        same("length_squared", &v, &[squares(&v)])?;
        same("unit_q28", &v, &unit(&v))?;
        let v = draw.vector(4, 7 << 28);
        same("scaled_up4", &v, &scaled(&v, 31))?;
        let v = draw.at_power(2, 30);
        same("scaled_up2", &v, &scaled(&v, 31))?;
        let v = draw.at_power(3, 30);
        same("scaled_up3", &v, &scaled(&v, 15))?;
        let v = draw.at_power(4, 30);
        same("scaled_up4", &v, &scaled(&v, 31))?;

        attitude(&mut draw, &same)?;
        steps(&mut draw, module, &same)?;
        let raw = draw.vector(3, 32_767);
        let line = draw.sensor_line();
        let arguments = [&raw[..], &line].concat();
        same("calibrate", &arguments, &calibrated(&raw, &line))?;
    }
    Ok(cases)
}

fn attitude(
    draw: &mut Draw,
    same: &impl Fn(&str, &[i128], &[i128]) -> Result<(), String>,
) -> Result<(), String> {
    let (q, measured, field) = (draw.quaternion(), draw.direction(), draw.direction());
    let beta = draw.within(0, (1 << 29) - 1);
    let mounting = draw.within(-PI, PI);
    same("up_q28", &q, &up(&q))?;
    same(
        "pivot_angle",
        &[&q[..], &[mounting]].concat(),
        &[pivot_angle(&q, mounting)],
    )?;
    same(
        "correction_imu",
        &[&q[..], &measured, &[beta]].concat(),
        &correction_imu(&q, &measured, beta),
    )?;
    same(
        "correction_marg",
        &[&q[..], &measured, &field, &[beta]].concat(),
        &correction_marg(&q, &measured, &field, beta),
    )?;
    // A gradient that just stops the correction, and any other.
    let least = 1 << 8;
    let corners = [least, -least];
    let just = (0..4).map(|_| draw.at_corners(-least - 1, least + 1, &corners));
    for gradient in [just.collect(), draw.vector(4, 7 << 28)] {
        same(
            "scaled_correction",
            &[&gradient[..], &[least, beta]].concat(),
            &correction(&gradient, least, beta),
        )?;
    }
    // The level sensor in a field that just leaves the vertical, 2²⁴ of 2²⁸ to one side.
    let mut aslant = vec![0, 0, 1 << 28];
    aslant[draw.0.choice(2) as usize] = (1 << 24) + draw.0.choice(64) as i128 - 32;
    let level = [ONE, 0, 0, 0];
    same(
        "correction_marg",
        &[&level[..], &measured, &aslant, &[beta]].concat(),
        &correction_marg(&level, &measured, &aslant, beta),
    )?;
    // At rest the gradient is as small as its least value, which stops the correction.
    let at_rest: Words = up(&q)
        .iter()
        .map(|x| (x + draw.within(-400, 400)).clamp(-(5 << 27), 5 << 27))
        .collect();
    same(
        "correction_imu",
        &[&q[..], &at_rest, &[beta]].concat(),
        &correction_imu(&q, &at_rest, beta),
    )?;
    let turn = draw.vector(3, 1 << 29);
    let mut direction = draw.vector(4, 7 << 28);
    direction.push(draw.within(0, 1 << 25));
    same(
        "turned",
        &[&q[..], &turn, &direction].concat(),
        &turned(&q, &turn, &direction),
    )?;
    same("normalised", &q, &normalised(&q))?;
    same("aligned", &measured, &aligned(&measured))?;
    let mut near_down =
        [0; 3].map(|_| draw.at_corners(-0x4_0001, 0x4_0001, &[1 << 18, -(1 << 18)]));
    near_down[2] -= 1 << 28;
    same("aligned", &near_down, &aligned(&near_down))
}

/// Whole steps with the bench's constants or any calibration: any counts, each sensor saturated now and then without the
/// others, and least lengths that the readings just reach, or just miss.
fn steps(
    draw: &mut Draw,
    module: &Module,
    same: &impl Fn(&str, &[i128], &[i128]) -> Result<(), String>,
) -> Result<(), String> {
    let words = module
        .constant("constants", "FILTER")
        .filter(|words| words.len() == 49)
        .ok_or("constants::FILTER has not the 49 words of its documents")?;
    let mut filter = Filter {
        words: words.to_vec(),
    };
    // Any calibration, so that none can stand for another.
    for sensor in 0..3 {
        if draw.0.choice(2) == 0 {
            let line = draw.sensor_line();
            filter.words.splice(14 * sensor..14 * (sensor + 1), line);
        }
    }
    let mut counts = |limit: i128| {
        let mut counts: Words = (0..3).map(|_| draw.within(-limit, limit)).collect();
        if draw.0.choice(6) == 0 {
            counts[draw.0.choice(3) as usize] = [-32_768, 32_767][draw.0.choice(2) as usize];
        }
        counts
    };
    let (gyro, accel, mag) = (counts(20_000), counts(20_000), counts(3_000));
    let mut state = draw.of_length(4, ONE as f64);
    state.extend([
        draw.within(-(1 << 28), 1 << 28),
        draw.within(-(1 << 28), 1 << 28),
    ]);
    let turn = calibrated(&gyro, filter.gyro());
    let up = filter.gravity(&accel, turn[2], state[5]);
    let field = calibrated(&mag, filter.mag());
    for (at, length) in [
        (Filter::GRAVITY_MIN, squares(&up)),
        (Filter::FIELD_MIN, squares(&field)),
    ] {
        if draw.0.choice(2) == 0 {
            filter.words[at] = (length + draw.0.choice(3) as i128 - 1).clamp(1, (1 << 31) - 1);
        }
    }
    let words = &filter.words;
    same(
        "step_imu",
        &[&state[..], &gyro, &accel, words].concat(),
        &filter.step(&state, &gyro, &accel, None),
    )?;
    same(
        "step_marg",
        &[&state[..], &gyro, &accel, &mag, words].concat(),
        &filter.step(&state, &gyro, &accel, Some(&mag)),
    )?;
    let up = calibrated(&accel, filter.accel());
    let is_usable = filter.shows_gravity(&accel, &up);
    let mut next = state.clone();
    if is_usable {
        next.splice(..4, aligned(&unit(&up)));
    }
    next.push(i128::from(is_usable));
    same("align", &[&state[..], &accel, words].concat(), &next)
}

/// The named constants that stand for numbers of mathematics or bounds of a format.
fn constants(module: &Module) -> Result<(), String> {
    let known = [
        ("arc_tangent", "PI_Q28", PI),
        ("arc_tangent", "HALF_PI_Q28", HALF_PI),
        ("arc_tangent", "QUARTER_PI_Q28", QUARTER_PI),
        ("arc_tangent", "TWO_PI_Q28", TWO_PI),
        ("madgwick", "ONE", ONE),
        ("madgwick", "COMPONENT_MAX", COMPONENT_MAX),
        ("scaling", "SCALED_MIN", 1 << 29),
        ("calibration", "CALIBRATED_MAX", 1 << 29),
        ("lever_arm", "CORRECTION_MAX", 1 << 29),
        ("madgwick", "GRADIENT_MIN_IMU", 1 << 8),
        ("madgwick", "GRADIENT_MIN_MARG", 1 << 6),
        ("madgwick", "HORIZONTAL_SQUARED_MIN", 1 << 21),
    ];
    let names = ["C0", "C1", "C2", "C3", "C4", "C5", "C6"];
    let series = names.iter().zip(ARC_TANGENT.iter().rev());
    let series = series.map(|(name, wanted)| ("arc_tangent", *name, *wanted));
    for (file, name, wanted) in known.into_iter().chain(series) {
        match module.constant(file, name) {
            Some([found]) if *found == wanted => {}
            found => return Err(format!("{file}::{name} is {found:?}, not {wanted}")),
        }
    }
    Ok(())
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

//! Madgwick's equations (report of 2010, eq. 25 to 46) in double precision, written from the paper.

pub(crate) fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn unit<const N: usize>(v: [f64; N]) -> [f64; N] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// One step: q + ½ q ⊗ ω T − β T ∇/‖∇‖, normalised.
pub(crate) fn madgwick(
    q: [f64; 4],
    half: [f64; 3],
    up: Option<[f64; 3]>,
    field: Option<[f64; 3]>,
    beta_step: f64,
) -> [f64; 4] {
    let [w, x, y, z] = q;
    let [a, b, c] = half;
    let turn = [
        -x * a - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    ];
    let mut next = [0, 1, 2, 3].map(|i| q[i] + turn[i]);
    if let Some(up) = up {
        let gradient = unit(gradient(q, unit(up), field.map(unit)));
        for i in 0..4 {
            next[i] -= beta_step * gradient[i];
        }
    }
    unit(next)
}

/// Jᵀ f of the vertical and, with a field, of the field (eq. 25, 26, 29 to 34).
fn gradient(q: [f64; 4], measured_up: [f64; 3], field: Option<[f64; 3]>) -> [f64; 4] {
    let [w, x, y, z] = q;
    let up = [
        2.0 * (x * z - w * y),
        2.0 * (w * x + y * z),
        1.0 - 2.0 * (x * x + y * y),
    ];
    let up_slopes = [
        [-2.0 * y, 2.0 * z, -2.0 * w, 2.0 * x],
        [2.0 * x, 2.0 * w, 2.0 * z, 2.0 * y],
        [0.0, -4.0 * x, -4.0 * y, 0.0],
    ];
    let mut vertical = [0, 1, 2].map(|i| up[i] - measured_up[i]);
    let mut gradient = [0.0; 4];
    if let Some(field) = field {
        let north = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (w * y + x * z),
        ];
        let west = [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ];
        let north_slopes = [
            [0.0, 0.0, -4.0 * y, -4.0 * z],
            [-2.0 * z, 2.0 * y, 2.0 * x, -2.0 * w],
            [2.0 * y, 2.0 * z, 2.0 * w, 2.0 * x],
        ];
        let horizontal = dot3(north, field).hypot(dot3(west, field));
        let field_up = dot3(up, field);
        for i in 0..3 {
            let error = horizontal * north[i] + field_up * up[i] - field[i];
            vertical[i] += field_up * error;
            for j in 0..4 {
                gradient[j] += horizontal * north_slopes[i][j] * error;
            }
        }
    }
    for i in 0..3 {
        for j in 0..4 {
            gradient[j] += up_slopes[i][j] * vertical[i];
        }
    }
    gradient
}

//! Madgwick's equations in double precision, written from the papers: the report of 2010, eq. 25 to 44, and the heading
//! by itself as in his thesis of 2014.

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
        let gradient = unit(gradient(q, unit(up)));
        for i in 0..4 {
            next[i] -= beta_step * gradient[i];
        }
    }
    unit(next)
}

/// Jᵀ f of the vertical (eq. 25, 26).
fn gradient(q: [f64; 4], measured_up: [f64; 3]) -> [f64; 4] {
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
    let mut gradient = [0.0; 4];
    for i in 0..3 {
        for j in 0..4 {
            gradient[j] += up_slopes[i][j] * (up[i] - measured_up[i]);
        }
    }
    gradient
}

/// A vector of the sensor's frame in the estimated earth frame, its vertical part left out: north, west.
pub(crate) fn in_earth(q: [f64; 4], v: [f64; 3]) -> [f64; 2] {
    let [w, x, y, z] = q;
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
    [dot3(north, v), dot3(west, v)]
}

/// q turned about the earth's vertical by −h_w for a field with the parts (h_n, h_w) to north and west, by the whole
/// 2 β T where north lies behind, and by no more than that.
pub(crate) fn to_north(q: [f64; 4], field: Option<[f64; 2]>, beta_step: f64) -> [f64; 4] {
    let Some([north, west]) = field else {
        return q;
    };
    let largest = 2.0 * beta_step;
    let turn = if north > 0.0 {
        (-west).clamp(-largest, largest)
    } else {
        -largest * west.signum()
    };
    let [w, x, y, z] = q;
    let half = 0.5 * turn;
    unit([w - half * z, x - half * y, y + half * x, z + half * w])
}

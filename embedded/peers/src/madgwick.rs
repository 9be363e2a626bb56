//! The emitted filter's algorithm in floating point: Madgwick's six and nine axes, and the angle about the pivot.

/// The filter with one type of numbers, its square root and its arc tangent.
macro_rules! madgwick {
    ($name:ident, $number:ty, $sqrt:path, $atan2:path) => {
        /// Attitude as a unit quaternion w x y z.
        pub struct $name {
            q: [$number; 4],
            beta_rad_s: $number,
            sample_time_s: $number,
        }

        impl $name {
            /// At the attitude of a body that stands upright with x upwards.
            pub fn new(beta_rad_s: $number, sample_time_s: $number) -> Self {
                let half: $number = $sqrt(0.5);
                $name {
                    q: [half, 0.0, -half, 0.0],
                    beta_rad_s,
                    sample_time_s,
                }
            }

            /// One step; the field where there is one. Vectors in rad/s, and in any unit.
            pub fn step(
                &mut self,
                rate: [$number; 3],
                accel: [$number; 3],
                mag: Option<[$number; 3]>,
            ) {
                let [w, x, y, z] = self.q;
                let up = self.up();
                let mut gradient = [0.0; 4];
                if let Some(measured) = unit(accel) {
                    let mut e = [0, 1, 2].map(|k| up[k] - measured[k]);
                    let mut u = [0.0; 3];
                    if let Some(field) = mag.and_then(unit) {
                        let east = [
                            2.0 * (x * y + w * z),
                            2.0 * (0.5 - x * x - z * z),
                            2.0 * (y * z - w * x),
                        ];
                        let north = [
                            2.0 * (0.5 - y * y - z * z),
                            2.0 * (x * y - w * z),
                            2.0 * (w * y + x * z),
                        ];
                        let (n, s) = (dot(north, field), dot(east, field));
                        let (horizontal, vertical) = ($sqrt(n * n + s * s), dot(up, field));
                        let error =
                            [0, 1, 2].map(|k| horizontal * north[k] + vertical * up[k] - field[k]);
                        e = [0, 1, 2].map(|k| e[k] + vertical * error[k]);
                        u = error.map(|part| horizontal * part);
                    }
                    gradient = [
                        y * (u[2] - e[0]) + x * e[1] - z * u[1],
                        z * (e[0] + u[2]) + w * e[1] - 2.0 * x * e[2] + y * u[1],
                        w * (u[2] - e[0]) + z * e[1] - 2.0 * y * (e[2] + u[0]) + x * u[1],
                        x * (e[0] + u[2]) + y * e[1] - 2.0 * z * u[0] - w * u[1],
                    ];
                }
                let [a, b, c] = rate.map(|part| 0.5 * self.sample_time_s * part);
                let turned = [
                    w - x * a - y * b - z * c,
                    x + w * a + y * c - z * b,
                    y + w * b - x * c + z * a,
                    z + w * c + x * b - y * a,
                ];
                let size = $sqrt(gradient.iter().map(|part| part * part).sum::<$number>());
                let gain = if size > 1e-6 {
                    self.beta_rad_s * self.sample_time_s / size
                } else {
                    0.0
                };
                let next = [0, 1, 2, 3].map(|k| turned[k] - gain * gradient[k]);
                let scale = 1.0 / $sqrt(next.iter().map(|part| part * part).sum::<$number>());
                self.q = next.map(|part| part * scale);
            }

            /// Angle about the pivot, relative to upright, rad.
            pub fn angle(&self) -> $number {
                let [x, y, _] = self.up();
                $atan2(-y, x)
            }

            fn up(&self) -> [$number; 3] {
                let [w, x, y, z] = self.q;
                [
                    2.0 * (x * z - w * y),
                    2.0 * (w * x + y * z),
                    2.0 * (0.5 - x * x - y * y),
                ]
            }
        }

        fn unit(vector: [$number; 3]) -> Option<[$number; 3]> {
            let square = dot(vector, vector);
            if square == 0.0 {
                return None;
            }
            let scale = 1.0 / $sqrt(square);
            Some(vector.map(|part| part * scale))
        }

        fn dot(a: [$number; 3], b: [$number; 3]) -> $number {
            a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
        }
    };
}

/// Single precision.
pub mod single {
    madgwick!(Madgwick, f32, libm::sqrtf, libm::atan2f);
}

/// Double precision.
pub mod double {
    madgwick!(Madgwick, f64, libm::sqrt, libm::atan2);
}

//! Noise, counts, poses, and the test that stated standard errors are right.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, UnitSphere};

pub const GRAVITY: f64 = 9.81;

pub struct Noise {
    pub rng: ChaCha8Rng,
    pub normal: Normal<f64>,
}

impl Noise {
    pub fn new(seed: u64) -> Self {
        Noise {
            rng: ChaCha8Rng::seed_from_u64(seed),
            normal: Normal::new(0.0, 1.0).expect("a standard deviation of one"),
        }
    }

    pub fn one(&mut self) -> f64 {
        self.normal.sample(&mut self.rng)
    }

    pub fn three(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::new(self.one(), self.one(), self.one()) * deviation
    }

    pub fn direction(&mut self) -> Vector3<f64> {
        Vector3::from(UnitSphere.sample(&mut self.rng))
    }
}

pub fn counts(value: Vector3<f64>) -> [i16; 3] {
    let count = |x: f64| x.round().clamp(-32_768.0, 32_767.0) as i16;
    [count(value.x), count(value.y), count(value.z)]
}

/// Mean of squared standardised errors; one if the stated standard errors are right.
#[derive(Default)]
pub struct ChiSquared {
    pub sum: f64,
    pub count: f64,
    pub worst: f64,
}

impl ChiSquared {
    pub fn add(&mut self, error: f64, std: f64) {
        let z = error / std;
        self.sum += z * z;
        self.count += 1.0;
        self.worst = self.worst.max(z.abs());
    }

    /// Asserts that the mean differs from `excess` by at most five standard deviations. The mean of n independent
    /// values has the standard deviation √(2/n). Parameters of one seed are correlated, so that n = `independent` is
    /// given. `excess` is the expected mean: 1, or ν/(ν − 2) if the variance was estimated with ν degrees of freedom.
    pub fn assert_one(&self, name: &str, independent: f64, excess: f64) {
        let mean = self.sum / self.count;
        println!(
            "{name}: mean squared z {mean:.3}, worst z {:.2}",
            self.worst
        );
        let allowed = 5.0 * excess * (2.0 / independent).sqrt();
        assert!(
            (mean - excess).abs() < allowed,
            "{name}: {mean} ± {allowed}"
        );
    }
}

/// The six faces up, tilted by some degrees as by hand, then further directions.
pub fn pose_directions(count: usize, noise: &mut Noise) -> Vec<Vector3<f64>> {
    let faces = [
        Vector3::x(),
        -Vector3::x(),
        Vector3::y(),
        -Vector3::y(),
        Vector3::z(),
        -Vector3::z(),
    ];
    (0..count)
        .map(|index| match faces.get(index) {
            Some(face) => (face + noise.three(0.05)).normalize(),
            None => {
                // Edges and corners of the cube.
                let signs = [0, 1, 2].map(|bit| if index >> bit & 1 == 1 { 1.0 } else { -1.0 });
                let mut edge = Vector3::from(signs);
                if index % 2 == 0 {
                    edge[index % 3] = 0.0;
                }
                (edge + noise.three(0.05)).normalize()
            }
        })
        .collect()
}

//! Benches with random numbers, simulated by the plant, with columns that can be spoilt.

use std::f64::consts::PI;

use bench_files::{Bench, Error, FilesInMemory};
use plant::{Current, EffectId, Hold, Input, Kind, Model, Plant, State};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The numbers of a bench.
#[derive(Clone, Debug)]
pub struct Numbers {
    pub gravity_torque: f64,
    pub total_inertia: f64,
    pub wheel_inertia: f64,
    pub torque_constant: f64,
    pub dry: f64,
    pub gains: [f64; 3],
    pub seed: u64,
}

/// One log: its name, kind and columns, SI.
#[derive(Clone, Debug)]
pub struct Log {
    pub name: &'static str,
    pub kind: Kind,
    pub columns: Vec<(&'static str, Vec<f64>)>,
    pub more: String,
}

impl Log {
    pub fn column(&mut self, name: &str) -> &mut Vec<f64> {
        let mut columns = self.columns.iter_mut();
        let found = columns.find(|(column, _)| *column == name);
        &mut found.unwrap_or_else(|| panic!("no {name}")).1
    }

    /// The log as a CSV file.
    pub fn text(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| *name).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.columns[0].1.len() {
            let cells: Vec<String> = self
                .columns
                .iter()
                .map(|(_, column)| format!("{:.7}", column[row]))
                .collect();
            text.push_str(&(cells.join(",") + "\n"));
        }
        text
    }

    pub fn scale(&mut self, name: &str, factor: f64) {
        self.column(name).iter_mut().for_each(|x| *x *= factor);
    }
}

impl Numbers {
    /// A bench between half and twice the thesis' size.
    pub fn random(seed: u64) -> Numbers {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut between = |low: f64, high: f64| rng.random_range(low..high);
        let total_inertia = between(1e-3, 6e-3);
        let frequency: f64 = between(6.0, 12.0);
        let gravity_torque = total_inertia * frequency.powi(2);
        Numbers {
            gravity_torque,
            total_inertia,
            wheel_inertia: total_inertia * between(0.03, 0.12),
            torque_constant: between(0.02, 0.05),
            dry: gravity_torque * between(2e-4, 2e-3),
            gains: [0.0; 3],
            seed,
        }
        .with_gains()
    }

    fn with_gains(mut self) -> Numbers {
        let model = Model::base();
        let linear = plant::linearise(&model, &self.values(&model), PI, None).expect("upright");
        let settings = design::Settings {
            sample_time_s: 0.004,
            weights: design::Weights {
                state: [25.0, 0.5, 5e-4].into(),
                current: 1.0,
            },
            current_limit_a: 3.0,
            friction_extremes: None,
        };
        let gains = design::Design::new(&linear, &settings)
            .expect("design")
            .gains;
        self.gains = [gains[0], gains[1], gains[2]];
        self
    }

    fn values(&self, model: &Model) -> Vec<f64> {
        let value = |name: &str| match name {
            "total_inertia" => self.total_inertia,
            "wheel_inertia" => self.wheel_inertia,
            "gravity_torque" => self.gravity_torque,
            "torque_constant" => self.torque_constant,
            "body_viscous_friction" => 0.01 * self.total_inertia,
            "wheel_viscous_friction" => 0.1 * self.wheel_inertia,
            "body_coulomb_torque" => self.dry,
            other => unreachable!("no {other}"),
        };
        model
            .parameters()
            .iter()
            .map(|info| value(info.name))
            .collect()
    }

    pub fn run(
        &self,
        kind: Kind,
        start: State<f64>,
        current_a: &[f64],
        step_s: f64,
    ) -> Vec<State<f64>> {
        let model = Model::base().with(EffectId::BodyCoulombFriction);
        let plant = Plant::new(&model, &self.values(&model), kind);
        let time_s: Vec<f64> = (0..current_a.len()).map(|k| k as f64 * step_s).collect();
        let input = Input::new(&time_s, current_a, Hold::Zero);
        let mut states = vec![];
        plant.run(
            start,
            &time_s,
            0..time_s.len(),
            Current::Recorded(&input),
            None,
            |_, _, state| states.push(*state),
        );
        states
    }

    /// Two free swings, three spin-ups, a coast-down, a balance and a driven log, with noise.
    pub fn logs(&self) -> Vec<Log> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0x5eed);
        let mut noise = move |std: f64| -> f64 {
            let sample: f64 = StandardNormal.sample(&mut rng);
            std * sample
        };
        let mut logs = vec![];
        for (name, degrees) in [("swing a", 35.0_f64), ("swing b", 15.0)] {
            let start = State {
                angle_rad: degrees.to_radians(),
                ..State::rest()
            };
            let states = self.run(Kind::FreeSwing, start, &vec![0.0; 3000], 0.005);
            logs.push(Log {
                name,
                kind: Kind::FreeSwing,
                columns: vec![
                    ("time_s", (0..3000).map(|k| 0.005 * k as f64).collect()),
                    (
                        "angle_rad",
                        states.iter().map(|s| s.angle_rad + noise(1e-3)).collect(),
                    ),
                    (
                        "rate_rad_s",
                        states.iter().map(|s| s.rate_rad_s + noise(5e-3)).collect(),
                    ),
                ],
                more: String::new(),
            });
        }
        // A current that brings the wheel to some 400 rad/s.
        let unit_a = self.wheel_inertia / self.torque_constant * 100.0;
        let spin = [
            ("spin a", 0.5 * unit_a, 0.0),
            ("spin b", unit_a, 0.0),
            ("spin c", -unit_a, 0.0),
            ("coast", 0.0, 150.0),
        ];
        for (name, current_a, start) in spin {
            let start = State {
                wheel_speed_rad_s: start,
                ..State::rest()
            };
            let current = vec![current_a; 400];
            let states = self.run(Kind::SpinUp, start, &current, 0.01);
            logs.push(Log {
                name,
                kind: Kind::SpinUp,
                columns: vec![
                    ("time_s", (0..400).map(|k| 0.01 * k as f64).collect()),
                    (
                        "wheel_speed_rad_s",
                        states
                            .iter()
                            .map(|s| s.wheel_speed_rad_s + noise(0.5))
                            .collect(),
                    ),
                    ("current_A", current),
                ],
                more: String::new(),
            });
        }
        logs.push(self.balance(&mut noise));
        // Hanging, driven back and forth near its own frequency, so that it swings far.
        let frequency = (self.gravity_torque / self.total_inertia).sqrt();
        let current: Vec<f64> = (0..2000)
            .map(|k| 2.0 * unit_a * (0.93 * frequency * 0.005 * k as f64).sin().signum())
            .collect();
        let states = self.run(Kind::Driven, State::rest(), &current, 0.005);
        let seen = |value: fn(&State<f64>) -> f64| states.iter().map(value).collect::<Vec<f64>>();
        let mut driven = Log {
            name: "driven",
            kind: Kind::Driven,
            columns: vec![
                ("time_s", (0..2000).map(|k| 0.005 * k as f64).collect()),
                ("angle_rad", seen(|s| s.angle_rad)),
                ("rate_rad_s", seen(|s| s.rate_rad_s)),
                ("wheel_speed_rad_s", seen(|s| s.wheel_speed_rad_s)),
                ("current_A", current),
            ],
            more: String::new(),
        };
        for (name, std) in [
            ("angle_rad", 1e-3),
            ("rate_rad_s", 5e-3),
            ("wheel_speed_rad_s", 0.5),
        ] {
            driven
                .column(name)
                .iter_mut()
                .for_each(|x| *x += noise(std));
        }
        logs.push(driven);
        logs
    }

    /// A balance log: the law is applied to the states sample by sample, with a push now and then.
    fn balance(&self, noise: &mut impl FnMut(f64) -> f64) -> Log {
        let model = Model::base().with(EffectId::BodyCoulombFriction);
        let plant = Plant::new(&model, &self.values(&model), Kind::Balance);
        let step_s = 0.004;
        let mut state = State {
            angle_rad: PI + 0.05,
            ..State::rest()
        };
        let mut columns = vec![
            ("time_s", vec![]),
            ("angle_rad", vec![]),
            ("rate_rad_s", vec![]),
            ("wheel_speed_rad_s", vec![]),
            ("current_A", vec![]),
        ];
        for k in 0..2000 {
            let seen = [
                state.angle_rad + noise(1e-3),
                state.rate_rad_s + noise(5e-3),
                state.wheel_speed_rad_s + noise(0.5),
            ];
            let [k1, k2, k3] = self.gains;
            let current = -(k1 * (seen[0] - PI) + k2 * seen[1] + k3 * seen[2]);
            let current = current.clamp(-3.0, 3.0);
            let row = [k as f64 * step_s, seen[0], seen[1], seen[2], current];
            for ((_, column), value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
            let time_s = [0.0, step_s];
            plant.run(
                state,
                &time_s,
                0..2,
                Current::Held(current),
                None,
                |_, _, next| state = *next,
            );
            if k % 500 == 499 {
                state.rate_rad_s += 0.2;
                state.wheel_speed_rad_s -= 0.2;
            }
        }
        Log {
            name: "balance",
            kind: Kind::Balance,
            columns,
            more: String::new(),
        }
    }

    /// The bench of these logs.
    pub fn bench(&self, logs: &[Log]) -> Bench {
        self.bench_with(logs, "")
    }

    /// As [`Numbers::bench`], with more lines under `[known]`.
    pub fn bench_with(&self, logs: &[Log], known: &str) -> Bench {
        let bench = self.try_bench_with(logs, known);
        bench.unwrap_or_else(|error| panic!("seed {}: {error}", self.seed))
    }

    /// As [`Numbers::bench_with`], for logs that the reader itself may refuse.
    pub fn try_bench_with(&self, logs: &[Log], known: &str) -> Result<Bench, Error> {
        let mut files = FilesInMemory::default();
        let [k1, k2, k3] = self.gains;
        let mut toml = format!(
            "[known]\ngravity = 9.81\ngravity_torque = {}\ntorque_constant = {}\n{known}\n\n[controller]\ngains = [{k1}, \
             {k2}, {k3}]\ncurrent_limit = 3.0\nsample_time = 0.004\n",
            self.gravity_torque, self.torque_constant
        );
        for log in logs {
            let name = log.name;
            toml.push_str(&format!(
                "\n[[experiment]]\nname = \"{name}\"\nkind = \"{}\"\nfile = \"{name}.csv\"\n{}\n",
                log.kind.name(),
                log.more
            ));
            files.insert(format!("{name}.csv"), log.text());
        }
        files.insert("bench.toml", toml);
        Bench::from_files(&files)
    }
}

//! Writes every kind of figure from synthetic data, plain and ugly cases, into
//! the folder that is given (default `target/gallery`).
//!
//!     cargo run -p figures --example gallery -- FOLDER

use figures::{
    Breakdown, BreakdownPanel, Confusion, Decay, DecayPanel, DecayPoint, FigureError, Limit, Line,
    LineRole, Marker, Overlay, OverlayChannel, Panel, Plane, PoleSet, Poles, Quantity, Region,
    Reliability, ReliabilityBin, ResidualBin, Series, Sphere, Staircase, StaircaseTrace,
    SuspectBar, Suspects, TorqueCurve, TorqueCurvePoint, breakdown, confusion, decay, overlay,
    poles, reliability, series, sphere, staircase, suspects, torque_curve,
};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("target/gallery"), PathBuf::from);
    let figures = [
        ("overlay", free_swing(7_500, true)?),
        ("overlay-long", free_swing(60_000, false)?),
        ("overlay-balance", balance()?),
        ("overlay-ugly", ugly_overlay()?),
        ("staircase", few_steps()?),
        ("staircase-many", many_steps(12)?),
        ("staircase-of-30", many_steps(60)?),
        ("breakdown", breakdown_figure()),
        ("decay", decay_figure()?),
        ("suspects", suspects_figure()),
        ("suspects-none", suspects(&Suspects::default())),
        ("torque-curve", torque_curve_figure()),
        ("poles-spread", spread_poles()),
        ("poles-z", poles_figure(Plane::Discrete)),
        ("poles-s", poles_figure(Plane::Continuous)),
        ("series", transient()?),
        ("reliability", reliability_figure()),
        ("confusion", confusion_figure()?),
        ("sphere", sphere_figure()),
    ];
    std::fs::create_dir_all(&folder)?;
    for (name, svg) in figures {
        let path = folder.join(format!("{name}.svg"));
        std::fs::write(&path, &svg)?;
        println!("{:6.0} kB  {}", svg.len() as f64 / 1e3, path.display());
    }
    Ok(())
}

/// Repeatable noise with mean 0 and standard deviation 1: the sum of twelve
/// uniform numbers less six, from a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

const ANGLE: Quantity = Quantity {
    name: "angle",
    unit: "rad",
};
const TIME: Quantity = Quantity {
    name: "time",
    unit: "s",
};

fn free_swing(samples: usize, with_gap: bool) -> Result<String, FigureError> {
    let mut noise = Noise(1);
    let time_s: Vec<f64> = (0..samples)
        .map(|i| 60.0 * i as f64 / samples as f64)
        .collect();
    let model: Vec<f64> = time_s
        .iter()
        .map(|t| 0.9 * (-0.05 * t).exp() * (9.0 * t).cos())
        .collect();
    let measurement: Vec<f64> = time_s
        .iter()
        .map(|t| {
            if with_gap && (21.0..23.5).contains(t) {
                return f64::NAN;
            }
            let amplitude = (0.9 * (-0.042 * t).exp() - 0.0021 * t).max(0.0);
            amplitude * (9.0 * t + 0.01).cos() + 0.002 * noise.normal()
        })
        .collect();
    overlay(&Overlay {
        title: "Free swing 52°: the model swings on where the pendulum has stopped",
        subtitle: "Base model with viscous friction alone. Dry friction would end the swing early.",
        time_s: &time_s,
        channels: &[OverlayChannel {
            quantity: ANGLE,
            measurement: &measurement,
            model: &model,
            sensor_std: 0.002,
            note: "RMSE 22.3 mrad · fit 82.9 %",
        }],
        regions: &[Region {
            from: 5.0,
            until: 17.0,
            label: "61 % of the error",
        }],
        markers: &[],
        zoom_s: with_gap.then_some((8.0, 13.0)),
    })
}

fn balance() -> Result<String, FigureError> {
    let mut noise = Noise(2);
    let samples = 20_000;
    let pushes = [(3.2, 4.1), (7.9, -3.0), (8.4, 2.2), (15.1, 5.6)];
    let time_s: Vec<f64> = (0..samples).map(|i| f64::from(i) * 1e-3).collect();
    let answer = |t: f64, delay: f64| -> f64 {
        let reply = |&(at, size): &(f64, f64)| {
            let s: f64 = t - at - delay;
            if s < 0.0 {
                0.0
            } else {
                size * 0.01 * s * 12.0 * (-4.0 * s).exp() * (6.0 * s).cos()
            }
        };
        pushes.iter().map(reply).sum()
    };
    let mut channel = |scale: f64, std: f64| -> (Vec<f64>, Vec<f64>) {
        time_s
            .iter()
            .map(|t| {
                (
                    scale * answer(*t, 0.0) + std * noise.normal(),
                    scale * answer(*t, 0.004),
                )
            })
            .unzip()
    };
    let (angle, angle_model) = channel(1.0, 1e-3);
    let (rate, rate_model) = channel(8.0, 0.02);
    let (wheel, wheel_model) = channel(900.0, 0.4);
    let (current, current_model) = channel(20.0, 0.01);
    let data = [
        ("angle − π", "rad", &angle, &angle_model, 1e-3),
        ("rate", "rad/s", &rate, &rate_model, 0.02),
        ("wheel speed", "rad/s", &wheel, &wheel_model, 0.4),
        ("current", "A", &current, &current_model, 0.01),
    ];
    let channels = data.map(
        |(name, unit, measurement, model, sensor_std)| OverlayChannel {
            quantity: Quantity { name, unit },
            measurement,
            model,
            sensor_std,
            note: "fit 93 %",
        },
    );
    let labels = pushes.map(|(_, size)| format!("push {size:+.1} mN m s").replace('-', "−"));
    let markers: Vec<Marker> = pushes
        .iter()
        .zip(&labels)
        .map(|((at, _), label)| Marker { at: *at, label })
        .collect();
    overlay(&Overlay {
        title: "Balance: four pushes explain the largest excursions",
        subtitle: "Model over windows of 0.25 s, each from its own start.",
        time_s: &time_s,
        channels: &channels,
        markers: &markers,
        ..Overlay::default()
    })
}

fn ugly_overlay() -> Result<String, FigureError> {
    let time_s: Vec<f64> = (0..40).map(|i| 1.7e9 + f64::from(i) * 0.01).collect();
    let constant = vec![3.25; 40];
    let mut spike = vec![1e6; 40];
    spike[20] = 1e6 + 0.004;
    let mut lonely = vec![f64::NAN; 40];
    lonely[10] = 7.0;
    let empty = vec![f64::NAN; 40];
    let channel = |name, measurement, model, note| OverlayChannel {
        quantity: Quantity { name, unit: "rad" },
        measurement,
        model,
        sensor_std: f64::NAN,
        note,
    };
    overlay(&Overlay {
        title: "Ugly: <constant> & \"huge offsets\", one lone point, nothing at all, and a title \
                that is so long that it cannot possibly stand in one line of the page",
        subtitle: "Time in seconds since 1970.",
        time_s: &time_s,
        channels: &[
            channel("constant", &constant, &constant, "measurement = model"),
            channel("a huge offset with a small spike", &spike, &spike, ""),
            channel("one point", &lonely, &empty, "no model"),
            channel(
                "a_channel_with_a_very_long_name_that_somebody_gave_it_in_a_configuration_file_of_the_bench",
                &empty,
                &empty,
                "a note that is rather long as well and has to give way to the name of the channel",
            ),
        ],
        regions: &[Region {
            from: 1.7e9 + 0.1,
            until: 1.7e9 + 0.11,
            label: "a region with a label that is longer than the region by far",
        }],
        markers: &[Marker {
            at: 1.7e9 + 0.11,
            label: "a push next to it",
        }],
        zoom_s: None,
    })
}

fn few_steps() -> Result<String, FigureError> {
    let trace = |name, held_out, rmse_over_floor| StaircaseTrace {
        name,
        held_out,
        rmse_over_floor,
    };
    staircase(&Staircase {
        title: "Dry friction explains most of the error; drag brings it to the sensor's floor",
        subtitle: "Each step adds one effect and refits every parameter.",
        steps: &[
            "base model",
            "+ body-coulomb-friction",
            "+ body-quadratic-drag",
        ],
        traces: &[
            trace("free swing 20 deg/angle", false, &[22.0, 3.1, 1.02]),
            trace("free swing 52 deg/angle", false, &[31.0, 4.4, 1.08]),
            trace("free swing 35 deg/angle", true, &[25.5, 3.4, 1.05]),
            trace("spin-up 0.6 A/wheel speed", false, &[1.3, 1.3, 1.3]),
        ],
    })
}

fn many_steps(count: u32) -> Result<String, FigureError> {
    let mut noise = Noise(3);
    let names: Vec<String> = (0..count)
        .map(|i| match i % 4 {
            0 => format!("free swing {} deg/angle", 10 + 5 * i),
            1 => format!("spin-up {:.1} A/wheel speed", 0.2 * f64::from(i)),
            2 => format!("balance {i}/rate"),
            _ => format!("driven experiment with an unusually long name {i}/angle"),
        })
        .collect();
    let values: Vec<Vec<f64>> = (0..count)
        .map(|_| {
            let start = 3.0 + 300.0 * noise.uniform().powi(3);
            (0..6)
                .map(|step| 1.0 + start * 0.25f64.powi(step) * (0.5 + noise.uniform()))
                .collect()
        })
        .collect();
    let traces: Vec<StaircaseTrace> = names
        .iter()
        .zip(&values)
        .enumerate()
        .map(|(i, (name, rmse_over_floor))| StaircaseTrace {
            name,
            held_out: i % 3 == 2,
            rmse_over_floor,
        })
        .collect();
    staircase(&Staircase {
        title: &format!("{count} series fall to the floor within five steps"),
        subtitle: "",
        steps: &[
            "base model",
            "+ body-presliding-friction",
            "+ wheel-coulomb-friction",
            "+ motor-lag",
            "+ gyro-bias",
            "+ current-offset",
        ],
        traces: &traces,
    })
}

fn breakdown_figure() -> String {
    let mut noise = Noise(4);
    let coordinates = [
        ("amplitude", "rad", 0.0, 0.9),
        ("rate", "rad/s", -8.0, 8.0),
        ("angle", "rad", -0.9, 0.9),
        ("time", "s", 0.0, 60.0),
    ];
    let bins: Vec<Vec<ResidualBin>> = coordinates
        .iter()
        .map(|(_, _, from, until)| {
            let shares: Vec<f64> = (0..14).map(|_| noise.uniform().powi(4)).collect();
            let total: f64 = shares.iter().sum();
            (0..14)
                .map(|i| {
                    let edge = |k: usize| from + (until - from) * k as f64 / 14.0;
                    let middle = (edge(i) + edge(i + 1)) / 2.0;
                    ResidualBin {
                        from: edge(i),
                        until: edge(i + 1),
                        mean: if i == 11 {
                            f64::NAN
                        } else {
                            0.006 * (middle * 6.0 / (until - from)).tanh() + 8e-4 * noise.normal()
                        },
                        mean_std: 6e-4,
                        share_of_error: if i == 11 { 0.0 } else { shares[i] / total },
                    }
                })
                .collect()
        })
        .collect();
    let panels: Vec<BreakdownPanel> = coordinates
        .iter()
        .zip(&bins)
        .map(|((name, unit, _, _), bins)| BreakdownPanel {
            coordinate: Quantity { name, unit },
            residual: Quantity {
                name: "residual",
                unit: "rad",
            },
            bins,
            sensor_std: 0.002,
            note: "free swing 52 deg",
        })
        .collect();
    breakdown(&Breakdown {
        title: "The residual follows the sign of the rate: friction that does not grow with speed",
        subtitle: "Free swing 52°, angle, base model.",
        panels: &panels,
    })
}

fn decay_figure() -> Result<String, FigureError> {
    let mut noise = Noise(5);
    let model_amplitude: Vec<f64> = (1..200).map(|i| f64::from(i) * 0.0045).collect();
    let rate = |a: f64| 0.02 + 0.004 / a.max(0.02);
    let period = |a: f64| 0.698 * (1.0 - 0.03 * (-a / 0.1).exp());
    let mut points = |f: &dyn Fn(f64) -> f64, std: f64| -> Vec<DecayPoint> {
        (1..45)
            .map(|i| {
                let amplitude = 0.02 * f64::from(i);
                let std = std * (0.2 / amplitude);
                DecayPoint {
                    amplitude,
                    value: f(amplitude) + std * noise.normal(),
                    std,
                }
            })
            .collect()
    };
    let (rates, periods) = (points(&rate, 0.002), points(&period, 6e-4));
    let rate_model: Vec<f64> = model_amplitude.iter().map(|a| rate(*a)).collect();
    let period_model: Vec<f64> = model_amplitude.iter().map(|a| period(*a)).collect();
    decay(&Decay {
        title: "Small swings die faster and take less time: presliding friction",
        subtitle: "Each point is one period; the large-angle effect is removed from the period.",
        amplitude: Quantity {
            name: "amplitude",
            unit: "rad",
        },
        panels: &[
            DecayPanel {
                quantity: Quantity {
                    name: "decay rate",
                    unit: "1/s",
                },
                points: &rates,
                model_amplitude: &model_amplitude,
                model: &rate_model,
                note: "",
            },
            DecayPanel {
                quantity: Quantity {
                    name: "period",
                    unit: "s",
                },
                points: &periods,
                model_amplitude: &model_amplitude,
                model: &period_model,
                note: "drift −2.9 %",
            },
        ],
    })
}

fn suspects_figure() -> String {
    let suspect = |name, probability, evidence| SuspectBar {
        name,
        probability,
        evidence,
    };
    suspects(&Suspects {
        title: "Dry friction at the pivot is missing (93 %)",
        subtitle: "Probability of each effect given the fit and the held-out experiments.",
        suspects: &[
            suspect(
                "body-coulomb-friction",
                0.93,
                "The decay per cycle is constant, not proportional to the amplitude: dry friction.",
            ),
            suspect(
                "body-presliding-friction",
                0.052,
                "The period hardly shortens at small amplitudes, so the contact does not act as a \
                 spring; the stiffness would have to be above 4 N m/rad, which these logs cannot \
                 tell from infinite.",
            ),
            suspect("body-stribeck-friction", 0.012, ""),
            suspect("body-quadratic-drag", 0.003, ""),
            suspect("none in the library", 0.002, ""),
            suspect("body-cable-spring", 0.0, ""),
        ],
    })
}

/// A magnet that a swing passes at 0.15 rad; beyond 0.35 rad the log says little.
fn torque_curve_figure() -> String {
    let points: Vec<TorqueCurvePoint> = (0..=80)
        .map(|k| {
            let at = -0.4 + 0.01 * f64::from(k);
            let z = (at - 0.15) / 0.06;
            TorqueCurvePoint {
                at,
                value: 6e-3 * z * (-z * z).exp(),
                std: 1e-4 + 4e-3 * (at.abs() / 0.4).powi(12),
            }
        })
        .collect();
    torque_curve(&TorqueCurve {
        title: "The torque that the model lacks, over the body's angle",
        subtitle: "On the body, as it acts.",
        coordinate: Quantity {
            name: "angle",
            unit: "rad",
        },
        torque: Quantity {
            name: "missing torque",
            unit: "N m",
        },
        points: &points,
    })
}

/// Poles without a crowd: one panel.
fn spread_poles() -> String {
    poles(&Poles {
        title: "Three poles apart",
        subtitle: "",
        plane: Plane::Continuous,
        sets: &[PoleSet {
            name: "closed loop",
            role: LineRole::Model,
            poles: &[(-12.0, 6.0), (-12.0, -6.0), (-9.0, 0.0)],
            cloud: &[],
        }],
    })
}

fn poles_figure(plane: Plane) -> String {
    let mut noise = Noise(6);
    let open = vec![(8.95, 0.0), (-9.2, 0.0), (-0.02, 0.0)];
    let closed = vec![(-310.0, 0.0), (-6.1, 2.4), (-6.1, -2.4)];
    let mut cloud = |poles: &[(f64, f64)], spread: f64| -> Vec<(f64, f64)> {
        let mut cloud = Vec::new();
        for _ in 0..400 {
            let (a, b) = (spread * noise.normal(), spread * noise.normal());
            for &(re, im) in poles {
                cloud.push((re * (1.0 + a), im * (1.0 + b)));
            }
        }
        cloud
    };
    let (open_cloud, closed_cloud) = (cloud(&open, 0.02), cloud(&closed, 0.05));
    // The same poles sampled at 20 ms where the z-plane is asked for.
    let map = |poles: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let to_z = |&(re, im): &(f64, f64)| {
            let (size, angle) = ((re * 0.02f64).exp(), im * 0.02);
            (size * angle.cos(), size * angle.sin())
        };
        match plane {
            Plane::Discrete => poles.iter().map(to_z).collect(),
            Plane::Continuous => poles.to_vec(),
        }
    };
    let data = [&open, &closed, &open_cloud, &closed_cloud].map(|p| map(p));
    poles(&Poles {
        title: "The regulator moves the unstable pole inside; its uncertainty leaves a wide margin",
        subtitle: "Clouds: 400 draws of the parameters.",
        plane,
        sets: &[
            PoleSet {
                name: "open loop",
                role: LineRole::Other(0),
                poles: &data[0],
                cloud: &data[2],
            },
            PoleSet {
                name: "closed loop",
                role: LineRole::Model,
                poles: &data[1],
                cloud: &data[3],
            },
        ],
    })
}

fn transient() -> Result<String, FigureError> {
    let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
    let angle: Vec<f64> = time
        .iter()
        .map(|t| 0.1 * (-4.0 * t).exp() * (5.0 * t).cos())
        .collect();
    let current: Vec<f64> = time
        .iter()
        .map(|t| (3.1 * (-4.0 * t).exp() * (5.0 * t + 0.3).cos()).clamp(-2.0, 2.0))
        .collect();
    let speed: Vec<f64> = time
        .iter()
        .map(|t| 180.0 * t * (-2.0 * t).exp() * (2.0 * t).cos())
        .collect();
    let rounded = |values: &[f64], step: f64| -> Vec<f64> {
        values.iter().map(|v| (v / step).round() * step).collect()
    };
    let fixed = [
        rounded(&angle, 1e-3),
        rounded(&current, 0.02),
        rounded(&speed, 0.5),
    ];
    let lines = |float: &'static str, y, fixed_y| {
        [
            Line {
                name: float,
                role: LineRole::Float,
                x: &time,
                y,
            },
            Line {
                name: "fixed-point law",
                role: LineRole::FixedPoint,
                x: &time,
                y: fixed_y,
            },
        ]
    };
    let quantity = |name, unit| Quantity { name, unit };
    series(&Series {
        title: "From 5.7° the fixed-point law brings the pendulum upright as the float law does",
        subtitle: "Nonlinear closed loop; the current is at its limit for the first 90 ms.",
        x: TIME,
        panels: &[
            Panel {
                quantity: quantity("angle − π", "rad"),
                lines: &lines("float law", &angle, &fixed[0]),
                limits: &[],
                note: "largest difference 0.5 mrad",
            },
            Panel {
                quantity: quantity("current", "A"),
                lines: &lines("float law", &current, &fixed[1]),
                limits: &[
                    Limit {
                        value: 2.0,
                        name: "2 A",
                    },
                    Limit {
                        value: -2.0,
                        name: "−2 A",
                    },
                ],
                note: "",
            },
            Panel {
                quantity: quantity("wheel speed", "rad/s"),
                lines: &lines("float law", &speed, &fixed[2]),
                limits: &[Limit {
                    value: 400.0,
                    name: "speed limit 400 rad/s",
                }],
                note: "",
            },
        ],
        regions: &[],
        region_name: "",
        markers: &[Marker {
            at: 0.09,
            label: "leaves the limit",
        }],
        zoom: None,
    })
}

fn reliability_figure() -> String {
    let bins: Vec<ReliabilityBin> = (0..10)
        .map(|i| {
            let stated = 0.05 + 0.1 * f64::from(i);
            let frequency: f64 = (stated + 0.04 * (f64::from(i) * 1.7).sin()).clamp(0.0, 1.0);
            let count = 30 + 40 * (i as usize).abs_diff(4).pow(2);
            let half = 1.96 * (frequency * (1.0 - frequency) / count as f64).sqrt();
            ReliabilityBin {
                stated,
                frequency,
                low: (frequency - half).max(0.0),
                high: (frequency + half).min(1.0),
                count,
            }
        })
        .collect();
    reliability(&Reliability {
        title: "Stated probabilities come true within five points",
        subtitle: "2,000 simulated benches.",
        bins: &bins,
        tolerance: 0.05,
    })
}

fn confusion_figure() -> Result<String, FigureError> {
    let mut noise = Noise(7);
    let truths = [
        "nothing missing",
        "body-coulomb-friction",
        "body-stribeck-friction",
        "body-presliding-friction",
        "body-quadratic-drag",
        "body-cable-spring",
        "body-softening-spring",
        "angle-offset",
        "gyro-bias",
        "gyro-scale",
        "wheel-coulomb-friction",
        "wheel-quadratic-drag",
        "wheel-cogging",
        "motor-saturation",
        "motor-lag",
        "motor-dead-zone",
        "current-offset",
        "input-delay",
        "back-emf-limit",
        "unknown",
    ];
    let answers = [&truths[..], &["ambiguous"]].concat();
    let mut counts = Vec::new();
    for row in 0..truths.len() {
        for column in 0..answers.len() {
            let chance = noise.uniform();
            counts.push(if row == column {
                85 + (15.0 * chance) as usize
            } else if chance > 0.95 || (column == 20 && chance > 0.5) {
                1 + (6.0 * noise.uniform()) as usize
            } else {
                0
            });
        }
    }
    confusion(&Confusion {
        title: "The right effect is named first in 95 % of the benches",
        subtitle: "Exam of 2,000 benches; trace at least three times the noise.",
        truths: &truths,
        answers: &answers,
        counts: &counts,
    })
}

fn sphere_figure() -> String {
    let mut noise = Noise(8);
    let mut before = Vec::new();
    let mut after = Vec::new();
    for _ in 0..4000 {
        let v = [noise.normal(), noise.normal(), noise.normal()];
        let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unit = v.map(|x| x / size);
        let [x, y, z] = unit;
        before.push([
            180.0 + 420.0 * x + 60.0 * y + 5.0 * noise.normal(),
            -90.0 + 350.0 * y + 5.0 * noise.normal(),
            60.0 + 300.0 * z - 40.0 * x + 5.0 * noise.normal(),
        ]);
        after.push(unit.map(|x| 48.6 * x + 0.6 * noise.normal()));
    }
    sphere(&Sphere {
        title: "After calibration the magnetometer's readings lie on a sphere around zero",
        subtitle: "Offset, scale and skew removed; spread of the field strength 1.2 %.",
        before: &before,
        before_unit: "counts",
        after: &after,
        after_unit: "µT",
        radius: 48.6,
    })
}

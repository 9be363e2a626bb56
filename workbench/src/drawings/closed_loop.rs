//! Figures of the closed loop: runs, attitude filters, and the validity of the linear model.

use figures::{Line, LineRole, Panel, Quantity};
use simulate::{LoggedLoop, LoopTrace};

use crate::closed_loop::{FilterRun, LinearRangeReport, LoopRun, SimulationReport};
use crate::error::Error;
use crate::measured_linearity::{MeasuredSwings, PERIODS, SpinUpLinearity};
use crate::numbers::{percent, significant, with_prefix};
use crate::output_file::{OutputFile, file_name};

/// Columns of a table, with their names.
type Columns<'a> = Vec<(String, &'a [f64])>;

/// Both models compared with the log of one experiment.
struct ModelsOverLog<'a> {
    time_s: &'a [f64],
    /// Linear model, measurement, nonlinear model.
    series: [Vec<f64>; 3],
    /// The text beside the panel.
    note: String,
}

impl SimulationReport {
    /// Every run as a figure and as a table of its samples.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn files(&self) -> Result<Vec<OutputFile>, Error> {
        let mut files = Vec::new();
        for run in &self.runs {
            let name = format!("simulate-{}", run.scenario);
            files.push(OutputFile::svg(&name, self.run_figure(run)?));
            files.push(OutputFile::csv(&name, &run.emitted.columns()));
        }
        let raw = self.raw_counts.trace.columns();
        files.push(OutputFile::csv("simulate-raw-counts", &raw));
        if let Some(filters) = &self.filters {
            let svg = self.filter_figure(filters)?;
            files.push(OutputFile::svg("simulate-attitude-filters", svg));
        }
        files.extend(self.linear_files(&self.linear_model)?);
        if let Some(swings) = &self.measured_swings {
            let svg = self.swings_figure(swings)?;
            files.push(OutputFile::svg("simulate-measured-free-swings", svg));
            for swing in &swings.swings {
                let Some(over) = &swing.curves else { continue };
                let columns = [
                    ("time_s", &over.time_s[..]),
                    ("measured_angle_rad", &over.measured_rad),
                    ("nonlinear_angle_rad", &over.whole_rad),
                    ("linear_angle_rad", &over.linear_rad),
                ];
                files.push(OutputFile::csv(&over_name(&swing.experiment), &columns));
            }
        }
        if !self.measured_spin_ups.is_empty() {
            let svg = self.spin_ups_figure()?;
            files.push(OutputFile::svg("simulate-measured-spin-ups", svg));
            for spin_up in &self.measured_spin_ups {
                let Some(over) = &spin_up.curves else {
                    continue;
                };
                let columns = [
                    ("time_s", &over.time_s[..]),
                    ("measured_wheel_speed_rad_s", &over.measured_rad_s),
                    ("nonlinear_wheel_speed_rad_s", &over.whole_rad_s),
                    ("linear_wheel_speed_rad_s", &over.linear_rad_s),
                ];
                files.push(OutputFile::csv(&over_name(&spin_up.experiment), &columns));
            }
        }
        for overlay in &self.overlays {
            let Some(found) = &overlay.found else {
                continue;
            };
            let name = over_name(&overlay.experiment);
            let svg = self.overlay_figure(&overlay.experiment, found)?;
            files.push(OutputFile::svg(&name, svg));
            let mut columns: Columns = vec![("time_s".to_owned(), &found.time_s)];
            for channel in &found.channels {
                columns.push((format!("measured_{}", channel.name), &channel.measured));
                columns.push((format!("simulated_{}", channel.name), &channel.simulated));
            }
            files.push(OutputFile::csv(&name, &columns));
        }
        Ok(OutputFile::distinct(files))
    }

    fn run_figure(&self, run: &LoopRun) -> Result<String, Error> {
        let (exact, emitted) = (&run.exact, &run.emitted);
        let angles = [exact, emitted].map(|trace: &LoopTrace| degrees(&trace.angle_rad));
        let lines = |exact_y, emitted_y| {
            [
                Line {
                    name: "law in floating point",
                    role: LineRole::Float,
                    x: &exact.time_s,
                    y: exact_y,
                },
                Line {
                    name: "emitted fixed-point law",
                    role: LineRole::FixedPoint,
                    x: &emitted.time_s,
                    y: emitted_y,
                },
            ]
        };
        let angle: [Line; 2] = lines(&angles[0], &angles[1]);
        let wheel: [Line; 2] = lines(&exact.wheel_speed_rad_s, &emitted.wheel_speed_rad_s);
        let current: [Line; 2] = lines(&exact.current_a, &emitted.current_a);
        let pushes = run.pushes.iter();
        let labels: Vec<String> = pushes
            .map(|(_, impulse)| with_prefix(*impulse, "N m s"))
            .collect();
        let markers: Vec<figures::Marker> = run
            .pushes
            .iter()
            .zip(&labels)
            .map(|((at, _), label)| figures::Marker { at: *at, label })
            .collect();
        let limit = self.current_limit_a;
        let limits = [limit, -limit].map(|value| figures::Limit {
            value,
            name: "limit",
        });
        Ok(figures::series(&figures::Series {
            title: &format!("{}: {}", self.model, run.about),
            subtitle: "Nonlinear bench with all effects of its model, sensor noise and steps",
            x: TIME,
            panels: &[
                panel("angle from upright", "°", &angle, &[], ""),
                panel("wheel speed", "rad/s", &wheel, &[], ""),
                panel("current", "A", &current, &limits, ""),
            ],
            markers: &markers,
            ..Default::default()
        })?)
    }

    fn filter_figure(&self, filters: &FilterRun) -> Result<String, Error> {
        let FilterRun { lever_arm_m, found } = filters;
        let estimates: Vec<(&str, LineRole, Vec<f64>, Vec<f64>)> = found
            .estimates()
            .into_iter()
            .enumerate()
            .map(|(index, (name, angle))| {
                let errors = angle.iter().zip(&found.truth_rad);
                let errors = errors.map(|(angle, truth)| (angle - truth).to_degrees());
                (
                    name,
                    LineRole::Other(index),
                    degrees(angle),
                    errors.collect(),
                )
            })
            .collect();
        let line = |name, role, y| Line {
            name,
            role,
            x: &found.time_s,
            y,
        };
        let truth = degrees(&found.truth_rad);
        let mut angles = vec![line("truth", LineRole::Measurement, &truth[..])];
        let mut errors = Vec::new();
        // The error of the accelerometer alone is so large that its curve would hide the others; it is given as text.
        for (name, role, angle, error) in estimates.iter().skip(1) {
            angles.push(line(name, *role, angle));
            errors.push(line(name, *role, error));
        }
        Ok(figures::series(&figures::Series {
            title: &format!("{}: methods for the angle", self.model),
            subtitle: &format!(
                "One simulated free swing, the same raw counts for all; sensor {} mm off the pivot, \
                 for which Madgwick's filter corrects",
                significant(1e3 * lever_arm_m[0].hypot(lever_arm_m[1]), 3)
            ),
            x: TIME,
            panels: &[
                panel("angle from hanging", "°", &angles, &[], ""),
                panel("error", "°", &errors, &[], ""),
            ],
            ..Default::default()
        })?)
    }

    /// The validity of the linear model: one figure, three tables.
    fn linear_files(&self, linear: &LinearRangeReport) -> Result<Vec<OutputFile>, Error> {
        let ([small, large], Some(spin_up)) = (&linear.swings[..], &linear.spin_up) else {
            return Ok(Vec::new());
        };
        let series =
            [small, large].map(|swing| (degrees(&swing.whole_rad), degrees(&swing.linear_rad)));
        let lines = |time_s, whole, linear| {
            [
                Line {
                    name: "nonlinear model",
                    role: LineRole::Model,
                    x: time_s,
                    y: whole,
                },
                Line {
                    name: "linear model",
                    role: LineRole::Other(0),
                    x: time_s,
                    y: linear,
                },
            ]
        };
        let from_small: [Line; 2] = lines(&small.time_s, &series[0].0, &series[0].1);
        let from_large: [Line; 2] = lines(&large.time_s, &series[1].0, &series[1].1);
        let speeds: [Line; 2] = lines(&spin_up.time_s, &spin_up.whole_rad_s, &spin_up.linear_rad_s);
        let svg = figures::series(&figures::Series {
            title: &format!("{}: where the linear model is no longer valid", self.model),
            subtitle: "Free swings from 20° and 60°, and a spin-up with the body clamped",
            x: TIME,
            panels: &[
                panel("angle from 20°", "°", &from_small, &[], ""),
                panel("angle from 60°", "°", &from_large, &[], ""),
                panel("wheel speed", "rad/s", &speeds, &[], ""),
            ],
            ..Default::default()
        })?;
        let mut files = vec![OutputFile::svg("simulate-linear-model", svg)];
        for (name, swing) in [("20deg", small), ("60deg", large)] {
            let columns = [
                ("time_s", &swing.time_s[..]),
                ("nonlinear_angle_rad", &swing.whole_rad),
                ("linear_angle_rad", &swing.linear_rad),
            ];
            files.push(OutputFile::csv(
                &format!("simulate-free-swing-{name}"),
                &columns,
            ));
        }
        let columns = [
            ("time_s", &spin_up.time_s[..]),
            ("nonlinear_wheel_speed_rad_s", &spin_up.whole_rad_s),
            ("linear_wheel_speed_rad_s", &spin_up.linear_rad_s),
        ];
        files.push(OutputFile::csv("simulate-spin-up", &columns));
        Ok(files)
    }

    /// Measurement, nonlinear and linear model, one panel per swing.
    fn swings_figure(&self, found: &MeasuredSwings) -> Result<String, Error> {
        let swings = found.swings.iter().filter_map(|swing| {
            let over = swing.curves.as_ref()?;
            let series = [&over.linear_rad, &over.measured_rad, &over.whole_rad];
            let note = off_by(&swing.experiment, swing.nonlinear_error, swing.linear_error);
            Some(ModelsOverLog {
                time_s: &over.time_s,
                series: series.map(|angle| degrees(angle)),
                note,
            })
        });
        let swings: Vec<ModelsOverLog> = swings.collect();
        self.models_over_measurement(
            &format!(
                "{}: where the linear model deviates from the measured swing",
                self.model
            ),
            &format!("First {PERIODS} periods; {}", found.range_sentence()),
            ("angle", "°"),
            &swings,
        )
    }

    /// Measurement, nonlinear and linear model, one panel per spin-up.
    fn spin_ups_figure(&self) -> Result<String, Error> {
        let spin_ups = self.measured_spin_ups.iter().filter_map(|spin_up| {
            let SpinUpLinearity {
                experiment,
                nonlinear_error,
                linear_error,
                curves,
                ..
            } = spin_up;
            let over = curves.as_ref()?;
            let series = [&over.linear_rad_s, &over.measured_rad_s, &over.whole_rad_s];
            let note = off_by(experiment, *nonlinear_error, *linear_error);
            Some(ModelsOverLog {
                time_s: &over.time_s,
                series: series.map(Clone::clone),
                note,
            })
        });
        let spin_ups: Vec<ModelsOverLog> = spin_ups.collect();
        self.models_over_measurement(
            &format!(
                "{}: where the linear model deviates from the measured spin-up",
                self.model
            ),
            "Body clamped; RMS error of each model, relative to the largest speed",
            ("wheel speed", "rad/s"),
            &spin_ups,
        )
    }

    /// One panel per experiment.
    fn models_over_measurement(
        &self,
        title: &str,
        subtitle: &str,
        (name, unit): (&str, &str),
        experiments: &[ModelsOverLog],
    ) -> Result<String, Error> {
        let lines: Vec<[Line; 3]> = experiments
            .iter()
            .map(|experiment| {
                let [linear, measured, whole] = &experiment.series;
                let line = |name, role, y| Line {
                    name,
                    role,
                    x: experiment.time_s,
                    y,
                };
                [
                    line("linear model", LineRole::Other(0), linear),
                    line("measurement", LineRole::Measurement, measured),
                    line("nonlinear model", LineRole::Model, whole),
                ]
            })
            .collect();
        let panels: Vec<Panel> = lines
            .iter()
            .zip(experiments)
            .map(|(lines, experiment)| panel(name, unit, lines, &[], &experiment.note))
            .collect();
        Ok(figures::series(&figures::Series {
            title,
            subtitle,
            x: TIME,
            panels: &panels,
            ..Default::default()
        })?)
    }

    fn overlay_figure(&self, experiment: &str, found: &LoggedLoop) -> Result<String, Error> {
        let quantity = |name: &str| match name {
            "angle" => ("angle from upright", "rad"),
            "rate" => ("rate", "rad/s"),
            "wheel_speed" => ("wheel speed", "rad/s"),
            _ => ("current", "A"),
        };
        let lines: Vec<[Line; 2]> = found
            .channels
            .iter()
            .map(|channel| {
                let line = |name, role, y| Line {
                    name,
                    role,
                    x: &found.time_s,
                    y,
                };
                [
                    line("measurement", LineRole::Measurement, &channel.measured[..]),
                    line("simulation", LineRole::Model, &channel.simulated),
                ]
            })
            .collect();
        let panels: Vec<Panel> = found
            .channels
            .iter()
            .zip(&lines)
            .map(|(channel, lines)| {
                let (name, unit) = quantity(channel.name);
                panel(name, unit, lines, &[], "")
            })
            .collect();
        Ok(figures::series(&figures::Series {
            title: &format!(
                "{}: simulated loop over the log \"{experiment}\"",
                self.model
            ),
            subtitle: "The noise differs, so compare size and shape, not single samples",
            x: TIME,
            panels: &panels,
            ..Default::default()
        })?)
    }
}

/// The horizontal axis of all panels.
const TIME: Quantity = Quantity {
    name: "time",
    unit: "s",
};

fn panel<'a>(
    name: &'a str,
    unit: &'a str,
    lines: &'a [Line<'a>],
    limits: &'a [figures::Limit<'a>],
    note: &'a str,
) -> Panel<'a> {
    Panel {
        quantity: Quantity { name, unit },
        lines,
        limits,
        note,
    }
}

fn degrees(radians: &[f64]) -> Vec<f64> {
    radians.iter().map(|angle| angle.to_degrees()).collect()
}

fn off_by(experiment: &str, nonlinear: f64, linear: f64) -> String {
    format!(
        "{experiment}: RMS error {} (nonlinear), {} (linear)",
        percent(nonlinear),
        percent(linear)
    )
}

fn over_name(experiment: &str) -> String {
    format!("simulate-over-{}", file_name(experiment))
}

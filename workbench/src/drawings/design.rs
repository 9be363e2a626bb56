//! Figures of a design: the poles with their uncertainty, and the angles from which the wheel recovers.

use figures::{Line, LineRole, Panel, Plane, PoleSet, Quantity};

use crate::design_report::{DesignReport, WheelSize};
use crate::error::Error;
use crate::numbers::significant;
use crate::output_file::OutputFile;

impl DesignReport {
    /// The poles without and with the controller, and the angles from which wheels of three sizes recover.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn drawings(&self) -> Result<Vec<OutputFile>, Error> {
        Ok(vec![
            OutputFile::svg("poles", self.pole_figure()),
            OutputFile::svg("wheel-sizing", self.sizing_figure()?),
        ])
    }

    fn pole_figure(&self) -> String {
        let points = |poles: &[[f64; 2]]| -> Vec<(f64, f64)> {
            poles.iter().map(|&[re, im]| (re, im)).collect()
        };
        let open = points(&self.open_loop_poles);
        let closed = points(&self.closed_loop_poles_per_s);
        let uncertainty = self.pole_uncertainty.as_ref();
        let clouds = uncertainty.map_or_else(Default::default, |found| {
            [
                points(&found.open_loop_cloud),
                points(&found.closed_loop_cloud),
            ]
        });
        let subtitle = match uncertainty {
            Some(found) => format!(
                "{} of {} parameter sets within their standard errors are stable",
                found.stable(),
                found.drawn
            ),
            None => "The model states no standard errors".to_owned(),
        };
        figures::poles(&figures::Poles {
            title: &format!("{}: poles without and with the controller", self.model),
            subtitle: &subtitle,
            plane: Plane::Continuous,
            sets: &[
                PoleSet {
                    name: "open loop",
                    role: LineRole::Residual,
                    poles: &open,
                    cloud: &clouds[0],
                },
                PoleSet {
                    name: "closed loop",
                    role: LineRole::Model,
                    poles: &closed,
                    cloud: &clouds[1],
                },
            ],
        })
    }

    /// Largest recoverable angle against the wheel's top speed, for three wheels (thesis, figure 2.2).
    fn sizing_figure(&self) -> Result<String, Error> {
        let wheels: Vec<&[WheelSize]> = self
            .wheel_curves
            .chunk_by(|a, b| a.wheel_factor == b.wheel_factor)
            .collect();
        let names: Vec<String> = wheels
            .iter()
            .map(|wheel| format!("wheel of {} kg m2", significant(wheel[0].wheel_inertia, 3)))
            .collect();
        let roles = [LineRole::Other(0), LineRole::Model, LineRole::Other(1)];
        let column = |value: &dyn Fn(&WheelSize) -> f64| -> Vec<Vec<f64>> {
            let wheels = wheels.iter();
            wheels
                .map(|wheel| wheel.iter().map(value).collect())
                .collect()
        };
        let speeds = column(&|size| size.wheel_speed_rad_s);
        let angles = column(&|size| size.recoverable_angle_rad.to_degrees());
        let recovered = column(&|size| size.recovered_energy_j);
        let energies = column(&|size| size.wheel_energy_j);
        let angle_lines = lines(&names, &roles, &speeds, &angles);
        let recovered_lines = lines(&names, &roles, &speeds, &recovered);
        let energy_lines = lines(&names, &roles, &speeds, &energies);
        Ok(figures::series(&figures::Series {
            title: &format!("{}: angles from which the wheel recovers", self.model),
            subtitle: "Largest angle at rest from which the body comes up, by the wheel's top speed",
            x: Quantity {
                name: "top speed of the wheel",
                unit: "rad/s",
            },
            panels: &[
                Panel {
                    quantity: Quantity {
                        name: "recoverable angle",
                        unit: "°",
                    },
                    lines: &angle_lines,
                    limits: &[figures::Limit {
                        value: self.recovery_angle_rad.to_degrees(),
                        name: "current limit",
                    }],
                    note: "",
                },
                Panel {
                    quantity: Quantity {
                        name: "energy to recover",
                        unit: "J",
                    },
                    lines: &recovered_lines,
                    limits: &[],
                    note: "energy that the body lacks at that angle",
                },
                Panel {
                    quantity: Quantity {
                        name: "energy in the wheel",
                        unit: "J",
                    },
                    lines: &energy_lines,
                    limits: &[],
                    note: "",
                },
            ],
            ..Default::default()
        })?)
    }
}

fn lines<'a>(
    names: &'a [String],
    roles: &[LineRole],
    x: &'a [Vec<f64>],
    series: &'a [Vec<f64>],
) -> Vec<Line<'a>> {
    names
        .iter()
        .zip(roles)
        .zip(x.iter().zip(series))
        .map(|((name, &role), (x, y))| Line { name, role, x, y })
        .collect()
}

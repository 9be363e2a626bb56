//! Figures of one loop, or of several side by side: responses with bands, Bode, Nyquist, sweeps.

use design::{Band, BandedResponse, LinearResponse};
use figures::{
    Banded, BandedLine, BandedPanel, Limit, LineRole, NyquistCurve, Plane, PoleSet, Quantity,
};

use crate::design_report::DesignReport;
use crate::design_sweep::{DesignSweep, SweepPoint};
use crate::error::Error;
use crate::loop_expectations::{LoopExpectations, TorqueAnswer};
use crate::numbers::{significant, with_prefix};
use crate::output_file::OutputFile;

/// A design with its name in legends.
#[derive(Clone, Copy, Debug)]
pub struct NamedLoop<'a> {
    /// The name.
    pub name: &'a str,
    /// The design.
    pub report: &'a DesignReport,
    /// The properties of its loop.
    pub expectations: &'a LoopExpectations,
}

/// The colours of designs side by side.
const ROLES: [LineRole; 6] = [
    LineRole::Model,
    LineRole::Residual,
    LineRole::FixedPoint,
    LineRole::Float,
    LineRole::Other(0),
    LineRole::Other(1),
];

/// The responses to a step and to a push, the Bode and the Nyquist plot and, for several loops, their poles. File names
/// begin with `prefix`.
///
/// # Errors
/// [`Error::Figure`].
pub fn loop_drawings(prefix: &str, loops: &[NamedLoop]) -> Result<Vec<OutputFile>, Error> {
    let role = |index: usize| ROLES[index % ROLES.len()];
    let name = |what: &str| format!("{prefix}{what}");
    let title = |what: &str| match loops {
        [one] => format!("{}: {what}", one.name),
        _ => {
            let mut all = what.chars();
            all.next().map_or(String::new(), |first| {
                first.to_uppercase().collect::<String>() + all.as_str()
            })
        }
    };
    let mut files = Vec::new();
    let steps: Vec<_> = answers(loops, |found| found.step.as_ref());
    let pushes: Vec<_> = answers(loops, |found| found.push.as_ref());
    if let Some((_, one, _)) = steps.first() {
        let size = format!(
            "A torque of {} on the body, from time zero on",
            with_prefix(one.size, &one.unit)
        );
        let text = answer_figure(&title("a constant torque"), &size, &steps)?;
        files.push(OutputFile::svg(&name("step-response"), text));
    }
    if let Some((_, one, _)) = pushes.first() {
        let size = format!(
            "A push of {} on the body at time zero",
            with_prefix(one.size, &one.unit)
        );
        files.push(OutputFile::svg(
            &name("push-response"),
            answer_figure(&title("a push"), &size, &pushes)?,
        ));
    }
    files.push(OutputFile::svg(
        &name("bode"),
        bode(&title("the open loop over frequency (Bode)"), loops)?,
    ));
    let curves: Vec<(Vec<f64>, Vec<f64>)> = loops
        .iter()
        .map(|one| {
            let frequencies = one.expectations.frequencies.iter();
            frequencies.map(|at| (at.value.re, at.value.im)).unzip()
        })
        .collect();
    let curves: Vec<NyquistCurve> = loops
        .iter()
        .zip(&curves)
        .enumerate()
        .map(|(index, (one, (re, im)))| NyquistCurve {
            name: one.name,
            role: role(index),
            re,
            im,
            modulus_margin: one
                .expectations
                .margins
                .map_or(f64::NAN, |margins| margins.modulus_margin),
        })
        .collect();
    let text = figures::nyquist(&figures::Nyquist {
        title: &title("the open loop and the point −1 (Nyquist)"),
        subtitle: "Stable where the whole curve goes around −1 once, counter-clockwise: the pendulum has one unstable pole",
        curves: &curves,
    })?;
    files.push(OutputFile::svg(&name("nyquist"), text));
    if loops.len() > 1 {
        files.push(OutputFile::svg(&name("poles"), poles(loops)));
    }
    Ok(files)
}

/// Name, response and colour of the designs whose response is known.
fn answers<'a>(
    loops: &[NamedLoop<'a>],
    part: impl Fn(&'a LoopExpectations) -> Option<&'a TorqueAnswer>,
) -> Vec<(&'a str, &'a TorqueAnswer, LineRole)> {
    let all = loops.iter().enumerate();
    all.filter_map(|(index, one)| {
        Some((
            one.name,
            part(one.expectations)?,
            ROLES[index % ROLES.len()],
        ))
    })
    .collect()
}

fn answer_figure(
    title: &str,
    subtitle: &str,
    answers: &[(&str, &TorqueAnswer, LineRole)],
) -> Result<String, Error> {
    type Part = (
        &'static str,
        &'static str,
        fn(&LinearResponse) -> &Vec<f64>,
        fn(&BandedResponse) -> &Band,
    );
    let parts: [Part; 3] = [
        ("angle", "rad", |one| &one.angle_rad, |one| &one.angle_band),
        (
            "wheel speed",
            "rad/s",
            |one| &one.wheel_speed_rad_s,
            |one| &one.wheel_speed_band,
        ),
        (
            "current",
            "A",
            |one| &one.current_a,
            |one| &one.current_band,
        ),
    ];
    let lines = parts.map(|(_, _, line, band)| {
        let all = answers.iter();
        all.map(|(name, answer, role)| BandedLine {
            name,
            role: *role,
            x: &answer.curves.nominal.time_s,
            y: line(&answer.curves.nominal),
            band: (&band(&answer.curves).low, &band(&answer.curves).high),
        })
        .collect::<Vec<_>>()
    });
    let panels: Vec<BandedPanel> = parts
        .iter()
        .zip(&lines)
        .map(|((name, unit, _, _), lines)| BandedPanel {
            quantity: Quantity { name, unit },
            lines,
            ..Default::default()
        })
        .collect();
    Ok(figures::banded(&Banded {
        title,
        subtitle,
        x: Quantity {
            name: "time",
            unit: "s",
        },
        x_in_decades: false,
        band_name: "95 % of the parameter sets within their errors",
        panels: &panels,
    })?)
}

fn bode(title: &str, loops: &[NamedLoop]) -> Result<String, Error> {
    struct Curve {
        frequency: Vec<f64>,
        size: Vec<f64>,
        phase: Vec<f64>,
    }
    let curves: Vec<Curve> = loops
        .iter()
        .map(|one| {
            let at = one.expectations.frequencies.iter();
            Curve {
                frequency: at.clone().map(|at| at.frequency_rad_s).collect(),
                size: at.clone().map(|at| at.value.norm()).collect(),
                phase: at.map(|at| at.phase_rad.to_degrees()).collect(),
            }
        })
        .collect();
    let line = |part: fn(&Curve) -> &Vec<f64>| -> Vec<BandedLine> {
        let all = loops.iter().zip(&curves).enumerate();
        all.map(|(index, (one, curve))| BandedLine {
            name: one.name,
            role: ROLES[index % ROLES.len()],
            x: &curve.frequency,
            y: part(curve),
            band: (&[], &[]),
        })
        .collect()
    };
    let (sizes, phases) = (line(|curve| &curve.size), line(|curve| &curve.phase));
    let said: Vec<String> = loops
        .iter()
        .map(|one| margins_said(one, loops.len() > 1))
        .collect();
    Ok(figures::banded(&Banded {
        title,
        subtitle: &said.join("; "),
        x: Quantity {
            name: "frequency",
            unit: "rad/s",
        },
        x_in_decades: true,
        band_name: "",
        panels: &[
            BandedPanel {
                quantity: Quantity {
                    name: "size of the open loop",
                    unit: "",
                },
                in_decades: true,
                lines: &sizes,
                limits: &[Limit {
                    value: 1.0,
                    name: "1",
                }],
            },
            BandedPanel {
                quantity: Quantity {
                    name: "phase",
                    unit: "°",
                },
                in_decades: false,
                lines: &phases,
                limits: &[Limit {
                    value: -180.0,
                    name: "−180°",
                }],
            },
        ],
    })?)
}

/// The margins of a loop in words.
fn margins_said(one: &NamedLoop, with_name: bool) -> String {
    let name = if with_name {
        format!("{}: ", one.name)
    } else {
        String::new()
    };
    let Some(margins) = &one.expectations.margins else {
        return format!(
            "{name}unstable with a delay of {}",
            with_prefix(one.expectations.delay_s, "s")
        );
    };
    let upper = match margins.largest_gain_factor {
        factor if factor.is_finite() => format!("to {}", significant(factor, 3)),
        _ => "upwards".to_owned(),
    };
    format!(
        "{name}gain factor {} {upper}, phase margin {}°, {} of further delay",
        significant(margins.least_gain_factor, 3),
        significant(margins.phase_margin_rad.to_degrees(), 3),
        with_prefix(margins.delay_margin_s, "s"),
    )
}

fn poles(loops: &[NamedLoop]) -> String {
    let points = |poles: &[[f64; 2]]| -> Vec<(f64, f64)> {
        poles.iter().map(|&[re, im]| (re, im)).collect()
    };
    let all: Vec<_> = loops
        .iter()
        .map(|one| {
            let cloud = one.report.pole_uncertainty.as_ref();
            let cloud = cloud.map_or_else(Vec::new, |found| points(&found.closed_loop_cloud));
            (points(&one.report.closed_loop_poles_per_s), cloud)
        })
        .collect();
    let sets: Vec<PoleSet> = loops
        .iter()
        .zip(&all)
        .enumerate()
        .map(|(index, (one, (poles, cloud)))| PoleSet {
            name: one.name,
            role: ROLES[index % ROLES.len()],
            poles,
            cloud,
        })
        .collect();
    figures::poles(&figures::Poles {
        title: "Poles of the closed loops",
        subtitle: "",
        plane: Plane::Continuous,
        sets: &sets,
    })
}

impl DesignSweep {
    /// The sweep as a figure.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn drawing(&self, model: &str) -> Result<OutputFile, Error> {
        let x: Vec<f64> = self.rows.iter().map(|row| row.value).collect();
        type Part = (&'static str, &'static str, fn(&SweepPoint) -> f64);
        let parts: [Part; 5] = [
            ("phase margin", "°", |point| {
                point.phase_margin_rad.to_degrees()
            }),
            ("further delay that the loop tolerates", "s", |point| {
                point.delay_margin_s
            }),
            ("slowest pole, −real part", "1/s", |point| {
                -point.slowest_pole_per_s
            }),
            ("largest angle under a torque", "rad", |point| {
                point.step_angle_rad
            }),
            ("noise in the current", "A", |point| point.noise_current_a),
        ];
        let columns = parts.map(|(_, _, part)| -> Vec<f64> {
            let rows = self.rows.iter();
            rows.map(|row| row.point.as_ref().map_or(f64::NAN, part))
                .collect()
        });
        let lines: Vec<[BandedLine; 1]> = columns
            .iter()
            .map(|y| {
                [BandedLine {
                    name: "",
                    role: LineRole::Model,
                    x: &x,
                    y,
                    band: (&[], &[]),
                }]
            })
            .collect();
        let panels: Vec<BandedPanel> = parts
            .iter()
            .zip(&lines)
            .map(|((name, unit, _), lines)| BandedPanel {
                quantity: Quantity { name, unit },
                lines,
                ..Default::default()
            })
            .collect();
        let spoken = self.swept.spoken();
        let none = self.rows.iter().filter(|row| row.point.is_none()).count();
        let subtitle = match none {
            0 => String::new(),
            1 => "One value gives no stable loop: a gap".to_owned(),
            _ => format!("{none} values give no stable loop: gaps"),
        };
        let text = figures::banded(&Banded {
            title: &format!("{model}: the design over the {spoken}"),
            subtitle: &subtitle,
            x: Quantity {
                name: &spoken,
                unit: self.swept.unit(),
            },
            x_in_decades: self.rows.iter().all(|row| row.value > 0.0),
            band_name: "",
            panels: &panels,
        })?;
        Ok(OutputFile::svg(
            &format!("sweep-{}", self.swept.name()),
            text,
        ))
    }
}

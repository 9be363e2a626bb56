//! Poles of the open and the closed loop with their uncertainty.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Text};

/// The plane in which the poles lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Plane {
    /// z-plane: stable within the unit circle.
    #[default]
    Discrete,
    /// s-plane, in 1/s: stable left of the imaginary axis.
    Continuous,
}

/// A figure of poles.
#[derive(Debug, Clone, Copy, Default)]
pub struct Poles<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// z-plane or s-plane.
    pub plane: Plane,
    /// The sets of poles, such as open and closed loop.
    pub sets: &'a [PoleSet<'a>],
}

/// The poles of one loop.
#[derive(Debug, Clone, Copy)]
pub struct PoleSet<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Gives the colour.
    pub role: LineRole,
    /// Poles as (real, imaginary) part.
    pub poles: &'a [(f64, f64)],
    /// Poles for parameters drawn from their uncertainty; may be empty.
    pub cloud: &'a [(f64, f64)],
}

/// Space for the labels of the vertical axis, in pixels. It is chosen before the labels are known, and has room for
/// "0.9985" and "−1200".
const GUTTER: f64 = 62.0;
/// A single panel has the width of the page, but not its height.
const LARGEST_HEIGHT: f64 = 440.0;

/// Draws all poles on the left and the crowded part, enlarged, on the right:
/// around z = 1 or around the slow poles.
pub fn poles(figure: &Poles) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys = Vec::new();
    for set in figure.sets {
        let color = set.role.color();
        keys.push(Key::new(Mark::Cross { color }, set.name));
    }
    if let Some(set) = figure.sets.iter().find(|set| !set.cloud.is_empty()) {
        let color = set.role.pale();
        let name = "pale dots: poles for parameters within their uncertainty";
        keys.push(Key::new(Mark::Dot { color }, name));
    }
    let stability = match figure.plane {
        Plane::Discrete => "unstable: outside the unit circle",
        Plane::Continuous => "unstable: right of the imaginary axis",
    };
    let color = style::REGION;
    keys.push(Key::new(Mark::Patch { color }, stability));
    page.legend(&keys);

    let all: Vec<(f64, f64)> = figure
        .sets
        .iter()
        .flat_map(|set| set.poles.iter().chain(set.cloud))
        .copied()
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .collect();
    let poles: Vec<(f64, f64)> = figure
        .sets
        .iter()
        .flat_map(|set| set.poles)
        .copied()
        .collect();
    let crowd = crowded(&all, figure.plane).filter(|crowd| are_several(&poles, crowd));
    let full = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN;
    let panels = 1 + usize::from(crowd.is_some());
    let width = if panels == 2 {
        (full - 24.0) / 2.0
    } else {
        full
    };
    let height = (width - GUTTER).min(LARGEST_HEIGHT);
    let top = page.y + frame::CAPTION;
    let left = style::PAGE_MARGIN;
    let place = (left, top, width, height);
    let bottom = panel(&mut page, figure, &all, "all poles", place);
    if let Some(crowd) = crowd {
        let left = left + width + 24.0;
        let name = match figure.plane {
            Plane::Discrete => "the poles near 1, enlarged",
            Plane::Continuous => "the slow poles, enlarged",
        };
        let place = (left, top, width, height);
        zoom_panel(&mut page, figure, &crowd, name, place);
    }
    page.y = bottom + 38.0;
    page.finish()
}

/// The poles that overlap in a panel of all poles: those nearer to the point of the constant state (z = 1, s = 0) than
/// the largest gap in distance. Empty if the poles are well spread.
fn crowded(all: &[(f64, f64)], plane: Plane) -> Option<Vec<(f64, f64)>> {
    let (center, whole) = match plane {
        Plane::Discrete => (1.0, 2.0),
        Plane::Continuous => (0.0, 0.0),
    };
    let distance = |p: &(f64, f64)| (p.0 - center).hypot(p.1);
    let mut distances: Vec<f64> = all.iter().map(distance).collect();
    distances.sort_by(f64::total_cmp);
    let largest = *distances.last()?;
    // In the z-plane the panel shows the whole circle, however close the
    // farthest pole is.
    if largest < whole / 4.0 {
        return Some(all.to_vec());
    }
    let small = largest * 1e-2;
    let gap = distances
        .windows(2)
        .rev()
        .find(|w| w[1].max(small) > 2.5 * w[0].max(small))?;
    let near = all.iter().filter(|p| distance(p) <= gap[0]);
    (gap[0] > 0.0).then(|| near.copied().collect())
}

/// Whether the crowd contains poles that can be told apart. Enlarging a single pole would show nothing.
fn are_several(poles: &[(f64, f64)], crowd: &[(f64, f64)]) -> bool {
    let near: Vec<(f64, f64)> = poles
        .iter()
        .filter(|p| crowd.contains(p))
        .copied()
        .collect();
    let Some(&first) = near.first() else {
        return false;
    };
    let size = near.iter().map(|p| p.0.hypot(p.1)).fold(0.0, f64::max);
    near.iter()
        .any(|p| (p.0 - first.0).hypot(p.1 - first.1) > 1e-3 * size)
}

fn panel(
    page: &mut Page,
    figure: &Poles,
    all: &[(f64, f64)],
    name: &str,
    place: (f64, f64, f64, f64),
) -> f64 {
    let points = match figure.plane {
        // The whole circle, and whatever lies outside it.
        Plane::Discrete => [all, &[(-1.1, -1.1), (1.1, 1.1)]].concat(),
        Plane::Continuous => [all, &[(0.0, 0.0)]].concat(),
    };
    zoom_panel(page, figure, &points, name, place)
}

/// Draws a panel that shows at least `points` at (left, top, width, height); returns its lower end.
fn zoom_panel(
    page: &mut Page,
    figure: &Poles,
    points: &[(f64, f64)],
    name: &str,
    (left, top, width, height): (f64, f64, f64, f64),
) -> f64 {
    let gutter = GUTTER;
    let plot_width = width - gutter;
    let (x, y) = axes(figure.plane, points, plot_width, height);
    let frame = Frame {
        left: left + gutter,
        top,
        width: plot_width,
        height,
        x,
        y,
    };
    background(page, figure.plane, &frame);
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    boundary(page, figure.plane, &frame);
    frame.begin_clip(&mut page.svg);
    for set in figure.sets {
        let cloud = set.cloud.iter().copied();
        page.svg.begin_series("cloud", set.name);
        frame.dots(&mut page.svg, cloud, 2.6, set.role.pale());
        page.svg.end();
    }
    for set in figure.sets {
        page.svg.begin_series(set.role.class(), set.name);
        for pole in set.poles {
            if let Some(at) = frame.at(pole.0, pole.1) {
                let path = page::cross(at, 5.0);
                page.svg.path(&path, Stroke::solid("#FFFFFF", 4.4));
                page.svg.path(&path, Stroke::solid(set.role.color(), 2.0));
            }
        }
        page.svg.end();
    }
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    frame.x_labels(&mut page.svg);
    let unit = match figure.plane {
        Plane::Discrete => "",
        Plane::Continuous => "1/s",
    };
    let imaginary = Quantity {
        name: "imaginary part",
        unit,
    };
    let real = Quantity {
        name: "real part",
        unit,
    };
    let taken = frame.y_caption(&mut page.svg, left, imaginary);
    let room = frame.right() - left - taken - 12.0;
    page::right_note(
        &mut page.svg,
        frame.right(),
        top - frame::CAPTION_GAP,
        room,
        name,
    );
    frame.x_caption(&mut page.svg, real);
    frame.bottom()
}

/// Scales are equal in the z-plane, so that the circle is round. In the s-plane each axis takes the range of its data.
fn axes(plane: Plane, points: &[(f64, f64)], width: f64, height: f64) -> (Axis, Axis) {
    let real = extent(points.iter().map(|p| p.0)).unwrap_or((-1.0, 1.0));
    let imaginary = extent(points.iter().map(|p| p.1)).unwrap_or((-1.0, 1.0));
    let reach = imaginary.0.abs().max(imaginary.1.abs());
    let (real, reach) = match plane {
        Plane::Discrete => {
            let half = ((real.1 - real.0) / 2.0 * (height / width))
                .max(reach)
                .max(1e-6)
                * 1.12;
            let middle = (real.0 + real.1) / 2.0;
            let wide = half * width / height;
            ((middle - wide, middle + wide), half)
        }
        Plane::Continuous => {
            let span = (real.1 - real.0).max(reach).max(1e-6);
            let reach = (reach * 1.25).max(0.1 * span);
            ((real.0 - 0.12 * span, real.1 + 0.12 * span), reach)
        }
    };
    let x = Axis::linear(Some(real), 0.0, frame::x_ticks(width));
    let y = Axis::linear(Some((-reach, reach)), 0.0, frame::y_ticks(height));
    (x, y)
}

/// Colours the unstable part of the plane.
fn background(page: &mut Page, plane: Plane, frame: &Frame) {
    match plane {
        Plane::Discrete => {
            let (left, top) = (frame.left, frame.top);
            page.svg
                .rect(left, top, frame.width, frame.height, style::REGION);
            page.svg.begin_clip(left, top, frame.width, frame.height);
            let circle = unit_circle(frame);
            page.svg.area(&circle, "#FFFFFF");
            page.svg.end();
        }
        Plane::Continuous => {
            frame.stripe(&mut page.svg, 0.0, frame.x.hi.max(0.0), style::REGION);
        }
    }
}

fn boundary(page: &mut Page, plane: Plane, frame: &Frame) {
    let stroke = Stroke::solid(style::AXIS, 1.2);
    let (left, top) = (frame.left, frame.top);
    page.svg.begin_clip(left, top, frame.width, frame.height);
    match plane {
        Plane::Discrete => page.svg.path(&unit_circle(frame), stroke),
        Plane::Continuous => {
            if let Some(x) = frame.at_x(0.0) {
                page.svg.line((x, frame.top), (x, frame.bottom()), stroke);
            }
        }
    }
    page.svg.end();
    if let (Plane::Discrete, Some((x, y))) = (plane, frame.at(0.0, -1.0)) {
        let inside = (frame.left + 40.0..frame.right() - 40.0).contains(&x) && y < frame.bottom();
        if inside {
            let at = Text::new(x, y - 6.0, style::NOTE_SIZE, style::TEXT_MUTED);
            page.svg.text(at.anchor(Anchor::Middle), "unit circle");
        }
    }
}

/// The unit circle in pixels: coarse where it is off the panel, fine within.
fn unit_circle(frame: &Frame) -> Path {
    let mut path = Path::default();
    // The more the panel is enlarged, the finer the steps that a part of the circle needs: chord and arc differ by at
    // most a tenth of a pixel.
    let radius = frame.width / (frame.x.hi - frame.x.lo);
    let step = (0.8 / radius).sqrt().clamp(1e-3, 0.05);
    let corners = (std::f64::consts::TAU / step).ceil();
    let mut first = true;
    for i in 0..corners as usize {
        let angle = i as f64 / corners * std::f64::consts::TAU;
        if let Some((x, y)) = frame.at(angle.cos(), angle.sin()) {
            if first {
                path.move_to(x, y);
                first = false;
            } else {
                path.line_to(x, y);
            }
        }
    }
    path.close();
    path
}

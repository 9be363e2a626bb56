//! The SVG writer: escaped text, compact numbers, nothing else.

use crate::style;
use std::fmt::Write as _;

/// Horizontal anchor of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A piece of text and how it is set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Text<'a> {
    pub x: f64,
    /// Baseline.
    pub y: f64,
    pub size: f64,
    pub anchor: Anchor,
    pub color: &'a str,
    pub bold: bool,
    pub angle_deg: f64,
}

impl<'a> Text<'a> {
    pub fn new(x: f64, y: f64, size: f64, color: &'a str) -> Self {
        Text {
            x,
            y,
            size,
            anchor: Anchor::Start,
            color,
            bold: false,
            angle_deg: 0.0,
        }
    }

    pub fn anchor(self, anchor: Anchor) -> Self {
        Text { anchor, ..self }
    }

    pub fn bold(self) -> Self {
        Text { bold: true, ..self }
    }

    pub fn angle_deg(self, angle_deg: f64) -> Self {
        Text { angle_deg, ..self }
    }
}

/// The stroke of a line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke<'a> {
    pub color: &'a str,
    pub width: f64,
    /// `stroke-dasharray`, empty for a solid line.
    pub dash: &'a str,
}

impl<'a> Stroke<'a> {
    pub fn solid(color: &'a str, width: f64) -> Self {
        Stroke {
            color,
            width,
            dash: "",
        }
    }

    pub fn dashed(color: &'a str, width: f64) -> Self {
        Stroke {
            color,
            width,
            dash: "5 4",
        }
    }
}

/// A document under construction; its size is given at the end.
#[derive(Debug, Default)]
pub(crate) struct Svg {
    body: String,
    clips: usize,
}

impl Svg {
    pub fn rect(&mut self, x: f64, y: f64, width: f64, height: f64, fill: &str) {
        let _ = writeln!(
            self.body,
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{fill}"/>"#,
            number(x),
            number(y),
            number(width.max(0.0)),
            number(height.max(0.0)),
        );
    }

    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        let mut path = Path::default();
        path.move_to(from.0, from.1);
        path.line_to(to.0, to.1);
        self.path(&path, stroke);
    }

    pub fn path(&mut self, path: &Path, stroke: Stroke) {
        if path.data.is_empty() {
            return;
        }
        let _ = write!(
            self.body,
            r#"<path d="{}" fill="none" stroke="{}" stroke-width="{}""#,
            path.data,
            stroke.color,
            number(stroke.width),
        );
        if !stroke.dash.is_empty() {
            let _ = write!(self.body, r#" stroke-dasharray="{}""#, stroke.dash);
        }
        self.body.push_str("/>\n");
    }

    /// The filled inside of a closed path.
    pub fn area(&mut self, path: &Path, fill: &str) {
        if !path.data.is_empty() {
            let _ = writeln!(self.body, r#"<path d="{}" fill="{fill}"/>"#, path.data);
        }
    }

    pub fn circle(&mut self, center: (f64, f64), radius: f64, fill: &str, stroke: Stroke) {
        let _ = writeln!(
            self.body,
            r#"<circle cx="{}" cy="{}" r="{}" fill="{fill}" stroke="{}" stroke-width="{}"/>"#,
            number(center.0),
            number(center.1),
            number(radius),
            stroke.color,
            number(stroke.width),
        );
    }

    pub fn text(&mut self, style: Text, content: &str) {
        if content.is_empty() {
            return;
        }
        let (x, y) = (number(style.x), number(style.y));
        let _ = write!(
            self.body,
            r#"<text x="{x}" y="{y}" font-size="{}" fill="{}""#,
            number(style.size),
            style.color
        );
        match style.anchor {
            Anchor::Start => {}
            Anchor::Middle => self.body.push_str(r#" text-anchor="middle""#),
            Anchor::End => self.body.push_str(r#" text-anchor="end""#),
        }
        if style.bold {
            self.body.push_str(r#" font-weight="bold""#);
        }
        if style.angle_deg != 0.0 {
            let _ = write!(
                self.body,
                r#" transform="rotate({} {x} {y})""#,
                number(style.angle_deg)
            );
        }
        self.body.push('>');
        self.body.push_str(&escape(content));
        self.body.push_str("</text>\n");
    }

    /// Everything until [`Svg::end`] is cut off at this rectangle.
    pub fn begin_clip(&mut self, x: f64, y: f64, width: f64, height: f64) {
        self.clips += 1;
        let id = self.clips;
        let _ = writeln!(
            self.body,
            r#"<clipPath id="clip{id}"><rect x="{}" y="{}" width="{}" height="{}"/></clipPath><g clip-path="url(#clip{id})">"#,
            number(x),
            number(y),
            number(width.max(0.0)),
            number(height.max(0.0)),
        );
    }

    /// Everything until [`Svg::end`] belongs to one named series; browsers
    /// show the name where the pointer rests.
    pub fn begin_series(&mut self, class: &str, name: &str) {
        let name = escape(name);
        let _ = writeln!(
            self.body,
            r#"<g class="{class}" data-series="{name}" stroke-linecap="round" stroke-linejoin="round"><title>{name}</title>"#,
        );
    }

    /// Closes the group that was begun last.
    pub fn end(&mut self) {
        self.body.push_str("</g>\n");
    }

    pub fn finish(self, width: f64, height: f64, title: &str) -> String {
        let (width, height, title) = (number(width), number(height), escape(title));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{}\">\n\
             <title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n{}</svg>\n",
            style::FONT,
            self.body
        )
    }
}

/// Path data with relative commands in tenths of a pixel.
#[derive(Debug, Default)]
pub(crate) struct Path {
    data: String,
    at: (i64, i64),
    /// Whether a drawing command follows the last move.
    drawn: bool,
}

impl Path {
    /// Moves without drawing. A point to which nothing is drawn still shows
    /// as a dot under a round line cap.
    pub fn move_to(&mut self, x: f64, y: f64) {
        self.close_dot();
        let to = (tenths(x), tenths(y));
        let relative = if self.data.is_empty() {
            to
        } else {
            (to.0 - self.at.0, to.1 - self.at.1)
        };
        self.data.push(if self.data.is_empty() { 'M' } else { 'm' });
        self.pair(relative);
        self.at = to;
        self.drawn = false;
    }

    pub fn line_to(&mut self, x: f64, y: f64) {
        let to = (tenths(x), tenths(y));
        let relative = (to.0 - self.at.0, to.1 - self.at.1);
        if relative == (0, 0) {
            return;
        }
        self.data.push('l');
        self.pair(relative);
        self.at = to;
        self.drawn = true;
    }

    /// Ends a run of points; draws the dot of a run of one point.
    pub fn close_dot(&mut self) {
        if !self.data.is_empty() && !self.drawn {
            self.data.push_str("h0");
            self.drawn = true;
        }
    }

    /// Closes the outline, if there is one.
    pub fn close(&mut self) {
        if !self.data.is_empty() {
            self.data.push('z');
            self.drawn = true;
        }
    }

    fn pair(&mut self, (x, y): (i64, i64)) {
        push_tenths(&mut self.data, x);
        if y >= 0 {
            self.data.push(' ');
        }
        push_tenths(&mut self.data, y);
    }
}

/// Far outside any page, yet small enough for every SVG reader.
const COORDINATE_LIMIT: f64 = 30_000.0;

fn tenths(value: f64) -> i64 {
    debug_assert!(!value.is_nan(), "NaN is filtered before drawing");
    (value.clamp(-COORDINATE_LIMIT, COORDINATE_LIMIT) * 10.0).round() as i64
}

fn push_tenths(out: &mut String, tenths: i64) {
    if tenths < 0 {
        out.push('-');
    }
    let (whole, part) = (tenths.abs() / 10, tenths.abs() % 10);
    if whole != 0 || part == 0 {
        let _ = write!(out, "{whole}");
    }
    if part != 0 {
        let _ = write!(out, ".{part}");
    }
}

fn number(value: f64) -> String {
    let mut out = String::new();
    push_tenths(&mut out, tenths(value));
    out
}

/// Escapes what XML gives a meaning to and drops characters that XML 1.0
/// does not allow at all.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(' '),
            c if c < ' ' || c == '\u{FFFE}' || c == '\u{FFFF}' => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_compact() {
        for (value, text) in [
            (0.0, "0"),
            (-0.04, "0"),
            (0.5, ".5"),
            (-12.34, "-12.3"),
            (7.0, "7"),
            (f64::INFINITY, "30000"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn relative_steps_do_not_drift() {
        let mut path = Path::default();
        path.move_to(0.0, 0.0);
        for i in 1..=10_000 {
            path.line_to(f64::from(i) * 0.033, 1.0);
        }
        let sum: f64 = path
            .data
            .split('l')
            .skip(1)
            .map(|step| {
                step.split([' ', '-'])
                    .next()
                    .unwrap()
                    .parse::<f64>()
                    .unwrap()
            })
            .sum();
        assert!((sum - 330.0).abs() < 0.051, "{sum}");
    }

    #[test]
    fn text_is_escaped_and_forbidden_characters_are_dropped() {
        assert_eq!(
            escape("a<b> & \"c\"\u{1}\u{0}\n\u{FFFF}d"),
            "a&lt;b&gt; &amp; &quot;c&quot; d"
        );
    }

    #[test]
    fn a_lone_point_is_a_dot() {
        let mut path = Path::default();
        path.move_to(1.0, 2.0);
        path.move_to(3.0, 4.0);
        path.close_dot();
        assert_eq!(path.data, "M1 2h0m2 2h0");
    }
}

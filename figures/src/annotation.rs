//! Annotations of axes and panels: names with units, regions, markers, limits.

/// A name with its unit, for axes and captions.
///
/// SI units take a prefix where the numbers are small ("mrad" for "rad");
/// others are preceded by a power of ten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Quantity<'a> {
    /// The quantity that is plotted, such as "angle".
    pub name: &'a str,
    /// Its unit, such as "rad"; empty for a pure number.
    pub unit: &'a str,
}

/// A stretch of the horizontal axis to shade, such as where a model fails.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Region<'a> {
    /// Beginning, in the unit of the axis.
    pub from: f64,
    /// End, in the unit of the axis.
    pub until: f64,
    /// Short label, such as "41 % of the error"; may be empty.
    pub label: &'a str,
}

/// An instant that is marked in all panels, such as a push.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Marker<'a> {
    /// Its position, in the unit of the axis.
    pub at: f64,
    /// Short label, such as "3.1 mN m s"; may be empty.
    pub label: &'a str,
}

/// A value that must not be passed, drawn as a dashed line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limit<'a> {
    /// The value, in the unit of the panel.
    pub value: f64,
    /// Short label, such as "2 A".
    pub name: &'a str,
}

//! The samples of a log.

use crate::channel::Channel;

/// The samples of one experiment in SI units. All vectors have the length of `time_s`; a lost sample
/// is NaN in its channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time of each sample, s, strictly increasing; the zero is that of the file.
    pub time_s: Vec<f64>,
    /// Body angle α, rad, 0 hanging, as measured.
    pub angle_rad: Option<Vec<f64>>,
    /// Body rate α̇, rad/s, as measured.
    pub rate_rad_s: Option<Vec<f64>>,
    /// Wheel speed φ̇ relative to the body, rad/s, as measured.
    pub wheel_speed_rad_s: Option<Vec<f64>>,
    /// Wheel angle φ relative to the body, rad, unwrapped, as measured.
    pub wheel_angle_rad: Option<Vec<f64>>,
    /// Motor current, A: the command, or the measured current (see
    /// [`CurrentMeaning`](crate::CurrentMeaning)). Never NaN.
    pub current_a: Option<Vec<f64>>,
}

impl Log {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample. Never the case for a log from [`Bench::load`](crate::Bench::load).
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Time from the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// The samples of a channel, in SI.
    pub fn channel(&self, channel: Channel) -> Option<&[f64]> {
        match channel {
            Channel::Time => Some(&self.time_s),
            Channel::Angle => self.angle_rad.as_deref(),
            Channel::Rate => self.rate_rad_s.as_deref(),
            Channel::WheelSpeed => self.wheel_speed_rad_s.as_deref(),
            Channel::WheelAngle => self.wheel_angle_rad.as_deref(),
            Channel::Current => self.current_a.as_deref(),
        }
    }

    pub(crate) fn channel_mut(&mut self, channel: Channel) -> Option<&mut Vec<f64>> {
        match channel {
            Channel::Time => Some(&mut self.time_s),
            Channel::Angle => self.angle_rad.as_mut(),
            Channel::Rate => self.rate_rad_s.as_mut(),
            Channel::WheelSpeed => self.wheel_speed_rad_s.as_mut(),
            Channel::WheelAngle => self.wheel_angle_rad.as_mut(),
            Channel::Current => self.current_a.as_mut(),
        }
    }
}

impl Log {
    /// Sets the samples of a channel.
    pub(crate) fn set(&mut self, channel: Channel, samples: Vec<f64>) {
        match channel {
            Channel::Time => self.time_s = samples,
            Channel::Angle => self.angle_rad = Some(samples),
            Channel::Rate => self.rate_rad_s = Some(samples),
            Channel::WheelSpeed => self.wheel_speed_rad_s = Some(samples),
            Channel::WheelAngle => self.wheel_angle_rad = Some(samples),
            Channel::Current => self.current_a = Some(samples),
        }
    }
}

//! The noise of a bench's sensors, for the computation of its effect in the loop.

use identify::{Output, Record};
use plant::Kind;
use simulate::Sensors;

use crate::session::Session;

/// Standard deviations of a single sample (rad, rad/s, rad/s), each with the name of the experiment that showed it.
/// `None` if no log of the bench has the sensor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BenchNoise {
    /// Noise of the angle, rad.
    pub angle: Option<(f64, String)>,
    /// Noise of the rate, rad/s.
    pub rate: Option<(f64, String)>,
    /// Noise of the wheel speed, rad/s.
    pub wheel_speed: Option<(f64, String)>,
}

impl Session {
    /// The noise of the bench's sensors according to its logs. Balance logs are preferred, because the sensors then
    /// measure the same motion as in the loop; if there are none, all logs count. Of several logs the median is taken.
    pub fn sensor_noise(&self) -> BenchNoise {
        let of = |output: Output| noise_of(self.records(), output);
        BenchNoise {
            angle: of(Output::Angle),
            rate: of(Output::Rate),
            wheel_speed: of(Output::WheelSpeed),
        }
    }
}

fn noise_of(records: &[Record], output: Output) -> Option<(f64, String)> {
    let of_kind = |balance: bool| {
        let own = records
            .iter()
            .filter(move |record| (record.kind == Kind::Balance) == balance);
        let mut found: Vec<(f64, String)> = own
            .filter_map(|record| Some((record.channel(output)?.noise_std, record.name.clone())))
            .filter(|(std, _)| std.is_finite())
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let middle = found.len() / 2;
        found.into_iter().nth(middle)
    };
    of_kind(true).or_else(|| of_kind(false))
}

impl BenchNoise {
    /// The noise of every sensor (rad, rad/s, rad/s) and its source. Unknown noise is replaced by that of the thesis
    /// bench, and the source says so.
    pub(crate) fn or_assumed(&self) -> ([f64; 3], [String; 3]) {
        let usual = Sensors::of_the_thesis();
        let of = |known: &Option<(f64, String)>, usual: f64| match known {
            Some((std, experiment)) => (*std, format!("log \"{experiment}\"")),
            None => (usual, "assumed, as on the thesis bench".to_owned()),
        };
        let all = [
            of(&self.angle, usual.angle.noise_std),
            of(&self.rate, usual.rate.noise_std),
            of(&self.wheel_speed, usual.wheel_speed.noise_std),
        ];
        (
            all.clone().map(|(std, _)| std),
            all.map(|(_, source)| source),
        )
    }
}

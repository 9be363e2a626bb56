//! From a region of a coordinate back to the time of a log.

use super::coordinate::Coordinate;
use super::failure_map::FailureRegion;
use super::series::Context;

impl Context<'_> {
    /// The stretches of a region in the time of its own log.
    pub(super) fn stretches_of(&self, region: &FailureRegion) -> Vec<[f64; 2]> {
        let mut records = self.records.iter();
        let own = records.position(|record| record.name == region.experiment);
        let mut all = Coordinate::ALL.iter();
        let index = all.position(|coordinate| *coordinate == region.coordinate);
        let (Some(own), Some(index)) = (own, index) else {
            return vec![];
        };
        match &self.motions[own] {
            Some(motion) => stretches(&motion.time_s, &self.places[own][index], region),
            None => vec![],
        }
    }
}

/// The stretches of a log's time in which the coordinate of a region lies in the region: first and last instant, s, in
/// rising order. `at` has the value of the coordinate at each of the instants `time_s`. A pass that only one instant
/// sees is no stretch.
fn stretches(time_s: &[f64], at: &[f64], region: &FailureRegion) -> Vec<[f64; 2]> {
    if region.coordinate == Coordinate::Time {
        return vec![[region.from, region.to]];
    }
    let mut found: Vec<[f64; 2]> = vec![];
    let mut open: Option<[f64; 2]> = None;
    for (&time, &value) in time_s.iter().zip(at) {
        let is_inside = value >= region.from && value <= region.to;
        open = match (open, is_inside) {
            (Some([from, _]), true) => Some([from, time]),
            (None, true) => Some([time, time]),
            (Some(stretch), false) => {
                found.push(stretch);
                None
            }
            (None, false) => None,
        };
    }
    found.extend(open);
    found.retain(|[from, to]| to > from);
    found
}

#[cfg(test)]
mod tests {
    use super::super::failure_map::ResidualKind;
    use super::*;

    fn region(coordinate: Coordinate, from: f64, to: f64) -> FailureRegion {
        FailureRegion {
            experiment: "swing".to_owned(),
            channel: "angle",
            quantity: ResidualKind::Output,
            coordinate,
            from,
            to,
            stretches_s: vec![],
            share_of_error: 0.8,
            size: 1.0,
            is_significant: true,
        }
    }

    #[test]
    fn stretches_are_where_the_coordinate_lies_in_the_region() {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-2).collect();
        let sine: Vec<f64> = time_s.iter().map(|t| t.sin()).collect();
        // sin t is at least 0 for t in [0, π] and [2π, 3π].
        let found = stretches(&time_s, &sine, &region(Coordinate::Angle, 0.0, 2.0));
        assert_eq!(
            found,
            [[time_s[0], time_s[314]], [time_s[629], time_s[942]]]
        );
        let nowhere = stretches(&time_s, &sine, &region(Coordinate::Angle, 2.0, 3.0));
        assert_eq!(nowhere, Vec::<[f64; 2]>::new());
        // An amplitude that decays passes through a region once.
        let decay: Vec<f64> = time_s.iter().map(|t| (-t).exp()).collect();
        let (least, most) = ((-4.005_f64).exp(), (-2.005_f64).exp());
        let found = stretches(&time_s, &decay, &region(Coordinate::Amplitude, least, most));
        assert_eq!(found, [[time_s[201], time_s[400]]]);
    }

    #[test]
    fn a_region_of_time_is_a_stretch() {
        let found = stretches(&[], &[], &region(Coordinate::Time, 1.0, 2.5));
        assert_eq!(found, [[1.0, 2.5]]);
    }
}

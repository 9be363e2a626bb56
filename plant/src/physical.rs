//! The values that the cause of an effect can have, whatever the size of the bench.

/// The range within which the cause that an effect names can lie.
///
/// The bounds of a fit are wider, so that a fit shows where it wants to go. A value outside this range is no
/// measurement of that cause: the term imitates something else, and the diagnosis accepts it as no explanation. Only
/// what the cause itself bounds has such a range (times, speeds in a bearing, ratios), not what grows with the bench
/// (torques, drags).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicalRange {
    /// Index of the parameter in [`crate::EffectInfo::parameters`].
    pub parameter: usize,
    /// Index of the parameter by which it is divided, where only the ratio of the two is bounded.
    pub over: Option<usize>,
    /// The smallest and the largest value or ratio, in its unit.
    pub range: (f64, f64),
    /// Why no such cause lies outside, as the end of a sentence after a colon.
    pub reason: &'static str,
}

impl PhysicalRange {
    /// The value or ratio that is bounded, for an effect with the parameters `p`; NaN for the ratio of nothing to
    /// nothing.
    pub fn of(&self, p: &[f64]) -> f64 {
        p[self.parameter] / self.over.map_or(1.0, |over| p[over])
    }

    /// How far a value or ratio lies outside, in its unit; 0 inside, and for NaN.
    pub fn beyond(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        (low - value).max(value - high).max(0.0)
    }
}

/// The friction at rest, parameter 1, is not less than the friction while sliding, parameter 0: a smaller one is no
/// Stribeck curve, but a friction that grows with the speed.
pub(crate) const HOLDS_AT_REST: PhysicalRange = PhysicalRange {
    parameter: 1,
    over: Some(0),
    range: (1.0, f64::INFINITY),
    reason: "a contact holds at rest at least as strongly as it rubs while it slides",
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EffectId;

    #[test]
    fn a_friction_that_grows_with_the_speed_is_no_stribeck_curve() {
        let beyond = |p: &[f64]| HOLDS_AT_REST.beyond(HOLDS_AT_REST.of(p));
        assert_eq!(beyond(&[1e-3, 2e-3]), 0.0);
        assert_eq!(beyond(&[1e-3, 7.5e-4]), 0.25);
        // No sliding friction at all, and no friction at all.
        assert_eq!(beyond(&[0.0, 1e-3]), 0.0);
        assert_eq!(beyond(&[0.0, 0.0]), 0.0);
    }

    #[test]
    fn every_range_has_a_reason_and_room_for_what_is_usual() {
        for effect in EffectId::ALL {
            let info = effect.info();
            for range in info.physical {
                assert!(!range.reason.is_empty(), "{}", info.name);
                let own = &info.parameters[range.parameter];
                if range.over.is_none() {
                    for usual in [own.plausible.0, own.plausible.1] {
                        assert_eq!(range.beyond(usual), 0.0, "{}", own.name);
                    }
                    let fit = own.bounds;
                    assert!(
                        fit.0 <= range.range.0.max(fit.0) && range.range.1 < fit.1,
                        "the fit of {} shows where it wants to go",
                        own.name
                    );
                }
            }
        }
    }
}

//! The numbers that decide verdicts, each with its source.
//!
//! The numbers in `economy.rs` only save time. Three thresholds stand in `identify`, beside the statistics that
//! they bound, because reports use them without a diagnosis: when a residual is more than noise
//! ([`identify::SIGNIFICANT`]), what counts as a push, and when two results contradict each other.
//! `docs/guide/thresholds.md` lists the verdicts that change when a number of this file is moved by a quarter.

/// Declares the numbers once: the struct, the default values, and the list through which a number can be changed
/// by its name.
macro_rules! thresholds {
    ($($(#[$about:meta])* $name:ident = $value:expr),* $(,)?) => {
        /// The numbers that decide verdicts. "Judgement" marks a number that no statistical theory gives; its
        /// comment then says on what it was calibrated.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Thresholds {
            $($(#[$about])* pub $name: f64,)*
        }

        impl Default for Thresholds {
            fn default() -> Thresholds {
                Thresholds { $($name: $value,)* }
            }
        }

        impl Thresholds {
            /// Every number with its name, to be read or changed.
            pub fn each(&mut self) -> Vec<(&'static str, &mut f64)> {
                vec![$((stringify!($name), &mut self.$name),)*]
            }
        }
    };
}

thresholds! {
    /// Two models tie if the logarithms of their evidence differ by less than this. The value 3 means odds of
    /// 20 to one, "strong" in the scale of Kass & Raftery (JASA 90 (1995)).
    tie = 3.0,
    /// Periods of an oscillation that count as one independent value of its misfit. The misfit of an oscillation
    /// is a slow error of amplitude and phase: two numbers. The cause on a real bench (play, dust, a creeping
    /// zero) is assumed to renew itself every three periods. A log is therefore worth at least one independent
    /// value per one and a half periods. Judgement; no calibration is recorded.
    periods_per_value = 1.5,
    /// A structured remainder of at least this size, in units of a channel's noise, counts as "something
    /// remains". Judgement: a misfit below the noise is not visible in a figure.
    remains = 1.0,
    /// Explanations that tie are offered as alternatives if the best of them leaves at most this structured
    /// remainder, in units of noise. If it leaves more, none of them explains the measurements. Judgement, from
    /// the exam: effects that are not in the library leave at least this much.
    left_by_ties = 3.0,
    /// Least gain in χ² for which a suspect is fitted: the 1e-5 point of χ² with two degrees of freedom. With
    /// twenty suspects and white noise, one passes by chance on one bench in five thousand.
    least_gain = 23.0,
    /// Least gain in χ² of a refinement of the answer: the 1 % point of χ² with two degrees of freedom. It is
    /// less strict than `least_gain` because one refinement is tested, not twenty suspects. A refinement with
    /// such a gain is not chosen for that alone, but the report names it beside the answer.
    least_gain_of_refinement = 9.2,
    /// An effect is set aside if it explains less than this share of the misfit in the experiments in which it
    /// acts: every effect can imitate a small part of an unknown cause. Such an effect may still be real beside
    /// the main cause, and is found once the main cause has been added. Judgement; when it was introduced, the
    /// verdicts of the exam were the same with and without it.
    least_part = 0.01,
    /// An effect must lower the error of at least one series by this share of the series' noise; the fall is the
    /// root of the difference of the mean squared errors. A smaller fall can be statistically significant in
    /// ten thousand samples and still come from the integration rule or from a clock. Judgement; no calibration
    /// is recorded.
    least_trace = 0.2,
    /// As `least_trace`, for a refinement that replaces a term of the model. A smaller fall is enough, because the
    /// imperfection of that term is known (see `imperfection.rs`). The value is a hundredth of the noise's
    /// variance. Judgement, calibrated on 219 drawn benches with dry friction: it made 11 more answers right
    /// and none wrong.
    least_trace_of_refinement = 0.1,
    /// As `least_trace`, for an effect that joins others that act in the same experiment. The terms of those
    /// others are imperfect: dry friction with a smoothed sign sticks a little less than a real joint, and a
    /// window takes its history from noisy samples. A further effect can absorb such
    /// an error. Refinements are exempt. Judgement, made with the exam; the figures are not recorded.
    least_trace_beside = 0.5,
    /// An effect that joins others must also lower an error by at least this share of what the others lowered it
    /// by. Dry friction with its sign smoothed over 0.01 rad/s agrees with that of a real joint to about half a
    /// percent; the threshold is twice that.
    least_share_of_trace = 0.01,
    /// It must also lower an error by this many times the misfit that the smoothed sign of dry friction alone
    /// leaves there (see `imperfection.rs`). At a factor of two, that misfit makes up at most a quarter of the
    /// squared fall. The computed misfit is a lower bound: the "sticking" joint in its computation has a sign that
    /// is ten times sharper, not infinitely sharp.
    times_imperfection = 2.0,
    /// A fault of the gyroscope is plain if the comparison with the angle shows it at more than this many
    /// standard errors. Of a Gaussian error, 99.7 % lies within three.
    plain_fault = 3.0,
    /// A fitted value that lies outside the range of its cause (`EffectInfo::physical`) by more than this many standard
    /// errors is no measurement of that cause. Of a Gaussian error, 99.7 % lies within three.
    unphysical = 3.0,
    /// Two experiments, or a measured and a stated value, that differ by more than this many standard errors
    /// prevent the verdict "explained". The test of contradictions itself reports from its 1e-3 point on. Here ten is
    /// asked because a standard error covers the noise and its correlation, but not the errors of an
    /// integration rule or a clock; measured in standard errors, those grow with the number of samples.
    /// Judgement, by the exam: see docs/guide/thresholds.md.
    contradiction = 10.0,
    /// The logs are read in short windows if cogging explains at least this share of the misfit there. Half means
    /// that cogging is the larger part. Beside a larger effect, cogging is found once that effect has been added.
    cogging_share = 0.5,
    /// Upper end of the prior for the trace of an effect beside something unknown, in units of noise. Judgement:
    /// three decades. Calibrated on the exam: suspects that explained half to nine tenths of the misfit of an
    /// unknown effect were really present in one case of twenty.
    largest_trace = 1e3,
    /// Prior odds that an unknown cause acts alone, against an unknown cause beside an effect of the library: two
    /// causes at once are rarer than one. Judgement; the exam's draw agrees in its order of magnitude: nine of ten
    /// benches with a remainder hide nothing else.
    alone_to_beside = 9.0,
}

//! The numbers that decide verdicts, each with where it comes from.
//!
//! What stands in `economy.rs` only saves time. What decides in the fit whether a residual is noise
//! ([`identify::SIGNIFICANT`]), what is a push and what contradicts stands in `identify` beside the
//! statistic that it bounds, since reports use it without any diagnosis. `docs/thresholds.md` shows how much hangs on each number
//! here: the verdicts that change where it is moved by a quarter.

/// Declares the numbers once: the struct, its usual values, and the list by which one of them can be moved.
macro_rules! thresholds {
    ($($(#[$about:meta])* $name:ident = $value:expr),* $(,)?) => {
        /// The numbers that decide verdicts. "Judgement" says that no statistics gives the number; it then
        /// also says on what it was calibrated.
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
            /// Every number with its name, to be read or moved.
            pub fn each(&mut self) -> Vec<(&'static str, &mut f64)> {
                vec![$((stringify!($name), &mut self.$name),)*]
            }
        }
    };
}

thresholds! {
    /// Difference of the logarithm of the evidence beyond which one model is preferred to another:
    /// odds of 20 to one, "strong" in the scale of Kass & Raftery (JASA 90 (1995)). Below it they tie.
    tie = 3.0,
    /// Periods of an oscillation for each independent value of its misfit. A misfit of an oscillation is a slow
    /// error of its amplitude and phase: two numbers. What causes it on a real bench (play, dust, a zero
    /// that creeps) is taken to renew itself every three periods, so that a log is worth at least one
    /// value for each one and a half of them. Judgement; a calibration is not
    /// recorded.
    periods_per_value = 1.5,
    /// Structure of this size in units of a channel's noise counts as "something remains". Judgement: the noise
    /// itself is the scale below which nobody looking at the figure would see a misfit.
    remains = 1.0,
    /// Explanations that tie are worth a choice if the best of them leaves at most this much structure in
    /// units of noise; beyond it, what they share is that they do not explain the measurements. Judgement,
    /// with the exam, in which outsiders leave at least this.
    left_by_ties = 3.0,
    /// Least gain of a suspect in χ²: the 1e-5 point for two parameters, so that even twenty suspects on
    /// white noise pass it once in five thousand benches.
    least_gain = 23.0,
    /// Least gain in χ² of what refines the answer: the 1 % point for two parameters, since this is asked
    /// once and not of twenty suspects. What gains so little is not chosen for it, but it is named beside the
    /// answer.
    least_gain_of_refinement = 9.2,
    /// An effect that takes less than this part of what the model misses in the experiments in which it
    /// acts is not what is missing there: an unknown cause looks a little like everything. Beside what
    /// is missing it may be real, and is found once that has been added. Judgement; the verdicts of the exam
    /// were the same without it when it came.
    least_part = 0.01,
    /// An effect must lower the error of some series by at least this share of the series' noise (root
    /// of the difference of the mean squares). What is smaller may be significant in ten thousand
    /// samples, and yet be the imperfection of an integration rule or of a clock. Judgement; a
    /// calibration is not recorded.
    least_trace = 0.2,
    /// The same for a refinement that takes the place of a term: it speaks about that very term, whose own
    /// imperfection is known (see `imperfection.rs`). A hundredth of the noise's variance. Judgement,
    /// calibrated on 219 drawn benches with dry friction: 11 answers became right by it and none wrong.
    least_trace_of_refinement = 0.1,
    /// The same for an effect beside others that were added before it, in experiments in which they act:
    /// their terms have imperfections of their own (dry friction with its smoothed sign sticks a little
    /// less than a real joint; a window knows its past from noisy samples), which another effect may take
    /// up. A refinement is spared. Judgement, made with the exam; figures are not recorded.
    least_trace_beside = 0.5,
    /// What is added beside others must also show at least this share of their trace: dry friction
    /// whose sign is smoothed over 0.01 rad/s is that of a real joint to about half a percent, and twice
    /// that is asked.
    least_share_of_trace = 0.01,
    /// And so many times what the smoothed sign of dry friction alone would leave there (see
    /// `imperfection.rs`): of a smaller trace a quarter of the square could be that, and the sign that
    /// stands for sticking there is ten times as sharp and not infinitely so.
    times_imperfection = 2.0,
    /// Standard errors by which a fault of the gyroscope must show against the angle: of an
    /// error that is Gaussian 99.7 % lie within three.
    plain_fault = 3.0,
    /// Standard errors beyond which experiments or knowns that contradict each other keep a verdict from being
    /// "explained". The test itself reports from the 1e-3 point of its bench; ten is asked here, since the standard
    /// errors know the noise and its correlation but not the imperfections of an integration rule or a clock,
    /// which grow beside them with the number of samples. Judgement, by the exam: see docs/thresholds.md.
    contradiction = 10.0,
    /// Share of what a model misses that cogging must take over short windows, for the logs to be read in
    /// them: beside a larger effect it is found once that has been added. Half: it must be the larger part.
    cogging_share = 0.5,
    /// The largest trace that is thought of beforehand, in units of noise, for the probability of effects beside
    /// something unknown. Judgement: three decades. Calibrated on the exam, where suspects that took half
    /// to nine tenths of an outsider's misfit were there in one case of twenty.
    largest_trace = 1e3,
    /// How much more probable it is beforehand that what is unknown acts alone than that a library effect
    /// acts beside it: two causes at once are rarer than one. Judgement, of the order that the exam's draw
    /// bears out, in which nine of ten benches with a remainder hide nothing else.
    alone_to_beside = 9.0,
}

//! The numbers that decide findings, by the module that uses them, each with its derivation. "Judgement" marks a number
//! that no law gives; its comment then says on what it was calibrated, or that no calibration is recorded.
//!
//! The test `recordings` holds all of them from one side: nothing of the recordings of other labs is refused. The tests
//! `matrix`, `known_faults`, `hostile` and `silent` hold them from the other, on benches of random size: each fault is
//! found, and the same bench without it has no finding.

/// What several modules ask of a fit.
pub(crate) mod fit {
    /// Standard errors by which a coefficient must differ from 0 before anything is reported. A Gaussian error exceeds
    /// eight once in 10¹⁵ fits; the margin is for what the standard errors leave out: bumps that share samples, and
    /// noise of the columns.
    pub(crate) const STANDARD_ERRORS: f64 = 8.0;
    /// Share of the right-hand side's variance that a fit must explain before its signs and units are reported. A
    /// column that explains less may stand for another (judgement; no calibration is recorded).
    pub(crate) const EXPLAINED: f64 = 0.8;
    /// Smallest number of points for a line through two series (judgement: a line has two parameters, and four points
    /// for each leave an estimate of the scatter).
    pub(crate) const FEWEST_POINTS: usize = 8;
    /// Smallest number of rows for a fit with two or three columns, by the same judgement.
    pub(crate) const FEWEST_ROWS: usize = 20;
    /// Smallest number of samples under a bump; `identify` uses no shorter ones.
    pub(crate) const SHORTEST_BUMP: usize = 12;
    /// Smallest eigenvalue of scaled normal equations: a correlation beyond 1 − 1e-9 is a rounding error.
    pub(crate) const INDEPENDENT: f64 = 1e-9;
}

/// Ratios of units (`slips`).
pub(crate) mod slips {
    /// Largest distance of a measured factor from a known one, as a logarithm. Scale errors of gyroscopes, lags of
    /// filters and the influence of friction on an acceleration stay below 15 %. The nearest two factors of the list,
    /// 6.28 and 9.55, differ by 42 %, so that no two of these ranges overlap.
    pub(crate) const NEAR: f64 = 0.15;
}

/// What a bench is (`view`, `known`).
pub(crate) mod bench {
    use std::ops::Range;

    /// Range of the period of a pendulum on a bench, s. The equivalent length g T²/4π² goes from 2.5 mm to 60 m. With a
    /// counterweight, an arm of 0.3 m can have the latter; no arm has a thousandth or a thousand times these lengths.
    pub(crate) const PERIODS_S: Range<f64> = 0.1..16.0;
    /// Fewest lines that are counted: so few could be seconds of a short look at a bench (judgement).
    pub(crate) const FEWEST_LINES: usize = 40;
    /// Gravity on Earth's surface lies between 9.76 and 9.84 m/s²; rounded values are usual.
    pub(crate) const GRAVITY: Range<f64> = 9.7..9.9;
    /// Ranges for a bench, from the smallest that can be built by hand to the largest that one person can lift: masses
    /// in kg, lengths in m, torque constants in N m/A (from a toy motor to a servo of 1 kW). Judgement.
    pub(crate) const MASS_KG: Range<f64> = 1e-3..30.0;
    /// As [`MASS_KG`], m.
    pub(crate) const LENGTH_M: Range<f64> = 2e-3..3.0;
    /// As [`MASS_KG`], N m/A.
    pub(crate) const TORQUE_CONSTANT: Range<f64> = 2e-4..2.0;
    /// Beyond the range by this factor, a value is not an unusual bench but a mistake (judgement). A slip of units is a
    /// factor of ten at least.
    pub(crate) const SURELY: f64 = 3.0;
    /// The wheel's share of the total inertia, j_w/Θ. The rim does not reach the pivot, so j_w < k² m_w and
    /// j_w/Θ < 1/2. A wheel whose radius of gyration is below a seventh of its distance from the pivot would have
    /// less than 1/49 of k² m_w, which is at least a quarter of Θ.
    pub(crate) const SHARE_OF_INERTIA: Range<f64> = 0.005..0.5;
}

/// The body of a log in which everything is free (`body`, `momentum`).
pub(crate) mod momentum {
    use std::f64::consts::PI;

    /// Correlation from which wheel and body accelerate oppositely, and the share within which they do so by equal
    /// amounts. A motor accelerates the wheel by at least twice as much as the body, since no wheel has more than half of
    /// the inertia; and bumps of a dozen samples make an acceleration from an angle alone wrong by up to a fifth.
    pub(crate) const OWN_MOTION: f64 = 0.9;
    /// See [`OWN_MOTION`].
    pub(crate) const EQUAL: f64 = 0.3;
    /// Partial share of a column above which noise draws its coefficient towards 0 by no more than a tenth (Frisch's
    /// bounds, see `regression`).
    pub(crate) const CLEAR: f64 = 0.9;
    /// Another unit of the angle is taken for right if its residual is below this share of the residual with the stated
    /// unit (judgement: a factor of ten in variance, which no effect of the library gives by chance in the tests).
    pub(crate) const LEFT_OVER: f64 = 0.1;
    /// Least share of the acceleration's variance that a wrong unit leaves: a twentieth of the acceleration. Springs and
    /// presliding change a period by up to 4 % with the amplitude (see [`super::swing::CHANGE`]), and so can look like
    /// another unit below that.
    pub(crate) const LEAST_LEFT: f64 = 0.0025;
    /// Turns of a driven body above which gravity must be seen to act as the sine of its angle. A motor that lifts a body
    /// over the top does so against gravity, which then shows; a column in degrees goes far beyond so many turns.
    pub(crate) const MOST_TURNS: f64 = 2.0;
    /// Turns above which no motor with a wheel did it (judgement): to go round so often in one log, the body must turn as
    /// fast as a wheel, whose momentum it has not got.
    pub(crate) const IMPOSSIBLE_TURNS: f64 = 20.0;
    /// Distance of the angle's zero from hanging, rad, above which it is no error of mounting (judgement: 20°).
    pub(crate) const ZERO_RAD: f64 = 0.35;
    /// Distance of the angle's zero from hanging, rad, above which the data are refused. With a zero at c, gravity as the
    /// column shows it is −ω² cos c sin α + ω² sin c cos α. The base model has the first term; the effect angle-offset
    /// adds the second. From 45° on the second is the larger one: the model's gravity is then no longer gravity with an
    /// error, and an inertia fitted without the effect is wrong by more than √2. That the refusal begins exactly where
    /// the two are equal is a judgement, and it was made while one recording of another lab was in view: its zero is at
    /// 41° (a free swing, to which this comparison is not applied), so that nothing known lies between the two bounds.
    pub(crate) const WRONG_ZERO_RAD: f64 = PI / 4.0;
    /// Distance, as a logarithm, of a ratio of two measures of one quantity from 1 up to which they agree: that of a
    /// known ratio ([`super::slips::NEAR`]).
    pub(crate) const AGREE: f64 = super::slips::NEAR;
}

/// A wheel without a current (`coast`).
pub(crate) mod coast {
    /// Blocks of a log whose means are compared (judgement: few enough that a mean has a fraction of a sample's noise,
    /// enough that a short push is not averaged away).
    pub(crate) const BLOCKS: usize = 50;
    /// Least speed gained, as a share of the largest. A wheel out of balance on a body that is not clamped hard swings
    /// by a few per cent of its speed (judgement; nothing of the recordings of other labs gains so much).
    pub(crate) const GAIN_SHARE: f64 = 0.1;
    /// Least speed gained, in standard deviations of a sample's noise: a mean of two samples or more differs from
    /// another by eight of them once in 10¹⁵ times.
    pub(crate) const GAIN_NOISE: f64 = 8.0;
}

/// A free swing (`swing`).
pub(crate) mod swing {
    /// Relative change of the period over the log above which its cause is searched for. Presliding and springs
    /// change it by up to 4 % (the thesis' own bench), a pendulum with an amplitude of 1 rad by 6.6 %.
    pub(crate) const CHANGE: f64 = 0.05;
    /// Share of that change that the right unit may leave (judgement; no calibration is recorded).
    pub(crate) const LEFT_OVER: f64 = 0.25;
    /// Number of periods averaged at each end of the compared range (judgement: the standard error of one period falls
    /// by a factor of two, and the range stays long).
    pub(crate) const AT_EITHER_END: usize = 5;
    /// Smallest amplitude that is compared, as a share of the largest. The period of a pendulum changes with the square
    /// of the amplitude, so eight ninths of the change lie above it. The last swings before dry friction stops the body
    /// have periods of their own.
    pub(crate) const LEAST_AMPLITUDE: f64 = 1.0 / 3.0;
    /// Way between two turning points, in turns, that a body without a motor does not make: once it has turned back, its
    /// energy is below that of the top, and so less than one turn lies between two turning points. A tenth is for the
    /// noise.
    pub(crate) const LONGEST_SWING: f64 = 1.1;
    /// Fewest such ways: a hand may have made the first two (judgement).
    pub(crate) const FEWEST_ROUNDS: usize = 3;
    /// Way back, rad, that shows a turning point: larger than any noise of an angle in rad, and smaller than a swing that
    /// goes round.
    pub(crate) const TURNS_BACK_RAD: f64 = 1.0;
    /// Range within which a body counts as still, in standard deviations of the noise: noise leaves ±4 once in 16 000
    /// samples.
    pub(crate) const STILL: f64 = 4.0;
    /// The same in steps of the column (a value between two steps shows both), and as a share of half the range
    /// (judgement: a sway of a fiftieth while a hand holds the body).
    pub(crate) const STILL_STEPS: f64 = 2.0;
    /// See [`STILL_STEPS`].
    pub(crate) const STILL_SHARE: f64 = 0.02;
    /// Share of half the range above which a band is too wide to tell a standstill from a swing (judgement).
    pub(crate) const TOO_WIDE: f64 = 0.3;
    /// Share of a period for which the body may stand still at its first turning point: a release by hand takes that long
    /// (judgement).
    pub(crate) const RELEASE: f64 = 0.25;
    /// Share of a period from which a hold is refused (judgement: a beginning that is longer than half a swing is no
    /// release). The rows of a shorter one are left out ([`identify::held_start`]).
    pub(crate) const LONG_HOLD: f64 = 0.5;
    /// Growth of the turning points on one side above which energy came in: in standard deviations of the noise (the
    /// farthest of several noisy samples lies about two off, and two are compared: six are never reached by chance) and
    /// in steps of the column. What the time between two samples hides of a turning point is added in `swing`.
    pub(crate) const GAIN_NOISE: f64 = 6.0;
    /// See [`GAIN_NOISE`].
    pub(crate) const GAIN_STEPS: f64 = 3.0;
    /// Least growth as a share of half the range, and of the swing itself; the smaller of the two counts (judgement: a
    /// swing that was filmed grows by 2.4 % once, by an error of the picture's scale, and no hand was on it).
    pub(crate) const GAIN_SHARE: f64 = 0.03;
    /// See [`GAIN_SHARE`].
    pub(crate) const GAIN_OF_SWING: f64 = 0.05;
    /// Number of the turning point up to which growth is the work of a hand that sets the body going (judgement: one whole
    /// swing).
    pub(crate) const SETTING_GOING: usize = 2;
    /// Standard errors of the inertia by which the period must contradict a locked wheel: of a Gaussian error, 99.7 %
    /// lies within three. What decides beside them is whether the masses are right, which the warning says.
    pub(crate) const FREE_WHEEL_ERRORS: f64 = 3.0;
    /// Distance of the inertia from that without the wheel, as a share of the wheel's, up to which the wheel counts as
    /// free: nearer to free than to locked by a factor of three.
    pub(crate) const FREE_WHEEL: f64 = 0.25;
}

/// The rate and the angle (`kinematics`).
pub(crate) mod kinematics {
    /// Correlation of rate and derivative above which their ratio is known within 5 % (Frisch's bounds, see
    /// `regression`).
    pub(crate) const CLEAR: f64 = 0.95;
    /// Correlation below which a rate that moves well above its noise cannot be the derivative of the angle: it then
    /// shares less than a quarter of its variance (judgement).
    pub(crate) const UNRELATED: f64 = 0.5;
    /// Motion of a channel, in units of its noise, from which [`UNRELATED`] is applied: noise alone covers ten in a million
    /// lines.
    pub(crate) const OVER_NOISE: f64 = 30.0;
    /// Largest factor error, as a share, that counts as a scale error of the gyroscope. Data sheets allow 3 % (effect
    /// `gyro-scale`); a warning comes at five times that.
    pub(crate) const SCALE_ERROR: f64 = 0.15;
    /// A rate counts as delayed if a shift in time removes this share of the correlation's distance from 1 (judgement).
    pub(crate) const SHORTFALL: f64 = 0.5;
    /// Delay in samples up to which nothing is reported: one hold and one computation.
    pub(crate) const USUAL_DELAY: usize = 2;
    /// Largest delay, in samples, that is tried (judgement: longer delays no longer look like one).
    pub(crate) const MOST_LATE: isize = 20;
    /// Distance of the usual step of the angle from rate times interval, as a share of the step, up to which the two
    /// agree at all. Noise alone hides more, and then a standstill of one of them is not looked for.
    pub(crate) const AGREES: f64 = 0.3;
    /// Way that a channel misses while it stands still: in standard deviations of the angle's noise and in steps of its
    /// column (as [`super::channels::BEYOND_NOISE`], with a margin for the noise of the integrated rate), and as a share
    /// of the angle's range (judgement: less changes no parameter by more than that).
    pub(crate) const MISSED_NOISE: f64 = 20.0;
    /// See [`MISSED_NOISE`].
    pub(crate) const MISSED_STEPS: f64 = 5.0;
    /// See [`MISSED_NOISE`].
    pub(crate) const MISSED_SHARE: f64 = 0.05;
}

/// Each channel alone, and the time stamps (`channels`, `jumps`).
pub(crate) mod channels {
    /// Smallest number of equal samples that counts as a stop at a limit (judgement: the top of a smooth motion, rounded,
    /// has two or three).
    pub(crate) const AT_LIMIT: usize = 4;
    /// Least excursion beyond a limit, extrapolated from the slopes on both sides: in standard deviations of the noise,
    /// and in steps of the column. A smaller one is a turning point.
    pub(crate) const BEYOND_NOISE: f64 = 8.0;
    /// See [`BEYOND_NOISE`].
    pub(crate) const BEYOND_STEPS: f64 = 3.0;
    /// Smallest number of equal samples at the end of a log that show a limit, where the noise before them is larger than
    /// so many steps of the column. Noise of two steps repeats a sample once in five times, and never so often in a row.
    pub(crate) const STUCK: usize = 20;
    /// See [`STUCK`].
    pub(crate) const NOISY_STEPS: f64 = 2.0;
    /// Share of samples at a limit above which results from the channel are wrong (judgement).
    pub(crate) const CLIPPED_SHARE: f64 = 0.02;
    /// Smallest number of equal samples of a frozen channel (judgement; what decides is the way that is missed).
    pub(crate) const FROZEN: usize = 5;
    /// Share of a log that may be frozen before results from the channel are wrong (judgement).
    pub(crate) const FROZEN_SHARE: f64 = 0.1;
    /// Least noise of a channel that can be missed, as a share of its range: less is a simulation's, or a filter's.
    pub(crate) const LEAST_NOISE: f64 = 1e-4;
    /// Distance of a frozen value from the channel's median, as a share of half its range, from which it is no rest
    /// (judgement).
    pub(crate) const OFF_REST: f64 = 0.1;
    /// Number of levels below which a channel hardly resolves a motion (judgement).
    pub(crate) const FEW_LEVELS: f64 = 12.0;
    /// Share of equal neighbouring samples above which a channel repeats samples (judgement: a sensor at half the rate of
    /// the log repeats every second one).
    pub(crate) const REPEATED: f64 = 0.4;
    /// Number of steps between two samples from which equal neighbours come neither from rounding nor from rest.
    pub(crate) const LARGE_STEP: f64 = 10.0;
    /// Smallest number of such steps before repetitions are counted (judgement).
    pub(crate) const FEWEST_LARGE: usize = 20;
    /// Allowed variation of the sampling interval (fifth to ninety-fifth percentile), as a share of its usual value
    /// (judgement: from half the interval to one and a half).
    pub(crate) const JITTER: f64 = 1.0;
    /// Allowed share of lines that repeat the time of the line before (judgement).
    pub(crate) const REPEATED_TIMES: f64 = 0.02;
    /// Share of a turn between two samples above which the direction of a wheel is uncertain; at half a turn it is
    /// unknown.
    pub(crate) const DOUBTFUL_TURN: f64 = 0.4;
    /// Share of such steps above which the speed is wrong somewhere: a wheel that speeds up through half a turn a sample
    /// has them on its way there, and a lost sample is one.
    pub(crate) const DOUBTFUL_SHARE: f64 = 0.01;
    /// Size of a jump against the largest other step of the channel. A body or a wheel that moves several times as far in
    /// one sample as in any other one would need, in that sample alone, a torque that acts nowhere else (judgement: five;
    /// two recordings of another lab at 20 Hz, which seem to have lost samples, have one step of 3.1 times the others).
    pub(crate) const JUMP_STEPS: f64 = 5.0;
    /// Size of a jump in standard deviations of the noise, and against the range of the channel (judgement: a tenth).
    pub(crate) const JUMP_NOISE: f64 = 30.0;
    /// How many times as long as the steps beside it a step after a lost sample is: twice, less what the pace changes.
    pub(crate) const LOST_STEP: f64 = 1.7;
    /// Largest ratio of two of the four steps beside a lost sample. Near a turning point the pace changes by more, and
    /// there a step tells nothing (judgement).
    pub(crate) const LOST_ALIKE: f64 = 1.7;
    /// Most places at which a log loses samples before another cause is likelier (judgement).
    pub(crate) const LOST_MOST: usize = 5;
    /// See [`JUMP_NOISE`].
    pub(crate) const JUMP_SHARE: f64 = 0.1;
    /// Number of samples on either side within which a jump may be a hand's, or a lost sample's: a release or a catch takes
    /// so long (judgement; a recording of another lab at 20 Hz begins with such a step).
    pub(crate) const JUMP_INSIDE: usize = 20;
    /// A jump also shows where the rate contradicts the step of the angle by this many usual contradictions.
    pub(crate) const JUMP_AGAINST_RATE: f64 = 20.0;
}

/// Channels that never change (`constant`).
pub(crate) mod constant {
    /// Largest number of levels of a command that is switched, and smallest of a speed that rises (judgement). A wheel
    /// that gains speed passes through more levels, or nothing can be fitted to it.
    pub(crate) const COMMAND_LEVELS: usize = 3;
    /// See [`COMMAND_LEVELS`].
    pub(crate) const SPEED_LEVELS: usize = 50;
    /// Range of a channel, in standard deviations of its noise, that is a motion: noise alone covers ten in a million
    /// lines.
    pub(crate) const MOVES: f64 = 30.0;
}

/// Logs with the same samples (`copies`).
pub(crate) mod copies {
    /// Number of consecutive equal samples that two recordings cannot share by chance.
    pub(crate) const IN_A_ROW: usize = 32;
    /// Two samples are the same if they differ by less than this share of the range of their stretch: the files may have
    /// other units and other digits. Noise of another recording differs by more, or it would not be seen in the file.
    pub(crate) const ROUNDED: f64 = 1e-4;
}

/// Joints that the experiment holds still (`held`).
pub(crate) mod held {
    /// Share of the body's speed that the sensor of a locked wheel may show through cross-coupling (judgement). A free
    /// wheel keeps its speed in space, and so shows the whole speed of the body.
    pub(crate) const LOCKED: f64 = 0.2;
    /// Range of the body's speed, as a share of the wheel's range of speeds, above which the body counts as moving. The
    /// equation of a spin-up, j_w (α̈ + φ̈) = τ u, is then wrong by about this share if the motion of the body is left
    /// out.
    pub(crate) const CLAMPED: f64 = 0.01;
    /// Range of the body's angle, rad, above which it is not clamped (judgement).
    pub(crate) const CLAMPED_RAD: f64 = 0.1;
    /// Range of the body's angle, rad, below which the motion is the play of a vice (judgement).
    pub(crate) const PLAY_RAD: f64 = 0.02;
    /// Motion in standard deviations of the noise that is no noise: noise alone covers 3.3 between the fifth and the
    /// ninety-fifth percentile.
    pub(crate) const OVER_NOISE: f64 = 10.0;
}

/// The law of a balance log (`law`).
pub(crate) mod law {
    /// Share of the current's variance that a linear law of the logged states must explain before it is
    /// compared with the stated law. Noise of the states and a delay of one step leave a larger share.
    pub(crate) const EXPLAINED: f64 = 0.9;
    /// Standard errors by which a gain must differ from 0: as [`super::fit::STANDARD_ERRORS`], with a margin for the noise
    /// of all three columns.
    pub(crate) const STANDARD_ERRORS: f64 = 10.0;
    /// Ratio of a gain to the stated one, in either direction, that noise of the states may cause (it draws the
    /// coefficients of a regression towards 0; judgement).
    pub(crate) const RATIO: f64 = 1.5;
    /// Share of the limit above which a current counts as clipped: the last step of a converter of 6 bits.
    pub(crate) const CLIPPED: f64 = 0.98;
    /// Largest delay, in samples, of the logged command against the states: one hold and one computation.
    pub(crate) const LATEST: usize = 2;
    /// Interval, s, with which no bench balances, and the number of samples of a controller of which nobody logs only one
    /// (judgement): both together show a time that is read a thousand times too large.
    pub(crate) const LONGEST_STEP_S: f64 = 0.5;
    /// See [`LONGEST_STEP_S`].
    pub(crate) const SPARSE: f64 = 100.0;
}

/// A sensor with a range of one turn (`sawtooth`).
pub(crate) mod sawtooth {
    /// Share of the range that a jump covers. The motion within one sample, by which a jump is shorter than a turn, must
    /// not be half a turn: then the way that was taken is unknown.
    pub(crate) const JUMP: f64 = 0.5;
    /// Fewest jumps that show a range: one may be a slip.
    pub(crate) const FEWEST: usize = 2;
    /// Share of the jumps that must fit, and how well they agree on the size of a turn: noise hides the motion about a
    /// jump now and then (judgement).
    pub(crate) const FITTING: f64 = 0.8;
    /// See [`FITTING`].
    pub(crate) const ALIKE: f64 = 0.05;
    /// Distance from a size that counts as this size: noise and the motion within a sample. The nearest two numbers of
    /// counts, 1000 and 1024, differ by 2.4 %; the message says that it may be another number.
    pub(crate) const NEAR: f64 = 0.03;
}

/// The wheel with its current (`wheel`).
pub(crate) mod wheel {
    /// Largest voltage of a bench supply, V: above 60 V, direct voltage is no longer safe to touch (IEC 61140).
    /// A motor with a higher back-EMF cannot have been driven to that speed.
    pub(crate) const SAFE_VOLTAGE_V: f64 = 60.0;
    /// Largest voltage of usual bench supplies, V.
    pub(crate) const USUAL_VOLTAGE_V: f64 = 48.0;
    /// Largest mechanical power of a bench motor, W: five times what 60 V and 3 A give.
    pub(crate) const BENCH_POWER_W: f64 = 1000.0;
    /// Largest current of a bench drive, A (judgement).
    pub(crate) const BENCH_CURRENT_A: f64 = 100.0;
    /// Speed of the fastest motors with a flywheel, rad/s: 15000 rpm.
    pub(crate) const FASTEST_RAD_S: f64 = 1570.0;
    /// Typical share of the inertia for wheels that were built for the purpose; used only to choose between two possible
    /// units (judgement: the thesis' wheel has 0.059).
    pub(crate) const USUAL_SHARE: f64 = 0.06;
    /// Ratio of the accelerations per ampere of two spin-ups, in either direction, that no effect of a motor causes
    /// (judgement: a dead zone that takes nine tenths of one current leaves a tenth of its torque).
    pub(crate) const NO_EFFECT: f64 = 20.0;
    /// Distance of the accelerations per ampere of two spin-ups, as a logarithm, up to which they agree: friction and a
    /// dead zone may take a third of a small current (judgement). The smallest ratio of two units is six.
    pub(crate) const ALIKE: f64 = 0.4;
    /// Largest noise below 0 of a speed that has no sign, in standard deviations.
    pub(crate) const BELOW_ZERO: f64 = 10.0;
    /// Ratio of a balance log's current to `current_limit` above which it is in another unit: the smallest ratio of two
    /// units of a current is a thousand, and a limit may be stated too small (judgement).
    pub(crate) const OVER_LIMIT: f64 = 20.0;
    /// Share of samples at the largest or smallest current from which they are a plateau, and the part of the range from
    /// which other samples are compared with it: a dead zone of a tenth of the limit then changes the ratio by 3 %.
    pub(crate) const PLATEAU: f64 = 0.02;
    /// See [`PLATEAU`].
    pub(crate) const BESIDE_PLATEAU: f64 = 0.5;
    /// Excess of the wheel's acceleration per ampere on the plateau from which the current went on where its sensor ended:
    /// that of a scale error ([`super::slips::NEAR`]).
    pub(crate) const EXCESS: f64 = super::slips::NEAR;
}

/// The proposal for files without a bench.toml (`propose`).
pub(crate) mod propose {
    /// Largest distance of the angle from upright, rad, in a log of balancing. A motor that recovers from 0.6 rad needs a
    /// torque of more than half of gravity's (judgement).
    pub(crate) const ABOUT_UPRIGHT: f64 = 0.6;
    /// Share of the amplitude up to which the rest position of a swing may differ from 0 without a question (judgement).
    pub(crate) const REST: f64 = 0.1;
    /// A wheel that travels against the body by less than this share of the body's travel is locked (judgement).
    pub(crate) const LOCKED: f64 = 0.1;
    /// Share by which the motion of a free wheel may differ from its own: friction and noise (judgement).
    pub(crate) const FREE: f64 = 0.1;
    /// A command counts as held if this share of its samples has the most frequent value (judgement).
    pub(crate) const HELD: f64 = 0.98;
    /// Fewest jumps by a turn that show its unit: one may be a slip.
    pub(crate) const JUMPS: usize = 2;
    /// Standard errors by which gravity must show before hanging and upright are told apart; below, the user is asked.
    pub(crate) const SHOWS: f64 = 3.0;
    /// Share of the lines of a column with a time's name that may go backwards: such a column is the time of a log that
    /// was started again, or of a counter that began anew, and reading it names the line (judgement).
    pub(crate) const FALLS: f64 = 0.01;
}

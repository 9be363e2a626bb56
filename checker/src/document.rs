//! CLAIMS.md: the claims, the engines that decide them, and the source of each constant.

use crate::certificate::claims::CLAIMS;
use crate::certificate::reader::Certificate;
use crate::language::module::Module;
use crate::prove::results::ClaimResult;

/// The text of CLAIMS.md for one emitted crate. `results` tells which engines settle a claim; times
/// and outcomes, which differ from machine to machine, are not in the text.
pub fn claims(certificate: &Certificate, module: &Module, results: &[ClaimResult]) -> String {
    let mut text = String::from(
        "# Claims\n\n\
         Written by the checker from the table that `flywheel prove` uses. A test holds this file\n\
         against that table.\n\n\
         | claim | statement | domain | assumptions | engines |\n|---|---|---|---|---|\n",
    );
    for claim in CLAIMS {
        let engines: Vec<&str> = results
            .iter()
            .filter(|result| result.id == claim.id)
            .map(|result| result.engine)
            .collect();
        let assumptions = if claim.assumptions.is_empty() {
            "none"
        } else {
            claim.assumptions
        };
        text.push_str(&format!(
            "| `{}` | {} | {} | {assumptions} | {} |\n",
            claim.id,
            claim.statement,
            claim.domain,
            engines.join(", ")
        ));
    }
    text.push_str(&format!(
        "\n# Where the constants of the control law come from\n\n\
         Parameters ({}) and weights give K; each constant is an entry of −K or the limit, rounded\n\
         to its format.\n\n\
         | constant | from | real | word | format | line | claims |\n|---|---|---|---|---|---|---|\n",
        certificate
            .parameters
            .iter()
            .map(|parameter| format!("`{}`", parameter.name))
            .collect::<Vec<_>>()
            .join(", ")
    ));
    for constant in &certificate.constants {
        text.push_str(&format!(
            "| `{}` | `{}` | {} {} | {} | / 2^{} | {}:{} | {} |\n",
            constant.name,
            constant.from,
            constant.real,
            constant.unit,
            constant.raw,
            constant.fraction_bits,
            constant.file,
            constant.line,
            constant.claims.join(", ")
        ));
    }
    text.push_str(
        "\n# Where the constants of sensors, filter and drive come from\n\n\
         Each word is the real number, which stands in `certificate.json`, rounded to its\n\
         format; `hardware-words` computes it again.\n\n\
         | word | from | value | format | line | claims |\n|---|---|---|---|---|---|\n",
    );
    for (file, constant) in BENCH {
        let words = module.constant_words(file, constant).unwrap_or_default();
        let line = module
            .constant_place(file, constant)
            .map_or(0, |place| place.line);
        for (name, value) in words {
            let Some((_, from, format, claims)) =
                TRACES.iter().find(|(start, ..)| name.starts_with(start))
            else {
                continue;
            };
            text.push_str(&format!(
                "| `{name}` | {from} | {value} | {format} | src/{file}.rs:{line} | {claims} |\n"
            ));
        }
    }
    text
}

/// The constants that hold a bench's numbers: file and name.
const BENCH: [(&str, &str); 19] = [
    ("constants", "FILTER"),
    ("constants", "MOUNTING_ANGLE"),
    ("constants", "ANGLE_FACTOR"),
    ("constants", "ANGLE_SHIFT"),
    ("constants", "ANGLE_MAX"),
    ("constants", "RATE_LINE"),
    ("constants", "BODY_ENCODER"),
    ("constants", "BODY_ZERO"),
    ("constants", "BODY_ANGLE_LINE"),
    ("constants", "BODY_RATE_LINE"),
    ("constants", "HOLDING_LINE"),
    ("constants", "WHEEL_SPEED_LINE"),
    ("constants", "WHEEL_ENCODER"),
    ("constants", "DUTY_LINE"),
    ("constants", "DUTY_PLANE"),
    ("constants", "ZERO_CURRENT"),
    ("constants", "BIAS_OBSERVER"),
    ("constants", "LIMITS"),
    ("constants", "SAMPLE_TIME_US"),
];

/// Claims that speak of every word of the filter.
const OF_FILTER: &str = "hardware-words, filter-total, filter-accurate, step-total";
/// Claims that speak of every word of the lines into and out of the control law.
const OF_LINES: &str = "hardware-words, step-total";

/// Claims that speak of the numbers of the supervisor.
const OF_SUPERVISOR: &str = "supervisor, step-total";

/// The beginning of the word's name, the source of its number, its format, and the claims about it.
const TRACES: [(&str, &str, &str, &str); 33] = [
    (
        "FILTER.accel_clip",
        "accelerometer: counts where it clips",
        "counts",
        OF_FILTER,
    ),
    (
        "FILTER.mag_clip",
        "magnetometer: counts where it clips",
        "counts",
        OF_FILTER,
    ),
    (
        "FILTER.drift.gain",
        "T over the time constant with which the filter follows the gyroscope's drift",
        "/ 2^(28 + shift)",
        OF_FILTER,
    ),
    (
        "FILTER.drift",
        "shift: fraction bits of the drift beyond those of a turn; limit: the largest drift, as a half-angle in a step",
        "/ 2^(32 + shift)",
        OF_FILTER,
    ),
    (
        "LIMITS.angle",
        "arm: the angle at which the largest current holds the body, asin(B2 I/A21); trip: twice that angle",
        "word of the angle",
        OF_SUPERVISOR,
    ),
    (
        "LIMITS.rate_arm",
        "a quarter of that angle times sqrt(A21)",
        "word of the rate",
        OF_SUPERVISOR,
    ),
    (
        "LIMITS.saturated_steps",
        "largest wheel speed over (B2 + B3) I",
        "steps",
        OF_SUPERVISOR,
    ),
    (
        "LIMITS",
        "the stated times, the ends of the sensors, and shares of gravity",
        "steps, counts, accelerometer units",
        OF_SUPERVISOR,
    ),
    ("SAMPLE_TIME_US", "sample time", "µs", OF_SUPERVISOR),
    (
        "FILTER.gyro.bias",
        "gyroscope: bias in counts",
        "/ 2^15",
        OF_FILTER,
    ),
    (
        "FILTER.gyro.shift",
        "gyroscope: bits beyond the output",
        "bits",
        OF_FILTER,
    ),
    (
        "FILTER.gyro.half_unit",
        "gyroscope: 2^shift / 2 + 1",
        "integer",
        OF_FILTER,
    ),
    (
        "FILTER.gyro",
        "gyroscope: matrix in rad/s per count, times T/2",
        "/ 2^(49 + shift)",
        OF_FILTER,
    ),
    (
        "FILTER.accel.bias",
        "accelerometer: bias in counts",
        "/ 2^15",
        OF_FILTER,
    ),
    (
        "FILTER.accel.shift",
        "accelerometer: bits beyond the output",
        "bits",
        OF_FILTER,
    ),
    (
        "FILTER.accel.half_unit",
        "accelerometer: 2^shift / 2 + 1",
        "integer",
        OF_FILTER,
    ),
    (
        "FILTER.accel",
        "accelerometer: matrix over its largest row",
        "/ 2^(30 + shift)",
        OF_FILTER,
    ),
    (
        "FILTER.mag.bias",
        "magnetometer: bias in counts",
        "/ 2^15",
        OF_FILTER,
    ),
    (
        "FILTER.mag.shift",
        "magnetometer: bits beyond the output",
        "bits",
        OF_FILTER,
    ),
    (
        "FILTER.mag.half_unit",
        "magnetometer: 2^shift / 2 + 1",
        "integer",
        OF_FILTER,
    ),
    (
        "FILTER.mag",
        "magnetometer: matrix over its largest row",
        "/ 2^(30 + shift)",
        OF_FILTER,
    ),
    (
        "FILTER.gravity_squared_min",
        "(gravity / 8)² in the accelerometer's units",
        "units of 2^32",
        OF_FILTER,
    ),
    (
        "FILTER.field_squared_min",
        "(weakest usable field)² in the magnetometer's units",
        "units of 2^32",
        OF_FILTER,
    ),
    (
        "FILTER.lever_arm",
        "lever arm in m, over T² in the accelerometer's units",
        "/ 2^16",
        OF_FILTER,
    ),
    ("FILTER.beta", "beta in rad/s, times T", "/ 2^35", OF_FILTER),
    (
        "MOUNTING_ANGLE",
        "mounting angle in rad",
        "/ 2^28",
        OF_LINES,
    ),
    (
        "ANGLE_",
        "factor and shift from rad / 2^28 to the word of the angle; max: the largest angle, less the bias",
        "integer",
        OF_LINES,
    ),
    (
        "BIAS_OBSERVER",
        "`bias_observer` of the certificate; zero where it is null",
        "products of equal fraction bits",
        "hardware-words, step-total, bias-observer-stable",
    ),
    (
        "BODY_ENCODER",
        "wrap and window of the encoder; by how much a step may turn further than the one before",
        "counts, steps",
        "encoder-exact, step-total",
    ),
    (
        "BODY_ZERO",
        "the count with the body upright",
        "counts",
        OF_LINES,
    ),
    (
        "WHEEL_ENCODER",
        "wrap and window of the encoder; by how much a step may turn further than the one before",
        "counts, steps",
        "encoder-exact, step-total",
    ),
    (
        "ZERO_CURRENT",
        "duty at zero current",
        "counts",
        "certificate-consistent, step-total",
    ),
    (
        "",
        "the documented line: slope; offset, plus one half for rounding; and both ends",
        "over 2^shift",
        OF_LINES,
    ),
];

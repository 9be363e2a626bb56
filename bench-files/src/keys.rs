//! Every key of bench.toml, model.toml and an own effect's file, stated once: the readers allow these keys and
//! no others, and the guide prints them.

use serde::Serialize;

/// A key that a file may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// The SI unit of its value; empty where it has none.
    pub unit: &'static str,
    /// What holds where the key is left out; "needed" where it cannot be left out.
    pub default: &'static str,
    /// The line as a person would write it.
    pub example: &'static str,
    /// What it says.
    pub meaning: &'static str,
}

/// A section of a file with its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct KeySection {
    /// Its name as a reader finds it: `known`, `hardware.drive`. A section whose keys depend on `kind` stands once
    /// for each kind, as `hardware.drive, voltage`.
    pub name: &'static str,
    /// The line that opens it.
    pub heading: &'static str,
    /// What it is for.
    pub meaning: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
}

/// Shortens the tables below.
const fn key(
    name: &'static str,
    unit: &'static str,
    default: &'static str,
    example: &'static str,
    meaning: &'static str,
) -> Key {
    Key {
        name,
        unit,
        default,
        example,
        meaning,
    }
}

/// What a key is where it has to be there.
const NEEDED: &str = "needed";

/// Keys of an inertial sensor, of which each kind has these.
const INERTIAL: [Key; 8] = [
    key(
        "part",
        "",
        "none",
        "part = \"FXAS21002\"",
        "a part whose data sheet is known here; the other keys override what it says",
    ),
    key(
        "scale",
        "rad/s, m/s² or µT per count",
        "from `part`",
        "scale = 1.0908308e-3",
        "what one count means",
    ),
    key("bits", "", "16", "bits = 12", "width of the sensor's word"),
    key(
        "justified",
        "",
        "\"right\"",
        "justified = \"left\"",
        "at which end of the 16-bit word a narrower word stands",
    ),
    key(
        "clip",
        "counts",
        "the ends of the word",
        "clip = [32767, 32767, 32767]",
        "reading at which each axis clips",
    ),
    key(
        "rate",
        "1/s",
        "from `part`",
        "rate = 800.0",
        "fresh samples a second",
    ),
    key(
        "axes",
        "",
        "[\"x\", \"y\", \"z\"]",
        "axes = [\"y\", \"-x\", \"z\"]",
        "the body axis that each sensor axis shows; \"-y\" is reversed. Body x runs from the pivot to the centre of mass, z along the pivot",
    ),
    key(
        "rotation",
        "",
        "from `axes`",
        "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "the same as a matrix, sensor to body, of determinant +1; instead of `axes`",
    ),
];

/// The accelerometer has one more.
const ACCELEROMETER: [Key; 9] = {
    let mut keys = [INERTIAL[0]; 9];
    let mut k = 0;
    while k < INERTIAL.len() {
        keys[k] = INERTIAL[k];
        k += 1;
    }
    keys[8] = key(
        "lever_arm",
        "m",
        "[0, 0]",
        "lever_arm = [0.05, 0.0]",
        "where the sensor sits: from the pivot, along body x and y",
    );
    keys
};

/// Keys that every drive has.
const DRIVE: [Key; 7] = [
    key(
        "kind",
        "",
        "from `part`",
        "kind = \"current\"",
        "what the duty sets: \"current\" or \"voltage\"",
    ),
    key(
        "part",
        "",
        "none",
        "part = \"ESCON 24/2\"",
        "a drive whose data sheet is known here",
    ),
    key(
        "bits",
        "",
        "from `part`, else 16",
        "bits = 12",
        "width of the timer that makes the duty",
    ),
    key(
        "duty_zero",
        "counts",
        "from `part`",
        "duty_zero = 32768",
        "the duty of no current",
    ),
    key(
        "duty_low",
        "counts",
        "from `part`",
        "duty_low = 6554",
        "the smallest duty that may be sent",
    ),
    key(
        "duty_high",
        "counts",
        "from `part`",
        "duty_high = 58982",
        "the largest duty that may be sent",
    ),
    key(
        "amperes_per_count",
        "A",
        "from `[calibration]`",
        "amperes_per_count = 8.39246e-5",
        "current (voltage drive: of the full supply) a count; negative where the PWM is inverted",
    ),
];

/// A voltage drive has two more.
const VOLTAGE_DRIVE: [Key; 9] = {
    let mut keys = [DRIVE[0]; 9];
    let mut k = 0;
    while k < DRIVE.len() {
        keys[k] = DRIVE[k];
        k += 1;
    }
    keys[7] = key(
        "supply_voltage",
        "V",
        NEEDED,
        "supply_voltage = 12.0",
        "largest voltage either way",
    );
    keys[8] = key(
        "winding_resistance",
        "Ohm",
        NEEDED,
        "winding_resistance = 1.2",
        "R in V = R u + τ φ̇",
    );
    keys
};

/// The sections of bench.toml.
pub const BENCH: &[KeySection] = &[
    KeySection {
        name: "bench",
        heading: "[bench]",
        meaning: "The bench itself.",
        keys: &[key(
            "name",
            "",
            "the folder's name",
            "name = \"my bench\"",
            "its name in reports",
        )],
    },
    KeySection {
        name: "known",
        heading: "[known]",
        meaning: "What was measured with ruler, scales and data sheet. Each may be missing; without masses and lengths torques are found per unit of inertia.",
        keys: &[
            key(
                "gravity",
                "m/s²",
                "none",
                "gravity = 9.81",
                "local gravity; it is never assumed",
            ),
            key(
                "torque_constant",
                "N m/A",
                "none",
                "torque_constant = 0.0335",
                "torque of the motor for each ampere",
            ),
            key(
                "body_mass",
                "kg",
                "none",
                "body_mass = 0.2",
                "body without the wheel",
            ),
            key(
                "wheel_mass",
                "kg",
                "none",
                "wheel_mass = 0.106",
                "wheel with everything that turns with it",
            ),
            key(
                "pivot_to_wheel",
                "m",
                "none",
                "pivot_to_wheel = 0.085",
                "from the pivot to the wheel's axis",
            ),
            key(
                "pivot_to_com",
                "m",
                "none",
                "pivot_to_com = 0.0799",
                "from the pivot to the body's own centre of mass; negative above it",
            ),
            key(
                "gravity_torque",
                "N m",
                "from masses and lengths",
                "gravity_torque = 0.2451",
                "G, the torque of gravity with the body level, as one number",
            ),
            key(
                "total_inertia",
                "kg m²",
                "fitted",
                "total_inertia = 2.3e-3",
                "Θ about the pivot, where another experiment gave it",
            ),
            key(
                "wheel_inertia",
                "kg m²",
                "fitted",
                "wheel_inertia = 1.36e-4",
                "j_w about the wheel's axis, likewise",
            ),
            key(
                "body_inertia",
                "kg m²",
                "follows from Θ",
                "body_inertia = 5.0e-4",
                "j_b about the body's centre of mass, likewise",
            ),
        ],
    },
    KeySection {
        name: "controller",
        heading: "[controller]",
        meaning: "The controller under which the balance logs were recorded: u = −K (angle − π, rate, wheel speed), clipped. Only balance logs need it.",
        keys: &[
            key(
                "gains",
                "A/rad, A s/rad, A s/rad",
                NEEDED,
                "gains = [-24.27, -2.13, -0.0226]",
                "K",
            ),
            key(
                "current_limit",
                "A",
                NEEDED,
                "current_limit = 2.0",
                "largest current either way",
            ),
            key(
                "sample_time",
                "s",
                NEEDED,
                "sample_time = 0.001",
                "time between two commands",
            ),
        ],
    },
    KeySection {
        name: "experiment",
        heading: "[[experiment]]",
        meaning: "One recording; the section stands once for each.",
        keys: &[
            key(
                "name",
                "",
                NEEDED,
                "name = \"free swing 20 deg\"",
                "its name in reports and figures; no two alike",
            ),
            key(
                "kind",
                "",
                NEEDED,
                "kind = \"free-swing\"",
                "\"free-swing\" (wheel locked, hanging), \"spin-up\" (body clamped), \"balance\" (upright, under a controller), \"driven\" (everything free, hanging, open loop)",
            ),
            key(
                "file",
                "",
                NEEDED,
                "file = \"free-swing-20deg.csv\"",
                "the log, from the bench folder",
            ),
            key(
                "columns",
                "",
                "the standard names",
                "columns = { time = \"t\", angle = \"pend\" }",
                "which column is which; standard names are `time_s`, `angle_rad`, `rate_rad_s`, `wheel_speed_rad_s`, `wheel_angle_rad`, `current_A`",
            ),
            key(
                "units",
                "",
                "SI",
                "units = { time = \"ms\", angle = \"deg\", wheel_speed = \"rpm\", current = \"mA\" }",
                "the unit of a column",
            ),
            key(
                "scale",
                "",
                "1",
                "scale = { angle = 0.5 }",
                "a factor: value = sign · scale · (column in SI) + offset",
            ),
            key(
                "sign",
                "",
                "1",
                "sign = { angle = -1 }",
                "where the column counts the other way",
            ),
            key(
                "offset",
                "SI unit of the column",
                "0",
                "offset = { angle = 3.14159265 }",
                "what is added, after sign and scale",
            ),
            key(
                "constants",
                "A",
                "none",
                "constants = { current = 0.6 }",
                "a current that was held and not logged",
            ),
            key(
                "current_meaning",
                "",
                "\"command\"",
                "current_meaning = \"measured\"",
                "whether the current is what was asked for or what flowed",
            ),
            key(
                "from",
                "s",
                "the log's start",
                "from = 8.0",
                "where the part that is used begins",
            ),
            key(
                "until",
                "s",
                "the log's end",
                "until = 60.0",
                "where it ends",
            ),
            key(
                "time_step",
                "s",
                "none",
                "time_step = 0.005",
                "from line to line, where there is no time column",
            ),
            key(
                "accept",
                "",
                "none",
                "accept = [\"rate-factor\"]",
                "findings of `flywheel check` that this experiment may have",
            ),
        ],
    },
    KeySection {
        name: "calibration",
        heading: "[calibration]",
        meaning: "Recordings of raw counts for `flywheel calibrate`. Each may be missing.",
        keys: &[
            key(
                "accelerometer",
                "",
                "none",
                "accelerometer = [\"x-up.csv\", \"x-down.csv\"]",
                "still poses, six or more: `ax ay az`",
            ),
            key(
                "gyroscope",
                "",
                "none",
                "gyroscope = \"still.csv\"",
                "at rest: `gx gy gz`",
            ),
            key(
                "magnetometer",
                "",
                "none",
                "magnetometer = \"all-round.csv\"",
                "turned into all directions: `mx my mz`",
            ),
            key(
                "swing",
                "",
                "none",
                "swing = \"swing.csv\"",
                "wheel locked, swinging freely: `gx gy gz`; with `ax ay az` the sensor's place is found too",
            ),
            key(
                "hanging",
                "",
                "none",
                "hanging = \"hanging.csv\"",
                "at rest, hanging: `ax ay az`",
            ),
            key(
                "wheel_speed",
                "",
                "none",
                "wheel_speed = \"converter.csv\"",
                "`adc_count` and `wheel_speed_rad_s`, by a tachometer",
            ),
            key(
                "current",
                "",
                "none",
                "current = \"drive.csv\"",
                "`duty` and `current_A`, by an ammeter",
            ),
            key(
                "gyroscope_scale",
                "rad/s per count",
                "needed beside `gyroscope`",
                "gyroscope_scale = 1.0908308e-3",
                "from the data sheet",
            ),
            key(
                "sample_time",
                "s",
                "needed beside `gyroscope`",
                "sample_time = 0.001",
                "of the still and the swing recording",
            ),
            key(
                "field",
                "µT",
                "0.1 µT per count",
                "field = 48.9",
                "strength of the local magnetic field",
            ),
            key(
                "lever_arm",
                "m",
                "from the swing",
                "lever_arm = [0.05, 0.0]",
                "accelerometer from the pivot by a ruler, along the sensor's x and y",
            ),
            key(
                "lever_arm_std",
                "m",
                "needed beside `lever_arm`",
                "lever_arm_std = 0.001",
                "standard error of that",
            ),
            key(
                "columns",
                "",
                "the names above",
                "columns = { ax = \"acc_x\" }",
                "where the header differs",
            ),
            key(
                "plumb_lines",
                "",
                "none",
                "[calibration.plumb_lines]",
                "the section below",
            ),
        ],
    },
    KeySection {
        name: "calibration.plumb_lines",
        heading: "[calibration.plumb_lines]",
        meaning: "The body's centre of mass from plumb lines that were drawn on it, in a drawing fixed to the body.",
        keys: &[
            key(
                "pivot",
                "m",
                NEEDED,
                "pivot = [0.0, 0.0]",
                "the pivot in the drawing",
            ),
            key(
                "std",
                "m",
                NEEDED,
                "std = 0.0005",
                "standard error of a mark",
            ),
            key(
                "lines",
                "m",
                NEEDED,
                "lines = [[[0.1, 0.0], [0.02, -0.13]], [[-0.1, 0.0], [-0.01, -0.13]]]",
                "two marks on each line",
            ),
        ],
    },
    KeySection {
        name: "hardware",
        heading: "[hardware]",
        meaning: "The sensors and the drive on which the controller will run, copied into model.toml. Each is a section of its own.",
        keys: &[
            key(
                "gyroscope",
                "",
                "none",
                "[hardware.gyroscope]",
                "the section below",
            ),
            key(
                "accelerometer",
                "",
                "none",
                "[hardware.accelerometer]",
                "likewise",
            ),
            key(
                "magnetometer",
                "",
                "none",
                "[hardware.magnetometer]",
                "likewise",
            ),
            key(
                "wheel_speed",
                "",
                "none",
                "[hardware.wheel_speed]",
                "likewise",
            ),
            key("angle", "", "none", "[hardware.angle]", "likewise"),
            key("drive", "", "none", "[hardware.drive]", "likewise"),
        ],
    },
    KeySection {
        name: "hardware.gyroscope",
        heading: "[hardware.gyroscope], [hardware.magnetometer]",
        meaning: "An inertial sensor: what its raw counts mean.",
        keys: &INERTIAL,
    },
    KeySection {
        name: "hardware.accelerometer",
        heading: "[hardware.accelerometer]",
        meaning: "The accelerometer, which also says where it sits.",
        keys: &ACCELEROMETER,
    },
    KeySection {
        name: "hardware.wheel_speed, converter",
        heading: "[hardware.wheel_speed]  kind = \"converter\"",
        meaning: "The wheel's speed as a voltage that a converter reads.",
        keys: &[
            key(
                "kind",
                "",
                NEEDED,
                "kind = \"converter\"",
                "how the speed comes in",
            ),
            key(
                "slope",
                "rad/s per count",
                NEEDED,
                "slope = 0.4",
                "speed = slope · count + offset",
            ),
            key(
                "offset",
                "rad/s",
                NEEDED,
                "offset = -819.2",
                "the speed at count 0",
            ),
            key(
                "low",
                "counts",
                NEEDED,
                "low = 0",
                "lower end of the converter's range",
            ),
            key("high", "counts", NEEDED, "high = 4095", "upper end"),
        ],
    },
    KeySection {
        name: "hardware.wheel_speed, encoder",
        heading: "[hardware.wheel_speed]  kind = \"encoder\"",
        meaning: "The wheel's angle as a count that wraps; the speed is its difference over some samples.",
        keys: &[
            key(
                "kind",
                "",
                NEEDED,
                "kind = \"encoder\"",
                "how the speed comes in",
            ),
            key(
                "part",
                "",
                "none",
                "part = \"AS5600\"",
                "an encoder whose data sheet is known here",
            ),
            key(
                "counts_per_turn",
                "",
                "from `part`",
                "counts_per_turn = 4096",
                "negative where it counts backwards",
            ),
            key(
                "bits",
                "",
                "from `part`, else 16",
                "bits = 12",
                "the count wraps at 2^bits",
            ),
            key(
                "window",
                "samples",
                NEEDED,
                "window = 8",
                "speed = difference over so many samples",
            ),
            key(
                "largest",
                "rad/s",
                "what the sensor shows, or where a voltage drive's supply ends",
                "largest = 700.0",
                "largest speed of the wheel; at 105 % of it the motor is switched off",
            ),
        ],
    },
    KeySection {
        name: "hardware.wheel_speed, driver",
        heading: "[hardware.wheel_speed]  kind = \"driver\"",
        meaning: "The wheel's speed as a number that the motor's driver sends.",
        keys: &[
            key(
                "kind",
                "",
                NEEDED,
                "kind = \"driver\"",
                "how the speed comes in",
            ),
            key(
                "scale",
                "rad/s per unit",
                NEEDED,
                "scale = 0.1047",
                "what one unit means; negative where it counts backwards",
            ),
            key(
                "largest",
                "rad/s",
                "what the sensor shows, or where a voltage drive's supply ends",
                "largest = 700.0",
                "largest speed of the wheel; at 105 % of it the motor is switched off",
            ),
        ],
    },
    KeySection {
        name: "hardware.angle, inertial",
        heading: "[hardware.angle]  kind = \"inertial\"",
        meaning: "The body's angle from gyroscope and accelerometer.",
        keys: &[key(
            "kind",
            "",
            NEEDED,
            "kind = \"inertial\"",
            "how the angle comes in",
        )],
    },
    KeySection {
        name: "hardware.angle, encoder",
        heading: "[hardware.angle]  kind = \"encoder\"",
        meaning: "The body's angle from an encoder at the pivot.",
        keys: &[
            key(
                "kind",
                "",
                NEEDED,
                "kind = \"encoder\"",
                "how the angle comes in",
            ),
            key(
                "part",
                "",
                "none",
                "part = \"AS5600\"",
                "an encoder whose data sheet is known here",
            ),
            key(
                "counts_per_turn",
                "",
                "from `part`",
                "counts_per_turn = 4096",
                "negative where it counts backwards",
            ),
            key(
                "bits",
                "",
                "from `part`, else 16",
                "bits = 12",
                "the count wraps at 2^bits",
            ),
            key(
                "zero",
                "counts",
                NEEDED,
                "zero = 2048",
                "the count with the body upright",
            ),
        ],
    },
    KeySection {
        name: "hardware.drive, current",
        heading: "[hardware.drive]  kind = \"current\"",
        meaning: "A drive that closes the current loop itself.",
        keys: &DRIVE,
    },
    KeySection {
        name: "hardware.drive, voltage",
        heading: "[hardware.drive]  kind = \"voltage\"",
        meaning: "A drive that sets the motor's voltage.",
        keys: &VOLTAGE_DRIVE,
    },
    KeySection {
        name: "bring_up",
        heading: "[bring_up]",
        meaning: "Recordings of raw counts, with the columns `gx gy gz ax ay az wheel duty time_s`, which show which way is positive.",
        keys: &[
            key(
                "hanging",
                "",
                NEEDED,
                "hanging = \"hanging.csv\"",
                "hanging still",
            ),
            key(
                "tilted",
                "",
                NEEDED,
                "tilted = \"tilted.csv\"",
                "tilted by hand towards positive angles",
            ),
            key(
                "wheel_spun",
                "",
                NEEDED,
                "wheel_spun = \"wheel-spun.csv\"",
                "the wheel spun by hand in the sense of positive angles",
            ),
            key(
                "current_step",
                "",
                NEEDED,
                "current_step = \"current-step.csv\"",
                "a small positive current, the body held",
            ),
        ],
    },
];

/// The sections of model.toml beside `[hardware]`, which is as in bench.toml.
pub const MODEL: &[KeySection] = &[
    KeySection {
        name: "parameters",
        heading: "[parameters.total_inertia]",
        meaning: "A parameter; the section stands once for each, under its name.",
        keys: &[
            key("value", "`unit`", NEEDED, "value = 2.30344e-3", "its value"),
            key(
                "std",
                "`unit`",
                "taken as exact",
                "std = 1.2e-6",
                "its standard error",
            ),
            key(
                "unit",
                "",
                "SI",
                "unit = \"kg m2\"",
                "the SI unit; \"… per kg m2\" where torques are known per unit of inertia only",
            ),
            key(
                "source",
                "",
                "empty",
                "source = \"free swing 20 deg\"",
                "where the value comes from",
            ),
        ],
    },
    KeySection {
        name: "correlation",
        heading: "[correlation]",
        meaning: "How the errors of the parameters hang together.",
        keys: &[
            key(
                "parameters",
                "",
                NEEDED,
                "parameters = [\"total_inertia\", \"body_viscous_friction\"]",
                "the order of rows and columns",
            ),
            key(
                "matrix",
                "",
                NEEDED,
                "matrix = [[1.0, 0.2], [0.2, 1.0]]",
                "correlation coefficients",
            ),
        ],
    },
    KeySection {
        name: "effects",
        heading: "[effects]",
        meaning: "What the model holds.",
        keys: &[
            key(
                "present",
                "",
                "the base model",
                "present = [\"body-viscous-friction\", \"wheel-viscous-friction\"]",
                "the effects in the model",
            ),
            key(
                "provisional",
                "",
                "none",
                "provisional = [\"wheel-coulomb-friction\"]",
                "those of them that explain no better than their rivals",
            ),
            key(
                "rivals",
                "",
                "none",
                "rivals = [[\"current-offset\"]]",
                "what explains as well",
            ),
            key(
                "unseen_upright",
                "",
                "none",
                "unseen_upright = [\"own:magnet\"]",
                "own effects that no log has shown upright: the linear model does without them",
            ),
        ],
    },
    KeySection {
        name: "learned",
        heading: "[learned.angle]",
        meaning: "A torque that was learned as a curve over a coordinate: `angle`, `rate` (on the body), `wheel_speed`, \
                  `wheel_angle` (on the wheel). Between its knots lies a cubic spline, outside it is constant.",
        keys: &[
            key(
                "knots",
                "unit of the coordinate",
                NEEDED,
                "knots = [-0.3, -0.1, 0.1, 0.3]",
                "4 to 24 values of the coordinate, increasing",
            ),
            key(
                "torque",
                "N m",
                NEEDED,
                "torque = [0.0, 1e-4, -1e-4, 0.0]",
                "the torque there, as it acts",
            ),
            key(
                "std",
                "N m",
                "taken as exact",
                "std = [1e-5, 1e-5, 1e-5, 1e-5]",
                "their standard errors",
            ),
            key(
                "unit",
                "",
                "N m",
                "unit = \"N m per kg m2\"",
                "where torques are known per unit of inertia only",
            ),
            key(
                "source",
                "",
                "empty",
                "source = \"free swing 20 deg\"",
                "where the curve comes from",
            ),
        ],
    },
    KeySection {
        name: "design",
        heading: "[design]",
        meaning: "What the controller is designed for.",
        keys: &[
            key(
                "sample_time",
                "s",
                NEEDED,
                "sample_time = 0.001",
                "time between two commands",
            ),
            key(
                "state_weights",
                "1/rad², s²/rad², s²/rad²",
                NEEDED,
                "state_weights = [25.0, 0.5, 5e-4]",
                "diagonal of Q: angle, rate, wheel speed",
            ),
            key(
                "current_weight",
                "1/A²",
                NEEDED,
                "current_weight = 1.0",
                "R",
            ),
            key(
                "current_limit",
                "A",
                NEEDED,
                "current_limit = 2.0",
                "largest current either way",
            ),
            key(
                "friction_linearisation_speed",
                "rad/s",
                "friction is left out",
                "friction_linearisation_speed = 0.0846768",
                "ι: dry friction of the body enters the linear model as μ/ι",
            ),
            key(
                "bias_time_constant",
                "s",
                "no observer",
                "bias_time_constant = 2.0",
                "time constant of an observer that finds a constant bias of the angle",
            ),
        ],
    },
    KeySection {
        name: "calibration",
        heading: "[calibration]",
        meaning: "What `flywheel calibrate` found; it goes before `[hardware]`.",
        keys: &[
            key(
                "accelerometer",
                "",
                "none",
                "[calibration.accelerometer]",
                "bias and matrix, counts to m/s²",
            ),
            key(
                "gyroscope",
                "",
                "none",
                "[calibration.gyroscope]",
                "likewise, counts to rad/s, with the filter's `beta`",
            ),
            key(
                "magnetometer",
                "",
                "none",
                "[calibration.magnetometer]",
                "likewise, counts to µT",
            ),
            key(
                "mounting",
                "",
                "none",
                "[calibration.mounting]",
                "`axis`: body z in the sensor's frame; `angle` about it",
            ),
            key(
                "lever_arm",
                "",
                "none",
                "[calibration.lever_arm]",
                "`position` of the accelerometer",
            ),
            key(
                "wheel_speed",
                "",
                "none",
                "[calibration.wheel_speed]",
                "`slope` and `offset` of the converter",
            ),
            key(
                "current",
                "",
                "none",
                "[calibration.current]",
                "`slope` and `offset` of the drive",
            ),
        ],
    },
];

/// The file of an effect of one's own, `effects/NAME.toml`; in model.toml it stands as `[own.NAME]`.
pub const OWN_EFFECT: &[KeySection] = &[
    KeySection {
        name: "own",
        heading: "effects/NAME.toml",
        meaning: "An effect in a formula. Every other key is a definition that the torque may use.",
        keys: &[
            key(
                "role",
                "",
                NEEDED,
                "role = \"body\"",
                "on what the torque acts: \"body\" or \"wheel\"",
            ),
            key(
                "torque",
                "N m",
                NEEDED,
                "torque = \"a*z*exp(-z^2)\"",
                "the torque as it acts, positive towards positive angles",
            ),
            key(
                "fingerprint",
                "",
                "none",
                "fingerprint = \"a bump in the torque at one angle\"",
                "what to look for, one sentence",
            ),
            key(
                "parameters",
                "",
                NEEDED,
                "[parameters.a]",
                "the section below, once for each parameter",
            ),
        ],
    },
    KeySection {
        name: "own.parameters",
        heading: "[parameters.a]",
        meaning: "A parameter of the formula.",
        keys: &[
            key("unit", "", NEEDED, "unit = \"N m\"", "its SI unit"),
            key(
                "start",
                "`unit`",
                NEEDED,
                "start = [0.1, 0.2]",
                "where the fit begins; several where one may lead nowhere",
            ),
            key(
                "bounds",
                "`unit`",
                "none",
                "bounds = [-0.5, 0.5]",
                "the range that it may have",
            ),
        ],
    },
];

/// The names of the keys that a section may have.
///
/// # Panics
/// Never for a section of the tables above, and the readers name no others: a test reads each.
pub(crate) fn names(sections: &[KeySection], section: &str) -> Vec<&'static str> {
    sections
        .iter()
        .find(|one| one.name == section)
        .map(|one| one.keys.iter().map(|key| key.name).collect())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml_edit::DocumentMut;

    /// Each example is TOML that sets its key; a section's name stands for itself.
    #[test]
    fn examples_set_their_keys() {
        for section in BENCH.iter().chain(MODEL).chain(OWN_EFFECT) {
            assert!(!section.keys.is_empty(), "{}", section.name);
            for key in section.keys {
                let document: DocumentMut = key
                    .example
                    .parse()
                    .unwrap_or_else(|error| panic!("{} {}: {error}", section.name, key.example));
                let place = if key.example.starts_with('[') {
                    let inside = key.example.trim_matches(['[', ']']);
                    assert!(
                        inside.ends_with(&format!(".{}", key.name))
                            || inside.starts_with(&format!("{}.", key.name)),
                        "{}",
                        key.example
                    );
                    continue;
                } else {
                    document.as_table().contains_key(key.name)
                };
                assert!(place, "{} does not set {}", key.example, key.name);
            }
        }
    }

    /// The readers ask for sections by name: one that is not there would allow nothing.
    #[test]
    fn sections_have_one_name_each() {
        for list in [BENCH, MODEL, OWN_EFFECT] {
            for (index, section) in list.iter().enumerate() {
                assert_eq!(names(list, section.name).len(), section.keys.len());
                assert!(list[..index].iter().all(|one| one.name != section.name));
            }
        }
        assert!(names(BENCH, "unheard of").is_empty());
    }
}

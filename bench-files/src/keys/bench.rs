//! The sections of bench.toml beside `[hardware]`.

use super::{KeySection, NEEDED, key};

/// `[bench]`.
pub(super) const BENCH: KeySection = KeySection {
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
};

/// `[known]`.
pub(super) const KNOWN: KeySection = KeySection {
    name: "known",
    heading: "[known]",
    meaning: "Constants measured with ruler and scales, or taken from data sheets. Each may be missing; without masses and lengths torques are found per unit of inertia.",
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
            "G, the torque of gravity with the body horizontal, as one number",
        ),
        key(
            "total_inertia",
            "kg m²",
            "fitted",
            "total_inertia = 2.3e-3",
            "Θ about the pivot, if known from another experiment",
        ),
        key(
            "wheel_inertia",
            "kg m²",
            "fitted",
            "wheel_inertia = 1.36e-4",
            "j_w about the wheel's axis, if known from another experiment",
        ),
        key(
            "body_inertia",
            "kg m²",
            "follows from Θ",
            "body_inertia = 5.0e-4",
            "j_b about the body's centre of mass, if known from another experiment",
        ),
    ],
};

/// `[controller]`.
pub(super) const CONTROLLER: KeySection = KeySection {
    name: "controller",
    heading: "[controller]",
    meaning: "The controller under which the balance logs were recorded: u = −K (angle − π, rate, wheel speed), clipped. It tells the check of a balance log how current and motion belong together; a balance log is also read without it.",
    keys: &[
        key(
            "gains",
            "A/rad, A s/rad, A s/rad",
            NEEDED,
            "gains = [-24.27, -2.13, -0.0226]",
            "the gains K",
        ),
        key(
            "current_limit",
            "A",
            NEEDED,
            "current_limit = 2.0",
            "largest current in either direction",
        ),
        key(
            "sample_time",
            "s",
            NEEDED,
            "sample_time = 0.001",
            "time between two commands",
        ),
    ],
};

/// `[[experiment]]`.
pub(super) const EXPERIMENT: KeySection = KeySection {
    name: "experiment",
    heading: "[[experiment]]",
    meaning: "One recording; every recording has a section of its own.",
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
            "the column of each channel; the standard names are `time_s`, `angle_rad`, `rate_rad_s`, `wheel_speed_rad_s`, `wheel_angle_rad`, `current_A`",
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
            "-1 for a column that is positive in the opposite sense",
        ),
        key(
            "offset",
            "SI unit of the column",
            "0",
            "offset = { angle = 3.14159265 }",
            "a constant that is added after sign and scale",
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
            "whether the column is the commanded current or the measured one",
        ),
        key(
            "from",
            "s",
            "the log's start",
            "from = 8.0",
            "beginning of the part that is used",
        ),
        key(
            "until",
            "s",
            "the log's end",
            "until = 60.0",
            "end of the part that is used",
        ),
        key(
            "time_step",
            "s",
            "none",
            "time_step = 0.005",
            "time from line to line, for a file without a time column",
        ),
        key(
            "accept",
            "",
            "none",
            "accept = [\"rate-factor\"]",
            "findings of `flywheel check` that this experiment may have",
        ),
    ],
};

/// `[calibration]` of bench.toml.
pub(super) const CALIBRATION: KeySection = KeySection {
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
            "turned through all orientations: `mx my mz`",
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
            "scale of the gyroscope, from the data sheet",
        ),
        key(
            "sample_time",
            "s",
            "needed beside `gyroscope`",
            "sample_time = 0.001",
            "sample time of the still and the swing recording",
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
            "place of the accelerometer relative to the pivot, measured with a ruler along the sensor's x and y",
        ),
        key(
            "lever_arm_std",
            "m",
            "needed beside `lever_arm`",
            "lever_arm_std = 0.001",
            "standard error of `lever_arm`",
        ),
        key(
            "columns",
            "",
            "the names above",
            "columns = { ax = \"acc_x\" }",
            "the column of each quantity, where the header has other names",
        ),
        key(
            "plumb_lines",
            "",
            "none",
            "[calibration.plumb_lines]",
            "the section below",
        ),
    ],
};

/// `[calibration.plumb_lines]`.
pub(super) const CALIBRATION_PLUMB_LINES: KeySection = KeySection {
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
};

/// `[bring_up]`.
pub(super) const BRING_UP: KeySection = KeySection {
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
            "the wheel spun by hand in the positive sense",
        ),
        key(
            "current_step",
            "",
            NEEDED,
            "current_step = \"current-step.csv\"",
            "a small positive current, the body held",
        ),
    ],
};

//! The section `[hardware]`: sensors and drive.

use super::{Key, KeySection, NEEDED, key};

/// Keys of an inertial sensor, of which each kind has these.
const INERTIAL: [Key; 8] = [
    key(
        "part",
        "",
        "none",
        "part = \"FXAS21002\"",
        "a part whose data sheet is known here; the other keys override its values",
    ),
    key(
        "scale",
        "rad/s, m/s² or µT per count",
        "from `part`",
        "scale = 1.0908308e-3",
        "the value of one count",
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
        "none; `generate` asks for it, unless `flywheel calibrate` has found the mounting",
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

/// Keys of the accelerometer: those of an inertial sensor, and its place.
const ACCELEROMETER_KEYS: [Key; 9] = joined(
    &INERTIAL,
    &[key(
        "lever_arm",
        "m",
        "[0, 0]",
        "lever_arm = [0.05, 0.0]",
        "position of the sensor from the pivot, along body x and y",
    )],
);

/// The width of the timer, and the duties that it may be given.
const DUTY: [Key; 3] = [
    key(
        "bits",
        "",
        "from `part`, else 16",
        "bits = 12",
        "width of the timer that makes the duty",
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
];

/// Keys of a current drive: those of the duty, and what it does to the current.
const CURRENT_DRIVE: [Key; 7] = joined(
    &[
        drive_kind("kind = \"current\""),
        drive_part("part = \"ESCON 24/2\""),
        key(
            "duty_zero",
            "counts",
            "from `part`",
            "duty_zero = 32768",
            "the duty of no current",
        ),
        key(
            "amperes_per_count",
            "A",
            "from `[calibration]`",
            "amperes_per_count = 8.39246e-5",
            "current a count; negative where the PWM is inverted",
        ),
    ],
    &DUTY,
);

/// Keys of a voltage drive: those of the duty, what it does to the voltage, and what turns volts into amperes.
const VOLTAGE_DRIVE: [Key; 9] = joined(
    &[
        drive_kind("kind = \"voltage\""),
        drive_part("part = \"SimpleFOC voltage\""),
        key(
            "duty_zero",
            "counts",
            "from `part`",
            "duty_zero = 32768",
            "the duty of 0 V",
        ),
        key(
            "amperes_per_count",
            "V",
            "from `[calibration]`",
            "amperes_per_count = 4.6e-4",
            "volts a count, in spite of its name; negative where the PWM is inverted",
        ),
        key(
            "supply_voltage",
            "V",
            NEEDED,
            "supply_voltage = 12.0",
            "largest voltage either way",
        ),
        key(
            "winding_resistance",
            "Ohm",
            NEEDED,
            "winding_resistance = 1.2",
            "R in V = R u + τ φ̇",
        ),
    ],
    &DUTY,
);

/// Which kind of drive this is.
const fn drive_kind(example: &'static str) -> Key {
    key(
        "kind",
        "",
        "from `part`",
        example,
        "what the duty sets: \"current\" or \"voltage\"",
    )
}

/// Which drive this is.
const fn drive_part(example: &'static str) -> Key {
    key(
        "part",
        "",
        "none",
        example,
        "a drive whose data sheet is known here",
    )
}

/// What every encoder states after its kind: which part it is, and how it counts.
const ENCODER: [Key; 3] = [
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
];

/// The wheel's largest speed, where the sensor's range does not state it.
const LARGEST: Key = key(
    "largest",
    "rad/s",
    "the end of the sensor's words, or of a voltage drive's supply",
    "largest = 700.0",
    "largest speed of the wheel; at 105 % of it the motor is switched off",
);

/// Keys of an encoder on the wheel.
const WHEEL_ENCODER: [Key; 6] = joined(
    &joined::<4>(&[speed_kind("kind = \"encoder\"")], &ENCODER),
    &[
        key(
            "window",
            "samples",
            NEEDED,
            "window = 8",
            "speed = difference over so many samples",
        ),
        LARGEST,
    ],
);

/// Keys of an encoder at the pivot.
const PIVOT_ENCODER: [Key; 5] = joined(
    &joined::<4>(&[angle_kind("kind = \"encoder\"")], &ENCODER),
    &[key(
        "zero",
        "counts",
        NEEDED,
        "zero = 2048",
        "the count with the body upright",
    )],
);

/// Which kind of wheel speed sensor this is.
const fn speed_kind(example: &'static str) -> Key {
    key(
        "kind",
        "",
        NEEDED,
        example,
        "how the controller gets the speed: through a converter, from an encoder, or from the motor's driver",
    )
}

/// Which kind of angle sensor this is.
const fn angle_kind(example: &'static str) -> Key {
    key(
        "kind",
        "",
        NEEDED,
        example,
        "how the controller gets the angle: from gyroscope and accelerometer, or from an encoder on the pivot",
    )
}

/// Two lists of keys as one of `ALL` keys.
const fn joined<const ALL: usize>(first: &[Key], more: &[Key]) -> [Key; ALL] {
    assert!(first.len() + more.len() == ALL);
    let mut keys = [first[0]; ALL];
    let mut at = 0;
    while at < ALL {
        keys[at] = if at < first.len() {
            first[at]
        } else {
            more[at - first.len()]
        };
        at += 1;
    }
    keys
}

/// `[hardware]`.
pub(super) const HARDWARE: KeySection = KeySection {
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
};

/// `[hardware.gyroscope]`.
pub(super) const GYROSCOPE: KeySection = KeySection {
    name: "hardware.gyroscope",
    heading: "[hardware.gyroscope], [hardware.magnetometer]",
    meaning: "An inertial sensor: what its raw counts mean.",
    keys: &INERTIAL,
};

/// `[hardware.accelerometer]`.
pub(super) const ACCELEROMETER: KeySection = KeySection {
    name: "hardware.accelerometer",
    heading: "[hardware.accelerometer]",
    meaning: "The accelerometer, with its position.",
    keys: &ACCELEROMETER_KEYS,
};

/// `[hardware.wheel_speed]` of kind "converter".
pub(super) const WHEEL_SPEED_CONVERTER: KeySection = KeySection {
    name: "hardware.wheel_speed, converter",
    heading: "[hardware.wheel_speed]  kind = \"converter\"",
    meaning: "The wheel's speed as a voltage that a converter reads.",
    keys: &[
        speed_kind("kind = \"converter\""),
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
};

/// `[hardware.wheel_speed]` of kind "encoder".
pub(super) const WHEEL_SPEED_ENCODER: KeySection = KeySection {
    name: "hardware.wheel_speed, encoder",
    heading: "[hardware.wheel_speed]  kind = \"encoder\"",
    meaning: "The wheel's angle as a count that wraps; the speed is its difference over some samples.",
    keys: &WHEEL_ENCODER,
};

/// `[hardware.wheel_speed]` of kind "driver".
pub(super) const WHEEL_SPEED_DRIVER: KeySection = KeySection {
    name: "hardware.wheel_speed, driver",
    heading: "[hardware.wheel_speed]  kind = \"driver\"",
    meaning: "The wheel's speed as a number that the motor's driver sends.",
    keys: &[
        speed_kind("kind = \"driver\""),
        key(
            "scale",
            "rad/s per unit",
            NEEDED,
            "scale = 0.1047",
            "what one unit means; negative where it counts backwards",
        ),
        LARGEST,
    ],
};

/// `[hardware.angle]` of kind "inertial".
pub(super) const ANGLE_INERTIAL: KeySection = KeySection {
    name: "hardware.angle, inertial",
    heading: "[hardware.angle]  kind = \"inertial\"",
    meaning: "The body's angle from gyroscope and accelerometer.",
    keys: &[angle_kind("kind = \"inertial\"")],
};

/// `[hardware.angle]` of kind "encoder".
pub(super) const ANGLE_ENCODER: KeySection = KeySection {
    name: "hardware.angle, encoder",
    heading: "[hardware.angle]  kind = \"encoder\"",
    meaning: "The body's angle from an encoder at the pivot.",
    keys: &PIVOT_ENCODER,
};

/// `[hardware.drive]` of kind "current".
pub(super) const DRIVE_CURRENT: KeySection = KeySection {
    name: "hardware.drive, current",
    heading: "[hardware.drive]  kind = \"current\"",
    meaning: "A drive that closes the current loop itself.",
    keys: &CURRENT_DRIVE,
};

/// `[hardware.drive]` of kind "voltage".
pub(super) const DRIVE_VOLTAGE: KeySection = KeySection {
    name: "hardware.drive, voltage",
    heading: "[hardware.drive]  kind = \"voltage\"",
    meaning: "A drive that sets the motor's voltage.",
    keys: &VOLTAGE_DRIVE,
};

//! The loop around the controller for a board that is programmed in C: commands in, duty and frames out. It is written by
//! hand, as the loop of the firmware in Rust (`firmware/core`) is; a test from bench to bench compares both bit for bit.
//! The lines that depend on the bench's sensors are filled in here.

use crate::file::{EmittedCrate, EmittedFile, MARK};

const HEADER: &str = include_str!("board_loop/flywheel_loop.h");
const SOURCE: &str = include_str!("board_loop/flywheel_loop.c");

/// An encoder at the wheel: its turns are counted once more for the frames, since a controller that starts anew forgets
/// them.
const ENCODER_STATE: &str = "    flywheel_encoder_t encoder;\n";
const ENCODER_INIT: &str = "    flywheel_encoder_init(&self->encoder);\n";
const ENCODER_KEPT: &str = "    \
    self->wheel = sample->wheel_count;
    flywheel_encoder_update(&self->encoder, sample->wheel_count, &FLYWHEEL_WHEEL_ENCODER);
    self->wheel_speed = flywheel_wheel_speed(flywheel_encoder_turned(&self->encoder, &FLYWHEEL_WHEEL_ENCODER));
";
const DRIVER_KEPT: &str = "    \
    self->wheel = (uint16_t)sample->wheel_speed;
    self->wheel_speed = flywheel_wheel_speed(sample->wheel_speed);
";
const CONVERTER_KEPT: &str = "    \
    self->wheel = sample->wheel_adc;
    self->wheel_speed = flywheel_wheel_speed(sample->wheel_adc);
";

const INERTIAL_KEPT: &str = "    \
    for (uint8_t axis = 0; axis < 3u; axis++) {
        self->body[axis] = (uint16_t)sample->gyro[axis];
        self->body[axis + 3] = (uint16_t)sample->accel[axis];
    }
";
/// The count of an encoder on the pivot stands in the place of the gyroscope's x.
const PIVOT_KEPT: &str = "    \
    self->body[0] = sample->body_count;
";

/// Header and source of the loop for an emitted crate.
pub fn files(emitted: &EmittedCrate) -> [EmittedFile; 2] {
    let controller = emitted.file("src/controller.rs").unwrap_or_default();
    let has_field = |name: &str| controller.contains(&format!("pub {name}:"));
    let (body_kept, body_at_start, shown_by) = match has_field("body_count") {
        true => (
            PIVOT_KEPT,
            "place == 0u ? 0u : NO_FIELD",
            "&self->controller",
        ),
        false => (INERTIAL_KEPT, "0", "&self->controller.attitude"),
    };
    let has_encoder = has_field("wheel_count");
    let wheel_kept = match () {
        () if has_encoder => ENCODER_KEPT,
        () if has_field("wheel_speed") => DRIVER_KEPT,
        () => CONVERTER_KEPT,
    };
    let of_encoder = |text: &'static str| if has_encoder { text } else { "" };
    let file = |name: &str, text: &str| EmittedFile {
        path: format!("src/{name}"),
        contents: format!("/* {MARK}; do not edit. */\n{text}")
            .replace("ENCODER_STATE\n", of_encoder(ENCODER_STATE))
            .replace("ENCODER_INIT\n", of_encoder(ENCODER_INIT))
            .replace("BODY_KEPT\n", body_kept)
            .replace("WHEEL_KEPT\n", wheel_kept)
            .replace("BODY_AT_START", body_at_start)
            .replace("SHOWN_BY", shown_by),
    };
    [
        file("flywheel_loop.h", HEADER),
        file("flywheel_loop.c", SOURCE),
    ]
}

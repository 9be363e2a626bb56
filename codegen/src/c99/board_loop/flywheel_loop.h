/* The loop around the controller, as a board calls it: it follows the commands of `flywheel record` and makes the frames
 * from which `flywheel record` makes a log. It is the loop of this project's firmware in Rust, bit for bit.
 *
 *     flywheel_loop_init(&loop);
 *     for each byte of the serial line: flywheel_loop_received(&loop, byte, now_us);
 *     every FLYWHEEL_SAMPLE_TIME_US:    duty = flywheel_loop_tick(&loop, now_us, &sample);
 *                                       length = flywheel_loop_frame(&loop, frame);
 *
 * now_us is a clock in microseconds that may wrap. Send a frame whole or not at all: the receiver notices the gap.
 *
 * What keeps the motor still:
 * - The controller drives the motor only after it was armed, near upright and at rest, and trips by itself.
 * - A tick that comes more than half a sample time late, or without a sample, is a fault of the controller.
 * - A command is valid for its lease: if the line falls silent, the controller is disarmed.
 * - After a start, a command that was under way before does not arm: only one with another number does, unless the
 *   first that is heard asks for no current.
 * - A trip lasts until a command with a new number comes. The controller then starts anew, and is armed at most once
 *   for that command.
 */
#ifndef FLYWHEEL_LOOP_H
#define FLYWHEEL_LOOP_H

#include "flywheel.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of a frame with the zero at its end. */
#define FLYWHEEL_FRAME_BYTES 46u

/* Bytes of a command on the line, without the zero at its end. */
#define FLYWHEEL_COMMAND_BYTES 13u

/* The state of the loop. Its members are for the functions below; a sketch may read `controller`. */
typedef struct {
    flywheel_controller_t controller;
    /* The task: 0 watch, 1 balance, 2 drive with a current. */
    uint8_t task;
    /* The number of the command. */
    uint8_t wish;
    /* Steps from one frame to the next. */
    uint8_t every;
    /* Time for which the command is valid, ms, and when it came, us. */
    uint16_t lease_ms;
    uint32_t came_us;
    /* The current of the task, in the words of the controller. */
    int32_t current;
    /* Whether a command has come since the start. */
    uint8_t has_heard;
    /* Whether the command is new to the controller. */
    uint8_t is_new;
    /* Whether the controller was armed for this command; it is not armed for it again. */
    uint8_t was_armed;
    /* Bytes of a command so far; more than there is room for where it is too long. */
    uint8_t line[FLYWHEEL_COMMAND_BYTES];
    uint8_t line_length;
    /* Whether there was a tick, and when the last one was, us. */
    uint8_t has_ticked;
    uint32_t time_us;
    /* The number of the next step, and the steps since the last frame. */
    uint16_t sequence;
    uint8_t since_frame;
    /* Whether this step has a frame. */
    uint8_t is_due;
    /* The last readings, as the frame has them: they are sent again while a sensor fails. */
    uint16_t body[6];
    uint16_t wheel;
    int32_t wheel_speed;
    uint16_t duty;
ENCODER_STATE
} flywheel_loop_t;

/* At rest: nothing is driven before a command comes. */
void flywheel_loop_init(flywheel_loop_t *self);

/* Takes a byte of the serial line. What is no whole command is ignored. */
void flywheel_loop_received(flywheel_loop_t *self, uint8_t byte, uint32_t now_us);

/* One step: the duty for the timer. `sample` is null where a sensor gave no reading. */
uint16_t flywheel_loop_tick(flywheel_loop_t *self, uint32_t now_us, const flywheel_sample_t *sample);

/* The frame of the last tick: its number of bytes, or 0 where none is due. */
uint8_t flywheel_loop_frame(const flywheel_loop_t *self, uint8_t frame[FLYWHEEL_FRAME_BYTES]);

#ifdef __cplusplus
}
#endif

#endif

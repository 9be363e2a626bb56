#include "flywheel_loop.h"

/* Version of commands and frames. */
#define VERSION 1u
/* Bytes of a message before the two of its CRC. */
#define COMMAND_BODY 10u
#define FRAME_BODY 42u
/* The word of a sensor that the bench does not have. */
#define NO_FIELD 0x8000u
/* Tasks. */
#define WATCH 0u
#define DRIVE 2u

/* CRC-16/CCITT-FALSE: polynomial 0x1021, from 0xFFFF, not reflected. */
static uint16_t crc16(const uint8_t *bytes, uint8_t count) {
    uint16_t crc = 0xFFFFu;
    for (uint8_t place = 0; place < count; place++) {
        crc = (uint16_t)(crc ^ ((uint32_t)bytes[place] << 8));
        for (uint8_t bit = 0; bit < 8u; bit++) {
            const uint32_t shifted = (uint32_t)crc << 1;
            crc = (uint16_t)(shifted > 0xFFFFu ? shifted ^ 0x1021u : shifted);
        }
    }
    return crc;
}

/* Words of a message, lower byte first. */
static uint16_t word_16(const uint8_t *bytes) {
    return (uint16_t)(bytes[0] | ((uint32_t)bytes[1] << 8));
}

static uint32_t word_32(const uint8_t *bytes) {
    return word_16(bytes) | ((uint32_t)word_16(bytes + 2) << 16);
}

static void put_16(uint8_t *bytes, uint16_t word) {
    bytes[0] = (uint8_t)(word & 0xFFu);
    bytes[1] = (uint8_t)(word >> 8);
}

static void put_32(uint8_t *bytes, uint32_t word) {
    put_16(bytes, (uint16_t)(word & 0xFFFFu));
    put_16(bytes + 2, (uint16_t)(word >> 16));
}

/* The controller's word for a current in uA, given as its bits: bit by bit, since a chip of 8 bits has no room for a
 * division of 64. Beyond the range of the word, the end of the range. */
static int32_t current_word(uint32_t bits) {
    const uint8_t is_negative = bits > 0x7FFFFFFFu;
    const uint32_t magnitude_ua = is_negative != 0u ? 0u - bits : bits;
    uint32_t word = magnitude_ua / 1000000u;
    uint32_t rest = magnitude_ua % 1000000u;
    for (uint8_t bit = 0; bit < FLYWHEEL_CURRENT_FRACTION_BITS; bit++) {
        if (word > 0x3FFFFFFFu) {
            word = 0x7FFFFFFFu;
            break;
        }
        word *= 2u;
        rest *= 2u;
        if (rest >= 1000000u) {
            rest -= 1000000u;
            word += 1u;
        }
    }
    return is_negative != 0u ? -(int32_t)word : (int32_t)word;
}

void flywheel_loop_init(flywheel_loop_t *self) {
    flywheel_init(&self->controller);
    self->task = WATCH;
    self->wish = 0;
    self->every = 1;
    self->lease_ms = 0;
    self->came_us = 0;
    self->current = 0;
    self->has_heard = 0;
    self->is_new = 0;
    self->was_armed = 0;
    self->line_length = 0;
    self->has_ticked = 0;
    self->time_us = 0;
    self->sequence = 0;
    self->since_frame = 0xFFu;
    self->is_due = 0;
    for (uint8_t place = 0; place < 6u; place++) {
        self->body[place] = BODY_AT_START;
    }
    self->wheel = 0;
    self->wheel_speed = 0;
    self->duty = FLYWHEEL_ZERO_CURRENT;
ENCODER_INIT
}

/* Undoes COBS in a whole command, whose message then begins at line[1]; 0 where that cannot be done. Each code is the
 * distance to the next one, which stands where the message has a zero.
 */
static uint8_t unstuffed(uint8_t *line) {
    uint8_t place = 0;
    while (place < FLYWHEEL_COMMAND_BYTES) {
        const uint8_t code = line[place];
        if (code > FLYWHEEL_COMMAND_BYTES - place) {
            return 0;
        }
        line[place] = 0;
        place = (uint8_t)(place + code);
    }
    return 1;
}

/* Puts this command in the place of the one in force. */
static void take(flywheel_loop_t *self, const uint8_t *message, uint32_t now_us) {
    const uint8_t task = message[1];
    const uint8_t wish = message[2];
    /* A program repeats its command, also to a board whose supply has just dropped and come back: the controller is not
     * armed for the first command that asks for the motor, but for the next number. */
    const uint8_t is_first = self->has_heard == 0u;
    self->has_heard = 1;
    if (is_first != 0u || wish != self->wish) {
        self->is_new = 1;
        self->was_armed = is_first != 0u && task != WATCH;
    }
    if (task == DRIVE) {
        self->current = current_word(word_32(message + 6));
    }
    self->task = task;
    self->wish = wish;
    self->every = message[3];
    self->lease_ms = word_16(message + 4);
    self->came_us = now_us;
}

void flywheel_loop_received(flywheel_loop_t *self, uint8_t byte, uint32_t now_us) {
    const uint8_t length = self->line_length;
    const uint8_t *message = self->line + 1;
    if (byte != 0u) {
        if (length < FLYWHEEL_COMMAND_BYTES) {
            self->line[length] = byte;
        }
        if (length <= FLYWHEEL_COMMAND_BYTES) {
            self->line_length = (uint8_t)(length + 1u);
        }
        return;
    }
    self->line_length = 0;
    if (length == FLYWHEEL_COMMAND_BYTES && unstuffed(self->line) != 0u
        && crc16(message, COMMAND_BODY) == word_16(message + COMMAND_BODY) && message[0] == VERSION
        && message[1] <= DRIVE) {
        take(self, message, now_us);
    }
}

static uint8_t is_tripped(const flywheel_loop_t *self) {
    const flywheel_status_t status = flywheel_status(&self->controller);
    return status != FLYWHEEL_NOT_ALIGNED && status != FLYWHEEL_READY && status != FLYWHEEL_RUNNING;
}

/* Ends a command whose lease is over; starts a tripped controller anew for a new command; arms or disarms. */
static void follow(flywheel_loop_t *self, uint32_t now_us) {
    if (self->task != WATCH && (uint32_t)(now_us - self->came_us) > (uint32_t)self->lease_ms * 1000u) {
        self->task = WATCH;
        self->was_armed = 1;
    }
    if (self->is_new != 0u && is_tripped(self) != 0u) {
        flywheel_init(&self->controller);
    }
    self->is_new = 0u;
    if (self->task == WATCH) {
        flywheel_disarm(&self->controller);
    } else if (self->was_armed == 0u) {
        self->was_armed = flywheel_arm(&self->controller);
    }
}

/* Keeps the readings for the frames. */
static void keep(flywheel_loop_t *self, const flywheel_sample_t *sample) {
BODY_KEPT
WHEEL_KEPT
}

uint16_t flywheel_loop_tick(flywheel_loop_t *self, uint32_t now_us, const flywheel_sample_t *sample) {
    const uint32_t longest_us = (uint32_t)FLYWHEEL_SAMPLE_TIME_US + FLYWHEEL_SAMPLE_TIME_US / 2u;
    const uint8_t is_late = self->has_ticked != 0u && (uint32_t)(now_us - self->time_us) > longest_us;
    self->has_ticked = 1;
    self->time_us = now_us;
    if (sample) {
        keep(self, sample);
    }
    follow(self, now_us);
    if (is_late != 0u || !sample) {
        flywheel_fault(&self->controller);
    }
    /* Without a reading the controller cannot step. */
    if (!sample) {
        self->duty = FLYWHEEL_ZERO_CURRENT;
    } else if (self->task == DRIVE) {
        self->duty = flywheel_step_with_current(&self->controller, sample, self->current);
    } else {
        self->duty = flywheel_step(&self->controller, sample);
    }
    self->sequence = (uint16_t)(self->sequence + 1u);
    if (self->since_frame < 0xFFu) {
        self->since_frame = (uint8_t)(self->since_frame + 1u);
    }
    self->is_due = self->since_frame >= self->every;
    if (self->is_due != 0u) {
        self->since_frame = 0;
    }
    return self->duty;
}

uint8_t flywheel_loop_frame(const flywheel_loop_t *self, uint8_t frame[FLYWHEEL_FRAME_BYTES]) {
    uint8_t *message = frame + 1;
    uint8_t code = 0;
    if (self->is_due == 0u) {
        return 0;
    }
    message[0] = VERSION;
    message[1] = (uint8_t)flywheel_status(&self->controller);
    put_16(message + 2, (uint16_t)(self->sequence - 1u));
    put_32(message + 4, self->time_us);
    for (uint8_t axis = 0; axis < 6u; axis++) {
        put_16(message + 8 + 2u * axis, self->body[axis]);
    }
    put_16(message + 26, self->wheel);
    put_16(message + 28, self->duty);
    /* No magnetometer. */
    for (uint8_t axis = 0; axis < 3u; axis++) {
        put_16(message + 20 + 2u * axis, NO_FIELD);
    }
    put_32(message + 30, (uint32_t)flywheel_angle(SHOWN_BY));
    put_32(message + 34, (uint32_t)flywheel_rate(SHOWN_BY));
    put_32(message + 38, (uint32_t)self->wheel_speed);
    put_16(message + FRAME_BODY, crc16(message, FRAME_BODY));
    /* COBS: in the place of each zero stands the distance to the next, or to the end. */
    for (uint8_t place = 1; place < FLYWHEEL_FRAME_BYTES - 1u; place++) {
        if (frame[place] == 0u) {
            frame[code] = (uint8_t)(place - code);
            code = place;
        }
    }
    frame[code] = (uint8_t)(FLYWHEEL_FRAME_BYTES - 1u - code);
    frame[FLYWHEEL_FRAME_BYTES - 1u] = 0;
    return FLYWHEEL_FRAME_BYTES;
}

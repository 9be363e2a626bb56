/* Proofs about the emitted C, one function each, for CBMC: `run` says how. The source is included, so that its static
 * functions can be called. CBMC lets `nondet_…` return any value of its type. Beside the assertions it checks that no
 * operation overflows, shifts too far, loses a value in a conversion, or leaves an array: so an expression in 64 bits,
 * here as in the source, is exact where its proof succeeds.
 */
#include "flywheel.c"

int16_t nondet_int16(void);
uint16_t nondet_uint16(void);
int32_t nondet_int32(void);
int64_t nondet_int64(void);
uint8_t nondet_uint8(void);

static int32_t any_within(int32_t limit) {
    const int32_t value = nondet_int32();
    __CPROVER_assume(-limit <= value && value <= limit);
    return value;
}

/* The nearest value from low to high. */
static int64_t nearest(int64_t value, int64_t low, int64_t high) {
    return value < low ? low : value > high ? high : value;
}

/* The current is the sum of the three products, rounded to the nearest unit and clamped: exact, for any words. */
void proof_law(void) {
    const int32_t angle = nondet_int32();
    const int32_t rate = nondet_int32();
    const int32_t wheel_speed = nondet_int32();
    const int32_t current = flywheel_control(angle, rate, wheel_speed);
    const int64_t sum = (int64_t)FLYWHEEL_ANGLE_GAIN * angle + (int64_t)FLYWHEEL_RATE_GAIN * rate
            + (int64_t)FLYWHEEL_WHEEL_SPEED_GAIN * wheel_speed;
    const int64_t rounded = (sum + (INT64_C(1) << (FLYWHEEL_SHIFT - 1))) >> FLYWHEEL_SHIFT;
    __CPROVER_assert(current == nearest(rounded, -(int64_t)FLYWHEEL_CURRENT_LIMIT, FLYWHEEL_CURRENT_LIMIT), "exact");
}

/* A line is its product and offset, rounded down and clamped. */
static void check_line(int32_t word, const flywheel_line_t *line) {
    const int64_t value = ((int64_t)word * line->scale + line->offset) >> line->shift;
    __CPROVER_assert(line_on_line(word, line) == nearest(value, line->low, line->high), "exact");
}

void proof_rate_line(void) {
    /* What a filter may leave as its rate. */
    check_line(any_within(CALIBRATION_CALIBRATED_MAX), &FLYWHEEL_RATE_LINE);
}

#ifdef WHEEL_CONVERTER
void proof_wheel_speed_line(void) {
    check_line((int32_t)nondet_uint16(), &FLYWHEEL_WHEEL_SPEED_LINE);
}
#endif

#ifndef VOLTAGE_DRIVE
void proof_duty_line(void) {
    const int32_t current = any_within(FLYWHEEL_CURRENT_LIMIT);
    check_line(current, &FLYWHEEL_DUTY_LINE);
    __CPROVER_assert(controller_duty(current) >= FLYWHEEL_DUTY_LINE.low
            && controller_duty(current) <= FLYWHEEL_DUTY_LINE.high, "range");
    __CPROVER_assert(controller_duty(0) == FLYWHEEL_ZERO_CURRENT, "no current");
}
#endif

/* Calibrated readings have a value, within its range, for any counts. */
static void check_calibration(const flywheel_sensor_line_t *line) {
    const int16_t raw[3] = {nondet_int16(), nondet_int16(), nondet_int16()};
    int32_t found[3];
    calibration_calibrate(raw, line, found);
    for (int axis = 0; axis < 3; axis++) {
        __CPROVER_assert(-CALIBRATION_CALIBRATED_MAX <= found[axis] && found[axis] <= CALIBRATION_CALIBRATED_MAX, "range");
    }
}

void proof_gyroscope(void) {
    check_calibration(&FLYWHEEL_FILTER.gyro);
}

void proof_accelerometer(void) {
    check_calibration(&FLYWHEEL_FILTER.accel);
}

/* A sum of products rounded to its upper word is off by half a unit at most. */
void proof_rounding(void) {
    const int64_t sum = nondet_int64();
    const int64_t half = INT64_C(1) << 31;
    __CPROVER_assume(-INT64_MAX - 1 + 2 * half <= sum && sum <= INT64_MAX - 2 * half);
    const int64_t rest = (int64_t)product_round_high(sum) * (2 * half) - sum;
    __CPROVER_assert(-half <= rest && rest <= half, "accurate");
}

/* The upward direction has a value, within its range, for any quaternion within its components, whatever its length. */
void proof_up(void) {
    const int32_t limit = MADGWICK_COMPONENT_MAX;
    const int32_t q[4] = {any_within(limit), any_within(limit), any_within(limit), any_within(limit)};
    int32_t up[3];
    madgwick_up_q28(q, up);
    for (int axis = 0; axis < 3; axis++) {
        __CPROVER_assert(-INT32_C(0x40200000) <= up[axis] && up[axis] <= INT32_C(0x40200000), "range");
    }
}

/* A quaternion after its normalisation lies within its range, whatever its length was. */
void proof_normalised(void) {
    const int32_t limit = INT32_C(0x60000000);
    const int32_t q[4] = {any_within(limit), any_within(limit), any_within(limit), any_within(limit)};
    int32_t unit[4];
    madgwick_normalised(q, unit);
    for (int axis = 0; axis < 4; axis++) {
        __CPROVER_assert(-MADGWICK_COMPONENT_MAX <= unit[axis] && unit[axis] <= MADGWICK_COMPONENT_MAX, "range");
    }
}

/* Each count goes on or ends, within its limit, and the words of the gyroscope are those of the sample. */
void proof_counts(void) {
    flywheel_counters_t before, after;
    before.wheel = nondet_uint16();
    before.clipped = nondet_uint16();
    before.frozen = nondet_uint16();
    before.rejected = nondet_uint16();
    before.saturated = nondet_uint16();
    before.gyro[0] = nondet_int16();
    before.gyro[1] = nondet_int16();
    before.gyro[2] = nondet_int16();
    const int16_t gyro[3] = {nondet_int16(), nondet_int16(), nondet_int16()};
    const uint8_t is_clipped = nondet_uint8() & 1, shows_gravity = nondet_uint8() & 1;
    const flywheel_limits_t *limits = &FLYWHEEL_LIMITS;
    supervisor_observed(&before, gyro, is_clipped, shows_gravity, nondet_int32(), limits, &after);
    __CPROVER_assert(0 <= after.wheel && after.wheel <= limits->wheel_steps, "wheel");
    __CPROVER_assert(0 <= after.clipped && after.clipped <= limits->clipped_steps, "clipped");
    __CPROVER_assert(0 <= after.frozen && after.frozen <= limits->frozen_steps, "frozen");
    __CPROVER_assert(0 <= after.rejected && after.rejected <= limits->rejected_steps, "rejected");
    __CPROVER_assert((after.clipped == 0) == !is_clipped, "clipped is counted");
    __CPROVER_assert((after.rejected == 0) == shows_gravity, "no gravity is counted");
    __CPROVER_assert(after.saturated == before.saturated && after.gyro[0] == gyro[0] && after.gyro[1] == gyro[1]
            && after.gyro[2] == gyro[2], "what stays");
}

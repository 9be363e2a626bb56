/* Reads steps from standard input and writes what the controller answers. Words are little-endian, as on the
 * machine that runs the test: u8 what, i16 gyro[3], i16 accel[3], u16 wheel, i32 words[3].
 *
 * The source itself is compiled here, so that functions can be called with words that no step gives them. */
#include <stdio.h>
#include <string.h>

#include "flywheel.c"

/* How local variables are filled before they are answered: what a function leaves out is seen. */
#define UNSET 0xAA

static int read_all(void *to, size_t size) { return fread(to, size, 1, stdin) == 1; }

/* BEGIN DIGEST */
static uint32_t joined(uint32_t digest, int32_t word) { return (digest ^ (uint32_t)word) * 16777619u; }

/* All words of the state, in the order of its declaration. */
static int32_t digest(const flywheel_controller_t *c) {
    uint32_t d = 0;
    for (int i = 0; i < 4; i++) d = joined(d, c->attitude.state.quaternion[i]);
    d = joined(d, c->attitude.state.rate);
    d = joined(d, c->attitude.state.slow_rate);
    for (int i = 0; i < 3; i++) d = joined(d, c->attitude.drift[i]);
    d = joined(d, c->window.count);
    for (int i = 0; i < 3; i++) d = joined(d, c->window.first[i]);
    for (int i = 0; i < 3; i++) d = joined(d, c->window.sum[i]);
    d = joined(d, c->counters.wheel);
    d = joined(d, c->counters.clipped);
    d = joined(d, c->counters.frozen);
    d = joined(d, c->counters.rejected);
    d = joined(d, c->counters.saturated);
    for (int i = 0; i < 3; i++) d = joined(d, c->counters.gyro[i]);
    d = joined(d, c->bias_state);
    return (int32_t)d;
}
/* END */

int main(void) {
    flywheel_controller_t controller;
    memset(&controller, UNSET, sizeof controller);
    flywheel_init(&controller);
    uint8_t what;
    while (read_all(&what, sizeof what)) {
        flywheel_sample_t sample;
        int32_t words[3];
        int32_t answer[9];
        memset(answer, 0, sizeof answer);
        if (!read_all(sample.gyro, sizeof sample.gyro) || !read_all(sample.accel, sizeof sample.accel)
            || !read_all(&sample.wheel_adc, sizeof sample.wheel_adc) || !read_all(words, sizeof words)) {
            return 1;
        }
        switch (what) {
        case 0:
            memset(&controller, UNSET, sizeof controller);
            flywheel_init(&controller);
            break;
        case 1: answer[0] = flywheel_arm(&controller); break;
        case 2: flywheel_disarm(&controller); break;
        case 3: flywheel_fault(&controller); break;
        case 4: answer[0] = flywheel_step(&controller, &sample); break;
        case 5: answer[0] = flywheel_step_with_current(&controller, &sample, words[0]); break;
        case 7: answer[0] = flywheel_wheel_speed(sample.wheel_adc); break;
/* BEGIN DIRECT */
        case 8: {
            /* A gradient with any components below what counts as none. */
            int32_t gradient[4];
            flywheel_correction_t correction;
            memset(&correction, UNSET, sizeof correction);
            for (int i = 0; i < 4; i++) {
                const int32_t wide = i < 3 ? words[i] >> 4 : sample.gyro[1] * 4096;
                gradient[i] = (sample.accel[2] >> i) & 1 ? wide : sample.gyro[i % 3] >> 8;
            }
            madgwick_scaled_correction(gradient, 0x100, FLYWHEEL_FILTER.beta, &correction);
            answer[0] = correction.gain;
            memcpy(answer + 4, correction.direction, sizeof correction.direction);
            break;
        }
        case 9: {
            /* An upward direction: too short, straight down, a little beside it, or any. */
            flywheel_filter_state_t state, aligned;
            int32_t up[3];
            memset(&aligned, UNSET, sizeof aligned);
            memcpy(state.quaternion, words, sizeof words);
            state.quaternion[3] = sample.gyro[0] * 16384;
            state.rate = sample.accel[0];
            state.slow_rate = sample.accel[1];
            for (int i = 0; i < 3; i++) {
                const int32_t kinds[4] = {sample.accel[i], sample.gyro[i], sample.gyro[i], sample.gyro[i] * 8192};
                up[i] = kinds[sample.wheel_adc & 3];
            }
            if ((sample.wheel_adc & 3) == 1 || (sample.wheel_adc & 3) == 2) {
                up[2] -= INT32_C(0x10000000);
            }
            if ((sample.wheel_adc & 3) == 2) {
                up[(sample.wheel_adc >> 2) & 1] = sample.accel[1] * 1024;
            }
            filter_align_to(&state, up, &FLYWHEEL_FILTER, &aligned);
            answer[0] = aligned.rate ^ (aligned.slow_rate * 65536);
            memcpy(answer + 4, aligned.quaternion, sizeof aligned.quaternion);
            break;
        }
/* END */
        default: answer[0] = flywheel_control(words[0], words[1], words[2]); break;
        }
        answer[1] = (int32_t)flywheel_status(&controller);
        answer[2] = flywheel_angle(&controller.attitude);
        answer[3] = flywheel_rate(&controller.attitude);
        if (what < 8) {
            flywheel_quaternion(&controller.attitude, answer + 4);
        }
        answer[8] = digest(&controller);
        if (fwrite(answer, sizeof answer, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}

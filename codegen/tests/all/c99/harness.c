/* Reads steps from standard input and writes what the controller answers. Words are little-endian, as on the
 * machine that runs the test: u8 what, i16 gyro[3], i16 accel[3], u16 wheel, i32 words[3]. */
#include <stdio.h>
#include <string.h>

#include "flywheel.h"

static int read_all(void *to, size_t size) { return fread(to, size, 1, stdin) == 1; }

int main(void) {
    flywheel_controller_t controller;
    flywheel_init(&controller);
    uint8_t what;
    while (read_all(&what, sizeof what)) {
        flywheel_sample_t sample;
        int32_t words[3];
        int32_t answer[8];
        memset(answer, 0, sizeof answer);
        if (!read_all(sample.gyro, sizeof sample.gyro) || !read_all(sample.accel, sizeof sample.accel)
            || !read_all(&sample.wheel_adc, sizeof sample.wheel_adc) || !read_all(words, sizeof words)) {
            return 1;
        }
        switch (what) {
        case 0: flywheel_init(&controller); break;
        case 1: answer[0] = flywheel_arm(&controller); break;
        case 2: flywheel_disarm(&controller); break;
        case 3: flywheel_fault(&controller); break;
        case 4: answer[0] = flywheel_step(&controller, &sample); break;
        case 5: answer[0] = flywheel_step_with_current(&controller, &sample, words[0]); break;
        case 7: answer[0] = flywheel_wheel_speed(sample.wheel_adc); break;
        default: answer[0] = flywheel_control(words[0], words[1], words[2]); break;
        }
        answer[1] = (int32_t)flywheel_status(&controller);
        answer[2] = flywheel_angle(&controller.attitude);
        answer[3] = flywheel_rate(&controller.attitude);
        flywheel_quaternion(&controller.attitude, answer + 4);
        if (fwrite(answer, sizeof answer, 1, stdout) != 1) {
            return 1;
        }
    }
    return 0;
}

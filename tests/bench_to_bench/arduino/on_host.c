/* The loop in C around a bench that another program states; the messages are those of `firmware/on-host`. BODY_COUNT stands
 * for an encoder on the pivot, WHEEL for the field of the wheel's sensor. Words are little-endian, as on the machine that runs
 * the test. */
#include <stdio.h>

#include "flywheel_loop.h"

static int read_all(void *to, size_t size) { return fread(to, size, 1, stdin) == 1; }

int main(void) {
    flywheel_loop_t loop;
    uint32_t now_us;
    flywheel_loop_init(&loop);
    while (read_all(&now_us, sizeof now_us)) {
        uint8_t answers, count, byte;
        int16_t inertial[9];
        uint16_t wheel, body, duty;
        flywheel_sample_t sample;
        uint8_t frame[FLYWHEEL_FRAME_BYTES];
        uint8_t length;
        if (!read_all(&answers, 1) || !read_all(inertial, sizeof inertial) || !read_all(&wheel, sizeof wheel)
            || !read_all(&body, sizeof body) || !read_all(&count, 1)) {
            return 1;
        }
        for (; count > 0; count--) {
            if (!read_all(&byte, 1)) return 1;
            flywheel_loop_received(&loop, byte, now_us);
        }
#ifdef BODY_COUNT
        sample.body_count = body;
#else
        for (int axis = 0; axis < 3; axis++) {
            sample.gyro[axis] = inertial[axis];
            sample.accel[axis] = inertial[axis + 3];
        }
#endif
        sample.WHEEL = (WHEEL_TYPE)wheel;
        duty = flywheel_loop_tick(&loop, now_us, answers ? &sample : NULL);
        length = flywheel_loop_frame(&loop, frame);
        if (fwrite(&duty, sizeof duty, 1, stdout) != 1 || fwrite(&length, 1, 1, stdout) != 1
            || fwrite(frame, 1, length, stdout) != length || fflush(stdout) != 0) {
            return 1;
        }
    }
    return 0;
}

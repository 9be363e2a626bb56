/* The loop in C around a bench that another program states; the messages are those of `firmware/on-host`. BODY_COUNT stands
 * for an encoder on the pivot, WHEEL for the field of the wheel's sensor. Words are little-endian, as on the machine that runs
 * the test. */
#include <stdio.h>
#include <string.h>

/* The source itself, whose words of currents are asked for too. */
#include "flywheel_loop.c"

/* Room around a frame, which nobody may touch. */
#define AROUND 8u

static int read_all(void *to, size_t size) { return fread(to, size, 1, stdin) == 1; }

/* The words of currents in uA: with any argument, instead of the loop. */
static int current_words(void) {
    uint32_t bits;
    while (read_all(&bits, sizeof bits)) {
        const int32_t word = current_word(bits);
        if (fwrite(&word, sizeof word, 1, stdout) != 1) return 1;
    }
    return 0;
}

int main(int count_of_arguments, char **arguments) {
    (void)arguments;
    if (count_of_arguments > 1) return current_words();
    flywheel_loop_t loop;
    uint32_t now_us;
    uint8_t filled = 0;
    uint8_t room[FLYWHEEL_FRAME_BYTES + 2u * AROUND];
    uint8_t *frame = room + AROUND;
    /* What is not set shows. */
    memset(&loop, 0xAA, sizeof loop);
    flywheel_loop_init(&loop);
    if (flywheel_loop_frame(&loop, frame) != 0) return 1;
    while (read_all(&now_us, sizeof now_us)) {
        uint8_t answers, count, byte;
        int16_t inertial[9];
        uint16_t wheel, body, duty;
        flywheel_sample_t sample;
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
        filled ^= 0xAA;
        memset(room, filled, sizeof room);
        length = flywheel_loop_frame(&loop, frame);
        for (unsigned place = 0; place < AROUND; place++) {
            if (room[place] != filled || frame[FLYWHEEL_FRAME_BYTES + place] != filled) return 1;
        }
        if (fwrite(&duty, sizeof duty, 1, stdout) != 1 || fwrite(&length, 1, 1, stdout) != 1
            || fwrite(frame, 1, length, stdout) != length || fflush(stdout) != 0) {
            return 1;
        }
    }
    return 0;
}

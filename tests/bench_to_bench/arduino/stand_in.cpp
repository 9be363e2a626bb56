// The board and the sensors around the emitted sketch: the clock, the line and the registers of the parts, filled by
// another program each tick and read by it. The messages are those of `firmware/on-host`.
#include "Wire.h"
#if defined(SIMPLEFOC)
#include "SimpleFOC.h"
#endif

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <deque>
#include <vector>

void setup();
void loop();

SerialLine Serial;
Bus Wire;

namespace {

// What the other program states of a tick, and what the sketch answers.
uint32_t now_us;
bool answers;
int16_t gyro[3], accel[3];
uint16_t wheel, body;
std::deque<uint8_t> came;
std::vector<uint8_t> goes;
uint16_t duty;
bool has_stepped;

// The timer.
uint8_t timer_bits;

// The registers of the parts that were written, and the transmission in progress.
uint8_t registers[128][256];
uint8_t device;
std::vector<uint8_t> sent;
uint8_t address;
std::deque<uint8_t> received;

void fail(const char *what) {
    fprintf(stderr, "the sketch: %s\n", what);
    exit(1);
}

void use_timer(double frequency_hz, uint8_t bits) {
#if defined(CONFIG_IDF_TARGET_ESP32)
    const int most = 20;
#else
    const int most = 14;
#endif
    // The timer divides 80 MHz.
    if (bits > most || frequency_hz * (1u << bits) > 80e6) fail("a duty that no timer gives");
    timer_bits = bits;
}

void put(std::vector<uint8_t> &bytes, uint16_t word) {
    bytes.push_back((uint8_t)(word >> 8));
    bytes.push_back((uint8_t)word);
}

void put_axes(std::vector<uint8_t> &bytes, const int16_t *axes) {
    for (int axis = 0; axis < 3; axis++) put(bytes, (uint16_t)axes[axis]);
}

// What a part holds from this register on; zeros where it was not started in the range that the bench states.
std::vector<uint8_t> held() {
    std::vector<uint8_t> bytes;
    const uint8_t *own = registers[device];
    if (device == 0x21 && address == 0x01 && own[0x13] == 0x02 && own[0x0D] == 0x00) put_axes(bytes, gyro);
    if (device == 0x1F && address == 0x01 && own[0x2A] == 0x01 && own[0x0E] == 0x02) put_axes(bytes, accel);
    if (device == 0x48 && address == 0x00 && own[0x01] == 0xC2) put(bytes, (uint16_t)(wheel << 4));
    if (device == 0x36 && address == 0x0B) bytes.push_back(0x20);
    if (device == 0x36 && address == 0x0C) put(bytes, body);
    bytes.resize(32);
    return bytes;
}

bool read_all(void *to, size_t size) { return fread(to, size, 1, stdin) == 1; }

}  // namespace

unsigned long micros() { return now_us; }
void delay(uint32_t) {}

#if ESP_ARDUINO_VERSION_MAJOR >= 3
bool ledcAttach(uint8_t, uint32_t frequency_hz, uint8_t bits) {
    use_timer(frequency_hz, bits);
    return true;
}
#else
double ledcSetup(uint8_t, double frequency_hz, uint8_t bits) {
    use_timer(frequency_hz, bits);
    return frequency_hz;
}
void ledcAttachPin(uint8_t, uint8_t) {}
#endif

bool ledcWrite(uint8_t, uint32_t counts) {
    if (timer_bits == 0 || counts >> timer_bits != 0) fail("a duty beyond its timer");
    duty = (uint16_t)(counts << (timer_bits < 16 ? 16 - timer_bits : 0));
    has_stepped = true;
    return true;
}

#if defined(SIMPLEFOC)
// The numbers are those of the bench in `arduino.rs`.
BLDCMotor motor;
namespace {
bool has_begun_motor, has_moved;
}
int BLDCMotor::init() { return 1; }
int BLDCMotor::initFOC() {
    has_begun_motor = controller == MotionControlType::torque && torque_controller == TorqueControlType::voltage;
    return 1;
}
void BLDCMotor::loopFOC() { shaft_velocity = 0.1f * (int16_t)wheel; }
void BLDCMotor::move() {
    if (!has_begun_motor) fail("a motor that moves before it begins");
    has_moved = true;
}
#endif

void SerialLine::begin(unsigned long) {}
int SerialLine::available() { return (int)came.size(); }
int SerialLine::read() {
    if (came.empty()) return -1;
    const uint8_t byte = came.front();
    came.pop_front();
    return byte;
}
int SerialLine::availableForWrite() { return 128; }
size_t SerialLine::write(const uint8_t *bytes, size_t count) {
    goes.insert(goes.end(), bytes, bytes + count);
    return count;
}

void Bus::begin() {}
void Bus::setClock(uint32_t) {}
void Bus::beginTransmission(uint8_t to) {
    device = to;
    sent.clear();
}
size_t Bus::write(uint8_t byte) {
    sent.push_back(byte);
    return 1;
}
uint8_t Bus::endTransmission(bool) {
#if defined(SIMPLEFOC)
    // No duty goes to a timer: a step shows by its look at the sensors.
    has_stepped = true;
#endif
    if (!answers) return 2;
    if (sent.empty() || device >= 128) fail("a transmission of nothing");
    address = sent[0];
    for (size_t place = 1; place < sent.size(); place++) registers[device][(uint8_t)(address + place - 1)] = sent[place];
    return 0;
}
uint8_t Bus::requestFrom(uint8_t from, uint8_t count) {
    if (!answers || from != device) return 0;
    const std::vector<uint8_t> bytes = held();
    if (count > bytes.size()) fail("more bytes than a part has");
    received.assign(bytes.begin(), bytes.begin() + count);
    return count;
}
int Bus::read() {
    if (received.empty()) return -1;
    const uint8_t byte = received.front();
    received.pop_front();
    return byte;
}

int main() {
    bool has_begun = false;
    uint8_t does_answer, count;
    int16_t mag[3];
    while (read_all(&now_us, sizeof now_us)) {
        if (!read_all(&does_answer, 1) || !read_all(gyro, sizeof gyro) || !read_all(accel, sizeof accel)
            || !read_all(mag, sizeof mag) || !read_all(&wheel, sizeof wheel) || !read_all(&body, sizeof body)
            || !read_all(&count, 1)) {
            return 1;
        }
        for (int byte = 0; byte < count; byte++) {
            uint8_t one;
            if (!read_all(&one, 1)) return 1;
            came.push_back(one);
        }
        answers = does_answer != 0;
        if (!has_begun) setup();
        has_begun = true;
        goes.clear();
        has_stepped = false;
#if defined(SIMPLEFOC)
        has_moved = false;
#endif
        // A board calls it over and over.
        for (int turn = 0; turn < 100 && (!has_stepped || !came.empty()); turn++) loop();
#if defined(SIMPLEFOC)
        if (!has_moved) fail("a motor that nobody moves");
        duty = (uint16_t)(lroundf(motor.target / 0.000732444f) + 32768);
#endif
        if (!has_stepped) fail("no step in a tick");
        const uint8_t length = (uint8_t)goes.size();
        fwrite(&duty, sizeof duty, 1, stdout);
        fwrite(&length, 1, 1, stdout);
        fwrite(goes.data(), 1, length, stdout);
        fflush(stdout);
    }
    return 0;
}

// Stands in for the ESP32 core of Arduino, as far as the emitted sketch uses it: clock, serial line and duty are those of a
// simulated bench (`stand_in.cpp`).
#pragma once
#include <math.h>
#include <stddef.h>
#include <stdint.h>

// Version 3 of the core names the pin of a duty, version 2 a channel; a test compiles the sketch for both.
#if ESP_ARDUINO_VERSION_MAJOR >= 3
bool ledcAttach(uint8_t pin, uint32_t frequency_hz, uint8_t bits);
#else
double ledcSetup(uint8_t channel, double frequency_hz, uint8_t bits);
void ledcAttachPin(uint8_t pin, uint8_t channel);
#endif
bool ledcWrite(uint8_t pin_or_channel, uint32_t duty);

unsigned long micros();
void delay(uint32_t ms);

struct SerialLine {
    void begin(unsigned long baud);
    int available();
    int read();
    int availableForWrite();
    size_t write(const uint8_t *bytes, size_t count);
};
extern SerialLine Serial;

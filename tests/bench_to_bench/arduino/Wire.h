// Stands in for the I2C bus: the parts on it are those of a simulated bench (`stand_in.cpp`).
#pragma once
#include "Arduino.h"

struct Bus {
    void begin();
    void setClock(uint32_t frequency_hz);
    void beginTransmission(uint8_t device);
    size_t write(uint8_t byte);
    uint8_t endTransmission(bool ends = true);
    uint8_t requestFrom(uint8_t device, uint8_t count);
    int read();
};
extern Bus Wire;

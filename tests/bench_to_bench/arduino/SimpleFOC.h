// Stands in for SimpleFOC, as far as the guide's page on Arduino uses it: the members of its motor by their names and types,
// and what the motor's target and speed are on a simulated bench (`stand_in.cpp`).
#pragma once

enum MotionControlType : uint8_t { torque = 0 };
enum TorqueControlType : uint8_t { voltage = 0, dc_current = 1, foc_current = 2 };

struct BLDCMotor {
    MotionControlType controller;
    TorqueControlType torque_controller;
    float target;
    float shaft_velocity;
    int init();
    int initFOC();
    void loopFOC();
    void move();
};
extern BLDCMotor motor;

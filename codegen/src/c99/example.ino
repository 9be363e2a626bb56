// The emitted controller on an ESP32 with the sensors of the thesis' bench: FXOS8700 (accelerometer), FXAS21002C
// (gyroscope), an ADS1015 on the speed output of the drive, and a drive that takes its current from a PWM.
// Registers are those of the data sheets of NXP. This sketch has been neither compiled with Arduino's core nor tried on a bench. Take the
// wheel off, or the supply's current limit down, for the first power-on.
//
// Commands on the serial line: a arms, d disarms. Every 20 ms a line: status, duty, and the words of angle and rate.
#include <Wire.h>
#include <flywheel.h>

const uint8_t GYRO = 0x21;
const uint8_t ACCEL = 0x1F;
const uint8_t WHEEL_SPEED = 0x48;
const int DUTY_PIN = 25;
const uint32_t PWM_FREQUENCY_HZ = 1000;
const uint8_t PWM_BITS = 16;

flywheel_controller_t controller;
uint32_t next_step_us;
uint16_t steps;

void write_register(uint8_t device, uint8_t address, uint8_t value) {
  Wire.beginTransmission(device);
  Wire.write(address);
  Wire.write(value);
  Wire.endTransmission();
}

// Three words, upper byte first. False where the bus fails.
bool read_words(uint8_t device, uint8_t address, int16_t words[3]) {
  Wire.beginTransmission(device);
  Wire.write(address);
  if (Wire.endTransmission(false) != 0 || Wire.requestFrom(device, (uint8_t)6) != 6) {
    return false;
  }
  for (int axis = 0; axis < 3; axis++) {
    const uint8_t high = Wire.read();
    const uint8_t low = Wire.read();
    words[axis] = (int16_t)(((uint16_t)high << 8) | low);
  }
  return true;
}

// The last conversion of the ADS1015, 12 bits, left-justified.
bool read_wheel(uint16_t *counts) {
  Wire.beginTransmission(WHEEL_SPEED);
  Wire.write((uint8_t)0x00);
  if (Wire.endTransmission(false) != 0 || Wire.requestFrom(WHEEL_SPEED, (uint8_t)2) != 2) {
    return false;
  }
  const uint8_t high = Wire.read();
  const uint8_t low = Wire.read();
  *counts = (uint16_t)((((uint16_t)high << 8) | low) >> 4);
  return true;
}

void setup() {
  // The motor first: zero current before anything else may fail.
  ledcAttach(DUTY_PIN, PWM_FREQUENCY_HZ, PWM_BITS);
  ledcWrite(DUTY_PIN, FLYWHEEL_ZERO_CURRENT);
  Serial.begin(921600);
  Wire.begin();
  Wire.setClock(400000);
  write_register(GYRO, 0x13, 0x00);   // CTRL_REG1: standby
  write_register(GYRO, 0x0D, 0x00);   // CTRL_REG0: 2000 degrees a second
  write_register(GYRO, 0x13, 0x02);   // CTRL_REG1: 800 Hz, active
  write_register(ACCEL, 0x2A, 0x00);  // CTRL_REG1: standby
  write_register(ACCEL, 0x0E, 0x02);  // XYZ_DATA_CFG: 8 g
  write_register(ACCEL, 0x5B, 0x00);  // M_CTRL_REG1: accelerometer alone
  write_register(ACCEL, 0x2A, 0x05);  // CTRL_REG1: 800 Hz, low noise, active
  Wire.beginTransmission(WHEEL_SPEED);  // ADS1015: AIN0 against ground, 4.096 V, 3300 a second, without pause
  Wire.write((uint8_t)0x01);
  Wire.write((uint8_t)0xC2);
  Wire.write((uint8_t)0xC3);
  Wire.endTransmission();
  flywheel_init(&controller);
  next_step_us = micros();
}

void loop() {
  const uint32_t late_us = micros() - next_step_us;
  if ((int32_t)late_us < 0) {
    return;
  }
  next_step_us += FLYWHEEL_SAMPLE_TIME_US;
  flywheel_sample_t sample;
  bool is_read = read_words(GYRO, 0x01, sample.gyro);
  is_read = read_words(ACCEL, 0x01, sample.accel) && is_read;
  is_read = read_wheel(&sample.wheel_adc) && is_read;
  // A step that comes a whole period late, or without a reading, is no step of the controller that was proved.
  if (!is_read || late_us > FLYWHEEL_SAMPLE_TIME_US) {
    flywheel_fault(&controller);
    next_step_us = micros() + FLYWHEEL_SAMPLE_TIME_US;
  }
  const uint16_t duty = flywheel_step(&controller, &sample);
  ledcWrite(DUTY_PIN, duty);
  if (Serial.available() > 0) {
    switch (Serial.read()) {
      case 'a':
        Serial.println(flywheel_arm(&controller) ? "armed" : "not armed");
        break;
      case 'd':
        flywheel_disarm(&controller);
        break;
    }
  }
  if (++steps % 20 == 0) {
    Serial.printf("%d,%u,%ld,%ld\n", (int)flywheel_status(&controller), duty,
                  (long)flywheel_angle(&controller.attitude), (long)flywheel_rate(&controller.attitude));
  }
}

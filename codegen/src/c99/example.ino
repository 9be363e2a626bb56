// The emitted controller with the sensors of the thesis' bench: FXOS8700 (accelerometer), FXAS21002C (gyroscope), an
// ADS1015 on the speed output of the drive, and a drive that takes its current from a PWM. Registers are those of the
// data sheets of NXP and TI. Compiled with Arduino's AVR core; the ESP32's part with no core, and nothing was tried on a
// bench. Take the wheel off, or the supply's current limit down, for the first power-on.
//
// An AVR is too slow for 1 kHz: it runs the sketch, reports a fault at the first step and never arms.
//
// Commands on the serial line: a arms, d disarms. Every 20 ms a line: status, duty, and the words of angle and rate.
#include <Wire.h>
#include <flywheel.h>

const uint8_t GYRO = 0x21;
const uint8_t ACCEL = 0x1F;
const uint8_t WHEEL_SPEED = 0x48;

#if defined(ARDUINO_ARCH_ESP32)
const int DUTY_PIN = 25;

// Version 3 of Arduino's ESP32 core names the pin where version 2, which PlatformIO has, names a channel.
#if ESP_ARDUINO_VERSION_MAJOR >= 3
void begin_duty() {
  ledcAttach(DUTY_PIN, 1000, 16);  // Hz, bits
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_PIN, duty);
}
#else
const uint8_t DUTY_CHANNEL = 0;

void begin_duty() {
  ledcSetup(DUTY_CHANNEL, 1000, 16);  // Hz, bits
  ledcWrite(DUTY_CHANNEL, FLYWHEEL_ZERO_CURRENT);
  ledcAttachPin(DUTY_PIN, DUTY_CHANNEL);
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_CHANNEL, duty);
}
#endif
#elif defined(ARDUINO_ARCH_AVR)
// Timer 1 counts to 2^16: 244 Hz at 16 MHz. Its first output is pin 9 of an Uno, pin 11 of a Mega.
#if defined(__AVR_ATmega2560__)
const int DUTY_PIN = 11;
#else
const int DUTY_PIN = 9;
#endif

void begin_duty() {
  OCR1A = FLYWHEEL_ZERO_CURRENT;
  ICR1 = 0xFFFF;
  TCCR1A = _BV(COM1A1) | _BV(WGM11);
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS10);
  pinMode(DUTY_PIN, OUTPUT);
}

void write_duty(uint16_t duty) {
  OCR1A = duty;
}
#else
#error "begin_duty and write_duty for this chip: a PWM of 16 bits"
#endif

flywheel_controller_t controller;
flywheel_sample_t sample;
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

// The last conversion of the ADS1015, 12 bits, left-justified; a voltage below ground is none.
bool read_wheel(uint16_t *counts) {
  Wire.beginTransmission(WHEEL_SPEED);
  Wire.write((uint8_t)0x00);
  if (Wire.endTransmission(false) != 0 || Wire.requestFrom(WHEEL_SPEED, (uint8_t)2) != 2) {
    return false;
  }
  const uint8_t high = Wire.read();
  const uint8_t low = Wire.read();
  const uint16_t word = ((uint16_t)high << 8) | low;
  *counts = word < 0x8000 ? word >> 4 : 0;
  return true;
}

void setup() {
  // The motor first: zero current before anything else may fail.
  begin_duty();
  write_duty(FLYWHEEL_ZERO_CURRENT);
  Serial.begin(115200);
  Wire.begin();
  Wire.setClock(400000);
  write_register(GYRO, 0x13, 0x00);   // CTRL_REG1: standby
  write_register(GYRO, 0x0D, 0x00);   // CTRL_REG0: 2000 degrees a second
  write_register(GYRO, 0x13, 0x02);   // CTRL_REG1: 800 Hz, active
  write_register(ACCEL, 0x2A, 0x00);  // CTRL_REG1: standby
  write_register(ACCEL, 0x0E, 0x02);  // XYZ_DATA_CFG: 8 g
  write_register(ACCEL, 0x5B, 0x00);  // M_CTRL_REG1: accelerometer alone
  write_register(ACCEL, 0x2A, 0x01);  // CTRL_REG1: 800 Hz, active; its low noise would end at 4 g
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
  bool is_read = read_words(GYRO, 0x01, sample.gyro);
  is_read = read_words(ACCEL, 0x01, sample.accel) && is_read;
  is_read = read_wheel(&sample.wheel_adc) && is_read;
  // A step that comes a whole period late, or without a reading, is no step of the controller that was proved.
  if (!is_read || late_us > FLYWHEEL_SAMPLE_TIME_US) {
    flywheel_fault(&controller);
    next_step_us = micros() + FLYWHEEL_SAMPLE_TIME_US;
  }
  const uint16_t duty = flywheel_step(&controller, &sample);
  write_duty(duty);
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
    Serial.print((int)flywheel_status(&controller));
    Serial.print(',');
    Serial.print(duty);
    Serial.print(',');
    Serial.print((long)flywheel_angle(&controller.attitude));
    Serial.print(',');
    Serial.println((long)flywheel_rate(&controller.attitude));
  }
}

// The emitted controller around the sensors of its bench:
// BODY_WORDS; WHEEL_WORDS.
// The drive takes its current or its voltage from a PWM. Registers are those of the parts' data sheets. Compiled with
// Arduino's AVR core; the ESP32's part with no core, and nothing was tried on a bench. Take the wheel off, or the
// supply's current limit down, for the first power-on.
//
// What this program cannot know is marked YOUR READING: until you have written it there, the controller is told of a
// fault in each step, and nothing is driven.
//
// An AVR is too slow for 1 kHz: it runs the sketch, reports a fault at the first step and never arms.
//
// Commands on the serial line: a arms, d disarms. Every 20 ms a line: status, duty, and the words of angle and rate.
#include <Wire.h>
#include <flywheel.h>

const int DUTY_BITS = BITS_OF_THE_DUTY;

#if defined(ARDUINO_ARCH_ESP32)
const int DUTY_PIN = 25;

// Version 3 of Arduino's ESP32 core names the pin where version 2, which PlatformIO has, names a channel.
#if ESP_ARDUINO_VERSION_MAJOR >= 3
void begin_duty() {
  ledcAttach(DUTY_PIN, 1000, DUTY_BITS);  // Hz, bits
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_PIN, duty);
}
#else
const uint8_t DUTY_CHANNEL = 0;

void begin_duty() {
  ledcSetup(DUTY_CHANNEL, 1000, DUTY_BITS);  // Hz, bits
  ledcWrite(DUTY_CHANNEL, FLYWHEEL_ZERO_CURRENT);
  ledcAttachPin(DUTY_PIN, DUTY_CHANNEL);
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_CHANNEL, duty);
}
#endif
#elif defined(ARDUINO_ARCH_AVR)
// Timer 1 counts to 2^DUTY_BITS: 244 Hz with 16 bits at 16 MHz. Its first output is pin 9 of an Uno, pin 11 of a Mega.
#if defined(__AVR_ATmega2560__)
const int DUTY_PIN = 11;
#else
const int DUTY_PIN = 9;
#endif

void begin_duty() {
  OCR1A = FLYWHEEL_ZERO_CURRENT;
  ICR1 = (uint16_t)((1UL << DUTY_BITS) - 1);
  TCCR1A = _BV(COM1A1) | _BV(WGM11);
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS10);
  pinMode(DUTY_PIN, OUTPUT);
}

void write_duty(uint16_t duty) {
  OCR1A = duty;
}
#else
#error "begin_duty and write_duty for this chip: a PWM of DUTY_BITS bits"
#endif

flywheel_controller_t controller;
flywheel_sample_t sample;
uint32_t next_step_us;
uint16_t steps;

SENSORS
void setup() {
  // The motor first: zero current before anything else may fail.
  begin_duty();
  write_duty(FLYWHEEL_ZERO_CURRENT);
  Serial.begin(115200);
  Wire.begin();
  Wire.setClock(400000);
  begin_body();
  begin_wheel();
  flywheel_init(&controller);
  next_step_us = micros();
}

void loop() {
  const uint32_t late_us = micros() - next_step_us;
  if ((int32_t)late_us < 0) {
    return;
  }
  next_step_us += FLYWHEEL_SAMPLE_TIME_US;
  bool is_read = read_body();
  is_read = read_wheel() && is_read;
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
    Serial.print((long)flywheel_angle(SHOWN_BY));
    Serial.print(',');
    Serial.println((long)flywheel_rate(SHOWN_BY));
  }
}

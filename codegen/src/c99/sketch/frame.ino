// The emitted controller around the sensors of its bench:
// BODY_WORDS; WHEEL_WORDS.
// The drive takes its current or its voltage from a PWM. Registers are those of the parts' data sheets. Compiled with
// Arduino's AVR core; the ESP32's part with stand-ins for its core, and nothing was tried on a bench. Take the wheel off,
// or the supply's current limit down, for the first power-on.
//
// What this program cannot know is marked YOUR READING: until you have written it there, the controller is told of a
// fault in each step, and nothing is driven.
//
// An AVR is too slow for 1 kHz: it runs the sketch, reports a fault at the first step and never arms.
//
// The serial line belongs to `flywheel record`, which arms, drives and records: frames of bytes, no text. A Serial.print
// of your own would damage them.
#include <Wire.h>
#include <flywheel_loop.h>

// Bits of the duties that the controller returns.
const int DUTY_BITS = BITS_OF_THE_DUTY;

#if defined(ARDUINO_ARCH_ESP32)
// What `flywheel record` takes by itself.
const uint32_t BAUD = 921600;

// The timers of the ESP32 have 20 bits, those of its successors 14; the pins are free on the usual boards.
#if defined(CONFIG_IDF_TARGET_ESP32)
const int DUTY_PIN = 25;
const int TIMER_BITS = DUTY_BITS;
#else
const int DUTY_PIN = 10;
const int TIMER_BITS = DUTY_BITS < 14 ? DUTY_BITS : 14;
#endif

// Version 3 of Arduino's ESP32 core names the pin where version 2, which PlatformIO has, names a channel.
#if ESP_ARDUINO_VERSION_MAJOR >= 3
void begin_duty() {
  ledcAttach(DUTY_PIN, 1000, TIMER_BITS);  // Hz, bits
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_PIN, duty >> (DUTY_BITS - TIMER_BITS));
}
#else
const uint8_t DUTY_CHANNEL = 0;

void begin_duty() {
  ledcSetup(DUTY_CHANNEL, 1000, TIMER_BITS);  // Hz, bits
  ledcWrite(DUTY_CHANNEL, FLYWHEEL_ZERO_CURRENT >> (DUTY_BITS - TIMER_BITS));
  ledcAttachPin(DUTY_PIN, DUTY_CHANNEL);
}

void write_duty(uint16_t duty) {
  ledcWrite(DUTY_CHANNEL, duty >> (DUTY_BITS - TIMER_BITS));
}
#endif
#elif defined(ARDUINO_ARCH_AVR)
const uint32_t BAUD = 115200;

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
#error "BAUD, begin_duty and write_duty for this chip: the serial line, and a PWM of DUTY_BITS bits"
#endif

// Time after which a sensor that does not answer is started again, us. The controller has tripped by then.
const uint32_t RETRY_US = 500000;
// Bytes that are read before each look at the clock: a line that never ends must not hold the steps up.
const uint8_t BYTES_AT_ONCE = 16;

flywheel_loop_t balance;
flywheel_sample_t sample;
uint32_t next_step_us;
uint32_t retry_us;

SENSORS
void setup() {
  // The motor first: zero current before anything else may fail.
  begin_duty();
  write_duty(FLYWHEEL_ZERO_CURRENT);
  Serial.begin(BAUD);
  Wire.begin();
  Wire.setClock(400000);
  begin_body();
  begin_wheel();
  flywheel_loop_init(&balance);
  next_step_us = micros();
  retry_us = next_step_us;
}

void loop() {
  for (uint8_t count = 0; count < BYTES_AT_ONCE && Serial.available() > 0; count++) {
    flywheel_loop_received(&balance, (uint8_t)Serial.read(), micros());
  }
  const uint32_t now_us = micros();
  if ((int32_t)(now_us - next_step_us) < 0) {
    return;
  }
  next_step_us += FLYWHEEL_SAMPLE_TIME_US;
  bool is_read = read_body();
  is_read = read_wheel() && is_read;
  // A step that comes late, or without a reading, is a fault, after which no current flows.
  write_duty(flywheel_loop_tick(&balance, now_us, is_read ? &sample : NULL));
  // A frame that the line has no room for is left out; `flywheel record` counts it as lost.
  uint8_t frame[FLYWHEEL_FRAME_BYTES];
  const uint8_t length = flywheel_loop_frame(&balance, frame);
  if (length > 0 && Serial.availableForWrite() >= (int)length) {
    Serial.write(frame, length);
  }
  if (!is_read && micros() - retry_us > RETRY_US) {
    begin_body();
    begin_wheel();
    retry_us = micros();
  }
  // After any delay the steps go on from now; the loop has noticed the delay by its clock.
  if ((int32_t)(micros() - next_step_us) > (int32_t)FLYWHEEL_SAMPLE_TIME_US) {
    next_step_us = micros();
  }
}

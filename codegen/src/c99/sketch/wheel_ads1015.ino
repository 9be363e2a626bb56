
// An ADS1015 on the speed output of the drive, 2 mV a count. bench.toml does not name the converter: for another one,
// YOUR READING takes the place of these two functions, with the counts that are stated above.
const uint8_t WHEEL_SPEED = 0x48;

void begin_wheel() {
  Wire.beginTransmission(WHEEL_SPEED);  // AIN0 against ground, 4.096 V, 3300 a second, without pause
  Wire.write((uint8_t)0x01);
  Wire.write((uint8_t)0xC2);
  Wire.write((uint8_t)0xC3);
  Wire.endTransmission();
}

bool read_wheel() {
  uint8_t bytes[2];
  if (!read_bytes(WHEEL_SPEED, 0x00, bytes, 2)) {
    return false;
  }
  // 12 bits, left-justified; a voltage below ground is none.
  const uint16_t word = word_of(bytes);
  sample.wheel_adc = word < 0x8000 ? word >> 4 : 0;
  return true;
}

// Reads bytes from a register on. False where the bus fails.
bool read_bytes(uint8_t device, uint8_t address, uint8_t *bytes, uint8_t count) {
  Wire.beginTransmission(device);
  Wire.write(address);
  if (Wire.endTransmission(false) != 0 || Wire.requestFrom(device, count) != count) {
    return false;
  }
  for (uint8_t place = 0; place < count; place++) {
    bytes[place] = Wire.read();
  }
  return true;
}

// A word, upper byte first.
uint16_t word_of(const uint8_t *bytes) {
  return ((uint16_t)bytes[0] << 8) | bytes[1];
}

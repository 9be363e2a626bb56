
void write_register(uint8_t device, uint8_t address, uint8_t value) {
  Wire.beginTransmission(device);
  Wire.write(address);
  Wire.write(value);
  Wire.endTransmission();
}

// Three words from bytes.
void take_axes(const uint8_t *bytes, int16_t words[3]) {
  for (uint8_t axis = 0; axis < 3; axis++) {
    words[axis] = (int16_t)word_of(bytes + 2 * axis);
  }
}

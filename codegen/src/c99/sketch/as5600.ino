
// AS5600 WHERE. Every 64th time it is asked for its magnet too: STATUS has MD where one is there, ML or
// MH where it is too weak or too strong.
const uint8_t ENCODER = 0x36;
uint8_t since_check;

void begin_PART() {
}

bool read_PART() {
  uint8_t status;
  if (since_check++ % 64 == 0 && (!read_bytes(ENCODER, 0x0B, &status, 1) || (status & 0x38) != 0x20)) {
    since_check = 0;
    return false;
  }
  uint8_t bytes[2];  // RAW ANGLE
  if (!read_bytes(ENCODER, 0x0C, bytes, 2)) {
    return false;
  }
  sample.FIELD = word_of(bytes) & 0x0FFF;
  return true;
}

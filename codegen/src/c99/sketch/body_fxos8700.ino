
// FXAS21002C (gyroscope) and FXOS8700 (accelerometer).
const uint8_t GYRO = 0x21;
const uint8_t ACCEL = 0x1F;

void begin_body() {
  write_register(GYRO, 0x13, 0x00);   // CTRL_REG1: standby
  write_register(GYRO, 0x0D, 0x00);   // CTRL_REG0: 2000 degrees a second
  write_register(GYRO, 0x13, 0x02);   // CTRL_REG1: 800 Hz, active
  write_register(ACCEL, 0x2A, 0x00);  // CTRL_REG1: standby
  write_register(ACCEL, 0x0E, 0x02);  // XYZ_DATA_CFG: 8 g
  write_register(ACCEL, 0x5B, 0x00);  // M_CTRL_REG1: accelerometer alone
  write_register(ACCEL, 0x2A, 0x01);  // CTRL_REG1: 800 Hz, active; its low noise would end at 4 g
}

bool read_body() {
  uint8_t turn[6];
  uint8_t up[6];
  if (!read_bytes(GYRO, 0x01, turn, 6) || !read_bytes(ACCEL, 0x01, up, 6)) {
    return false;
  }
  take_axes(turn, sample.gyro);
  take_axes(up, sample.accel);
  return true;
}

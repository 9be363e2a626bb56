
// MPU-6050 (gyroscope and accelerometer).
const uint8_t BODY = 0x68;

void begin_body() {
  write_register(BODY, 0x6B, 0x80);  // PWR_MGMT_1: reset, after which the registers are not heard for 100 ms
  delay(100);
  write_register(BODY, 0x6B, 0x01);  // PWR_MGMT_1: awake, on the gyroscope's clock
  write_register(BODY, 0x1A, 0x01);  // CONFIG: low-pass filter at 188 Hz, 1 kHz
  write_register(BODY, 0x19, 0x00);  // SMPLRT_DIV
  write_register(BODY, 0x1B, 0x18);  // GYRO_CONFIG: 2000 degrees a second
  write_register(BODY, 0x1C, 0x10);  // ACCEL_CONFIG: 8 g
}

bool read_body() {
  uint8_t bytes[14];  // acceleration, temperature, rate
  if (!read_bytes(BODY, 0x3B, bytes, 14)) {
    return false;
  }
  take_axes(bytes, sample.accel);
  take_axes(bytes + 8, sample.gyro);
  return true;
}

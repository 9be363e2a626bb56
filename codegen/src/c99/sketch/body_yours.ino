
void begin_body() {
  // YOUR READING: start gyroscope and accelerometer in the ranges that are stated above.
}

bool read_body() {
  // YOUR READING: sample.gyro and sample.accel, raw counts x y z as the part gives them; then `return true`.
  return false;
}

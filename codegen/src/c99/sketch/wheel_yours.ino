
void begin_wheel() {
  // YOUR READING: start HOW.
}

bool read_wheel() {
  // YOUR READING: sample.FIELD, WHAT; then `return true`.
  return false;
}

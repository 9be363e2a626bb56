
void begin_body() {
  // YOUR READING: start the encoder on the pivot.
}

bool read_body() {
  // YOUR READING: sample.body_count, the count of the encoder as stated above; then `return true`.
  return false;
}

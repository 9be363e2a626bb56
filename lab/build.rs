//! Which tests can run here.

fn main() {
    test_conditions::declare(&[test_conditions::Condition::Chromium]);
}

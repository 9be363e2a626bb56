//! Which tests can run on this machine.

use test_conditions::Condition;

fn main() {
    test_conditions::declare(&[Condition::Recordings]);
}

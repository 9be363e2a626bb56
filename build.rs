//! Which tests can run on this machine.

use std::env;

use test_conditions::Condition;

fn main() {
    test_conditions::declare(&[Condition::Recordings, Condition::Gcc]);
    // A sketch of Arduino is C++.
    println!("cargo::rustc-check-cfg=cfg(have_gxx)");
    let path = env::var_os("PATH").unwrap_or_default();
    if env::split_paths(&path).any(|folder| folder.join("g++").is_file()) {
        println!("cargo::rustc-cfg=have_gxx");
    }
}

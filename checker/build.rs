//! Which tests can run on this machine.

use std::env;

/// Tells cargo and the compiler whether there is such a program; it may be installed later.
fn declare(program: &str) {
    println!("cargo::rustc-check-cfg=cfg(have_{program})");
    println!("cargo::rerun-if-env-changed=PATH");
    let name = format!("{program}{}", env::consts::EXE_SUFFIX);
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = env::split_paths(&path).filter(|folder| folder.is_dir());
    let mut is_found = false;
    for folder in folders {
        println!("cargo::rerun-if-changed={}", folder.display());
        is_found |= folder.join(&name).is_file();
    }
    if is_found {
        println!("cargo::rustc-cfg=have_{program}");
    }
}

fn main() {
    declare("z3");
}

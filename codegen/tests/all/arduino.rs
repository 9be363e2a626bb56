//! The example sketch as Arduino builds it: with Arduino's AVR core, to an image that links.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use codegen::{c99, generate};

use crate::thesis;

/// Arduino's AVR core, as Debian has it.
const CORE: &str = env!("ARDUINO_AVR");

/// Files of a folder with one of these endings.
fn sources(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of the core");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.retain(|file| {
        let ending = file.extension().and_then(OsStr::to_str);
        ending.is_some_and(|ending| endings.contains(&ending))
    });
    files.sort();
    files
}

fn run(command: &mut Command) -> String {
    let result = command.output().expect("the compiler runs");
    let said = String::from_utf8_lossy(&result.stderr).into_owned();
    assert!(result.status.success(), "{command:?}: {said}");
    said
}

/// Bytes of the sections that go into flash.
fn flash_bytes(image: &Path) -> usize {
    let table = Command::new("avr-size")
        .arg(image)
        .output()
        .expect("avr-size");
    let text = String::from_utf8_lossy(&table.stdout).into_owned();
    let row = text.lines().nth(1).expect("a row of sizes");
    row.split_whitespace()
        .take(2)
        .map(|bytes| bytes.parse::<usize>().expect("a size"))
        .sum()
}

#[test]
#[cfg_attr(
    not(all(have_arduino_avr, have_cross_gcc)),
    ignore = "needs the AVR core of Arduino"
)]
fn the_sketch_links_with_arduinos_avr_core() {
    let folder = tempfile::tempdir().expect("a folder");
    let emitted = generate(&thesis::spec()).expect("an emitted crate");
    let library = c99::emit(&emitted).expect("a translation");
    library.write(folder.path()).expect("written");
    let sketch = folder.path().join("examples/flywheel/flywheel.ino");
    let sketch = fs::read_to_string(sketch).expect("the sketch");
    // What Arduino puts before a sketch.
    let translated = folder.path().join("flywheel.ino.cpp");
    fs::write(&translated, format!("#include <Arduino.h>\n{sketch}")).expect("written");
    let core = Path::new(CORE);
    // Uno and Mega, and what each has of flash beside its boot loader.
    for (chip, variant, flash) in [
        ("atmega328p", "standard", 32_256),
        ("atmega2560", "mega", 253_952),
    ] {
        let objects = folder.path().join(chip);
        fs::create_dir(&objects).expect("a folder");
        let includes = [
            core.join("cores/arduino"),
            core.join("variants").join(variant),
            core.join("libraries/Wire/src"),
            folder.path().join("src"),
        ];
        let mut files = vec![translated.clone(), folder.path().join("src/flywheel.c")];
        files.extend(sources(&core.join("cores/arduino"), &["c", "cpp", "S"]));
        files.extend(sources(&core.join("libraries/Wire/src"), &["cpp"]));
        files.extend(sources(&core.join("libraries/Wire/src/utility"), &["c"]));
        for file in &files {
            let is_cpp = file.extension() == Some(OsStr::new("cpp"));
            let is_ours = file.starts_with(folder.path());
            let mut compiler = Command::new(if is_cpp { "avr-g++" } else { "avr-gcc" });
            // The options of the core's platform.txt.
            compiler
                .arg(format!("-mmcu={chip}"))
                .args(["-c", "-Os", "-ffunction-sections", "-fdata-sections"])
                .args(["-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_ARCH_AVR"])
                .args(includes.iter().map(|path| format!("-I{}", path.display())));
            if is_cpp {
                compiler.args(["-std=gnu++11", "-fpermissive", "-fno-exceptions"]);
                compiler.arg("-fno-threadsafe-statics");
            }
            if is_ours {
                compiler.args(["-Wall", "-Wextra"]);
            } else {
                // Debian's compiler is older than its core, and names this only for C.
                compiler.arg("-DDECIMAL_DIG=__DECIMAL_DIG__");
            }
            let name = file.file_name().expect("a name").to_string_lossy();
            let said = run(compiler
                .arg(file)
                .arg("-o")
                .arg(objects.join(format!("{name}.o"))));
            if is_ours {
                let own: Vec<&str> = said
                    .lines()
                    .filter(|line| line.contains("flywheel"))
                    .collect();
                assert_eq!(own, [""; 0], "{chip}");
            }
        }
        let image = objects.join("image.elf");
        run(Command::new("avr-gcc")
            .arg(format!("-mmcu={chip}"))
            .args(["-Os", "-Wl,--gc-sections", "-o"])
            .arg(&image)
            .args(sources(&objects, &["o"]))
            .arg("-lm"));
        let bytes = flash_bytes(&image);
        println!("{chip}: {bytes} bytes");
        assert!(bytes < flash, "{chip}: {bytes} bytes");
    }
}

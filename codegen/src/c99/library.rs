//! The files that make a library of header and source: README, and the descriptions for Arduino and PlatformIO.

use crate::crate_name::CrateName;
use crate::file::{EmittedFile, MARK};

/// README, `library.properties` (Arduino) and `library.json` (PlatformIO).
pub fn files(name: &CrateName, title: &str, has_monitor: bool) -> Vec<EmittedFile> {
    let library = name.of_library();
    let file = |path: &str, contents: String| EmittedFile {
        path: path.to_string(),
        contents,
    };
    vec![
        file("README.md", readme(library, title, has_monitor)),
        file("library.properties", library_properties(library)),
        file("library.json", library_json(library)),
    ]
}

fn readme(library: &str, title: &str, has_monitor: bool) -> String {
    let monitor = match has_monitor {
        true => {
            " After each step call `flywheel_monitor_allows` with what it measured (`flywheel_angle`, `flywheel_rate`, \
             `flywheel_wheel_speed`) and its duty, and `flywheel_fault` where that returns 0."
        }
        false => "",
    };
    format!(
        r#"<!-- {title} -->

# {library}

The controller of one reaction-wheel pendulum in C99: raw sensor counts in, duty of the motor's timer out. It is fixed point without floats or heap, and needs nothing but `<stdint.h>`; the controller, `src/flywheel.c`, has no loops either. The folder is a library for Arduino (copy it into `libraries/` of the sketchbook) and for PlatformIO (name it in `lib_deps`). Any other firmware compiles the files in `src/` and includes `src/flywheel_loop.h`, or `src/flywheel.c` and `src/flywheel.h` alone.

```c
#include "flywheel.h"

static flywheel_controller_t controller; /* flywheel_init(&controller) before the first step */

/* Every FLYWHEEL_SAMPLE_TIME_US, with the sensors' words, or without where one did not answer. */
uint16_t tick(const flywheel_sample_t *sample, uint8_t sensors_answer, uint8_t user_wants_it) {{
    if (!sensors_answer) flywheel_fault(&controller); /* no current until flywheel_arm succeeds again */
    if (user_wants_it) flywheel_arm(&controller); /* at start and after each trip; returns 1 once it is armed */
    return flywheel_step(&controller, sample); /* the duty; FLYWHEEL_ZERO_CURRENT unless it runs */
}}
```

`src/flywheel_loop.h` has a loop around it, with which `flywheel record` arms, drives and records the bench over the serial line.{monitor} `examples/flywheel/flywheel.ino` is a whole sketch for the sensors of the bench; where it says YOUR READING, it is for you to write. `certificate.json` states what is claimed of the controller; `flywheel prove` checks it on the Rust that `flywheel generate` writes without `--language c`, of which this is a translation.

Do not change a file here by hand. Change `model.toml`, or change `bench.toml` and run `flywheel identify`, which copies its `[hardware]` into model.toml. Then run `flywheel generate` again.
"#
    )
}

fn library_properties(library: &str) -> String {
    format!(
        "# {MARK}; do not edit.\n\
         name={library}\n\
         version=0.1.0\n\
         author=flywheel\n\
         maintainer=flywheel\n\
         sentence=Fixed-point controller of a reaction-wheel pendulum.\n\
         paragraph=Raw sensor counts in, duty of the timer out. Emitted for one bench.\n\
         category=Device Control\n\
         url=https://example.invalid/flywheel\n\
         architectures=*\n\
         includes=flywheel.h\n"
    )
}

fn library_json(library: &str) -> String {
    format!(
        "{{\n  \"_comment\": \"{MARK}; do not edit.\",\n  \"name\": \"{library}\",\n  \"version\": \"0.1.0\",\n  \
         \"description\": \"Fixed-point controller of a reaction-wheel pendulum\",\n  \
         \"frameworks\": \"*\",\n  \"platforms\": \"*\",\n  \
         \"build\": {{ \"flags\": [\"-std=c99\"] }}\n}}\n"
    )
}

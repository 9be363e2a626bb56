//! `README.md` of the emitted crate: a description, and the use of the crate in a firmware.

use crate::crate_name::CrateName;
use crate::emit::{example, header, single_line};
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// Emits `README.md`.
pub fn file(spec: &ModuleSpec, name: &CrateName) -> EmittedFile {
    let header = header(spec);
    let model = single_line(&spec.model_name);
    let example = example::lines(name, &spec.parts()).join("\n");
    let contents = format!(
        r#"<!-- {header}. -->

# {name}

The controller of one reaction-wheel pendulum, from the model `{model}`: raw sensor counts in, duty of the motor's timer out. It is `no_std` Rust in fixed point, without floats, heap, loops or panics, and needs nothing but `core` and the crate `fixed`.

In the `Cargo.toml` of the firmware:

```toml
[dependencies]
{name} = {{ path = "path/to/this/folder" }}
```

In its loop:

```rust
{example}
```

- `cargo doc --open` in this folder shows the sensors and the drive that it is made for, and the unit of each number.
- `cargo test` in this folder compiles and runs the example above.
- `src/constants.rs` states when the controller can be armed and when it trips (zero current).
- `certificate.json` states the claims about this crate. `flywheel prove` checks them from these files alone.

Do not change a file here by hand. Change `model.toml`, or change `bench.toml` and run `flywheel identify`, which copies its `[hardware]` into model.toml. Then run `flywheel generate` again.
"#
    );
    EmittedFile {
        path: "README.md".to_owned(),
        contents,
    }
}

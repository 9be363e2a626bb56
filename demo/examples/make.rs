//! Writes the files of the demonstration bench anew: `cargo run -p demo --example make`.

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench");
    std::fs::create_dir_all(&folder)?;
    for file in demo::make()? {
        std::fs::write(folder.join(file.name), &file.text)?;
        println!("{} ({} bytes)", file.name, file.text.len());
    }
    Ok(())
}

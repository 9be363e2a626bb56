//! CLAIMS.md is what the table says.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::document::claims;
use checker::prove::prove;
use checker::{Module, ProofSettings};

#[test]
fn the_committed_file_is_current() {
    let folder = Path::new("../generated");
    // The engines of a claim are the same whether or not they are installed here.
    let settings = ProofSettings {
        cases: 20,
        compiled: false,
        smt: false,
        kani: false,
        closed_loop: false,
        python: false,
        ..ProofSettings::default()
    };
    let results = prove(folder, None, &settings, &|_| ()).unwrap();
    let module = Module::read(folder).unwrap();
    let text = claims(&Certificate::read(folder).unwrap(), &module, &results);
    let committed = std::fs::read_to_string("../CLAIMS.md").unwrap();
    assert_eq!(committed, text, "write this text into CLAIMS.md:\n{text}");
}

#[test]
fn every_word_of_the_bench_is_traced() {
    let folder = Path::new("../generated");
    let module = Module::read(folder).unwrap();
    let text = claims(&Certificate::read(folder).unwrap(), &module, &[]);
    let constants = &module.declarations().constants;
    let mut count = 0;
    for constant in constants {
        if *constant.place.file != *"src/constants.rs" {
            continue;
        }
        for (name, value) in module.constant_words("constants", &constant.name).unwrap() {
            let row = format!("| `{name}` | ");
            let line = text.lines().find(|line| line.starts_with(&row));
            let line = line.unwrap_or_else(|| panic!("{name} is not traced"));
            assert!(line.contains(&format!("| {value} |")), "{line}");
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
}

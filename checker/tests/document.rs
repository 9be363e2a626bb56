//! CLAIMS.md is what the table says.

use std::path::Path;

use checker::Settings;
use checker::certificate::Certificate;
use checker::document::claims;
use checker::prove::prove;

#[test]
fn the_committed_file_is_current() {
    let folder = Path::new("../generated");
    // The engines of a claim are the same whether or not they are installed here.
    let settings = Settings {
        cases: 20,
        smt: false,
        kani: false,
        closed_loop: false,
        ..Settings::default()
    };
    let results = prove(folder, &settings).unwrap();
    let text = claims(&Certificate::read(folder).unwrap(), &results);
    let committed = std::fs::read_to_string("../CLAIMS.md").unwrap();
    assert_eq!(committed, text, "write this text into CLAIMS.md:\n{text}");
}

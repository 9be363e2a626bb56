use checker::*;
use std::path::Path;
#[test]
fn scratch() {
    let dir = Path::new("../generated");
    for r in prove::prove(dir, &Settings::default()).unwrap() { println!("{:26} {:26} {:8} {:.3} {}", r.id, r.engine, r.outcome.word(), r.seconds, r.outcome.detail()); }
}

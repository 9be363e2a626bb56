use checker::*;
use checker::certificate::Certificate;
use checker::control_law::ControlLaw;
use std::path::Path;
#[test]
fn scratch() {
    let dir = Path::new("../generated");
    let module = Module::read(dir).unwrap();
    let c = Certificate::read(dir).unwrap();
    let law = ControlLaw::read(&module).unwrap();
    let mut files: Vec<String> = module.texts().iter().map(|(p,_)| p.clone()).collect(); files.push("Cargo.toml".into());
    println!("{:?}", consistency::check(&c, &module, &law, &files));
    println!("{:?}", hardware::check(&c, &module, &law));
}

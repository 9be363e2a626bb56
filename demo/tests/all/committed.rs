//! The committed files are what the generator makes.

#[test]
fn the_committed_files_are_what_the_generator_makes() {
    let made = demo::make().expect("the bench can be simulated");
    assert_eq!(made.len(), demo::FILES.len());
    for (file, (name, committed)) in made.iter().zip(demo::FILES) {
        assert_eq!(file.name, name);
        assert!(
            file.text == committed,
            "{name} differs: cargo run -p demo --example make"
        );
    }
}

#[test]
fn the_bench_is_small_enough_to_ship() {
    let bytes: usize = demo::FILES.iter().map(|(_, text)| text.len()).sum();
    assert!(bytes < 1_500_000, "{bytes} bytes");
}

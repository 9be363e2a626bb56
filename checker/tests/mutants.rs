//! At least 95 % of small damages to the source are noticed; survivors are listed with the reason.

use std::path::Path;

use checker::certificate::Certificate;
use checker::mutate::{applied, chosen, judged, mutants, notices, summary};
use checker::prove::Emitted;

#[test]
fn most_damages_are_noticed_and_survivors_are_listed() {
    let emitted = Emitted::read(Path::new("../generated")).unwrap();
    let certificate = Certificate::parse(&emitted.certificate).unwrap();
    assert_eq!(notices(&emitted, &certificate), [], "undamaged");
    let verdicts: Vec<_> = chosen(&emitted, Some(14))
        .into_iter()
        .map(|mutant| judged(&emitted, &certificate, mutant))
        .collect();
    let summary = summary(&verdicts);
    for verdict in verdicts.iter().filter(|verdict| verdict.noticed.is_empty()) {
        let m = &verdict.mutant;
        eprintln!(
            "survives: {}:{}:{} {}: `{}` -> `{}`: {}",
            m.file, m.line, m.column, m.kind, m.before, m.after, verdict.reason
        );
    }
    eprintln!("{summary:?}");
    assert!(summary.mutants > 150, "{}", summary.mutants);
    // Of all mutants, the harmless ones among them.
    assert!(summary.caught * 100 >= summary.mutants * 95, "{summary:?}");
}

#[test]
fn a_mutant_changes_its_place_and_nothing_else() {
    let text = "/// 5 ü\npub fn f(a: i32) -> i32 {\n    (a + 7) >> 3\n}\n";
    let found = mutants("src/x.rs", text);
    assert!(found.iter().all(|mutant| mutant.line == 3));
    let texts: Vec<_> = found.iter().map(|mutant| applied(text, mutant)).collect();
    for wanted in [
        "(a - 7) >> 3",
        "(a + 8) >> 3",
        "(a + 7) >> 2",
        "(a + 7) << 3",
        "(a + -7) >> 3",
    ] {
        assert!(texts.iter().any(|text| text.contains(wanted)), "{wanted}");
    }
}

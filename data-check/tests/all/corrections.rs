//! A proposal that its user corrects.

use std::fs;

use data_check::{Corrections, propose, propose_with};

/// A swing in degrees whose columns say nothing.
fn log() -> String {
    let mut text = "a,b,c\n".to_owned();
    for k in 0..3000 {
        let time = 0.01 * f64::from(k);
        let angle = 20.0 * (-0.05 * time).exp() * (10.0 * time).cos();
        text.push_str(&format!("{time},{angle},{}\n", 0.5 * angle));
    }
    text
}

#[test]
fn what_is_corrected_is_written_and_keeps_its_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    fs::write(&file, log()).expect("a log");
    let files = [file];
    let first = propose(folder.path(), &files).expect("a proposal");
    assert_eq!(first.experiments[0].column_names, ["a", "b", "c"]);

    let mut choices = first.experiments[0].choices.clone();
    let column = |channel: &str, column: &str, unit: Option<&str>| data_check::ColumnChoice {
        channel: channel.to_owned(),
        column: column.to_owned(),
        unit: unit.map(str::to_owned),
        ..Default::default()
    };
    choices.kind = "free-swing".to_owned();
    choices.columns = vec![
        column("time", "a", Some("s")),
        column("angle", "b", Some("deg")),
    ];
    choices.until_s = Some(12.5);
    let mut corrections = Corrections::default();
    corrections
        .files
        .insert("log.csv".to_owned(), choices.clone());
    corrections.known.insert("gravity_torque".to_owned(), 0.245);
    let (second, refused) = propose_with(folder.path(), &files, &corrections).expect("a proposal");
    assert_eq!(refused, Vec::<String>::new());
    for line in [
        "angle = \"b\"",
        "units = { angle = \"deg\" }",
        "until = 12.5",
        "gravity_torque  = 0.245",
        "# not used: c",
        "corrected by hand",
    ] {
        assert!(second.text.contains(line), "{line}\n{}", second.text);
    }
    assert_eq!(second.open, None, "{}", second.text);
    // The same again changes nothing: what is shown is what is written.
    corrections
        .files
        .insert("log.csv".to_owned(), second.experiments[0].choices.clone());
    let (third, _) = propose_with(folder.path(), &files, &corrections).expect("a proposal");
    assert_eq!(third.text, second.text);
}

#[test]
fn nonsense_is_named_and_leaves_the_proposal() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    fs::write(&file, log().replace("a,b,c", "time_s,angle_deg,rate_dps")).expect("a log");
    let files = [file];
    let first = propose(folder.path(), &files).expect("a proposal");
    let choices = &first.experiments[0].choices;
    let wrong = |change: &dyn Fn(&mut data_check::Choices)| {
        let mut changed = choices.clone();
        change(&mut changed);
        let mut corrections = Corrections::default();
        corrections.files.insert("log.csv".to_owned(), changed);
        let (proposal, refused) =
            propose_with(folder.path(), &files, &corrections).expect("a proposal");
        assert_eq!(proposal.experiments[0].choices.columns, choices.columns);
        refused.join(" ")
    };
    assert!(wrong(&|one| one.kind = "swing".to_owned()).contains("\"swing\" is no kind"));
    assert!(wrong(&|one| one.columns[1].column = "x".to_owned()).contains("no column \"x\""));
    assert!(wrong(&|one| one.columns[1].unit = Some("rpm".to_owned())).contains("known are rad"));
    assert!(
        wrong(&|one| one.columns[1].channel = "height".to_owned())
            .contains("\"height\" is no channel")
    );
    assert!(
        wrong(&|one| one.columns[1].column = one.columns[0].column.clone()).contains("used twice")
    );
}

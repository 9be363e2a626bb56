//! The kind of experiment that is proposed for a log.

use std::fs;

use data_check::{Proposal, propose};

/// A swing of half a radian at 10 rad/s, with the wheel's speed as `wheel` makes it of the body's rate, and a current
/// sensor whose zero wanders.
fn proposed(current: &str, wheel: impl Fn(f64) -> f64) -> Proposal {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    let mut text = format!("time_s,angle_rad,wheel_speed_rad_s,{current}\n");
    for k in 0..2000 {
        let time = 0.02 * f64::from(k);
        let size = 0.5 * (-0.05 * time).exp();
        let (angle, rate) = (
            size * (10.0 * time).cos(),
            -10.0 * size * (10.0 * time).sin(),
        );
        let current = 0.1 + 0.05 * (0.2 * time).sin();
        text.push_str(&format!(
            "{time:.2},{angle:.5},{:.4},{current:.4}\n",
            wheel(rate)
        ));
    }
    fs::write(&file, text).expect("a log");
    propose(folder.path(), &[file]).expect("a proposal")
}

fn kind_of(proposal: &Proposal) -> &str {
    &proposal.experiments[0].choices.kind
}

/// A wheel that stays with the body is locked, or stuck, whatever the current's column shows.
#[test]
fn a_swing_with_a_still_wheel_is_a_free_swing() {
    assert_eq!(
        kind_of(&proposed("current_A", |rate| 0.02 * rate)),
        "free-swing"
    );
}

/// A wheel that is free keeps its own motion, so that it turns against the body, at rest or at speed. No current
/// flows, whatever its sensor says: it would turn the wheel.
#[test]
fn a_swing_with_a_free_wheel_is_driven_without_current() {
    for own_speed in [0.0, 40.0] {
        let proposal = proposed("motor current [A]", |rate| own_speed - rate);
        assert_eq!(kind_of(&proposal), "driven", "{:?}", proposal.experiments);
        let text = &proposal.text;
        assert!(text.contains("\nconstants = { current = 0.0 }"), "{text}");
        assert_eq!(proposal.open, None);
        assert!(proposal.findings.is_empty(), "{:?}", proposal.findings);
        // A column with the standard name is read whatever is proposed: its user must decide.
        let proposal = proposed("current_A", |rate| own_speed - rate);
        assert_eq!(kind_of(&proposal), "driven");
        let asked = &proposal.experiments[0].questions;
        assert!(
            asked.iter().any(|one| one.contains("current = 0.0")),
            "{asked:?}"
        );
    }
}

/// A wheel that a motor turns beside the swing is not free.
#[test]
fn a_swing_with_a_driven_wheel_keeps_its_current() {
    let proposal = proposed("motor current [A]", |rate| -3.0 * rate);
    assert!(
        !proposal.text.contains("\nconstants = {"),
        "{}",
        proposal.text
    );
}

/// A free swing whose angle starts again at 360 below hanging, with an index for the lines: it is in degrees, needs no
/// offset, and the index is no current.
#[test]
fn an_angle_that_starts_again_after_360_is_in_degrees() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    let mut text = "time_s,angle,sample\n".to_owned();
    for k in 0..2000 {
        let time = 0.02 * f64::from(k);
        let angle = 40.0 * (-0.05 * time).exp() * (10.0 * time).cos();
        text.push_str(&format!("{time:.2},{:.3},{k}\n", angle.rem_euclid(360.0)));
    }
    fs::write(&file, text).expect("a log");
    let proposal = propose(folder.path(), &[file]).expect("a proposal");
    let choices = &proposal.experiments[0].choices;
    assert_eq!(choices.kind, "free-swing");
    assert_eq!(choices.offset_rad, None);
    let told: Vec<(&str, Option<&str>)> = choices
        .columns
        .iter()
        .map(|one| (one.channel.as_str(), one.unit.as_deref()))
        .collect();
    assert_eq!(told, [("time", Some("s")), ("angle", Some("deg"))]);
}

/// What turns of a wheel are called is its angle, and no speed. A sensor that starts again after 1 counts turns.
#[test]
fn turns_of_a_wheel_are_its_angle() {
    for (name, unit) in [("wheel_rev", Some("rev")), ("wheel_pos", Some("rev"))] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("log.csv");
        let mut text = format!("time_s,{name},current_A\n");
        for k in 0..400 {
            let time = 0.005 * f64::from(k);
            let turns = 3.0 * time * time;
            text.push_str(&format!("{time:.3},{:.5},0.3\n", turns % 1.0));
        }
        fs::write(&file, text).expect("a log");
        let proposal = propose(folder.path(), &[file]).expect("a proposal");
        let columns = &proposal.experiments[0].choices.columns;
        let turns = columns.iter().find(|one| one.column == name).expect(name);
        assert_eq!(
            (turns.channel.as_str(), turns.unit.as_deref()),
            ("wheel_angle", unit)
        );
    }
}

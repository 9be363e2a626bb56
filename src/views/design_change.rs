//! The changes in the controller that a new model makes.

use workbench::numbers::{complex, degrees, significant};
use workbench::{DesignChange, DesignSummary};

use crate::report::table::{Align, Table};

/// The table of earlier and new values.
pub fn text(change: &DesignChange) -> String {
    let mut table = Table::new(&[
        ("", Align::Left),
        ("before", Align::Left),
        ("after", Align::Left),
    ]);
    let gains = |summary: &DesignSummary| {
        let gains = summary.gains.map(|gain| significant(gain, 6));
        gains.join(", ")
    };
    let poles = |poles: &[[f64; 2]]| {
        let poles: Vec<String> = poles.iter().map(|[re, im]| complex(*re, *im)).collect();
        poles.join(", ")
    };
    let angle = |summary: &DesignSummary| degrees(summary.recovery_angle_rad);
    let (before, after) = (&change.before, &change.after);
    table.row(["gains K".to_owned(), gains(before), gains(after)]);
    table.row([
        "open-loop poles, 1/s".to_owned(),
        poles(&before.open_loop_poles),
        poles(&after.open_loop_poles),
    ]);
    table.row([
        "closed-loop poles, 1/s".to_owned(),
        poles(&before.closed_loop_poles_per_s),
        poles(&after.closed_loop_poles_per_s),
    ]);
    table.row(["recovery angle".to_owned(), angle(before), angle(after)]);
    format!(
        "\nWhat the new model changes in the design\n{}",
        table.text()
    )
}

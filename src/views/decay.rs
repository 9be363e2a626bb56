//! The decay of the free swings, as a table.

use workbench::SwingDecay;
use workbench::numbers::{significant, with_uncertainty};
use workbench::words::amplitude_law;

use crate::report::table::{Align, Table};

/// The table of all swings; empty if there are none.
pub fn text(decays: &[SwingDecay]) -> String {
    let mut table = Table::new(&[
        ("experiment", Align::Left),
        ("best law for the amplitude", Align::Left),
        ("error of the law", Align::Right),
        ("period, small against large swings", Align::Left),
    ]);
    for decay in decays {
        let (law, rest) = match decay.laws.first() {
            Some(law) => (
                amplitude_law(law),
                format!("{} %", significant(100.0 * law.relative_rms, 2)),
            ),
            None => ("–".to_owned(), "–".to_owned()),
        };
        let drift = with_uncertainty(
            decay.period_drift_percent,
            Some(decay.period_drift_percent_std),
        );
        table.row([decay.experiment.clone(), law, rest, format!("{drift} %")]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "\nHow the free swings die out, without any model: dA/dt = −(C + V A + Q A²)\n{}",
        table.text()
    )
}

//! The sections of model.toml beside `[hardware]`.

use super::{KeySection, NEEDED, key};

/// `[parameters]`.
pub(super) const PARAMETERS: KeySection = KeySection {
    name: "parameters",
    heading: "[parameters.total_inertia]",
    meaning: "A parameter; the section stands once for each, under its name.",
    keys: &[
        key("value", "`unit`", NEEDED, "value = 2.30344e-3", "its value"),
        key(
            "std",
            "`unit`",
            "taken as exact",
            "std = 1.2e-6",
            "its standard error",
        ),
        key(
            "unit",
            "",
            "SI",
            "unit = \"kg m2\"",
            "the SI unit; \"… per kg m2\" where torques are known per unit of inertia only",
        ),
        key(
            "source",
            "",
            "empty",
            "source = \"free swing 20 deg\"",
            "where the value comes from",
        ),
    ],
};

/// `[correlation]`.
pub(super) const CORRELATION: KeySection = KeySection {
    name: "correlation",
    heading: "[correlation]",
    meaning: "The correlations between the errors of the parameters.",
    keys: &[
        key(
            "parameters",
            "",
            NEEDED,
            "parameters = [\"total_inertia\", \"body_viscous_friction\"]",
            "the order of rows and columns",
        ),
        key(
            "matrix",
            "",
            NEEDED,
            "matrix = [[1.0, 0.2], [0.2, 1.0]]",
            "correlation coefficients",
        ),
    ],
};

/// `[effects]`.
pub(super) const EFFECTS: KeySection = KeySection {
    name: "effects",
    heading: "[effects]",
    meaning: "The effects in the model.",
    keys: &[
        key(
            "present",
            "",
            "the base model",
            "present = [\"body-viscous-friction\", \"wheel-viscous-friction\"]",
            "the effects in the model",
        ),
        key(
            "provisional",
            "",
            "none",
            "provisional = [\"wheel-coulomb-friction\"]",
            "the present effects that explain no better than their rivals",
        ),
        key(
            "rivals",
            "",
            "none",
            "rivals = [[\"current-offset\"]]",
            "sets of effects that explain as well",
        ),
        key(
            "unseen_upright",
            "",
            "none",
            "unseen_upright = [\"own:magnet\"]",
            "own effects that no log has shown upright; the linear model leaves them out",
        ),
    ],
};

/// `[learned]`.
pub(super) const LEARNED: KeySection = KeySection {
    name: "learned",
    heading: "[learned.angle]",
    meaning: "A torque that was learned as a curve over a coordinate: `angle`, `rate` (on the body), `wheel_speed`, \
              `wheel_angle` (on the wheel). Between its knots lies a cubic spline, outside it is constant.",
    keys: &[
        key(
            "knots",
            "unit of the coordinate",
            NEEDED,
            "knots = [-0.3, -0.1, 0.1, 0.3]",
            "4 to 24 values of the coordinate, increasing",
        ),
        key(
            "torque",
            "N m",
            NEEDED,
            "torque = [0.0, 1e-4, -1e-4, 0.0]",
            "the torque at each knot, as it acts",
        ),
        key(
            "std",
            "N m",
            "taken as exact",
            "std = [1e-5, 1e-5, 1e-5, 1e-5]",
            "the standard errors of the torques",
        ),
        key(
            "unit",
            "",
            "N m",
            "unit = \"N m per kg m2\"",
            "where torques are known per unit of inertia only",
        ),
        key(
            "source",
            "",
            "empty",
            "source = \"free swing 20 deg\"",
            "where the curve comes from",
        ),
    ],
};

/// `[design]`.
pub(super) const DESIGN: KeySection = KeySection {
    name: "design",
    heading: "[design]",
    meaning: "The requirements of the controller.",
    keys: &[
        key(
            "sample_time",
            "s",
            NEEDED,
            "sample_time = 0.001",
            "time between two commands",
        ),
        key(
            "state_weights",
            "1/rad², s²/rad², s²/rad²",
            NEEDED,
            "state_weights = [25.0, 0.5, 5e-4]",
            "diagonal of Q: angle, rate, wheel speed",
        ),
        key(
            "current_weight",
            "1/A²",
            NEEDED,
            "current_weight = 1.0",
            "R",
        ),
        key(
            "current_limit",
            "A",
            NEEDED,
            "current_limit = 2.0",
            "largest current either way",
        ),
        key(
            "friction_linearisation_speed",
            "rad/s",
            "friction is left out",
            "friction_linearisation_speed = 0.0846768",
            "ι: dry friction of the body enters the linear model as μ/ι",
        ),
        key(
            "bias_time_constant",
            "s",
            "no observer",
            "bias_time_constant = 2.0",
            "time constant of an observer that finds a constant bias of the angle",
        ),
    ],
};

/// `[calibration]` of model.toml.
pub(super) const CALIBRATION: KeySection = KeySection {
    name: "calibration",
    heading: "[calibration]",
    meaning: "The results of `flywheel calibrate`; they take precedence over `[hardware]`.",
    keys: &[
        key(
            "accelerometer",
            "",
            "none",
            "[calibration.accelerometer]",
            "bias and matrix, counts to m/s²",
        ),
        key(
            "gyroscope",
            "",
            "none",
            "[calibration.gyroscope]",
            "likewise, counts to rad/s, with the filter's `beta`",
        ),
        key(
            "magnetometer",
            "",
            "none",
            "[calibration.magnetometer]",
            "likewise, counts to µT",
        ),
        key(
            "mounting",
            "",
            "none",
            "[calibration.mounting]",
            "`axis`: body z in the sensor's frame; `angle` about it",
        ),
        key(
            "lever_arm",
            "",
            "none",
            "[calibration.lever_arm]",
            "`position` of the accelerometer",
        ),
        key(
            "wheel_speed",
            "",
            "none",
            "[calibration.wheel_speed]",
            "`slope` and `offset` of the converter",
        ),
        key(
            "current",
            "",
            "none",
            "[calibration.current]",
            "`slope` and `offset` of the drive",
        ),
    ],
};

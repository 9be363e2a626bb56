//! The hand-written helpers of the emitted crate, compiled here unchanged.
//!
//! The helpers are tested in `codegen/tests/` and copied into the output by [`crate::runtime`]. Helpers that name
//! emitted constants (`attitude.rs`, `body.rs`, `controller.rs`, `monitor.rs`) are compiled in the output only.

#[path = "../runtime/arc_tangent.rs"]
pub mod arc_tangent;
#[path = "../runtime/bias_observer.rs"]
pub mod bias_observer;
#[path = "../runtime/body_supervisor.rs"]
pub mod body_supervisor;
#[path = "../runtime/calibration.rs"]
pub mod calibration;
#[path = "../runtime/drift.rs"]
pub mod drift;
#[path = "../runtime/encoder.rs"]
pub mod encoder;
#[path = "../runtime/filter.rs"]
pub mod filter;
#[path = "../runtime/lever_arm.rs"]
pub mod lever_arm;
#[path = "../runtime/line.rs"]
pub mod line;
#[path = "../runtime/madgwick.rs"]
pub mod madgwick;
#[path = "../runtime/motion.rs"]
pub mod motion;
#[path = "../runtime/pivot_angle.rs"]
pub mod pivot_angle;
#[path = "../runtime/plane.rs"]
pub mod plane;
#[path = "../runtime/product.rs"]
pub mod product;
#[path = "../runtime/root.rs"]
pub mod root;
#[path = "../runtime/scaling.rs"]
pub mod scaling;
#[path = "../runtime/supervisor.rs"]
pub mod supervisor;

//! Claim `stable-for-parameters`: the loop with the emitted gains is stable for every parameter vector
//! that identification allows, by the criterion of [`crate::claims::closed_loop_stable`].
//!
//! **Region.** The 95 % ellipsoid of the stated standard errors and correlations, or, where no correlations are
//! stated, the box around it ([`crate::claims::parameter_region`]). In its own coordinates it is halved until the
//! criterion holds on every part in outward-rounded intervals, by the slopes over the part
//! ([`crate::exact::slopes`]), and along the coordinate that moves the number in doubt the most. Parts beyond the
//! ellipsoid are left out. If the largest number of halvings is reached first, the claim is neither proved nor
//! refuted.
//!
//! **An observer of the angle's bias** is a fourth state of the loop, which does not depend on the parameters.
//!
//! **Windows of encoders** are states of the loop, too many for that criterion. Such a module is looked at over the
//! whole region at once, by what the responses of the loop at the stated parameters make of all that a plant may be
//! off by ([`crate::claims::loop_as_shipped::small_gain`]).

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::Certificate;
use crate::claims::closed_loop_stable::Stability;
use crate::claims::control_law::EmittedLaw;
use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::plant::Loop;
use crate::claims::loop_as_shipped::responses::Responses;
use crate::claims::loop_as_shipped::small_gain::gain;
use crate::claims::outcome::ClaimOutcome;
use crate::claims::parameter_model::{Model, NAMES};
use crate::claims::parameter_region::Region;
use crate::exact::rational::{half, integer, rounded_up};

/// Largest number of halvings; after them the claim is left open.
const BOXES: usize = 4_000;

/// How far the loop is known to be stable.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterRegion {
    /// Parameters that are uncertain, and by how much (± in their units), as text.
    pub uncertain: Vec<(String, String)>,
    /// Whether their correlations are stated, so that the region is the ellipsoid and not the box around it.
    pub is_correlated: bool,
    /// Boxes that were looked at.
    pub boxes: usize,
}

/// Why stability over the region is not shown.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionFailure {
    /// The certificate does not say enough.
    NotStated(String),
    /// It does not hold.
    Fails(String),
    /// It could not be decided.
    Undecided(String),
}

/// The outcome of the claim.
pub fn by_exact_arithmetic(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    match check_region(certificate, law) {
        Ok(region) if region.uncertain.is_empty() => ClaimOutcome::Proved(
            "no standard error is stated: the parameters themselves".to_owned(),
        ),
        Ok(region) => {
            let list: Vec<_> = region
                .uncertain
                .iter()
                .map(|(name, radius)| format!("{name} ± {radius}"))
                .collect();
            let correlated = match region.is_correlated {
                true => ", correlated as stated,",
                false => "",
            };
            ClaimOutcome::Proved(format!(
                "{}{correlated} in {} {}",
                list.join(", "),
                region.boxes,
                if region.boxes == 1 { "box" } else { "boxes" }
            ))
        }
        Err(RegionFailure::NotStated(why) | RegionFailure::Undecided(why)) => {
            ClaimOutcome::NotRun(why)
        }
        Err(RegionFailure::Fails(why)) => ClaimOutcome::Failed(why),
    }
}

/// Shows that the loop with the emitted gains is stable for every parameter vector of the region.
///
/// # Errors
/// [`RegionFailure`].
pub fn check_region(
    certificate: &Certificate,
    law: &EmittedLaw,
) -> Result<ParameterRegion, RegionFailure> {
    let parameter = |name: &str| certificate.parameters.iter().find(|p| p.name == name);
    let mut values = Vec::new();
    let mut errors = Vec::new();
    for name in NAMES {
        match parameter(name) {
            Some(found) => {
                values.push(found.value.value.clone());
                let std = found.std.as_ref().map(|std| std.value.abs());
                errors.push(std.unwrap_or_default());
            }
            // Without it there is no dry friction; every model has the others.
            None if name == "body_coulomb_torque" => {
                values.push(BigRational::zero());
                errors.push(BigRational::zero());
            }
            None => {
                return Err(RegionFailure::NotStated(format!(
                    "the certificate does not state the parameter {name}"
                )));
            }
        }
    }
    let model = Model::new(certificate, law, &values).map_err(RegionFailure::Fails)?;
    // The ellipsoid of the parameters on which the loop depends; it does not depend on the others.
    let region = Region::of(certificate, &NAMES, values, &errors).map_err(RegionFailure::Fails)?;
    let uncertain = NAMES
        .iter()
        .zip(&region.radii)
        .filter(|(_, radius)| !radius.is_zero())
        .map(|(name, radius)| ((*name).to_owned(), rounded_up(radius, 3)))
        .collect();

    let region_of = |boxes: usize| ParameterRegion {
        uncertain,
        is_correlated: region.is_ball,
        boxes,
    };
    let hardware = &certificate.hardware;
    if hardware.wheel_speed.encoder.is_some() || hardware.body_encoder().is_some() {
        with_windows(certificate, law, &model, &region)?;
        return Ok(region_of(1));
    }

    let named = |z: &[BigRational]| {
        let list: Vec<_> = NAMES
            .iter()
            .zip(region.at(z))
            .map(|(name, value)| format!("{name} = {}", rounded_up(&value, 6)))
            .collect();
        list.join(", ")
    };
    let unstable_at =
        |z: &[BigRational]| RegionFailure::Fails(format!("the loop is unstable for {}", named(z)));
    let is_unstable = |z: &[BigRational]| model.judge(&region.at(z)) == Stability::Unstable;
    // Where the loop is unstable at all, it mostly is so in a corner.
    if let Some(corner) = region.corners().iter().find(|z| is_unstable(z)) {
        return Err(unstable_at(corner));
    }
    let mut pending = std::collections::VecDeque::from([region.whole()]);
    let mut boxes = 0;
    while let Some(part) = pending.pop_front() {
        if region.is_outside(&part) {
            continue;
        }
        boxes += 1;
        let (stability, widest) = model.judge_part(&region, &part);
        if stability == Stability::Stable {
            continue;
        }
        let middle: Vec<BigRational> = part
            .iter()
            .map(|(low, high)| (low + high) * half())
            .collect();
        if region.holds(&middle) && is_unstable(&middle) {
            return Err(unstable_at(&middle));
        }
        let (Some(index), true) = (widest, boxes < BOXES) else {
            return Err(RegionFailure::Undecided(format!(
                "not decided after {boxes} boxes, near {}",
                named(&middle)
            )));
        };
        let mut lower = part.clone();
        lower[index].1.clone_from(&middle[index]);
        let mut upper = part;
        upper[index].0.clone_from(&middle[index]);
        pending.push_back(lower);
        pending.push_back(upper);
    }
    Ok(region_of(boxes))
}

/// The loop with the windows of its encoders, whose polynomial is of too high a degree for intervals, over the whole
/// region at once.
fn with_windows(
    certificate: &Certificate,
    law: &EmittedLaw,
    model: &Model,
    region: &Region,
) -> Result<(), RegionFailure> {
    let undecided = |why: String| {
        RegionFailure::Undecided(format!(
            "with the windows of its encoders: {why} (`encoder-loop-stable` is about the stated parameters themselves)"
        ))
    };
    let of_loop = |why: NoBounds| match why {
        NoBounds::NotShown(why) => undecided(why),
        NoBounds::Unphysical(why) => RegionFailure::Fails(why),
    };
    let off = model
        .off(certificate, region)
        .ok_or_else(|| undecided("an inertia may be zero".to_owned()))?;
    let plant = Loop::with_wheel_input(certificate, law).map_err(of_loop)?;
    let responses = Responses::of(&plant).map_err(of_loop)?;
    match gain(&plant, &responses, &off) {
        Some(factor) if factor < integer(1) => Ok(()),
        Some(factor) => Err(undecided(format!(
            "what the parameters may be off by feeds on itself by a factor of {}, and the argument needs one below 1",
            rounded_up(&factor, 3)
        ))),
        None => Err(undecided(
            "the motion between two samples has no bound".to_owned(),
        )),
    }
}

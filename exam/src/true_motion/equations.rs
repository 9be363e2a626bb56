//! The equations of the true motion: torques, accelerations, and the readings of the sensors.

use nalgebra::{Matrix2, Vector2};
use plant::{EffectId, Kind};

use super::{Direction, HiddenPush, Motion, TrueMotion};
use crate::truth::{Hidden, Outsider, TrueInstant};

struct Stage {
    motor: f64,
    body: f64,
    wheel: f64,
}

impl TrueMotion {
    pub(super) fn library(&self, effect: EffectId) -> Option<&[f64]> {
        self.truth.hidden.iter().find_map(|hidden| match hidden {
            Hidden::Library(own, p) if *own == effect => Some(p.as_slice()),
            _ => None,
        })
    }

    fn outsider(&self, outsider: Outsider) -> Option<[f64; 3]> {
        self.truth.hidden.iter().find_map(|hidden| match hidden {
            Hidden::Outsider(own, p) if *own == outsider => Some(*p),
            _ => None,
        })
    }

    /// The readings of sensors without lag and delay.
    pub(super) fn at_once(&self) -> [f64; 3] {
        let [mut angle, mut rate, _, speed, _, _] = self.motion;
        if let Some(p) = self.library(EffectId::AngleEccentricity) {
            angle += p[0] * (self.motion[0] + p[1]).sin();
        }
        if let Some(p) = self.outsider(Outsider::UnevenEncoder) {
            angle += p[0] * (8.0 * self.motion[0] + p[1]).sin();
        }
        if let Some(p) = self.library(EffectId::AngleOffset) {
            angle += p[0];
        }
        if let Some(p) = self.library(EffectId::GyroScale) {
            rate *= 1.0 + p[0];
        }
        if let Some(p) = self.library(EffectId::GyroBias) {
            rate += p[0];
        }
        [angle, rate, speed]
    }

    /// Magnitude of the body's dry friction at a speed, N m.
    pub(super) fn body_dry(&self, time_s: f64, angle: f64, rate: f64) -> f64 {
        let mut level = 0.0;
        for hidden in &self.truth.hidden {
            level += match hidden {
                Hidden::Library(EffectId::BodyCoulombFriction, p) => p[0],
                Hidden::Library(EffectId::BodyStribeckFriction, p) => {
                    p[0] + (p[1] - p[0]) * (-(rate / p[2]).powi(2)).exp()
                }
                Hidden::Outsider(Outsider::FrictionThatGrows, p) => p[0] * time_s / 20.0,
                Hidden::Outsider(Outsider::RubbingBeyondAnAngle, p)
                    if angle.abs() > p[1] && angle.abs() < std::f64::consts::FRAC_PI_2 =>
                {
                    p[0]
                }
                _ => 0.0,
            };
        }
        level
    }

    pub(super) fn wheel_dry(&self, speed: f64) -> f64 {
        let coulomb = self.library(EffectId::WheelCoulombFriction);
        let level = coulomb.map_or(0.0, |p| p[0]);
        let stribeck = self.library(EffectId::WheelStribeckFriction);
        let falls = |p: &[f64]| p[0] + (p[1] - p[0]) * (-(speed / p[2]).powi(2)).exp();
        level + stribeck.map_or(0.0, falls)
    }

    /// The torques without dry friction: the motor's torque, and the torques against body and wheel.
    fn stage(&self, time_s: f64, y: &Motion, push: &[HiddenPush]) -> Stage {
        let [angle, rate, wheel_angle, speed, presliding, current] = *y;
        let torque_constant = self.truth.base[3];
        let mut body = self.truth.base[2] * angle.sin() + self.truth.body_viscous * rate;
        let mut wheel = self.truth.wheel_viscous * speed;
        let mut flowing = current;
        if let Some(&[voltage, resistance]) = self.library(EffectId::BackEmfLimit)
            && flowing * speed > 0.0
        {
            let most = ((voltage - torque_constant * speed.abs()) / resistance).max(0.0);
            flowing = flowing.clamp(-most, most);
        }
        if let Some(&[width]) = self.library(EffectId::MotorDeadZone) {
            flowing -= flowing.clamp(-width, width);
        }
        if let Some(&[offset]) = self.library(EffectId::CurrentOffset) {
            flowing += offset;
        }
        if let Some(&[knee]) = self.library(EffectId::MotorSaturation) {
            flowing /= 1.0f64.hypot(flowing / knee);
        }
        let mut motor = torque_constant * flowing;
        for hidden in &self.truth.hidden {
            match hidden {
                Hidden::Library(effect, p) => match effect {
                    EffectId::BodyPreslidingFriction => body += presliding,
                    EffectId::BodyQuadraticDrag => body += p[0] * rate * rate.abs(),
                    EffectId::BodyCableSpring => body += p[0] * (angle - p[1]),
                    EffectId::BodySofteningSpring => body -= p[0] * angle.powi(3),
                    EffectId::WheelQuadraticDrag => wheel += p[0] * speed * speed.abs(),
                    EffectId::WheelUnbalance => {
                        let side = wheel_angle + p[1];
                        let weight = p[0] * p[3] * (angle + side).sin();
                        let pull = p[0] * p[2] * side.sin();
                        body += weight - pull * speed * (2.0 * rate + speed);
                        wheel += weight + pull * rate * rate;
                    }
                    EffectId::WheelCogging => wheel += p[0] * (p[1] * wheel_angle + p[2]).sin(),
                    _ => {}
                },
                Hidden::Stated(_, p, stated) => {
                    let at = TrueInstant {
                        time_s,
                        angle_rad: angle,
                        rate_rad_s: rate,
                        wheel_angle_rad: wheel_angle,
                        wheel_speed_rad_s: speed,
                    };
                    let joint = if stated.on_body {
                        &mut body
                    } else {
                        &mut wheel
                    };
                    *joint += (stated.torque)(p, &at);
                }
                Hidden::Outsider(outsider, p) => match outsider {
                    Outsider::MagnetNearAnAngle => {
                        let z = (angle - p[1]) / p[2];
                        body -= p[0] * z * (-z * z).exp();
                    }
                    Outsider::VibrationOfTheBase => {
                        body -= p[0] * (p[1] * time_s + p[2]).sin() * angle.cos();
                    }
                    Outsider::SoftStop => {
                        if angle > p[1] && angle < std::f64::consts::FRAC_PI_2 {
                            body += p[0] * (angle - p[1]);
                        }
                    }
                    Outsider::WheelDragThatGrows => wheel += p[0] * speed * time_s / 10.0,
                    Outsider::SupplyThatSags => {
                        motor *= 1.0 - p[0] * (1.0 - (-time_s / p[1]).exp())
                    }
                    Outsider::FrictionThatGrows
                    | Outsider::RubbingBeyondAnAngle
                    | Outsider::UnevenEncoder => {}
                },
            }
        }
        for push in push {
            let z = (time_s - push.time_s) / push.width_s;
            if z.abs() < 6.0 {
                body -= push.peak_nm * (-z * z).exp();
            }
        }
        Stage { motor, body, wheel }
    }

    /// The torque in N m on each joint without its own dry friction: a joint sticks if its dry friction can hold this
    /// torque.
    pub(super) fn drive(&self, time_s: f64, y: &Motion, push: &[HiddenPush]) -> (f64, f64) {
        let at = self.stage(time_s, y, push);
        let [total, wheel_inertia, _, _] = self.truth.base;
        let slides = |direction: Direction, level: f64| direction * level;
        let body_friction = slides(self.body, self.body_dry(time_s, y[0], y[1]));
        let wheel_friction = slides(self.wheel, self.wheel_dry(y[3]));
        match self.kind {
            Kind::FreeSwing => (-at.body, 0.0),
            Kind::SpinUp => (0.0, at.motor - at.wheel),
            Kind::Balance | Kind::Driven => {
                let body = if self.wheel_sticks() {
                    -at.body
                } else {
                    -at.body - at.motor + at.wheel + wheel_friction
                };
                let acceleration = if self.body_sticks() {
                    0.0
                } else {
                    (-at.body - body_friction) / total
                };
                (body, at.motor - at.wheel - wheel_inertia * acceleration)
            }
        }
    }

    fn body_sticks(&self) -> bool {
        self.has_body_dry() && self.body == 0.0
    }

    fn wheel_sticks(&self) -> bool {
        self.has_wheel_dry() && self.wheel == 0.0
    }

    pub(super) fn has_body_dry(&self) -> bool {
        self.truth.hidden.iter().any(|hidden| {
            matches!(
                hidden,
                Hidden::Library(
                    EffectId::BodyCoulombFriction | EffectId::BodyStribeckFriction,
                    _
                ) | Hidden::Outsider(
                    Outsider::FrictionThatGrows | Outsider::RubbingBeyondAnAngle,
                    _
                )
            )
        })
    }

    pub(super) fn has_wheel_dry(&self) -> bool {
        self.library(EffectId::WheelCoulombFriction).is_some()
            || self.library(EffectId::WheelStribeckFriction).is_some()
    }

    pub(super) fn rates(
        &self,
        time_s: f64,
        y: &Motion,
        command_a: f64,
        push: &[HiddenPush],
    ) -> Motion {
        let at = self.stage(time_s, y, push);
        let [total, wheel_inertia, _, _] = self.truth.base;
        // The contribution of the wheel's heavy side to the products of inertia.
        let side = |p: &[f64]| p[0] * p[2] * (y[2] + p[1]).cos();
        let coupling = self.library(EffectId::WheelUnbalance).map_or(0.0, side);
        let body_friction = self.body * self.body_dry(time_s, y[0], y[1]);
        let wheel_friction = self.wheel * self.wheel_dry(y[3]);
        let body = at.body + body_friction;
        let wheel = at.motor - at.wheel - wheel_friction;
        let (rate_dot, speed_dot) = match self.kind {
            Kind::FreeSwing if self.body_sticks() => (0.0, 0.0),
            Kind::FreeSwing => (-body / total, 0.0),
            Kind::SpinUp if self.wheel_sticks() => (0.0, 0.0),
            Kind::SpinUp => (0.0, wheel / wheel_inertia),
            Kind::Balance | Kind::Driven => match (self.body_sticks(), self.wheel_sticks()) {
                (true, true) => (0.0, 0.0),
                (true, false) => (0.0, wheel / wheel_inertia),
                (false, true) => (-body / (total + 2.0 * coupling), 0.0),
                (false, false) if coupling != 0.0 => {
                    let matrix = Matrix2::new(
                        total + 2.0 * coupling,
                        wheel_inertia + coupling,
                        wheel_inertia + coupling,
                        wheel_inertia,
                    );
                    let solved = matrix.lu().solve(&Vector2::new(-body, wheel));
                    solved.map_or((f64::NAN, f64::NAN), |both| (both[0], both[1]))
                }
                (false, false) => {
                    let rate_dot = (-body - wheel) / (total - wheel_inertia);
                    (rate_dot, wheel / wheel_inertia - rate_dot)
                }
            },
        };
        let mut presliding_dot = 0.0;
        if let Some(&[limit, stiffness]) = self.library(EffectId::BodyPreslidingFriction) {
            presliding_dot = stiffness * y[1] * (1.0 - y[1].signum() * y[4] / limit);
        }
        let mut current_dot = 0.0;
        if let Some(&[lag_s]) = self.library(EffectId::MotorLag) {
            current_dot = (command_a - y[5]) / lag_s;
        }
        let moves_body = self.kind != Kind::SpinUp;
        let moves_wheel = self.kind != Kind::FreeSwing;
        [
            if moves_body { y[1] } else { 0.0 },
            if moves_body { rate_dot } else { 0.0 },
            if moves_wheel { y[3] } else { 0.0 },
            if moves_wheel { speed_dot } else { 0.0 },
            presliding_dot,
            current_dot,
        ]
    }
}

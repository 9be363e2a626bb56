//! The pendulum, and the hand that holds it.

use std::f64::consts::PI;

use plant::{EffectId, Kind, Model, Plant, State};

/// Integration steps in a sample time of 1 ms. The fit has its own rules for its steps, so that both differ.
const SUBSTEPS: usize = 4;

/// What the bench truly is.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub total_inertia: f64,
    pub wheel_inertia: f64,
    pub gravity_torque: f64,
    pub torque_constant: f64,
    pub body_viscous: f64,
    pub wheel_viscous: f64,
    pub body_coulomb_torque: f64,
}

impl Truth {
    /// A bench similar to that of the thesis: so near that the thesis' controller balances it, so far that the
    /// measurements show the difference.
    pub fn with_dry_friction() -> Truth {
        Truth {
            total_inertia: 2.42e-3,
            wheel_inertia: 1.27e-4,
            gravity_torque: 0.245158,
            torque_constant: 0.0335,
            body_viscous: 3.0e-5,
            wheel_viscous: 2.1e-5,
            body_coulomb_torque: 5.0e-4,
        }
    }

    fn plant(&self, kind: Kind) -> Plant<f64> {
        let model = Model::base().with(EffectId::BodyCoulombFriction);
        let values: Vec<f64> = model
            .parameters()
            .iter()
            .map(|info| match info.name {
                "total_inertia" => self.total_inertia,
                "wheel_inertia" => self.wheel_inertia,
                "gravity_torque" => self.gravity_torque,
                "torque_constant" => self.torque_constant,
                "body_viscous_friction" => self.body_viscous,
                "wheel_viscous_friction" => self.wheel_viscous,
                "body_coulomb_torque" => self.body_coulomb_torque,
                other => panic!("the bench has no {other}"),
            })
            .collect();
        Plant::new(&model, &values, kind)
    }
}

/// The action of the person at the bench.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// The wheel is locked. The body hangs for a second, is lifted to an angle and let go.
    Swing { from_rad: f64 },
    /// Body clamped upright.
    Clamped,
    /// The hand holds the body at an angle from upright until the motor is driven, and then lets go.
    Upright { from_rad: f64 },
    /// The body is clamped, and the bus of the sensors fails after this time under current.
    BusFailsAfter { seconds: f64 },
    /// The body is clamped, and the plug of the serial line is pulled after this time under current, until the next scene.
    UnpluggedAfter { seconds: f64 },
}

/// The pendulum in a scene.
pub struct Pendulum {
    truth: Truth,
    plant: Plant<f64>,
    scene: Scene,
    pub state: State<f64>,
    /// Angle of the body when the scene was requested, rad.
    came_from_rad: f64,
    /// Time since the scene began, s. While it is negative, the hand turns the body to the first angle of the scene.
    time_s: f64,
    /// Since the motor was first driven, s.
    driven_s: f64,
}

/// Time in s in which the hand turns the body to the first angle of a scene. The turn is slow enough for the gyroscope.
const TURN_S: f64 = 2.0;

impl Pendulum {
    /// The next scene, which starts from the present angle of the body, with the wheel at rest.
    pub fn next(&self, scene: Scene) -> Pendulum {
        let mut next = Pendulum::new(&self.truth, scene);
        next.came_from_rad = self.state.angle_rad;
        next.time_s = -TURN_S;
        next.hold();
        next
    }

    pub fn new(truth: &Truth, scene: Scene) -> Pendulum {
        let kind = match scene {
            Scene::Swing { .. } => Kind::FreeSwing,
            Scene::Clamped | Scene::BusFailsAfter { .. } | Scene::UnpluggedAfter { .. } => {
                Kind::SpinUp
            }
            Scene::Upright { .. } => Kind::Balance,
        };
        let angle_rad = begin_rad(scene);
        Pendulum {
            truth: *truth,
            plant: truth.plant(kind),
            scene,
            state: State {
                angle_rad,
                ..State::rest()
            },
            came_from_rad: angle_rad,
            time_s: 0.0,
            driven_s: 0.0,
        }
    }

    /// Whether the hand is still turning the body to the first angle of the scene.
    pub fn is_turned(&self) -> bool {
        self.time_s < 0.0
    }

    /// Whether the sensors answer.
    pub fn bus_works(&self) -> bool {
        match self.scene {
            Scene::BusFailsAfter { seconds } => !(seconds..seconds + 0.1).contains(&self.driven_s),
            _ => true,
        }
    }

    /// Whether the serial line is connected.
    pub fn is_plugged(&self) -> bool {
        match self.scene {
            Scene::UnpluggedAfter { seconds } => self.driven_s < seconds,
            _ => true,
        }
    }

    /// The body's acceleration as its sensor feels it, rad/s².
    pub fn acceleration_rad_s2(&self, current_a: f64) -> f64 {
        match self.held() {
            Some(_) => 0.0,
            None => self.plant.derivative(&self.state, current_a, 0.0).0,
        }
    }

    /// Angle and rate of the body while the hand holds it; `None` if the body is free.
    fn held(&self) -> Option<(f64, f64)> {
        if self.time_s < 0.0 {
            let way_rad = begin_rad(self.scene) - self.came_from_rad;
            let (angle_rad, rate_rad_s) = smooth(1.0 + self.time_s / TURN_S);
            return Some((
                self.came_from_rad + way_rad * angle_rad,
                way_rad * rate_rad_s / TURN_S,
            ));
        }
        match self.scene {
            Scene::Swing { from_rad } => match self.time_s {
                t if t < 1.0 => Some((0.0, 0.0)),
                // Lifted within a second along a smooth path, held for half a second.
                t if t < 2.0 => {
                    let (share, rate) = smooth(t - 1.0);
                    Some((from_rad * share, from_rad * rate))
                }
                t if t < 2.5 => Some((from_rad, 0.0)),
                _ => None,
            },
            Scene::Clamped | Scene::BusFailsAfter { .. } | Scene::UnpluggedAfter { .. } => {
                Some((PI, 0.0))
            }
            Scene::Upright { from_rad } => (self.driven_s == 0.0).then_some((PI + from_rad, 0.0)),
        }
    }

    /// One sample time under a current.
    pub fn step(&mut self, current_a: f64, sample_time_s: f64) {
        if current_a != 0.0 || self.driven_s > 0.0 {
            self.driven_s += sample_time_s;
        }
        let step_s = sample_time_s / SUBSTEPS as f64;
        for _ in 0..SUBSTEPS {
            self.runge_kutta(current_a, step_s);
            self.time_s += step_s;
            self.hold();
        }
    }

    /// Puts the body where the hand holds it.
    fn hold(&mut self) {
        if let Some((angle_rad, rate_rad_s)) = self.held() {
            self.state.angle_rad = angle_rad;
            self.state.rate_rad_s = rate_rad_s;
        }
    }

    /// The classical rule of fourth order.
    fn runge_kutta(&mut self, current_a: f64, step_s: f64) {
        let start = self.state;
        let slope = |state: &State<f64>| {
            let (body, wheel) = self.plant.derivative(state, current_a, 0.0);
            [state.rate_rad_s, body, state.wheel_speed_rad_s, wheel]
        };
        let moved = |slope: [f64; 4], by_s: f64| State {
            angle_rad: start.angle_rad + by_s * slope[0],
            rate_rad_s: start.rate_rad_s + by_s * slope[1],
            wheel_angle_rad: start.wheel_angle_rad + by_s * slope[2],
            wheel_speed_rad_s: start.wheel_speed_rad_s + by_s * slope[3],
            ..start
        };
        let first = slope(&start);
        let second = slope(&moved(first, step_s / 2.0));
        let third = slope(&moved(second, step_s / 2.0));
        let fourth = slope(&moved(third, step_s));
        let mean =
            [0, 1, 2, 3].map(|i| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0);
        self.state = moved(mean, step_s);
    }
}

/// Angle of the body at the beginning of a scene, rad.
fn begin_rad(scene: Scene) -> f64 {
    match scene {
        Scene::Swing { .. } => 0.0,
        Scene::Clamped | Scene::BusFailsAfter { .. } | Scene::UnpluggedAfter { .. } => PI,
        Scene::Upright { from_rad } => PI + from_rad,
    }
}

/// A smooth way from 0 to 1, and its slope.
fn smooth(share: f64) -> (f64, f64) {
    let phase = PI * share;
    ((1.0 - phase.cos()) / 2.0, PI * phase.sin() / 2.0)
}

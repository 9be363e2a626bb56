#!/usr/bin/env python3
"""The claims `loop-as-shipped` and `motion-kept-up` a second time: python3 loop_as_shipped.py certificate.json

Nothing here is shared with the checker in Rust. It reads the certificate alone; that the source has the stated
words is for `flywheel prove` to show.

The plant of `motion.py` has viscous friction alone:

    x' = A x + B i + e f + e_w f_w,    e = (0, 1, -1),    e_w = (0, 1/D, -Theta/(j_w D)),

where |f| is at most dry friction over D plus g |angle|^3/6, what a straight line leaves out of the sine, and f_w the dry
torque on the wheel. Loops with a delay of 1, 3, 5 and 7 eighths of a sample are looked at; what the delay is off by, at most
1/8 of a sample, is an input as large as the command's change. What sensors, filter, words and duty do is in `closing.py`.

Exit code 0 and one line: from which angle at rest, and what stays. 3: the argument does not hold this module. 1: the
certificate contradicts itself. 2: no certificate.
"""

import os
import sys
from fractions import Fraction

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from closing import Errors, closing, digits, kept_up, largest_start
from motion import Contradiction, NotShown, Plant, Responses, observer_words, run, words_of

MODEL = {
    "total_inertia", "wheel_inertia", "gravity_torque", "torque_constant",
    "body_viscous_friction", "wheel_viscous_friction",
}  # fmt: skip
OTHER = {
    "body_coulomb_torque", "body_breakaway_torque", "wheel_coulomb_torque", "cogging_torque", "dead_zone",
    "current_offset", "body_stribeck_speed", "body_presliding_stiffness", "cogging_order", "cogging_phase",
    "body_inertia",  # follows from others; no equation of motion has it
}  # fmt: skip


def of_parameters(certificate):
    """The plant of the stated parameters, under the emitted gains."""
    p = {entry["name"]: Fraction(entry["value"]) for entry in certificate["parameters"]}
    for name in p:
        if name not in MODEL | OTHER:
            raise NotShown(f"the argument does not hold the effect of {name}")
    of = lambda name: abs(p.get(name, Fraction(0)))
    theta, wheel = p["total_inertia"], p["wheel_inertia"]
    d = theta - wheel
    if d <= 0 or wheel <= 0 or p["gravity_torque"] <= 0 or p["torque_constant"] <= 0:
        raise Contradiction("these are the parameters of no pendulum")
    if p.get("body_viscous_friction", 0) < 0 or p.get("wheel_viscous_friction", 0) < 0:
        raise Contradiction("viscous friction is negative")
    g, body, drag = p["gravity_torque"] / d, of("body_viscous_friction") / d, of("wheel_viscous_friction") / d
    lever = theta / (wheel * d)
    spin = of("wheel_viscous_friction") * lever
    zero, one = Fraction(0), Fraction(1)
    a = [[zero, one, zero], [g, -body, drag], [-g, body, -spin]]
    b = [zero, -p["torque_constant"] / d, p["torque_constant"] * lever]
    if abs(Fraction(certificate["plant"]["A"][1][0]) - g) > g / 10**5:
        raise Contradiction("A[1][0] is not the gravity of the parameters")
    gains, _ = words_of(certificate)
    plant = Plant(certificate, gains, a, b, [zero, 1 / d, -lever], Fraction(1, 8), observer_words(certificate))
    plant.dry = max(of("body_coulomb_torque"), of("body_breakaway_torque")) / d
    plant.wheel_dry = of("wheel_coulomb_torque") + of("cogging_torque")
    plant.current_off = of("dead_zone") + of("current_offset")
    return plant


def check(certificate):
    plant = of_parameters(certificate)
    noisy, quiet = Errors(certificate, plant, True), Errors(certificate, plant, False)
    all_responses = [Responses(plant, eighths) for eighths in (1, 3, 5, 7)]
    start = min(largest_start(plant, responses, noisy) for responses in all_responses)
    bounds, kept = [Fraction(0)] * 4, [Fraction(0)] * 4
    for responses in all_responses:
        rows, b, command = closing(plant, responses, noisy, start)
        bounds = [max(x, y) for x, y in zip(bounds, b + [command])]
        kept = [max(x, y) for x, y in zip(kept, kept_up(plant, responses, quiet, rows))]
    return f"from rest up to {float(start):.5f} rad: within {digits(bounds)} (rad, rad/s, rad/s, A); kept up: {digits(kept)}"


if __name__ == "__main__":
    sys.exit(run(check))

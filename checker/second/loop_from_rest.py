#!/usr/bin/env python3
"""The claims `closed-loop-for-all-time` and `region-of-attraction` a second time, where an encoder has a window, or the module an
observer of the angle's bias, and the starts are at rest: python3 loop_from_rest.py certificate.json

Nothing here is shared with the checker in Rust. It reads the certificate alone; that the source has the stated
words is for `flywheel prove` to show.

First the certificate must agree with itself: Ad and Bd are A and B sampled with a zero-order hold, A and B have the gravity
and the torque of the parameters, each emitted gain is -K rounded to its word, and the back-EMF is that of the motor.

The plant is the stated linear model, without delay, dry friction and noise, and with sensors that return the nearest count. With
z the states of the emitted loop (`motion.py`), z' those of the loop with the gains -K in real numbers and the same windows,

    e = z - z',    e+ = F e + B (v + (N + K) z') + readings,

v the rounding of words, duty and counts. z' keeps the bounds of its own start, which follow from themselves (`closing.py`), and so
|(N + K) z'| is bounded; the sum of all responses bounds e for all time. An observer in real numbers has the decimals of the
certificate, and what its words make of z' besides is one more input of the observer's state.

The region: the same bounds with gravity as a sine, from the largest start for which they keep themselves, and those that every
such motion comes to and then keeps.

Exit code 0 and two lines: both loops, and the region. 3: the argument does not hold this module. 1: the certificate contradicts
itself. 2: no certificate.
"""

import copy
import os
import sys
from fractions import Fraction

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from closing import Errors, added, closing, digits, kept_up, largest_start
from motion import (
    Contradiction, NotShown, Plant, Responses, exponential, observer_decimals, observer_words, real, run, short, words_of,
)  # fmt: skip


def check_sampling(a, b, ad, bd, period):
    """The stated Ad and Bd are those of A and B, to their last digits."""
    zero, one = Fraction(0), Fraction(1)
    a = [row + [zero] for row in a] + [[zero, zero, one, zero]]
    sampled, held = exponential(a, b + [zero], period)
    for i in range(3):
        for stated, found in zip(ad[i] + [bd[i]], sampled[i][:3] + [held[i]]):
            if abs(stated - real(found)) > abs(real(found)) / 10**12 + Fraction(1, 10**20):
                raise Contradiction("Ad and Bd are not those of A and B")


def check_observer(observer, ad, bd):
    """The stated numbers observe the stated plant: m + l Ad = d l, f = -l Bd, d + l (I - Ad) e_1 = 1."""
    decay, direct, into, of_current = observer
    moved = [sum(x * row[j] for x, row in zip(direct, ad)) for j in range(3)]
    checks = [[x, y, -decay * z] for x, y, z in zip(into, moved, direct)]
    checks += [[of_current] + [x * y for x, y in zip(direct, bd)], [decay, direct[0], -moved[0], Fraction(-1)]]
    if not 0 < decay < 1 or any(abs(sum(terms)) > sum(map(abs, terms)) / 2**46 for terms in checks):
        raise Contradiction("the observer is not one of Ad and Bd")


def as_stated(certificate):
    """The linear model under the emitted gains and under -K, neither with the sine of gravity."""
    vector = lambda entries: [Fraction(entry) for entry in entries]
    matrix = lambda rows: [vector(row) for row in rows]
    stated, drive = certificate["plant"], certificate["drive"]
    a, b = matrix(stated["A"]), vector(stated["B"])
    period = Fraction(certificate["sample_time_s"])
    check_sampling(a, b, matrix(stated["Ad"]), vector(stated["Bd"]), period)
    emitted, _ = words_of(certificate)
    minus_k = [-gain for gain in vector(certificate["gains"])]
    for word, gain, other in zip(certificate["constants"], emitted, minus_k):
        if abs(gain - other) > Fraction(1, 2 ** (word["fraction_bits"] + 1)):
            raise Contradiction(f"{word['name']} is not the stated gain, rounded to its word")
    p = {entry["name"]: Fraction(entry["value"]) for entry in certificate["parameters"]}
    theta, wheel, torque = p["total_inertia"], p["wheel_inertia"], p["torque_constant"]
    if not 0 < wheel < theta:
        raise Contradiction("these are the parameters of no pendulum")
    d = theta - wheel
    for what, found, wanted in [
        ("A[1][0]", a[1][0], p["gravity_torque"] / d), ("B[1]", b[1], -torque / d), ("B[2]", b[2], torque * theta / (wheel * d)),
    ]:  # fmt: skip
        if abs(found - wanted) > abs(wanted) / 10**5:
            raise Contradiction(f"{what} is not that of the parameters")
    none = [Fraction(0)] * 3
    observers = [observer_words(certificate), observer_decimals(certificate)]
    if observers[1] is not None:
        check_observer(observers[1], matrix(stated["Ad"]), vector(stated["Bd"]))
    both = zip((emitted, minus_k), observers)
    plants = [Plant(certificate, gains, a, b, none, Fraction(0), observer) for gains, observer in both]
    if drive["voltage"] is not None:
        held = [row[:3] for row in plants[0].a[:3]]
        check_sampling(held, b, matrix(drive["voltage"]["Ad"]), vector(drive["voltage"]["Bd"]), period)
    return plants


def straight(plant):
    """The same without the sine."""
    found = copy.copy(plant)
    found.g = Fraction(0)
    return found


def difference(plant, responses, errors, apart):
    """Bounds of e at the samples, and of the command's difference, where the held inputs and the observers differ by up to `apart`
    besides."""
    still = Fraction(0)
    noise = errors.weighted(plant.held, still, still) + errors.rounding + apart[0]
    sizes, waiting = errors.of_sample(still, still), errors.waiting(plant, still, still)
    if plant.direct:
        sizes[-1] += apart[1]
    of_row = lambda i: (
        responses.sums[0][i] * noise + added([reading[i] for reading in responses.reading], sizes)
        + responses.before[i] * (errors.at_rest + waiting)
    )  # fmt: skip
    own = errors.weighted(plant.n, still, still) + errors.asked_rounding + apart[0]
    own += added([command for _, command, _ in plant.readings], sizes)
    return [of_row(0), of_row(1), of_row(2), of_row(7) + own]


def check(certificate):
    hardware = certificate["hardware"]
    encoders = hardware.get("body_encoder"), hardware["wheel_speed"]["encoder"]
    if encoders == (None, None) and certificate["bias_observer"] is None:
        raise NotShown("no encoder has a window, and there is no observer: closed_loop.py checks this module")
    emitted, exact = as_stated(certificate)
    errors = Errors(certificate, emitted, False, is_direct=True)
    responses, of_exact = Responses(emitted, 0), Responses(exact, 0)

    linear, linear_exact = straight(emitted), straight(exact)
    start = min(largest_start(linear, responses, errors), largest_start(linear_exact, of_exact, errors))
    rows, between, _ = closing(linear_exact, of_exact, errors, start)
    apart = [added([x - y for x, y in zip(emitted.n, exact.n)], between), Fraction(0)]
    if exact.direct:
        # The bias that the real observer shows, errors included, less l y.
        state = rows[8] + added(exact.direct, between) + errors.waiting(exact, Fraction(0), Fraction(0))
        apart[0] += abs(emitted.of_bias - exact.of_bias) * state
        apart[1] = added([x - y for x, y in zip(emitted.into, exact.into)], between)
        apart[1] += abs(emitted.decay - exact.decay) * state
    off = difference(linear, responses, errors, [short(x) for x in apart])
    _, between, command = closing(linear, responses, errors, start)
    said = f"from rest up to {float(start):.5f} rad: within {digits(between + [command])}, differs by {digits(off)}"

    start = largest_start(emitted, responses, errors)
    rows, between, command = closing(emitted, responses, errors, start)
    kept = kept_up(emitted, responses, errors, rows)
    return f"{said}\nfrom rest up to {float(start):.5f} rad: within {digits(between + [command])}; comes to {digits(kept)}"


if __name__ == "__main__":
    sys.exit(run(check))

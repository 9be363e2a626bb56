#!/usr/bin/env python3
"""Checks the closed-loop part of certificate.json a second time: python3 closed_loop.py certificate.json

Nothing here is shared with the checker in Rust, and nothing is rounded that is not said to be: numbers
are Python's integers and fractions of them. It reads the certificate alone; that the source has the
stated words is for `flywheel prove` to show.

Two loops start at one state. One is the linear model under u = -K x, x' = F x with F = Ad - Bd K. The
other has the emitted gains N (words, about -K), sees each state off by at most h, and rounds its sum by
at most half a unit:

    u = N (x + d) + r,    x' = G x + Bd v,    G = Ad + Bd N,    v = N d + r,    |v| <= V.

Shown, for the set E = {x: x P x <= 1} and its norm |x|^2 = x P x:

 1. Ad and Bd are A and B sampled at T with a zero-order hold.
 2. P is positive definite, and both loops map E into gamma E: gamma^2 P - F'P F and gamma^2 P - G'P G
    are positive definite.
 3. |Bd| V <= 1 - gamma: no perturbation leads out of E.
 4. In E no command reaches the limit and no state the end of its word: the largest r x in E is the root
    of r P^-1 r.
 5. At every step k the loops differ, along a row C, by at most
        V (|C Bd| + |C G Bd| + ... + |C G^(k-1) Bd|) + |C G^k - C F^k|*,    |r|* the root of r P^-1 r,
    whose largest value over all k is not above what is stated. It is added up for the stated number of
    steps; later ones add at most |C|* |Bd| gamma^n/(1 - gamma) to the sum, and the second part is at most
    2 |C|* gamma^n.

A voltage drive holds V = R u + k_e (wheel speed) over a step, and the current that flows is (V - k_e (wheel speed))/R: with
w = V/R and c = k_e/R the loop is the same with A - c B (0, 0, 1) for A, sampled as it is stated, and N + c (0, 0, 1) for N. Then
E must also lie where |w| is at most what the duty and the supply give.

An encoder on the wheel shows the mean speed over the last n steps. While the wheel accelerates with at most f, that is off by
f n T/2, and by the errors of two counts instead of one. f is stated; in E, and until the next sample, no more can follow from it:
at a sample the wheel accelerates with (A3 + B3 N) x + B3 v, and until the next one the states move as the rows of A let them.

Exit code 0 and one line: it holds. 1: a sentence says what does not. 2: no such certificate.
"""

import json
import sys
from fractions import Fraction
from math import isqrt, lcm

DIGITS = 40  # a root is rounded up to so many decimals
BITS = 192  # rows C F^k are kept in units of 2^-BITS, each product rounded down


class Fails(Exception):
    """What does not hold."""


def holds(condition, sentence):
    if not condition:
        raise Fails(sentence)


def root(value):
    """A number not below the square root, by less than 10^-DIGITS."""
    holds(value >= 0, "a square is negative")
    scale = 10 ** (2 * DIGITS)
    return Fraction(isqrt(value.numerator * scale // value.denominator) + 1, 10**DIGITS)


def product(a, b):
    return [[sum(x * b[k][j] for k, x in enumerate(row)) for j in range(len(b[0]))] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def quadratic(m, v):
    return dot(v, [dot(row, v) for row in m])


def determinant(m):
    if len(m) == 1:
        return m[0][0]
    minors = ([row[:j] + row[j + 1 :] for row in m[1:]] for j in range(len(m)))
    return sum((-1) ** j * m[0][j] * determinant(minor) for j, minor in enumerate(minors))


def is_positive_definite(m):
    """Sylvester: every leading minor is positive."""
    return all(determinant([row[:n] for row in m[:n]]) > 0 for n in (1, 2, 3))


def inverse(m):
    """By cofactors, of a 3 x 3 matrix."""
    d = determinant(m)
    holds(d != 0, "a matrix is singular")

    def cofactor(i, j):
        minor = [[m[r][c] for c in range(3) if c != j] for r in range(3) if r != i]
        return (-1) ** (i + j) * determinant(minor)

    return [[cofactor(j, i) / d for j in range(3)] for i in range(3)]


def check_sampling(a, b, ad, bd, period):
    """exp of the 4 x 4 matrix (A B; 0 0) T holds Ad and Bd in its upper rows."""
    m = [[x * period for x in row] + [y * period] for row, y in zip(a, b)] + [[Fraction(0)] * 4]
    norm = max(sum(abs(x) for x in row) for row in m)
    holds(norm <= 8, "the sample time is too long for the series")
    term = [[Fraction(int(i == j)) for j in range(4)] for i in range(4)]
    total = [row[:] for row in term]
    left, k = Fraction(1), 0
    while left > Fraction(1, 10**30) or k < 2 * norm:
        k += 1
        # Numbers of 60 decimals are enough; what that cuts off is far below the tolerance.
        term = product(term, m)
        term = [[Fraction(round(x / k * 10**60), 10**60) for x in row] for row in term]
        total = [[x + y for x, y in zip(*rows)] for rows in zip(total, term)]
        left = left * norm / k
    for i in range(3):
        for j, stated in enumerate(ad[i] + [bd[i]]):
            allowed = abs(total[i][j]) / 10**12 + Fraction(1, 10**20)
            what = f"Ad[{i}][{j}]" if j < 3 else f"Bd[{i}]"
            holds(abs(stated - total[i][j]) <= allowed, f"{what} is not that of A and B")


def over_one(entries):
    """Fractions as integers over one denominator."""
    common = lcm(*(entry.denominator for entry in entries))
    return [entry.numerator * (common // entry.denominator) for entry in entries], common


def up(value):
    """In units of 2^-BITS, rounded up."""
    return -((-value.numerator << BITS) // value.denominator)


def times(row, matrix):
    """row times a matrix over one denominator, rounded down."""
    entries, denominator = matrix
    return [sum(row[i] * entries[3 * i + j] for i in range(3)) // denominator for j in range(3)]


def worst_difference(row, f, g, bd, p_inverse, bd_norm, gamma, levels, terms):
    """For each V of `levels` a bound of point 5 for the row, over all k."""
    # A row that was rounded down in each step is off by at most one unit in each entry and step, and
    # gamma shrinks what was before: together less than this in |.|*.
    unit = Fraction(1, 1 << BITS)
    row_error = unit * root(sum(abs(x) for line in p_inverse for x in line)) * (1 + 1 / (1 - gamma))
    sum_error, gain_error = up(row_error * bd_norm) + 1, up(2 * row_error) + 1
    flat = [over_one([x for line in m for x in line]) for m in (f, g, p_inverse)]
    input_, input_denominator = over_one(bd)
    noises = [up(level) for level in levels]
    with_f = [(x.numerator << BITS) // x.denominator for x in row]
    with_g, total, power = with_f[:], 0, 1 << BITS
    worst = [0] * len(levels)
    scaled_gamma = up(gamma)
    for _ in range(terms):
        response = abs(sum(x * y for x, y in zip(with_g, input_)))
        total += -(-response // input_denominator) + sum_error
        with_f, with_g = times(with_f, flat[0]), times(with_g, flat[1])
        difference = [x - y for x, y in zip(with_g, with_f)]
        entries, denominator = flat[2]
        square = sum(
            difference[i] * entries[3 * i + j] * difference[j] for i in range(3) for j in range(3)
        )
        gain = isqrt(max(0, -(-square // denominator))) + 1 + gain_error
        for index, noise in enumerate(noises):
            worst[index] = max(worst[index], ((noise * total) >> BITS) + 1 + gain)
        power = ((power * scaled_gamma) >> BITS) + 1
    reach, power = root(quadratic(p_inverse, row)), Fraction(power, 1 << BITS)
    rest = reach * bd_norm * power / (1 - gamma)
    whole = Fraction(total, 1 << BITS) + rest
    holds(rest * 1000 <= whole, f"{terms} terms leave too much open")
    late = 2 * reach * power
    return [max(Fraction(w, 1 << BITS), v * whole + late) for w, v in zip(worst, levels)]


def wheel_acceleration(a, b, gains, reach, extents, noise, period):
    """A bound of the wheel's acceleration in the set, at samples and between them, with gravity as a sine."""
    held, bounds = reach(gains) + noise, extents[:]
    sine = lambda angle: abs(a[1][0]) * angle**3 / 6
    for _ in range(40):
        moved = [
            extent + period * (dot([abs(x) for x in row], bounds) + abs(push) * held + (sine(bounds[0]) if i else 0))
            for i, (extent, row, push) in enumerate(zip(extents, a, b))
        ]
        if all(new < old for new, old in zip(moved, bounds)):
            drift = sum(abs(x) * (y - z) for x, y, z in zip(a[2], bounds, extents))
            at_sample = reach([x + b[2] * gain for x, gain in zip(a[2], gains)])
            return at_sample + abs(b[2]) * noise + drift + sine(bounds[0])
        bounds = [Fraction(int(x * (1 + Fraction(1, 10**9)) * 10**12) + 1, 10**12) for x in moved]
    raise Fails("the motion between two samples does not settle")


def check(certificate):
    number = Fraction
    loop = certificate["closed_loop"]
    if loop is None:
        return "not stated"
    vector = lambda entries: [number(entry) for entry in entries]
    matrix = lambda rows: [vector(row) for row in rows]
    plant = certificate["plant"]
    a, b, ad, bd = matrix(plant["A"]), vector(plant["B"]), matrix(plant["Ad"]), vector(plant["Bd"])
    k, p, gamma = vector(certificate["gains"]), matrix(loop["ellipsoid"]), number(loop["contraction"])
    words = certificate["constants"]
    n = [Fraction(word["raw"], 2 ** word["fraction_bits"]) for word in words[:3]]
    limit = Fraction(words[3]["raw"], 2 ** words[3]["fraction_bits"])
    half_unit = Fraction(1, 2 ** (certificate["output"]["fraction_bits"] + 1))
    inputs = certificate["inputs"]
    half_words = [Fraction(1, 2 ** (entry["fraction_bits"] + 1)) for entry in inputs]

    period = number(certificate["sample_time_s"])
    holds(period > 0, "the sample time is not positive")
    check_sampling(a, b, ad, bd, period)

    holds(p == transposed(p) and is_positive_definite(p), "P is not positive definite")
    holds(0 < gamma < 1, "the contraction is not between 0 and 1")
    held_a = a
    voltage, supply, w_gains = certificate["drive"]["voltage"], None, [[-x for x in k], n[:]]
    if voltage is not None:
        drive, ohm = certificate["drive"], number(voltage["winding_Ohm"])
        holds(ohm > 0, "the winding has no resistance")
        c = number(voltage["back_emf_V_s"]) / ohm
        ad, bd = matrix(voltage["Ad"]), vector(voltage["Bd"])
        held_a = [row[:2] + [row[2] - c * y] for row, y in zip(a, b)]
        check_sampling(held_a, b, ad, bd, period)
        w_gains = [gains[:2] + [gains[2] + c] for gains in w_gains]
        counts = min(drive["duty_high"] - drive["duty_zero"], drive["duty_zero"] - drive["duty_low"])
        supply = min(abs(number(drive["amperes_per_count"])) * counts, number(voltage["supply_V"]) / ohm)
    loops = [
        [[ad[i][j] + bd[i] * gains[j] for j in range(3)] for i in range(3)] for gains in w_gains
    ]
    for name, m in zip(("real", "emitted"), loops):
        image = product(transposed(m), product(p, m))
        margin = [[gamma**2 * p[i][j] - image[i][j] for j in range(3)] for i in range(3)]
        holds(is_positive_definite(margin), f"the loop with the {name} gains does not shrink the set")

    p_inverse = inverse(p)
    reach = lambda row: root(quadratic(p_inverse, row))
    units = [[Fraction(int(i == j)) for j in range(3)] for i in range(3)]
    extents = [reach(row) for row in units]
    for stated, found in zip(vector(loop["extents"]), extents):
        holds(found <= stated, "an extent of the set is more than is stated")
    holds(reach(k) <= number(loop["command_A"]), "the command in the set is more than is stated")
    holds(reach(k) <= number(words[3]["real"]), "the real law reaches its limit in the set")

    bd_norm = root(quadratic(p, bd))
    holds(supply is None or reach(w_gains[0]) <= supply, "the supply clips the real law in the set")
    encoder, acceleration = certificate["hardware"]["wheel_speed"]["encoder"], loop["wheel_acceleration_rad_s2"]
    holds((encoder is None) == (acceleration is None), "the wheel's acceleration belongs to an encoder")
    if encoder is not None:
        acceleration = number(acceleration)
        half_words[2] += encoder["window"] * period / 2 * acceleration
    counts = [h + abs(number(step)) / 2 for h, step in zip(half_words, loop["sensor_steps"])]
    if encoder is not None:
        counts[2] += abs(number(loop["sensor_steps"][2])) / 2
    names = [case["name"] for case in loop["cases"]]
    holds(names == ["words", "sensors"], "the cases are not words and sensors")
    levels = []
    for case, steps in zip(loop["cases"], (half_words, counts)):
        of_current = half_unit + sum(abs(gain) * step for gain, step in zip(n, steps))
        noise = half_unit + sum(abs(gain) * step for gain, step in zip(w_gains[1], steps))
        name = case["name"]
        holds(noise <= number(case["perturbation_A"]), f"{name} perturb more than is stated")
        share = bd_norm * noise / (1 - gamma)
        holds(share <= 1, f"{name} may lead out of the set")
        holds(share <= number(loop["perturbation_share"]), f"{name} need more of the set than is stated")
        holds(reach(n) + of_current <= limit, f"the emitted law may reach its limit ({name})")
        holds(supply is None or reach(w_gains[1]) + noise <= supply, f"the supply may clip ({name})")
        if encoder is not None:
            most = wheel_acceleration(held_a, b, w_gains[1], reach, extents, noise, period)
            holds(most <= acceleration, f"the wheel may accelerate more than is stated ({name})")
        for entry, extent, step in zip(inputs, extents, steps):
            largest = min(Fraction(2**31 - 1, 2 ** entry["fraction_bits"]), number(entry["range"]))
            holds(extent + step <= largest, f"the set reaches beyond {entry['argument']} ({name})")
        levels.append(noise)

    for index, row in enumerate(units + [k]):
        bounds = worst_difference(
            row, *loops, bd, p_inverse, bd_norm, gamma, levels, loop["terms"]
        )
        for case, bound in zip(loop["cases"], bounds):
            stated = case["states"][index] if index < 3 else case["command_A"]
            what = ("the angle", "the rate", "the wheel speed", "the command")[index]
            holds(bound <= number(stated), f"{what} may differ by more than is stated ({case['name']})")
    return f"every statement, {loop['terms']} steps added up"


def main():
    try:
        with open(sys.argv[1], encoding="utf-8") as file:
            certificate = json.load(file)
        print(check(certificate))
        return 0
    except Fails as failure:
        print(failure)
        return 1
    except (IndexError, OSError, ValueError, KeyError, TypeError) as error:
        print(f"no certificate: {error!r}")
        return 2


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""The claims `loop-as-shipped` and `motion-kept-up` a second time: python3 loop_as_shipped.py certificate.json

Nothing here is shared with the checker in Rust. It reads the certificate alone; that the source has the stated
words is for `flywheel prove` to show. Numbers are integers in units of 2^-BITS and fractions; what rounding does is
added to every result.

The pendulum x = (angle, rate, wheel speed) with viscous friction alone obeys

    x' = A x + B i + e f + e_w f_w,    e = (0, 1, -1),    e_w = (0, 1/D, -Theta/(j_w D)),

where |f| is at most dry friction over D plus g |angle|^3/6, what a straight line leaves out of the sine, and f_w the dry
torque on the wheel. The command of a sample is N x plus errors, and flows after a delay. z = (x, N x of one
sample before), z+ = F z for a delay of 1, 3, 5 or 7 eighths of a sample; what the delay is off by, at most
1/8 of a sample, is an input as large as the command's change.

A voltage drive holds V = R u + k_e (wheel speed), and the current that flows is (V - k_e (wheel speed))/R: the same loop for
V/R, with A - (k_e/R) B (0, 0, 1) and N + (k_e/R) (0, 0, 1), and the end of the supply as one limit more. The speed of an
encoder on the wheel is its turn over the last n steps: this turn and those of the last n - 1 steps are states of z.

An encoder on the pivot shows the angle, off by e, and (angle - angle n steps ago)/(n T) as the rate. The angles that it showed in
the last n steps are states of z, so that an error e acts on the angle and the rate of its sample, and n steps later on the rate
alone. The readings of the window before the start are off by half a count: each acts once, in the first n steps. There is no filter.

For a row C and an input v, T (|C v| + |C F v| + |C F^2 v| + ...) bounds what the input does. Later terms than
those added up are bounded by a power of F whose weighted norm is at most 1/2.

The filter's correction turns the estimate by c, 2/3 * 2 beta T <= c <= 2 beta T, towards what the accelerometer
shows, which is off by at most eta; the gyroscope disturbs by at most delta a step. Above
max(4 beta T, eta/s), s^2 = 1 - (delta/c + 2 beta T/eta)^2 or 2/3 (1 - delta/c), the estimate comes nearer.

Exit code 0 and one line: from which angle at rest, and what stays. 3: the argument does not hold this module. 1: the
certificate contradicts itself. 2: no certificate.
"""

import json
import sys
from fractions import Fraction
from math import factorial, isqrt

BITS = 140
ONE = 1 << BITS
PARTS, LATER = 3, 12
PI = Fraction(355, 113)  # above pi, by less than a ten-millionth of it
MODEL = {
    "total_inertia", "wheel_inertia", "gravity_torque", "torque_constant",
    "body_viscous_friction", "wheel_viscous_friction",
}  # fmt: skip
OTHER = {
    "body_coulomb_torque", "body_breakaway_torque", "wheel_coulomb_torque", "cogging_torque", "dead_zone",
    "current_offset", "body_stribeck_speed", "body_presliding_stiffness", "cogging_order", "cogging_phase",
    "body_inertia",  # follows from others; no equation of motion has it
}  # fmt: skip


class NotShown(Exception):
    """The argument does not hold, or does not close."""


class Contradiction(Exception):
    """The certificate cannot be true."""


def root(value, up):
    """The square root to 60 decimals, rounded up or down."""
    if value < 0:
        raise NotShown("a square is negative")
    scale = 10**120
    return Fraction(isqrt(value.numerator * scale // value.denominator) + int(up), 10**60)


def grid(value):
    return value.numerator * ONE // value.denominator


def real(entry):
    return Fraction(entry, ONE)


def times(a, b):
    """Matrices in units of 2^-BITS."""
    columns = list(zip(*b))
    return [[sum(x * y for x, y in zip(row, column)) >> BITS for column in columns] for row in a]


def short(value):
    """Rounded up to few digits."""
    return Fraction(-((-value.numerator << 80) // value.denominator), 1 << 80)


def exponential(a, b, t):
    """exp(A t) and what a current of 1 A does in t, from the series of the matrix (A B; 0 0); the wheel's angle is last."""
    m = [[grid(x * t) for x in row] + [grid(y * t)] for row, y in zip(a, b)] + [[0] * 5]
    if max(sum(abs(x) for x in row) for row in m) > 8 * ONE:
        raise NotShown("the sample time is too long for the series")
    term = [[ONE * (i == j) for j in range(5)] for i in range(5)]
    total = [row[:] for row in term]
    for k in range(1, 100):
        term = [[x // k for x in row] for row in times(term, m)]
        total = [[x + y for x, y in zip(*rows)] for rows in zip(total, term)]
    return [row[:4] for row in total[:4]], [row[4] for row in total[:4]]


class Plant:
    """A, B, gains, and the sizes of what acts on them."""

    def __init__(self, certificate):
        if certificate["bias_observer"] is not None:
            raise NotShown("the module has an observer of the angle's bias")
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
        self.g, body, drag = p["gravity_torque"] / d, of("body_viscous_friction") / d, of("wheel_viscous_friction") / d
        self.lever = theta / (wheel * d)
        spin = of("wheel_viscous_friction") * self.lever
        zero, one = Fraction(0), Fraction(1)
        self.a = [[zero, one, zero, zero], [self.g, -body, drag, zero], [-self.g, body, -spin, zero]]
        self.a.append([zero, zero, one, zero])  # the wheel's angle
        self.b = [zero, -p["torque_constant"] / d, p["torque_constant"] * self.lever, zero]
        if abs(Fraction(certificate["plant"]["A"][1][0]) - self.g) > self.g / 10**5:
            raise Contradiction("A[1][0] is not the gravity of the parameters")
        words = certificate["constants"]
        self.n = [Fraction(word["raw"], 2 ** word["fraction_bits"]) for word in words[:3]]
        self.limit = self.reach = Fraction(words[3]["raw"], 2 ** words[3]["fraction_bits"])
        self.t = Fraction(certificate["sample_time_s"])
        self.held, drive = self.n[:], certificate["drive"]
        voltage = self.voltage = drive["voltage"]
        if voltage is not None:
            ohm, back_emf = Fraction(voltage["winding_Ohm"]), Fraction(voltage["back_emf_V_s"])
            if ohm <= 0 or back_emf != p["torque_constant"]:
                raise Contradiction("the back-EMF is not that of the motor, or the winding has no resistance")
            for row, push in zip(self.a, self.b):
                row[2] -= push * back_emf / ohm
            self.held[2] += back_emf / ohm
            counts = min(drive["duty_high"] - drive["duty_zero"], drive["duty_zero"] - drive["duty_low"])
            self.reach = abs(Fraction(drive["amperes_per_count"])) * counts
            self.reach = min(self.reach, Fraction(voltage["supply_V"]) / ohm)
        encoder = certificate["hardware"]["wheel_speed"]["encoder"]
        self.window = None if encoder is None else encoder["window"]
        if self.window is not None and not 1 <= self.window <= 16:
            raise Contradiction("the encoder's window is not 1 to 16 steps")
        encoder = self.pivot = certificate["hardware"].get("body_encoder")
        self.shown = 0 if encoder is None else encoder["window"]
        if encoder is not None and not 1 <= self.shown <= 16:
            raise Contradiction("the window of the encoder on the pivot is not 1 to 16 steps")
        self.of_reading = self.n[0] + self.n[1] / (self.shown * self.t) if encoder else Fraction(0)
        self.dry = max(of("body_coulomb_torque"), of("body_breakaway_torque")) / d
        self.wheel_dry = of("wheel_coulomb_torque") + of("cogging_torque")
        self.current_off = of("dead_zone") + of("current_offset")
        self.inputs = [self.b, [zero, one, -one, zero], [zero, 1 / d, -self.lever, zero]]

    def row(self, gains):
        """Gains of the states as a row of z."""
        found = gains + [Fraction(0)]
        if self.window is not None:
            turn = gains[2] / (self.window * self.t)
            found = gains[:2] + [Fraction(0)] * 2 + [turn] + [Fraction(0)] * (self.window - 1)
        if self.shown:
            slope = gains[1] / (self.shown * self.t)
            found[:2] = [gains[0] + slope, Fraction(0)]
            found += [Fraction(0)] * (self.shown - 1) + [-slope]
        return found

    def column(self, change):
        """A change of the plant's states as one of z: the turn counts in the window and as the newest."""
        window = self.window or 0
        return change[:3] + [0] + ([change[3]] * 2 + [0] * window)[:window] + [0] * self.shown


class Responses:
    """The worst that start and inputs do to each row."""

    def __init__(self, plant, eighths):
        t, n, turns = plant.t, plant.held, 4 + (plant.window or 0)
        order = turns + plant.shown
        ad, whole = exponential(plant.a, plant.b, t)
        _, new = exponential(plant.a, plant.b, t * (8 - eighths) / 8)
        exact = plant.row(n)
        row = [grid(x) for x in exact]

        def moved(i):
            found = [new[i] * x >> BITS for x in row]
            for j in range(3):
                found[j] += ad[i][j]
            found[3] += whole[i] - new[i]
            return found

        unit = lambda place: [ONE * (j == place) for j in range(order)]
        f = [moved(0), moved(1), moved(2), row]
        if plant.window is not None:
            f.append([x + ONE * (4 < j < turns) for j, x in enumerate(moved(3))])
            f += [moved(3) if place == 5 else unit(place - 1) for place in range(5, turns)]
        f += [unit(0 if place == turns else place - 1) for place in range(turns, order)]
        turn = abs(exact[4]) if plant.window else Fraction(0)
        speed = turn * t * plant.window if plant.window else abs(n[2])
        weights = [abs(exact[0]), abs(exact[1]), speed, Fraction(1)] + [turn] * (turns - 4)
        weights += [abs(exact[-1])] * plant.shown
        weights = [weight or Fraction(1) for weight in weights]
        ratios = [[-(-x.numerator * y.denominator * ONE // (x.denominator * y.numerator)) for y in weights] for x in weights]
        norm = lambda m: real(
            max(sum(abs(x) * y >> BITS for x, y in zip(*lines) if x) for lines in zip(m, ratios))
        ) * (1 + Fraction(1, 1 << 40)) + Fraction(1, 1 << 60)
        power, m = f, 1
        while (q := norm(power)) > Fraction(1, 2):
            if m > 1 << 17:
                raise NotShown("with viscous friction alone the loop is not stable, or too slow")
            power, m = times(power, power), 2 * m
        # power f as rows times the places of f that are not zero
        lines = [[(j, x) for j, x in enumerate(line) if x] for line in f]
        power, total = [unit(i) for i in range(order)], Fraction(0)
        for _ in range(m):
            total += short(norm(power))
            found = [[0] * order for _ in range(order)]
            for sums, line in zip(found, power):
                for x, places in zip(line, lines):
                    if x:
                        for j, y in places:
                            sums[j] += x * y >> BITS
            power = found
        total /= 1 - q

        fall, push = plant.a[1], plant.b[1]
        fall = fall[:3] + [Fraction(0)] * (order - 3)
        rows = [unit(0), unit(1), unit(2), row, [x - ONE * (j == 3) for j, x in enumerate(row)]]
        rows += [[grid(x) for x in fall[:3] + [push] + fall[4:]]]
        rows += [[grid(x + push * y) for x, y in zip(fall, exact)], [grid(x) for x in plant.row(plant.n)]]
        # At rest the encoder on the pivot has shown the start all the time.
        columns, later = [[ONE * (j == 0 or j >= turns) for j in range(order)]], []
        for v in plant.inputs:
            size = Fraction(0)
            for k in range(LATER):
                if k < PARTS:
                    columns.append(plant.column([grid(x) for x in v]))
                else:
                    size += max(abs(x) for x in v) * max(weights)
                v = [sum(x * y for x, y in zip(line, v)) * t / (k + 1) for line in plant.a]
            later.append(size)
        reach = max(sum(abs(x) for x in line) for line in plant.a) * t
        if reach >= 1:
            raise NotShown("the sample time is too long: |A| T is above 1")
        beyond = reach**LATER / factorial(LATER) / (1 - reach)
        peak, kick, sums = [0] * 8, [0] * 8, [[0] * 8 for _ in range(3)]
        first, steps = 0, 16 * m
        # What does not act on the wheel is not carried along.
        acting = 3 if plant.wheel_dry else 2
        columns = columns[: 1 + PARTS * acting]
        # An error of 1 rad of one reading: at once, and in the angles that the encoder has shown.
        error = grid(plant.of_reading)
        change = [new[i] * error >> BITS for i in range(4)]
        reading = plant.column(change)
        reading[3] = error
        if plant.shown:
            reading[turns] = ONE
            columns += [reading, unit(order - 1)]
        reads, before, recent = [0] * 8, [0] * 8, [[0] * max(1, plant.shown) for _ in range(8)]
        places = [[(j, x) for j, x in enumerate(c) if x] for c in rows]
        twins = [next(k for k in range(8) if rows[k] == c) for c in rows]
        # A line with a single one moves an entry on.
        moves = [(line[0][0], None) if len(line) == 1 and line[0][1] == ONE else (0, line) for line in lines]
        after = lambda column: [
            column[place] if line is None else sum([x * column[j] for j, x in line]) >> BITS for place, line in moves
        ]
        for step in range(steps):
            seen = []
            for index, c in enumerate(places):
                if twins[index] < index:
                    seen.append(seen[twins[index]])
                elif index < 3:
                    seen.append([abs(column[index]) for column in columns])
                else:
                    seen.append([abs(sum([x * column[j] for j, x in c]) >> BITS) for column in columns])
                if index == 4 and step == 0:
                    first = seen[index][0]
                else:
                    peak[index] = max(peak[index], seen[index][0])
                for i in range(acting):
                    term = sum(seen[index][1 + PARTS * i : 1 + PARTS * (i + 1)])
                    sums[i][index] += term
                    if i == 0 and term > kick[index]:
                        kick[index] = term
                if plant.shown:
                    reads[index] += seen[index][-2]
                    recent[index][step % plant.shown] = seen[index][-1]
                    before[index] = max(before[index], sum(recent[index]))
            columns = [after(column) for column in columns]
        largest = max(weights)
        # Each step is off by less than this in an entry: products of numbers below 2^30, and a unit of F's entries.
        drift = Fraction(1, 1 << (BITS - 40)) * largest * total
        size = lambda some: sum(max(w * real(abs(x)) for w, x in zip(weights, c)) for c in some) + drift
        late = [size(columns[:1])] + [size(columns[1 + PARTS * i : 1 + PARTS * (i + 1)]) for i in range(3)]
        first_reading = 1 + PARTS * acting
        late += [size(columns[first_reading : first_reading + 1]), size(columns[first_reading + 1 :])]
        norms = [sum(real(abs(x)) / w for x, w in zip(c, weights)) for c in rows]

        def settled(index, group, value):
            found = real(value) + norms[index] * (late[group] * total + drift * steps * PARTS)
            if 1 <= group <= 3:
                rest = beyond * max(abs(x) for x in plant.inputs[group - 1]) * largest
                found += (later[group - 1] + rest) * norms[index] * total
            return short(found)

        self.peak = [settled(i, 0, peak[i]) for i in range(8)]
        self.first = settled(4, 0, first)
        self.sums = [[t * settled(i, j + 1, sums[j][i]) for i in range(8)] for j in range(3)]
        self.kick = [t * settled(i, 1, kick[i]) for i in range(8)]
        self.reading = [settled(i, 4, reads[i]) for i in range(8)]
        self.before = [settled(i, 5, before[i]) for i in range(8)]


class Errors:
    """What sensors, filter, words and duty do to the command."""

    def __init__(self, certificate, plant, noisy):
        hardware = certificate["hardware"]
        steps = Fraction(3, 2) if noisy else Fraction(1, 2)
        wheel = hardware["wheel_speed"]
        ends = [
            Fraction(wheel["rad_s_per_count"]) * wheel[end] + Fraction(wheel["rad_s_at_zero"])
            for end in ("low_counts", "high_counts")
        ]
        self.wheel_range = min(map(abs, ends)) if ends[0] * ends[1] < 0 else Fraction(0)
        # An encoder's turn is the difference of two readings.
        readings = 1 if plant.window is None else 2
        self.wheel = abs(Fraction(wheel["rad_s_per_count"])) * steps * readings
        words = [Fraction(1, 2 ** entry["fraction_bits"]) for entry in certificate["inputs"]]
        self.rate_word = words[1]
        unit = Fraction(1, 2 ** certificate["output"]["fraction_bits"])
        duty = abs(Fraction(certificate["drive"]["amperes_per_count"])) * Fraction(51, 100)
        self.rounding, self.asked_rounding = (
            sum(abs(x) * y for x, y in zip(gains, words)) + unit for gains in (plant.held, plant.n)
        )
        self.rounding += duty
        self.reading = self.at_rest = Fraction(0)
        self.t, self.pivot = plant.t, plant.pivot is not None
        if self.pivot:
            self.on_the_pivot(certificate, plant, steps)
        else:
            self.inertial(hardware, certificate["gyro_rate_hz"], steps, noisy)

    def on_the_pivot(self, certificate, plant, steps):
        """The errors of an encoder on the pivot: of a reading, and so of the rate, which is the difference of two."""
        count = 2 * PI / abs(Fraction(plant.pivot["counts_per_turn"]))
        self.reading, self.at_rest, self.of_reading = count * steps, count / 2, abs(plant.of_reading)
        self.rate = 2 * self.reading / (plant.shown * self.t) + self.rate_word
        ranges = [Fraction(entry["range"]) for entry in certificate["inputs"]]
        wrap = 2 ** plant.pivot["bits"] * count * Fraction(99, 100)
        self.rate_range = min(ranges[1], (wrap / 2 - 2 * self.reading) / self.t)
        self.angle_range = min(ranges[0], wrap / 2) - self.reading

    def inertial(self, hardware, rate, steps, noisy):
        """The errors of gyroscope and accelerometer."""

        def sensor(name):
            clips = [abs(clip) for clip in hardware[name]["clip_counts"] if clip]
            step = min((clip & -clip for clip in clips), default=1)
            axes = [sum(abs(Fraction(x)) for x in line) * steps * step for line in hardware[name]["matrix"]]
            return max(axes), root(sum(axis * axis for axis in axes), True)

        self.gyro_axis, self.gyro = sensor("gyroscope")
        _, self.accel = sensor("accelerometer")
        beta = Fraction(hardware["beta_rad_s"])
        if beta <= 0:
            raise Contradiction("the filter never corrects")
        if Fraction(hardware["drift_time_s"]) < 20:
            raise NotShown("the gyroscope's drift is followed so fast that it follows the correction's ripple")

        def per_unit(name):
            m = [[Fraction(x) for x in line] for line in hardware[name]["matrix"]]
            minor = lambda i, j: (
                m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
                - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
            )
            d = sum(m[0][j] * minor(0, j) for j in range(3))
            if d == 0:
                raise Contradiction("a sensor's matrix is singular")
            room = [
                clip - abs(Fraction(bias)) - 16 * steps
                for clip, bias in zip(hardware[name]["clip_counts"], hardware[name]["bias_counts"])
            ]
            return [[minor(j, i) / d for j in range(3)] for i in range(3)], room

        counts, room = per_unit("gyroscope")
        self.rate_range = min(space / abs(line[2]) for space, line in zip(room, counts) if line[2])
        counts, room = per_unit("accelerometer")
        self.accel_range = min(space / root(sum(x * x for x in line), True) for space, line in zip(room, counts))
        self.turn = 2 * beta * self.t
        self.drift = beta / 10 if noisy else Fraction(0)
        self.age = 1 / Fraction(rate) if rate is not None and Fraction(rate) > 0 else Fraction(0)
        self.lever = root(sum(Fraction(x) ** 2 for x in hardware["lever_arm_m"]), True)
        self.g = Fraction(hardware["gravity_m_s2"])

    def filter(self, acceleration, rate):
        moved = 2 * self.lever * (2 * acceleration + rate * rate) + self.lever * self.gyro / self.t
        off = self.accel + moved
        if 2 * off >= self.g:
            raise NotShown("at the accelerometer the motion is as large as gravity")
        if self.g + off >= self.accel_range:
            raise NotShown("the accelerometer may come to the end of its range")
        eta = off / (self.g - off) * Fraction(101, 100)
        old = self.age - self.t / 2 if self.age > self.t else self.t / 2
        delta = self.t * (self.gyro + self.drift + acceleration * old) + Fraction(16, 10**7)
        share = delta / (self.turn * Fraction(2, 3))
        if share >= 1:
            raise NotShown("the gyroscope may turn the estimate faster than the filter's beta turns it back")
        square, other = Fraction(2, 3) * (1 - share), share + self.turn / eta
        if other < 1:
            square = max(square, 1 - other * other)
        return max(eta / root(square, False), 2 * self.turn) + self.turn + delta + Fraction(1, 10**6)

    def off(self, acceleration):
        """By how much a shown rate is off."""
        return self.rate if self.pivot else self.gyro_axis + self.drift + self.age * acceleration + self.rate_word

    def weighted(self, gains, acceleration, rate):
        """All errors of the command but those of a reading of the pivot's encoder."""
        wheel = abs(gains[2]) * self.wheel
        if self.pivot:
            return wheel
        return abs(gains[0]) * self.filter(acceleration, rate) + abs(gains[1]) * self.off(acceleration) + wheel

    def at_once(self):
        """What an error of a reading does to the command of its own sample."""
        return self.of_reading * self.reading if self.pivot else Fraction(0)


def settled(plant, errors, rows, current):
    """The motion between samples while the drive holds at most this: states, acceleration, error of what it holds."""
    strength = max(abs(x) for x in plant.inputs[2])
    sine = lambda angle: plant.g * angle**3 / 6
    b = rows[:3]
    for _ in range(200):
        reached = []
        for i in range(3):
            speed = abs(plant.b[i]) * current + sum(abs(x) * y for x, y in zip(plant.a[i], b))
            if i:
                speed += plant.dry + sine(b[0]) + strength * plant.wheel_dry
            reached.append(rows[i] + plant.t * speed)
        if all(new < old for new, old in zip(reached, b)):
            break
        b = [short(x * (1 + Fraction(1, 1 << 20)) + Fraction(1, 1 << 60)) for x in reached]
    else:
        raise NotShown("the motion between two samples does not settle")
    plain = max(rows[5], rows[6]) + sum(abs(x) * (y - z) for x, y, z in zip(plant.a[1], b, rows))
    plain += plant.dry + sine(b[0]) + strength * plant.wheel_dry
    noise = Fraction(0)
    for _ in range(200):
        acceleration = plain + abs(plant.b[1]) * (noise + errors.at_once())
        more = errors.weighted(plant.held, acceleration, b[1]) + errors.rounding + plant.current_off
        if more <= noise:
            return b, acceleration, noise
        noise = short(more * (1 + Fraction(1, 1 << 30)))
    raise NotShown("the age of the gyroscope's readings feeds on itself")


def following(plant, responses, errors, rows, start, before):
    """What bounds follow at the next sample from those that held until now; states between, current, what is within."""
    sine = lambda angle: plant.g * angle**3 / 6
    # Nothing above the end of the drive; and by that, nothing above what is to be held and its error.
    end = plant.reach + plant.current_off + errors.rounding
    _, _, noise = settled(plant, errors, rows, end)
    b, acceleration, noise = settled(plant, errors, rows, min(end, rows[3] + noise + errors.at_once()))
    body, late = plant.dry + sine(b[0]), (rows[4] + errors.at_once()) / 8
    sums = responses.sums
    found = [
        short(
            start * responses.peak[i] + sums[0][i] * (noise + late) + sums[1][i] * body
            + sums[2][i] * plant.wheel_dry + responses.reading[i] * errors.reading
            + responses.before[i] * before + responses.kick[i] * responses.first * start / 8
        )
        for i in range(8)
    ]  # fmt: skip
    asked = found[7] + errors.weighted(plant.n, acceleration, b[1]) + errors.at_once() + errors.asked_rounding
    inside = b[1] + errors.off(acceleration) < errors.rate_range
    inside = inside and (plant.voltage is None or found[3] + noise + errors.at_once() < plant.reach)
    inside = inside and (not errors.pivot or b[0] < errors.angle_range)
    return found, b, asked, inside and b[2] + errors.wheel < errors.wheel_range


def closing(plant, responses, errors, start):
    """Bounds that keep themselves, or None."""
    rows = [short(start * x + y * errors.at_rest) for x, y in zip(responses.peak, responses.before)]
    for _ in range(200):
        try:
            found, b, asked, inside = following(plant, responses, errors, rows, start, errors.at_rest)
        except NotShown:
            return None
        if not inside or asked >= plant.limit or b[0] * plant.g >= abs(plant.b[1]) * plant.limit:
            return None
        if all(new <= old for new, old in zip(found, rows)):
            return rows, b, asked
        rows = [short(max(x, y) * (1 + Fraction(1, 1 << 12))) for x, y in zip(found, rows)]
    return None


def check(certificate):
    plant = Plant(certificate)
    noisy, quiet = Errors(certificate, plant, True), Errors(certificate, plant, False)
    start, all_responses = Fraction(1), [Responses(plant, eighths) for eighths in (1, 3, 5, 7)]
    for responses in all_responses:
        if closing(plant, responses, noisy, Fraction(0)) is None:
            raise NotShown("even from upright no bounds keep themselves")
        low, high = Fraction(0), Fraction(1)
        for _ in range(18):
            middle = (low + high) / 2
            low, high = (middle, high) if closing(plant, responses, noisy, middle) else (low, middle)
        start = min(start, low)
    bounds, kept = [Fraction(0)] * 4, [Fraction(0)] * 4
    for responses in all_responses:
        rows, b, command = closing(plant, responses, noisy, start)
        bounds = [max(x, y) for x, y in zip(bounds, b + [command])]
        for _ in range(200):
            found, b, asked, _ = following(plant, responses, quiet, rows, Fraction(0), Fraction(0))
            done = all(new * (1 + Fraction(1, 1 << 12)) >= old for new, old in zip(found, rows))
            rows = [min(x, y) for x, y in zip(found, rows)]
            if done:
                break
        kept = [max(x, y) for x, y in zip(kept, b + [asked])]
    three = lambda values: ", ".join(f"{float(value):.4g}" for value in values)
    return f"from rest up to {float(start):.5f} rad: within {three(bounds)} (rad, rad/s, rad/s, A); kept up: {three(kept)}"


def main():
    try:
        with open(sys.argv[1], encoding="utf-8") as file:
            certificate = json.load(file)
        print(check(certificate))
        return 0
    except NotShown as why:
        print(why)
        return 3
    except Contradiction as why:
        print(why)
        return 1
    except (IndexError, OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        print(f"no certificate: {error!r}")
        return 2


if __name__ == "__main__":
    sys.exit(main())

"""The sampled loop of the pendulum, and the worst that starts and inputs do to it, for `loop_as_shipped.py` and `loop_from_rest.py`.

Nothing here is shared with the checker in Rust. Numbers are integers in units of 2^-BITS and fractions; what rounding does is
added to every result.

The plant x = (angle, rate, wheel speed) obeys x' = A x + B i + e f + e_w f_w; f is a torque on the body over D, and what a
straight line leaves out of the sine, and f_w a torque on the wheel. The command of a sample is N x plus errors, and flows after a
delay of some eighths of a sample. z = (x, N x of one sample before), z+ = F z.

A voltage drive holds V = R u + k_e (wheel speed), and the current that flows is (V - k_e (wheel speed))/R: the same loop for
V/R, with A - (k_e/R) B (0, 0, 1) and N + (k_e/R) (0, 0, 1), and the end of the supply as one limit more. The speed of an
encoder on the wheel is its turn over the last n steps: this turn and those of the last n - 1 steps are states of z.

An encoder on the pivot shows the angle, off by e, and (angle - angle n steps ago)/(n T) as the rate. The angles that it showed in
the last n steps are states of z, so that an error e acts on the angle and the rate of its sample, and n steps later on the rate
alone. The readings of the window before the start are off by half a count: each acts once, in the first n steps.

An observer of the angle's bias is a state of z too. With y what is shown of x, the emitted words give the bias s + l y, the command
u = N (y - (s + l y) e_1) and the next s = d s + m y + f u. With N' = N - N_1 l the command is N' y - N_1 s, and
s+ = (d - f N_1) s + (m + f N') y. At rest it waits at s = -l y, so that it sees no bias. It knows the command with all its errors:
an error of y, or of the sum that is the command, acts on the command and on s together. These are inputs of their own, and
so is the rounding of s.

For a row C and an input v, T (|C v| + |C F v| + |C F^2 v| + ...) bounds what the input does. Later terms than
those added up are bounded by a power of F whose weighted norm is at most 1/4.
"""

import json
import sys
from fractions import Fraction
from math import factorial, isqrt

BITS = 140
ONE = 1 << BITS
PARTS, LATER = 3, 12


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


def words_of(certificate):
    """The emitted gains N, and the largest command."""
    *gains, limit = [Fraction(word["raw"], 2 ** word["fraction_bits"]) for word in certificate["constants"]]
    return gains, limit


STATE_BITS = 30  # of the observer's word


def observer_words(certificate):
    """The observer's numbers (d, l, m, f) as its words have them; None without one. All products have as many bits after the point as
    let their sums stay within 64 bits."""
    stated = certificate["bias_observer"]
    if stated is None:
        return None
    bits = [entry["fraction_bits"] for entry in certificate["inputs"]]
    of_current = certificate["output"]["fraction_bits"]
    for product in range(60, max(STATE_BITS, bits[0]), -1):
        word = lambda text, own: round(Fraction(text) * 2 ** (product - own))
        decay, current = word(stated["decay"], STATE_BITS), word(stated["from_current"], of_current)
        direct, into = ([word(x, own) for x, own in zip(stated[key], bits)] for key in ("direct", "from_states"))
        sums = 2 ** (product - STATE_BITS) + sum(map(abs, direct)), abs(decay) + abs(current) + sum(map(abs, into))
        if max(sums) < 2**31:
            number = lambda value, own: Fraction(value, 2 ** (product - own))
            of_states = lambda values: [number(value, own) for value, own in zip(values, bits)]
            return number(decay, STATE_BITS), of_states(direct), of_states(into), number(current, of_current)
    raise Contradiction("the numbers of the observer fit no words")


def observer_decimals(certificate):
    """The same as they are stated, in real numbers."""
    stated = certificate["bias_observer"]
    if stated is None:
        return None
    vector = lambda entries: [Fraction(entry) for entry in entries]
    return Fraction(stated["decay"]), vector(stated["direct"]), vector(stated["from_states"]), Fraction(stated["from_current"])


class Plant:
    """A, B, gains, and the sizes of what acts on them."""

    def __init__(self, certificate, gains, a, b, e_w, delay_off, observer=None):
        """A 3 x 3 and B of the current, the gains N, e_w, by how much of a sample a delay may be off, and the observer's numbers."""
        zero, one = Fraction(0), Fraction(1)
        self.a = [row + [zero] for row in a] + [[zero, zero, one, zero]]  # the wheel's angle
        self.b, self.n, self.delay_off = b + [zero], gains, delay_off
        self.g, self.direct = a[1][0], None
        if observer is not None:
            decay, self.direct, into, of_current = observer
            self.of_bias = gains[0]
            self.n = [x - gains[0] * y for x, y in zip(gains, self.direct)]
            self.decay, self.of_current = decay - of_current * gains[0], of_current
            self.into = [x + of_current * y for x, y in zip(into, self.n)]
        _, self.limit = words_of(certificate)
        self.reach = self.limit
        self.t = Fraction(certificate["sample_time_s"])
        if self.t <= 0:
            raise Contradiction("the sample time is not positive")
        self.held, drive = self.n[:], certificate["drive"]
        voltage = self.voltage = drive["voltage"]
        if voltage is not None:
            ohm, back_emf = Fraction(voltage["winding_Ohm"]), Fraction(voltage["back_emf_V_s"])
            torque = [entry for entry in certificate["parameters"] if entry["name"] == "torque_constant"]
            if ohm <= 0 or any(Fraction(entry["value"]) != back_emf for entry in torque):
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
        if encoder is not None and observer is not None:
            raise Contradiction("an observer of the angle's bias belongs to gyroscope and accelerometer")
        self.of_reading = self.n[0] + self.n[1] / (self.shown * self.t) if encoder else Fraction(0)
        # Inputs of one sample: what 1 of each does to what the drive holds, to the command, and to the observer's state.
        self.readings = []
        if encoder is not None:
            self.readings = [(self.of_reading, self.of_reading, zero)]
        if observer is not None:
            self.readings = [*zip(self.held, self.n, self.into), (one, one, of_current), (zero, zero, one)]
        self.dry = self.wheel_dry = self.current_off = zero
        self.inputs = [self.b, [zero, one, -one, zero], e_w + [zero]]

    def row(self, gains, of_observer=0):
        """Gains of the states, and of the observer's state, as a row of z."""
        found = gains + [Fraction(0)]
        if self.window is not None:
            turn = gains[2] / (self.window * self.t)
            found = gains[:2] + [Fraction(0)] * 2 + [turn] + [Fraction(0)] * (self.window - 1)
        if self.shown:
            slope = gains[1] / (self.shown * self.t)
            found[:2] = [gains[0] + slope, Fraction(0)]
            found += [Fraction(0)] * (self.shown - 1) + [-slope]
        return found + ([Fraction(of_observer)] if self.direct else [])

    def column(self, change):
        """A change of the plant's states as one of z: the turn counts in the window and as the newest."""
        window = self.window or 0
        return change[:3] + [0] + ([change[3]] * 2 + [0] * window)[:window] + [0] * (self.shown + bool(self.direct))


class Responses:
    """The worst that start and inputs do to each row."""

    def __init__(self, plant, eighths):
        t, n, turns = plant.t, plant.held, 4 + (plant.window or 0)
        shown = turns + plant.shown
        order = shown + bool(plant.direct)
        ad, whole = exponential(plant.a, plant.b, t)
        _, new = exponential(plant.a, plant.b, t * (8 - eighths) / 8)
        of_bias = -plant.of_bias if plant.direct else 0
        exact, asked = plant.row(n, of_bias), plant.row(plant.n, of_bias)
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
        f += [unit(0 if place == turns else place - 1) for place in range(turns, shown)]
        if plant.direct:
            f.append([grid(x) for x in plant.row(plant.into, plant.decay)])
        turn = abs(exact[4]) if plant.window else Fraction(0)
        speed = turn * t * plant.window if plant.window else abs(n[2])
        weights = [abs(exact[0]), abs(exact[1]), speed, Fraction(1)] + [turn] * (turns - 4)
        weights += [abs(exact[-1])] * (order - turns)
        weights = [weight or Fraction(1) for weight in weights]
        ratios = [[-(-x.numerator * y.denominator * ONE // (x.denominator * y.numerator)) for y in weights] for x in weights]
        norm = lambda m: real(
            max(sum(abs(x) * y >> BITS for x, y in zip(*lines) if x) for lines in zip(m, ratios))
        ) * (1 + Fraction(1, 1 << 40)) + Fraction(1, 1 << 60)
        power, m = f, 1
        while (q := norm(power)) > Fraction(1, 4):
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
        rows += [[grid(x + push * y) for x, y in zip(fall, exact)], [grid(x) for x in asked]]
        rows += [[grid(x) for x in plant.row(plant.direct, 1)] if plant.direct else [0] * order]
        # At rest the encoder on the pivot has shown the start all the time, and the observer sees no bias.
        columns, later = [[ONE * (j == 0 or turns <= j < shown) for j in range(order)]], []
        if plant.direct:
            columns[0][-1] = grid(-plant.direct[0])
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
        count = len(rows)
        peak, kick, sums = [0] * count, [0] * count, [[0] * count for _ in range(3)]
        first, steps = 0, 8 * m
        # What does not act on the wheel is not carried along.
        acting = 3 if plant.wheel_dry else 2
        columns = columns[: 1 + PARTS * acting]
        # Errors of one sample: at once, in the angles that the encoder has shown, and in the observer's state. The last column is an
        # error before the start, which acts once.
        reads = len(plant.readings)
        for at_once, _, into in plant.readings:
            error = grid(at_once)
            reading = plant.column([new[i] * error >> BITS for i in range(4)])
            reading[3] = error
            if plant.shown:
                reading[turns] = ONE
            else:
                reading[-1] = grid(into)
            columns.append(reading)
        if reads:
            columns.append(unit(order - 1))
        reading, span = [[0] * count for _ in range(reads)], max(1, plant.shown)
        before, recent = [0] * count, [[0] * span for _ in range(count)]
        places = [[(j, x) for j, x in enumerate(c) if x] for c in rows]
        twins = [next(k for k in range(count) if rows[k] == c) for c in rows]
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
                if reads:
                    for k in range(reads):
                        reading[k][index] += seen[index][k - reads - 1]
                    recent[index][step % span] = seen[index][-1]
                    before[index] = max(before[index], sum(recent[index]))
            columns = [after(column) for column in columns]
        largest = max(weights)
        # Each step is off by less than this in an entry: products of numbers below 2^30, and a unit of F's entries.
        drift = Fraction(1, 1 << (BITS - 40)) * largest * total
        size = lambda some: sum(max(w * real(abs(x)) for w, x in zip(weights, c)) for c in some) + drift
        late = [size(columns[:1])] + [size(columns[1 + PARTS * i : 1 + PARTS * (i + 1)]) for i in range(3)]
        late += [size([column]) for column in columns[1 + PARTS * acting :]]
        norms = [sum(real(abs(x)) / w for x, w in zip(c, weights)) for c in rows]

        def settled(index, group, value):
            found = real(value) + norms[index] * (late[group] * total + drift * steps * PARTS)
            if 1 <= group <= 3:
                rest = beyond * max(abs(x) for x in plant.inputs[group - 1]) * largest
                found += (later[group - 1] + rest) * norms[index] * total
            return short(found)

        self.peak = [settled(i, 0, peak[i]) for i in range(count)]
        self.first = settled(4, 0, first)
        self.sums = [[t * settled(i, j + 1, sums[j][i]) for i in range(count)] for j in range(3)]
        self.kick = [t * settled(i, 1, kick[i]) for i in range(count)]
        self.reading = [[settled(i, 4 + k, reading[k][i]) for i in range(count)] for k in range(reads)]
        self.before = [settled(i, 4 + reads, before[i]) if reads else Fraction(0) for i in range(count)]


def run(check):
    """Prints what a check says of the certificate that is named on the command line; the exit code."""
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

"""Bounds of the motion that keep themselves, for `loop_as_shipped.py` and `loop_from_rest.py`: what sensors, filter, words and duty do
to the command, and the largest start at rest from which no bound is passed.

The filter's correction turns the estimate by c, 2/3 * 2 beta T <= c <= 2 beta T, towards what the accelerometer
shows, which is off by at most eta; the gyroscope disturbs by at most delta a step. Above
max(4 beta T, eta/s), s^2 = 1 - (delta/c + 2 beta T/eta)^2 or 2/3 (1 - delta/c), the estimate comes nearer. An encoder on the pivot
needs no filter.
"""

from fractions import Fraction

from motion import STATE_BITS, Contradiction, NotShown, root, short

PI = Fraction(355, 113)  # above pi, by less than a ten-millionth of it


def step_of(sensor):
    """The step of its words in counts: that of a left-justified word is the power of two which divides its ends."""
    clips = [abs(clip) for clip in sensor["clip_counts"] if clip]
    return min((clip & -clip for clip in clips), default=1)


class Errors:
    """What sensors, filter, words and duty do to the command."""

    def __init__(self, certificate, plant, noisy, is_direct=False):
        """With `is_direct`, angle and rate are measured to the nearest count, by no filter."""
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
        self.observer = plant.direct
        if self.observer:
            # The observer knows the command with its errors, but not what the duty adds. The shown bias is rounded to half a word.
            self.words, self.own = words, unit + abs(plant.of_bias) * words[0] / 2
            self.rounding, self.asked_rounding = duty, Fraction(0)
            self.bias_limit = Fraction(certificate["bias_observer"]["limit_rad"]) - words[0]
        self.reading = self.at_rest = Fraction(0)
        self.t, self.pivot, self.direct, self.angle_range = plant.t, plant.pivot is not None, None, None
        if self.pivot:
            self.on_the_pivot(certificate, plant, steps)
        elif is_direct:
            self.counts(certificate)
        else:
            self.inertial(hardware, certificate["gyro_rate_hz"], steps, noisy)

    def on_the_pivot(self, certificate, plant, steps):
        """The errors of an encoder on the pivot: of a reading, and so of the rate, which is the difference of two."""
        count = 2 * PI / abs(Fraction(plant.pivot["counts_per_turn"]))
        self.reading, self.at_rest = count * steps, count / 2
        self.rate = 2 * self.reading / (plant.shown * self.t) + self.rate_word
        ranges = [Fraction(entry["range"]) for entry in certificate["inputs"]]
        wrap = 2 ** plant.pivot["bits"] * count * Fraction(99, 100)
        self.rate_range = min(ranges[1], (wrap / 2 - 2 * self.reading) / self.t)
        self.angle_range = min(ranges[0], wrap / 2) - self.reading

    def counts(self, certificate):
        """The errors of an angle and a rate that are off by half a step of accelerometer and gyroscope."""
        hardware = certificate["hardware"]

        def half_steps(name):
            step = Fraction(step_of(hardware[name]), 2)
            return [sum(abs(Fraction(x)) for x in line) * step for line in hardware[name]["matrix"]]

        *plane, _ = half_steps("accelerometer")
        angle = max(plane) / Fraction(hardware["gravity_m_s2"])
        self.direct = angle, half_steps("gyroscope")[2] + self.rate_word
        ranges = [Fraction(entry["range"]) for entry in certificate["inputs"]]
        self.angle_range, self.rate_range = ranges[0] - angle, ranges[1]

    def inertial(self, hardware, rate, steps, noisy):
        """The errors of gyroscope and accelerometer."""

        def sensor(name):
            step = steps * step_of(hardware[name])
            axes = [sum(abs(Fraction(x)) for x in line) * step for line in hardware[name]["matrix"]]
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
        if self.direct:
            return self.direct[1]
        return self.rate if self.pivot else self.gyro_axis + self.drift + self.age * acceleration + self.rate_word

    def parts(self, acceleration, rate):
        """By how much angle, rate and wheel speed are off, where no encoder is on the pivot."""
        angle = self.direct[0] if self.direct else self.filter(acceleration, rate)
        return [angle, self.off(acceleration), self.wheel]

    def weighted(self, gains, acceleration, rate):
        """All errors of the command but those that are inputs of one sample."""
        if self.pivot:
            return abs(gains[2]) * self.wheel
        if self.observer:
            return Fraction(0)
        return sum(abs(x) * y for x, y in zip(gains, self.parts(acceleration, rate)))

    def of_sample(self, acceleration, rate):
        """The sizes of the inputs of one sample (`Plant.readings`)."""
        if self.pivot:
            return [self.reading]
        if not self.observer:
            return []
        shown = [part + word for part, word in zip(self.parts(acceleration, rate), self.words)]
        return shown + [self.own, Fraction(1, 2 ** (STATE_BITS + 1))]


    def waiting(self, plant, acceleration, rate):
        """By how much the bias that an observer sees at rest, before the start, and its state may be off."""
        if not self.observer:
            return Fraction(0)
        sizes = self.of_sample(acceleration, rate)
        return added(plant.direct, sizes) + self.words[0] / 2 + sizes[-1]


def added(gains, sizes):
    return sum(abs(x) * y for x, y in zip(gains, sizes))


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
    of_held = [at_once for at_once, _, _ in plant.readings]
    noise = at_once = Fraction(0)
    for _ in range(200):
        acceleration = plain + abs(plant.b[1]) * (noise + at_once)
        more = errors.weighted(plant.held, acceleration, b[1]) + errors.rounding + plant.current_off
        sizes = errors.of_sample(acceleration, b[1])
        if more <= noise and added(of_held, sizes) <= at_once:
            return b, acceleration, noise, at_once
        noise, at_once = (short(x * (1 + Fraction(1, 1 << 30))) for x in (more, added(of_held, sizes)))
    raise NotShown("the age of the gyroscope's readings feeds on itself")


def following(plant, responses, errors, rows, start, is_start):
    """What bounds follow at the next sample from those that held until now; states between, current, what is within."""
    sine = lambda angle: plant.g * angle**3 / 6
    # Nothing above the end of the drive; and by that, nothing above what is to be held and its error.
    end = plant.reach + plant.current_off + errors.rounding
    _, _, noise, at_once = settled(plant, errors, rows, end)
    b, acceleration, noise, at_once = settled(plant, errors, rows, min(end, rows[3] + noise + at_once))
    body, late = plant.dry + sine(b[0]), (rows[4] + at_once) * plant.delay_off
    sums, sizes = responses.sums, errors.of_sample(acceleration, b[1])
    of_bias = errors.waiting(plant, acceleration, b[1])
    before = errors.at_rest + of_bias if is_start else Fraction(0)
    found = [
        short(
            start * responses.peak[i] + sums[0][i] * (noise + late) + sums[1][i] * body
            + sums[2][i] * plant.wheel_dry + added([reading[i] for reading in responses.reading], sizes)
            + responses.before[i] * before + responses.kick[i] * responses.first * start * plant.delay_off
        )
        for i in range(9)
    ]  # fmt: skip
    asked = found[7] + errors.weighted(plant.n, acceleration, b[1]) + errors.asked_rounding
    asked += added([command for _, command, _ in plant.readings], sizes)
    inside = b[1] + errors.off(acceleration) < errors.rate_range
    inside = inside and (plant.voltage is None or found[3] + noise + at_once < plant.reach)
    inside = inside and (errors.angle_range is None or b[0] < errors.angle_range)
    if plant.direct:
        # Neither the bias nor the observer's state, which is the bias less l y, comes to the end of its range.
        state = found[8] + 2 * of_bias + added(plant.direct, b)
        inside = inside and found[8] + of_bias < errors.bias_limit and state < Fraction(199, 100)
    return found, b, asked, inside and b[2] + errors.wheel < errors.wheel_range


def closing(plant, responses, errors, start):
    """Bounds that keep themselves, or None."""
    rows = [short(start * x + y * errors.at_rest) for x, y in zip(responses.peak, responses.before)]
    for _ in range(200):
        try:
            found, b, asked, inside = following(plant, responses, errors, rows, start, True)
        except NotShown:
            return None
        if not inside or asked >= plant.limit or b[0] * plant.g >= abs(plant.b[1]) * plant.limit:
            return None
        if all(new <= old for new, old in zip(found, rows)):
            return rows, b, asked
        rows = [short(max(x, y) * (1 + Fraction(1, 1 << 12))) for x, y in zip(found, rows)]
    return None


def largest_start(plant, responses, errors):
    """The largest angle at rest from which bounds keep themselves, to one part in 2^18 of a radian."""
    if closing(plant, responses, errors, Fraction(0)) is None:
        raise NotShown("even from upright no bounds keep themselves")
    low, high = Fraction(0), Fraction(1)
    for _ in range(18):
        middle = (low + high) / 2
        low, high = (middle, high) if closing(plant, responses, errors, middle) else (low, middle)
    return low


def kept_up(plant, responses, errors, rows):
    """The bounds that every motion within `rows` comes to, and then keeps: states between samples, and the command."""
    for _ in range(200):
        found, b, asked, _ = following(plant, responses, errors, rows, Fraction(0), False)
        done = all(new * (1 + Fraction(1, 1 << 12)) >= old for new, old in zip(found, rows))
        rows = [min(x, y) for x, y in zip(found, rows)]
        if done:
            break
    return b + [asked]


def digits(values):
    """Four digits of each."""
    return ", ".join(f"{float(value):.4g}" for value in values)

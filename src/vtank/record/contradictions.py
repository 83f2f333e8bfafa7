"""Where channels of one recording contradict each other: degrees, z axis up, axes mixed up, clocks that part.

Nothing is refused here: a vehicle may stand on its head. What is said names columns, what was found, the likely cause.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .columns import ACCELERATION, ATTITUDE, MOTION, RATES, channel_of
from .run import INPUTS, FloatArray, Run

TURN = 2.0 * np.pi
ALIKE = 0.7  # correlation above which two channels tell of one motion; a choice
DEGREES = 180.0 / np.pi
GRAVITY_M_S2 = 9.81  # [m/s2] to three digits, as no accelerometer is better by itself
ABOVE_M = 0.5  # [m] of negative depth that no wave or offset explains; a choice
ONE, ANOTHER = 0.9, 1.5  # correlation above which two channels are one, and their ratio in another unit; choices
BEYOND_TURN = 7.0  # [rad] beyond which an angle is in degrees, or has been counted on and needs no unwrapping; a choice
LATE_S = 0.3  # [s] by which two clocks part at least, more than the delays of sensors; a choice
LATE_STEPS = 2.0  # the same in steps of the slower channel; a choice
LONGEST_S = 10.0  # [s] searched either way; a choice
BETTER = 0.5  # share of what two channels do not have in common that a delay must explain; a choice
PART = 0.5  # of how fast depth changes, that heave makes at least where its sign is judged; a choice
MOVES = 20  # samples that a comparison needs; a choice
SMOOTH_S = 1.0  # [s] over which channels are averaged, so that the noise of a derivative hides nothing; a choice
FINEST = 2**15  # points on which two channels are compared at most; a choice


def contradictions(run: Run) -> list[str]:
    """What of a whole vehicle's recording cannot be as its columns say, one sentence each; none for a sound one.

    Of a run along one axis, whose other columns are not read, nothing is said.
    """
    if set(INPUTS) & set(run.columns) and run.outputs:
        return []
    return [*_degrees(run), *_angles_and_rates(run), *_units(run), *_upside_down(run), *_gravity(run), *_clocks(run)]


def measured(run: Run, channel: str) -> list[str]:
    """The columns that hold a channel, of one sensor or several."""
    return [name for name in run.columns if channel_of(name) == channel in MOTION]


def _degrees(run: Run) -> Iterator[str]:
    """A heading that does not begin within one turn; a vehicle that rolls over and over, and no rate says so."""
    for name in measured(run, "heading_rad"):
        first = float(run.samples(name)[1][0])
        if abs(first) > TURN:
            yield f"column {name}: begins at {first:.4g} rad, {abs(first) / TURN:.3g} turns; are these degrees?"
    for name in measured(run, "roll_rad") if not measured(run, "roll_rate_rad_s") else ():
        most = float(np.max(np.abs(run.samples(name)[1])))
        if most > TURN:
            yield f"column {name}: reaches {most:.4g} rad, {most / TURN:.3g} turns; are these degrees?"


def _angles_and_rates(run: Run) -> Iterator[str]:
    """An angle's derivative against its rate: in degrees, with another sign, or of another axis."""
    for angle, rate in zip(ATTITUDE, RATES, strict=True):
        for name in measured(run, angle):
            for other in measured(run, rate):
                slope, alike = _slope(run, name, other)
                if abs(alike) < ALIKE:
                    continue
                if slope < 0.0:
                    yield f"columns {name} and {other}: they turn against each other; a sign, or z axis up?"
                elif slope > np.sqrt(DEGREES):
                    yield f"column {name}: turns {slope:.3g} times as fast as {other}; is it in degrees?"
                elif slope < 1.0 / np.sqrt(DEGREES):
                    yield f"column {other}: is {1.0 / slope:.3g} times as fast as {name} turns; is it in degrees?"


def _units(run: Run) -> Iterator[str]:
    """Two sensors that tell of one motion, one of them many times as much."""
    for channel in MOTION:
        names = measured(run, channel)
        for k, first in enumerate(names):
            for second in names[k + 1 :]:
                grid = _grid(run, first, second)
                if grid.size < MOVES:
                    continue
                a, b = (_smooth(_on(run, name, grid), grid) for name in (first, second))
                power = np.sqrt(float(a @ a) * float(b @ b))
                if not power or abs(float(a @ b)) / power < ONE:
                    continue
                times = float(np.sqrt((a @ a) / (b @ b)))
                if max(times, 1.0 / times) > ANOTHER:
                    large, small = (first, second) if times > 1.0 else (second, first)
                    yield (f"columns {large} and {small}: the first is {max(times, 1.0 / times):.3g} times the second; "
                           "is one in another unit?")  # fmt: skip


def _upside_down(run: Run) -> Iterator[str]:
    """Depth that falls below zero, or rises when heave says that the vehicle goes up."""
    for name in measured(run, "depth_m"):
        depth = run.samples(name)[1]
        if np.median(depth) < -ABOVE_M:
            yield f"column {name}: {np.median(depth):.3g} m on average, above the surface; is it height, z axis up?"
        for heave in measured(run, "heave_m_s"):
            if _sinking(run, name, heave) < -ALIKE:
                yield f"columns {name} and {heave}: depth grows while heave says up; does the z axis of one point up?"


def _gravity(run: Run) -> Iterator[str]:
    """Specific force at rest, which points up, against the attitude; quaternions in another order do not agree."""
    for x in measured(run, ACCELERATION[0]):
        sensor = x.removesuffix(ACCELERATION[0])
        if not all(sensor + name in run.columns for name in ACCELERATION):
            continue
        force = np.array([np.median(run.samples(sensor + name)[1]) for name in ACCELERATION])
        felt = float(np.linalg.norm(force))
        if not 0.5 < felt / GRAVITY_M_S2 < 1.5:
            yield (f"columns {sensor}accel_*: typically {felt:.3g} m/s2, where gravity is {GRAVITY_M_S2:g}; "
                   "are they in g, or without gravity?")  # fmt: skip
            continue
        for roll in measured(run, "roll_rad"):
            pitch = roll.removesuffix("roll_rad") + "pitch_rad"
            if pitch not in run.columns:
                continue
            phi, theta = (np.median(run.samples(name)[1]) for name in (roll, pitch))
            up = np.array([np.sin(theta), -np.cos(theta) * np.sin(phi), -np.cos(theta) * np.cos(phi)])
            agree = float(force @ up / np.linalg.norm(force))
            if agree < -ALIKE:
                yield f"columns {sensor}accel_*: gravity is upside down against {roll}; does the z axis point up?"
            elif agree < ALIKE:
                yield (f"columns {roll}, {pitch} and {sensor}accel_*: they disagree on where down is; is the order of "
                       "quaternions another than w, x, y, z, or are axes mixed up?")  # fmt: skip


def _clocks(run: Run) -> Iterator[str]:
    """Two channels of one quantity, one later than the other, and whether that grows."""
    pairs, told = [], set()
    for channel in MOTION:
        names = measured(run, channel)
        pairs += [(first, second, False) for k, first in enumerate(names) for second in names[k + 1 :]]
    for angle, rate in zip(ATTITUDE, RATES, strict=True):
        pairs += [(name, other, True) for name in measured(run, angle) for other in measured(run, rate)]
    for first, second, derivative in pairs:
        halves = [_uncommon(run, first, second, derivative, share) for share in ((0.0, 0.5), (0.5, 1.0))]
        known = [half for half in halves if half is not None]
        sensors = first.rpartition(".")[0], second.rpartition(".")[0]
        if len(known) < 2 or sensors in told:
            continue
        best = [min(left, key=lambda delay: left[delay]) for _, left in known]
        late = [steps * step for steps, (step, _) in zip(best, known, strict=True)]
        limit = max(LATE_S, LATE_STEPS * max(_step_s(run, first), _step_s(run, second)))
        better = [
            left[own] < BETTER * left.get(other, 1.0)
            for (_, left), own, other in zip(known, best, best[::-1], strict=True)
        ]
        if abs(late[1] - late[0]) > limit and all(better):
            told.add(sensors)
            yield (f"columns {first} and {second}: {late[0]:+.2g} s apart in the first half, {late[1]:+.2g} s in the "
                   "second; their clocks run at different speeds")  # fmt: skip
        elif min(map(abs, late)) > limit and all(
            left[own] < BETTER * left[0] for (_, left), own in zip(known, best, strict=True)
        ):
            told.add(sensors)
            late_one = first if late[0] > 0.0 else second
            yield f"columns {first} and {second}: {late_one} is {abs(late[0]):.2g} s late; are they from two clocks?"


def _step_s(run: Run, name: str) -> float:
    time_s = run.samples(name)[0]
    return float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0


def _slope(run: Run, first: str, second: str) -> tuple[float, float]:
    """How many times the second the derivative of the first is, and their correlation; 0, 0 where nothing moves."""
    grid = _grid(run, first, second)
    if grid.size < MOVES:
        return 0.0, 0.0
    rate, other = _smooth(_derivative(run, first, grid), grid), _smooth(_turning(run, second, grid), grid)
    power = float(other @ other)
    if not power or not rate.any():
        return 0.0, 0.0
    return float(rate @ other) / power, float(rate @ other / np.sqrt(power * (rate @ rate)))


def _sinking(run: Run, depth: str, heave: str) -> float:
    """Correlation of heave with the depth's derivative, less what surge and sway bring to it at the attitude.

    0 where heave makes little of that: a hull that dives by its pitch tells of the errors of surge and pitch instead.
    """
    grid = _grid(run, depth, heave)
    if grid.size < MOVES:
        return 0.0
    first = {name: next(iter(measured(run, name)), "") for name in ("roll_rad", "pitch_rad", "surge_m_s", "sway_m_s")}
    roll, pitch, surge, sway = (_on(run, name, grid) if name else np.zeros(grid.size) for name in first.values())
    brought = np.cos(pitch) * np.sin(roll) * sway - np.sin(pitch) * surge
    sinks = _derivative(run, depth, grid)
    rate = _smooth(sinks - brought, grid)
    other = _smooth(np.cos(pitch) * np.cos(roll) * _on(run, heave, grid), grid)
    power = np.sqrt(float(rate @ rate) * float(other @ other))
    told = other.std() > PART * _smooth(sinks, grid).std()
    return float(rate @ other) / power if told and power else 0.0


def _uncommon(
    run: Run, first: str, second: str, derivative: bool, share: tuple[float, float]
) -> tuple[float, dict[int, float]] | None:
    """A step [s], and by delay of the first behind the second in steps the share of the variance that is not common.

    In a share of the time; None where they are not alike at any delay.
    """
    grid = _grid(run, first, second)
    grid = grid[int(share[0] * grid.size) : int(share[1] * grid.size)]
    if grid.size < MOVES:
        return None
    a, b = (_derivative(run, first, grid), _turning(run, second, grid)) if derivative else (
        _on(run, first, grid), _on(run, second, grid))  # fmt: skip
    a, b = _smooth(a, grid), _smooth(b, grid)
    power = np.sqrt(float(a @ a) * float(b @ b))
    if not power:
        return None
    size = 2 ** int(np.ceil(np.log2(2 * a.size)))
    both = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)), size) / power
    step = float(grid[1] - grid[0])
    reach = min(int(LONGEST_S / step), a.size // 4)
    shifts = np.arange(-reach, reach + 1)
    if both[shifts].max() < ALIKE:
        return None
    return step, dict(zip(shifts.tolist(), (1.0 - np.maximum(both[shifts], 0.0) ** 2).tolist(), strict=True))


def _grid(run: Run, first: str, second: str) -> FloatArray:
    """Even times where both channels have samples."""
    times = [run.samples(name)[0] for name in (first, second)]
    start, end = max(each[0] for each in times), min(each[-1] for each in times)
    step = max(min(_step_s(run, first), _step_s(run, second)), (end - start) / FINEST)
    return np.arange(start, end, step) if step > 0.0 and end > start else np.empty(0)


def _on(run: Run, name: str, grid: FloatArray) -> FloatArray:
    """A channel at even times; an angle goes on beyond a turn."""
    time_s, values = run.samples(name)
    if name.endswith("_rad"):
        values = np.unwrap(values, period=360.0 if np.abs(values).max() > BEYOND_TURN else TURN)
    return np.interp(grid, time_s, values)


def _derivative(run: Run, name: str, grid: FloatArray) -> FloatArray:
    return np.gradient(_on(run, name, grid), grid)


def _turning(run: Run, name: str, grid: FloatArray) -> FloatArray:
    """How fast the angle of a rate about a body axis grows, by the sensor's other rates and any roll and pitch.

    Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), 2.2.1; what was not measured is nothing.
    """
    sensor, _, channel = name.rpartition(".")
    p, q, r = (_optional(run, [f"{sensor}.{rate}".lstrip(".")], grid) for rate in RATES)
    roll, pitch = (_optional(run, measured(run, angle), grid) for angle in ("roll_rad", "pitch_rad"))
    about = q * np.sin(roll) + r * np.cos(roll)
    turning = (p + about * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll), about / np.cos(pitch))
    return np.asarray(turning[RATES.index(channel)])


def _optional(run: Run, names: list[str], grid: FloatArray) -> FloatArray:
    """The first of the columns that there is; zeros where there is none."""
    found = next((name for name in names if name in run.columns), "")
    return _on(run, found, grid) if found else np.zeros(grid.size)


def _smooth(values: FloatArray, grid: FloatArray) -> FloatArray:
    """Means over SMOOTH_S, less the mean of all; shorter by the width of the window."""
    width = min(max(1, round(SMOOTH_S / float(grid[1] - grid[0]))), values.size)
    sums = np.cumsum(np.concatenate([[0.0], values - values.mean()]))
    return (sums[width:] - sums[:-width]) / width

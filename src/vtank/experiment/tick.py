"""One tick on board, compiled: echo, range reading, filter, surge control, propeller speed, tachometer reading.

The order within a tick at t: the echo that arrives at t is read and filtered; the controller sets the propeller speed
that is held until the next tick; the tachometer is read. f is a Flight, i the run and k the tick.
"""

from __future__ import annotations

import math

from ..compiled import law
from ..effects import (
    clock_skew,
    command_delay,
    sonar_latency,
    sonar_multipath,
    sonar_offset,
    sonar_scale,
    tachometer_bias,
    tachometer_spikes,
)
from ..plant.parameters import indices, slot
from ..plant.surge import STANDOFF, law_product
from .flight import COMMAND, COMMAND_RATE, RANGE, RANGE_RATE, READING, SPEED, SPEED_READING
from .noise import DROPOUT, MULTIPATH, SONAR, SPIKE, TACHOMETER
from .sonar_filter import filter_step

(LATENCY,), (SKEW,), (DELAY,) = (indices(e.EFFECT) for e in (sonar_latency, clock_skew, command_delay))
(SCALE,), (OFFSET,), (BIAS,) = (indices(e.EFFECT) for e in (sonar_scale, sonar_offset, tachometer_bias))
MULTIPATH_P, MULTIPATH_EXTRA = indices(sonar_multipath.EFFECT)
SPIKE_P, SPIKE_SIZE = indices(tachometer_spikes.EFFECT)
RANGE_LAW = slot("law.range")

ROUNDING = 1e-9  # [ticks] instants closer than this to a tick are that tick


@law
def true_range(f, i, t):
    """Range to the wall [m] at any past time t [s]: cubic Hermite between ticks, at rest before the run."""
    h = f.setting[i].period_s
    place = t / h
    k = int(math.floor(place + ROUNDING))
    s = place - k
    if k < 0:
        return f.history[i, RANGE, 0]
    if s < ROUNDING:
        return f.history[i, RANGE, k]
    before, after = f.history[i, RANGE, k], f.history[i, RANGE, k + 1]
    slope, slope_after = h * f.history[i, RANGE_RATE, k], h * f.history[i, RANGE_RATE, k + 1]
    bend = (1.0 - s) * (slope + before - after) - s * (slope_after + before - after)
    return before + s * (after - before) + s * (1.0 - s) * bend


@law
def range_reading(f, i, k, ping, t_echo):
    """What the sonar says at tick k of the echo of t_echo [m]; NaN for no ping, a lost one or one from too far.

    ping: tick whose noise the echo carries.
    """
    p, setting = f.p[i], f.setting[i]
    if k % setting.ping_ticks != 0 or f.noise[i, DROPOUT, ping] < setting.dropout:
        return math.nan
    path = true_range(f, i, t_echo)
    if not math.isfinite(path) or path > setting.max_range_m:
        return math.nan
    if p[RANGE_LAW] != 0.0:
        u = -f.history[i, RANGE_RATE, int(t_echo / setting.period_s + ROUNDING)]
        path += p[RANGE_LAW] * law_product(t_echo, p[STANDOFF] - path, u, 0.0, 0.0, 0.0, path, 0.0, p)
    path = sonar_multipath.reading(path, p[MULTIPATH_P], p[MULTIPATH_EXTRA], f.noise[i, MULTIPATH, ping])
    reading = sonar_offset.reading(sonar_scale.reading(path, p[SCALE]), p[OFFSET]) + f.noise[i, SONAR, ping]
    step = setting.resolution_m
    return math.floor(reading / step + 0.5) * step if step > 0.0 else reading


@law
def filter_range(f, i, reading):
    """The on-board filter's estimate of range and its rates, in place; it starts at rest on the first ping."""
    setting = f.setting[i]
    if not math.isnan(f.estimate[i, 0]):
        filter_step(f.estimate[i], f.covariance[i], reading, setting.period_s, setting.filter_q, setting.filter_r)
    elif not math.isnan(reading):
        f.estimate[i, 0] = reading
        f.estimate[i, 1] = 0.0
        f.estimate[i, 2] = 0.0


@law
def limited(value, limit):
    """Value kept within the limit either way."""
    return min(max(value, -limit), limit)


@law
def surge_control(f, i, k):
    """Propeller speed [rev/s] that the range and its rate call for; still until the first ping.

    Too long a range asks for acceleration ahead, c; n = c/sqrt(beta (|c| + c_0)), the square root of c/beta blunted
    below c_0 = beta n_0^2, since noise would otherwise make the propellers chatter about zero.
    """
    setting = f.setting[i]
    if math.isnan(f.estimate[i, 0]):
        return 0.0
    demand = setting.position_gain * (f.estimate[i, 0] - f.command[i, COMMAND, k])
    demand += setting.speed_gain * (f.estimate[i, 1] - f.command[i, COMMAND_RATE, k])
    blunt = setting.thrust_m_per_rev2 * setting.blunt_rev_s * setting.blunt_rev_s
    size = setting.thrust_m_per_rev2 * (abs(demand) + blunt)
    return demand / math.sqrt(size) if size > 0.0 else 0.0


@law
def speed_reading(f, i, k, n):
    """What the tachometer says [rev/s] of propeller speed n [rev/s]."""
    p = f.p[i]
    biased = tachometer_bias.reading(n, p[BIAS])
    spiked = tachometer_spikes.reading(biased, p[SPIKE_P], p[SPIKE_SIZE], f.noise[i, SPIKE, k])
    return spiked + f.noise[i, TACHOMETER, k]


@law
def tick(f, i, k):
    """One tick: from the true range of tick k, already in the history, to the propeller speed held until the next."""
    setting = f.setting[i]
    reading = range_reading(f, i, k, k, sonar_latency.echo_time(k * setting.period_s, f.p[i, LATENCY]))
    filter_range(f, i, reading)
    wanted = surge_control(f, i, k) if setting.closed_loop else f.command[i, COMMAND, k]
    wanted = limited(wanted, setting.n_limit_rev_s)
    n = limited(wanted + f.trim[i], setting.n_limit_rev_s)
    n_read = speed_reading(f, i, k, n)
    f.trim[i] += setting.governor_per_s * setting.period_s * (wanted - n_read)
    f.record[i, READING, k] = reading
    f.record[i, SPEED, k] = n
    f.record[i, SPEED_READING, k] = n_read


@law
def acting_speed(f, i, t):
    """Propeller speed that acts at time t [s], a little after a switch to be clear of it; still before the run."""
    k = int(math.floor(command_delay.input_time(t, f.p[i, DELAY]) / f.setting[i].period_s + ROUNDING))
    return f.record[i, SPEED, k] if k >= 0 else 0.0


@law
def switch_time(f, i):
    """Time into each tick [s] at which the acting propeller speed changes; 0 without a delay."""
    h = f.setting[i].period_s
    late = f.p[i, DELAY] / h
    late -= math.floor(late + ROUNDING)
    return max(late, 0.0) * h


@law
def stamp(f, i, samples):
    """Write the record of ranges anew as the sonar's own clock stamps them; nothing to do where the clocks agree.

    An echo carries the noise of the tick at which the controller hears it, or the next: were it that of the stamp, a
    controller would answer to noise that a clock running ahead has not recorded yet.
    """
    s = f.p[i, SKEW]
    if s == 0.0:
        return
    for k in range(samples):
        t = clock_skew.echo_time(k * f.setting[i].period_s, s)
        ping = min(max(int(math.ceil(t / f.setting[i].period_s - ROUNDING)), 0), f.noise.shape[2] - 1)
        f.record[i, READING, k] = range_reading(f, i, k, ping, sonar_latency.echo_time(t, f.p[i, LATENCY]))

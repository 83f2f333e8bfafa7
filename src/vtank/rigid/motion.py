"""The equations of motion of a whole vehicle, compiled once for all vehicles, whose numbers come as a vector.

    M dnu/dt = thrust + fins + drag(nu_r) + restoring + tether - C_RB(nu) nu - C_A(nu_r) nu_r + M_A d[U]/dt + M push

over the axes that move; those whose motion is known keep it, and what they carry with them is taken off the right side.
Attitude is roll, pitch and heading (Euler angles, Fossen (2011), section 2.2), place north, east, down.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import law, lean, term
from ..effects.wall_proximity import NEAREST_M, growth
from ..plant.sixdof import add, at, coriolis, cross, multiply, subtract
from .flow import pushed
from .layout import (
    ASLANT,
    ASYMMETRY,
    AXIS,
    BUOYANCY,
    BUOYED,
    CENTRE,
    CORIOLIS,
    COUPLE,
    COUPLING,
    CROSSFLOW,
    CURRENT,
    DIRECTION,
    DRAG,
    DRIFT,
    FIN,
    FORCE,
    FRICTION,
    GONE,
    HELD_AT,
    HOLDS,
    HULL,
    INDUCED,
    LEANS,
    LEFT_OUT,
    LIFT,
    LINEAR,
    LOSS,
    NOSE,
    OFFSET,
    PITCHED,
    PLACE,
    PRESSURE,
    PULL,
    QUADRATIC,
    RATIO,
    RECOVERY,
    SEAT,
    SPRING,
    STALL,
    SUCTION,
    SWELL,
    SWELL_AHEAD,
    SWELL_RATE,
    TAIL,
    TETHER,
    THRUSTER,
    TRIM,
    WAKE,
    WALL_DRAG,
    WALL_MASS,
    WATERLINE,
    WEIGHT,
    YAWED,
    G,
)  # fmt: skip

SQUARE = 0.2  # cosine of the heading to a wall, beyond which it is not ahead; a choice
STRIPS = ((-0.90618, 0.236927), (-0.538469, 0.478629), (0.0, 0.568889), (0.538469, 0.478629), (0.90618, 0.236927))


@term
def rotation(roll, pitch, heading):
    """Body to earth axes, row by row, 9 numbers."""
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    ch, sh = math.cos(heading), math.sin(heading)
    return (
        ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr,
        sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr,
        -sp, cp * sr, cp * cr,
    )  # fmt: skip


@term
def turned(R, v):
    """R v."""
    return (
        R[0] * v[0] + R[1] * v[1] + R[2] * v[2],
        R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
        R[6] * v[0] + R[7] * v[1] + R[8] * v[2],
    )


@term
def back(R, v):
    """R' v."""
    return (
        R[0] * v[0] + R[3] * v[1] + R[6] * v[2],
        R[1] * v[0] + R[4] * v[1] + R[7] * v[2],
        R[2] * v[0] + R[5] * v[1] + R[8] * v[2],
    )


@term
def triple(p, i):
    """Three numbers of the vector from slot i on."""
    return p[i], p[i + 1], p[i + 2]


@term
def resisted(p, i, speed):
    """Drag of axis i at a speed through the water, with what its asymmetry adds, along the motion."""
    return -(p[LINEAR + i] + p[QUADRATIC + i] * (abs(speed) + p[ASYMMETRY + i] * speed)) * speed


@lean
def fin_force(p, i, angle, through):
    """Lift and drag of the fin whose block starts at slot i, at an angle [rad], in body axes [N].

    Lift is square to the flow across the fin's axis, linear up to the stall and falling as sin 2 alpha beyond, but for
    the share that it holds, at the drag that it has at the stall. Without suction at the leading edge the force is
    square to the fin itself (a plate); with all of it, lift costs no drag. So far the share by which it leans; the rest
    is as simple simulators have it where the flow comes from ahead: square to the hull, up to the stall, and with a
    power of the cosine of the flow's angle, 0 by the square of all of the flow, 2 by that of the flow ahead; a share of
    that angle is the ratio of both instead.
    """
    axis, ahead = triple(p, i + AXIS), (1.0, 0.0, 0.0)
    side = cross(axis, ahead)
    along = through[0]
    across = through[0] * side[0] + through[1] * side[1] + through[2] * side[2]
    speed = math.sqrt(along * along + across * across)
    turned, inflow = angle + p[i + OFFSET], math.atan2(across, along)
    beyond = turned - inflow
    alpha = math.atan2(math.sin(beyond), math.cos(beyond))
    stall = p[i + STALL]
    if abs(alpha) <= stall:
        lift = p[i + LIFT] * alpha
        cost = (1.0 - p[i + SUCTION]) * lift * math.tan(alpha)
    else:
        most, holds = p[i + LIFT] * math.copysign(stall, alpha), p[i + HOLDS]
        lift = most * (holds + (1.0 - holds) * math.sin(2.0 * abs(alpha)) / math.sin(2.0 * stall))
        cost = (1.0 - holds) * 2.0 * p[i + LIFT] * stall * math.sin(alpha) ** 2 / math.sin(2.0 * stall)
        cost = cost + holds * (1.0 - p[i + SUCTION]) * abs(most) * math.tan(stall)
    pressure = (1.0 - p[i + GONE]) * p[i + PRESSURE] * speed  # on what is left of its area
    leans = p[i + LEANS] if along > 0.0 else 1.0
    X = pressure * (leans * (-lift * across - cost * along) - p[i + DRAG] * along)
    Y = pressure * (leans * (lift * along - cost * across) - p[i + DRAG] * across)
    if leans != 1.0:
        simple = turned - inflow - p[i + RATIO] * (across / along - inflow)
        held = p[i + LIFT] * min(max(simple, -stall), stall)
        Y = Y + pressure * (1.0 - leans) * held * speed * math.pow(along / speed, p[i + ASLANT])
    X = X - p[i + INDUCED] * along * along * math.sin(angle) ** 2
    return X, Y * side[1], Y * side[2]


@term
def scaled(f, w):
    """A wrench times a number."""
    return f * w[0], f * w[1], f * w[2], f * w[3], f * w[4], f * w[5]


@term
def axis_force(i, t, x, speed, away, hull):
    """Force along or about axis i [N, N m]: drag at a speed through the water, friction, spring, wave, constant.

    away: displacement since the start along or about the axis.
    """
    p = hull.p
    speed = speed - p[DRIFT + i] - x[12 + i]
    force = p[FORCE + i] - p[SPRING + i] * away
    if i < 3 and (p[SWELL + i] != 0.0 or p[SWELL_AHEAD + i] != 0.0):
        phase = p[SWELL_RATE + i] * t
        sine, cosine = math.sin(phase), math.cos(phase)
        speed -= p[SWELL + i] * sine + p[SWELL_AHEAD + i] * cosine
        carried = p[SWELL_RATE + i] * (p[SWELL + i] * cosine - p[SWELL_AHEAD + i] * sine)
        force += (hull.body[i, i] + hull.water[i, i]) * carried
    if p[FRICTION + i] != 0.0:
        force -= p[FRICTION + i] * math.tanh(x[6 + i] / hull.creep[i])
    return force + resisted(p, i, speed)


@law
def gears(p, thrusters):
    """Wrench of each thruster at 1 N, (K, 6), in the direction in which it pushes."""
    out = np.empty((thrusters, 6))
    for k in range(thrusters):
        i = HULL + THRUSTER * k
        d, r, c = triple(p, i + DIRECTION), triple(p, i + PLACE), triple(p, i + COUPLE)
        if p[i + YAWED] != 0.0 or p[i + PITCHED] != 0.0:
            d = turned(rotation(0.0, p[i + PITCHED], 0.0), turned(rotation(0.0, 0.0, p[i + YAWED]), d))
        m = cross(r, d)
        out[k, 0], out[k, 1], out[k, 2] = d
        out[k, 3], out[k, 4], out[k, 5] = m[0] + c[0], m[1] + c[1], m[2] + c[2]
    return out


def lifts(p, first, fins):
    """Wrench of each fin at 1 rad in 1 m/s from ahead, (F, 6); first: slot of the first one."""
    of = p[first:][: FIN * fins].reshape(fins, FIN)
    side = np.cross(of[:, AXIS : AXIS + 3], (1.0, 0.0, 0.0))
    force = side * (of[:, PRESSURE] * of[:, LIFT])[:, None]
    return np.hstack((force, np.cross(of[:, SEAT : SEAT + 3], force)))


@term
def lost(nu_r, asked, hull):
    """What the speed of advance takes off the thrust: loss times input times the flow along each thruster."""
    total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for k in range(hull.counts[0]):
        loss = hull.p[HULL + THRUSTER * k + LOSS]
        if loss != 0.0:
            g = hull.gears[k]
            ahead = g[0] * nu_r[0] + g[1] * nu_r[1] + g[2] * nu_r[2] + g[3] * nu_r[3] + g[4] * nu_r[4] + g[5] * nu_r[5]
            total = add(total, scaled(-loss * asked[k] * ahead, (g[0], g[1], g[2], g[3], g[4], g[5])))
    return total


@term
def held_by(x, R, hull):
    """Wrench of weight, buoyancy, a waterline at the origin, a trim weight, a tether with a spring about the start."""
    p, down = hull.p, back(R, (0.0, 0.0, 1.0))
    W, B, rise = p[WEIGHT], p[BUOYANCY], -p[WATERLINE] * x[2]
    total = at((W * down[0], W * down[1], W * down[2]), triple(p, CENTRE))
    total = add(total, (rise * down[0], rise * down[1], rise * down[2], 0.0, 0.0, 0.0))
    total = subtract(total, at((B * down[0], B * down[1], B * down[2]), triple(p, BUOYED)))
    if p[TRIM] != 0.0:
        W = G * p[TRIM]
        total = add(total, at((W * down[0], W * down[1], W * down[2]), triple(p, TRIM + 1)))
    k = p[TETHER]
    if k != 0.0 or p[PULL] != 0.0 or p[PULL + 1] != 0.0 or p[PULL + 2] != 0.0:
        r, home = triple(p, HELD_AT), hull.home
        now, then = turned(R, r), turned(rotation(0.0, 0.0, home[3]), r)
        F = back(R, (
            p[PULL] - k * (x[0] + now[0] - home[0] - then[0]),
            p[PULL + 1] - k * (x[1] + now[1] - home[1] - then[1]),
            p[PULL + 2] - k * (x[2] + now[2] - home[2] - then[2]),
        ))  # fmt: skip
        total = add(total, at(F, r))
    return total


@term
def turning(nu, nu_r, hull):
    """What turning adds: -C_RB(nu) nu - C_A(nu_r) nu_r, and coupling terms and strips of the hull besides."""
    p = hull.p
    total = add(scaled(-p[CORIOLIS], coriolis(hull.body, nu)), scaled(p[LEFT_OUT] - 1.0, coriolis(hull.water, nu_r)))
    c = (p[COUPLING], p[COUPLING + 1], p[COUPLING + 2], p[COUPLING + 3], p[COUPLING + 4])
    if c[0] != 0.0 or c[1] != 0.0 or c[2] != 0.0 or c[3] != 0.0 or c[4] != 0.0:
        total = add(total, (c[0] * nu_r[1] * nu[5], -c[1] * nu_r[0] * nu[5], c[3] * nu_r[0] * nu[4],
                            0.0, c[4] * nu_r[0] * nu_r[2], -c[2] * nu_r[0] * nu_r[1]))  # fmt: skip
    if p[CROSSFLOW] != 0.0 or p[CROSSFLOW + 1] != 0.0:
        middle, half = 0.5 * (p[NOSE] + p[TAIL]), 0.5 * (p[NOSE] - p[TAIL])
        for place, share in STRIPS:
            lever = middle + half * place
            side, down = nu_r[1] + lever * nu[5], nu_r[2] - lever * nu[4]
            speed = half * share * math.sqrt(side * side + down * down)
            Y, Z = -p[CROSSFLOW] * speed * side, -p[CROSSFLOW + 1] * speed * down
            total = add(total, (0.0, Y, Z, 0.0, -lever * Z, lever * Y))
    return total


@term
def gap(x, R, hull):
    """Distance along the hull from the sonar to the wall ahead [m], which is square to the heading `facing`."""
    north, east = math.cos(hull.facing), math.sin(hull.facing)
    left = hull.wall - (x[0] - hull.home[0]) * north - (x[1] - hull.home[1]) * east
    return left / max(R[0] * north + R[3] * east, SQUARE) - hull.sonar_m


@term
def grown(x, R, hull):
    """Mass by which the wall ahead makes surge heavier [kg]."""
    return hull.p[WALL_MASS] * growth(gap(x, R, hull)) * (hull.body[0, 0] + hull.water[0, 0])


@term
def near_wall(x, R, nu_r, hull):
    """What the wall ahead adds: drag, the slope of the mass that it adds, and Coriolis terms of that mass."""
    p, far = hull.p, gap(x, R, hull)
    mass = grown(x, R, hull)
    drag = p[WALL_DRAG] * growth(far) * p[QUADRATIC] * abs(nu_r[0]) * nu_r[0]
    P = mass * nu_r[0]
    return (-drag - 1.5 * mass / max(far, NEAREST_M) * x[6] * x[6], -x[11] * P, x[10] * P,
            0.0, -nu_r[2] * P, nu_r[1] * P)  # fmt: skip


@term
def wrench(t, x, thrust, asked, fins, hull, room):
    """All forces on the right side [N, N m] at the state x, 6 numbers.

    thrust: wrench of all thrusters, before what speed takes off; asked: sizes of their inputs; fins: angles [rad];
    room: scratch, (18,).
    """
    p, R = hull.p, rotation(x[3], x[4], x[5])
    nu = (x[6], x[7], x[8], x[9], x[10], x[11])
    U = (0.0, 0.0, 0.0)
    if p[CURRENT] != 0.0 or p[CURRENT + 1] != 0.0 or p[CURRENT + 2] != 0.0:
        U = back(R, triple(p, CURRENT))
    nu_r = (x[6] - U[0], x[7] - U[1], x[8] - U[2], x[9], x[10], x[11])
    home = hull.home
    off = back(R, (x[0] - home[0], x[1] - home[1], x[2] - home[2]))
    total = (
        axis_force(0, t, x, nu_r[0], off[0], hull), axis_force(1, t, x, nu_r[1], off[1], hull),
        axis_force(2, t, x, nu_r[2], off[2], hull), axis_force(3, t, x, nu_r[3], x[3], hull),
        axis_force(4, t, x, nu_r[4], x[4], hull), axis_force(5, t, x, nu_r[5], x[5] - home[3], hull),
    )  # fmt: skip
    total = add(total, add(turning(nu, nu_r, hull), held_by(x, R, hull)))
    if U[0] != 0.0 or U[1] != 0.0 or U[2] != 0.0:
        rate = cross(U, (x[9], x[10], x[11]))  # d U/dt in the turning axes, -w x U
        total = add(total, multiply(hull.water, (rate[0], rate[1], rate[2], 0.0, 0.0, 0.0)))
    total = add(total, (thrust[0], thrust[1], thrust[2], thrust[3], thrust[4], thrust[5]))
    if p[WALL_DRAG] != 0.0 or p[WALL_MASS] != 0.0:
        total = add(total, near_wall(x, R, nu_r, hull))
    if hull.losing:
        total = add(total, lost(nu_r, asked, hull))
    if hull.flow.terms.shape[0]:
        total = add(total, pushed(nu_r, hull.flow, room))
    for k in range(hull.counts[1]):
        i = HULL + THRUSTER * hull.counts[0] + FIN * k
        r = triple(p, i + SEAT)
        v = cross((x[9], x[10], x[11]), r)
        total = add(total, at(fin_force(p, i, fins[k], (nu_r[0] + v[0], nu_r[1] + v[1], nu_r[2] + v[2])), r))
    return total


@lean
def rates(t, x, thrust, asked, fins, push, known, hull, out):
    """d/dt of place, attitude, velocity and wakes into `out`, shape (18,).

    push: unmodelled acceleration of each axis, and known: that of axes whose motion is known, shapes (6,).
    """
    p, R = hull.p, rotation(x[3], x[4], x[5])
    carried = (known[0], known[1], known[2], known[3], known[4], known[5])
    left = subtract(wrench(t, x, thrust, asked, fins, hull, out), multiply(hull.body, carried))
    out[0], out[1], out[2] = turned(R, (x[6], x[7], x[8]))
    sr, cr, cp = math.sin(x[3]), math.cos(x[3]), math.cos(x[4])
    cp = math.copysign(max(abs(cp), 1e-6), cp)
    turn = sr * x[10] + cr * x[11]
    out[3] = x[9] + turn * math.sin(x[4]) / cp
    out[4] = cr * x[10] - sr * x[11]
    out[5] = turn / cp
    nu = multiply(hull.inverse, subtract(left, multiply(hull.water, carried)))
    if p[WALL_MASS] != 0.0:  # the inverse of M and a mass more in surge (Sherman, Morrison, Ann. Math. Stat. 21, 1950)
        mass, across = grown(x, R, hull), hull.inverse[0]
        slower = -mass * (nu[0] + carried[0]) / (1.0 + mass * across[0])
        nu = add(nu, scaled(slower, (across[0], across[1], across[2], across[3], across[4], across[5])))
    for i in range(6):
        out[6 + i] = nu[i] + carried[i] + push[i]
        out[12 + i] = (p[WAKE + i] * x[6 + i] - x[12 + i]) / p[RECOVERY + i] if p[WAKE + i] != 0.0 else 0.0


@lean
def advance(t, x, h, drive, i, begin, end, push, hull, k, y):
    """One Runge-Kutta step of h [s] from time t [s] under the drive of step i, in place on x, (18,).

    begin, end: where on the way of what thrusters and fins change by, -1 to 1 through the whole of step i, it begins
    and ends; 0 for both stays amid. k, (5, 18), and y, (18,), are scratch.
    """
    thrust, asked, fins, known = k[4], drive.asked[i], drive.fins[i], drive.known[i, 9:]
    angles = k[4, 6 : 6 + fins.size]  # of more fins than there is room for, none on the way
    for a in range(18):
        y[a] = x[a]
    for stage in range(4):
        g = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
        if stage > 0:
            for a in range(18):
                y[a] = x[a] + g * k[stage - 1, a]
        change = begin + (end - begin) * g / h
        for a in range(6):
            thrust[a] = drive.thrust[i, a] + change * drive.swing[i, a]
        if angles.size == drive.fins.shape[1]:
            fins = angles
            for a in range(fins.size):
                fins[a] = drive.fins[i, a] + change * drive.turn[i, a]
        rates(t + g, y, thrust, asked, fins, push, known, hull, k[stage])
    for i in range(18):
        x[i] += h / 6.0 * (k[0, i] + 2.0 * (k[1, i] + k[2, i]) + k[3, i])

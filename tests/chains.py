"""Jointed bodies in water by equations of their own, for the tests of `vtank.water`: none of MuJoCo's, none of vtank's.

Every body's velocity nu = (v, w) of its origin, in its own axes, follows from its parent's; with the joint's axis s:

    hinge, ball: w' = E w + s q', v' = E (v + w x r)        slide: w' = E w, v' = E (v + w x (r + s q)) + s q'

E takes the parent's axes to the body's. The joints' accelerations are those for which no virtual motion finds work in

    M_RB dnu/dt + C_RB(nu) nu + M_A d nu_r/dt + C_A(nu_r) nu_r - forces      (Fossen 2011, eq. 6.42 with 3.56 and 6.43)

summed over all bodies (d'Alembert); nu_r = nu - E_world [U; 0].
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from vtank.water import Body

Array = NDArray[np.float64]
GAUSS = np.polynomial.legendre.leggauss(8)


def skew(a: Array) -> Array:
    """Matrix of the cross product a x."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


@dataclass
class Link:
    """A body: kind free, hinge, slide, ball or fixed; place [m] and turn (child to parent) in the parent at q = 0."""

    name: str
    parent: int  # index of a link, -1 for the world
    kind: str
    place: Array
    turn: Array
    axis: Array
    mass: float
    centre: Array
    inertia: Array
    water: Body | None = None

    @property
    def freedoms(self) -> int:
        return {"free": 6, "ball": 3, "hinge": 1, "slide": 1, "fixed": 0}[self.kind]

    @property
    def rigid(self) -> Array:
        """M_RB about the origin (Fossen 2011, eq. 3.44)."""
        s = skew(self.centre)
        return np.block([[self.mass * np.eye(3), -self.mass * s], [self.mass * s, self.inertia - self.mass * s @ s]])


def kirchhoff(mass: Array, nu: Array) -> Array:
    """C(nu) nu of a symmetric mass matrix (Fossen 2011, theorem 3.2)."""
    p, h = (mass @ nu)[:3], (mass @ nu)[3:]
    v, w = nu[:3], nu[3:]
    return np.concatenate([np.cross(w, p), np.cross(w, h) + np.cross(v, p)])


def strips(hull: Array, nu: Array, exact: bool = False) -> Array:
    """Cross-flow drag (Healey and Lienard 1993) by Gauss's eight strips; exact: by ten thousand alike."""
    tail, nose, sway, heave = hull
    x, dx = tail + 0.5 * (GAUSS[0] + 1.0) * (nose - tail), 0.5 * GAUSS[1] * (nose - tail)
    if exact:
        edges = np.linspace(tail, nose, 10001)
        x, dx = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    v, w = nu[1] + x * nu[5], nu[2] - x * nu[4]
    speed = np.hypot(v, w)
    across, down = -sway * speed * v * dx, -heave * speed * w * dx
    return np.array([0.0, across.sum(), down.sum(), 0.0, -(x * down).sum(), (x * across).sum()])


def force(link: Link, turn: Array, nu: Array, gravity: Array, flow: Array, rate: Array) -> Array:
    """Weight, buoyancy in accelerating water, drag: wrench about the origin, body axes. turn: body to world."""
    weight = link.mass * turn.T @ gravity
    total = np.concatenate([weight, np.cross(link.centre, weight)])
    if link.water is None:
        return total
    water = link.water
    lift = water.displaced_kg * turn.T @ (rate - gravity)
    total += np.concatenate([lift, np.cross(water.centre_of_buoyancy_m, lift)])
    axes, at = water.drag_axes, water.centre_of_drag_m
    nu_r = nu - np.concatenate([turn.T @ flow, np.zeros(3)])
    there = np.concatenate([axes.T @ (nu_r[:3] + np.cross(nu_r[3:], at)), axes.T @ nu_r[3:]])
    drag = -water.drag_linear * there - water.drag_quadratic * np.abs(there) * there
    drag = drag + strips(water.cross_flow, there)
    push = axes @ drag[:3]
    return total + np.concatenate([push, np.cross(at, push) + axes @ drag[3:]])


def accelerations(
    links: list[Link], qpos: Array, qvel: Array, gravity: Array, flow: Array, rate: Array, tau: Array
) -> Array:
    """qacc, shape (nv,), of the links in order, positions and velocities as MuJoCo counts them; tau: on the joints."""
    nv = qvel.size
    work, known = np.zeros((nv, nv)), np.zeros(nv)
    # of each link: rotation to world, velocity, its derivative by qvel, and the rate that is left when qacc is 0
    done: list[tuple[Array, Array, Array, Array]] = []
    position = speed = 0
    for link in links:
        own = slice(speed, speed + link.freedoms)
        q, dq = qpos[position:], qvel[own]
        jacobian = np.zeros((6, nv))
        if link.kind == "free":
            turn = Rotation.from_quat(q[[4, 5, 6, 3]]).as_matrix()
            nu = np.concatenate([turn.T @ dq[:3], dq[3:]])
            jacobian[:, own] = np.block([[turn.T, np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)]])
            rest = np.concatenate([-np.cross(nu[3:], nu[:3]), np.zeros(3)])
        else:
            base = done[link.parent] if link.parent >= 0 else (np.eye(3), np.zeros(6), np.zeros((6, nv)), np.zeros(6))
            turn, nu, jacobian, rest = step(link, base, q, dq, own)
        position += {"free": 7, "ball": 4, "hinge": 1, "slide": 1, "fixed": 0}[link.kind]
        speed += link.freedoms
        done.append((turn, nu, jacobian, rest))
        added = np.zeros((6, 6)) if link.water is None else link.water.added_mass
        relative = nu - np.concatenate([turn.T @ flow, np.zeros(3)])
        carried = np.concatenate([turn.T @ rate - np.cross(nu[3:], turn.T @ flow), np.zeros(3)])  # dU/dt, body axes
        left = link.rigid @ rest + kirchhoff(link.rigid, nu) + added @ (rest - carried) + kirchhoff(added, relative)
        work += jacobian.T @ (link.rigid + added) @ jacobian
        known += jacobian.T @ (force(link, turn, nu, gravity, flow, rate) - left)
    return np.linalg.solve(work, known + tau)


def step(link: Link, base, q: Array, dq: Array, own: slice):
    """Rotation, velocity, derivative and rest of a link from those of its parent."""
    turn_p, nu_p, jacobian_p, rest_p = base
    turning = {
        "hinge": lambda: Rotation.from_rotvec(link.axis * q[0]),
        "ball": lambda: Rotation.from_quat(q[[1, 2, 3, 0]]),
    }
    relative = link.turn @ turning[link.kind]().as_matrix() if link.kind in turning else link.turn
    e, place = relative.T, link.place
    spin, sliding = np.zeros(3), np.zeros(3)
    axes = {"hinge": link.axis[:, None], "ball": np.eye(3), "slide": link.axis[:, None]}.get(
        link.kind, np.zeros((3, 0))
    )
    if link.kind == "slide":
        place, sliding = place + link.turn @ link.axis * q[0], axes @ dq
    else:
        spin = axes @ dq
    carry = np.block([[e, -e @ skew(place)], [np.zeros((3, 3)), e]])
    carried = carry @ nu_p
    jacobian = carry @ jacobian_p
    jacobian[: 3 if link.kind == "slide" else 6, own][-3:] += axes
    nu = carried + np.concatenate([sliding, spin])
    rest = carry @ rest_p + np.concatenate(
        [np.cross(carried[:3], spin) + np.cross(e @ nu_p[3:], sliding), np.cross(carried[3:], spin)]
    )
    return turn_p @ relative, nu, jacobian, rest


def random_water(rng: np.random.Generator, mass: float, hull: bool) -> Body:
    """Hydrodynamics of the size of a body's own mass, every coupling at work."""
    mix, scale = rng.normal(size=(6, 6)), np.sqrt(mass * np.array([0.4, 1.0, 1.4, 0.05, 0.1, 0.1]))
    added = scale[:, None] * (0.5 * np.eye(6) + 0.1 * mix @ mix.T) * scale
    return Body(
        added_mass=added,
        displaced_kg=mass * rng.uniform(0.7, 1.3),
        centre_of_buoyancy_m=0.1 * rng.normal(size=3),
        drag_linear=mass * rng.uniform(0.0, 0.5, 6),
        drag_quadratic=mass * rng.uniform(0.0, 2.0, 6),
        cross_flow=(-0.6, 0.8, 3.0, 5.0) if hull else (0.0,) * 4,
        centre_of_drag_m=0.1 * rng.normal(size=3) if hull else np.zeros(3),
        drag_axes=Rotation.random(random_state=3).as_matrix() if hull else np.eye(3),
    )


KINDS = (
    ("vehicle", -1, "free"),
    ("boom", 0, "fixed"),
    ("shoulder", 1, "hinge"),
    ("elbow", 2, "slide"),
    ("hand", 3, "ball"),
    ("fin", 0, "hinge"),
    ("buoy", -1, "free"),
    ("post", -1, "hinge"),
    ("flag", 7, "hinge"),
)
DRY = ("elbow",)


def random_links(seed: int = 1) -> list[Link]:
    """A vehicle with an arm and a fin, a ball adrift, and a chain that is fixed to the bottom; all but one body wet."""
    rng, links = np.random.default_rng(seed), []
    for number, (name, parent, kind) in enumerate(KINDS):
        mass, mix, axis = rng.uniform(2.0, 20.0), rng.normal(size=(3, 3)), rng.normal(size=3)
        plain = name == "buoy"  # inertia along its own axes, which MuJoCo has a simpler mass matrix for
        link = Link(
            name=name,
            parent=parent,
            kind=kind,
            place=rng.normal(size=3) * (0.3 if parent >= 0 else 3.0),
            turn=Rotation.random(random_state=number).as_matrix(),
            axis=axis / np.linalg.norm(axis),
            mass=mass,
            centre=np.zeros(3) if plain else 0.1 * rng.normal(size=3),
            inertia=mass * (np.diag([0.1, 0.12, 0.15]) if plain else 0.1 * np.eye(3) + 0.005 * mix @ mix.T),
        )
        link.water = None if name in DRY else random_water(rng, mass, number % 2 == 0)
        links.append(link)
    return links


def specification(links: list[Link]) -> mujoco.MjSpec:
    """The same bodies for MuJoCo, dry."""
    spec = mujoco.MjSpec()
    bodies = [spec.worldbody]
    types = {
        "free": mujoco.mjtJoint.mjJNT_FREE,
        "hinge": mujoco.mjtJoint.mjJNT_HINGE,
        "slide": mujoco.mjtJoint.mjJNT_SLIDE,
        "ball": mujoco.mjtJoint.mjJNT_BALL,
    }
    for link in links:
        i = link.inertia
        body = bodies[link.parent + 1].add_body(
            name=link.name,
            pos=link.place,
            quat=Rotation.from_matrix(link.turn).as_quat()[[3, 0, 1, 2]],
            explicitinertial=True,
            mass=link.mass,
            ipos=link.centre,
            fullinertia=[i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]],
        )
        if link.kind in types:
            body.add_joint(type=types[link.kind], axis=link.axis, align=mujoco.mjtAlignFree.mjALIGNFREE_FALSE)
        bodies.append(body)
    return spec

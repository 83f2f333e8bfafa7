"""The pilot of a whole vehicle: orders and readings in, inputs of thrusters and fins out, at every tick.

It knows the vehicle file and what the instruments read, as a pilot on board would, and nothing of what is true.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.actuators import Fin, Thruster
from ..plant.vehicle import AXES, Vehicle
from ..record import TIME
from ..units import G_M_S2
from .allocation import SLOWEST_M_S, Allocation
from .loops import Loop
from .obeying import obeyed
from .orders import Order
from .sensing import PLACE, SPEED, Sensing

Array = NDArray[np.float64]
SHORT = 0.01  # share of its largest force by which a thruster may miss what is wanted in open loop; a choice
HURRIED_RAD = 0.3  # [rad] that latency, lag and tick may cost a loop at its bandwidth; a choice
DIVING = 0.3  # bandwidth of a depth over that of the pitch by which it is held; a choice
LOOPS, FORWARD = ("place", "speed"), ("surge", "speed")
FIRST_TO_LAST = ([3, 4], [2], [5], [0, 1])  # numbers of AXES, as thrusters and fins are given to them; a choice
STEEPEST_RAD = 0.35  # [rad] pitch that is ordered for the sake of depth; a choice


class Pilot:
    """Flies a vehicle by orders; to be called at every tick with the time and the readings.

    Where the parts cannot make all that is ordered, attitude and depth come before heading, and heading before what
    moves the vehicle about, which is made smaller, and its integrals wait; in open loop that is refused.

    Attributes:
        orders: those that are obeyed. left: axes of those that are not.
        ticks: so far. cut: of these, by axis, how many asked more than the parts make.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        orders: Sequence[Order],
        duration_s: float,
        period_s: float,
        depth_m: float | None = None,
    ) -> None:
        """depth_m: at the start (default: the MJCF's). InputError names the order that cannot be obeyed, and why."""
        from ..tank.model import centre_of_gravity, vehicle_body  # MuJoCo takes a while to load
        from ..tank.whole import load_whole

        self.model = load_whole(vehicle, depth_m=depth_m).model
        body = vehicle_body(self.model)
        self.vehicle, self.duration_s, self.period_s = vehicle, duration_s, period_s
        self.sensing = Sensing(vehicle, -float(self.model.body_pos[body, 2]))
        self.orders = obeyed(vehicle, self.model, orders, self.sensing, duration_s)
        kept = {axis for order in self.orders for axis in (order.target, order.axis)}
        self.left = tuple(order.target for order in orders if order.target not in kept)
        axes = sorted({order.axis for order in self.orders if order.axis in AXES}, key=AXES.index)
        self.allocation = Allocation(vehicle, self.model, axes)
        for order in self.orders:
            self.sensing.watch(order)
            self._refuse_above(order, -float(self.model.body_pos[body, 2]))
        self._refuse_beyond()
        height = float(centre_of_gravity(self.model, body)[2])
        rights = vehicle.mass_kg * G_M_S2 * height - vehicle.buoyancy_N * float(vehicle.centre_of_buoyancy_m[2])
        self._loops = {i: self._loop(order, rights) for i, order in enumerate(self.orders) if order.loop in LOOPS}
        self._sides = dict.fromkeys((order.target for order in self.orders if order.turns_at_rad), 1.0)
        self._wanted = np.zeros(6)
        self._surge = 0.0
        self.ticks, self.cut = 0, Counter[str]()

    @property
    def _ticks(self) -> Array:
        """Times of the commands, (T,) [s]."""
        return self.period_s * np.arange(int(np.floor(self.duration_s / self.period_s + 1e-9)) + 1, dtype=np.float64)

    @property
    def closed(self) -> bool:
        """Whether it needs readings: then it is called, else its table is flown."""
        return any(order.closed for order in self.orders)

    def __call__(self, time_s: float, readings: Mapping[str, float]) -> dict[str, float]:
        """Inputs by column."""
        efforts, direct = self._efforts(time_s, readings)
        return {key: float(value[0]) for key, value in self.allocation.inputs(efforts[None]).items()} | direct

    def table(self) -> dict[str, Array]:
        """Inputs by column at every tick, (T,), in open loop. InputError where thrusters cannot make what is asked."""
        ticks = self._ticks
        rows = [self._efforts(float(at), {}) for at in ticks]
        efforts = np.array([row for row, _ in rows])
        for part, forces in zip(self.allocation.parts, efforts.T, strict=True):
            self._refuse_short(part, forces)
        direct = {key: np.array([row[key] for _, row in rows]) for key in rows[0][1]}
        return {TIME: ticks} | direct | self.allocation.inputs(efforts)

    def _efforts(self, time_s: float, readings: Mapping[str, float]) -> tuple[Array, dict[str, float]]:
        """Forces of thrusters [N] and angles of fins [rad], (parts,), and inputs that are ordered by themselves."""
        seen = self.sensing.look(readings) if self.closed else {}
        at = np.array([time_s])
        signals = [[float(x[0]) for x in order.signal.command(at, self.duration_s)] for order in self.orders]
        places = {o.target: value for o, (value, _) in zip(self.orders, signals, strict=True) if o.loop == "place"}
        surge = [value for o, (value, _) in zip(self.orders, signals, strict=True) if (o.target, o.loop) == FORWARD]
        self._surge = seen.get("surge_m_s", surge[0] if surge else 0.0)
        matrix, wanted = self.allocation.matrix(self._surge), np.zeros(6)
        direct: dict[str, float] = {}
        errors: dict[int, float] = {}
        for i, (order, (value, rate)) in enumerate(zip(self.orders, signals, strict=True)):
            if order.target not in AXES:
                direct[order.target] = direct.get(order.target, 0.0) + self._side(order, seen) * value
            elif i in self._loops:
                force, errors[i] = self._held(i, (value, rate), seen, places)
                wanted[AXES.index(order.axis)] += force
            else:
                most = self.allocation.largest(order.axis, self._surge) if order.loop == "share" else 1.0
                wanted[AXES.index(order.axis)] += self._side(order, seen) * value * most
        efforts = matrix @ wanted
        self.ticks += 1
        short: list[int] = []
        if self.closed and self.allocation.overload(efforts) > 1.0:
            efforts = np.zeros_like(efforts)
            for axes in FIRST_TO_LAST:
                share = self.allocation.room(efforts, more := matrix[:, axes] @ wanted[axes])
                efforts, wanted[axes] = efforts + share * more, share * wanted[axes]
                short += axes if share < 1.0 else []
        for i, error in errors.items():
            if AXES.index(self.orders[i].axis) not in short:
                self._loops[i].integral += error * self.period_s
        self.cut.update(order.target for order in self.orders if order.axis in [AXES[axis] for axis in short])
        self._wanted = wanted
        return efforts, direct

    def _held(
        self, number: int, signal: Sequence[float], seen: Mapping[str, float], places: Mapping[str, float]
    ) -> tuple[float, float]:
        """Force of a loop, and the error that it integrates; without a reading only what the order needs by itself."""
        order, loop, (value, rate) = self.orders[number], self._loops[number], signal
        if order.loop == "speed":
            error = seen[SPEED[order.target]] - value if SPEED[order.target] in seen else 0.0
            return loop.force(error, 0.0, self._surge) + loop.ahead(0.0, value), error
        found = self.sensing.error(order.target, seen, places)
        if order.through and found is not None:
            deep = DIVING * loop.bandwidth_rad_s * found / max(self._surge, SLOWEST_M_S)
            value, rate = float(np.clip(deep, -STEEPEST_RAD, STEEPEST_RAD)), 0.0
            found = self.sensing.error(order.through, seen, {order.through: value})
        if found is None:
            return loop.ahead(value, rate), 0.0
        if (speed := seen.get(SPEED[order.axis])) is None:
            off = loop.observe(found, float(self._wanted[AXES.index(order.axis)]), self.period_s)
        else:
            off = speed - rate
        return loop.force(found, off, self._surge) + loop.ahead(value, rate), found

    def _side(self, order: Order, seen: Mapping[str, float]) -> float:
        """1, or of a zig-zag the side to which it turns now: it goes over when the heading passes its limit."""
        if not order.turns_at_rad:
            return 1.0
        heading = (seen.get("heading_rad", 0.0) + np.pi) % (2.0 * np.pi) - np.pi
        if abs(heading) >= order.turns_at_rad:
            self._sides[order.target] = -np.sign(heading) * self.allocation.sense(order.target)
        return float(self._sides[order.target])

    def _loop(self, order: Order, rights: float) -> Loop:
        """A loop with the vehicle's numbers; InputError where its bandwidth is too much for what is late."""
        i = AXES.index(order.axis)
        channel = SPEED[order.axis] if order.loop == "speed" else PLACE.get(order.axis, "north_m")
        late = self.sensing.latency_s(channel) + max((t.lag_s for t in self.vehicle.thrusters), default=0.0)
        most = HURRIED_RAD / (late + self.period_s)
        if order.bandwidth_rad_s > most:
            what = f"latency, lag and tick of {self.vehicle.name} are {late + self.period_s:.2g} s together"
            raise order.table.error("bandwidth_rad_s", f"{what}; expected {most:.2g} or less")
        return Loop(
            mass=float(self.allocation.inertia[i]),
            linear=float(self.vehicle.linear_drag[i]),
            quadratic=float(self.vehicle.quadratic_drag[i]),
            rights=max(rights, 0.0) if order.axis in ("roll", "pitch") else 0.0,
            per_square=self._per_square(order.axis),
            bandwidth_rad_s=order.bandwidth_rad_s,
            most_rad_s=most,
            of_speed=order.loop == "speed",
        )

    def _per_square(self, axis: str) -> float:
        """Stiffness of pitch or yaw over the square of the speed ahead: of fins, less that of the Munk moment."""
        if axis not in ("pitch", "yaw"):
            return 0.0
        added, across = self.vehicle.added_mass, {"pitch": 2, "yaw": 1}[axis]
        return float(added[0, 0] - added[across, across]) - self.allocation.fins[AXES.index(axis)]

    def _refuse_above(self, order: Order, depth_m: float) -> None:
        """InputError where an order leads from that depth to above the surface."""
        if (order.target, order.loop) == ("heave", "place"):
            highest = float(order.signal.command(self._ticks, self.duration_s)[0].min())
            if depth_m + highest < 0.0:
                key = next((key for key in order.table.entries if key.endswith("_m")), "at_m")
                told = f"{highest:g} m from a depth of {depth_m:g} m is above the surface"
                raise order.table.error(key, f"{told}; expected {0.0 - depth_m:g} m or more, down is positive")

    def _refuse_beyond(self) -> None:
        """InputError where more than all is ordered: of a normalised input by all orders together, or of a force."""
        asked: dict[str, Array] = {}
        for order in self.orders:
            if order.loop == "share" or (order.loop == "input" and order.target.endswith("_command")):
                ordered = order.signal.command(self._ticks, self.duration_s)[0]
                if order.loop == "input":
                    asked[order.target] = ordered = asked.get(order.target, 0.0) + ordered
                worst = float(ordered[np.abs(ordered).argmax()])
                if abs(worst) > 1.0:
                    key = next(key for key in order.table.entries if key.startswith("amplitude"))
                    told = f"{order.target} is asked for {worst:.3g}; expected -1 to 1, full astern to full ahead"
                    raise order.table.error(key, told)

    def _refuse_short(self, part: Thruster | Fin, forces: Array) -> None:
        """InputError where one of the forces, (T,) [N], is more than a thruster can make."""
        if isinstance(part, Thruster):
            made = part.force_N(part.input_for(forces))
            if (short := np.abs(made - forces)).max() > SHORT * part.limit_N:
                worst, name = int(short.argmax()), part.name
                message = f"asks {forces[worst]:.3g} N of thruster {name}, which makes {made[worst]:.3g} N at most"
                raise InputError(f"{self.orders[0].table.path}: excite: {message}")

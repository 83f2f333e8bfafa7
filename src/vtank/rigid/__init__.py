"""A whole vehicle as a rigid body in water with six degrees of freedom, for estimation: laws, readings, kernels, fits.

The tank flies vehicles in MuJoCo; the equations here are written out by themselves, so that one can judge the other.
"""

from .layout import AXES, Layout
from .recorded import Recorded
from .recordings import record

__all__ = ["AXES", "Layout", "Recorded", "record"]

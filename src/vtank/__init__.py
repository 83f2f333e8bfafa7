"""A virtual tank for identifying the surge dynamics of an underwater vehicle."""

__version__ = "0.1.0"

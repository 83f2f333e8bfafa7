"""Packages whose public names are loaded when they are first used."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from types import ModuleType


class Facade(ModuleType):
    """A package that loads a public name from the module that holds it, and stays light until then.

    A public name may be that of a submodule, as the function `vtank.diagnose` and the package: the name wins.
    """

    _homes: dict[str, str]

    def __getattr__(self, name: str) -> object:
        """The public name, loaded now; AttributeError where there is none such."""
        if name not in self._homes:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        value = getattr(import_module(self._homes[name], self.__name__), name)
        vars(self)[name] = value
        return value

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute, unless it is a submodule just imported that would hide a public name."""
        if not (name in self._homes and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """The public names, loaded or not."""
        return sorted({*self._homes, *(name for name in vars(self) if name.startswith("__")), *vars(self)["__all__"]})


def facade(package: str, modules: Mapping[str, Sequence[str]]) -> list[str]:
    """Make a package a Facade with the public names of its modules, {module: names}; all names, for `__all__`."""
    module, homes = sys.modules[package], {name: f".{home}" for home, names in modules.items() for name in names}
    vars(module)["_homes"] = homes
    module.__class__ = Facade
    return list(homes)

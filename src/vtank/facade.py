"""Packages whose public names are loaded when they are first used."""

from __future__ import annotations

import ast
import difflib
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType


class Facade(ModuleType):
    """A package that loads a public name from the module that holds it, and stays light until then.

    A public name may be that of a submodule, as the function `vtank.diagnose` and the package: the name wins.
    """

    _homes: dict[str, str]
    __all__: list[str]

    def __getattr__(self, name: str) -> object:
        """The public name, loaded now; AttributeError where there is none such."""
        if name not in self._homes:
            near = difflib.get_close_matches(name, self.__all__, 1)
            slip = f"; did you mean {near[0]!r}?" if near and not name.startswith("_") else ""
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}{slip}")
        home = self._homes[name]
        loaded = import_module(f".{home or name}", self.__name__)
        value = vars(self)[name] = getattr(loaded, name) if home else loaded
        return value

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute, unless it is a submodule just imported that would hide a public name."""
        if not (name in self._homes and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """The public names, loaded or not."""
        return sorted({*vars(self)["__all__"], *(name for name in vars(self) if name.startswith("__"))})


def facade(package: str) -> list[str]:
    """Make a package a Facade; returns its public names for `__all__`.

    The names are those that type checkers see: relative imports under `if TYPE_CHECKING` in its `__init__.py`.
    """
    module = sys.modules[package]
    tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
    seen = [node for lazy in tree.body if isinstance(lazy, ast.If) for node in lazy.body]
    relative = [node for node in seen if isinstance(node, ast.ImportFrom) and node.level == 1]
    homes = {alias.name: node.module or "" for node in relative for alias in node.names}
    vars(module)["_homes"] = homes
    module.__class__ = Facade
    return list(homes)

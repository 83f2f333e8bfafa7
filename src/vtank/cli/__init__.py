"""The command `vtank`: one file per sub-command, each loading what it needs only when it runs.

The sub-command `check-data` is the module `vtank.cli.check_data` with two functions:

    add_parser(subparsers) -> None      declares the arguments; imports nothing heavy
    run(args) -> int                    does the work and returns the exit code

Exit codes: 0 done, 2 bad input or arguments (one line on stderr, no traceback), 130 interrupted, 141 reader of a pipe
gone, 143 terminated.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import io
import os
import re
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import redirect_stdout, suppress
from traceback import extract_tb
from types import ModuleType
from typing import NoReturn

from vtank import __version__
from vtank.errors import InputError

from .shown import Shown, one_line

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # sums of several threads are rounded otherwise, by 1e-12
COMMANDS = (  # in the order of `vtank --help`
    *("demo", "run", "campaign", "identify", "reproduce", "check-data", "import", "view"),
    *("diagnose", "predict", "explore", "effects", "bandwidth", "identifiability", "blind"),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command and return the exit code; `argv` defaults to the command line's arguments."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # names of files need not be text
    previous = signal.signal(signal.SIGTERM, _terminate)
    try:
        modules = _modules()
        args = _parse(modules, argv)
        with warnings.catch_warnings(), redirect_stdout(sys.stdout and Shown(sys.stdout)):
            warnings.showwarning = _show_warning
            code: int = modules[args.command].run(args)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except InputError as error:
        return _refuse(str(error))
    except KeyboardInterrupt:
        print("\nvtank: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        _silence_stdout()
        return 141
    except OSError as error:
        return _refuse(f"{_culprit(error)}: {error.strerror or error}")
    except (AttributeError, ImportError, RuntimeError) as error:
        drawing = any("gl_context" in frame.filename for frame in extract_tb(error.__traceback__))
        if "MUJOCO_GL" not in os.environ or not drawing:
            raise
        told = "nothing here can draw by that; expected egl, osmesa or glfw where it is installed, or no such variable"
        return _refuse(f"MUJOCO_GL={os.environ['MUJOCO_GL']}: {told}")
    except Exception as error:
        if "numba.core.errors.NumbaError" not in {f"{c.__module__}.{c.__name__}" for c in type(error).__mro__}:
            raise
        return _refuse(_uncompiled(error))
    finally:
        signal.signal(signal.SIGTERM, previous)


def _modules() -> dict[str, ModuleType]:
    paths = {name: f"{__name__}.{name.replace('-', '_')}" for name in COMMANDS}
    return {name: importlib.import_module(path) for name, path in paths.items()}


class Parser(argparse.ArgumentParser):
    """Arguments; of a word that is not known the nearest that is is named."""

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message, and exit with 2."""
        choice = re.search(r"invalid choice: '?([^']*?)'? \(choose from (.*)\)$", message, re.DOTALL)
        strange = re.match(r"unrecognized arguments: (--[\w-]+)", message)
        if choice:
            message = message[: choice.start()] + _slip(choice[1], re.findall(r"[\w-]+", choice[2]))
        elif strange:
            message = _slip(strange[1], sorted(set(re.findall(r"--[\w-]+", self.format_help()))))
        super().error(one_line(message))


def _slip(word: str, known: Sequence[str]) -> str:
    from vtank.record.toml import meant

    return f"unknown '{word}'{meant(word, known)}"


def _parse(modules: dict[str, ModuleType], argv: Sequence[str] | None) -> argparse.Namespace:
    parser, commands = _parser(modules)
    args, strange = parser.parse_known_args(argv)
    if strange:
        commands[args.command].error(f"unrecognized arguments: {' '.join(strange)}")
    return args


def _parser(modules: dict[str, ModuleType]) -> tuple[Parser, dict[str, Parser]]:
    """The parser of all commands, and that of each."""
    parser = Parser(
        prog="vtank",
        description="A virtual tank for underwater vehicles; it explains the gap between a simulator and recordings.",
    )
    parser.add_argument("--version", action="version", version=f"vtank {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for module in modules.values():
        module.add_parser(subparsers)
    return parser, subparsers.choices


def _refuse(message: str) -> int:
    print(f"vtank: error: {one_line(message)}", file=sys.stderr)
    return 2


def _culprit(error: OSError) -> str:
    """What the system refused: a file, or what is printed, since all that is written elsewhere is told by its name."""
    if error.filename is not None:
        return str(error.filename)
    if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO):
        return "the system"
    with suppress(OSError):  # where it is a file of its own
        _silence_stdout()
    return "standard output"


def _uncompiled(error: Exception) -> str:
    """File, line and reason of a law that loads but cannot be compiled: the innermost that numba's message names."""
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line).strip() for line in str(error).splitlines()]
    place = re.search(r'File "(.+?)", line (\d+)', "\n".join(lines))
    why = next((line for line in lines if line and not line.startswith("Failed in")), "no reason given")
    where = f"{os.path.abspath(place[1])}:{place[2]}" if place else "a law"
    return f"{where}: does not compile: {why}; expected arithmetic on numbers, as in the other files of effects/"


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: object = None,
    line: object = None,
) -> None:
    where = "" if issubclass(category, UserWarning) else f"{filename}:{lineno}: {category.__name__}: "
    print(f"vtank: warning: {where}{one_line(str(message))}", file=sys.stderr)


def _terminate(signum: int, frame: object) -> NoReturn:
    sys.exit(128 + signum)  # an exception, so that half-written folders are cleared away


def _silence_stdout() -> None:
    """Nobody reads on: let the interpreter's last flush go nowhere instead of failing."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

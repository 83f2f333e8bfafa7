"""The one exception that is the user's to mend."""

from __future__ import annotations


class InputError(Exception):
    """Something given to vtank cannot be used.

    The message is complete for the user: the file, the line or key, what was found and what was expected.
    The command line prints it without a traceback and exits with code 2.
    """

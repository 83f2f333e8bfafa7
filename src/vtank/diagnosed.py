"""What a user is given by a diagnosis: everything found, and the ways to see and to keep it."""

from __future__ import annotations

from html import escape
from pathlib import Path
from shutil import get_terminal_size

from .diagnose import diagnosis
from .diagnose.model_file import model_text
from .diagnose.whole import diagnosis as whole
from .errors import InputError
from .record import json_text, utf8, write_files

WIDEST = 110  # columns of a diagnosis on a terminal, at most


class Diagnosis(diagnosis.Diagnosis):
    """A diagnosis that can be printed, shown in a notebook, reported and saved."""

    def __str__(self) -> str:
        """The text that `vtank diagnose` prints."""
        from .present.terminal import terminal_text

        return terminal_text(self.document, min(get_terminal_size((100, 24)).columns, WIDEST))

    def _repr_html_(self) -> str:
        """The report, in a frame of its own so that the notebook's style and the report's do not mix."""
        frame = 'style="width: 100%; height: 80vh; border: 0" title="Gap diagnosis"'
        return f'<iframe {frame} srcdoc="{escape(self._page())}"></iframe>'

    def report(self, path: Path | str) -> None:
        """Write the report, one HTML file that loads nothing; InputError where it cannot be written."""
        self.write(report=path)

    def save(self, path: Path | str, law: int = 0) -> None:
        """Write the diagnosed model as TOML, for `predict`, or as the truth of a scenario; InputError as `report`.

        law: which of `laws` is accepted into it, 1 for the first; by default none.
        """
        self.write(model=path, law=law)

    def write_json(self, path: Path | str) -> None:
        """Write `document` as JSON, schema vtank.diagnosis/2; InputError as `report`."""
        self.write(json=path)

    def write(
        self,
        json: Path | str | None = None,
        model: Path | str | None = None,
        report: Path | str | None = None,
        law: int = 0,
    ) -> None:
        """Write what is asked for as a set: no file is changed before all of them could be written. As the above."""
        if law and not 0 < law <= len(self.laws):
            raise InputError(
                f"no law {law}: this diagnosis has {len(self.laws)}; expected a number from 1, or 0 for none"
            )
        contents = (
            (json, lambda: json_text(self.document)),
            (model, lambda: model_text(self, self.laws[law - 1] if law else None)),
            (report, self._page),
        )
        write_files({Path(path): utf8(text()) for path, text in contents if path})

    def _page(self) -> str:
        from .present.page import report_html

        return report_html(self, self.document)


class WholeDiagnosis(whole.WholeDiagnosis):
    """A diagnosis of a whole vehicle that can be printed, shown in a notebook, reported and saved."""

    def __str__(self) -> str:
        """The text that `vtank diagnose` prints."""
        from .present.whole import terminal_text

        return terminal_text(self.document, min(get_terminal_size((100, 24)).columns, WIDEST))

    def _repr_html_(self) -> str:
        """The report, in a frame of its own."""
        return f'<iframe style="width: 100%; height: 80vh; border: 0" srcdoc="{escape(self._page())}"></iframe>'

    def report(self, path: Path | str) -> None:
        """Write the report, one HTML file that loads nothing; InputError where it cannot be written."""
        write_text(path, self._page())

    def save(self, path: Path | str, law: int = 0) -> None:
        """Write the diagnosed simulator as TOML, for `predict`; InputError for a law, which there is none."""
        from .diagnose.whole.model_file import model_text

        if law:
            raise InputError(f"no law {law}: the diagnosis of a whole vehicle has none")
        write_text(path, model_text(self))

    def write_json(self, path: Path | str) -> None:
        """Write `document` as JSON, schema vtank.diagnosis/2; InputError as `report`."""
        write_text(path, json_text(self.document))

    def _page(self) -> str:
        from .present.whole import report_html

        return report_html(self, json_text(self.document))

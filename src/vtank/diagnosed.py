"""What a user is given by a diagnosis: everything found, and the ways to see and to keep it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from html import escape
from pathlib import Path
from shutil import get_terminal_size
from typing import Any

from .diagnose import diagnosis
from .diagnose.model_file import model_text
from .diagnose.whole import diagnosis as whole
from .diagnose.whole.model_file import model_text as whole_model_text
from .errors import InputError
from .record import json_text, utf8, write_files

WIDEST = 110  # columns of a diagnosis on a terminal, at most


class Outlets(ABC):
    """A diagnosis that can be printed, shown in a notebook, reported and saved, each from one document."""

    @abstractmethod
    def _text(self, width: int) -> str:
        """The text that `vtank diagnose` prints, of at most so many columns."""

    @abstractmethod
    def _page(self) -> str:
        """The report, one HTML page."""

    @abstractmethod
    def _model(self, law: int) -> str:
        """The diagnosed model as TOML, with that of its laws, 1 for the first; InputError where it has none such."""

    @property
    @abstractmethod
    def document(self) -> dict[str, Any]:
        """All that was found as plain data."""

    def __str__(self) -> str:
        """The text that `vtank diagnose` prints."""
        return self._text(min(get_terminal_size((100, 24)).columns, WIDEST))

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
        contents = (
            (json, lambda: json_text(self.document)),
            (model, lambda: self._model(law)),
            (report, self._page),
        )
        write_files({Path(path): utf8(text()) for path, text in contents if path})


class Diagnosis(diagnosis.Diagnosis, Outlets):
    """The diagnosis of runs along one axis."""

    def _text(self, width: int) -> str:
        from .present.terminal import terminal_text

        return terminal_text(self.document, width)

    def _page(self) -> str:
        from .present.page import report_html

        return report_html(self, self.document)

    def _model(self, law: int) -> str:
        if law and not 0 < law <= len(self.laws):
            raise InputError(
                f"no law {law}: this diagnosis has {len(self.laws)}; expected a number from 1, or 0 for none"
            )
        return model_text(self, self.laws[law - 1] if law else None)


class WholeDiagnosis(whole.WholeDiagnosis, Outlets):
    """The diagnosis of a whole vehicle."""

    def _text(self, width: int) -> str:
        from .present.whole import terminal_text

        return terminal_text(self.document, width)

    def _page(self) -> str:
        from .present.whole import report_html

        return report_html(self, json_text(self.document))

    def _model(self, law: int) -> str:
        if law:
            raise InputError(f"no law {law}: the diagnosis of a whole vehicle has none")
        return whole_model_text(self)

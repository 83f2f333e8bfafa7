"""Tables 1 to 4 in the paper's form: published, true and estimated values of each quantity, one above the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from math import floor, isfinite, log10, nan

from ...estimate import ResidualStatistics
from ...plant import to_feet
from ...present import Table
from ...present.document import csv_text
from ...units import FOOT_M
from .campaign import Campaign
from .published import PARAMETERS, RESIDUALS, UNITS, PublishedTable, published

ALL = "1-4"  # column of what was identified from all data sets together
SYMBOLS = {"gamma": "γ", "tau": "τ", "mean": "mean e", "deviation": "s_e", "mean_absolute": "mean |e|"}
SOURCES = ("published", "truth", "paper", "settling", "least_squares", "likelihood")  # order of the rows


@dataclass(frozen=True)
class Entry:
    """One number of a table, in the paper's feet; NaN where there is none."""

    table: int
    data_set: str  # "1" to "4", or ALL
    quantity: str
    source: str
    value: float
    sd: float = nan
    mark: str = ""

    @property
    def text(self) -> str:
        """Four decimals as in the paper, more where a standard deviation calls for them; 4e-06 where four show none."""
        if not isfinite(self.value):
            return f"-{self.mark}"
        if not isfinite(self.sd) or self.sd <= 0.0:
            small = 0.0 < abs(self.value) < 5e-5
            return f"{self.value:.0e}{self.mark}" if small else f"{self.value:.4f}{self.mark}"
        digits = min(max(4, 1 - floor(log10(self.sd))), 7)
        return f"{self.value:.{digits}f} ± {self.sd:.{digits}f}"


def entries(campaign: Campaign, number: int) -> list[Entry]:
    """All numbers of one table."""
    table = published()[number]
    found = [_published(table), _truth(campaign, table)]
    found += [_by_method(campaign, table, source) for source in ("paper", "settling", "least_squares")]
    return [entry for entry in chain(*found, _likelihood(campaign, table)) if entry.quantity in table.values]


def _published(table: PublishedTable) -> Iterator[Entry]:
    for quantity in table.quantities:
        for i, value in enumerate(table.values[quantity].tolist()):
            yield Entry(table.number, str(i + 1), quantity, "published", value, mark=table.mark(quantity, i + 1))


def _truth(campaign: Campaign, table: PublishedTable) -> Iterator[Entry]:
    values = dict(zip(PARAMETERS, to_feet(campaign.truth.lumped), strict=True))
    for i in range(len(campaign.results)):
        here = values | _residuals(campaign.truth_statistics(i))
        yield from (Entry(table.number, str(i + 1), name, "truth", value) for name, value in here.items())
    yield from (Entry(table.number, ALL, name, "truth", value) for name, value in values.items())


def _by_method(campaign: Campaign, table: PublishedTable, source: str) -> Iterator[Entry]:
    stages = "two_stage" if table.number == 4 else "kalman"
    method = {"paper": stages, "settling": f"{stages}_settling"}.get(source, source)
    for i in range(len(campaign.results)):
        estimate = campaign.paper[method, table.model, i]
        values = dict(zip(PARAMETERS, estimate.feet, strict=True)) | _residuals(estimate.statistics)
        for name, value in values.items():
            mark = "*" if name in estimate.unstable else ""
            yield Entry(table.number, str(i + 1), name, source, value, mark=mark)


def _likelihood(campaign: Campaign, table: PublishedTable) -> Iterator[Entry]:
    found = {str(i + 1): campaign.likelihood[table.model, i] for i in range(len(campaign.results))}
    for column, estimate in (found | {ALL: campaign.joint[table.model]}).items():
        feet = zip(PARAMETERS, to_feet(estimate.parameters), to_feet(estimate.sd), strict=True)
        yield from (Entry(table.number, column, name, "likelihood", value, sd) for name, value, sd in feet)
        if estimate.statistics:
            for name, value in _residuals(estimate.statistics).items():
                yield Entry(table.number, column, name, "likelihood", value)


def _residuals(statistics: ResidualStatistics) -> dict[str, float]:
    values = (statistics.mean, statistics.deviation, statistics.mean_absolute)
    return dict(zip(RESIDUALS, (value / FOOT_M for value in values), strict=True))


def labels(table: PublishedTable) -> dict[str, str]:
    """What each source is called in a table."""
    estimator = "two-stage" if table.number == 4 else "Kalman"
    q = table.values["q_ii"][0]
    return {
        "published": "published",
        "truth": "truth",
        "paper": f"{estimator}, q_ii = {q:g}",
        "settling": f"{estimator}, a Q that settles",
        "least_squares": "least squares",
        "likelihood": "maximum likelihood",
    }


def paper_form(campaign: Campaign, number: int) -> Table:
    """One table as a page shows it: for each quantity a row from every source."""
    table, found = published()[number], entries(campaign, number)
    names, columns = labels(table), ("1", "2", "3", "4", ALL)
    rows, kinds = [], []
    for quantity in table.quantities:
        for source in SOURCES:
            cells = {e.data_set: e.text for e in found if e.quantity == quantity and e.source == source}
            first = source == SOURCES[0]
            name = f"{SYMBOLS.get(quantity, quantity)} [{UNITS[quantity]}]" if first else ""
            rows.append((name, names[source], *(cells.get(column, "") for column in columns)))
            kinds.append(f"{source}{' first' * first}")
    header = ("", "", *(f"Data Set {column}" for column in columns[:4]), "all together")
    title = f"Table {table.number}: {table.title}"
    return Table(header, tuple(rows), notes(table), tuple(kinds), left=2, title=title)


def notes(table: PublishedTable) -> tuple[str, ...]:
    """What is doubtful in print, and the asterisk."""
    doubtful = [f"{doubt.mark} {_where(doubt.quantities, doubt.sets)}: {doubt.reason}." for doubt in table.doubts]
    return ("* unstable parameter; - no value, or a free run that diverges.", *doubtful, *table.notes)


def _where(quantities: Sequence[str], sets: Sequence[int]) -> str:
    names = "all rows" if len(quantities) > 3 else ", ".join(SYMBOLS.get(name, name) for name in quantities)
    places = "all data sets" if len(sets) == 4 else f"data set{'s' * (len(sets) > 1)} {', '.join(map(str, sets))}"
    return f"published {names}, {places}"


def tables_csv(campaign: Campaign) -> str:
    """All numbers of all tables, one a line, in feet as printed."""
    header = ("table", "truth", "model", "data_set", "quantity", "unit", "source", "value", "sd", "mark")
    rows = [
        (e.table, campaign.truth.name, published()[e.table].model, e.data_set, e.quantity, UNITS[e.quantity], e.source)
        + (e.value, e.sd, e.mark)
        for number in published()
        for e in entries(campaign, number)
    ]
    return csv_text(header, rows, blank=True)

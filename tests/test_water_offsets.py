"""The struct offsets lead where they should, and one that does not is refused."""

from __future__ import annotations

import ctypes

import mujoco
import pytest

from vtank.errors import InputError
from vtank.water import offsets


def test_offsets_hold_on_a_model_of_another_size() -> None:
    offsets.verify(offsets.OFFSETS, *offsets.probe(9))


@pytest.mark.parametrize("name", sorted(offsets.OFFSETS))
def test_every_shifted_offset_is_refused_by_name_and_version(name: str) -> None:
    shifted = {**offsets.OFFSETS, name: offsets.OFFSETS[name] + 8}
    with pytest.raises(InputError, match=rf"MuJoCo {mujoco.mj_versionString()}.*{name}.*install mujoco 4\.0"):
        offsets.verify(shifted, *offsets.probe(3))


def test_probe_has_no_two_fields_at_one_address() -> None:
    _, data = offsets.probe(2)
    addresses = [getattr(data, name).ctypes.data for name in offsets.POINTERS]
    assert len(set(addresses)) == len(addresses)


def test_another_series_is_refused() -> None:
    """Before anything is read or written: there the callback may come at another time."""
    with pytest.raises(InputError, match=r"expected the series 4\.0\.x.*install mujoco 4\.0"):
        offsets.check_series("4.1.0")


def test_unknown_header_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(offsets.SCALARS, "mjtSize")
    with pytest.raises(InputError, match="headers do not describe 'mjtSize'"):
        offsets.derive()


def test_reading_through_an_offset_sees_the_python_array() -> None:
    _, data = offsets.probe(2)
    data.qvel[3] = 0.625
    address = ctypes.c_size_t.from_address(data._address + offsets.OFFSETS["qvel"]).value
    assert ctypes.c_double.from_address(address + 3 * 8).value == 0.625

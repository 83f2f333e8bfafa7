"""What a vehicle's own file leaves out is read from its MJCF, and is what a file that states it says."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.diagnose.given import vehicle_of
from vtank.errors import InputError
from vtank.plant.vehicle import Vehicle, load_vehicle
from vtank.rigid.layout import Layout
from vtank.tank import described, load_whole

NAMES = ("bluerov2", "phoenix", "remus100", "kingfisher")
MJCF = """<mujoco><worldbody><body name="mine"><freejoint/>
<inertial pos="0.1 0 -0.02" mass="10" fullinertia="0.4 0.5 0.6 {slant} 0 0"/><site name="stern" pos="-0.5 0 0.1"/>
</body></worldbody></mujoco>"""


def bare(name: str) -> Vehicle:
    """A vehicle whose file says nothing that its MJCF says."""
    return replace(load_vehicle(name), sites={}, centre_m=None, inertia=None)


@pytest.mark.parametrize("name", NAMES)
def test_a_file_that_leaves_it_out_is_as_one_that_states_it(name: str) -> None:
    stated, found = load_vehicle(name), described(bare(name))
    assert stated.complete and not bare(name).complete and found.complete
    assert described(stated) is stated
    assert found.centre_m == pytest.approx(stated.centre_m, abs=1e-9)
    assert found.inertia == pytest.approx(stated.inertia, rel=1e-6)
    for part in (*stated.thrusters, *stated.fins):
        assert found.sites[part.site] == pytest.approx(stated.sites[part.site], abs=1e-6)


def test_a_diagnosis_asks_for_it() -> None:
    found = vehicle_of(bare("bluerov2"), (), None)
    assert found is not None and np.isfinite(Layout(found, (), (), ()).null).all()


def mine(folder: Path, slant: float = 0.0, site: str = "stern") -> Vehicle:
    (folder / "mine.xml").write_text(MJCF.format(slant=slant))
    whole = bare("bluerov2")
    thruster = replace(whole.thrusters[0], site=site, direction=(1.0, 0.0, 0.0))
    return replace(whole, mjcf=folder / "mine.xml", mass_kg=10.0, thrusters=(thruster,), path=folder / "mine.toml")


def test_a_complete_file_is_held_against_its_mjcf_too(tmp_path: Path) -> None:
    own = described(mine(tmp_path))
    assert own.complete
    with pytest.raises(InputError, match=r"mine.toml: body.mass_kg: found 11, but .*mine.xml has 10 kg"):
        vehicle_of(replace(own, mass_kg=11.0), (), None)
    with pytest.raises(InputError, match=r"sites.stern_m: .* the z axis of one of them points up"):
        vehicle_of(replace(own, sites={"stern": (-0.5, 0.0, 0.1)}), (), None)


def test_moments_are_about_the_centre_of_gravity(tmp_path: Path) -> None:
    found = described(mine(tmp_path))
    assert found.inertia == pytest.approx((0.4, 0.5, 0.6)) and found.centre_m == pytest.approx((0.1, 0.0, 0.02))


def test_products_of_inertia_are_told(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match=r"mine.xml: products of inertia of up to 0.1 kg m2 are left out"):
        described(mine(tmp_path, slant=0.1))


def test_a_thruster_at_no_site_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"mine.toml: thruster\[0\].site: .*no site 'bow'; there are: .*stern"):
        described(mine(tmp_path, site="bow"))


def test_propellers_need_not_be_listed_where_thrusters_push_ahead(tmp_path: Path) -> None:
    """[propeller] is for the surge tank's truth alone."""
    text = (load_vehicle("remus100").path).read_text().replace("remus100.xml", str(load_vehicle("remus100").mjcf))
    (tmp_path / "own.toml").write_text(re.sub(r"\[propeller\].*?(?=\n\[)", "", text, count=1, flags=re.DOTALL))
    own = load_vehicle(tmp_path / "own.toml")
    assert own.propeller_sites == load_vehicle("remus100").propeller_sites and np.isnan(own.propeller_diameter_m)
    assert load_whole(own).model.nu

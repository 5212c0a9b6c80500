"""Materials: every file that comes with the library, and what a user's own may hold."""

from __future__ import annotations

import math

import pytest

from toolpace.common.errors import UsageError
from toolpace.cutting.forces.material import Material

OWN = """
name = "Mine"
[[coefficients]]
cutter = "10 mm"
Ktc = "1500MPa"
Krc = "600N/mm2"
Kte = "20N/mm"
source = "test cuts"
validity = "shoulders"
"""


@pytest.mark.parametrize("name", Material.names())
def test_every_material_says_where_it_is_from_and_where_it_holds(name):
    material = Material.load(name)
    assert len(material.source) > 20 and len(material.validity) > 20
    least, most = material.spread["tangential"]
    assert 1e8 < least <= material.coefficients.tangential <= most < 1e10
    for cutter in material.others:
        assert Material.load(name, cutter).cutter == cutter


@pytest.mark.parametrize("rake", [0, 5, 12])
def test_titanium_is_that_of_orthogonal_data_in_oblique_cutting(rake):
    """Budak, Altintas, Armarego 1996, with chips that flow off at the angle of the helix, at a chip of 0.05 mm."""
    found = Material.load("ti-6al-4v", f"rake {rake} degrees").coefficients
    alpha, helix = math.radians(rake), math.radians(30.0)
    ratio = (1.755 - 0.028 * rake) * 0.05 ** (0.331 - 0.0082 * rake)
    shear = math.atan2(ratio * math.cos(alpha), 1.0 - ratio * math.sin(alpha))
    friction = math.atan(math.tan(math.radians(19.1 + 0.29 * rake)) * math.cos(helix))
    along, across = math.cos(friction - alpha), math.sin(friction - alpha)
    lateral = math.tan(helix) * math.sin(friction)
    pressure = 613e6 / math.sin(shear) / math.hypot(math.cos(shear + friction - alpha), lateral)
    assert found.tangential == pytest.approx(pressure * (along + math.tan(helix) * lateral), rel=5e-4)
    assert found.radial == pytest.approx(pressure * across / math.cos(helix), rel=5e-4)
    assert found.axial == pytest.approx(pressure * (along * math.tan(helix) - lateral), rel=5e-4)


def test_a_name_is_found_as_people_write_it():
    assert Material.load("AL 7075_t6").name == "Al7075-T6"
    assert Material.load("al7075-t6", "HSS").coefficients.tangential == pytest.approx(951.365e6)
    low, high = Material.load("al7075-t6").spread["tangential"]
    assert high > 2.0 * low


def test_an_own_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(OWN)
    material = Material.load(path)
    assert material.coefficients.tangential == 1.5e9 and material.coefficients.axial == 0.0
    assert "axial" not in material.spread


@pytest.mark.parametrize(
    "old, new, what",
    [
        ('Ktc = "1500MPa"\n', "", "Ktc is missing"),
        ('"1500MPa"', "1500", "no unit"),
        ('"1500MPa"', '"1500mm"', "Ktc: "),
        ('cutter = "10 mm"\n', "", "cutter is missing"),
        ("[[coefficients]]", "[coefficients]", "at least one set"),
        ('name = "Mine"', 'name = 3', "name is missing"),
        ("Kte", "Ktt", "unknown key"),
        ("[[coef", "[[[coef", "not a TOML file"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_in_a_line(tmp_path, old, new, what):
    path = tmp_path / "mine.toml"
    path.write_text(OWN.replace(old, new))
    with pytest.raises(UsageError, match=what) as error:
        Material.load(path)
    assert "\n" not in str(error.value)


def test_a_material_that_is_not_there():
    with pytest.raises(UsageError, match="al7075-t6"):
        Material.load("al7057-t6")
    with pytest.raises(UsageError, match="diamond"):
        Material.load("steel", "diamond")
    with pytest.raises(UsageError, match="cannot be read"):
        Material.load("nowhere.toml")

"""The printed parts: committed files, the table of dimensions, and the checks of hardware/mount.py.

Tests of the checks need build123d. The others need no CAD kernel.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import dimensions
import fingertip_layout
import mesh
import mount_tables
import numpy as np
import pytest
from dimensions import NOMINAL as D

from firstcontact.core.physics import gent_modulus
from firstcontact.twin import pad
from firstcontact.twin.mechanics import FingerParameters

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs/images"
NAMES = ("mount", "mould", "locator", "press")


def stl(name: str) -> mesh.Mesh:
    return mesh.read_stl(mount_tables.PARTS / f"{name}.stl")


def rounded(length: float, width: float, radius: float) -> float:
    """Area of a rectangle with round corners."""
    return length * width - (4 - math.pi) * radius**2


def expected(name: str) -> tuple[list[float], float]:
    """Bounding box and volume of a part by closed forms. Chamfers and fillets are left out."""
    (length, width), (inner, inside) = D.outer, D.inner
    if name == "mount":
        tongue = D.tongue_length * D.tongue_width - D.tie_width * (D.tie_spacing + D.tie_thickness)
        solid = rounded(length, width, D.wall) * D.wall_top + tongue * D.floor
        solid += D.tie_width * (D.tie_spacing - D.tie_thickness) * (D.floor - D.tie_thickness)
        solid -= (inner * inside + D.cable_width * D.wall) * (D.wall_top - D.floor)
        solid += math.pi / 4 * D.disc_diameter**2 * D.post_height
        solid -= 4 * math.pi / 4 * D.insert_diameter**2 * D.insert_depth
        return [length + D.tongue_length, width, D.wall_top], solid
    if name == "mould":
        size = (
            2 * D.board_length + 4 * D.land + 3 * D.gutter + 2 * D.wall,
            D.board_width + 2 * (D.land + D.gutter + D.wall),
        )
        solid = rounded(*size, 3.0) * (D.mould_top - D.border_drop)
        solid -= (size[0] - 2 * D.wall) * (size[1] - 2 * D.wall) * (D.gutter_depth - D.border_drop)
        rim = (D.board_length + 2 * D.land) * (D.board_width + 2 * D.land)
        return [*size, D.mould_top], solid + 2 * (rim * D.gutter_depth - D.pad_volume())
    if name == "locator":
        pocket = D.board_length + 2 * D.board_fit, D.board_width + 2 * D.board_fit
        outer = [side + 2 * D.wall for side in pocket]
        height = D.plate + D.locator_depth
        radius = D.disc_diameter / 2 + D.disc_fit
        solid = rounded(*outer, D.wall) * height - pocket[0] * pocket[1] * D.locator_depth
        solid -= math.pi * radius**2 * D.plate
        solid -= D.slot * (outer[0] / 2 - radius) * D.plate + D.slot * D.wall * D.locator_depth
        return [*outer, height], solid
    face = (D.board_length - 2 * D.press_margin) * (D.board_width - 2 * D.press_margin)
    height = D.press_plate + D.press_drop
    return [length, width, height], rounded(*D.outer, D.wall) * D.press_plate + face * D.press_drop


@pytest.mark.parametrize("name", NAMES)
def test_committed_part_is_closed_and_has_the_size_of_the_table(name: str) -> None:
    surface = stl(name)
    size, volume = expected(name)
    assert mesh.is_watertight(surface)
    assert mesh.size(surface) == pytest.approx(size, abs=0.02)
    assert mesh.volume(surface) == pytest.approx(volume, rel=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_committed_part_can_be_printed(name: str) -> None:
    surface = stl(name)
    assert mesh.thinnest(surface, spacing=1.6)[0] >= D.thinnest - 0.01
    assert all(level and width <= D.bridge for width, level in mesh.overhangs(surface))


def test_a_surface_with_a_hole_or_turned_inside_out_is_not_watertight() -> None:
    surface = stl("press")
    assert not mesh.is_watertight(surface[1:])
    assert not mesh.is_watertight(surface[:, ::-1])
    assert not mesh.is_watertight(np.concatenate([surface, surface[:1]]))


def test_thickness_and_overhang_of_a_box_on_a_stem() -> None:
    def box(low: tuple[float, ...], high: tuple[float, ...]) -> mesh.Mesh:
        corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        points = np.array(low) + corners * (np.array(high) - np.array(low))
        sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        turned = [t for a, b, c, d in sides for t in ((a, c, b), (a, d, c))]
        return points[np.array(turned)]

    plate = box((0, 0, 0), (9, 6, 2))
    assert mesh.is_watertight(plate)
    assert mesh.volume(plate) == pytest.approx(108)
    assert mesh.thinnest(plate)[0] == pytest.approx(2, abs=1e-3)
    assert mesh.overhangs(plate) == []
    table = np.concatenate([box((0, 0, 5), (9, 6, 7)), box((0, 0, 0), (1, 1, 5))])
    assert mesh.overhangs(table) == [(pytest.approx(6), True)]


def test_table_agrees_with_the_twin() -> None:
    finger = FingerParameters()
    area = D.board_length * D.board_width * 1e-6
    whole = finger.pad_modulus * area / (D.pad_thickness * 1e-3)
    assert whole == pytest.approx(pad.SOLID, rel=0.02)
    # The force of a pad whose dimples are flat, for a touch that loads a share of them.
    share, height = finger.pad_stiffness / pad.ON_DIMPLES, D.dimple_height * 1e-3
    flat = share * (pad.SOLID - pad.ON_DIMPLES) / height**2
    assert finger.pad_stiffening == pytest.approx(flat, rel=0.01)
    assert finger.pad_arm_stiffness == pytest.approx(finger.pad_stiffness / 2, rel=0.01)
    assert finger.pad_damping == pytest.approx(1.5 * share, rel=0.01)
    # Half of the pad at 1.1 g/cm3 is 0.5 g, which the twin rounds up to 0.55.
    assert finger.skin_mass == pytest.approx(area * D.pad_thickness * 1e-3 / 2 * 1100, rel=0.15)
    board = area * D.board_thickness * 1e-3 * 1850
    assert finger.board_mass == pytest.approx(board + 1.2e-3, rel=0.02)
    # The build page says that 60 Shore A is a fifth softer.
    assert gent_modulus(60) / finger.pad_modulus == pytest.approx(0.8, abs=0.02)
    assert f"flat at {D.dimple_height:g} mm" in (
        ROOT / "docs/reference/twin-parameters.md"
    ).read_text("utf-8")


def test_each_dimension_has_a_source() -> None:
    for name, value, meaning, source in dimensions.sources():
        assert value > 0, name
        assert meaning, name
        assert source in (dimensions.PAPER, dimensions.ASSUMED), name


def test_drawings_show_the_numbers_of_the_table() -> None:
    shown = {
        "fingertip-mount": [*D.inner, *D.outer, D.wall_top, D.floor, D.screw_length, D.screw_width],
        "fingertip-mould": [D.board_length, D.board_width, D.pad_thickness, D.mould_top],
        "fingertip-section": [D.board_length, D.pad_thickness, D.pad_top],
    }
    for name, numbers in shown.items():
        text = (IMAGES / f"{name}.svg").read_text("utf-8")
        assert [n for n in numbers if f">{n:g}</text>" not in text] == [], name
    page = (ROOT / "docs/how-to/build-a-fingertip.md").read_text("utf-8")
    circuit = (ROOT / "docs/reference/fingertip.md").read_text("utf-8")
    for text in (page, circuit, (IMAGES / "gluing-6-velostat.svg").read_text("utf-8")):
        assert f"{D.sheet_length:g} × {D.sheet_width:g} mm" in text
        assert f"off by {D.sheet_cut:g} mm" in text
    mount = (IMAGES / "fingertip-mount.svg").read_text("utf-8")
    assert f"4 × Ø{D.insert_diameter:g}, {D.insert_depth:g} deep" in mount


def test_velostat_covers_all_combs_and_no_edge_of_the_board() -> None:
    half = fingertip_layout.FINGERS * 0.3 - 0.15 + fingertip_layout.OPENING
    x, y = (max(place[axis] for place in D.taxels) for axis in (0, 1))
    x, y = x + half, y + fingertip_layout.OVERLAP + fingertip_layout.OPENING
    length, width = D.sheet_length / 2, D.sheet_width / 2
    assert min(length - x, width - y) > 0.15
    assert length + width - D.sheet_cut - (x + y) > 0.3  # the cut corner
    assert max(length - D.board_length / 2, width - D.board_width / 2) <= -0.5


def test_page_shows_each_step_of_gluing_where_it_is_done() -> None:
    page = (ROOT / "docs/how-to/build-a-fingertip.md").read_text("utf-8")
    shown = re.findall(r"\(\.\./images/(gluing-\S+)\)", page)
    assert shown == sorted(path.name for path in IMAGES.glob("gluing-*"))
    assert len(shown) == 7


class TestChecks:
    """Each check of hardware/mount.py finds a fault that was put in."""

    @pytest.fixture(autouse=True)
    def _cad(self) -> None:
        pytest.importorskip("build123d", reason="no build123d")

    @pytest.mark.parametrize("name", NAMES)
    def test_committed_part_is_that_of_the_table(self, name: str) -> None:
        import mount
        import solids

        part = solids.printed(D)[name]
        assert mesh.volume(stl(name)) == pytest.approx(mesh.volume(mount.triangles(part)))
        assert part.volume == pytest.approx(mesh.volume(stl(name)), rel=0.002)

    def test_hole_in_the_surface(self) -> None:
        import mount

        with pytest.raises(ValueError, match="not closed"):
            mount.check_print("press", stl("press")[1:], D)

    def test_thin_wall(self) -> None:
        import mount
        import solids

        thin = solids.mount(replace(D, wall=1.0))
        with pytest.raises(ValueError, match="thinner than"):
            mount.check_print("mount", mount.triangles(thin), D)

    def test_overhang_and_long_bridge(self) -> None:
        import mount
        from build123d import Align, Box, Cone, Cylinder, Pos

        up = (Align.CENTER, Align.CENTER, Align.MIN)
        mushroom = Cone(2, 6, 2, align=up) + Pos(0, 0, 2) * Cylinder(6, 2, align=up)
        with pytest.raises(ValueError, match="leans by more than 45 degrees"):
            mount.check_print("mushroom", mount.triangles(mushroom), D)
        bridge = Box(16, 9, 6, align=up) - Box(8.5, 9, 4, align=up)
        with pytest.raises(ValueError, match="longer than 8 mm"):
            mount.check_print("bridge", mount.triangles(bridge), D)

    @pytest.mark.parametrize(
        ("clearance", "sentence"), [(0.05, "less than 0.1"), (0.4, "above 0.3")]
    )
    def test_clearance(self, clearance: float, sentence: str) -> None:
        import mount
        import solids

        with pytest.raises(ValueError, match=sentence):
            mount.check_clearance(solids.mount(replace(D, clearance=clearance)), D)

    def test_silicone(self) -> None:
        import mount
        import solids

        assert mount.check_silicone(solids.mould(D), D) == pytest.approx(
            2 * D.pad_volume(), rel=1e-3
        )
        with pytest.raises(ValueError, match="mm³ of silicone"):
            mount.check_silicone(solids.mould(replace(D, dimple_diameter=3.0)), D)

    def test_screws_near_the_wires(self) -> None:
        import mount

        mount.check_screws(D)
        with pytest.raises(ValueError, match="thread"):
            mount.check_screws(replace(D, insert_depth=4.0))

    def test_press_that_cannot_reach_a_thin_board(self) -> None:
        import mount

        with pytest.raises(ValueError, match="thinnest board"):
            mount.check_press(replace(D, press_drop=2.2))

    @pytest.mark.parametrize(
        ("width", "thickness", "length"), [(16, 14, 30), (11, 12, 23), (12.5, 30, 26), (40, 8, 50)]
    )
    def test_adapter_has_room_for_the_finger_and_can_be_printed(
        self, width: float, thickness: float, length: float
    ) -> None:
        import adapter
        import mount
        from build123d import Align, Box, Pos

        finger = adapter.Finger(width, thickness, length)
        part = adapter.adapter(finger, D)
        mount.check_print("adapter", mount.triangles(part), D)
        up = (Align.MAX, Align.CENTER, Align.MIN)
        tip = Pos(D.outer[0] / 2, 0, adapter.plate_thickness(D))
        assert not (part & (tip * Box(length, width, thickness, align=up))).solids()
        assert (part & (tip * Box(length, width + 1, thickness, align=up))).solids()
        for x, y in D.screws:
            assert not (part & (Pos(x, y, -1) * Box(1, 1, 60, align=up))).solids()

    @pytest.mark.parametrize(
        ("name", "size"),
        [("width", (9, 14, 30)), ("thickness", (16, 5, 30)), ("length", (16, 14, 20))],
    )
    def test_adapter_refuses_a_finger_that_it_cannot_hold(
        self, name: str, size: tuple[float, ...]
    ) -> None:
        import adapter

        with pytest.raises(ValueError, match=f"--{name} must be"):
            adapter.adapter(adapter.Finger(*size), D)

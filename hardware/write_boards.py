"""Write the KiCad boards from the table and the layouts. Needs KiCad 9's own Python.

/usr/bin/python3 hardware/write_boards.py  # into hardware/boards
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
from pathlib import Path

import pcbnew
from amplifier_layout import AMPLIFIER
from circuit import Part, fingertip_parts, parts
from fingertip_layout import FINGERTIP
from footprints import write_footprints
from layout import (
    BACK,
    CLEARANCE,
    DRILL,
    FRONT,
    REVISION,
    VIA,
    Layout,
    Point,
    Step,
    Track,
    octilinear,
)
from project import net_name, path_id, write_projects

FOOTPRINTS = Path("/usr/share/kicad/footprints")
#: Place of the board on KiCad's sheet, mm.
SHEET = (100.0, 70.0)
#: Layers of both boards. KiCad's Python cannot set the finish.
STACKUP = """\t\t(stackup
\t\t\t(layer "F.SilkS" (type "Top Silk Screen") (color "White"))
\t\t\t(layer "F.Mask" (type "Top Solder Mask") (color "Green") (thickness 0.01))
\t\t\t(layer "F.Cu" (type "copper") (thickness 0.035))
\t\t\t(layer "dielectric 1" (type "core") (color "FR4 natural") (thickness 1.51) (material "FR4")
\t\t\t\t(epsilon_r 4.5) (loss_tangent 0.02))
\t\t\t(layer "B.Cu" (type "copper") (thickness 0.035))
\t\t\t(layer "B.Mask" (type "Bottom Solder Mask") (color "Green") (thickness 0.01))
\t\t\t(layer "B.SilkS" (type "Bottom Silk Screen") (color "White"))
\t\t\t(copper_finish "ENIG")
\t\t\t(dielectric_constraints no)
\t\t)"""
SMALL = 0.8  # mm, height of the names of parts


def _at(point: Point) -> pcbnew.VECTOR2I:
    """Convert a point of a layout, mm, into a point on KiCad's sheet."""
    return pcbnew.VECTOR2I_MM(round(point[0] + SHEET[0], 4), round(point[1] + SHEET[1], 4))


def _layer(side: str) -> int:
    return pcbnew.B_Cu if side == BACK else pcbnew.F_Cu


def _layers(*numbers: int) -> pcbnew.LSET:
    layers = pcbnew.LSET()
    for number in numbers:
        layers.AddLayer(number)
    return layers


class Builder:
    """Builder of a KiCad board from a layout and its parts."""

    def __init__(self, layout: Layout, table: tuple[Part, ...], file: Path, own: Path):
        pcbnew.KIID.SeedGenerator(1)  # equal identifiers in each run, so that files stay equal
        self.layout, self.table = layout, {part.reference: part for part in table}
        self.board = pcbnew.CreateEmptyBoard()
        self.file, self.own = file, own
        self._net_codes: dict[str, pcbnew.NETINFO_ITEM] = {}
        self._sheet()
        self._outline()
        for part in table:
            self._place(part)
        for number, hole in enumerate(layout.holes, 1):
            self._hole(number, hole)
        for track in layout.tracks:
            self._track(track)
        for text in layout.texts:
            self._text(text.words, text.at, text.height, text.degrees, text.side, text.align)
        for via in layout.vias:
            self._via(via, "gnd")
            self._reach_ground(via)
        if layout.stitching:
            self._stitch()
        for side in layout.grounded:
            self._ground(side)

    def save(self) -> None:
        """Fill the ground areas and write the board file."""
        pcbnew.SaveBoard(str(self.file), self.board, True)
        board = pcbnew.LoadBoard(str(self.file))  # the filler needs the project's rules
        pcbnew.ZONE_FILLER(board).Fill(board.Zones())
        pcbnew.SaveBoard(str(self.file), board, True)
        text = self.file.read_text("utf-8")
        self.file.write_text(text.replace("(setup", f"(setup\n{STACKUP}", 1), "utf-8")

    # --- frame ------------------------------------------------------------------------------

    def _sheet(self) -> None:
        title = self.board.GetTitleBlock()
        title.SetTitle(self.layout.title)
        title.SetRevision(REVISION)
        title.SetComment(0, "CERN-OHL-P-2.0")
        settings = self.board.GetDesignSettings()
        settings.SetBoardThickness(pcbnew.FromMM(1.6))
        left, top = self.layout.corner
        settings.SetAuxOrigin(_at((left, top + self.layout.size[1])))

    def _outline(self) -> None:
        left, top = self.layout.corner
        width, height = self.layout.size
        shape = pcbnew.PCB_SHAPE(self.board, pcbnew.SHAPE_T_RECT)
        shape.SetStart(_at((left, top)))
        shape.SetEnd(_at((left + width, top + height)))
        shape.SetLayer(pcbnew.Edge_Cuts)
        shape.SetWidth(pcbnew.FromMM(0.1))
        self.board.Add(shape)

    def _text(
        self, words: str, at: Point, height: float, degrees: float, side: str, align: int
    ) -> None:
        text = pcbnew.PCB_TEXT(self.board)
        text.SetText(words)
        text.SetPosition(_at(at))
        text.SetLayer(pcbnew.B_SilkS if side == BACK else pcbnew.F_SilkS)
        text.SetTextSize(pcbnew.VECTOR2I_MM(height, height))
        text.SetTextThickness(pcbnew.FromMM(0.15 * height))
        text.SetTextAngleDegrees(degrees)
        text.SetMirrored(side == BACK)
        text.SetHorizJustify(
            (pcbnew.GR_TEXT_H_ALIGN_LEFT, pcbnew.GR_TEXT_H_ALIGN_CENTER,
             pcbnew.GR_TEXT_H_ALIGN_RIGHT)[align + 1]
        )  # fmt: skip
        self.board.Add(text)

    # --- parts ------------------------------------------------------------------------------

    def _place(self, part: Part) -> None:
        library, name = part.footprint.split(":")
        shelf = self.own if library == "firstcontact" else FOOTPRINTS / f"{library}.pretty"
        footprint = pcbnew.FootprintLoad(str(shelf), name)
        footprint.SetFPID(pcbnew.LIB_ID(library, name))
        footprint.SetReference(part.reference)
        footprint.SetValue(part.label)
        footprint.Models().clear()
        footprint.SetPath(pcbnew.KIID_PATH(f"/{path_id(self.layout.name, part.reference)}"))
        x, y, degrees = self.layout.places[part.reference]
        footprint.SetPosition(_at((x, y)))
        footprint.SetOrientationDegrees(degrees)
        self.board.Add(footprint)
        for pad in footprint.Pads():
            if pad.GetNumber() in part.pins:
                pad.SetNet(self._net(part.pins[pad.GetNumber()]))
        reference = footprint.Reference()
        reference.SetVisible(part.reference in self.layout.names)
        if part.reference in self.layout.names:
            dx, dy = self.layout.names[part.reference]
            reference.SetPosition(_at((x + dx, y + dy)))
            reference.SetTextSize(pcbnew.VECTOR2I_MM(SMALL, SMALL))
            reference.SetTextThickness(pcbnew.FromMM(0.15 * SMALL))
            reference.SetTextAngleDegrees(0)
            reference.SetKeepUpright(False)

    def _hole(self, number: int, at: Point) -> None:
        name = "MountingHole_2.7mm_M2.5"
        hole = pcbnew.FootprintLoad(str(FOOTPRINTS / "MountingHole.pretty"), name)
        hole.SetFPID(pcbnew.LIB_ID("MountingHole", name))
        hole.SetReference(f"H{number}")
        hole.SetPosition(_at(at))
        hole.SetAttributes(
            pcbnew.FP_BOARD_ONLY | pcbnew.FP_EXCLUDE_FROM_BOM | pcbnew.FP_EXCLUDE_FROM_POS_FILES
        )
        hole.Reference().SetVisible(False)
        self.board.Add(hole)

    # --- copper -----------------------------------------------------------------------------

    def _net(self, name: str) -> pcbnew.NETINFO_ITEM:
        if name not in self._net_codes:
            net = pcbnew.NETINFO_ITEM(self.board, net_name(name))
            self.board.Add(net)
            self._net_codes[name] = net
        return self._net_codes[name]

    def _pad(self, name: str, near: Point | None = None) -> Point:
        """Return the position of a pad such as ``R1.2``.

        Of several, take the one nearest to ``near``.
        """
        reference, number = name.split(".")
        places = [
            (pcbnew.ToMM(p.GetPosition().x) - SHEET[0], pcbnew.ToMM(p.GetPosition().y) - SHEET[1])
            for p in self.board.FindFootprintByReference(reference).Pads()
            if p.GetNumber() == number
        ]
        return min(places, key=lambda p: abs(p[0] - near[0]) + abs(p[1] - near[1]) if near else 0)

    def _track(self, track: Track) -> None:
        names = [stop for stop in track.stops if isinstance(stop, str)]
        nets = {self.table[n.split(".")[0]].pins[n.split(".")[1]] for n in names} | (
            {track.net} if track.net else set()
        )
        if len(nets) != 1:
            raise ValueError(f"the track {track.stops} joins the nets {sorted(nets)}")
        (net,) = nets
        side, run = track.side, []
        for stop in track.stops:
            if stop is Step.VIA:
                self._run(run, net, side, track.width)
                self._via(run[-1], net)
                side, run = (FRONT if side == BACK else BACK), [run[-1]]
            elif isinstance(stop, str):
                run.append(self._pad(stop))
            else:
                x, y = stop
                run.append((run[-1][0] if x is None else x, run[-1][1] if y is None else y))
        self._run(run, net, side, track.width)

    def _run(self, points: list[Point], net: str, side: str, width: float) -> None:
        corners = octilinear(points)
        for a, b in itertools.pairwise(corners):
            if a == b:
                continue
            segment = pcbnew.PCB_TRACK(self.board)
            segment.SetStart(_at(a))
            segment.SetEnd(_at(b))
            segment.SetWidth(pcbnew.FromMM(width))
            segment.SetLayer(_layer(side))
            segment.SetNet(self._net(net))
            self.board.Add(segment)

    def _via(self, at: Point, net: str) -> None:
        via = pcbnew.PCB_VIA(self.board)
        via.SetPosition(_at(at))
        via.SetWidth(pcbnew.FromMM(VIA))
        via.SetDrill(pcbnew.FromMM(DRILL))
        via.SetNet(self._net(net))
        self.board.Add(via)

    def _reach_ground(self, via: Point) -> None:
        """Connect a via of the ground to the ground's pads within 2 mm."""
        for footprint in self.board.Footprints():
            for pad in footprint.Pads():
                at = pad.GetPosition()
                place = pcbnew.ToMM(at.x) - SHEET[0], pcbnew.ToMM(at.y) - SHEET[1]
                if (
                    pad.GetNetname() == net_name("gnd")
                    and max(abs(place[0] - via[0]), abs(place[1] - via[1])) < 2.0
                ):
                    self._run([place, via], "gnd", FRONT, 0.4)

    def _ground(self, side: str) -> None:
        left, top = self.layout.corner
        width, height = self.layout.size
        inset = 0.3
        zone = pcbnew.ZONE(self.board)
        zone.SetLayer(_layer(side))
        zone.SetNet(self._net("gnd"))
        zone.SetLocalClearance(pcbnew.FromMM(CLEARANCE + 0.05))
        zone.SetMinThickness(pcbnew.FromMM(0.25))
        zone.SetThermalReliefGap(pcbnew.FromMM(0.3))
        zone.SetThermalReliefSpokeWidth(pcbnew.FromMM(0.4))
        zone.SetIslandRemovalMode(pcbnew.ISLAND_REMOVAL_MODE_ALWAYS)
        outline = zone.Outline()
        outline.NewOutline()
        for x, y in (
            (left + inset, top + inset), (left + width - inset, top + inset),
            (left + width - inset, top + height - inset), (left + inset, top + height - inset),
        ):  # fmt: skip
            outline.Append(_at((x, y)))
        self.board.Add(zone)

    def _stitch(self) -> None:
        """Add ground vias on a grid, where no other copper or text is near."""
        left, top = self.layout.corner
        width, height = self.layout.size
        pitch = self.layout.stitching
        apart = pcbnew.FromMM(VIA / 2 + CLEARANCE + 0.25)
        copper = [
            item.GetEffectiveShape(layer)
            for item in [
                *self.board.GetTracks(),
                *(pad for f in self.board.Footprints() for pad in f.Pads()),
            ]
            for layer in (pcbnew.F_Cu, pcbnew.B_Cu)
            if item.IsOnLayer(layer)
        ]
        silk = [t.GetBoundingBox() for t in self.board.GetDrawings() if t.IsOnLayer(pcbnew.F_SilkS)]
        silk += [
            f.Reference().GetBoundingBox()
            for f in self.board.Footprints()
            if f.Reference().IsVisible()
        ]
        found = []
        for column in range(int(width // pitch) + 1):
            for row in range(int(height // pitch) + 1):
                at = (left + 2.0 + column * pitch, top + 2.0 + row * pitch)
                if at[0] > left + width - 1 or at[1] > top + height - 1:
                    continue
                place = _at(at)
                circle = pcbnew.SHAPE_CIRCLE(place, 0)
                if any(shape.Collide(circle, apart) for shape in copper):
                    continue
                if any(box.Contains(place) for box in silk):
                    continue
                found.append(at)
        for at in found:
            self._via(at, "gnd")


def main() -> None:
    """Write both boards."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "boards")
    folder = parser.parse_args().out
    write_projects(folder)
    with tempfile.TemporaryDirectory() as name:
        own = Path(name, "firstcontact.pretty")
        write_footprints(own)
        for layout, table in ((AMPLIFIER, parts()), (FINGERTIP, fingertip_parts())):
            file = folder / layout.name / f"{layout.name}.kicad_pcb"
            Builder(layout, table, file, own).save()


if __name__ == "__main__":
    main()

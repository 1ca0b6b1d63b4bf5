"""The whole in the colors of its pieces, beside the pieces: as answered or as read back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.drawing.exhibit import Exhibit, Layer, Partner
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.known_layers import known_layer
from sherd.report.puzzle.piece_colors import piece_palette
from sherd.report.puzzle.piece_row import ShownPiece, piece_row

__all__ = ["AssemblyScene"]


@dataclass(frozen=True, eq=False)
class AssemblyScene:
    """What is shown of an assembly.

    Attributes
    ----------
    full
        The full shape.
    pieces
        In the order given.
    labels
        (n,) piece of each vertex of the full shape, -1 for the gap.
    membership
        (n,) how far it belongs to what it is given to.
    """

    full: TriangleMesh
    pieces: Sequence[ShownPiece]
    labels: Ints
    membership: Floats

    @property
    def full_layers(self) -> tuple[Layer, ...]:
        """Pieces and memberships."""
        gap = len(self.pieces)
        return (
            self._pieces(np.where(self.labels < 0, gap, self.labels)),
            known_layer("membership", self.membership),
        )

    def piece_layers(self, number: int) -> tuple[Layer, ...]:
        """Of one piece alone."""
        piece = self.pieces[number]
        layers = [self._pieces(np.full(piece.mesh.vertex_count, self._color(number)))]
        if piece.partner is not None:
            layers.append(known_layer("confidence", np.asarray(piece.partner.confidence)))
            layers.append(known_layer("matched", piece.partner.known))
        return tuple(layers)

    def exhibit(self) -> Exhibit:
        """The whole beside its pieces, without words."""
        row = piece_row(self.full, self.pieces)
        colors = np.array([self._color(number) for number in range(len(self.pieces))])
        partner = self._partner()
        return Exhibit(
            title=f"{len(self.pieces)} pieces on {self.full.name}",
            full=self.full,
            part=row.mesh,
            full_layers=self.full_layers,
            part_layers=(
                self._pieces(colors[row.owner]),
                known_layer("confidence", np.asarray(partner.confidence)),
            ),
            partner=partner,
            region=np.ones(self.full.vertex_count, dtype=bool),
            names=("Full shape", "Pieces"),
            part_stands=True,
            part_numbers=row.numbers,
        )

    def _color(self, number: int) -> int:
        refused = self.pieces[number].partner is None
        return len(self.pieces) + 1 if refused else number

    def _pieces(self, values: Ints) -> Layer:
        own = (f"{k} {piece.mesh.name}" for k, piece in enumerate(self.pieces))
        return Layer(
            "piece",
            values,
            kind="category",
            description="Which piece lies where; equal colors belong together.",
            labels=(*own, "gap", "refused"),
            palette=piece_palette(len(self.pieces)),
        )

    def _partner(self) -> Partner:
        """The map of all pieces, one after the other."""
        found = [
            _nowhere(piece.mesh.vertex_count) if piece.partner is None else piece.partner
            for piece in self.pieces
        ]
        points = SurfacePoints(
            np.concatenate([each.points.faces for each in found]),
            np.concatenate([each.points.barycentric for each in found]),
        )
        confidence = np.concatenate([np.asarray(each.confidence) for each in found])
        return Partner(points, np.concatenate([each.known for each in found]), confidence)


def _nowhere(count: int) -> Partner:
    points = SurfacePoints(np.zeros(count, dtype=np.int64), np.tile([1.0, 0.0, 0.0], (count, 1)))
    return Partner(points, np.zeros(count, dtype=bool))

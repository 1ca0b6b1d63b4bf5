"""Pieces of the generated animal in two poses, and how they truly lie on each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from scipy.spatial import cKDTree

from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.pairwise.body import Body, Told
from sherd.shapes import creature, cut_by_ball, landmarks, whole
from sherd.shapes.fragment import Fragment


@pytest.fixture(scope="module")
def near() -> float:
    """What is laid from the truth lies within the edges of the coarser of two meshings."""
    return 0.03


@pytest.fixture(scope="module")
def cut_halves() -> Callable[[float, float], tuple[Fragment, Fragment]]:
    """Cuts the front, standing, and the rear, walking, so far from the nose and the tail."""

    def halves(nose: float, tail: float) -> tuple[Fragment, Fragment]:
        full, walking = creature(5000), creature(5000, pose="walk")
        marks = landmarks(full)
        return (
            cut_by_ball(whole(full, full), marks["nose"], nose),
            cut_by_ball(whole(walking, full), marks["tail_tip"], tail),
        )

    return halves


@pytest.fixture(scope="module")
def alone(cut: Sequence[Fragment]) -> list[Union]:
    """The pieces that a module cuts."""
    return [Union.of_piece(piece.mesh, number) for number, piece in enumerate(cut)]


@pytest.fixture(scope="module")
def laid_truly(
    cut: Sequence[Fragment], alone: list[Union], near: float
) -> Callable[[int, int], Join]:
    """Lays the second of two pieces on the first from the truth, as likely as can be."""

    def laid(first: int, second: int) -> Join:
        there, here = (cut[k].truth.positions(cut[k].full) for k in (first, second))
        away, nearest = cKDTree(there).query(here)
        told = Told(cut[first].mesh.vertices[nearest], away < near * cut[0].full.length)
        met = Body(cut[first].mesh, 0).met(cut[second].mesh, told)
        return Join(alone[first], alone[second], replace(met, chance=0.99))

    return laid

"""Floor 6: generated shapes and pieces of them, with exact ground truth."""

from __future__ import annotations

from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, cut_by_plane, moved, remeshed, whole
from sherd.shapes.puzzle import puzzle_balls, puzzle_pieces
from sherd.shapes.vase import Sherd, vase, vase_sherds

__all__ = [
    "Fragment",
    "Sherd",
    "creature",
    "cut_by_ball",
    "cut_by_plane",
    "landmarks",
    "moved",
    "puzzle_balls",
    "puzzle_pieces",
    "remeshed",
    "vase",
    "vase_sherds",
    "whole",
]

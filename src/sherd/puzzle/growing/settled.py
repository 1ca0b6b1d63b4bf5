"""Joins that were decided, with what is shared brought home by relief."""

from __future__ import annotations

from dataclasses import replace

from sherd.correspondence.shared.relief import alike_in_relief
from sherd.puzzle.growing.sliding import slid
from sherd.puzzle.growing.union import Join
from sherd.results.overlap_options import OverlapOptions

__all__ = ["settled"]


def settled(join: Join) -> Join:
    """A join with what is shared where reliefs are most alike; its chance is what it was.

    As it was where a slide makes reliefs less alike, at a width finer than those it slides by.
    """
    met = join.met
    found = slid(met.questions, met.placements, strain=OverlapOptions().strain)
    before, after = (alike_in_relief(met.questions, each) for each in (met.placements, found))
    return replace(join, met=replace(met, placements=found)) if after > before else join

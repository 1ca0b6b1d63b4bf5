"""match_with_fitted_scale(): individuals of one kind differ in size, and a match is better without.

``scale="same"`` believes that skin keeps its lengths; of mouse skulls of several strains, lengths
differ by up to an eighth, and points then slide. How much larger the part lies on the full shape
than it is says the factor, and a second match takes it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np

from sherd.errors import OptionError
from sherd.match import match
from sherd.mesh.sizes import LARGEST_PART, check_areas
from sherd.output import Stages
from sherd.results.fitted.fit_options import Sizing
from sherd.results.keywords import options_of
from sherd.results.match_options import MatchKeywords, MatchOptions, Scale
from sherd.results.match_result import MatchResult
from sherd.scan.intake import Intake, MeshSource, ScanSource, scan_intake
from sherd.surface.prepared import as_template
from sherd.surface.template import Template

__all__ = [
    "FITTED_ANYWAY", "at_fitted_scale", "length_ratio_of", "match_with_fitted_scale",
    "sizing_after",
]  # fmt: skip

# In sqrt(area) of the full shape: straight lines that are longer are bent by the pose, and shorter
# ones say how smooth the map is. Of a skull, 3 to 8 mm.
SHORTEST, LONGEST = 0.08, 0.2
# Of so many pairs of vertices one in ten to twenty has such a length: enough for a median.
PAIRS = 200_000
# Lengths that agree up to this stay: the labeling allows for a tenth, and a pose takes as much.
LITTLE = 0.02
# Parts of another size than this many times that of the full shape's kind are not of another
# individual; their scale is unknown.
LARGEST_RATIO = 1.5
# So that a size at the bound is within it.
ROUNDING = 1e-9

FITTED_ANYWAY = (
    'scale is "unknown", which is fitted anyway; give another scale, or do not ask to fit it'
)


def match_with_fitted_scale(
    full: MeshSource | Template,
    part: ScanSource,
    options: MatchOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[MatchKeywords],
) -> MatchResult:
    """As :func:`sherd.match`, for a part of another individual, which is larger or smaller.

    Returns
    -------
    MatchResult
        Of two matches, the second with the lengths of the first answer, the one with the higher
        score; ``result.scale`` says which. The first alone if its lengths agree within 2 %.

    Raises
    ------
    OptionError
        If the scale is unknown, which looks for it over a wide range anyway; otherwise as
        :func:`sherd.match`.
    """
    options = options_of(MatchOptions, options, keywords)
    if options.scale == "unknown":
        raise OptionError(FITTED_ANYWAY)
    stages = stages or Stages(visible=False)
    template, scan = as_template(full), scan_intake(part)
    first = match(template, scan, _not_too_large(template, scan, options), stages=stages)
    return at_fitted_scale(first, template, scan, options, stages=stages)


def at_fitted_scale(
    first: MatchResult,
    template: Template,
    part: Intake,
    options: MatchOptions,
    *,
    stages: Stages | None = None,
) -> MatchResult:
    """The second match, where a first one with these options is there already."""
    ratio = length_ratio_of(first)
    if not LITTLE < abs(np.log(ratio)) < np.log(LARGEST_RATIO):
        return first
    fitted = replace(options, scale=first.scale * ratio, part_unit=None, full_unit=None)
    second = match(template, part, _not_too_large(template, part, fitted), stages=stages)
    return second if second.best.score > first.best.score else first


def _not_too_large(template: Template, part: Intake, options: MatchOptions) -> MatchOptions:
    """The same question, for a part so much larger than a match takes that it may be another one.

    It is asked at the largest size that fits. Areas differ more than lengths: those of skulls, with
    all that is inside, by 1.37 where lengths differ by 1.1.
    """
    full = template.intake.mesh
    check_areas(full, part.mesh)
    ratio = part.mesh.area * options.factor**2 / full.area
    if not LARGEST_PART < ratio < LARGEST_RATIO**2:
        return options
    fitting = options.factor * np.sqrt(LARGEST_PART / ratio) * (1 - ROUNDING)
    return replace(options, scale=float(fitting), part_unit=None, full_unit=None)


def sizing_after(result: MatchResult, asked: Scale | float) -> Sizing:
    """How a fit should be sized after a match with fitted scale that was asked at scale `asked`.

    Where another scale fits better, the part is of another individual.
    """
    return "local" if result.options.scale == asked else "individual"


def length_ratio_of(result: MatchResult) -> float:
    """How many times as long lines on the part are where it lies on the full shape.

    Median over straight lines of 0.08 to 0.2 sqrt(area) between matched vertices, relative to the
    scale of the result; 1 if there are none.
    """
    known = np.flatnonzero(result.matched)
    if not len(known):
        return 1.0
    here, there = result.part.vertices[known] * result.scale, result.positions[known]
    first, second = np.random.default_rng(0).integers(len(known), size=(2, PAIRS))
    before = np.linalg.norm(here[first] - here[second], axis=1)
    after = np.linalg.norm(there[first] - there[second], axis=1)
    unit = result.full.length
    use = (before > SHORTEST * unit) & (before < LONGEST * unit) & (after > 0)
    return float(np.median(after[use] / before[use])) if use.any() else 1.0

"""Where the viewer stood who saw a surface from one side, as a depth scanner does."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats

__all__ = ["viewing_direction"]

# A viewer sees only what faces them. Of what one camera sees of animals and people 0.984 and more
# does, of the cuts of SHREC'16 0.955 at most, as limbs go all around.
ONE_SIDED = 0.97
# What faces the viewer by more than a few times 7 degrees says nothing more, and what looks away
# counts by how far it does, no more, so that noise of single normals does not decide.
STEEPNESS = 8.0


def viewing_direction(normals: Floats, areas: Floats) -> Floats | None:
    """Unit direction (3,) toward the viewer of a surface that was seen from one side, or None.

    The direction that minimizes `sum a log(1 + exp(-8 n . d))`: all that was seen faces it.

    Parameters
    ----------
    normals, areas
        (n, 3) unit normals and (n,) areas of the vertices.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - few surfaces are asked before matching

    used = areas > 0  # what has no face has no normal
    share, normals = areas[used] / areas.sum(), normals[used]
    mean = share @ normals
    if not np.linalg.norm(mean) > 0:
        return None

    def looking_away(toward: Floats) -> tuple[float, Floats]:
        size = np.linalg.norm(toward)
        unit = toward / size
        away = -STEEPNESS * (normals @ unit)
        slope = -STEEPNESS * ((share / (1.0 + np.exp(-away))) @ normals)
        return float(share @ np.logaddexp(0.0, away)), (slope - unit * (unit @ slope)) / size

    toward = minimize(looking_away, mean / np.linalg.norm(mean), jac=True, method="BFGS").x
    toward /= np.linalg.norm(toward)
    return toward if share[normals @ toward > 0].sum() >= ONE_SIDED else None

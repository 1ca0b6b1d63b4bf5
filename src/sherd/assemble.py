"""assemble(full, pieces): which piece lies where on the whole, and what does not belong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

from sherd.errors import InputError
from sherd.match import STAGES as MATCH_STAGES
from sherd.output import Stages
from sherd.puzzle.answers import AssemblyQuestion, Decision, assembly_of
from sherd.puzzle.borders import bordering, cut_apart
from sherd.puzzle.further_trials import trials_again
from sherd.puzzle.partition import Partition
from sherd.puzzle.rigid.rigid_trials import rigid_trials
from sherd.puzzle.siblings import chosen_beside_siblings
from sherd.puzzle.trials import trials_alone
from sherd.results.keywords import options_of
from sherd.results.match_options import MatchOptions
from sherd.results.puzzle.assemble_options import AssembleKeywords, AssembleOptions
from sherd.results.puzzle.assembly import Assembly
from sherd.scan.intake import MeshSource, ScanSource, piece_intakes
from sherd.surface.prepared import as_template
from sherd.surface.template import Template
from sherd.threads import one_blas_thread

__all__ = ["STAGES", "assemble"]

# Of each piece those of a match but the twin, then once.
STAGES = (*MATCH_STAGES, "joint choice", "borders", "partition")


@one_blas_thread()  # or sums over 10,000 vertices would depend on how many there are
def assemble(
    full: MeshSource | Template,
    pieces: Sequence[ScanSource],
    options: AssembleOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[AssembleKeywords],
) -> Assembly:
    """Place all pieces on the full shape together: what belongs where, what is missing or foreign.

    Memberships u_1 ... u_k of the pieces and u_0 of the gap are at least 0, sum to 1 everywhere,
    and minimize a multi-phase Mumford-Shah energy

        E(u) = sum_i integral u_i f_i + (omega / 2) sum_i Per(u_i)

    in two steps: which placement of each piece, or none (:mod:`sherd.puzzle.joint_choice`), then
    where exactly the borders run (:mod:`sherd.puzzle.partition`).

    Parameters
    ----------
    full
        The full shape, as in :func:`sherd.match`.
    pieces
        The pieces: deformed, in any pose and order; whatever :func:`sherd.match` takes for a part,
        in the unit of the full shape. Some may be missing, some may not belong.
    options
        See :class:`AssembleOptions`; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`AssembleOptions`, instead of `options`.

    Returns
    -------
    Assembly
        ``assembly.check()`` proves that memberships of pieces sum to no more than 1; the gap has
        the rest. That a piece does not belong is an answer, with a reason.

    Raises
    ------
    OptionError
        If a keyword is unknown, or both `options` and keywords are given.
    MeshFileError, InvalidMeshError, InputError
        If a shape cannot be read or is no mesh, or there are no pieces.

    Notes
    -----
    Each piece is placed once, and again where it clashes with others or is torn between places. A
    rigid one is brought to the places where it fits most closely.

    References
    ----------
    Litany, Rodola, Bronstein, Bronstein, Cremers, *Non-rigid puzzles*, 2016: the question, and
    memberships that sum to 1 with one for the gap. Places are not found by functional maps here.

    Examples
    --------
    >>> from sherd.shapes import creature, puzzle_pieces
    >>> full = creature(5000)
    >>> pieces = puzzle_pieces(full, [creature(5000, pose="walk"), full])
    >>> answer = assemble(full, [piece.mesh for piece in pieces])
    >>> answer.placed, round(answer.gap_share, 1)
    ((0, 1), 0.0)
    """
    options = options_of(AssembleOptions, options, keywords)
    stages = stages or Stages(visible=False)
    intakes = piece_intakes(pieces)
    if not intakes:
        raise InputError("no pieces were given, but at least one is needed")
    template = as_template(full)
    partition = Partition(template.placed)
    asked = MatchOptions(side=options.side, seed=options.seed)
    if options.rigid:
        trials, impossible = rigid_trials(
            template, intakes, asked, options.closeness, stages, partition
        )
    else:
        trials, impossible = trials_alone(template, intakes, asked, stages, partition)
        trials += trials_again(
            template, trials, len(intakes), stages, may_overlap=options.may_overlap
        )
    with stages("joint choice"):
        together = chosen_beside_siblings(
            trials, len(intakes), template.placed.vertex_areas, may_overlap=options.may_overlap
        )
    with stages("borders"):
        placed = {piece: trial.placed for piece, trial in together.trials.items()}
        cut = not (options.may_overlap or options.rigid) and cut_apart(placed.values())
        if cut:
            placed = bordering(placed)
    decision = Decision(trials, together, placed, impossible, cut)
    return assembly_of(AssemblyQuestion(template, intakes, partition, options), decision, stages)

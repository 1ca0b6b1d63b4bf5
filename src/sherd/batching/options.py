"""BatchOptions: how a batch is written and shared, by name."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from sherd.batching.parts import Share
from sherd.errors import OptionError
from sherd.limits import available_memory, require_finite, require_whole
from sherd.report.exports import require_exports
from sherd.results.display import differences

__all__ = ["BatchOptions", "job_count"]

# A worker held .47 GB at most with a template of 2,000 vertices and parts of 700, and one of the
# benchmarks holds some .5 GB with 10,000 and 5,000. Three more templates may be kept, .1 GB each.
LEAST_WORKER_MEMORY = 10**9
MEMORY_REASON = "libraries alone take about .3 GB"


@dataclass(frozen=True, repr=False)
class BatchOptions:
    """Options of :func:`sherd.batch` beside those of the match.

    Parameters
    ----------
    min_confidence
        Below it a vertex counts as unmatched.
    fit_scale
        Whether parts are of other individuals than the full shape: each is matched again at the
        size that its first answer has, as by :func:`sherd.match_with_fitted_scale`.
    exports
        Further files of each answer, as of :func:`sherd.write_report`; with ``"parquet"`` also
        ``summary.parquet``.
    template
        File that keeps what depends on the one full shape alone; in the folder if None.
    shard
        ``"2/10"``: only the second of ten shares. Other processes do the others, on this machine
        or elsewhere, into the same folder; then :func:`sherd.collect_batch` makes the summary.
    memory
        Bytes that each worker process may hold; an equal share of what is free if None.
    overwrite
        Whether the folder may hold others' files, and those of a part be replaced.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> BatchOptions(shard="2/10").share
    Share(index=2, count=10)
    """

    min_confidence: float = 0.0
    fit_scale: bool = False
    exports: tuple[str, ...] = ()
    template: Path | None = None
    shard: str | None = None
    memory: int | None = None
    overwrite: bool = False

    def __repr__(self) -> str:
        return differences(self)

    def __post_init__(self) -> None:
        require_finite("min_confidence", self.min_confidence, 0, 1, "it is a chance")
        object.__setattr__(self, "exports", tuple(self.exports))
        require_exports(self.exports)
        if self.template is not None:
            object.__setattr__(self, "template", Path(self.template))
        if self.memory is not None:
            require_whole("memory", self.memory, 5 * 10**8, 2**50, MEMORY_REASON)
        _ = self.share

    @property
    def share(self) -> Share | None:
        """The share that `shard` names."""
        return None if self.shard is None else Share.from_text(self.shard)


def job_count(jobs: int | None, memory: int | None) -> tuple[int, int | None]:
    """How many worker processes, and how many bytes each may hold.

    Parameters
    ----------
    jobs
        As asked for; if None, one a core, or as many as memory is free for.
    memory
        Bytes for each, as asked for; an equal share of what is free if None.

    Raises
    ------
    OptionError
        If so many are out of range, or memory is too short for them.
    """
    free = available_memory()
    need = memory or LEAST_WORKER_MEMORY
    cores = os.cpu_count() or 1
    if jobs is None:
        jobs = cores if free is None else max(1, min(cores, free // need))
    else:
        require_whole("jobs", jobs, 1, max(16, cores), "more of them than cores gain nothing")
        if free is not None and jobs > 1 and jobs * need > free:
            raise OptionError(
                f"{jobs} jobs need about {jobs * need / 1e9:.1f} GB of memory, but "
                f"{free / 1e9:.1f} GB are free; ask for {max(1, free // need)}, or say how little "
                "each needs (--memory, in GB)"
            )
    return jobs, memory or (None if free is None else max(need, free // jobs))

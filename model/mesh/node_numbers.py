"""Which nodes of a mesh are those of its file, by their numbers there, and which were added between them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.numerics import Bools, Ints


@dataclass(frozen=True, slots=True)
class NodeNumbers:
    """The numbers of nodes in a mesh file, counted from 0.

    Attributes:
        of_file: (m,) numbers of the first m nodes in the file, ascending; it may have nodes that no
            tetrahedron uses.
        middles: nodes added after these, level by level: the two ends (k, 2) that each lies between.
    """

    of_file: Ints
    middles: tuple[Ints, ...] = ()

    def chosen(self, wanted: Ints) -> Bools:
        """The nodes with some numbers, and those added between two of them: (n_nodes,) bool.

        Raises:
            ValueError: a number that no node has.
        """
        missing = np.setdiff1d(wanted, self.of_file)
        if len(missing):
            raise ValueError(
                f"node {missing[0]} is not in the mesh or in no tetrahedron; numbers count from 0 and go up "
                f"to {self.of_file[-1]}"
            )
        found: Bools = np.isin(self.of_file, wanted)
        for ends in self.middles:
            found = np.concatenate([found, found[ends].all(axis=1)])
        return found

    def with_middles(self, ends: Ints) -> NodeNumbers:
        """These nodes with one more between each two `ends` (k, 2)."""
        return replace(self, middles=(*self.middles, ends))

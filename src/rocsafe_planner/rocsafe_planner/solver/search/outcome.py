# SPDX-License-Identifier: Apache-2.0
"""Options, progress and result of a search."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_planner.solver.bounds.certificate import Bound
from rocsafe_planner.solver.model.problem import Routes


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Length, seed and number of lanes of a search.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    budget_s: float = 10.0
    """Time after which the search ends; ignored when `proposals` is set."""
    proposals: int | None = None
    """Proposals a lane in all: the same plan on every machine, however fast.

    One that ruins and recreates counts for as many others as it takes the time of."""
    lanes: int = 2
    """Independent searches that exchange their best plans after each round."""
    threads: int = 2
    """How many lanes run at once; changes nothing but the time when `proposals` is set."""
    seed: int = 0
    close_enough: float = 0.0
    """Proven relative gap at which the search ends early."""
    bound_share: float = 0.15
    """Part of the elapsed time that one thread spends on the bound; 0: no bound."""
    clock: Callable[[], float] = time.monotonic
    """What lanes measure the budget with."""

    def __post_init__(self) -> None:
        """Refuse numbers out of range."""
        for name, least in (('budget_s', 0), ('lanes', 1), ('threads', 1), ('bound_share', 0)):
            if not getattr(self, name) >= least:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be at least {least}')
        if self.proposals is not None and self.proposals < 1:
            raise ValueError(f'proposals is {self.proposals}: it must be at least 1')


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a search."""

    value: float
    bound: Bound
    elapsed_s: float

    @property
    def gap(self) -> float:
        """Return the greatest relative excess over the optimum; infinite if unknown."""
        return self.value / self.bound.value - 1 if self.bound.value > 0 else np.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Routes, their costs, and a lower bound of the cost of all others."""

    routes: Routes
    """Customers of each vehicle in order."""
    costs: tuple[float, ...]
    loads: tuple[float, ...]
    """What each route consumes of its vehicle's limit."""
    value: float
    """The objective: greatest or summed cost."""
    feasible: bool
    """Whether all limits are kept."""
    bound: Bound
    elapsed_s: float
    proposals: int

    @property
    def gap(self) -> float:
        """Return the greatest relative excess over the optimum; infinite if unknown."""
        return self.value / self.bound.value - 1 if self.bound.value > 0 else np.inf

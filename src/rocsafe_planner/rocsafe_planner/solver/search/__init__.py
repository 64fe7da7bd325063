# SPDX-License-Identifier: Apache-2.0
"""The search for short routes: moves, annealing, crossover, schedule."""

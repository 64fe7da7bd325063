# SPDX-License-Identifier: Apache-2.0
"""Errors of scenarios."""


class ScenarioError(Exception):
    """A scenario or a file that it names is not valid; one line for each mistake."""

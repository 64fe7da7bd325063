# SPDX-License-Identifier: Apache-2.0
"""What can be wrong with a scenario."""


class ScenarioError(Exception):
    """A scenario, or a file that it names, cannot be flown as written; a line for each fault."""

# SPDX-License-Identifier: Apache-2.0
"""Fixtures: a small scenario, changed."""

from test.small_scenario import scenario_text, small  # noqa: F401 - fixtures

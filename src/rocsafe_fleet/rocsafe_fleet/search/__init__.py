# SPDX-License-Identifier: Apache-2.0
"""Rounds of measuring after the survey, which the agents decide."""

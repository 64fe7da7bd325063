# SPDX-License-Identifier: Apache-2.0
"""Contents of sections of a report: sources, cordons, gas, agent, drive, people."""

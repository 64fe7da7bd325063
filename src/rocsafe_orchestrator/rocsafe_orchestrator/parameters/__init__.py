# SPDX-License-Identifier: Apache-2.0
"""Parameters of the nodes of a run, from its scenario and the settings of its user."""

# SPDX-License-Identifier: Apache-2.0
"""Processes, mission phases, recording and report of ROCSAFE."""

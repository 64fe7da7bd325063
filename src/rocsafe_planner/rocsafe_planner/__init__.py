# SPDX-License-Identifier: Apache-2.0
"""Survey planning for ROCSAFE: coverage, assignment, routing, bounds."""

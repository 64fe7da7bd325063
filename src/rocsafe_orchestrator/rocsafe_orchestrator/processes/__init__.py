# SPDX-License-Identifier: Apache-2.0
"""The processes of a run: the table of them, their parameters, and keeping them running."""

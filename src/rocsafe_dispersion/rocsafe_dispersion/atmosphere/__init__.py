# SPDX-License-Identifier: Apache-2.0
"""Stability of the air and what follows from it."""

# SPDX-License-Identifier: Apache-2.0
"""Scenario files: what they may say, what they say together, and reading them."""

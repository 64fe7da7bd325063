# SPDX-License-Identifier: Apache-2.0
"""The scenario: its schema, checks and defaults."""

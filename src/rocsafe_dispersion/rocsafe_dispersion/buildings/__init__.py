# SPDX-License-Identifier: Apache-2.0
"""Wind around buildings and terrain."""

# SPDX-License-Identifier: Apache-2.0
"""Sources from readings by maximum likelihood."""

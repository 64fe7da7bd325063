# SPDX-License-Identifier: Apache-2.0
"""Where to photograph from, and what is seen from there."""

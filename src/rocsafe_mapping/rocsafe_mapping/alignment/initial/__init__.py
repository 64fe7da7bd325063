# SPDX-License-Identifier: Apache-2.0
"""Steps 5 and 6: the graph of pairs, and first poses from it."""

# SPDX-License-Identifier: Apache-2.0
"""Steps 1 to 4: features, neighbours, matches of pairs, refined ties."""

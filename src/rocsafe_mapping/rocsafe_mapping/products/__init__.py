# SPDX-License-Identifier: Apache-2.0
"""Files that a map is handed over as."""

# SPDX-License-Identifier: Apache-2.0
"""The routing problem as arrays, and the compiled basis of the solver."""

# SPDX-License-Identifier: Apache-2.0
"""Orders of an operator, in two steps."""

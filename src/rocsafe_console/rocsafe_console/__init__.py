# SPDX-License-Identifier: Apache-2.0
"""Page of the operator: see, decide, answer for it."""

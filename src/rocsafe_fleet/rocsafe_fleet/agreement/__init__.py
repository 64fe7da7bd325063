# SPDX-License-Identifier: Apache-2.0
"""Agreement on a plan, and the agent that keeps to it."""

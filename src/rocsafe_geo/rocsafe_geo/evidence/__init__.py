# SPDX-License-Identifier: Apache-2.0
"""What a run keeps as evidence: photographs with their pose, and the log of events."""

# SPDX-License-Identifier: Apache-2.0
"""What happened, kept so that a change is found: log, seal, verification."""

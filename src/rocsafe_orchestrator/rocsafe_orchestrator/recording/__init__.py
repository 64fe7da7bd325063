# SPDX-License-Identifier: Apache-2.0
"""The recording of a run: segments while it flies, one indexed file at its end."""

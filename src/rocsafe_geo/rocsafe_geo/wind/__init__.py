# SPDX-License-Identifier: Apache-2.0
"""The wind: mean, profile, gusts and records, for whatever it pushes or carries."""

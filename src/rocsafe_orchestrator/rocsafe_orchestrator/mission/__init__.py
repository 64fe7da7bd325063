# SPDX-License-Identifier: Apache-2.0
"""The phases of a mission, and what is known of it while it runs."""

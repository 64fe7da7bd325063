# SPDX-License-Identifier: Apache-2.0
"""What a sensor reads of a source: readings drawn, and their likelihood."""

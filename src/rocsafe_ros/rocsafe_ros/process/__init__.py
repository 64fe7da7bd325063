# SPDX-License-Identifier: Apache-2.0
"""The process of a node: its command line, start, end and health."""

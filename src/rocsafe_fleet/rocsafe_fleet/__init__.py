# SPDX-License-Identifier: Apache-2.0
"""Agents of a fleet that agree without a head: ledger, membership, agreement."""

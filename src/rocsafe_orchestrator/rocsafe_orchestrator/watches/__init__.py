# SPDX-License-Identifier: Apache-2.0
"""Watches beside a mission: decisions, the operator, doses of people, returns of least dose."""

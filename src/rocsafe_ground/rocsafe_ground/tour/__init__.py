# SPDX-License-Identifier: Apache-2.0
"""The order of evidence points and the ways between them, within budgets."""

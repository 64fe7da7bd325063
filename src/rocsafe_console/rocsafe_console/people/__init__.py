# SPDX-License-Identifier: Apache-2.0
"""Who may do what: users, roles, passwords and sessions."""

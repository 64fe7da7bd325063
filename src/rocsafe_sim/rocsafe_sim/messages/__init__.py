# SPDX-License-Identifier: Apache-2.0
"""Messages from and to the values of this package."""

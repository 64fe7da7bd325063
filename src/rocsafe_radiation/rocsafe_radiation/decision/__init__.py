# SPDX-License-Identifier: Apache-2.0
"""When it is enough, and where to measure next."""

# SPDX-License-Identifier: Apache-2.0
"""Commands that plan or check and start no mission."""

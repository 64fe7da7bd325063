# SPDX-License-Identifier: Apache-2.0
"""The files of a data set: pictures with their records, summary and data card."""

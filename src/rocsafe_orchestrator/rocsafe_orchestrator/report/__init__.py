# SPDX-License-Identifier: Apache-2.0
"""The report of a run, ``report.html``."""

from rocsafe_orchestrator.report.page import report_page

__all__ = ['report_page']

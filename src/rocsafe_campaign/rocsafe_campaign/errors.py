# SPDX-License-Identifier: Apache-2.0
"""Errors of campaigns."""


class CampaignError(Exception):
    """A campaign cannot be carried out; its text is one line for each thing that is wrong."""


class NotPureError(CampaignError):
    """A scenario needs what only whole processes have."""


class MachineError(CampaignError):
    """The machine cannot carry out runs now: that is no result of a run, and ends the campaign."""

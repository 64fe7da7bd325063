# SPDX-License-Identifier: Apache-2.0
"""Places at which evidence is taken: what they are, from files, and from what a survey found."""

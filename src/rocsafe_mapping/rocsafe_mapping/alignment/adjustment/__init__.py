# SPDX-License-Identifier: Apache-2.0
"""Steps 7 to 9: least squares over ties and priors, ground heights, clock lags."""

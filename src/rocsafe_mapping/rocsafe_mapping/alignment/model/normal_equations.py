# SPDX-License-Identifier: Apache-2.0
"""Normal equations solved."""

from typing import Any

from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu


def factored(normal: csr_matrix) -> Any:
    """Return the factors of a symmetric positive definite matrix, which `solve` with them.

    Such a matrix needs no pivoting. Telling SuperLU so makes it four times as fast: it keeps the
    order that makes the factors sparse.
    """
    return splu(
        normal.tocsc(),
        permc_spec='MMD_AT_PLUS_A',
        diag_pivot_thresh=0.0,
        options={'SymmetricMode': True},
    )

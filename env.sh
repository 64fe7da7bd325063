# SPDX-License-Identifier: Apache-2.0
# `source env.sh` gives this shell (bash or zsh) the built workspace: `rocsafe`, `ros2`, Python.
# A POSIX shell does not tell a sourced file its name: from those, source it in its own folder.
_rocsafe_root=${BASH_SOURCE:-}
if [ -n "${ZSH_VERSION-}" ]; then
    _rocsafe_root=${(%):-%x}
fi
_rocsafe_root=$(CDPATH='' cd -- "$(dirname -- "${_rocsafe_root:-./env.sh}")" && pwd -P)
if [ -r "$_rocsafe_root/.venv/workspace.sh" ]; then
    . "$_rocsafe_root/.venv/workspace.sh"
    # Threads of the linear algebra wait for each other in loops: five times as long on busy cores.
    export OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"
    unset _rocsafe_root
else
    echo "env.sh: nothing is built in $_rocsafe_root yet: run make setup there" >&2
    unset _rocsafe_root
    return 1
fi

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Finds a Python that starts and is new enough, and hands over to tools/prepare.py.
# PYTHON=<command> chooses another one than the first that fits.
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd -P) || exit 1

starts() {
    # A shim of a version manager may exist and not start: only running it tells.
    "$1" -E -s -S -B -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 12))' \
        </dev/null >/dev/null 2>&1
}

for python in ${PYTHON:-"$root/.venv/bin/python" python3 python3.12 python3.11 python3.10 /usr/bin/python3}; do
    if starts "$python"; then
        exec "$python" -E -s -S -B "$root/tools/prepare.py" "$@"
    fi
done

if [ -n "${PYTHON-}" ]; then
    echo "setup: PYTHON=$PYTHON is not a Python 3.10, 3.11 or 3.12 that starts" >&2
else
    echo "setup: no Python 3.10, 3.11 or 3.12 on the PATH; on Debian or Ubuntu: sudo apt install python3 python3-venv python3-dev" >&2
fi
exit 1

#!/usr/bin/env bash
# Proves the closed forms of docs/filter.md in letters. Needs python3-sympy.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

# Debian's Python: another that comes first in the path need not have sympy.
/usr/bin/python3 "$root/docs/filter_proofs.py"

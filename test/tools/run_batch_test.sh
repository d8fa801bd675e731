#!/usr/bin/env bash
# batch_test.sh with a result file as catkin reads it:  run_batch_test.sh BIN_DIR SOURCE_DIR RESULT
set -uo pipefail
mkdir -p "$(dirname "$3")"
failures=0 failure=''
if ! bash "$(dirname "${BASH_SOURCE[0]}")/batch_test.sh" "$1" "$2"; then
  failures=1 failure='<failure message="see the output"/>'
fi
cat >"$3" <<END
<testsuite name="batch" tests="1" failures="$failures" errors="0"><testcase classname="batch" name="batch">$failure</testcase></testsuite>
END
exit "$failures"
